/** @file
 * libFuzzer target: NanoVDB files. After an even first byte the remaining bytes are a file; after an odd one
 * they are changes of a good file. Nothing may crash, hang, or throw anything but Error, and values must be
 * within the stated bounds.
 */
#include <cstdint>
#include <cstdlib>

#include "fuzz/nanoVdbFuzzing.h"
#include "media/nanovdb/nanoVdbFile.h"
#include "recurse/core/io/error.h"
#include "recurse/core/threads/resources.h"

namespace {

using namespace recurse;

void read(std::string_view bytes) {
  std::vector<std::string> others;
  const NanoVdbGrid grid = readNanoVdb("grid", bytes, "density", others);
  if (grid.values.empty()) return;
  const SparseGrid& v = grid.values;
  const float low = v.smallest(), high = v.largest();
  for (int corner = 0; corner < 8; ++corner) {
    glm::ivec3 at;
    Vec3d point;
    for (int axis = 0; axis < 3; ++axis) {
      at[axis] = corner >> axis & 1 ? v.last()[axis] : v.first()[axis];
      point[axis] = double(v.first()[axis]) +
                    (double(v.last()[axis]) - double(v.first()[axis])) * (corner >> axis & 1 ? .7 : .1);
    }
    if (!(v.value(at) >= low && v.value(at) <= high)) std::abort();
    if (!(v.at(point) >= std::min(low, 0.0f) && v.at(point) <= std::max(high, 0.0f))) std::abort();
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  // A file may claim a box as large as memory, which is smaller for a fuzzer.
  static const bool LIMITED = (setMemoryLimit(1.5e9), true);
  (void)LIMITED;
  try {
    if (data[0] % 2 == 0)
      read({reinterpret_cast<const char*>(data + 1), size - 1});
    else
      read(changedNanoVdb(data + 1, size - 1));
  } catch (const Error&) {
    // expected result
  }
  return 0;
}
