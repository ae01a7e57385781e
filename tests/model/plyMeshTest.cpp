/** @file
 * PLY files: every encoding gives the same mesh, and broken files are explained.
 */
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <unistd.h>
#include <zlib.h>

#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {
void registerPlyMesh(PlugIns&);
}

using namespace recurse;

namespace {

enum class Encoding { TEXT, LITTLE, BIG };

/** Writes consecutive values in any encoding. */
class PlyWriter {
 public:
  explicit PlyWriter(Encoding encoding) : encoding(encoding) {
    const char* names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    line("ply");
    line(std::string("format ") + names[static_cast<int>(encoding)] + " 1.0");
  }
  PlyWriter& line(const std::string& text) {
    bytes += text + "\n";
    return *this;
  }
  template <class T> PlyWriter& put(T value) {
    if (encoding == Encoding::TEXT) {
      bytes += std::to_string(value) + " ";
      return *this;
    }
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (encoding == Encoding::BIG) std::reverse(raw, raw + sizeof(T));
    bytes.append(raw, sizeof(T));
    return *this;
  }
  std::string bytes;

 private:
  Encoding encoding;
};

class PlyMesh : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = ::testing::TempDir() + "plyMeshTest." + std::to_string(::getpid());
    std::filesystem::create_directory(directory);
    registerPlyMesh(all);
  }
  void TearDown() override { std::filesystem::remove_all(directory); }

  void write(const std::string& bytes) const {
    std::filesystem::remove(directory + "/mesh.ply"); // overwriting is slow on some file systems
    std::ofstream(directory + "/mesh.ply", std::ios::binary) << bytes;
  }
  void writeCompressed(const std::string& bytes) const {
    gzFile file = gzopen((directory + "/mesh.ply").c_str(), "wb");
    ASSERT_EQ(gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size())),
              static_cast<int>(bytes.size()));
    gzclose(file);
  }
  std::string rawBytes() const {
    std::ifstream in(directory + "/mesh.ply", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  std::unique_ptr<Shape> load(const std::string& more = {}) {
    ParsedDirective use = parseParameterText("plymesh", "\"string filename\" \"mesh.ply\" " + more);
    use.directory = use.topDirectory = directory;
    Diagnostics diagnostics;
    auto shape = all.shapes.make(use, {}, diagnostics);
    said = diagnostics.format();
    return shape;
  }
  const TriangleMesh* loadMesh() {
    loaded = load();
    EXPECT_TRUE(loaded) << said;
    return loaded ? loaded->triangleMesh() : nullptr;
  }
  void expectRefused(const std::string& bytes, const std::string& reason) {
    write(bytes);
    EXPECT_FALSE(load()) << reason;
    EXPECT_NE(said.find(reason), std::string::npos) << "\"" << reason << "\" is not in:\n" << said;
    const std::string name = directory + "/mesh.ply:";
    EXPECT_NE(said.find(name), std::string::npos) << said;
    EXPECT_EQ(said.find(name), said.rfind(name)) << said;
  }

  std::string directory, said;
  PlugIns all;
  std::unique_ptr<Shape> loaded;
};

/** A triangle, a quad and a pentagon, with all additional elements that occur in files. */
std::string house(Encoding encoding, bool facesFirst = false) {
  PlyWriter w(encoding);
  w.line("comment made for a test").line("obj_info nothing");
  const auto vertexHeader = [&] {
    w.line("element vertex 6").line("property double x").line("property float32 y").line("property float z");
    w.line("property uchar red").line("property list uchar short history");
    w.line("property float nx").line("property float ny").line("property float nz");
    w.line("property float texture_u").line("property float texture_v");
  };
  const auto faceHeader = [&] {
    w.line("element face 3").line("property int8 group").line("property list uint8 int vertex_indices");
    w.line("property list int float weights");
  };
  const auto otherHeader = [&] {
    w.line("element edge 2").line("property int vertex1").line("property list uint uint16 path");
    w.line("element nothing 1000000000000");
  };
  facesFirst ? faceHeader() : vertexHeader();
  otherHeader();
  facesFirst ? vertexHeader() : faceHeader();
  w.line("end_header");
  const auto vertices = [&] {
    for (int i = 0; i < 6; ++i) {
      w.put(0.25 * i)
          .put(0.5f * float(i * i))
          .put(-1.5f * float(i))
          .put(uint8_t(200 + i))
          .put(uint8_t(i % 3));
      for (int k = 0; k < i % 3; ++k) w.put(int16_t(-k - 300));
      w.put(0.0f).put(0.6f).put(0.8f).put(0.125f * float(i)).put(1.0f);
      if (encoding == Encoding::TEXT) w.line("");
    }
  };
  const auto faces = [&] {
    const std::vector<int> polygons[] = {{0, 1, 2}, {3, 2, 1, 0}, {5, 4, 3, 2, 1}};
    for (const auto& polygon : polygons) {
      w.put(int8_t(-5)).put(uint8_t(polygon.size()));
      for (int i : polygon) w.put(int32_t(i));
      w.put(int32_t(2)).put(0.5f).put(0.25f);
      if (encoding == Encoding::TEXT) w.line("");
    }
  };
  facesFirst ? faces() : vertices();
  for (int i = 0; i < 2; ++i) w.put(int32_t(i)).put(uint32_t(1)).put(uint16_t(60000));
  facesFirst ? vertices() : faces();
  return w.bytes;
}

const char* const TRIANGLE_HEADER =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
    "end_header\n";

} // namespace

