/** @file
 * Homogeneous media: equal coefficients everywhere.
 */
#include "recurse/model/medium/mediumParameters.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Medium of the same albedos with limited extinction in each channel [1/length]. At such extinctions only
 * the albedos matter. */
MediumPoint limited(MediumPoint m, float maxExtinction) {
  const Rgb extinction = m.extinction();
  for (int c = 0; c < 3; ++c)
    if (extinction[c] > maxExtinction)
      for (Rgb* coefficient : {&m.absorption, &m.scattering, &m.emission})
        (*coefficient)[c] *= maxExtinction / extinction[c];
  return m;
}

class Homogeneous final : public Medium {
 public:
  explicit Homogeneous(const MediumPoint& medium) : medium(medium) {}
  MediumPoint at(const Vec3f&) const override { return medium; }
  MajorantSegments segments(const Ray&, float end) const override { return {end, medium.extinction()}; }
  bool isHomogeneous() const override { return true; }
  bool isEmissive() const override { return !isBlack(medium.emission); }

 private:
  MediumPoint medium;
};

} // namespace

void registerHomogeneous(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = mediumParameters("1", "1");
  parameters.push_back(
      stringParameter("preset", "",
                      "measured material instead of sigma_a and sigma_s; lengths in millimetres")
          .oneOf(mediumPresetNames()));
  plugIns.media.add({{.name = "homogeneous",
                      .summary = "Fog, smoke or a liquid: a medium with constant coefficients.",
                      .parameters = parameters,
                      .examples = {"", "\"rgb sigma_s\" [ 1 2 3 ] \"float scale\" 10",
                                   "\"string preset\" \"Wholemilk\"", "\"rgb Le\" [ 1 .5 .2 ]"}},
                     [](const Parameters& p, const MediumContext& c) {
                       return std::make_unique<Homogeneous>(limited(readMediumPoint(p), c.maxExtinction));
                     }});
}

} // namespace recurse
