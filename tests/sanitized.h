/** @file
 * Whether the tests run under sanitizers, which are ten times slower.
 */
#pragma once

#include <algorithm>

namespace recurse::testing {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RECURSE_SANITIZED true // g++
#elif defined(__has_feature)
#define RECURSE_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer)) // clang++
#else
#define RECURSE_SANITIZED false
#endif
constexpr bool SANITIZED = RECURSE_SANITIZED;
#undef RECURSE_SANITIZED

/** Number of samples: an eighth under sanitizers, which are ten times slower; bounds that depend on measured
 * errors allow for this. */
inline int samples(int n) { return SANITIZED ? std::max(1, n / 8) : n; }

} // namespace recurse::testing
