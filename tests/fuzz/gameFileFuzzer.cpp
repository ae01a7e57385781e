/** @file
 * libFuzzer target: any bytes at all as a Quake III map, an MD2 model, a PCX picture or a shader script; the
 * first byte chooses. Nothing may crash, hang, or throw anything but Error.
 */
#include <cstdint>
#include <string>

#include "core/pcx.h"
#include "model/gameShader.h"
#include "model/md2Model.h"
#include "model/quake3Bsp.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace recurse;
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    if (data[0] % 4 == 0) {
      Quake3Bsp map = readQuake3Bsp("map", bytes);
      const int steps = patchSteps(map, 0.1, 4);
      for (Quake3Bsp::Face& face : map.faces)
        if (face.patchWidth > 0) tessellatePatch(face, steps);
    } else if (data[0] % 4 == 1) {
      const Md2Model model("model", bytes);
      model.skins();
      model.animations();
      model.pose(double(model.frames() - 1) / 2);
    } else if (data[0] % 4 == 2) {
      detail::tgaOfPcx("picture", bytes);
    } else {
      GameShaders shaders;
      std::vector<std::string> warnings;
      readGameShaders("script", bytes, shaders, warnings);
      for (const auto& [name, shader] : shaders) shader.base();
    }
  } catch (const Error&) {
    // promised
  }
  return 0;
}