TEST_F(PlyMesh, EveryEncodingReadsTheSame) {
  for (const Encoding encoding : {Encoding::TEXT, Encoding::LITTLE, Encoding::BIG}) {
    for (const bool compressed : {false, true}) {
      for (const bool facesFirst : {false, true}) {
        const std::string bytes = house(encoding, facesFirst);
        compressed ? writeCompressed(bytes) : write(bytes);
        const TriangleMesh* mesh = loadMesh();
        ASSERT_TRUE(mesh);
        ASSERT_EQ(mesh->positions().size(), 6u);
        for (int i = 0; i < 6; ++i)
          EXPECT_EQ(mesh->positions()[size_t(i)],
                    Vec3f(0.25f * float(i), 0.5f * float(i * i), -1.5f * float(i)));
        const std::vector<glm::uvec3> expected = {{0, 1, 2}, {3, 2, 1}, {3, 1, 0},
                                                  {5, 4, 3}, {5, 3, 2}, {5, 2, 1}};
        EXPECT_EQ(mesh->indices(), expected);
        const SurfacePoint p = mesh->surfaceAt(3, HitParameters(Vec2f(0, 0)));
        EXPECT_EQ(p.uv, Vec2f(0.625f, 1));
        EXPECT_NEAR(glm::dot(p.shadingNormal, Vec3f(0, 0.6f, 0.8f)), 1, 1e-6);
      }
    }
  }
}

TEST_F(PlyMesh, TextureCoordinatesByAnyName) {
  for (const auto& [u, v] :
       {std::pair("u", "v"), {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}) {
    std::string text = TRIANGLE_HEADER;
    const size_t place = text.find("element face");
    text.insert(place, std::string("property float ") + u + "\nproperty float " + v + "\n");
    write(text + "0 0 0 .1 .2\n1 0 0 .3 .4\n0 1 0 .5 .6\n3 0 1 2");
    const TriangleMesh* mesh = loadMesh();
    ASSERT_TRUE(mesh);
    EXPECT_EQ(mesh->surfaceAt(0, HitParameters(Vec2f(0, 1))).uv, Vec2f(0.5f, 0.6f)) << u;
  }
}

TEST_F(PlyMesh, CarriageReturnsSignsAndExponents) {
  std::string text = TRIANGLE_HEADER;
  for (size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2) text.insert(i, "\r");
  write(text + "+1e-1 0 0\r\n1.5E+0 -0 0\r\n 0\t1 0 \r\n3 0 1 2\r\n");
  const TriangleMesh* mesh = loadMesh();
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->positions()[0], Vec3f(0.1f, 0, 0));
  EXPECT_EQ(mesh->positions()[1], Vec3f(1.5f, 0, 0));
}

