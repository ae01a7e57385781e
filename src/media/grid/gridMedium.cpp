/** @file
 * Boxes of grid media, and emission of hot media.
 */
#include "media/grid/gridMedium.h"

#include <algorithm>

#include "recurse/core/io/text.h"
#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

namespace {

constexpr double COLD = 100; ///< [K], as in pbrt-v4
constexpr size_t TABLE_SIZE = 256;

Mat4d sceneFromBox(const Parameters& p, const MediumContext& context) {
  const Vec3d p0 = p.vector3("p0"), p1 = p.vector3("p1"), lower = glm::min(p0, p1),
              extent = glm::max(p0, p1) - lower;
  if (!(extent.x > 0 && extent.y > 0 && extent.z > 0))
    p.fail("p1", "the grid's box is flat", "p0 and p1 that differ in each coordinate");
  Mat4d boxFromUnit(1);
  for (int i = 0; i < 3; ++i) boxFromUnit[i][i] = extent[i];
  boxFromUnit[3] = Vec4d(lower, 1);
  return context.sceneFromMedium * boxFromUnit;
}

} // namespace

GridBox::GridBox(const Parameters& p, const MediumContext& context) : GridBox(p, sceneFromBox(p, context)) {}

GridBox::GridBox(const Parameters& p, const Mat4d& sceneFromUnit) {
  const double determinant = glm::determinant(Mat3d(sceneFromUnit));
  if (!std::isfinite(determinant) || determinant == 0)
    p.fail("", "the medium's transform is singular: it cannot be inverted");
  unitFromScene = glm::inverse(sceneFromUnit);
  for (int corner = 0; corner < 8; ++corner)
    sceneBounds.add(Vec3f(transformPoint(sceneFromUnit, Vec3d(corner & 1, corner >> 1 & 1, corner >> 2))));
  constexpr double LARGEST = 1e18;                                                  // squares fit a float
  const auto fits = [](const auto& v) { return glm::length(Vec3d(v)) <= LARGEST; }; // false for NaN
  if (!fits(sceneBounds.lower) || !fits(sceneBounds.upper) || !fits(unitFromScene[0]) ||
      !fits(unitFromScene[1]) || !fits(unitFromScene[2]))
    p.fail("", "the grid's box is too small or too large for single precision",
           "a box within 1e18 of the origin, wider than 1e-18");
}

void GridBox::checkSteps(const Parameters& p, const char* parameter, const MajorantGrid& grid,
                         const Rgb& extinction) const {
  constexpr double MAX_STEPS = 1e6;
  float highest = 0;
  for (int z = 0; z < grid.size().z; ++z)
    for (int y = 0; y < grid.size().y; ++y)
      for (int x = 0; x < grid.size().x; ++x) highest = std::max(highest, grid.at({x, y, z}));
  const double steps =
      double(highest) * double(maxComponent(extinction)) * double(glm::length(sceneBounds.diagonal()));
  if (steps > MAX_STEPS)
    p.fail(parameter,
           "the maximum density is so high that a path may take " + formatted("%.2g", steps) +
               " steps through the grid, even where it is empty",
           "at most 1e6 mean free paths across the grid's box: decrease the scale, or use a homogeneous "
           "medium with these boundaries, which needs no steps");
}

std::vector<ParameterSpec> gridBoxParameters() {
  return {arrayParameter(ParameterType::POINT3, "p0", 1, "0 0 0", "a corner of the grid's box"),
          arrayParameter(ParameterType::POINT3, "p1", 1, "1 1 1", "the opposite corner")};
}

namespace {

float largest(const SampledGrid<float>& grid) {
  const glm::ivec3 size = grid.size();
  float most = 0;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) most = std::max(most, grid.value({x, y, z}));
  return most;
}

} // namespace

HeatGlow::HeatGlow(const Parameters& p, const GridBox& box, SampledGrid<float> given)
    : HeatGlow(p, largest(given)) {
  this->box = box;
  temperatures = std::move(given);
}

HeatGlow::HeatGlow(const Parameters& p, float highest)
    : offset(
          static_cast<float>(p.real(p.has("temperaturecutoff") ? "temperaturecutoff" : "temperatureoffset"))),
      scale(static_cast<float>(p.real("temperaturescale"))) {
  // Temperatures that are interpolated towards the zeros outside may be hotter.
  hottest = std::max((highest - offset) * scale, -offset * scale);
  if (!std::isfinite(hottest)) p.fail("temperaturescale", "the temperatures are too high");
  const double strength = emissionScale(p);
  if (!(double(hottest) > COLD) || !(strength > 0)) return;
  for (size_t i = 0; i < TABLE_SIZE; ++i) {
    const double kelvin = COLD + (double(hottest) - COLD) * double(i) / double(TABLE_SIZE - 1);
    const Rgbd relative = rgbOfBlackbody(kelvin, SpectrumKind::UNBOUNDED);
    table.emplace_back(rgbOfBlackbody(kelvin, SpectrumKind::ILLUMINANT) * (luminance(relative) * strength));
  }
}

Rgb HeatGlow::radiance(float temperature) const {
  const float kelvin = (temperature - offset) * scale;
  const auto cold = static_cast<float>(COLD);
  if (!(kelvin > cold)) return BLACK;
  const float place = std::min((kelvin - cold) / (hottest - cold), 1.0f) * static_cast<float>(TABLE_SIZE - 1);
  const size_t i = std::min(static_cast<size_t>(place), TABLE_SIZE - 2);
  const float part = place - static_cast<float>(i);
  return table[i] * (1 - part) + table[i + 1] * part;
}

std::vector<ParameterSpec> heatParameters() {
  return {
      realParameter("temperatureoffset", "0", "is subtracted from the temperatures"),
      realParameter("temperaturecutoff", "", "older name of temperatureoffset"),
      realParameter("temperaturescale", "1", "factor that converts the difference to kelvin").range(0, 1e30)};
}

} // namespace recurse
