/** @file
 * Writes a valid file of each kind as a start for the fuzzers.
 */
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>

#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>

#include "gltfFile.h"
#include "model/gameFileTesting.h"

namespace {

using namespace recurse::testing;

const std::string SCRIPT =
    "textures/wall\n{\nsurfaceparm trans\nq3map_surfacelight 100\nq3map_sun 1 1 .9 80 30 60\n"
    "cull none\n{\nmap textures/wall.tga\nblendFunc add\nalphaFunc GE128\n}\n}\n"
    "textures/sky\n{\nsurfaceparm sky\nskyparms env/a - -\n}\n";
const std::string CUBE =
    "o cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\n"
    "vt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\nf 5 6 7 8\nf 1 2 6 5\n";
const std::string PLY =
    "ply\nformat ascii 1.0\ncomment a tent\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float u\n"
    "property float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n1 1 .5 0 0 1 1 1\n0 1 0 0 0 1 0 1\n4 0 1 2 3\n3 0 1 2\n";

std::string map() {
  BspWriter map;
  map.entities =
      "{ \"classname\" \"worldspawn\" \"ambient\" \"10\" } { \"classname\" \"light\" \"origin\" \"1 2 30\" "
      "\"light\" \"200\" \"_color\" \"1 .5 .2\" \"target\" \"t\" } { \"classname\" \"info_player_start\" "
      "\"origin\" \"0 0 1\" \"angle\" \"90\" } { \"classname\" \"x\" \"targetname\" \"t\" \"origin\" \"0 0 "
      "0\" }";
  map.shader("textures/wall");
  map.shader("textures/sky", 4);
  map.square(0, 0);
  map.square(1, 9);
  for (int i = 0; i < 9; ++i) map.vertex({float(i % 3), float(i / 3), i == 4}, {0, 0}, {0, 0, 1});
  map.face(0, 2, 8, 12, 3, 3);
  return map.file();
}

void write(const std::filesystem::path& file, const std::string& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << bytes;
}

/** A triangle with a joint and step keyframes. */
std::string movingModel() {
  GltfFile f;
  f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  f.bytes("VEC4", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  f.floats("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  f.floats("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  f.floats("SCALAR", {0, 2});
  f.floats("VEC3", {0, 0, 0, 3, 0, 0});
  return f.text(
      R"("scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"skin":0,"weights":[0.5]},{"name":"joint"}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2},"targets":[{"POSITION":0}]}]}],)"
      R"("skins":[{"joints":[1],"inverseBindMatrices":3}],"animations":[{"channels":[{"sampler":0,)"
      R"("target":{"node":1,"path":"translation"}}],"samplers":[{"interpolation":"STEP","input":4,"output":5}]}])");
}

/** A cube in each format that Assimp writes, each with the first byte that chooses the format. */
void writeModels(const std::filesystem::path& folder) {
  write(folder / "obj", char(0) + CUBE);
  write(folder / "off", char(7) + std::string("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  write(folder / "moving", char(9) + movingModel());
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(CUBE.data(), CUBE.size(), aiProcess_Triangulate, "obj");
  Assimp::Exporter exporter;
  for (const auto& [kind, name] :
       {std::pair(1, "gltf2"), {2, "glb2"}, {3, "stl"}, {3, "stlb"}, {4, "plyb"}, {5, "collada"}, {6, "3ds"}})
    if (const aiExportDataBlob* blob = exporter.ExportToBlob(scene, name))
      write(folder / name, char(kind) + std::string(static_cast<const char*>(blob->data), blob->size));
}

} // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "Usage: fuzz_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  const std::string length{char(SCRIPT.size() & 255), char(SCRIPT.size() >> 8)};
  write(folder / "md2/good", md2File("skin.pcx"));
  write(folder / "pcx/good", pcxFile());
  write(folder / "bsp/good", map());
  write(folder / "shader/good", SCRIPT);
  write(folder / "pak/good", zipFile({{"maps/m.bsp", map()}, {"scripts/s.shader", SCRIPT}}));
  write(folder / "mapFile/good", length + SCRIPT + map());
  write(folder / "ply/good", PLY);
  writeModels(folder / "meshFile");
  return 0;
}
