/** @file
 * libFuzzer target: arbitrary bytes as a PLY mesh.
 */
#include "fuzz/fuzzing.h"
#include "recurse/model/scene/plugIns.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  ParsedDirective shape = parseParameterText("plymesh", "\"string filename\" \"mesh.ply\"");
  shape.files = std::make_shared<MemoryFiles>(
      MemoryFiles{{"mesh.ply", std::make_shared<const std::string>(bytesOf(data, size))}});
  Diagnostics diagnostics;
  if (!plugIns().shapes.make(shape, ShapeContext{}, diagnostics) && !diagnostics.hasErrors())
    std::abort(); // a failure must have an error message
  return 0;
}
