/** @file
 * Mechanisms of photonmap that a study disables: only the noise changes, not the mean.
 */
#include "rendering.h"
#include "roomWithHole.h"

#include "transport/direct/lightSampler.h"
#include "transport/learning/lightLearning.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Picture without the mechanism, with enough photons to learn from. */
Rendered without(const std::string& scene, const std::string& mechanism, int photons, int samples) {
  return renderText(scene, "sppm",
                    "\"integer photonsperiteration\" " + std::to_string(photons) + " \"string without\" \"" +
                        mechanism + "\"",
                    samples);
}

/** Expects the same mean without each of the mechanisms. */
void expectSameLight(const std::string& scene, const std::vector<std::string>& mechanisms, int photons,
                     int samples) {
  constexpr double BIAS = 0.01; // bias of density estimates
  const Rendered all = without(scene, "nothing", photons, samples);
  for (const std::string& mechanism : mechanisms) {
    const Rendered less = without(scene, mechanism, photons, samples);
    const double error = std::hypot(all.standardError(), less.standardError());
    EXPECT_NEAR(less.mean(), all.mean(), 4 * error + BIAS * all.mean()) << mechanism;
    EXPECT_NE(less.mean(), all.mean()) << mechanism << " did nothing";
  }
}

} // namespace

TEST(Mechanisms, ARoomWithGlassAndAMirrorHasTheSameLightWithoutThem) {
  expectSameLight(glassAndMirrorBox(12), {"judgedradii", "mergeweights"}, 4096, 16);
}

TEST(Mechanisms, ARoomLitThroughAHoleHasTheSameLightWithoutThem) {
  expectSameLight(roomWithHole(12), {"splitting"}, 16384, 2);
}

TEST(Mechanisms, OpeningsForShadowRaysAreNotLookedForWhereTheyAreLeftOut) {
  const auto scene = sceneFrom(roomWithHole(12));
  LightSampler lights;
  EXPECT_GT(learnLights(*scene, lights).rays, 0u);
  EXPECT_EQ(learnLights(*scene, lights, false).rays, 0u); // nothing to learn with a single light
}
