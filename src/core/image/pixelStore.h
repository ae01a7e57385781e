/** @file
 * Storage of texture pixels.
 */
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace recurse::detail {

/**
 * Immutable bytes, in memory, or in a nameless temporary file where all stores together would exceed the
 * limit. The system keeps such a file in memory while there is room.
 */
class PixelStore {
 public:
  PixelStore() = default;
  explicit PixelStore(std::vector<std::byte> bytes);
  ~PixelStore();
  PixelStore(PixelStore&& o) noexcept { swap(o); }
  PixelStore& operator=(PixelStore&& o) noexcept {
    swap(o);
    return *this;
  }
  const std::byte* data() const { return mapped ? static_cast<const std::byte*>(mapped) : own.data(); }
  size_t size() const { return mapped ? mappedSize : own.size(); }
  /** Lets the system drop bytes of a file from memory until their next use. */
  void rest() const;

  /** Sets the limit for all stores in memory [bytes]; infinite at first. */
  static void setLimit(double bytes);
  /** Size of all stores now: in memory, and in files [bytes]. */
  static std::pair<size_t, size_t> totals();

 private:
  void swap(PixelStore& o) noexcept {
    std::swap(own, o.own);
    std::swap(mapped, o.mapped);
    std::swap(mappedSize, o.mappedSize);
  }
  std::vector<std::byte> own;
  void* mapped = nullptr;
  size_t mappedSize = 0;
};

} // namespace recurse::detail
