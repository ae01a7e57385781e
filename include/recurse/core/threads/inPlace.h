/** @file
 * Results of functions made where they are to stay. A structure that was written a number at a time and is
 * copied at once makes the processor wait until every write has reached the cache: about five nanoseconds,
 * which inner loops notice.
 */
#pragma once

#include <memory>
#include <type_traits>

namespace recurse {

/** Replaces `place` by what `make` returns, without a copy. */
template <class T, class Make> void makeAt(T& place, const Make& make) {
  static_assert(std::is_trivially_destructible_v<T>);
  static_assert(std::is_same_v<std::invoke_result_t<Make>, T>);
  ::new (static_cast<void*>(std::addressof(place))) T(make());
}

/** An argument for emplace() that becomes what `make` returns, without a copy. */
template <class Make> class Made {
 public:
  explicit Made(const Make& make) : make(make) {}
  operator std::invoke_result_t<Make>() const { return make(); }

 private:
  const Make& make;
};

} // namespace recurse
