/** @file
 * Tables of the transmittance and the internal reflectance of clear coats.
 */
#include "bsdfs/coated/clearCoat.h"

#include <map>
#include <mutex>
#include <tuple>

namespace recurse {

ClearCoat::ClearCoat(float eta, MicrofacetKind kind, float minAlpha, float maxAlpha, float thickness)
    : thickness(thickness), minAlpha(minAlpha), maxAlpha(maxAlpha) {
  const auto coatOf = [=](float alpha) { return DielectricInterface{eta, {kind, Vec2f(alpha)}}; };
  transmitted = AlbedoTable(minAlpha, maxAlpha, [&](const Vec3f& wi, float alpha, const Vec2f& u) {
    const auto in = coatOf(alpha).step(wi, u, TRANSMISSION);
    return in && in->wo.z != 0 ? in->weight * slabTransmittance(thickness, in->wo.z) : 0;
  });
  const int rows = maxAlpha > minAlpha ? 20 : 1;
  for (int row = 0; row < rows; ++row)
    returned.push_back(meanReflectance(
        coatOf(minAlpha + (maxAlpha - minAlpha) * static_cast<float>(row) / std::max(rows - 1.0f, 1.0f))));
}

float ClearCoat::transmittance(const DielectricInterface& coat, float cosine) const {
  if (!coat.facets.smooth()) return transmitted.at(cosine, coat.facets.roughness().x);
  const DielectricFresnel f = dielectricFresnel(std::min(cosine, 1.0f), coat.eta);
  return f.reflectance < 1 ? (1 - f.reflectance) * slabTransmittance(thickness, f.cosTransmitted) : 0;
}

float ClearCoat::reflectance(const DielectricInterface& coat) const {
  const float x = std::clamp((coat.facets.roughness().x - minAlpha) / (maxAlpha - minAlpha), 0.0f, 1.0f) *
                  static_cast<float>(returned.size() - 1);
  if (returned.size() == 1) return returned[0];
  const auto row = std::min(static_cast<size_t>(x), returned.size() - 2);
  return glm::mix(returned[row], returned[row + 1], x - static_cast<float>(row));
}

std::shared_ptr<const ClearCoat> ClearCoat::make(float eta, MicrofacetKind kind, float minAlpha,
                                                 float maxAlpha, float thickness) {
  static std::mutex one;
  static std::map<std::tuple<float, MicrofacetKind, float, float, float>, std::weak_ptr<const ClearCoat>>
      made;
  const std::lock_guard guard(one);
  std::weak_ptr<const ClearCoat>& known = made[{eta, kind, minAlpha, maxAlpha, thickness}];
  std::shared_ptr<const ClearCoat> coat = known.lock();
  if (!coat) {
    coat = std::make_shared<const ClearCoat>(eta, kind, minAlpha, maxAlpha, thickness);
    known = coat;
  }
  return coat;
}

/** Mean reflectance of the coat for diffuse light from below. The quasi-random points are multiples of the
 * negative powers of the root of x⁴ = x + 1, which generalise the golden ratio to three dimensions. */
float ClearCoat::meanReflectance(const DielectricInterface& coat) const {
  constexpr int COUNT = 1 << 15;
  const Vec3d step(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
  double sum = 0;
  for (int i = 0; i < COUNT; ++i) {
    const Vec3f u(glm::fract((double(i) + 0.5) * step));
    const float cosine = std::sqrt(std::max(u.x, 1e-6f));
    const auto back = coat.step({std::sqrt(1 - square(cosine)), 0, -cosine}, {u.y, u.z}, REFLECTION);
    if (back && back->wo.z != 0)
      sum += double(back->weight * slabTransmittance(thickness, cosine) *
                    slabTransmittance(thickness, back->wo.z));
  }
  return static_cast<float>(sum / COUNT);
}

} // namespace recurse
