/** @file
 * libFuzzer target: any bytes at all as the JSON of a glTF file.
 */
#include "fuzz/fuzzing.h"
#include "importers/assimp/gltfDetails.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  readAnything([&] { readGltfDetails("model", bytesOf(data, size)); });
  return 0;
}
