/** @file
 * Values at the points of a grid that is empty for the most part: in blocks of 8³, or one value for a block.
 */
#pragma once

#include <span>
#include <vector>

#include "recurse/core/math/vector.h"
#include "recurse/model/medium/medium.h"

namespace recurse {

class SparseGrid {
 public:
  static constexpr int WIDTH = 8;                                ///< of a block
  static constexpr size_t BLOCK = size_t(WIDTH) * WIDTH * WIDTH; ///< values of a block, z fastest

  SparseGrid() = default;
  /** Has values from `first` to `last`; all are `background` at first. Throws Error, which begins with
   * `name`, where there is no memory for that or for a block. */
  SparseGrid(std::string name, const glm::ivec3& first, const glm::ivec3& last, float background);

  /** Of the block that begins at `origin`, whose coordinates are multiples of WIDTH. Blocks out of the range
   * are left out. */
  void setBlock(const glm::ivec3& origin, std::span<const float> values);
  /** The same value in all blocks from `origin`, as far as `width`, a multiple of WIDTH. */
  void fill(const glm::ivec3& origin, int64_t width, float value);

  bool empty() const { return table.empty(); }
  const glm::ivec3& first() const { return lowest; }
  const glm::ivec3& last() const { return highest; }
  /** 0 out of the range. */
  float value(const glm::ivec3& i) const;
  /** Interpolated, at a point in coordinates of the grid; within `first` and `last` + 1 alone. */
  float at(const Vec3d& point) const;
  float smallest() const;
  float largest() const;
  /** Bounds of at() over the box from `first` to `last` + 1. */
  MajorantGrid majorants() const;

 private:
  static constexpr uint32_t SINGLE = 1u << 31; ///< the table's entry is the index of one value for the block

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
