/** @file
 * 128-bit integers that threads add to.
 */
#pragma once

#include <atomic>
#include <cstdint>

namespace recurse {

__extension__ using Int128 = __int128;

/** Sum of 128-bit integers. Threads may add in any order; it may be read once all have added. */
class WideSum {
 public:
  WideSum() = default;
  explicit WideSum(Int128 value)
      : low(static_cast<uint64_t>(value)), high(static_cast<int64_t>(value >> 64)) {}

  /** Adds from any thread. Returns false where the sum overflows; it wraps around then. */
  bool addAtomically(const WideSum& other) {
    const uint64_t before = std::atomic_ref(low).fetch_add(other.low, std::memory_order_relaxed);
    const int64_t carry = before + other.low < before;
    int64_t more = 0, after = 0;
    const bool overflows = __builtin_add_overflow(other.high, carry, &more);
    if (more == 0) return true;
    const int64_t highBefore = std::atomic_ref(high).fetch_add(more, std::memory_order_relaxed);
    return !__builtin_add_overflow(highBefore, more, &after) && !overflows;
  }
  /** The nearest double. */
  explicit operator double() const {
    return static_cast<double>(static_cast<Int128>(high) << 64 | static_cast<Int128>(low));
  }

 private:
  uint64_t low = 0;
  int64_t high = 0;
};

} // namespace recurse
