/** @file
 * Reads the tree of a NanoVDB grid: a root with a table, upper nodes of 32³ and lower nodes of 16³ children,
 * and leaves of 8³ values. Children are offsets in bytes from their parent.
 */
#include "media/nanovdb/nanoVdbFile.h"

#include <zlib.h>

#include <set>

#include "recurse/core/io/byteReader.h"
#include "recurse/core/threads/resources.h"

namespace recurse {

namespace {

constexpr uint64_t MAGIC = 0x304244566f6e614eull; ///< "NanoVDB0"
constexpr uint32_t MAJOR_VERSION = 32;
constexpr uint64_t HEADER = 16, GRID_ENTRY = 176;                ///< bytes in the file
constexpr uint64_t GRID_HEADER = 672, ROOT = 64, ROOT_TILE = 32; ///< bytes in a grid
constexpr uint64_t LEAF_HEADER = 96;

enum Codec : uint16_t { UNPACKED, ZIP, BLOSC };
/** Types with one number for each voxel. FP: quantized over the range of a leaf, with this many bits. */
enum GridType : uint32_t { FLOAT = 1, FP4 = 13, FP8 = 14, FP16 = 15, FP_ANY = 16 };

/** An inner level of the tree. */
struct Level {
  int log2Children; ///< number of children along an axis
  int log2Width;    ///< side of a child [voxels]
  uint64_t children() const { return 1ull << (3 * log2Children); }
  uint64_t childMask() const { return 32 + children() / 8; }
  uint64_t table() const { return (childMask() + children() / 8 + 16 + 31) / 32 * 32; }
  uint64_t bytes() const { return table() + 8 * children(); }
};
constexpr Level UPPER{5, 7}, LOWER{4, 3};
constexpr int ROOT_WIDTH_LOG2 = 12; ///< side of an upper node [voxels]

/** Reader of a grid that begins at byte 0. */
class GridReader {
 public:
  GridReader(const std::string& name, std::string_view bytes) : in(name, bytes) {}

  NanoVdbGrid read() {
    if (in.at<uint64_t>(0, "the grid's magic number") != MAGIC)
      in.fail(0, "this is not the beginning of a grid");
    type = in.at<uint32_t>(636, "the type of values");
    if (type != FLOAT && !(type >= FP4 && type <= FP_ANY))
      in.fail(636, "values of type " + std::to_string(type) +
                       "; only 1 (float) and 13 to 16 (floats with fewer bits) are supported");
    NanoVdbGrid grid;
    constexpr uint64_t MAP = 296, MATRIX = MAP + 88, SHIFT = MATRIX + 144;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        grid.worldFromIndex[column][row] =
            in.at<double>(MATRIX + 8 * uint64_t(3 * row + column), "the transform");
      grid.worldFromIndex[3][row] = in.at<double>(SHIFT + 8 * uint64_t(row), "the transform");
    }
    readRoot(offsetFrom(GRID_HEADER, GRID_HEADER + 24, "the root's offset"));
    grid.values = std::move(values);
    return grid;
  }

 private:
  /** Offset of a node whose distance from `parent` [bytes] is stored at `place`. */
  uint64_t offsetFrom(uint64_t parent, uint64_t place, const char* what) const {
    const auto distance = in.at<int64_t>(place, what);
    const auto most = static_cast<int64_t>(in.size());
    if (distance < -most || distance > most || static_cast<int64_t>(parent) + distance < 0)
      in.fail(place, std::string(what) + " points out of the grid");
    return static_cast<uint64_t>(static_cast<int64_t>(parent) + distance);
  }

