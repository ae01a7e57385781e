/** @file
 * Media on regular grids: the box of a grid, emission by temperature, and the medium with one density for all
 * coefficients.
 */
#pragma once

#include <utility>

#include "media/grid/sampledGrid.h"
#include "recurse/model/medium/mediumParameters.h"

namespace recurse {

/** Text for the reference: the limit that checkSteps() enforces. */
constexpr const char* DENSITY_LIMIT = " The box may have at most 1e6 mean free paths of its maximum density "
                                      "across, because a path takes a step for each.";

/** Box of a grid, which maps to the unit cube. */
class GridBox {
 public:
  GridBox() = default;
  /** Box with the corners p0 and p1 of the parameters. */
  GridBox(const Parameters& p, const MediumContext& context);
  /** Fails where the transform has no inverse. */
  GridBox(const Parameters& p, const Mat4d& sceneFromUnit);

  Bounds3f bounds() const { return sceneBounds; }
  /** Fails where flights may take millions of steps, which would not end. Their step is the mean free path
   * at the local majorant of the densest channel, even where the medium is clear. */
  void checkSteps(const Parameters& p, const char* parameter, const MajorantGrid& grid,
                  const Rgb& extinction) const;
  Vec3f point(const Vec3f& scene) const { return Vec3f(transformPoint(unitFromScene, Vec3d(scene))); }
  MajorantSegments segments(const MajorantGrid& grid, const Rgb& extinction, const Ray& ray,
                            float end) const {
    return {grid, extinction, point(ray.origin), Vec3f(Mat3d(unitFromScene) * Vec3d(ray.direction)), end};
  }

 private:
  Mat4d unitFromScene{1};
  Bounds3f sceneBounds;
};

/** Parameters p0 and p1. */
std::vector<ParameterSpec> gridBoxParameters();

/** Black-body radiance for temperatures on a grid, as in pbrt-v4: relative to the maximum of the spectrum,
 * so that brightness does not grow with the temperature, and zero up to 100 K. */
class HeatGlow {
 public:
  HeatGlow() = default;
  /** Reads temperatureoffset, temperaturescale and Lescale. */
  HeatGlow(const Parameters& p, const GridBox& box, SampledGrid<float> temperatures);
  /** Emission for temperatures that are stored elsewhere, at most `highest`. */
  HeatGlow(const Parameters& p, float highest);

  bool empty() const { return table.empty(); }
  Rgb radianceAt(const Vec3f& scene) const { return radiance(temperatures.at(box.point(scene))); }
  Rgb radiance(float temperature) const;

 private:
  GridBox box;
  SampledGrid<float> temperatures;
  float offset = 0, scale = 1;
  float hottest = 0;      ///< [K]
  std::vector<Rgb> table; ///< over temperatures from COLD to the hottest
};

/** Parameters temperatureoffset, its old name temperaturecutoff, and temperaturescale. */
std::vector<ParameterSpec> heatParameters();

/** Medium whose coefficients are multiplied by one density. */
class DensityGrid final : public Medium {
 public:
  /** `whole` is the medium at density 1. A grid of `emissionScales`, at most 1, multiplies the emission
   * where it is not empty. */
  DensityGrid(const MediumPoint& whole, const GridBox& box, SampledGrid<float> densities, HeatGlow glow,
              SampledGrid<float> emissionScales = {})
      : whole(whole), box(box), density(std::move(densities)), glow(std::move(glow)),
        emissionScale(std::move(emissionScales)),
        majorants(majorantsOf(density.size(), [&](const glm::ivec3& i) { return density.value(i); })) {}

  void checkSteps(const Parameters& p) const { box.checkSteps(p, "density", majorants, whole.extinction()); }
  MediumPoint at(const Vec3f& position) const override {
    const Vec3f p = box.point(position);
    const float d = density.at(p);
    MediumPoint m{whole.absorption * d, whole.scattering * d, whole.emission * d};
    if (!glow.empty() && d > 0) m.emission += m.absorption * glow.radianceAt(position);
    if (!emissionScale.empty()) m.emission *= emissionScale.at(p);
    return m;
  }
  MajorantSegments segments(const Ray& ray, float end) const override {
    return box.segments(majorants, whole.extinction(), ray, end);
  }
  bool isEmissive() const override { return !isBlack(whole.emission) || !glow.empty(); }
  Bounds3f bounds() const override { return box.bounds(); }

 private:
  MediumPoint whole;
  GridBox box;
  SampledGrid<float> density;
  HeatGlow glow;
  SampledGrid<float> emissionScale;
  MajorantGrid majorants;
};

} // namespace recurse
