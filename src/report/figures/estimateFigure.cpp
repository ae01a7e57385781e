/** @file
 * Layers of a photon radiance estimate. Bias and variance are those over independent photon maps.
 */
#include <algorithm>
#include <cmath>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/figures/figures.h"
#include "recurse/report/stills/stills.h"
#include "report/figures/visiblePoints.h"

namespace recurse {

namespace {

/** Light that photons carry to a non-delta surface, seen directly or through mirrors and glass. */
constexpr const char* ESTIMATED_PATHS = "L(S|D)*DS*E";
/** Part of the values that a scale covers; less for the bias, as path tracing has outliers. */
constexpr double SCALED_PART = 0.98, SCALED_BIAS = 0.9;

/** Supports of the estimates at the first points that pixels see, by pixel, summed over maps. */
struct EstimateSupports {
  std::vector<double> photons, radius, estimates;

  explicit EstimateSupports(size_t pixels) : photons(pixels), radius(pixels), estimates(pixels) {}
  void add(size_t pixel, const RecordedEstimate& e) {
    photons[pixel] += e.photons;
    radius[pixel] += double(e.radius);
    ++estimates[pixel];
  }
  bool hasPhotons() const {
    return std::any_of(photons.begin(), photons.end(), [](double n) { return n > 0; });
  }
  /** Mean of a sum for one estimate; NaN in pixels without any. */
  std::vector<double> mean(const std::vector<double>& sum) const {
    std::vector<double> out(sum.size());
    for (size_t p = 0; p < sum.size(); ++p) out[p] = sum[p] / estimates[p];
    return out;
  }
};

/** Sums of a pixel's radiance over independent estimates. */
struct EstimateSums {
  std::vector<Rgbd> sum;
  std::vector<double> luminance, squares;
  double count = 0; ///< estimates of each pixel

  explicit EstimateSums(size_t pixels) : sum(pixels, Rgbd(0)), luminance(pixels), squares(pixels) {}
  void add(size_t pixel, const Rgb& radiance) {
    sum[pixel] += Rgbd(radiance);
    const double y = double(recurse::luminance(radiance));
    luminance[pixel] += y;
    squares[pixel] += y * y;
  }
  double mean(size_t pixel) const { return luminance[pixel] / count; }
  /** Unbiased variance of one estimate. */
  double variance(size_t pixel) const {
    return std::max(0.0, (squares[pixel] - count * square(mean(pixel))) / (count - 1));
  }
  Image picture(const PixelBounds& crop) const {
    Image image(crop.width(), crop.height(), {"R", "G", "B"});
    for (size_t p = 0; p < sum.size(); ++p)
      for (int c = 0; c < 3; ++c) image.pixels[3 * p + size_t(c)] = static_cast<float>(sum[p][c] / count);
    return image;
  }
};

void shootFor(const Scene& scene, Integrator& integrator, const PathClasses& classes, uint64_t seed,
              const std::atomic<bool>& stop) {
  integrator.prepare(scene, classes);
  ForwardControl control;
  control.stop = &stop;
  integrator.forward(scene, classes, {.seed = seed, .time = scene.camera().timeAt(0.5f)}, control);
}

std::vector<double> finite(const std::vector<double>& values) {
  std::vector<double> out;
  std::copy_if(values.begin(), values.end(), std::back_inserter(out),
               [](double x) { return std::isfinite(x); });
  if (out.empty()) out.push_back(0);
  return out;
}

ColourScale scaleFrom0(const std::vector<double>& values, const char* unit) {
  return {0, quantileOf(finite(values), SCALED_PART), unit};
}

void addSupports(const PixelBounds& crop, const EstimateSupports& supports, const std::string& of,
                 std::vector<FigurePanel>& panels, int row, float column) {
  const std::vector<double> photons = supports.mean(supports.photons),
                            radius = supports.mean(supports.radius);
  panels.push_back(scaledPanel(crop, photons, scaleFrom0(photons, "photons"), "number" + of, row, column));
  panels.push_back(
      scaledPanel(crop, radius, scaleFrom0(radius, "scene units"), "radius" + of, row, column + 1));
}

/** Estimates by maps and by path tracing at the same points. */
struct EstimateData {
  const PixelBounds& crop;
  EstimateSums byMaps, byPaths;
  EstimateSupports supports, causticSupports;
  Image first; ///< estimate of the first map

