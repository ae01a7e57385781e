/** @file
 * Media of sparse grids in NanoVDB files, the output of simulations of smoke, fire and clouds.
 */
#include "media/grid/gridMedium.h"
#include "media/nanovdb/nanoVdbFile.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/scene/sceneImport.h"

namespace recurse {

namespace {

/** Grid of the file in the space of the scene. */
class PlacedGrid {
 public:
  PlacedGrid() = default;
  PlacedGrid(const Parameters& p, NanoVdbGrid grid, const MediumContext& context)
      : values(std::move(grid.values)), sceneFromIndex(context.sceneFromMedium * grid.worldFromIndex) {
    const double determinant = glm::determinant(Mat3d(sceneFromIndex));
    if (!std::isfinite(determinant) || determinant == 0)
      p.fail("filename", "the transform of the medium or of its grid is singular: it cannot be inverted");
    indexFromScene = glm::inverse(sceneFromIndex);
  }

  const SparseGrid& grid() const { return values; }
  float at(const Vec3f& scene) const { return values.at(transformPoint(indexFromScene, Vec3d(scene))); }
  /** Transform from the unit cube to the box of the grid in the scene. */
  Mat4d sceneFromUnit() const {
    Mat4d indexFromUnit(1);
    for (int i = 0; i < 3; ++i) indexFromUnit[i][i] = values.last()[i] + 1.0 - values.first()[i];
    indexFromUnit[3] = Vec4d(Vec3d(values.first()), 1);
    return sceneFromIndex * indexFromUnit;
  }

 private:
  SparseGrid values;
  Mat4d sceneFromIndex{1}, indexFromScene{1};
};

class NanoVdbMedium final : public Medium {
 public:
  NanoVdbMedium(const Parameters& p, const MediumContext& context) : whole(readMediumPoint(p)) {
    const std::string file = p.filePath("filename");
    const std::string bytes = readFileBytes(file);
    std::vector<std::string> names;
    density = PlacedGrid(p, readNanoVdb(file, bytes, "density", names), context);
    if (density.grid().empty()) {
      std::string all;
      for (const std::string& name : names) all += (all.empty() ? "\"" : ", \"") + name + "\"";
      p.fail("filename", file + " has no grid \"density\"",
             names.empty() ? "it has no grids at all" : "its grids are " + all);
    }
    constexpr float DENSEST = 1e18f; // limit of all grids; squares of extinctions fit
    if (density.grid().largest() > DENSEST)
      p.fail("filename", file + ": the densities are too high for single precision", "densities below 1e18");
    if (density.grid().smallest() < 0) p.warn("filename", file + ": negative densities are replaced by 0");
    box = GridBox(p, density.sceneFromUnit());
    majorants = density.grid().majorants();
    box.checkSteps(p, "filename", majorants, whole.extinction());
    temperature = PlacedGrid(p, readNanoVdb(file, bytes, "temperature", names), context);
    if (temperature.grid().empty()) return;
    if (p.has("Le")) p.fail("Le", "the emission is given twice: " + file + " has temperatures");
    glow = HeatGlow(p, temperature.grid().largest());
  }

  MediumPoint at(const Vec3f& position) const override {
    const float d = std::max(0.0f, density.at(position));
    MediumPoint m{whole.absorption * d, whole.scattering * d, whole.emission * d};
    if (!glow.empty() && d > 0) m.emission += m.absorption * glow.radiance(temperature.at(position));
    return m;
  }
  MajorantSegments segments(const Ray& ray, float end) const override {
    return box.segments(majorants, whole.extinction(), ray, end);
  }
  bool isEmissive() const override { return !isBlack(whole.emission) || !glow.empty(); }
  Bounds3f bounds() const override { return box.bounds(); }

 private:
  MediumPoint whole;
  PlacedGrid density, temperature;
  GridBox box;
  MajorantGrid majorants;
  HeatGlow glow;
};

} // namespace

void registerNanoVdb(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = mediumParameters("1", "1");
  parameters.push_back(
      realParameter("LeScale", "", "Lescale, as pbrt-v4 spells it for this medium").range(0, 1e30));
  parameters.push_back(
      stringParameter("filename", "",
                      "NanoVDB file with a grid \"density\", which multiplies sigma_a and sigma_s, and "
                      "optionally a grid \"temperature\": the absorbing medium emits as a black body")
          .require());
  for (const ParameterSpec& s : heatParameters()) parameters.push_back(s);
  plugIns.media.add(
      {{.name = "nanovdb",
        .summary =
            std::string(
                "A medium with the density of a sparse grid in a file, in single precision or fewer bits.") +
            DENSITY_LIMIT,
        .parameters = parameters,
        .examples = {}},
       [](const Parameters& p, const MediumContext& c) -> std::unique_ptr<Medium> {
         try {
           return std::make_unique<NanoVdbMedium>(p, c);
         } catch (const SceneError&) {
           throw;
         } catch (const Error& e) {
           p.fail("filename", e.what());
         }
       }});
}

} // namespace recurse
