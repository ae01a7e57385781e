/** @file
 * libFuzzer target: arbitrary bytes as a PCX picture.
 */
#include "core/image/pcx.h"
#include "fuzz/fuzzing.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  readAnything([&] { detail::tgaOfPcx("picture", bytesOf(data, size)); });
  return 0;
}
