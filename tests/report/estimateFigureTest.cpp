/** @file
 * Layers of photon estimates: bias and variance for an estimator with known values, and for a map at an edge.
 */
#include <gtest/gtest.h>

#include "recurse/report/figures/figures.h"
#include "sceneRendering.h"

namespace recurse {
namespace {

using namespace recurse::testing;

constexpr double ESTIMATE_TRUTH = 2, ESTIMATE_BIAS = 0.3, ESTIMATE_DEVIATION = 0.5;

/** Estimator with the values ESTIMATE_TRUTH plus `bias` plus or minus `deviation`, from 7 photons within
 * .25. */
class KnownEstimator final : public Integrator {
 public:
  KnownEstimator(double bias, double deviation) : bias(bias), deviation(deviation) {}
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    Hit hit;
    if (!scene.intersect(ray, hit)) return;
    if (out.recorder) {
      out.recorder->beginEstimate(
          out.recorder->addVertex(CAMERA_STEP, hit, ray.direction, REFLECTION, Rgb(1)), false);
      out.recorder->endEstimate(0.25f, 7);
    }
    const double sign = sampler.next1D() < 0.5f ? -1 : 1;
    const PathClasses& classes = out.pathClasses();
    out.add(classes.lightStart(), classes.step(classes.cameraStart(), PathEvent::D),
            Rgb(static_cast<float>(ESTIMATE_TRUTH + bias + sign * deviation)));
  }
  std::vector<EstimatorDomain> domains() const override { return {}; }

