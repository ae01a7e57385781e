/** @file
 * Directions of light at single points, estimated by rays and learned by the guide.
 */
#include "recurse/report/directions/guideFigure.h"

#include <cmath>
#include <numeric>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/core/threads/parallel.h"
#include "report/directions/hemisphereDisc.h"
#include "report/figures/visiblePoints.h"

namespace recurse {

namespace {

constexpr size_t DISC_CELLS = size_t(HemisphereDisc::CELLS) * HemisphereDisc::CELLS;

/** Estimates at one point. */
class PointDirections {
 public:
  PointDirections(const Scene& scene, const Integrator& integrator, const ViewedPoint& viewed, uint64_t seed,
                  const std::atomic<bool>& stop)
      : scene(scene), integrator(integrator), viewed(viewed), seed(seed), stop(stop),
        disc(viewed.hit.point.normalTowards(viewed.wi), viewed.wi), bsdf(*viewed.bsdf, viewed.hit.point),
        mixture(bsdf) {
    out.learned = integrator.directionsAt(viewed.hit.point, viewed.wi);
    out.isGuidable = bsdf.isGuidable();
    mixture.follow(out.learned.guide);
  }

  PixelDirections directions(int64_t samples) {
    for (std::vector<double>& density : out.densities) density.assign(DISC_CELLS, 0);
    out.solidAngles.assign(DISC_CELLS, 0);
    parallelFor(DISC_CELLS, [&](size_t cell) {
      fillDensities(cell);
      fillIncident(cell, samples);
    });
    takePaths(samples);
    out.irradiance = normalise(out.densities[PixelDirections::INCIDENT]);
    normalise(out.densities[PixelDirections::LEFT_TO_RAYS]);
    return std::move(out);
  }

 private:
  /** Sums over the camera paths of a row. */
  struct PathSums {
    std::vector<double> light = std::vector<double>(DISC_CELLS); ///< by the cell that the path left through
    double sum = 0, squares = 0, bsdfSquares = 0; ///< bsdfSquares: second moment as under BSDF sampling alone
    int64_t count = 0;
  };
  enum Stream : uint64_t { INCIDENT_STREAM, PATH_STREAM };

  void fillDensities(size_t cell) {
    constexpr int ACROSS = 4; // points of a cell in a row
    int inside = 0;
    std::array<double, PixelDirections::DENSITIES> sums{};
    for (int i = 0; i < ACROSS * ACROSS; ++i) {
      const auto d = disc.direction(cell, (Vec2f(i % ACROSS, i / ACROSS) + 0.5f) / float(ACROSS));
      if (!d) continue;
      ++inside;
      if (out.learned.guide) sums[PixelDirections::GUIDE] += double(out.learned.guide->pdf(*d));
      sums[PixelDirections::BSDF] += double(bsdf.pdfNonDelta(viewed.wi, *d));
      sums[PixelDirections::MIXTURE] += double(mixture.pdfNonDelta(viewed.wi, *d));
    }
    if (inside == 0) return;
    out.solidAngles[cell] = HemisphereDisc::CELL_ANGLE * inside / (ACROSS * ACROSS);
    for (size_t i : {PixelDirections::GUIDE, PixelDirections::BSDF, PixelDirections::MIXTURE})
      out.densities[i][cell] = sums[i] / inside;
  }

  void fillIncident(size_t cell, int64_t samples) {
    TransportCounts counts;
    PathRadiance radiance(classes, counts);
    double sum = 0;
    int64_t inside = 0;
    for (int64_t i = 0; i < samples && !stop; ++i) {
      Sampler sampler(hashCombine(seed, INCIDENT_STREAM), cell, static_cast<uint32_t>(i));
      const auto d = disc.direction(cell, sampler.next2D());
      if (!d) continue;
      ++inside;
      radiance.reset();
      const SurfacePoint& point = viewed.hit.point;
      integrator.backward(scene, {{point.rayOrigin(*d), *d, INFINITE, point.time}}, sampler, radiance);
      sum += double(luminance(radiance.total()) * disc.cosine(*d));
    }
    if (inside > 0) out.densities[PixelDirections::INCIDENT][cell] = sum / double(inside);
  }

