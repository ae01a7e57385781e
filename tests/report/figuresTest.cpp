/** @file
 * Figures: their pictures add up to the render, and each technique alone estimates the same light.
 */
#include <gtest/gtest.h>

#include "recurse/report/figures/figures.h"
#include "sceneRendering.h"

namespace recurse {
namespace {

using namespace recurse::testing;

constexpr int FIGURE_SIZE = 8, FIGURE_SAMPLES = 256;

RenderSettings figureSettings(int samples = FIGURE_SAMPLES) {
  RenderSettings settings;
  settings.samplesPerPixel = samples;
  settings.seed = 3;
  return settings;
}

/** Two opposite matt walls below a large lamp: every strategy finds their light well, and points of different
 * surfaces are never close. */
std::string mattWalls() {
  return view(FIGURE_SIZE, FIGURE_SIZE, "0 0 3.9  0 0 0  0 1 0", perspective(35)) + R"(
Material "diffuse" "rgb reflectance" [ .7 .5 .3 ]
Shape "bilinearmesh" "point3 P" [ -1 -1 -1  -1 1 -1  -1 -1 1  -1 1 1 ]
Shape "bilinearmesh" "point3 P" [ 1 -1 -1  1 -1 1  1 1 -1  1 1 1 ]
AreaLightSource "diffuse" "rgb L" [ 4 4 4 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "bilinearmesh" "point3 P" [ -.6 1.2 -1  .6 1.2 -1  -.6 1.2 1  .6 1.2 1 ]
)";
}

double meanOf(const Image& image) {
  double sum = 0;
  for (const float x : image.pixels) sum += double(x);
  return sum / double(image.pixels.size());
}

double meanOf(const Image& image, int channel) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += double(image.at(x, y)[channel]);
  return sum / double(image.width * image.height);
}

std::vector<StrategyPictures> strategiesOf(const Scene& scene, int longest, int samples = FIGURE_SAMPLES) {
  const std::atomic<bool> stop{false};
  return strategyPictures(scene, *integratorFrom("bdpt", ""), *integratorFrom("lightpath", ""),
                          figureSettings(samples), longest, stop);
}

/** Expects that the weighted pictures of each number of edges add up to the render of these paths. */
void expectLengthsAddUp(const Scene& scene, int longest, int samples) {
  const auto strategies = strategiesOf(scene, longest, samples);
  std::vector<PathClass> lengths;
  for (int edges = 2; edges <= longest; ++edges)
    lengths.push_back({std::to_string(edges), "L(S|D|V){" + std::to_string(edges - 1) + "}E"});
  const Rendered whole = renderScene(scene, *integratorFrom("bdpt", ""), PathClasses(lengths), samples, 3);
  const std::vector<double> means = whole.layerMeans();
  for (int edges = 2; edges <= longest; ++edges) {
    SCOPED_TRACE(edges);
    for (size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (const StrategyPictures& p : strategies)
        if (p.lightVertices + p.cameraVertices - 1 == edges) sum += meanOf(p.weighted, int(c));
      const double expected = means[3 * size_t(edges - 2) + c];
      EXPECT_NEAR(sum, expected, 1e-4 * expected);
      EXPECT_GT(expected, 0);
    }
  }
}

TEST(StrategyPictures, WeightedPicturesOfALengthAddUpToItsRender) {
  expectLengthsAddUp(*sceneFrom(mattWalls()), 4, 4);
}

TEST(StrategyPictures, LightThroughAPaneIsInTheRowOfItsEdges) {
  const std::string pane =
      "Material \"thindielectric\"\n"
      "Shape \"bilinearmesh\" \"point3 P\" [ -.9 1 -1.2  .9 1 -1.2  -.9 1 1.2  .9 1 1.2 ]\n";
  expectLengthsAddUp(*sceneFrom(mattWalls() + pane), 4, 16);
}

/** The scene with a white balance of its film. */
std::string withWhiteBalance(std::string scene) {
  return scene.insert(scene.find("\"integer xresolution\""), "\"float whitebalance\" 4000 ");
}

TEST(StrategyPictures, HaveTheWhiteBalanceOfTheFilm) {
  expectLengthsAddUp(*sceneFrom(withWhiteBalance(mattWalls())), 3, 4);
}

TEST(StrategyPictures, EachStrategyAloneEstimatesTheSameLight) {
  const auto scene = sceneFrom(mattWalls());
  const auto strategies = strategiesOf(*scene, 3);
  ASSERT_EQ(strategies.size(), 3u + 4u);
  for (const StrategyPictures& p : strategies) {
    const int edges = p.lightVertices + p.cameraVertices - 1;
    double sum = 0;
    for (const StrategyPictures& other : strategies)
      if (other.lightVertices + other.cameraVertices - 1 == edges) sum += meanOf(other.weighted);
    if (p.cameraVertices == 0) {
      EXPECT_EQ(meanOf(p.unweighted), 0); // no ray of light hits the camera
      continue;
    }
    EXPECT_NEAR(meanOf(p.unweighted), sum, 0.1 * sum) << "s=" << p.lightVertices << " t=" << p.cameraVertices;
    EXPECT_LT(meanOf(p.weighted), sum);
    EXPECT_GT(meanOf(p.weighted), 0);
  }
}

TEST(PyramidPanels, HaveARowForEachLength) {
  const auto scene = sceneFrom(mattWalls());
  const std::vector<FigurePanel> panels = pyramidPanels(strategiesOf(*scene, 3, 1), true);
  ASSERT_EQ(panels.size(), 7u);
  EXPECT_EQ(panels[0].row, 0);
  EXPECT_EQ(panels[0].column, 0.5f);
  EXPECT_EQ(panels[0].name, "s=0 t=3");
  EXPECT_EQ(panels[3].row, 1);
  EXPECT_EQ(panels[3].column, 0);
  EXPECT_EQ(panels[6].name, "s=3 t=1");
  EXPECT_EQ(panels[0].exposure, panels[2].exposure);
  const FigureDrawing sheet = figureSheet("title", "", panels);
  EXPECT_GE(sheet.width, 4 * FIGURE_SIZE);
  EXPECT_GE(sheet.height, 2 * FIGURE_SIZE);
}

TEST(MisPanels, BothTechniquesAloneAndTogetherEstimateTheSameLight) {
  const auto scene = sceneFrom(mattWalls());
  const std::atomic<bool> stop{false};
  const auto panels = misPanels(*scene, *integratorFrom("path", ""), figureSettings(), stop);
  ASSERT_EQ(panels.size(), 5u);
  const double both = meanOf(panels[4].image);
  EXPECT_NEAR(meanOf(panels[2].image) + meanOf(panels[3].image), both, 1e-4 * both);
  EXPECT_NEAR(meanOf(panels[0].image), meanOf(panels[1].image), 0.1 * both);
  const Rendered whole = renderScene(*scene, *integratorFrom("path", ""), PathClasses(), FIGURE_SAMPLES, 3);
  double expected = 0;
  for (size_t i = 0; i < whole.pixels(); ++i)
    for (int c = 0; c < 3; ++c) expected += double(whole.value(i)[c]) / double(3 * whole.pixels());
  EXPECT_NEAR(both, expected, 1e-4 * expected);
}

TEST(MisPanels, HaveTheWhiteBalanceOfTheFilm) {
  const auto scene = sceneFrom(withWhiteBalance(mattWalls()));
  const std::atomic<bool> stop{false};
  const auto panels = misPanels(*scene, *integratorFrom("path", ""), figureSettings(4), stop);
  const std::vector<double> means =
      renderScene(*scene, *integratorFrom("path", ""), PathClasses(), 4, 3).layerMeans();
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(meanOf(panels.back().image, c), means[size_t(c)], 1e-4 * means[size_t(c)]);
}

TEST(CostPanels, AreOfOneSampleWherePassesNeedMoreThanWanted) {
  const auto scene = sceneFrom(mattWalls());
  const std::atomic<bool> stop{false};
  const auto rays = [&](int samples) {
    const auto integrator = integratorFrom("photonmap", "\"integer photons\" 2000 \"integer passes\" 16");
    return costPanels(*scene, *integrator, figureSettings(samples), stop)[0].name;
  };
  EXPECT_EQ(rays(4), rays(16));
}

TEST(CostPanels, ShowPhotonsOnlyWhereThereAreSome) {
  const auto scene = sceneFrom(mattWalls());
  const std::atomic<bool> stop{false};
  const auto panelsOf = [&](const char* integrator, const char* parameters) {
    return costPanels(*scene, *integratorFrom(integrator, parameters), figureSettings(2), stop);
  };
  const auto byPaths = panelsOf("path", "");
  ASSERT_EQ(byPaths.size(), 2u);
  EXPECT_NE(byPaths[0].name.find(" rays"), std::string::npos);
  EXPECT_NE(byPaths[1].name.find(" us"), std::string::npos);
  const auto byPhotons = panelsOf("simplephotonmap", "\"integer photons\" 2000");
  ASSERT_EQ(byPhotons.size(), 3u);
  EXPECT_NE(byPhotons[1].name.find(" photons"), std::string::npos);
  EXPECT_NE(meanOf(byPhotons[0].image), 0);
}

} // namespace
} // namespace recurse
