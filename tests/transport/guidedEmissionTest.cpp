/** @file
 * Guided photons: pictures against pictures without guidance.
 */
#include "transport/emission/visibleRegion.h"
#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Closed rooms in a row, each with a lamp; the camera is in the first one. */
std::string rooms(int count) {
  std::string s = view(16, ".1 .5 .5  1 .5 .2  0 0 1", 70);
  for (int i = 0; i < count; ++i) {
    s += "AttributeBegin Translate " + std::to_string(i * 1.5) + " 0 0\n" + R"(
      Material "diffuse" "rgb reflectance" [.6 .6 .6]
      Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] Shape "bilinearmesh" "point3 P" [0 0 1 1 0 1 0 1 1 1 1 1]
      Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 0 1 1 0 1] Shape "bilinearmesh" "point3 P" [0 1 0 1 1 0 0 1 1 1 1 1]
      Shape "bilinearmesh" "point3 P" [0 0 0 0 1 0 0 0 1 0 1 1] Shape "bilinearmesh" "point3 P" [1 0 0 1 1 0 1 0 1 1 1 1]
      AttributeBegin Material "dielectric" Translate .7 .4 .25 Shape "sphere" "float radius" .15 AttributeEnd
      AreaLightSource "diffuse" "rgb L" [5 5 5]
      Shape "bilinearmesh" "point3 P" [.4 .4 .98  .4 .6 .98  .6 .4 .98  .6 .6 .98]
    AttributeEnd
    )";
  }
  return s;
}

} // namespace

TEST(GuidedEmission, VisibleRegionHoldsWhatIsNear) {
  VisibleRegion region;
  region.add({1, 2, 3}, 0.01f);
  region.add({-1e4f, 5, 0}, 7);
  EXPECT_TRUE(region.contains({1, 2, 3}));
  EXPECT_TRUE(region.contains({1.0099f, 1.9901f, 3.0099f}));
  EXPECT_FALSE(region.contains({1.1f, 2, 3}));
  EXPECT_TRUE(region.contains({-1e4f + 6, 0, -6}));
  EXPECT_FALSE(region.contains({-1e4f + 60, 0, 0}));
}

namespace {

/** Mean of the picture and mean variance of its pixels over several runs, without and with a guide. */
struct Compared {
  double mean[2] = {}, variance[2] = {};
  double samples = 0; ///< number of pixels of all runs
};
Compared compareGuided(const Scene& scene, const std::string& parameters,
                       const char* integrator = "photonmap") {
  const int runs = SANITIZED ? 3 : 6;
  Compared result;
  for (const size_t guided : {0, 1}) {
    std::vector<Rendered> pictures;
    for (int i = 0; i < runs; ++i)
      pictures.push_back(renderScene(
          scene, integrator, parameters + (guided ? " \"bool guided\" true" : " \"bool guided\" false"), 2,
          uint64_t(i)));
    for (const Rendered& p : pictures) result.mean[guided] += p.mean() / runs;
    result.samples = double(pictures[0].pixels()) * runs;
    for (size_t pixel = 0; pixel < pictures[0].pixels(); ++pixel) {
      double sum = 0, squares = 0;
      for (const Rendered& p : pictures) {
        const double y = double(luminance(p.value(pixel)));
        sum += y / runs;
        squares += y * y / runs;
      }
      result.variance[guided] += (squares - sum * sum) * runs / (runs - 1) / double(pictures[0].pixels());
    }
  }
  return result;
}

} // namespace

TEST(GuidedEmission, ManyLampsInOtherRooms) {
  const auto scene = sceneFrom(rooms(60));
  const Compared c = compareGuided(
      *scene,
      "\"string direct\" \"photons\" \"integer photons\" 30000 \"integer passes\" 2 \"float radius\" .08");
  // One photon in sixty contributes: the mean is the same, and the variance is at most a tenth.
  EXPECT_NEAR(c.mean[1] / c.mean[0], 1, 0.03);
  EXPECT_LT(c.variance[1], c.variance[0] / 10);
}

TEST(GuidedEmission, BidirectionalPathsFromLampsInOtherRooms) {
  const auto scene = sceneFrom(rooms(60));
  for (const char* integrator : {"bdpt", "vcm"}) {
    const Compared c = compareGuided(*scene, "\"integer maxdepth\" 8", integrator);
    EXPECT_NEAR(c.mean[1], c.mean[0], 5 * std::sqrt((c.variance[0] + c.variance[1]) / c.samples))
        << integrator;
    EXPECT_LT(c.variance[1], c.variance[0] / 2) << integrator;
  }
}

TEST(GuidedEmission, ASphericalLampShinesAtASmallBallOfGlass) {
  const auto scene = sceneFrom(view(16, "0 -1.5 .8  0 0 .1  0 0 1", 30) + R"(
    AttributeBegin
    AreaLightSource "diffuse" "rgb L" [600 600 600]
    Translate .8 .9 1.8
    Shape "sphere" "float radius" .015
    AttributeEnd
    Material "diffuse"
    Shape "bilinearmesh" "point3 P" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]
    Material "dielectric"
    Translate 0 0 .1
    Shape "sphere" "float radius" .06
  )");
  ASSERT_TRUE(scene);
  const auto stored = [&](const std::string& guided) {
    return renderScene(*scene, "photonmap", "\"bool guided\" " + guided, 2).statistics.photonsStored;
  };
  EXPECT_GT(stored("true"), 8 * stored("false"));
}