  /** Adds a camera path through the point. */
  void addPath(Sampler& sampler, PathRadiance& radiance, PathSums& sums) const {
    PathRecorder record;
    record.beginSample({});
    radiance.recorder = &record;
    integrator.backward(scene, {viewed.ray}, sampler, radiance);
    ++sums.count;
    if (record.steps().empty() || record.steps()[0].event != PathEvent::D) return;
    Rgb found = BLACK;
    for (const RecordedContribution& c : record.contributions()) {
      const bool isHit = c.source.technique == PathTechnique::HIT;
      if (isHit ? c.source.step > CAMERA_STEP : c.source.vertex > 0) found += c.radiance;
    }
    const Vec3f& direction = record.steps()[0].direction;
    const float byBsdf = bsdf.pdfNonDelta(viewed.wi, direction);
    const double light = double(luminance(found));
    if (!(light > 0 && byBsdf > 0)) return;
    sums.sum += light;
    sums.squares += square(light);
    // Second moment of light · mixture / BSDF under BSDF sampling, as a mean over samples of the mixture.
    sums.bsdfSquares += square(light) * double(mixture.pdfNonDelta(viewed.wi, direction) / byBsdf);
    if (const auto cell = disc.cellOf(direction)) sums.light[*cell] += light;
  }

  void takePaths(int64_t samples) {
    std::vector<PathSums> rows(HemisphereDisc::CELLS);
    parallelFor(rows.size(), [&](size_t row) {
      TransportCounts counts;
      PathRadiance radiance(classes, counts);
      for (int64_t i = 0; i < samples * HemisphereDisc::CELLS && !stop; ++i) {
        Sampler sampler(hashCombine(seed, PATH_STREAM), row, static_cast<uint32_t>(i));
        addPath(sampler, radiance, rows[row]);
      }
    });
    PathSums all;
    for (const PathSums& row : rows) {
      for (size_t cell = 0; cell < DISC_CELLS; ++cell) all.light[cell] += row.light[cell];
      all.sum += row.sum;
      all.squares += row.squares;
      all.bsdfSquares += row.bsdfSquares;
      all.count += row.count;
    }
    const double count = double(std::max<int64_t>(all.count, 1));
    out.leftToRays = all.sum / count;
    const auto relativeVariance = [&](double squares) {
      return squares / count / square(out.leftToRays) - 1;
    };
    out.mixtureVariance = relativeVariance(all.squares);
    out.bsdfVariance = relativeVariance(all.bsdfSquares);
    for (size_t cell = 0; cell < DISC_CELLS; ++cell)
      if (out.solidAngles[cell] > 0)
        out.densities[PixelDirections::LEFT_TO_RAYS][cell] = all.light[cell] / count / out.solidAngles[cell];
  }

  /** Divides by the integral, which it returns, unless that is zero. */
  double normalise(std::vector<double>& density) const {
    const double integral = std::inner_product(density.begin(), density.end(), out.solidAngles.begin(), 0.0);
    if (integral > 0)
      for (double& x : density) x /= integral;
    return integral;
  }