  explicit EstimateData(const PixelBounds& crop)
      : crop(crop), byMaps(crop.area()), byPaths(crop.area()), supports(crop.area()),
        causticSupports(crop.area()) {}
};

void addMap(const Scene& scene, const PathClasses& classes, Integrator& photonMap, uint64_t seed,
            const std::atomic<bool>& stop, EstimateData& data) {
  shootFor(scene, photonMap, classes, seed, stop);
  visitMiddleRays(scene, stop, [&](size_t p, const CameraRay& ray) {
    Sampler sampler(seed, p, 0);
    TransportCounts counts;
    PathRadiance out(classes, counts);
    PathRecorder record;
    record.beginSample({});
    out.recorder = &record;
    photonMap.backward(scene, ray, sampler, out);
    data.byMaps.add(p, out.total());
    for (const RecordedEstimate& e : record.estimates())
      if (e.vertex == record.estimates().front().vertex)
        (e.caustic ? data.causticSupports : data.supports).add(p, e);
  });
  ++data.byMaps.count;
}

void addPaths(const Scene& scene, const PathClasses& classes, Integrator& path, int64_t samples,
              uint64_t seed, const std::atomic<bool>& stop, EstimateData& data) {
  shootFor(scene, path, classes, seed, stop);
  visitMiddleRays(scene, stop, [&](size_t p, const CameraRay& ray) {
    TransportCounts counts;
    PathRadiance out(classes, counts);
    for (int64_t i = 0; i < samples && !stop; ++i) {
      // Independent samples: the variance of stratified ones says nothing about the error of their mean.
      Sampler sampler(hashCombine(hashCombine(seed, p), uint64_t(i)), 0, 0);
      out.reset();
      path.backward(scene, ray, sampler, out);
      data.byPaths.add(p, out.total());
    }
  });
  data.byPaths.count = double(samples);
}

void addPictures(const EstimateData& data, std::vector<FigurePanel>& panels) {
  const Image reference = data.byPaths.picture(data.crop);
  const float exposure = automaticExposure(reference);
  panels.push_back({data.first, "one map", 0, 0, exposure});
  panels.push_back(
      {data.byMaps.picture(data.crop), formatted("mean of %g maps", data.byMaps.count), 0, 1, exposure});
  panels.push_back({reference, "path tracing", 0, 2, exposure});
}

/** Adds bias and standard deviation, relative to the mean luminance by path tracing. */
void addErrors(const EstimateData& data, double mean, EstimateFigure& figure) {
  const size_t pixels = data.crop.area();
  std::vector<double> bias(pixels), deviation(pixels), biasError(pixels), sizes;
  for (size_t p = 0; p < pixels; ++p) {
    const double variance = data.byMaps.variance(p) / square(mean);
    const double error2 =
        variance / data.byMaps.count + data.byPaths.variance(p) / square(mean) / data.byPaths.count;
    bias[p] = (data.byMaps.mean(p) - data.byPaths.mean(p)) / mean;
    deviation[p] = std::sqrt(variance);
    biasError[p] = std::sqrt(error2);
    sizes.push_back(std::abs(bias[p]));
    figure.squaredBias += (square(bias[p]) - error2) / double(pixels);
    figure.variance += variance / double(pixels);
  }
  figure.biasError = quantileOf(biasError, 0.5);
  const double largest = quantileOf(sizes, SCALED_BIAS);
  figure.panels.push_back(
      scaledPanel(data.crop, bias, {-largest, largest, "of the mean", true}, "bias", 1, 0));
  figure.panels.push_back(
      scaledPanel(data.crop, deviation, scaleFrom0(deviation, "of the mean"), "standard deviation", 1, 1));
  figure.panels.push_back(
      scaledPanel(data.crop, biasError, {0, largest, "of the mean"}, "standard error of the bias", 1, 2));
}

} // namespace

EstimateFigure estimateFigure(const Scene& scene, const EstimateMethods& methods, int maps,
                              int64_t referenceSamples, uint64_t seed, const std::atomic<bool>& stop) {
  if (scene.hasMedia()) throw Error("the figure cannot draw media such as those of the scene");
  const std::vector<PathClass> estimated = {{"estimate", ESTIMATED_PATHS}};
  const PathClasses classes(estimated);
  EstimateData data(scene.film().crop);
  for (int m = 0; m < maps && !stop; ++m) {
    addMap(scene, classes, *methods.photonMap(), hashCombine(seed, uint64_t(m)), stop, data);
    if (m == 0) data.first = data.byMaps.picture(data.crop);
  }
  addPaths(scene, classes, *methods.path(), referenceSamples, seed, stop, data);
  EstimateFigure figure;
  if (stop) return figure;
  double mean = 0;
  for (size_t p = 0; p < data.crop.area(); ++p) mean += data.byPaths.mean(p) / double(data.crop.area());
  if (!(mean > 0))
    throw Error("the figure needs light on surfaces that store photons; path tracing finds none");
  addPictures(data, figure.panels);
  addErrors(data, mean, figure);
  const bool hasCaustics = data.causticSupports.hasPhotons();
  addSupports(data.crop, data.supports, hasCaustics ? ", not caustic" : "", figure.panels, 2, 0);
  if (hasCaustics) addSupports(data.crop, data.causticSupports, ", caustic", figure.panels, 2, 2);
  return figure;
}

} // namespace recurse
