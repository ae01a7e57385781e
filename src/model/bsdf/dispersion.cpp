/** @file
 * The distribution of wavelengths, in bins of a nanometre.
 */
#include "recurse/model/bsdf/dispersion.h"

#include <algorithm>
#include <cmath>

namespace recurse {

namespace {

class Wavelengths {
 public:
  static constexpr int COUNT = static_cast<int>(LONGEST_WAVELENGTH - SHORTEST_WAVELENGTH);

  Wavelengths() {
    std::array<Rgbd, COUNT> light;
    Rgbd white(0);
    for (int i = 0; i < COUNT; ++i) white += light[size_t(i)] = daylightColour(SHORTEST_WAVELENGTH + i + 0.5);
    double total = 0;
    std::array<double, COUNT> strength;
    for (size_t i = 0; i < COUNT; ++i) {
      light[i] /= white;
      total += strength[i] = std::abs(light[i].r) + std::abs(light[i].g) + std::abs(light[i].b);
    }
    double sum = 0;
    for (size_t i = 0; i < COUNT; ++i) {
      colours[i] = Rgb(light[i] * (total / strength[i]));
      sum += strength[i] / total;
      cumulative[i] = static_cast<float>(sum);
    }
    cumulative.back() = 1;
  }

  float sample(float u) const {
    const auto above = std::upper_bound(cumulative.begin(), cumulative.end() - 1, u);
    const auto i = above - cumulative.begin();
    const float from = i > 0 ? cumulative[size_t(i) - 1] : 0, width = *above - from;
    const float part = width > 0 ? std::clamp((u - from) / width, 0.0f, 0.999f) : 0.5f;
    return static_cast<float>(SHORTEST_WAVELENGTH) + static_cast<float>(i) + part;
  }
  const Rgb& colour(float wavelength) const {
    const int i = static_cast<int>(wavelength - static_cast<float>(SHORTEST_WAVELENGTH));
    return colours[static_cast<size_t>(std::clamp(i, 0, COUNT - 1))];
  }

 private:
  std::array<Rgb, COUNT> colours;
  std::array<float, COUNT> cumulative;
};

const Wavelengths& wavelengths() {
  static const Wavelengths ALL;
  return ALL;
}

} // namespace

float sampleWavelength(float u) { return wavelengths().sample(u); }

Rgb wavelengthColour(float wavelength) { return wavelengths().colour(wavelength); }

DispersiveIndex::DispersiveIndex(const SampledSpectrum& index) : spectrum(index) {
  const auto& v = spectrum.values;
  constant = std::all_of(v.begin(), v.end(), [&](double x) { return x == v.front(); });
  Rgb white(0);
  for (size_t i = 0; i < PARTS; ++i) {
    const float w = sampleWavelength((static_cast<float>(i) + 0.5f) / PARTS);
    white += whiteParts[i].colour = wavelengthColour(w);
    whiteParts[i].index = at(w);
  }
  for (Part& part : whiteParts) part.colour /= white;
}

SampledSpectrum cauchyIndex(double indexD, double abbe) {
  constexpr double D = 0.58756, F = 0.48613, C = 0.65627; // Fraunhofer's lines, micrometres
  const double b = (indexD - 1) / (abbe * (1 / (F * F) - 1 / (C * C))), a = indexD - b / (D * D);
  SampledSpectrum out;
  for (double w = SHORTEST_WAVELENGTH; w <= LONGEST_WAVELENGTH; w += 5) {
    out.wavelengths.push_back(w);
    out.values.push_back(a + b / (w * w * 1e-6));
  }
  return out;
}

} // namespace recurse
