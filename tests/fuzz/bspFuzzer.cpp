/** @file
 * libFuzzer target: arbitrary bytes as a Quake III map.
 */
#include "fuzz/fuzzing.h"
#include "importers/quake3/quake3Bsp.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  const std::string bytes = bytesOf(data, size);
  readAnything([&] {
    Quake3Bsp map = readQuake3Bsp("map", bytes);
    const int steps = patchSteps(map, 0.1, 4);
    for (Quake3Bsp::Face& face : map.faces)
      if (face.patchWidth > 0) tessellatePatch(face, steps);
  });
  return 0;
}