 private:
  double bias, deviation;
};

std::string plate(int size, const std::string& light, double fov) {
  return view(size, size, "0 4 0  0 0 0  0 0 1", perspective(fov)) + light +
         "\nMaterial \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\nShape \"bilinearmesh\" \"point3 P\" [ -1 "
         "0 -1  "
         "-1 0 1  1 0 -1  1 0 1 ]\n";
}

const std::string DISTANT = "LightSource \"distant\" \"point3 from\" [ 0 1 0 ] \"point3 to\" [ 0 0 0 ]";

EstimateFigure knownFigure(int maps, int64_t samples, double bias = ESTIMATE_BIAS) {
  const auto scene = sceneFrom(plate(8, DISTANT, 10));
  const std::atomic<bool> stop{false};
  return estimateFigure(*scene,
                        {[bias] { return std::make_unique<KnownEstimator>(bias, ESTIMATE_DEVIATION); },
                         [] { return std::make_unique<KnownEstimator>(0, ESTIMATE_DEVIATION); }},
                        maps, samples, 1, stop);
}

const FigurePanel& panelOf(const EstimateFigure& figure, const std::string& name) {
  for (const FigurePanel& panel : figure.panels)
    if (panel.name == name) return panel;
  throw Error("no panel " + name);
}

TEST(EstimateFigure, KnownBiasAndVarianceAreFound) {
  const int maps = 200;
  const int64_t samples = 300;
  const EstimateFigure figure = knownFigure(maps, samples);
  const double bias = ESTIMATE_BIAS / ESTIMATE_TRUTH, variance = square(ESTIMATE_DEVIATION / ESTIMATE_TRUTH);
  EXPECT_NEAR(figure.variance, variance, 0.02 * variance);
  EXPECT_NEAR(figure.squaredBias, square(bias), 0.06 * square(bias));
  const double error = std::sqrt(variance * (1.0 / maps + 1.0 / double(samples)));
  EXPECT_NEAR(figure.biasError, error, 0.03 * error);
}

TEST(EstimateFigure, SquaredBiasIsWithoutItsNoise) {
  // Without bias and with few maps, the mean square of the measured bias is only noise.
  const double variance = square(ESTIMATE_DEVIATION / ESTIMATE_TRUTH),
               noise = variance * (1.0 / 10 + 1.0 / 100);
  EXPECT_NEAR(knownFigure(10, 100, 0).squaredBias, 0, 0.6 * noise);
}

TEST(EstimateFigure, VarianceOfFewMapsIsNotTooSmall) {
  const double variance = square(ESTIMATE_DEVIATION / ESTIMATE_TRUTH);
  EXPECT_NEAR(knownFigure(2, 10).variance, variance, 0.3 * variance);
}

TEST(EstimateFigure, PanelsHaveTheSupportsOfTheEstimates) {
  const EstimateFigure figure = knownFigure(4, 4);
  EXPECT_DOUBLE_EQ(panelOf(figure, "number").scale->high, 7);
  EXPECT_DOUBLE_EQ(panelOf(figure, "radius").scale->high, 0.25);
  EXPECT_EQ(panelOf(figure, "number").image.rgb(3, 3), panelOf(figure, "number").scale->colour(7));
  const ColourScale& bias = *panelOf(figure, "bias").scale;
  EXPECT_TRUE(bias.diverging);
  EXPECT_EQ(bias.low, -bias.high);
}

TEST(EstimateFigure, ZeroIsNeutralAlsoOnAScaleWithoutExtent) {
  const ColourScale empty{0, 0, "", true, false}, wide{-1, 1, "", true, false};
  EXPECT_EQ(empty.colour(0), wide.colour(0));
}

std::unique_ptr<Integrator> oneMapOf(const std::string& parameters) {
  return integratorFrom("photonmap",
                        "\"integer passes\" 1 \"integer finalgather\" 0 \"string direct\" \"photons\" "
                        "\"integer photons\" 4000 \"float radius\" .2 " +
                            parameters);
}

/** Mean bias of the pixels of the middle row, at the left edge of the plate and in the middle. */
std::array<double, 2> edgeAndMiddle(const std::string& parameters) {
  const auto scene = sceneFrom(plate(21, DISTANT, 2 * std::atan(1.0 / 4) * 180 / PI_D));
  const std::atomic<bool> stop{false};
  const EstimateFigure figure = estimateFigure(
      *scene, {[&] { return oneMapOf(parameters); }, [] { return integratorFrom("path", ""); }}, 24, 4, 1,
      stop);
  const Image &mean = figure.panels[1].image, &truth = figure.panels[2].image;
  const auto ratio = [&](int x) {
    double sum = 0;
    for (int y = 8; y < 13; ++y) sum += double(mean.rgb(x, y).g / truth.rgb(x, y).g) / 5;
    return sum;
  };
  return {ratio(0), ratio(10)};
}

TEST(EstimateFigure, AnEdgeIsDarkWithoutBoundaryCorrection) {
  // The centre of the outermost pixel is 1/21 from the edge: t = .238 of the radius. The fraction of the
  // kernel's integral on the plate is 1/2 + (2/π) ∫_0^t (4/3)(1 - u²)^(3/2) du.
  const double t = (1.0 / 21) / 0.2;
  double inside = 0.5;
  for (int i = 0; i < 1000; ++i)
    inside += 2 / PI_D * 4 / 3 * std::pow(1 - square((i + .5) / 1000 * t), 1.5) * t / 1000;
  const auto [edge, middle] = edgeAndMiddle("\"bool edges\" false");
  EXPECT_NEAR(middle, 1, 0.03);
  EXPECT_NEAR(edge, inside, 0.04);
  const auto [corrected, correctedMiddle] = edgeAndMiddle("");
  EXPECT_NEAR(corrected, 1, 0.04);
  EXPECT_NEAR(correctedMiddle, 1, 0.03);
}

TEST(EstimateFigure, BlackScenesAreAnErrorWithTheReason) {
  const auto scene = sceneFrom(plate(4, "", 10));
  const std::atomic<bool> stop{false};
  EXPECT_THROW(estimateFigure(*scene,
                              {[] { return oneMapOf(""); }, [] { return integratorFrom("path", ""); }}, 2, 2,
                              1, stop),
               Error);
}

} // namespace
} // namespace recurse
