/** @file
 * Writes small NanoVDB files for tests byte by byte, and damaged ones.
 */
#pragma once

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <unistd.h>

#include "recurse/core/math/vector.h"

namespace recurse::testing {

/** A grid of floats in leaves of 8³ values. */
struct WrittenGrid {
  std::string name = "density";
  std::map<std::array<int, 3>, std::array<float, 512>> leaves; ///< leaves by their origin
  double voxel = 1;                                            ///< width of a voxel
  Vec3d origin{0};                                             ///< origin of the grid in the world

  float& operator()(int x, int y, int z) {
    std::array<float, 512>& leaf = leaves.try_emplace({x & ~7, y & ~7, z & ~7}).first->second;
    return leaf[size_t((x & 7) << 6 | (y & 7) << 3 | (z & 7))];
  }
};

class NanoVdbWriter {
 public:
  static constexpr size_t GRID = 672, ROOT = 64, TILE = 32, UPPER = 270400, LOWER = 33856, LEAF = 96 + 2048;

  /** A file of one segment. */
  static std::string file(const std::vector<WrittenGrid>& grids) {
    std::string bytes(16, '\0'), all;
    put(bytes, 0, MAGIC);
    put(bytes, 8, VERSION);
    put(bytes, 12, static_cast<uint16_t>(grids.size()));
    for (const WrittenGrid& g : grids) {
      const std::string one = grid(g);
      std::string entry(176, '\0');
      put(entry, 0, uint64_t(one.size()));
      put(entry, 8, uint64_t(one.size()));
      put(entry, 136, uint32_t(g.name.size() + 1));
      bytes += entry + g.name + '\0';
      all += one;
    }
    return bytes + all;
  }
  /** Offset of the first grid in a file with one segment. */
  static size_t firstGrid(const WrittenGrid& g) { return 16 + 176 + g.name.size() + 1; }
  template <class T> static void put(std::string& bytes, size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  }

 private:
  static constexpr uint64_t MAGIC = 0x304244566f6e614eull;
  static constexpr uint32_t VERSION = 32u << 21 | 4u << 10;

  static std::string grid(const WrittenGrid& g) {
    std::map<std::array<int, 3>, size_t> uppers, lowers; // positions in the file, by origin
    std::array<int, 3> low{1 << 30, 1 << 30, 1 << 30}, high{-(1 << 30), -(1 << 30), -(1 << 30)};
    for (const auto& [at, values] : g.leaves) {
      uppers[masked(at, 4095)] = lowers[masked(at, 127)] = 0;
      for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], at[axis]);
        high[axis] = std::max(high[axis], at[axis] + 7);
      }
    }
    const size_t root = GRID + 64;
    std::string b(root + ROOT + TILE * uppers.size(), '\0');
    put(b, 0, MAGIC);
    put(b, 16, VERSION);
    put(b, 636, uint32_t(1));
    for (size_t axis = 0; axis < 3; ++axis) {
      put(b, 296 + 88 + 32 * axis, g.voxel);
      put(b, 296 + 88 + 144 + 8 * axis, g.origin[int(axis)]);
      put(b, root + 4 * axis, low[axis]);
      put(b, root + 12 + 4 * axis, high[axis]);
    }
    put(b, GRID + 24, int64_t(root - GRID));
    put(b, root + 24, uint32_t(uppers.size()));
    size_t tile = root + ROOT;
    for (auto& [at, place] : uppers) {
      place = grow(b, UPPER);
      const auto part = [&corner = at](size_t axis) { return uint64_t(uint32_t(corner[axis]) >> 12); };
      put(b, tile, part(0) << 42 | part(1) << 21 | part(2));
      put(b, tile + 8, int64_t(place - root));
      tile += TILE;
    }
    for (auto& [at, place] : lowers) {
      place = grow(b, LOWER);
      setChild(b, uppers[masked(at, 4095)], index(at, 7, 5), 32 + 4096, 8256, place);
    }
    for (const auto& [at, values] : g.leaves) {
      const size_t place = grow(b, LEAF);
      std::memcpy(b.data() + place + 96, values.data(), sizeof values);
      setChild(b, lowers[masked(at, 127)], index(at, 3, 4), 32 + 512, 1088, place);
    }
    put(b, 32, uint64_t(b.size()));
    return b;
  }
  static std::array<int, 3> masked(const std::array<int, 3>& at, int mask) {
    return {at[0] & ~mask, at[1] & ~mask, at[2] & ~mask};
  }
  static size_t index(const std::array<int, 3>& at, int shift, int bits) {
    size_t n = 0;
    for (const int c : at) n = n << bits | size_t(c >> shift & ((1 << bits) - 1));
    return n;
  }
  static size_t grow(std::string& b, size_t bytes) {
    const size_t at = b.size();
    b.resize(at + bytes, '\0');
    return at;
  }
  static void setChild(std::string& b, size_t node, size_t n, size_t mask, size_t table, size_t child) {
    b[node + mask + n / 8] = static_cast<char>(b[node + mask + n / 8] | 1 << (n % 8));
    put(b, node + table + 8 * n, int64_t(child) - int64_t(node));
  }
};

/** A temporary file of a test. */
class NanoVdbFile {
 public:
  explicit NanoVdbFile(const std::vector<WrittenGrid>& grids) : NanoVdbFile(NanoVdbWriter::file(grids)) {}
  explicit NanoVdbFile(const std::string& bytes)
      : folder(std::filesystem::temp_directory_path() / ("recurse-vdb-" + std::to_string(::getpid()))),
        path((folder / "recurse-smoke.nvdb").string()) {
    std::filesystem::create_directories(folder);
    std::ofstream(path, std::ios::binary) << bytes;
  }
  ~NanoVdbFile() { std::filesystem::remove_all(folder); }
  NanoVdbFile(const NanoVdbFile&) = delete;
  NanoVdbFile& operator=(const NanoVdbFile&) = delete;

  std::string parameter() const { return "\"string filename\" \"" + path + "\" "; }
  const std::filesystem::path folder; ///< folder of this process
  const std::string path;
};

} // namespace recurse::testing
