/** @file
 * Allocation on huge pages.
 */
#include "recurse/core/threads/largeArray.h"

#include <new>

#include <sys/mman.h>

namespace recurse {

void* allocateLarge(size_t& bytes) {
  constexpr size_t LINE = 64, HUGE_PAGE = size_t(1) << 21;
  const size_t alignment = bytes >= HUGE_PAGE ? HUGE_PAGE : LINE;
  const size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  // Rounding up to whole huge pages pays only where it wastes little of the last one.
  const bool huge = alignment == HUGE_PAGE && rounded - bytes <= bytes / 64;
  bytes = huge ? rounded : (bytes + LINE - 1) / LINE * LINE;
  void* p = nullptr;
  if (posix_memalign(&p, alignment, std::max(bytes, LINE)) != 0) throw std::bad_alloc();
  if (alignment == HUGE_PAGE) madvise(p, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
  return p;
}

} // namespace recurse
