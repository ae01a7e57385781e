/** @file
 * Media on regular grids in a box: one density for all coefficients (uniformgrid), or coefficients of each
 * cell (rgbgrid).
 */
#include "recurse/model/mediumParameters.h"
#include "recurse/model/plugIns.h"
#include "recurse/model/sampledGrid.h"

namespace recurse {

namespace {

/** The box of a grid: its points in the unit cube. */
class GridBox {
 public:
  GridBox(const Parameters& p, const MediumContext& context) {
    const Vec3d p0 = p.vector3("p0"), p1 = p.vector3("p1"), lower = glm::min(p0, p1),
                extent = glm::max(p0, p1) - lower;
    if (!(extent.x > 0 && extent.y > 0 && extent.z > 0))
      p.fail("p1", "the grid's box is flat", "p0 and p1 that differ in each coordinate");
    Mat4d sceneFromUnit(1);
    for (int i = 0; i < 3; ++i) sceneFromUnit[i][i] = extent[i];
    sceneFromUnit[3] = Vec4d(lower, 1);
    sceneFromUnit = context.sceneFromMedium * sceneFromUnit;
    const double determinant = glm::determinant(Mat3d(sceneFromUnit));
    if (!std::isfinite(determinant) || determinant == 0)
      p.fail("", "the medium's transform flattens it: it cannot be inverted");
    unitFromScene = glm::inverse(sceneFromUnit);
  }
  Vec3f point(const Vec3f& scene) const { return Vec3f(transformPoint(unitFromScene, Vec3d(scene))); }
  MajorantSegments segments(const MajorantGrid& grid, const Rgb& extinction, const Ray& ray,
                            float end) const {
    return {grid, extinction, point(ray.origin), Vec3f(Mat3d(unitFromScene) * Vec3d(ray.direction)), end};
  }

 private:
  Mat4d unitFromScene{1};
};

std::vector<ParameterSpec> boxParameters() {
  return {integerParameter("nx", "1", "cells along x").range(1, 1 << 16),
          integerParameter("ny", "1", "cells along y").range(1, 1 << 16),
          integerParameter("nz", "1", "cells along z").range(1, 1 << 16),
          arrayParameter(ParameterType::POINT3, "p0", 1, "0 0 0", "a corner of the grid's box"),
          arrayParameter(ParameterType::POINT3, "p1", 1, "1 1 1", "the corner opposite")};
}

glm::ivec3 readSize(const Parameters& p) { return {p.integer("nx"), p.integer("ny"), p.integer("nz")}; }

/** The values of a grid's parameter, as many as it has cells. */
template <class T, class Values>
SampledGrid<T> readGrid(const Parameters& p, const std::string& name, const Values& values) {
  const glm::ivec3 size = readSize(p);
  const size_t cells = size_t(size.x) * size_t(size.y) * size_t(size.z);
  if (values.size() != cells)
    p.fail(name,
           "there are " + std::to_string(values.size()) + " values for " + std::to_string(size.x) + " x " +
               std::to_string(size.y) + " x " + std::to_string(size.z) + " cells",
           std::to_string(cells) + " values, or other nx, ny, nz");
  std::vector<T> converted;
  converted.reserve(cells);
  for (const auto& v : values) converted.push_back(T(v));
  return {size, std::move(converted)};
}

class UniformGrid final : public Medium {
 public:
  UniformGrid(const Parameters& p, const MediumContext& context)
      : box(p, context), whole(readMediumPoint(p)),
        density(readGrid<float>(p, "density", p.reals("density"))),
        majorants(majorantsOf(density.size(), [&](const glm::ivec3& i) { return density.value(i); })) {}
  MediumPoint at(const Vec3f& position) const override {
    const float d = density.at(box.point(position));
    return {whole.absorption * d, whole.scattering * d, whole.emission * d};
  }
  MajorantSegments segments(const Ray& ray, float end) const override {
    return box.segments(majorants, whole.extinction(), ray, end);
  }
  bool isEmissive() const override { return !isBlack(whole.emission); }

