/** @file
 * Media on regular grids in a box: one density for all coefficients (uniformgrid), or coefficients of each
 * cell (rgbgrid).
 */
#include "media/grid/gridMedium.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

std::vector<ParameterSpec> boxParameters() {
  std::vector<ParameterSpec> parameters = gridBoxParameters();
  for (const char* name : {"nx", "ny", "nz"})
    parameters.push_back(
        integerParameter(name, "1", std::string("cells along ") + name[1]).range(1, 1 << 16));
  return parameters;
}

glm::ivec3 readSize(const Parameters& p) { return {p.integer("nx"), p.integer("ny"), p.integer("nz")}; }

/** Values of a grid parameter; fails unless there is one for each cell. */
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

/** `Lescale` of each cell over emissionScale(); empty where one value serves all cells. */
SampledGrid<float> readEmissionScale(const Parameters& p) {
  std::vector<double> values = p.reals("Lescale");
  if (values.size() == 1) return {};
  if (const double most = emissionScale(p); most > 0)
    for (double& v : values) v /= most;
  return readGrid<float>(p, "Lescale", values);
}

std::unique_ptr<Medium> makeUniformGrid(const Parameters& p, const MediumContext& context) {
  const GridBox box(p, context);
  const MediumPoint whole = readMediumPoint(p);
  HeatGlow glow;
  if (p.hasValue("temperature")) {
    if (p.has("Le")) p.fail("temperature", "both Le and temperature are given", "Le or temperature");
    glow = HeatGlow(p, box, readGrid<float>(p, "temperature", p.reals("temperature")));
  }
  auto medium = std::make_unique<DensityGrid>(whole, box, readGrid<float>(p, "density", p.reals("density")),
                                              std::move(glow), readEmissionScale(p));
  medium->checkSteps(p);
  return medium;
}

class RgbGrid final : public Medium {
 public:
  RgbGrid(const Parameters& p, const MediumContext& context) : box(p, context) {
    const auto read = [&](const char* name, double scale) {
      if (!p.hasValue(name)) return SampledGrid<Rgb>();
      std::vector<Rgbd> values = p.spectra(name);
      for (Rgbd& v : values) {
        v *= scale;
        if (!(maxComponent(v) <= 1e18)) // so that their squares fit in a float
          p.fail(name, "the values are too high for single precision", "values times scale below 1e18");
      }
      return readGrid<Rgb>(p, name, values);
    };
    absorption = read("sigma_a", p.real("scale"));
    scattering = read("sigma_s", p.real("scale"));
    emission = read("Le", p.real("Lescale"));
    if (absorption.empty() && scattering.empty()) p.fail("", "the grid has neither sigma_a nor sigma_s");
    if (!emission.empty() && absorption.empty())
      p.fail("Le", "a medium without absorption does not emit", "sigma_a, which Le is multiplied by");
    majorants = majorantsOf(readSize(p), [&](const glm::ivec3& i) {
      Rgb sum(0);
      if (!absorption.empty()) sum += absorption.value(i);
      if (!scattering.empty()) sum += scattering.value(i);
      return maxComponent(sum);
    });
    box.checkSteps(p, absorption.empty() ? "sigma_s" : "sigma_a", majorants, Rgb(1));
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
  Bounds3f bounds() const override { return box.bounds(); }

 private:
  GridBox box;
  SampledGrid<Rgb> absorption, scattering, emission;
  MajorantGrid majorants;
};

} // namespace

void registerUniformGrid(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = mediumParameters(
      "1", "1",
      arrayParameter(ParameterType::REAL, "Lescale", 0, "1",
                     "factor on Le or on the emission by temperature; one number, or one for each cell")
          .range(0, 1e30));
  for (const ParameterSpec& s : boxParameters()) parameters.push_back(s);
  parameters.push_back(arrayParameter(ParameterType::REAL, "density", 0, "",
                                      "density of each cell, x fastest; a factor on sigma_a and sigma_s")
                           .range(0, 1e18)
                           .require());
  parameters.push_back(arrayParameter(ParameterType::REAL, "temperature", 0, "",
                                      "temperature of each cell: absorbing cells emit as black bodies"));
  for (const ParameterSpec& s : heatParameters()) parameters.push_back(s);
  plugIns.media.add(
      {{.name = "uniformgrid",
        .summary = std::string("A medium with a density on a regular grid in a box.") + DENSITY_LIMIT,
        .parameters = parameters,
        .examples =
            {"\"float density\" 1",
             "\"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2 \"float density\" [ 0 1 2 3 4 5 6 7 ]",
             "\"integer nx\" 2 \"float density\" [ 1 2 ] \"float temperature\" [ 1500 3000 ]",
             "\"integer nx\" 2 \"float density\" [ 1 2 ] \"rgb Le\" [ 1 2 3 ] \"float Lescale\" [ 0 2 ]"}},
       makeUniformGrid});
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
      realParameter("scale", "1", "factor on sigma_a and sigma_s").range(0, 1e30), emissionScaleParameter()};
  for (const ParameterSpec& s : boxParameters()) parameters.push_back(s);
  plugIns.media.add(
      {{.name = "rgbgrid",
        .summary = std::string("A medium with coefficients on a regular grid in a box.") + DENSITY_LIMIT,
        .parameters = parameters,
        .examples = {"\"rgb sigma_s\" [ 1 2 3 ]", "\"integer nx\" 2 \"rgb sigma_a\" [ 1 2 3  3 2 1 ]"}},
       [](const Parameters& p, const MediumContext& c) { return std::make_unique<RgbGrid>(p, c); }});
}

} // namespace recurse
