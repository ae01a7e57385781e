/** @file
 * Direct light by one ray.
 */
#include "report/figures/directSampling.h"

#include "recurse/core/sampling/sampling.h"

namespace recurse {

namespace {

/** Estimator at one point. */
class DirectEstimator {
 public:
  DirectEstimator(const Scene& scene, const ViewedPoint& visible)
      : scene(scene), visible(visible), scattering(*visible.bsdf, visible.hit.point),
        frame(facing(scattering.normal(), visible.wi)), isTwoSided(scattering.lobes() & TRANSMISSION) {}

  Rgb estimate(DirectSampling sampling, Sampler& sampler) const {
    const bool isCombined = sampling == DirectSampling::COMBINED;
    const bool isLight =
        sampling == DirectSampling::LIGHT || (isCombined && sampler.next1D() < COMBINED_PROBABILITY);
    return isLight ? byLight(isCombined, sampler) : byRay(sampling, sampler);
  }

 private:
  static constexpr float COMBINED_PROBABILITY = 0.5f;

  static Vec3f facing(const Vec3f& normal, const Vec3f& wi) {
    return glm::dot(normal, wi) < 0 ? -normal : normal;
  }

  Rgb byLight(bool isCombined, Sampler& sampler) const {
    const std::optional<ViewedLight> sample = sampleLight(scene, visible, scattering, sampler);
    if (!sample) return BLACK;
    const LiSample& light = sample->light;
    const SurfacePoint& from = visible.hit.point;
    if (isBlocked(scene, from, from.rayOrigin(light.direction), light)) return BLACK;
    float density = sample->density;
    if (isCombined) {
      density *= COMBINED_PROBABILITY;
      if (!light.unhittable)
        density += (1 - COMBINED_PROBABILITY) * scattering.pdfNonDelta(visible.wi, light.direction);
    }
    return sample->contribution / density;
  }

  Rgb byRay(DirectSampling sampling, Sampler& sampler) const {
    float density = 0;
    const std::optional<Vec3f> direction = sampleDirection(sampling, sampler, density);
    if (!direction || !(density > 0)) return BLACK;
    const Rgb f = scattering.evaluate(visible.wi, *direction);
    if (isBlack(f)) return BLACK;
    const SurfacePoint& from = visible.hit.point;
    Rgb sum = BLACK;
    const auto add = [&](const Rgb& radiance, float pdfLight) {
      if (isBlack(radiance)) return;
      const float all = sampling == DirectSampling::COMBINED
                            ? (1 - COMBINED_PROBABILITY) * density + COMBINED_PROBABILITY * pdfLight
                            : density;
      sum += visible.weight * f * radiance / all;
    };
    followRay(scene, {from.rayOrigin(*direction), *direction, INFINITE, from.time}, [&](const Hit* hit) {
      if (hit) {
        add(hit->areaLight->radiance(hit->point, -*direction),
            scene.lights().probability(hit->lightIndex) *
                hit->areaLight->pdfLi(from.position, hit->primitive, hit->point));
        return;
      }
      for (size_t i = 0; i < scene.environment().size(); ++i) {
        const EnvironmentLight& light = *scene.environment()[i];
        add(light.radiance(*direction), scene.lights().probability(scene.environmentIndices()[i]) *
                                            light.pdfLi(from.position, *direction));
      }
    });
    return sum;
  }

  std::optional<Vec3f> sampleDirection(DirectSampling sampling, Sampler& sampler, float& density) const {
    if (sampling == DirectSampling::BSDF || sampling == DirectSampling::COMBINED) {
      const std::optional<Scatter> s = scattering.scatterNonDelta(visible.wi, Transport::RADIANCE, sampler);
      if (!s) return {};
      density = s->pdf;
      return s->direction;
    }
    const Vec2f u = sampler.next2D();
    Vec3f local = sampling == DirectSampling::UNIFORM ? uniformCone(u, 1) : cosineHemisphere(u);
    density = sampling == DirectSampling::UNIFORM ? INV_PI / 2 : local.z * INV_PI;
    if (isTwoSided) {
      density /= 2;
      if (sampler.next1D() < 0.5f) local.z = -local.z;
    }
    return frame.toWorld(local);
  }

  const Scene& scene;
  const ViewedPoint& visible;
  ScatteringPoint scattering;
  Frame frame; ///< shading frame, z towards the camera's side
  bool isTwoSided;
};

} // namespace

const char* directSamplingName(DirectSampling sampling) {
  static constexpr std::array<const char*, DIRECT_SAMPLINGS> NAMES = {"uniform", "cosine", "BSDF", "light",
                                                                      "BSDF and light"};
  return NAMES[size_t(sampling)];
}

Rgb sampleDirectLight(const Scene& scene, const ViewedPoint& point, DirectSampling sampling,
                      Sampler& sampler) {
  return DirectEstimator(scene, point).estimate(sampling, sampler);
}

} // namespace recurse