  void readRoot(uint64_t root) {
    glm::ivec3 first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = in.at<int32_t>(root + 4 * uint64_t(axis), "the bounds");
      last[axis] = in.at<int32_t>(root + 12 + 4 * uint64_t(axis), "the bounds");
    }
    const auto background = in.at<float>(root + 28, "the background");
    if (first.x > last.x && first.y > last.y && first.z > last.z) { // bounds of an empty tree
      values = SparseGrid(in.source(), glm::ivec3(0), glm::ivec3(0), background);
      return;
    }
    constexpr int64_t WIDEST = 1 << 24,
                      FARTHEST = 1 << 30; // whole numbers in single precision; sums in 32 bits
    for (int axis = 0; axis < 3; ++axis)
      if (first[axis] > last[axis] || first[axis] < -FARTHEST || last[axis] > FARTHEST ||
          int64_t(last[axis]) - int64_t(first[axis]) >= WIDEST)
        in.fail(root, "bounds from " + std::to_string(first[axis]) + " to " + std::to_string(last[axis]));
    values = SparseGrid(in.source(), first, last, background);
    const uint64_t count = in.at<uint32_t>(root + 24, "the number of tiles");
    in.part(root + ROOT, count * ROOT_TILE, "the root's tiles");
    std::set<uint64_t> keys;
    for (uint64_t i = 0; i < count; ++i) {
      const uint64_t tile = root + ROOT + i * ROOT_TILE;
      const auto key = in.at<uint64_t>(tile, "a tile's key");
      if (!keys.insert(key).second) in.fail(tile, "two tiles have the same position");
      glm::ivec3 origin; // 21 bits for each coordinate, z the lowest
      for (int axis = 0; axis < 3; ++axis)
        origin[axis] = static_cast<int32_t>(static_cast<uint32_t>(key >> (21 * (2 - axis)) & 0x1fffff)
                                            << ROOT_WIDTH_LOG2);
      if (in.at<int64_t>(tile + 8, "a child's offset") != 0)
        readInner(UPPER, offsetFrom(root, tile + 8, "a child's offset"), origin);
      else
        values.fill(origin, 1 << ROOT_WIDTH_LOG2, in.at<float>(tile + 20, "a tile's value"));
    }
  }

  void readInner(const Level& level, uint64_t node, const glm::ivec3& origin) {
    in.part(node, level.bytes(), "a node of the tree");
    countBytes(node, level.bytes());
    const int mask = (1 << level.log2Children) - 1;
    for (uint64_t i = 0; i < level.children(); ++i) {
      const auto n = static_cast<int>(i);
      const glm::ivec3 at =
          origin + glm::ivec3(n >> (2 * level.log2Children), n >> level.log2Children & mask, n & mask) *
                       (1 << level.log2Width);
      const uint64_t place = node + level.table() + 8 * i;
      const auto bits = in.at<uint8_t>(node + level.childMask() + i / 8, "a mask of children");
      if (!(bits >> (i % 8) & 1))
        values.fill(at, 1 << level.log2Width, in.at<float>(place, "a tile's value"));
      else if (level.log2Width == LOWER.log2Width)
        readLeaf(offsetFrom(node, place, "a leaf's offset"), at);
      else
        readInner(LOWER, offsetFrom(node, place, "a child's offset"), at);
    }
  }

  void readLeaf(uint64_t leaf, const glm::ivec3& origin) {
    std::array<float, SparseGrid::BLOCK> block;
    if (type == FLOAT) {
      countBytes(leaf, LEAF_HEADER + sizeof block);
      for (size_t i = 0; i < block.size(); ++i)
        block[i] = in.at<float>(leaf + LEAF_HEADER + sizeof(float) * i, "a value");
    } else {
      const int bits = type == FP4    ? 4
                       : type == FP8  ? 8
                       : type == FP16 ? 16
                                      : 1 << (in.at<uint8_t>(leaf + 15, "the bits of a leaf") >> 5);
      if (bits > 16) in.fail(leaf + 15, "values of " + std::to_string(bits) + " bits");
      const auto lowest = in.at<float>(leaf + 80, "a leaf's lowest value"),
                 step = in.at<float>(leaf + 84, "a leaf's step");
      const std::string_view codes =
          in.part(leaf + LEAF_HEADER, block.size() / 8 * uint64_t(bits), "the values of a leaf");
      countBytes(leaf, LEAF_HEADER + codes.size());
      for (size_t i = 0; i < block.size(); ++i) {
        const size_t bit = i * size_t(bits);
        unsigned code = static_cast<uint8_t>(codes[bit / 8]);
        if (bits == 16) code |= unsigned(static_cast<uint8_t>(codes[bit / 8 + 1])) << 8;
        block[i] = static_cast<float>(code >> (bit % 8) & ((1u << bits) - 1)) * step + lowest;
        if (!std::isfinite(block[i])) in.fail(leaf + 84, "a value is not finite");
      }
    }
    values.setBlock(origin, block);
  }

