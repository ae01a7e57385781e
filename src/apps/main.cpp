/** @file
 * Where the program `recurse` begins.
 */
#include "apps/program.h"

int main(int argc, char** argv) { return recurse::apps::program(argc, argv); }
