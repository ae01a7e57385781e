/** @file
 * The medium that is the same everywhere.
 */
#include "recurse/model/mediumParameters.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

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
  std::vector<ParameterSpec> parameters = mediumParameters(".0011 .0024 .014", "2.55 3.21 3.77");
  parameters.push_back(
      stringParameter("preset", "", "measured matter in the place of sigma_a and sigma_s, in millimetres")
          .oneOf(mediumPresetNames()));
  plugIns.media.add({{.name = "homogeneous",
                      .summary = "A medium that is the same everywhere.",
                      .parameters = parameters,
                      .examples = {"", "\"rgb sigma_s\" [ 1 2 3 ] \"float scale\" 10",
                                   "\"string preset\" \"Wholemilk\"", "\"rgb Le\" [ 1 .5 .2 ]"}},
                     [](const Parameters& p, const MediumContext&) {
                       return std::make_unique<Homogeneous>(readMediumPoint(p));
                     }});
}

} // namespace recurse
