/** @file
 * libFuzzer target: NanoVDB files. An even first byte: the others are a file. An odd one: they say what to
 * change in a good file, which is too large to be found by chance. Nothing may crash, hang, or throw anything
 * but Error, and what is read stays within the bounds that it says.
 */
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "model/nanoVdb.h"
#include "model/nanoVdbTesting.h"
#include "recurse/core/error.h"
#include "recurse/core/memory.h"

namespace {

using namespace recurse;

const std::string& goodFile() {
  static const std::string FILE = [] {
    testing::WrittenGrid g;
    g(1, 2, 3) = 4;
    g(130, -5, 9) = 2;
    return testing::NanoVdbWriter::file({g});
  }();
  return FILE;
}

/** Bytes of the good file that say something: all but the tables of inner nodes, which are nearly empty. */
const std::vector<size_t>& places() {
  static const std::vector<size_t> PLACES = [] {
    std::vector<size_t> list;
    for (size_t i = 0; i < goodFile().size(); ++i)
      if (i < 1200 || goodFile()[i] != 0) list.push_back(i);
    return list;
  }();
  return PLACES;
}

std::string changed(const uint8_t* data, size_t size) {
  std::string bytes = goodFile();
  struct Change {
    uint16_t place;
    uint8_t width;
    uint64_t value;
  };
  for (; size >= 12; data += 12, size -= 12) {
    Change c;
    std::memcpy(&c.place, data, 2);
    std::memcpy(&c.width, data + 2, 1);
    std::memcpy(&c.value, data + 4, 8);
    const size_t at = places()[c.place % places().size()], width = size_t(1) << c.width % 4;
    if (at + width <= bytes.size()) std::memcpy(&bytes[at], &c.value, width);
  }
  if (size >= 3) bytes.resize(bytes.size() * data[0] / 255);
  return bytes;
}

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
  // A file may claim a box as large as memory, which is less for a fuzzer.
  static const bool LIMITED = (setMemoryLimit(1.5e9), true);
  (void)LIMITED;
  try {
    if (data[0] % 2 == 0)
      read({reinterpret_cast<const char*>(data + 1), size - 1});
    else
      read(changed(data + 1, size - 1));
  } catch (const Error&) {
    // promised
  }
  return 0;
}
