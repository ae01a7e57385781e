/** @file
 * Records of light paths: complete paths of the pass that made the map, in order, and recording changes no
 * result.
 */
#include "rendering.h"

#include <algorithm>
#include <map>

#include "recurse/pathclasses/pathExpression.h"
#include "recurse/render/recordPixels.h"

namespace recurse {
namespace {

using namespace recurse::testing;

constexpr int LIGHT_PATH_SIZE = 12;
constexpr uint64_t ALL_LIGHT_PATHS = 1000000;

/** Integrators that trace light paths and store their vertices. */
std::vector<Way> lightPathWays() {
  return {{"photonmap", "\"integer photons\" 1500"},
          {"photonmap", "\"integer photons\" 1500 \"integer passes\" 1"},
          {"photonmap", "\"integer photons\" 1500 \"bool causticsonly\" true"},
          {"simplephotonmap", "\"integer photons\" 1500"},
          {"vpl", "\"integer lightpaths\" 100"},
          {"bdpt", ""},
          {"vcm", ""}};
}

struct RecordedPass {
  std::unique_ptr<Scene> scene = sceneFrom(glassAndMirrorBox(LIGHT_PATH_SIZE, 1.2));
  PathClasses classes{defaultStillClasses()};
  std::unique_ptr<Integrator> integrator;
  LightPathRecorder record;

  RecordedPass(const Way& way, uint64_t limit, bool isRecorded = true)
      : integrator(integratorFrom(way.integrator, way.parameters)), record(limit) {
    std::vector<RecordedPixel> none;
    const std::atomic<bool> stop{false};
    RenderSettings settings;
    settings.samplesPerPixel = 2;
    recordPixels(*scene, *integrator, classes, settings, 2, none, stop, {}, isRecorded ? &record : nullptr);
  }
  std::vector<StoredPhoton> photons() const {
    std::vector<StoredPhoton> out;
    integrator->visitPhotons([&](const StoredPhoton& photon) { out.push_back(photon); });
    return out;
  }
};

using PhotonKey = std::array<float, 7>;
PhotonKey keyOf(const Vec3f& p, const Rgb& power, LightState state) {
  return {p.x, p.y, p.z, power.r, power.g, power.b, float(state.byte)};
}

TEST(LightPathRecorder, StoredVerticesAreThePhotonsOfTheMap) {
  for (const Way& way : lightPathWays()) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordedPass pass(way, ALL_LIGHT_PATHS);
    std::map<PhotonKey, int> counts;
    for (const StoredPhoton& p : pass.photons()) ++counts[keyOf(p.position, p.power, p.state)];
    EXPECT_GT(counts.size(), 50u);
    // Fluxes are scaled in a different order, so that the last bits may differ.
    size_t stored = 0, same = 0;
    for (const RecordedLightVertex& v : pass.record.vertices()) {
      if (!v.stored) continue;
      ++stored;
      const auto near = counts.lower_bound(keyOf(v.position, v.flux * 0.9999f, LightState()));
      ASSERT_NE(near, counts.end());
      EXPECT_EQ(Vec3f(near->first[0], near->first[1], near->first[2]), v.position);
      EXPECT_NEAR(near->first[3], v.flux.r, 1e-5f * v.flux.r);
      same += near->first[6] == float(v.state.byte);
    }
    EXPECT_EQ(stored, pass.photons().size());
    EXPECT_EQ(same, stored);
  }
}

TEST(LightPathRecorder, PathsBeginAtTheirLightAndStatesFollowTheEvents) {
  for (const Way& way : lightPathWays()) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordedPass pass(way, ALL_LIGHT_PATHS);
    const std::vector<RecordedLightVertex>& all = pass.record.vertices();
    size_t longPaths = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      const RecordedLightVertex& v = all[i];
      if (v.kind == LightVertexKind::START) {
        EXPECT_EQ(v.previous, NOT_RECORDED);
        EXPECT_EQ(v.state.byte, pass.classes.lightStart().byte);
        EXPECT_NEAR(v.position.y, 0.995f, 1e-4f); // on the lamp
        continue;
      }
      ASSERT_GE(v.previous, 0);
      ASSERT_LT(size_t(v.previous), i);
      const RecordedLightVertex& from = all[size_t(v.previous)];
      EXPECT_NE(from.kind, LightVertexKind::ESCAPE);
      const bool isNextToLight = from.kind == LightVertexKind::START;
      const LightState expected = isNextToLight ? from.state : pass.classes.step(from.state, v.event);
      EXPECT_EQ(v.state.byte, expected.byte);
      EXPECT_GT(maxComponent(v.flux), 0);
      longPaths += !isNextToLight;
      if (v.kind == LightVertexKind::ESCAPE) {
        EXPECT_GT(glm::length(v.position), 1.7f);
      }
    }
    EXPECT_GT(longPaths, 20u);
  }
}

