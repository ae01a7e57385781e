/** @file
 * Rayleigh's phase function, of particles much smaller than the wavelength: 3/(16π) (1 + cos²).
 */
#include "recurse/model/medium/phaseFunction.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Rayleigh final : public PhaseFunction {
 public:
  float value(float cosine) const override { return 3.0f / 16 * INV_PI * (1 + cosine * cosine); }
  float sampleCosine(float u) const override {
    // The real root of x³ + 3x = 2q by Cardano; the second term of x = a - 1/a.
    const float q = 2 * (1 - 2 * u), a = std::cbrt(std::abs(q) + std::sqrt(q * q + 1));
    return std::copysign(a - 1 / a, q);
  }
  float meanCosine() const override { return 0; }
};

} // namespace

void registerRayleigh(PlugIns& plugIns) {
  plugIns.phaseFunctions.add(
      {{.name = "rayleigh",
        .summary = "Rayleigh's phase function of air molecules.",
        .parameters = {},
        .examples = {""}},
       [](const Parameters&, const NoContext&) { return std::make_unique<Rayleigh>(); }});
}

} // namespace recurse