  /** Fails for nodes that overlap or repeat, which might take for ever to read. */
  void countBytes(uint64_t node, uint64_t bytes) {
    read_ += bytes;
    if (read_ > in.size()) in.fail(node, "nodes of the tree overlap");
  }

  ByteReader in;
  uint32_t type = FLOAT;
  uint64_t read_ = 0;
  SparseGrid values;
};

/** Grid decompressed by zlib. */
std::string unpacked(const std::string& name, const ByteReader& in, uint64_t offset, uint64_t bytesInFile,
                     uint64_t size) {
  constexpr uint64_t MAX_RATIO = 1032; // bound on the compression of deflate
  const auto packed = in.at<uint64_t>(offset, "the size of a packed grid");
  if (bytesInFile < 8 || packed > bytesInFile - 8)
    in.fail(offset, "a packed grid is larger than its space in the file");
  const std::string_view from = in.part(offset + 8, packed, "a packed grid");
  if (size / MAX_RATIO > packed) in.fail(offset, "a packed grid has an impossible size");
  requireMemory(name + ": unpacked it", double(size));
  std::string to(size, '\0');
  auto length = static_cast<uLongf>(size);
  const int result = uncompress(reinterpret_cast<Bytef*>(to.data()), &length,
                                reinterpret_cast<const Bytef*>(from.data()), static_cast<uLong>(packed));
  if (result != Z_OK || length != size) in.fail(offset, "a packed grid is damaged");
  return to;
}

} // namespace

NanoVdbGrid readNanoVdb(const std::string& file, std::string_view bytes, const std::string& name,
                        std::vector<std::string>& others) {
  const ByteReader in(file, bytes);
  uint64_t segment = 0;
  do {
    if (in.at<uint64_t>(segment, "the magic number") != MAGIC)
      in.fail(segment,
              segment == 0 ? "this is no NanoVDB file of version 32" : "something after the last grid");
    const uint32_t version = in.at<uint32_t>(segment + 8, "the version") >> 21;
    if (version != MAJOR_VERSION) in.fail(segment + 8, "version " + std::to_string(version) + "; 32 is read");
    const auto count = in.at<uint16_t>(segment + 12, "the number of grids");
    const auto codec = in.at<uint16_t>(segment + 14, "the codec");
    struct Entry {
      std::string name;
      uint64_t size, bytesInFile;
    };
    std::vector<Entry> entries;
    uint64_t at = segment + HEADER;
    for (uint16_t i = 0; i < count; ++i) {
      const uint64_t nameSize = in.at<uint32_t>(at + 136, "the size of a name");
      entries.push_back({in.text(at + GRID_ENTRY, nameSize, "a name"), in.at<uint64_t>(at, "a size"),
                         in.at<uint64_t>(at + 8, "a size")});
      at += GRID_ENTRY + nameSize;
    }
    for (const Entry& e : entries) {
      const std::string_view stored = in.part(at, e.bytesInFile, ("the grid \"" + e.name + "\"").c_str());
      if (e.name == name) {
        const std::string inside = file + ": grid \"" + name + "\"";
        if (codec == UNPACKED) return GridReader(inside, stored).read();
        if (codec != ZIP)
          in.fail(segment + 14,
                  codec == BLOSC ? "compressed by blosc, which is not supported; use no compression, or zip"
                                 : "codec " + std::to_string(codec));
        return GridReader(inside, unpacked(inside, in, at, e.bytesInFile, e.size)).read();
      }
      others.push_back(e.name);
      at += e.bytesInFile;
    }
    segment = at;
  } while (segment < bytes.size());
  return {};
}

} // namespace recurse
