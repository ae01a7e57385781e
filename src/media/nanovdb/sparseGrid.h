/** @file
 * Sparse grid of values in blocks of 8³; uniform blocks are stored as one value.
 */
#pragma once

#include <span>
#include <vector>

#include "recurse/core/math/vector.h"
#include "recurse/model/medium/medium.h"

namespace recurse {

class SparseGrid {
 public:
  static constexpr int WIDTH = 8;                                ///< side of a block
  static constexpr size_t BLOCK = size_t(WIDTH) * WIDTH * WIDTH; ///< values of a block, z fastest

  SparseGrid() = default;
  /** Grid with values from `first` to `last`, all initially `background`. Throws Error, which begins with
   * `name`, where there is no memory for the grid; setBlock() does for a block. */
  SparseGrid(std::string name, const glm::ivec3& first, const glm::ivec3& last, float background);

  /** Sets the block that begins at `origin`, whose coordinates are multiples of WIDTH. Blocks out of range
   * are ignored. */
  void setBlock(const glm::ivec3& origin, std::span<const float> values);
  /** Sets one value in all blocks of the cube at `origin` of side `width`, a multiple of WIDTH. */
  void fill(const glm::ivec3& origin, int64_t width, float value);

  bool empty() const { return table.empty(); }
  const glm::ivec3& first() const { return lowest; }
  const glm::ivec3& last() const { return highest; }
  /** Value at index i; 0 out of range. */
  float value(const glm::ivec3& i) const;
  /** Interpolated value at a point in index coordinates; 0 outside of `first` to `last` + 1. */
  float at(const Vec3d& point) const;
  float smallest() const;
  float largest() const;
  /** Bounds of at() over the box from `first` to `last` + 1. */
  MajorantGrid majorants() const;

 private:
  static constexpr uint32_t SINGLE = 1u << 31; ///< marks an entry as the index of one value for the block

  uint32_t entry(const glm::ivec3& block) const {
    return table[(size_t(block.x) * size_t(blocks.y) + size_t(block.y)) * size_t(blocks.z) + size_t(block.z)];
  }
  uint32_t& entry(const glm::ivec3& block) {
    return table[(size_t(block.x) * size_t(blocks.y) + size_t(block.y)) * size_t(blocks.z) + size_t(block.z)];
  }
  std::span<const float> valuesOf(uint32_t entry) const {
    return entry & SINGLE ? std::span(&singles[entry & ~SINGLE], 1)
                          : std::span(&values[size_t(entry) * BLOCK], BLOCK);
  }

  std::string name;
  glm::ivec3 lowest{0}, highest{-1};
  glm::ivec3 firstBlock{0}, blocks{0};
  std::vector<uint32_t> table;
  std::vector<float> values, singles;
};

} // namespace recurse
