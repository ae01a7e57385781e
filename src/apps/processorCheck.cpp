/** @file
 * Check at the start of the program: one clear line if the processor lacks instruction sets of the build.
 * This file is compiled for any x86-64 processor.
 */
#include <unistd.h>

#include "apps/processorNeeds.h"

namespace recurse::apps {

namespace {

template <unsigned long SIZE> void say(const char (&text)[SIZE]) {
  const long written = ::write(STDERR_FILENO, text, SIZE - 1);
  static_cast<void>(written);
}

#ifdef __x86_64__
/** Runs before all other initialization of the program. */
__attribute__((constructor(101))) void checkProcessor() {
  __builtin_cpu_init();
  const ProcessorNeeds& needs = PROCESSOR_NEEDS;
  const bool lacks =
      (needs.avx2 && !__builtin_cpu_supports("avx2")) || (needs.fma && !__builtin_cpu_supports("fma")) ||
      (needs.bmi2 && !__builtin_cpu_supports("bmi2")) || (needs.avx512 && !__builtin_cpu_supports("avx512f"));
  if (!lacks) return;
  if (needs.avx512)
    say("recurse: was built for a processor with AVX-512, which this processor lacks; build it on this "
        "machine, or for any processor (cmake --preset portable)\n");
  else
    say("recurse: needs a processor with AVX2, FMA and BMI2 (x86-64-v3: Intel since 2013, AMD since 2015), "
        "which this processor lacks\n");
  ::_exit(1);
}
#endif

} // namespace

} // namespace recurse::apps