TEST_F(PlyMesh, BrokenVerticesThatNoFaceUsesDoNoHarm) {
  std::string text = TRIANGLE_HEADER;
  text.replace(text.find("vertex 3"), 8, "vertex 5");
  write(text + "0 0 0\nnan 0 0\n1 0 0\n0 inf nan\n0 1 0\n3 0 2 4\n");
  const TriangleMesh* mesh = loadMesh();
  ASSERT_TRUE(mesh);
  EXPECT_NE(said.find("2 vertices are not finite; no face uses them"), std::string::npos) << said;
  EXPECT_EQ(mesh->area(), 0.5f);
  expectRefused(text + "0 0 0\nnan 0 0\n1 0 0\n0 inf nan\n0 1 0\n3 0 2 3\n",
                ":13: vertex 3 has a position that is not finite");
}

TEST_F(PlyMesh, BrokenFilesAreExplained) {
  const std::string header = TRIANGLE_HEADER, vertices = "0 0 0\n1 0 0\n0 1 0\n";
  const auto replaced = [&](const std::string& what, const std::string& with) {
    std::string text = header + vertices + "3 0 1 2\n";
    return text.replace(text.find(what), what.size(), with);
  };
  expectRefused("", "the file ends within the header");
  expectRefused("plain text\n", "this is no PLY file");
  expectRefused(std::string(1 << 20, 'x'), "this is no PLY header");
  expectRefused(replaced("ascii", "utf8"), ":2: unknown format \"utf8\"");
  expectRefused(replaced("1.0", "2.0"), "version \"2.0\"");
  expectRefused(replaced("format ascii 1.0\n", ""), "no \"format\" line");
  expectRefused(replaced("property float x", "property real x"), ":4: unknown type \"real\"");
  expectRefused(replaced("property float x", "property float q"), "no x, y and z");
  expectRefused(replaced("element vertex 3", "element vertex -3"), ":3: \"-3\" is no number of elements");
  expectRefused(replaced("element vertex 3", "element vertex 99999999999999999999"),
                "is no number of elements");
  expectRefused(replaced("element vertex 3", "element vertex 0"), "no vertices");
  expectRefused(replaced("element vertex 3", "element points 3"), "no vertices");
  expectRefused(replaced("element face 1", "element face 0"), "no faces");
  expectRefused(replaced("element face 1", "element vertex 1"), "declared twice");
  expectRefused(replaced("vertex_indices", "corners"), "no list \"vertex_indices\"");
  expectRefused(replaced("list uchar int", "list float int"), "the length of a list cannot be");
  expectRefused(replaced("end_header\n", "begin\n"), "\"begin\" is not allowed in a PLY header");
  expectRefused(header + "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n", ":11: \"x\" is no number");
  expectRefused(header + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertex 1 has a position that is not finite");
  expectRefused(header + "0 0 0\n1 1e999 0\n0 1 0\n3 0 1 2\n", "not finite");
  expectRefused(header + "0 0 0\n1 1e60 0\n0 1 0\n3 0 1 2\n", "single precision");
  expectRefused(header + "0 0 0\n1 0", "the file ends in vertex 1 of 3");
  expectRefused(header + vertices, "the file ends in face 0 of 1");
  expectRefused(header + vertices + "3 0 1", "the file ends in face 0 of 1");
  expectRefused(header + vertices + "3 0 1 3\n", ":13: face 0 names vertex 3; there are 0 to 2");
  expectRefused(header + vertices + "3 0 -1 2\n", "face 0 names vertex -1");
  expectRefused(header + vertices + "3 0 1.5 2\n", "face 0 names vertex 1.5");
  expectRefused(header + vertices + "2 0 1\n", "face 0 has 2 vertices");
  expectRefused(header + vertices + "-3 0 1 2\n", "impossible length");
  expectRefused(header + vertices + "1e9 0 1 2\n", "the file ends in face 0 of 1");
}

TEST_F(PlyMesh, BrokenBinaryFilesAreExplained) {
  for (const Encoding encoding : {Encoding::LITTLE, Encoding::BIG}) {
    const auto file = [&](int64_t vertexCount, int64_t faceCount, int32_t lastIndex) {
      PlyWriter w(encoding);
      w.line("element vertex " + std::to_string(vertexCount));
      w.line("property float x").line("property float y").line("property float z");
      w.line("element face " + std::to_string(faceCount)).line("property list int int vertex_index");
      w.line("end_header");
      for (int i = 0; i < 9; ++i) w.put(float(i % 4 == 0));
      w.put(int32_t(3)).put(int32_t(0)).put(int32_t(1)).put(lastIndex);
      return w.bytes;
    };
    write(file(3, 1, 2));
    EXPECT_TRUE(load()) << said;
    expectRefused(file(3, 1, -1), "face 0 names vertex -1; there are 0 to 2");
    expectRefused(file(3, 1, 3), "face 0 names vertex 3");
    expectRefused(file(3, 2, 2), "the file ends in face 1 of 2");
    // Huge counts: the file is read to its end, without allocating memory for missing data.
    expectRefused(file(4000000000, 1, 2), "the file ends in vertex 4 of 4000000000");
    expectRefused(file(3, 4000000000000, 2), "the file ends in face 1 of 4000000000000");
    expectRefused(file(5000000000, 1, 2), "too many vertices");
    expectRefused(file(4, 1, 2), "face 0 has 2 vertices");
  }
}

TEST_F(PlyMesh, FilesCutOffAnywhereAreRefused) {
  for (const Encoding encoding : {Encoding::TEXT, Encoding::LITTLE, Encoding::BIG}) {
    std::string bytes = house(encoding);
    while (bytes.back() == ' ' || bytes.back() == '\n') bytes.pop_back();
    // Text files may lose digits of the last number without an error.
    for (size_t length = 0; length + 12 < bytes.size(); length += 3) {
      write(bytes.substr(0, length));
      EXPECT_FALSE(load()) << length << " of " << bytes.size();
      if (encoding != Encoding::TEXT) {
        EXPECT_NE(said.find("the file ends"), std::string::npos) << said;
      }
    }
    writeCompressed(bytes);
    const std::string compressed = rawBytes();
    for (size_t length = 20; length < compressed.size() - 8; length += 7) {
      write(compressed.substr(0, length));
      EXPECT_FALSE(load()) << length << " of " << compressed.size();
    }
    std::string damaged = compressed;
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x55);
    expectRefused(damaged, "the gzip data is damaged");
  }
}