TEST(LightPathRecorder, LimitsTheNumberOfPathsAndChangesNothing) {
  for (const Way& way : lightPathWays()) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordedPass recorded(way, 30), plain(way, 30, false);
    size_t starts = 0;
    for (const RecordedLightVertex& v : recorded.record.vertices())
      starts += v.kind == LightVertexKind::START;
    EXPECT_GT(starts, 0u);
    EXPECT_LE(starts, recorded.record.pathsRecorded());
    EXPECT_LE(recorded.record.pathsRecorded(), 30u);
    EXPECT_TRUE(plain.record.vertices().empty());
    const std::vector<StoredPhoton> a = recorded.photons(), b = plain.photons();
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].position, b[i].position);
      EXPECT_EQ(a[i].power, b[i].power);
    }
  }
}

TEST(LightPathRecorder, RecordsNothingWhereLightPathsAreNotFollowed) {
  const RecordedPass pass({"path", ""}, ALL_LIGHT_PATHS);
  EXPECT_TRUE(pass.record.vertices().empty());
  EXPECT_EQ(pass.record.pathsEmitted(), 0u);
}

TEST(PhotonBoxes, ContainThePhotonsOfTheirMap) {
  for (const Way& way : lightPathWays()) {
    if (way.integrator == "vpl" || way.integrator == "bdpt") continue;
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordedPass pass(way, 0);
    uint64_t photons = 0;
    std::vector<PhotonBox> roots;
    pass.integrator->visitPhotonBoxes(4, [&](const PhotonBox& box) {
      EXPECT_LT(box.level, 4);
      if (box.level == 0) roots.push_back(box);
    });
    for (const PhotonBox& root : roots) photons += root.photons;
    size_t inside = 0;
    const std::vector<StoredPhoton> stored = pass.photons();
    for (const StoredPhoton& p : stored)
      for (const PhotonBox& root : roots)
        inside += root.caustic == p.caustic && root.box.contains(p.position);
    if (way.integrator != "vcm") { // vcm stores no photons with direct light
      EXPECT_EQ(photons, stored.size());
    }
    EXPECT_GE(inside, photons);
    EXPECT_GT(photons, 50u);
  }
}

TEST(PhotonPaths, AreThoseOfThePhotonsInEachMap) {
  const auto scene = sceneFrom(glassAndMirrorBox(LIGHT_PATH_SIZE, 1.2));
  // Classes by the last surface, each with many photons if a map contains it.
  const PathClasses classes({{"direct", "LDE"},
                             {"caustic", "LS+DE"},
                             {"indirect", "L(S|D)*DDE"},
                             {"caustic of indirect light", "L(S|D)*DS+DE"},
                             {"seen", "LS*E | L(S|D)*DS+E"}});
  const CameraState seen = classes.step(classes.cameraStart(), PathEvent::D);
  for (const auto& entry : plugIns().integrators.entries())
    for (std::string parameters : entry.examples) {
      // The default numbers would take seconds.
      for (const auto& [name, few] : {std::pair{"photons", "10000"}, {"rays", "20000"}})
        if (hasParameter(entry.name, name) && parameters.find(name + std::string("\"")) == std::string::npos)
          parameters += " \"integer " + std::string(name) + "\" " + few;
      if (hasParameter(entry.name, "photons") && hasParameter(entry.name, "passes") &&
          parameters.find("passes\"") == std::string::npos)
        parameters += " \"integer passes\" 0"; // otherwise a progressive render ignores "photons"
      SCOPED_TRACE(entry.name + " " + parameters);
      const auto integrator = integratorFrom(entry.name, parameters);
      integrator->prepare(*scene, classes);
      integrator->forward(*scene, classes, {.seed = 5}, {});
      std::vector<size_t> counts(classes.layerCount());
      size_t all = 0;
      integrator->visitPhotons([&](const StoredPhoton& photon) {
        const LayerMask mask = classes.join(photon.state, seen);
        for (size_t i = 0; i < counts.size(); ++i) counts[i] += mask >> i & 1;
        ++all;
      });
      if (all == 0) continue;
      const PathAutomaton carried = PathAutomaton::compile(integrator->photonPaths());
      for (size_t i = 0; i + 1 < counts.size(); ++i)
        EXPECT_EQ(counts[i] > 0,
                  !carried.intersect(PathAutomaton::compile(classes.classes()[i].expression)).isEmpty())
            << classes.classes()[i].name << " " << counts[i];
    }
}

} // namespace
} // namespace recurse
