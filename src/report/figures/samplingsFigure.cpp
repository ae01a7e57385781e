/** @file
 * Samplings of direct light side by side, and their errors by number of samples.
 */
#include <algorithm>
#include <array>
#include <cmath>

#include "recurse/core/io/text.h"
#include "recurse/report/figures/figures.h"
#include "recurse/report/stills/stills.h"
#include "report/figures/directSampling.h"

namespace recurse {

namespace {

/** Samples of the reference over samples of the pictures. */
constexpr int64_t REFERENCE_SAMPLES = 8;
/** Stream of the reference, after those of the samplings. */
constexpr uint64_t REFERENCE_STREAM = DIRECT_SAMPLINGS;

const std::array<Rgb, DIRECT_SAMPLINGS> CURVE_COLOURS = {Rgb(0.55f, 0.03f, 0.02f), Rgb(0.85f, 0.32f, 0.01f),
                                                         Rgb(0.02f, 0.30f, 0.06f), Rgb(0.02f, 0.12f, 0.60f),
                                                         Rgb(0.01f)};

/** Numbers of samples at which the error is measured: powers of two, and the last. */
std::vector<int64_t> checkpointsUpTo(int64_t samples) {
  std::vector<int64_t> out;
  for (int64_t n = 1; n < samples; n *= 2) out.push_back(n);
  out.push_back(samples);
  return out;
}

/** Sums over the pixels of a row; added in the order of rows, for any number of threads the same. */
struct RowErrors {
  std::array<std::vector<double>, DIRECT_SAMPLINGS> squares; ///< by sampling and checkpoint
  double reference = 0;                                      ///< sum of luminances
  double referenceVariance = 0;                              ///< sum of the variances of their means
};

/** Estimates of one pixel. */
class PixelSamplings {
 public:
  PixelSamplings(const Scene& scene, const PixelView& view, uint64_t seed, const std::atomic<bool>& stop)
      : scene(scene), view(view), seed(seed), stop(stop) {}

  /** Mean of the samples of a stream; of no use once stopped. Calls use(n, mean) after each sample. */
  template <class Use>
  Rgb mean(DirectSampling sampling, uint64_t stream, int64_t samples, const Use& use) const {
    Rgbd sum(0);
    for (int64_t i = 0; i < samples && !stop; ++i) {
      // Independent samples: those of one stream are stratified, and their error falls faster.
      Sampler sampler(hashCombine(hashCombine(seed, stream), uint64_t(i)), 0, 0);
      Rgb light = BLACK;
      for (const ViewedPoint& point : view.points)
        light += sampleDirectLight(scene, point, sampling, sampler);
      sum += Rgbd(light);
      use(i + 1, light, Rgb(sum / double(i + 1)));
    }
    return Rgb(sum / double(samples));
  }

 private:
  const Scene& scene;
  const PixelView& view;
  uint64_t seed;
  const std::atomic<bool>& stop;
};

/** Adds a pixel to the sums of its row, and returns its means by sampling. */
std::array<Rgb, DIRECT_SAMPLINGS> addPixel(const PixelSamplings& pixel, int64_t samples,
                                           const std::vector<int64_t>& checkpoints, RowErrors& row) {
  const int64_t count = REFERENCE_SAMPLES * samples;
  double squares = 0;
  const auto addSquare = [&](int64_t, const Rgb& light, const Rgb&) {
    squares += square(double(luminance(light)));
  };
  const double reference =
      double(luminance(pixel.mean(DirectSampling::COMBINED, REFERENCE_STREAM, count, addSquare)));
  row.reference += reference;
  row.referenceVariance += std::max(0.0, squares / double(count) - square(reference)) / double(count - 1);
  std::array<Rgb, DIRECT_SAMPLINGS> means;
  for (size_t s = 0; s < DIRECT_SAMPLINGS; ++s) {
    size_t next = 0;
    means[s] = pixel.mean(DirectSampling(s), s, samples, [&](int64_t n, const Rgb&, const Rgb& mean) {
      if (n == checkpoints[next]) row.squares[s][next++] += square(double(luminance(mean)) - reference);
    });
  }
  return means;
}

} // namespace

SamplingsFigure samplingsFigure(const Scene& scene, int64_t samples, uint64_t seed,
                                const std::atomic<bool>& stop) {
  requireVisiblePoints(scene);
  const PixelBounds& crop = scene.film().crop;
  const std::vector<int64_t> checkpoints = checkpointsUpTo(samples);
  RowErrors empty;
  empty.squares.fill(std::vector<double>(checkpoints.size()));
  std::vector<RowErrors> rows(size_t(crop.height()), empty);
  std::vector<Image> pictures(DIRECT_SAMPLINGS, Image(crop.width(), crop.height(), {"R", "G", "B"}));
  visitViews(scene, stop, [&](size_t p, const PixelView& view) {
    const auto means = addPixel(PixelSamplings(scene, view, hashCombine(seed, p), stop), samples, checkpoints,
                                rows[p / size_t(crop.width())]);
    for (size_t s = 0; s < DIRECT_SAMPLINGS; ++s)
      for (size_t c = 0; c < 3; ++c) pictures[s].pixels[3 * p + c] = view.emission[int(c)] + means[s][int(c)];
  });
  RowErrors sum = empty;
  for (const RowErrors& row : rows) {
    sum.reference += row.reference;
    sum.referenceVariance += row.referenceVariance;
    for (size_t s = 0; s < DIRECT_SAMPLINGS; ++s)
      for (size_t i = 0; i < checkpoints.size(); ++i) sum.squares[s][i] += row.squares[s][i];
  }
  SamplingsFigure figure;
  figure.plot = {"", "samples of a pixel, one ray each", "RMS error / mean", {}, -0.5};
  const float exposure = automaticExposure(pictures[size_t(DirectSampling::COMBINED)]);
  for (size_t s = 0; s < DIRECT_SAMPLINGS; ++s) {
    const std::string name = directSamplingName(DirectSampling(s));
    FigureCurve curve{name, CURVE_COLOURS[s], {}};
    for (size_t i = 0; i < checkpoints.size(); ++i) {
      // The error of the reference is independent of the picture's.
      const double squares = std::max(0.0, sum.squares[s][i] - sum.referenceVariance);
      const double pixels = double(crop.area());
      curve.points.emplace_back(double(checkpoints[i]),
                                sum.reference > 0 ? std::sqrt(squares / pixels) / (sum.reference / pixels)
                                                  : 0);
    }
    figure.panels.push_back({std::move(pictures[s]), name + formatted(", error %.2g", curve.points.back().y),
                             0, static_cast<float>(s), exposure});
    figure.plot.curves.push_back(std::move(curve));
  }
  return figure;
}

} // namespace recurse
