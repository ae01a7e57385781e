/** @file
 * Instruction sets that the program was compiled for.
 */
#pragma once

namespace recurse::apps {

/** Instruction sets beyond x86-64 that the compiler was allowed to use. */
struct ProcessorNeeds {
  bool avx2, fma, bmi2, avx512;
};
extern const ProcessorNeeds PROCESSOR_NEEDS;

} // namespace recurse::apps
