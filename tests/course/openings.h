/** @file
 * Switches in the solutions, which courseTest.py inserts.
 */
#pragma once

#include <bitset>

/** Gaps that are open, and wrong fillings, by the numbers that courseTest.py gives them. */
inline std::bitset<1000> openings;
