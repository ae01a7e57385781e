/** @file
 * Edges that belong to one piece only.
 */
#pragma once

#include <algorithm>
#include <vector>

namespace recurse {

/** Removes all items whose key occurs more than once; sorts the remaining ones by ascending key. */
template <class T, class Key> void keepSingles(std::vector<T>& items, const Key& key) {
  std::sort(items.begin(), items.end(), [&](const T& a, const T& b) { return key(a) < key(b); });
  size_t kept = 0;
  for (size_t first = 0, end = 0; first < items.size(); first = end) {
    while (end < items.size() && key(items[end]) == key(items[first])) ++end;
    if (end - first == 1) items[kept++] = items[first];
  }
  items.erase(items.begin() + static_cast<std::ptrdiff_t>(kept), items.end());
}

} // namespace recurse
