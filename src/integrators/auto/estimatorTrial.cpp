/** @file
 * Trial samples of blocks, and their statistics.
 */
#include "integrators/auto/estimatorTrial.h"

#include <numeric>

#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

constexpr size_t BLOCK_PIXELS = size_t(EstimatorTrial::BLOCK) * EstimatorTrial::BLOCK;
constexpr size_t ALL_BLOCKS = size_t(EstimatorTrial::BLOCKS) * EstimatorTrial::BLOCKS;
static_assert(BLOCK_PIXELS <= CAMERA_BATCH);

} // namespace

TrialSamples EstimatorTrial::take(const Integrator& integrator, uint32_t round) const {
  const PixelBounds film = scene.film().whole();
  TrialSamples samples;
  samples.luminance.resize(PIXELS);
  std::vector<TransportCounts> counts(ALL_BLOCKS);
  parallelFor(ALL_BLOCKS, [&](size_t block) {
    Sampler placer(seed, block, 0); // block positions are equal in all rounds
    const Vec2f u = placer.next2D();
    const auto corner = [&](float first, int extent, size_t number, float shift) {
      return first + std::max(0.0f, static_cast<float>(extent) - BLOCK) *
                         (static_cast<float>(number) + shift) / static_cast<float>(BLOCKS);
    };
    const float x0 = corner(static_cast<float>(film.x0), film.width(), block % BLOCKS, u.x);
    const float y0 = corner(static_cast<float>(film.y0), film.height(), block / BLOCKS, u.y);
    std::vector<PathRadiance> radiance(BLOCK_PIXELS, PathRadiance(classes, counts[block]));
    std::vector<CameraPath> paths;
    std::array<float, BLOCK_PIXELS> weights{};
    paths.reserve(BLOCK_PIXELS);
    for (size_t i = 0; i < BLOCK_PIXELS; ++i) {
      CameraPath path(Sampler(seed, block * BLOCK_PIXELS + i, round + 1), radiance[i]);
      CameraSample sample{{x0 + static_cast<float>(i % BLOCK), y0 + static_cast<float>(i / BLOCK)}};
      sample.film += path.sampler.next2D();
      if (scene.camera().usesLens()) sample.lens = path.sampler.next2D();
      sample.time = time;
      const std::optional<CameraRay> ray = scene.camera().validRay(sample);
      if (!ray) continue;
      weights[i] = ray->weight;
      path.ray = *ray;
      paths.push_back(path);
    }
    if (!paths.empty()) integrator.backwardBatch(scene, paths);
    for (size_t i = 0; i < BLOCK_PIXELS; ++i)
      samples.luminance[block * BLOCK_PIXELS + i] = weights[i] * luminance(radiance[i].scattered());
  });
  for (const TransportCounts& c : counts) samples.counts.add(c);
  return samples;
}

void EstimatorTrial::Figures::add(double variance) {
  ofPixels += variance;
  ofBlocks += variance / BLOCK_PIXELS;
}

double EstimatorTrial::Figures::errorOver(const Figures& other) const {
  return work / other.work * std::sqrt(ofPixels / other.ofPixels * (ofBlocks / other.ofBlocks));
}

EstimatorTrial::Figures EstimatorTrial::figures(const Rounds& rounds, const Rounds& others) {
  // Work coefficients fitted to the processor times of sixteen scenes, for all to within a factor of 1.5.
  constexpr double BOUNDARY_RAY = 0.6, GATHER = 3, PHOTON = 0.02, SCATTERED = 0.09;
  constexpr double DARK = 0.01; // fraction of the image's mean square, below which errors are invisible
  std::vector<double> mean(ALL_BLOCKS);
  for (size_t i = 0; i < size_t(PIXELS); ++i)
    for (const Rounds* each : {&rounds, &others})
      for (const TrialSamples& samples : *each)
        mean[i / BLOCK_PIXELS] += double(samples.luminance[i]) / (4 * BLOCK_PIXELS);
  double all2 = 0;
  for (const double m : mean) all2 += square(m) / ALL_BLOCKS;
  Figures f;
  for (size_t block = 0; block < ALL_BLOCKS; ++block) {
    const auto scale = [&](double value) { return 1 / (2 * (square(value) + DARK * all2)); };
    if (!std::isfinite(scale(mean[block]))) continue; // black image
    double difference = 0;
    for (size_t i = block * BLOCK_PIXELS; i < (block + 1) * BLOCK_PIXELS; ++i) {
      const double d = double(rounds[0].luminance[i]) - double(rounds[1].luminance[i]);
      // Edges of bright objects are bright in all estimators.
      double found = 0;
      for (size_t round = 0; round < 2; ++round)
        found += double(std::min(rounds[round].luminance[i], others[round].luminance[i])) / 2;
      difference += d / BLOCK_PIXELS;
      f.ofPixels += square(d) * scale(std::max(mean[block], found)) / PIXELS;
    }
    f.ofBlocks += square(difference) * scale(mean[block]) / ALL_BLOCKS;
  }
  for (const TrialSamples& samples : rounds) {
    const TransportCounts& c = samples.counts;
    f.work += (double(c.rays - c.boundaryRays) + BOUNDARY_RAY * double(c.boundaryRays) +
               GATHER * double(c.gathers) + PHOTON * double(c.photonsFound) +
               SCATTERED * double(c.photonsScattered)) /
              (2 * PIXELS);
  }
  return f;
}

double EstimatorTrial::effectiveCount(const Rounds& rounds) {
  double sum = 0, squares = 0;
  for (const TrialSamples& samples : rounds)
    for (const float x : samples.luminance) {
      sum += double(x);
      squares += square(double(x));
    }
  return squares > 0 ? square(sum) / squares : 0;
}

double EstimatorTrial::missedVariance(const Rounds& rounds, const Rounds& others) {
  constexpr double SURE = 0.8; // fraction of the darker round of `others`, as both may be too bright
  const auto mean = [](const TrialSamples& samples) {
    return std::accumulate(samples.luminance.begin(), samples.luminance.end(), 0.0) / PIXELS;
  };
  const double there = std::min(mean(others[0]), mean(others[1]));
  const double missed = SURE * there - (mean(rounds[0]) + mean(rounds[1])) / 2;
  return missed > 0 ? 2 * PIXELS * square(missed / there) : 0;
}

} // namespace recurse
