/** @file
 * libFuzzer target: arbitrary bytes as an MD2 model.
 */
#include "fuzz/fuzzing.h"
#include "importers/md2/md2Model.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  const std::string bytes = bytesOf(data, size);
  readAnything([&] {
    const Md2Model model("model", bytes);
    model.skins();
    model.animations();
    model.pose(double(model.frames() - 1) / 2);
  });
  return 0;
}
