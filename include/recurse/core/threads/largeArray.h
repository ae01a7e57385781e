/** @file
 * Large arrays on huge pages.
 */
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace recurse {

/** Uninitialised storage for trivially copyable objects, kept for reuse; large arrays use huge pages. */
template <class T> class LargeArray {
 public:
  LargeArray() = default;
  LargeArray(LargeArray&& o) noexcept : room(std::move(o.room)), allocated(std::exchange(o.allocated, 0)) {}
  LargeArray& operator=(LargeArray&& o) noexcept {
    room = std::move(o.room);
    allocated = std::exchange(o.allocated, 0);
    return *this;
  }
  T* data() const { return room.get(); }
  T& operator[](size_t i) const { return room.get()[i]; }
  size_t bytes() const { return allocated * sizeof(T); }
  /** Number of objects that there is room for. */
  size_t capacity() const { return allocated; }
  /** Makes room for n objects or more. Growth keeps the content only with `keep`. Throws std::bad_alloc; the
   * content is then unchanged with `keep`, and may be lost without. */
  void reserve(size_t n, bool keep = false);

 private:
  struct Release {
    void operator()(void* p) const { std::free(p); }
  };
  std::unique_ptr<T, Release> room;
  size_t allocated = 0; ///< [objects]
};
/** Allocates memory on a 64-byte boundary, on huge pages from 2 MiB on; std::free() releases it. Rounds
 * `bytes` up. Throws std::bad_alloc. */
void* allocateLarge(size_t& bytes);

template <class T> void LargeArray<T>::reserve(size_t n, bool keep) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (n <= allocated) return;
  // With at most half of all addresses, the number of bytes does not overflow when it is rounded up.
  if (n > std::numeric_limits<size_t>::max() / 2 / sizeof(T)) throw std::bad_alloc();
  // Second and later requests get 1/16 more: they are likely to be followed by a slightly larger one.
  size_t bytes = (allocated == 0 ? n : n + n / 16) * sizeof(T);
  if (!keep) *this = LargeArray();
  LargeArray grown;
  grown.room.reset(static_cast<T*>(allocateLarge(bytes)));
  grown.allocated = bytes / sizeof(T);
  if (keep) std::copy_n(data(), allocated, grown.data());
  *this = std::move(grown);
}

} // namespace recurse
