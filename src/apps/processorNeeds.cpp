/** @file
 * Instruction sets of the compiler's options, as data, because code might need a missing one.
 */
#include "apps/processorNeeds.h"

namespace recurse::apps {

const ProcessorNeeds PROCESSOR_NEEDS = {
#ifdef __AVX2__
    true,
#else
    false,
#endif
#ifdef __FMA__
    true,
#else
    false,
#endif
#ifdef __BMI2__
    true,
#else
    false,
#endif
#ifdef __AVX512F__
    true,
#else
    false,
#endif
};

} // namespace recurse::apps