  const Scene& scene;
  const Integrator& integrator;
  const ViewedPoint& viewed;
  uint64_t seed;
  const std::atomic<bool>& stop;
  const PathClasses classes;
  HemisphereDisc disc;
  ScatteringPoint bsdf, mixture;
  PixelDirections out;
};

PixelDirections directionsAt(const Scene& scene, const Integrator& integrator, int x, int y, int64_t samples,
                             uint64_t seed, const std::atomic<bool>& stop) {
  const std::string name = std::to_string(x) + "," + std::to_string(y);
  BsdfArena arena;
  PixelView view;
  if (const std::optional<CameraRay> ray = middleRay(scene, x, y)) view = viewAlong(scene, *ray, arena);
  if (view.points.empty())
    throw Error("pixel " + name + " sees no surface with a non-delta lobe, which a guide could serve");
  const ViewedPoint& brightest = *std::max_element(view.points.begin(), view.points.end(),
                                                   [](const ViewedPoint& a, const ViewedPoint& b) {
                                                     return maxComponent(a.weight) < maxComponent(b.weight);
                                                   });
  PixelDirections out = PointDirections(scene, integrator, brightest, seed, stop).directions(samples);
  out.pixel = name;
  return out;
}

std::string guideName(const PixelDirections& p) {
  if (!p.isGuidable) return "guide: never for this material";
  const auto records = static_cast<unsigned long long>(p.learned.records);
  if (!p.learned.guide) return formatted("no guide: %llu records", records);
  return formatted("guide, %s: %llu records", p.learned.isSampled ? "on" : "off", records);
}

std::string panelName(const PixelDirections& p, PixelDirections::Density density) {
  const auto withVariance = [](const char* name, double variance) {
    return std::isfinite(variance) ? formatted("%s, variance %.3g", name, variance) : std::string(name);
  };
  switch (density) {
  case PixelDirections::INCIDENT:
    return p.pixel + formatted(": all light, E = %.3g", p.irradiance);
  case PixelDirections::LEFT_TO_RAYS:
    return formatted("left to rays, L = %.2g", p.leftToRays);
  case PixelDirections::GUIDE:
    return guideName(p);
  case PixelDirections::BSDF:
    return withVariance("BSDF", p.bsdfVariance);
  default:
    return withVariance("mixture", p.mixtureVariance);
  }
}

/** Scale from a hundredth of the maximum of cosine sampling. Single bright cells of the estimates, and of
 * the tree, are above it. */
ColourScale scaleOf(const GuideFigure& figure) {
  constexpr double COSINE = 1 / PI_D, QUANTILE = 0.995;
  ColourScale scale{0.01 * COSINE, COSINE, "per sr"};
  for (const PixelDirections& p : figure.pixels)
    for (const std::vector<double>& density : p.densities)
      scale.high = std::max(scale.high, quantileOf(density, QUANTILE));
  scale.isLogarithmic = true;
  return scale;
}

} // namespace

double PixelDirections::integral(Density density) const {
  return std::inner_product(solidAngles.begin(), solidAngles.end(), densities[density].begin(), 0.0);
}

GuideFigure guideFigure(const Scene& scene, Integrator& integrator,
                        const std::vector<std::array<int, 2>>& pixels, int stages, int64_t samples,
                        uint64_t seed, const std::atomic<bool>& stop) {
  requireVisiblePoints(scene);
  if (!integrator.learnsDirections()) throw Error("the figure needs an integrator that learns directions");
  const PathClasses classes;
  integrator.prepare(scene, classes);
  ForwardControl control;
  control.stop = &stop;
  Pass pass{seed, 0, integrator.passes(0).schedule()};
  integrator.forward(scene, classes, pass, control);
  pass.index = static_cast<uint32_t>(stages);
  GuideFigure figure;
  figure.guide = integrator.forward(scene, classes, pass, control).guide.value_or(GuideStatistics());
  for (const auto& [x, y] : pixels)
    if (!stop) figure.pixels.push_back(directionsAt(scene, integrator, x, y, samples, seed, stop));
  return figure;
}

std::vector<FigurePanel> guidePanels(const GuideFigure& figure) {
  constexpr int SCALE = 2; // pixels of a cell in a row
  constexpr int SIZE = SCALE * HemisphereDisc::CELLS;
  const ColourScale scale = scaleOf(figure);
  std::vector<FigurePanel> panels;
  for (size_t row = 0; row < figure.pixels.size(); ++row)
    for (int i = 0; i < PixelDirections::DENSITIES; ++i) {
      const PixelDirections& p = figure.pixels[row];
      Image image(SIZE, SIZE, {"R", "G", "B"});
      for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
          const size_t cell = size_t(y / SCALE) * HemisphereDisc::CELLS + size_t(x / SCALE);
          const Rgb colour = p.solidAngles[cell] > 0 ? scale.colour(p.densities[size_t(i)][cell]) : Rgb(1);
          for (int c = 0; c < 3; ++c) image.at(x, y)[c] = colour[c];
        }
      panels.push_back({std::move(image), panelName(p, PixelDirections::Density(i)), static_cast<int>(row),
                        static_cast<float>(i), 0, scale});
    }
  return panels;
}

} // namespace recurse
