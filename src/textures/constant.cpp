/** @file
 * Texture of one value.
 */
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Constant final : public Texture {
 public:
  explicit Constant(const Rgb& value) : constant(value) {}
  Rgb value(const SurfacePoint&) const override { return constant; }

 private:
  Rgb constant;
};

} // namespace

void registerConstant(PlugIns& plugIns) {
  ParameterSpec value = textureValue("value", "1", "the value");
  value.textured = false;
  plugIns.textures.add({{.name = "constant",
                         .summary = "The same value everywhere.",
                         .parameters = {value},
                         .examples = {"\"float value\" .4"}},
                        [](const Parameters& p, const TextureContext& c) {
                          return std::make_unique<Constant>(c.value(p, "value").constant);
                        }});
}

} // namespace recurse
