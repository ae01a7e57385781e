/** @file
 * Sparse grids: blocks, interpolation and bounds.
 */
#include "media/nanovdb/sparseGrid.h"

#include <algorithm>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/resources.h"

namespace recurse {

SparseGrid::SparseGrid(std::string name, const glm::ivec3& first, const glm::ivec3& last, float background)
    : name(std::move(name)), lowest(first), highest(last), firstBlock(first >> 3),
      blocks((last >> 3) - (first >> 3) + 1) {
  static_assert(WIDTH == 1 << 3);
  const double count = double(blocks.x) * double(blocks.y) * double(blocks.z);
  requireMemory(this->name + ": a grid of " + std::to_string(blocks.x) + " x " + std::to_string(blocks.y) +
                    " x " + std::to_string(blocks.z) + " blocks",
                count * sizeof(uint32_t));
  singles.push_back(background);
  table.assign(size_t(blocks.x) * size_t(blocks.y) * size_t(blocks.z), SINGLE);
}

void SparseGrid::setBlock(const glm::ivec3& origin, std::span<const float> block) {
  const glm::ivec3 b = (origin >> 3) - firstBlock;
  for (int axis = 0; axis < 3; ++axis)
    if (b[axis] < 0 || b[axis] >= blocks[axis]) return;
  const size_t index = values.size() / BLOCK;
  if (index >= SINGLE) throw Error(name + ": a grid with more than 2^31 blocks");
  if (values.size() == values.capacity()) // the copy will be twice as large
    requireMemory(name + ": the grid's values", 2.0 * double(values.size() + BLOCK) * sizeof(float));
  values.insert(values.end(), block.begin(), block.end());
  entry(b) = static_cast<uint32_t>(index);
}

void SparseGrid::fill(const glm::ivec3& origin, int64_t width, float value) {
  glm::ivec3 from, to;
  for (int axis = 0; axis < 3; ++axis) {
    const int64_t begin = (origin[axis] >> 3) - int64_t(firstBlock[axis]);
    from[axis] = static_cast<int>(std::clamp<int64_t>(begin, 0, blocks[axis]));
    to[axis] = static_cast<int>(std::clamp<int64_t>(begin + width / WIDTH, 0, blocks[axis]));
  }
  if (from.x >= to.x || from.y >= to.y || from.z >= to.z) return;
  if (value == singles[0]) return; // already the background
  if (singles.back() != value) singles.push_back(value);
  const auto index = static_cast<uint32_t>(singles.size() - 1) | SINGLE;
  for (int x = from.x; x < to.x; ++x)
    for (int y = from.y; y < to.y; ++y)
      for (int z = from.z; z < to.z; ++z) entry({x, y, z}) = index;
}

float SparseGrid::value(const glm::ivec3& i) const {
  for (int axis = 0; axis < 3; ++axis)
    if (i[axis] < lowest[axis] || i[axis] > highest[axis]) return 0;
  const std::span<const float> block = valuesOf(entry((i >> 3) - firstBlock));
  const glm::ivec3 in = i & (WIDTH - 1);
  return block.size() == 1 ? block[0] : block[size_t((in.x * WIDTH + in.y) * WIDTH + in.z)];
}

float SparseGrid::at(const Vec3d& point) const {
  // The test is false for NaN as well, so that the coordinates fit an integer.
  for (int axis = 0; axis < 3; ++axis)
    if (!(point[axis] >= lowest[axis] && point[axis] <= highest[axis] + 1.0)) return 0;
  const Vec3d floor = glm::floor(point);
  const Vec3f part(point - floor);
  const glm::ivec3 i(floor);
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 d(corner & 1, corner >> 1 & 1, corner >> 2);
    const float weight =
        (d.x ? part.x : 1 - part.x) * (d.y ? part.y : 1 - part.y) * (d.z ? part.z : 1 - part.z);
    if (weight > 0) sum += value(i + d) * weight;
  }
  return sum;
}

float SparseGrid::smallest() const {
  float least = *std::min_element(singles.begin(), singles.end());
  return values.empty() ? least : std::min(least, *std::min_element(values.begin(), values.end()));
}

float SparseGrid::largest() const {
  float most = *std::max_element(singles.begin(), singles.end());
  return values.empty() ? most : std::max(most, *std::max_element(values.begin(), values.end()));
}

MajorantGrid SparseGrid::majorants() const {
  constexpr int MAX_CELLS = 64; // cells along an axis; with more, traversal costs about as much as it saves
  const glm::ivec3 size = highest - lowest + 1;
  const glm::ivec3 cells = glm::min(size, glm::ivec3(MAX_CELLS));
  std::vector<float> bounds(size_t(cells.x) * size_t(cells.y) * size_t(cells.z), 0);
  for (int bx = 0; bx < blocks.x; ++bx)
    for (int by = 0; by < blocks.y; ++by)
      for (int bz = 0; bz < blocks.z; ++bz) {
        const std::span<const float> block = valuesOf(entry({bx, by, bz}));
        const float most = *std::max_element(block.begin(), block.end());
        if (!(most > 0)) continue;
        // Interpolation reaches one sample further to either side, and rounding one more.
        const glm::ivec3 at = (glm::ivec3(bx, by, bz) + firstBlock) * WIDTH - lowest;
        glm::ivec3 from, to;
        for (int axis = 0; axis < 3; ++axis) {
          const auto cellOf = [&](int i) {
            return static_cast<int>(
                std::clamp<int64_t>(int64_t(i) * cells[axis] / size[axis], 0, cells[axis] - 1));
          };
          from[axis] = cellOf(at[axis] - 2);
          to[axis] = cellOf(at[axis] + WIDTH + 1);
        }
        for (int z = from.z; z <= to.z; ++z)
          for (int y = from.y; y <= to.y; ++y)
            for (int x = from.x; x <= to.x; ++x) {
              float& bound = bounds[(size_t(z) * size_t(cells.y) + size_t(y)) * size_t(cells.x) + size_t(x)];
              bound = std::max(bound, most);
            }
      }
  return {cells, std::move(bounds)};
}

} // namespace recurse