/** Light on a small table arrives from distant walls: the start of a photon says little about whether it
 * arrives. */
TEST(GuidedEmission, SmallTableInALargeHall) {
  std::string text = view(16, "0 -.3 2.2  0 0 .8  0 0 1", 40) + R"(
    Material "diffuse" "rgb reflectance" [.6 .6 .6]
    Shape "bilinearmesh" "point3 P" [-9 -7 0 9 -7 0 -9 7 0 9 7 0] Shape "bilinearmesh" "point3 P" [-9 -7 6 9 -7 6 -9 7 6 9 7 6]
    Shape "bilinearmesh" "point3 P" [-9 -7 0 9 -7 0 -9 -7 6 9 -7 6] Shape "bilinearmesh" "point3 P" [-9 7 0 9 7 0 -9 7 6 9 7 6]
    Shape "bilinearmesh" "point3 P" [-9 -7 0 -9 7 0 -9 -7 6 -9 7 6] Shape "bilinearmesh" "point3 P" [9 -7 0 9 7 0 9 -7 6 9 7 6]
    Shape "bilinearmesh" "point3 P" [-1 -1 .8 1 -1 .8 -1 1 .8 1 1 .8]
  )";
  for (int i = 0; i < 4; ++i)
    text += "LightSource \"spot\" \"point3 from\" [" + std::to_string(4 * i - 6) + " 2 5] \"point3 to\" [" +
            std::to_string(6 * i - 9) + " 0 9] \"rgb I\" [90 80 70] \"float coneangle\" 60\n";
  const auto scene = sceneFrom(text);
  // Few photons reach the table, and the guide learns little from them: the estimate must not be biased.
  std::vector<double> means;
  for (uint64_t seed = 1; seed <= 4; ++seed)
    means.push_back(renderScene(*scene, "photonmap", "", SANITIZED ? 4 : 32, seed).mean());
  const Mean found(means);
  const Rendered truth = renderScene(*scene, "path", "", SANITIZED ? 256 : 1024);
  EXPECT_NEAR(found.value, truth.mean(),
              0.02 * truth.mean() + 4 * std::hypot(found.error, truth.standardError()));
  EXPECT_LT(4 * found.error, 0.1 * truth.mean());
}

TEST(GuidedEmission, ABallOfMilkInAWideHall) {
  // A few in a thousand of the lamp's photons enter the milk, and cause blotches there.
  constexpr size_t SIZE = 16, BLOCK = 4;
  const auto scene = sceneFrom(view(SIZE, "0 -2 .9  0 0 .3  0 0 1", 20) + R"(
    MakeNamedMedium "milk" "string type" "homogeneous" "rgb sigma_a" [.5 .5 .5] "rgb sigma_s" [9 9 9]
    LightSource "point" "point3 from" [0 -1 3] "rgb I" [10 10 10]
    Material "diffuse" "rgb reflectance" [.2 .2 .2]
    Shape "bilinearmesh" "point3 P" [-8 -8 0 8 -8 0 -8 8 0 8 8 0]
    MediumInterface "milk" ""
    Material "interface"
    Translate 0 0 .32
    Shape "sphere" "float radius" .3
  )");
  const Rendered truth = renderScene(*scene, "path", "", SANITIZED ? 512 : 4096);
  const auto error = [&](const std::string& guided) {
    const Rendered r = renderScene(*scene, "photonmap",
                                   "\"integer photons\" 30000 \"integer passes\" 0 \"bool guided\" " + guided,
                                   SANITIZED ? 8 : 32);
    double sum = 0;
    for (size_t y = 0; y < SIZE; y += BLOCK)
      for (size_t x = 0; x < SIZE; x += BLOCK) {
        double difference = 0;
        for (size_t i = 0; i < BLOCK * BLOCK; ++i) {
          const size_t pixel = (y + i / BLOCK) * SIZE + x + i % BLOCK;
          difference += double(luminance(r.value(pixel)) - luminance(truth.value(pixel)));
        }
        sum += difference * difference;
      }
    return sum;
  };
  const double guided = error("true"), plain = error("false");
  EXPECT_LT(guided, plain / 3);
}

TEST(GuidedEmission, WhereAllPhotonsCountNothingChanges) {
  const auto scene = sceneFrom(rooms(1));
  const auto picture = [&](const char* guided) {
    return renderScene(
        *scene, "photonmap",
        std::string("\"integer passes\" 1 \"integer photons\" 20000 \"bool guided\" ") + guided, 2);
  };
  const Rendered a = picture("true"), b = picture("false");
  for (size_t i = 0; i < a.pixels(); ++i) ASSERT_EQ(a.value(i), b.value(i));
}