 private:
  GridBox box;
  MediumPoint whole; ///< of density 1
  SampledGrid<float> density;
  MajorantGrid majorants;
};

class RgbGrid final : public Medium {
 public:
  RgbGrid(const Parameters& p, const MediumContext& context) : box(p, context) {
    const auto read = [&](const char* name, double scale) {
      if (!p.hasValue(name)) return SampledGrid<Rgb>();
      std::vector<Rgbd> values = p.spectra(name);
      for (Rgbd& v : values) v *= scale;
      return readGrid<Rgb>(p, name, values);
    };
    absorption = read("sigma_a", p.real("scale"));
    scattering = read("sigma_s", p.real("scale"));
    emission = read("Le", p.real("Lescale"));
    if (absorption.empty() && scattering.empty()) p.fail("", "the grid has neither sigma_a nor sigma_s");
    if (!emission.empty() && absorption.empty())
      p.fail("Le", "what does not absorb does not emit", "sigma_a, which Le is multiplied by");
    majorants = majorantsOf(readSize(p), [&](const glm::ivec3& i) {
      Rgb sum(0);
      if (!absorption.empty()) sum += absorption.value(i);
      if (!scattering.empty()) sum += scattering.value(i);
      return maxComponent(sum);
    });
  }
  MediumPoint at(const Vec3f& position) const override {
    const Vec3f p = box.point(position);
    MediumPoint m;
    if (!absorption.empty()) m.absorption = absorption.at(p);
    if (!scattering.empty()) m.scattering = scattering.at(p);
    if (!emission.empty()) m.emission = m.absorption * emission.at(p);
    return m;
  }
  MajorantSegments segments(const Ray& ray, float end) const override {
    return box.segments(majorants, Rgb(1), ray, end);
  }
  bool isEmissive() const override { return !emission.empty(); }

 private:
  GridBox box;
  SampledGrid<Rgb> absorption, scattering, emission;
  MajorantGrid majorants;
};

} // namespace

void registerUniformGrid(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = mediumParameters("1", "1");
  for (const ParameterSpec& s : boxParameters()) parameters.push_back(s);
  parameters.push_back(arrayParameter(ParameterType::REAL, "density", 0, "",
                                      "of each cell, x fastest; multiplies sigma_a and sigma_s")
                           .range(0, 1e18)
                           .require());
  plugIns.media.add(
      {{.name = "uniformgrid",
        .summary = "A medium whose density is given on a regular grid in a box.",
        .parameters = parameters,
        .examples =
            {"\"float density\" 1",
             "\"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2 \"float density\" [ 0 1 2 3 4 5 6 7 ]"}},
       [](const Parameters& p, const MediumContext& c) { return std::make_unique<UniformGrid>(p, c); }});
}

void registerRgbGrid(PlugIns& plugIns) {
  const auto grid = [](const char* name, SpectrumKind kind, const char* meaning) {
    ParameterSpec s = spectrumParameter(name, "", kind, meaning);
    s.count = 0;
    return s;
  };
  std::vector<ParameterSpec> parameters = {
      grid("sigma_a", SpectrumKind::UNBOUNDED, "absorption of each cell, x fastest [1/length]"),
      grid("sigma_s", SpectrumKind::UNBOUNDED, "scattering of each cell [1/length]"),
      grid("Le", SpectrumKind::ILLUMINANT, "emitted radiance of each cell, see homogeneous"),
      realParameter("scale", "1", "of sigma_a and sigma_s").range(0, 1e30),
      realParameter("Lescale", "1", "of Le").range(0, 1e30)};
  for (const ParameterSpec& s : boxParameters()) parameters.push_back(s);
  plugIns.media.add(
      {{.name = "rgbgrid",
        .summary = "A medium whose coefficients are given on a regular grid in a box.",
        .parameters = parameters,
        .examples = {"\"rgb sigma_s\" [ 1 2 3 ]", "\"integer nx\" 2 \"rgb sigma_a\" [ 1 2 3  3 2 1 ]"}},
       [](const Parameters& p, const MediumContext& c) { return std::make_unique<RgbGrid>(p, c); }});
}

} // namespace recurse
