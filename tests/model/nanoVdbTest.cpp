/** @file
 * NanoVDB files: values as written, in every supported type of number, and errors for damaged files.
 */
#include "model/nanoVdbTesting.h"

#if __has_include(<nanovdb/util/GridBuilder.h>)
#define NANOVDB_USE_ZIP
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#pragma GCC diagnostic pop
#define RECURSE_HAS_NANOVDB
#endif

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "media/nanovdb/nanoVdbFile.h"
#include "recurse/core/io/error.h"
#include "recurse/model/scene/sceneImport.h"
#include "sanitized.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Two distant clusters, on both sides of 0. */
WrittenGrid clusters() {
  WrittenGrid g;
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    const auto at = [&] { return static_cast<int>(random() % 40) - 20; };
    const int x = at(), y = at(), z = at();
    g(x, y, z) = static_cast<float>(random() % 1000) / 100;
    g(x + 200, y - 60, z) = static_cast<float>(random() % 1000) / 100;
  }
  g.voxel = 0.25;
  g.origin = {1, -2, 3};
  return g;
}

NanoVdbGrid read(const std::string& bytes, const std::string& name = "density") {
  std::vector<std::string> others;
  return readNanoVdb("smoke.nvdb", bytes, name, others);
}

std::string errorOf(const std::string& bytes) {
  try {
    read(bytes);
    return "";
  } catch (const Error& e) {
    return e.what();
  }
}

void expectHas(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << text << "\" has no \"" << part << "\"";
}

} // namespace

TEST(NanoVdb, ValuesAreWhereTheyWerePut) {
  WrittenGrid g = clusters();
  const NanoVdbGrid found = read(NanoVdbWriter::file({g}));
  ASSERT_FALSE(found.values.empty());
  for (const auto& [at, values] : WrittenGrid(g).leaves)
    for (int i = 0; i < 512; ++i) {
      const glm::ivec3 p(at[0] + (i >> 6), at[1] + (i >> 3 & 7), at[2] + (i & 7));
      ASSERT_EQ(found.values.value(p), values[size_t(i)]);
    }
  EXPECT_EQ(found.values.value({100, 0, 0}), 0); // between the clusters
  EXPECT_EQ(found.values.value({1 << 20, 0, 0}), 0);
  EXPECT_EQ(transformPoint(found.worldFromIndex, Vec3d(8, 16, -4)), Vec3d(3, 2, 2));
  // Value interpolated between four of the eight neighbours.
  const auto v = [&](int x, int y) { return double(found.values.value({x, y, 2})); };
  EXPECT_NEAR(found.values.at({3.25, 5.5, 2}),
              0.75 * (v(3, 5) + v(3, 6)) / 2 + 0.25 * (v(4, 5) + v(4, 6)) / 2, 1e-5);
}

TEST(NanoVdb, NoValueIsAboveItsBound) {
  const NanoVdbGrid found = read(NanoVdbWriter::file({clusters()}));
  const SparseGrid& grid = found.values;
  const MajorantGrid bounds = grid.majorants();
  const Vec3d first(grid.first()), size(grid.last() - grid.first() + 1);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < 200000; ++i) {
    const Vec3d unit(u(random), u(random), u(random));
    const glm::ivec3 cell(unit * Vec3d(bounds.size()));
    ASSERT_LE(grid.at(first + unit * size), bounds.at(cell) * 1.0001f);
  }
}

TEST(NanoVdb, GridsAreFoundByTheirNames) {
  WrittenGrid density, heat;
  density(1, 2, 3) = 4;
  heat.name = "temperature";
  heat(1, 2, 3) = 900;
  const std::string one = NanoVdbWriter::file({density, heat});
  EXPECT_EQ(read(one).values.value({1, 2, 3}), 4);
  EXPECT_EQ(read(one, "temperature").values.value({1, 2, 3}), 900);
  // A file may have several segments.
  const std::string two = NanoVdbWriter::file({density}) + NanoVdbWriter::file({heat});
  EXPECT_EQ(read(two, "temperature").values.value({1, 2, 3}), 900);
  std::vector<std::string> others;
  EXPECT_TRUE(readNanoVdb("smoke.nvdb", two, "flames", others).values.empty());
  EXPECT_EQ(others, (std::vector<std::string>{"density", "temperature"}));
}

