/** @file
 * libFuzzer target: any bytes at all as a model that Assimp reads; the first byte chooses the kind.
 */
#include "fuzz/fuzzing.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  static constexpr const char* KINDS[] = {".obj", ".gltf", ".glb", ".stl", ".ply", ".dae", ".3ds", ".off"};
  if (size > 0)
    importAnything("mesh", "filename", KINDS[data[0] % std::size(KINDS)], bytesOf(data + 1, size - 1));
  return 0;
}
