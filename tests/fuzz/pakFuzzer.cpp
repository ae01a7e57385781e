/** @file
 * libFuzzer target: arbitrary bytes as an archive with a Quake III map.
 */
#include <fstream>

#include "fuzz/fuzzing.h"
#include "recurse/core/io/zipArchive.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  const std::string bytes = bytesOf(data, size), name = scratchFile(".zip");
  std::ofstream(name, std::ios::binary) << bytes;
  readAnything([&] {
    const ZipArchive archive(name);
    for (const std::string& file : archive.names()) readAnything([&] { archive.read(file); });
  });
  std::filesystem::remove(name);
  importAnything("quake3map", "pak", ".pk3", bytes);
  return 0;
}