TEST(NanoVdb, DamageIsToldWithItsPlace) {
  WrittenGrid g;
  g(1, 2, 3) = 4;
  const std::string good = NanoVdbWriter::file({g});
  const size_t grid = NanoVdbWriter::firstGrid(g), tree = grid + NanoVdbWriter::GRID, root = tree + 64,
               tile = root + NanoVdbWriter::ROOT, upper = tile + NanoVdbWriter::TILE;
  const auto changed = [&](size_t at, auto value) {
    std::string bytes = good;
    NanoVdbWriter::put(bytes, at, value);
    return errorOf(bytes);
  };
  EXPECT_EQ(errorOf(good), "");
  expectHas(errorOf(""), "smoke.nvdb: at byte 0: the magic number would take 8 bytes, and the file has 0");
  expectHas(errorOf("PNG"), "smoke.nvdb");
  expectHas(changed(0, uint64_t(7)), "this is no NanoVDB file");
  expectHas(changed(8, uint32_t(31u << 21)), "version 31; 32 is read");
  expectHas(changed(14, uint16_t(2)), "compressed by blosc");
  expectHas(changed(14, uint16_t(1)), "a packed grid");
  expectHas(changed(16 + 8, ~uint64_t(0)), "the grid \"density\" would take 18446744073709551615 bytes");
  expectHas(changed(16 + 136, ~uint32_t(0)), "a name would take");
  expectHas(changed(grid, uint64_t(7)),
            "smoke.nvdb: grid \"density\": at byte 0: this is not the beginning of a grid");
  expectHas(changed(grid + 636, uint32_t(6)), "values of type 6");
  expectHas(changed(grid + 384, std::nan("")), "the transform is not finite");
  for (const int64_t far : {int64_t(1) << 40, std::numeric_limits<int64_t>::max(),
                            std::numeric_limits<int64_t>::min(), int64_t(-5000)})
    expectHas(changed(tree + 24, far), "the root's offset points out of the grid");
  expectHas(changed(root, 100), "bounds from 100 to 7");
  expectHas(changed(root + 12, std::numeric_limits<int>::max()), "bounds from 0 to 2147483647");
  expectHas(changed(root + 24, ~uint32_t(0)), "the root's tiles would take");
  expectHas(changed(tile + 8, int64_t(-(1 << 20))), "a child's offset points out of the grid");
  expectHas(changed(tile + 8, int64_t(300000)), "a node of the tree would take");
  std::string large = good;
  for (size_t axis = 0; axis < 3; ++axis) NanoVdbWriter::put(large, root + 12 + 4 * axis, (1 << 24) - 1);
  expectHas(errorOf(large),
            "smoke.nvdb: grid \"density\": a grid of 2097152 x 2097152 x 2097152 blocks needs");
  std::string shared = good; // 64 entries have the same lower node as their child
  for (size_t i = 0; i < 64; ++i) {
    shared[upper + 32 + 4096 + i / 8] = '\xff';
    NanoVdbWriter::put(shared, upper + 8256 + 8 * i, int64_t(NanoVdbWriter::UPPER));
  }
  expectHas(errorOf(shared), "nodes of the tree overlap");
  expectHas(changed(good.size() - 4, std::nanf("")), "a value is not finite");
  for (size_t length = 0; length < good.size(); length += length < 2000 ? 1 : 997)
    EXPECT_NE(errorOf(good.substr(0, length)), "") << length;
}

