/** @file
 * How much memory there is, asked before much of it is taken: a process that takes too much is killed
 * without a word.
 */
#pragma once

#include <string>

namespace recurse {

/** The process is to take no more than this [bytes] in all. */
void setMemoryLimit(double bytes);

/** What the process can take without swapping [bytes]; infinite where the system does not say. */
double availableMemory();

/** Throws Error, which begins with `subject`, when that much memory is not available. */
void requireMemory(const std::string& subject, double bytes);

} // namespace recurse
