/** @file
 * Results of functions constructed in their destination. Copying a structure right after it was written
 * member by member stalls the processor, since its wider reads cannot be served from the pending writes.
 */
#pragma once

#include <memory>
#include <type_traits>

namespace recurse {

/** Replaces `place` by the result of `make`, which must not read `place`, without a copy. */
template <class T, class Make> void makeAt(T& place, const Make& make) {
  static_assert(std::is_trivially_destructible_v<T>);
  static_assert(std::is_same_v<std::invoke_result_t<Make>, T>);
  ::new (static_cast<void*>(std::addressof(place))) T(make());
}

/** Argument for std::optional::emplace() that converts to the result of `make`, without a copy. Must not
 * outlive `make`. */
template <class Make> class Made {
 public:
  explicit Made(const Make& make) : make(make) {}
  operator std::invoke_result_t<Make>() const { return make(); }

 private:
  const Make& make;
};

} // namespace recurse
