/** @file
 * The program as a function, for `main` and for the tests.
 */
#pragma once

namespace recurse::apps {

/** Runs the program: once per process, and before it has threads. Returns the exit status. */
int program(int argc, char** argv);

} // namespace recurse::apps