TEST(NanoVdb, NoBytesAreTrusted) {
  WrittenGrid g;
  g(1, 2, 3) = 4;
  g(130, -5, 9) = 2;
  const std::string good = NanoVdbWriter::file({g});
  // Bytes that matter: all but the tables of inner nodes, which are nearly empty.
  std::vector<size_t> places;
  for (size_t i = 0; i < good.size(); ++i)
    if (i < 1200 || good[i] != 0) places.push_back(i);
  std::mt19937 random(9);
  int refused = 0, taken = 0;
  std::string bytes = good;
  const int runs = samples(4000);
  for (int run = 0; run < runs; ++run) {
    std::vector<std::pair<size_t, char>> before;
    for (uint32_t n = 1 + random() % 3; n > 0; --n) {
      const size_t at = places[random() % places.size()];
      before.emplace_back(at, bytes[at]);
      bytes[at] = static_cast<char>(random() % 4 ? random() : (random() % 2 ? 0xff : 0));
    }
    try {
      const NanoVdbGrid found = read(bytes);
      if (!found.values.empty()) found.values.at({1.5, 2.5, 3.5});
      ++taken;
    } catch (const Error& e) {
      expectHas(e.what(), "");
      ++refused;
    }
    for (size_t i = before.size(); i-- > 0;) bytes[before[i].first] = before[i].second;
  }
  EXPECT_GT(40 * refused, runs);
  EXPECT_GT(40 * taken, runs);
}

#ifdef RECURSE_HAS_NANOVDB
namespace {

/** Writes the clusters by NanoVDB's own builder, and compares with NanoVDB's reader. */
template <class Build> void expectSameAsNanoVdb(nanovdb::io::Codec codec) {
  nanovdb::GridBuilder<float, Build> builder(0.0f);
  auto set = builder.getAccessor();
  for (const auto& [at, values] : clusters().leaves)
    for (int i = 0; i < 512; ++i)
      if (values[size_t(i)] != 0)
        set.setValue(nanovdb::Coord(at[0] + (i >> 6), at[1] + (i >> 3 & 7), at[2] + (i & 7)),
                     values[size_t(i)]);
  auto handle = builder.getHandle(0.5, nanovdb::Vec3d(1, 2, 3), "density");
  const std::string path = (std::filesystem::temp_directory_path() / "recurse-test.nvdb").string();
  nanovdb::io::writeGrid(path, handle, codec);
  std::vector<std::string> others;
  const NanoVdbGrid found = readNanoVdb(path, readFileBytes(path), "density", others);
  std::filesystem::remove(path);
  const auto* grid = handle.template grid<Build>();
  ASSERT_TRUE(grid);
  const auto get = grid->getAccessor();
  const auto box = grid->indexBBox();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(found.values.first()[axis], box.min()[axis]);
    EXPECT_EQ(found.values.last()[axis], box.max()[axis]);
  }
  int filled = 0;
  for (int x = box.min()[0]; x <= box.max()[0]; ++x)
    for (int y = box.min()[1]; y <= box.max()[1]; ++y)
      for (int z = box.min()[2]; z <= box.max()[2]; ++z) {
        const float there = get.getValue(nanovdb::Coord(x, y, z)), here = found.values.value({x, y, z});
        ASSERT_NEAR(here, there, 1e-6f * std::abs(there)) << x << " " << y << " " << z;
        filled += here != 0;
      }
  EXPECT_GT(filled, 500);
  const auto world = grid->indexToWorld(nanovdb::Vec3d(4, 5, 6));
  const Vec3d own = transformPoint(found.worldFromIndex, Vec3d(4, 5, 6));
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(own[axis], world[axis]);
}

} // namespace

TEST(NanoVdb, FilesOfItsOwnLibraryAreRead) {
  for (const auto codec : {nanovdb::io::Codec::NONE, nanovdb::io::Codec::ZIP}) {
    expectSameAsNanoVdb<float>(codec);
    expectSameAsNanoVdb<nanovdb::Fp4>(codec);
    expectSameAsNanoVdb<nanovdb::Fp8>(codec);
    expectSameAsNanoVdb<nanovdb::Fp16>(codec);
    expectSameAsNanoVdb<nanovdb::FpN>(codec);
  }
}
#endif
