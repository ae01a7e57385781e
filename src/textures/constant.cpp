/** @file
 * The same value everywhere.
 */
#include "recurse/model/plugIns.h"

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
  plugIns.textures.add(
      {{.name = "constant",
        .summary = "The same value everywhere.",
        .parameters = {spectrumParameter("value", "1", SpectrumKind::UNBOUNDED, "the value")},
        .examples = {"\"rgb value\" [.1 .2 .3]"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<Constant>(Rgb(p.spectrum("value")));
       }});
}

} // namespace recurse
