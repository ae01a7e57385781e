/** @file
 * libFuzzer target: arbitrary bytes as a shader script of Quake III.
 */
#include <vector>

#include "fuzz/fuzzing.h"
#include "importers/quake3/gameShader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  readAnything([&] {
    GameShaders shaders;
    std::vector<std::string> warnings;
    readGameShaders("script", bytesOf(data, size), shaders, warnings);
    for (const auto& [name, shader] : shaders) shader.base();
  });
  return 0;
}
