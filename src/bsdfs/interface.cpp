/** @file
 * No scattering at all: a boundary of media that light passes straight through.
 */
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Interface final : public Material {
 public:
  const Bsdf* bsdfAt(const SurfacePoint&, BsdfArena&) const override { return nullptr; }
  LobeSet lobes() const override { return NO_LOBE; }
};

} // namespace

void registerInterface(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "interface",
        .summary = "No surface: light passes straight through. For boundaries of media.",
        .parameters = {},
        .examples = {""}},
       [](const Parameters&, const MaterialContext&) { return std::make_unique<Interface>(); }});
}

} // namespace recurse
