/** @file
 * Entry point of the program `recurse`.
 */
#include "apps/program.h"

int main(int argc, char** argv) { return recurse::apps::program(argc, argv); }
