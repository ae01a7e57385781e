/** @file
 * As the compiler's options have it; no code, which might need what is not there.
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
