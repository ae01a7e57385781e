/** @file
 * libFuzzer target: arbitrary bytes as a model that Assimp reads; the first byte chooses the format, and
 * whether the model has a pose.
 */
#include "fuzz/fuzzing.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  static constexpr const char* KINDS[] = {".obj", ".gltf", ".glb", ".stl", ".ply", ".dae", ".3ds", ".off"};
  if (size > 0)
    importAnything("mesh", "filename", KINDS[data[0] % std::size(KINDS)], bytesOf(data + 1, size - 1),
                   data[0] / std::size(KINDS) % 2 == 1 ? "\"float time\" 1" : "");
  return 0;
}
