/** @file
 * libFuzzer target: arbitrary bytes as a Quake III map and its shader script, in a valid archive: two bytes
 * are the length of the script, which is first.
 */
#include "fuzz/fuzzing.h"
#include "model/gameFileTesting.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  if (size < 2) return 0;
  const size_t script = std::min<size_t>(data[0] + 256u * data[1], size - 2);
  std::string picture(21, 0); // one pixel in TGA format
  picture[2] = 2;
  picture[12] = picture[14] = 1;
  picture[16] = 24;
  importAnything("quake3map", "pak", ".pk3",
                 testing::zipFile({{"maps/m.bsp", bytesOf(data + 2 + script, size - 2 - script)},
                                   {"scripts/s.shader", bytesOf(data + 2, script)},
                                   {"textures/wall.tga", picture}}));
  return 0;
}
