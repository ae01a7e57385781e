/** @file
 * Where pixels of textures lie.
 */
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace recurse::detail {

/**
 * Bytes that do not change: in memory, or, where all of them together would take more than the limit, in a
 * file without a name, which the system keeps in memory as far as there is room.
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
  /** Those in a file need not be in memory for now. */
  void rest() const;

  /** Of all in memory [bytes]; infinite at first. */
  static void setLimit(double bytes);
  /** That all of them together have now, in memory and in files [bytes]. */
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