TEST_F(PlyMesh, FilesWithWrongBytesDoNoHarm) {
  std::mt19937 random(3);
  for (const Encoding encoding : {Encoding::TEXT, Encoding::LITTLE, Encoding::BIG}) {
    const std::string bytes = house(encoding);
    for (int i = 0; i < 1500; ++i) {
      std::string changed = bytes;
      for (int k = 0; k < 1 + i % 3; ++k) changed[random() % changed.size()] = static_cast<char>(random());
      write(changed);
      if (const auto shape = load())
        EXPECT_TRUE(std::isfinite(shape->area()) || shape->area() > 0);
      else
        EXPECT_FALSE(said.empty());
    }
  }
}

TEST_F(PlyMesh, WhatCannotBeDoneIsSaid) {
  write(house(Encoding::TEXT));
  EXPECT_FALSE(load("\"float edgelength\" 1"));
  EXPECT_NE(said.find("there is no displacement"), std::string::npos) << said;
  EXPECT_FALSE(load("\"texture displacement\" \"bumps\""));
  EXPECT_NE(said.find("textures are not supported here"), std::string::npos) << said;
  std::filesystem::remove(directory + "/mesh.ply");
  EXPECT_FALSE(load());
  EXPECT_NE(said.find("there is no file"), std::string::npos) << said;
}
