/** @file
 * Records of camera paths: recording changes no result, and the records are complete.
 */
#include "rendering.h"

#include <map>

#include "recurse/pathclasses/pathExpression.h"
#include "recurse/render/recordPixels.h"

namespace recurse {
namespace {

using namespace recurse::testing;

constexpr int RECORD_SIZE = 12, RECORD_SAMPLES = 3;
constexpr uint64_t RECORD_SEED = 7;

/** A weakly emissive fog in a box. */
std::string mistyFloor() {
  return view(RECORD_SIZE, "0 -3 1  0 0 .5  0 0 1", 50) + R"(
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [ .5 .6 .7 ] "rgb sigma_a" [ .1 .1 .1 ]
LightSource "point" "point3 from" [ 0 -1 2 ] "rgb I" [ 9 9 9 ]
Material "diffuse"
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Material "interface"
MediumInterface "fog" ""
Translate 0 0 .7
Shape "sphere" "float radius" .6
)";
}

struct RecordCase {
  std::string scene, integrator, parameters;
};
std::vector<RecordCase> recordCases() {
  const std::string photons = "\"integer photons\" 1000", progressive = photons + " \"integer passes\" 0";
  return {{glassAndMirrorBox(RECORD_SIZE, 1.2), "path", ""},
          {glassAndMirrorBox(RECORD_SIZE, 1.2), "simplepath", ""},
          {glassAndMirrorBox(RECORD_SIZE, 1.2), "photonmap", progressive},
          {glassAndMirrorBox(RECORD_SIZE, 1.2), "photonmap",
           photons + " \"integer passes\" 1 \"integer finalgather\" 3"},
          {glassAndMirrorBox(RECORD_SIZE, 1.2), "photonmap", progressive + " \"bool causticsonly\" true"},
          {glassAndMirrorBox(RECORD_SIZE, 1.2), "simplephotonmap", photons},
          {mistyFloor(), "path", ""},
          // With few photons the paths would read none.
          {mistyFloor(), "photonmap", "\"integer photons\" 65536 \"integer passes\" 0"}};
}

std::vector<RecordedPixel> somePixels() {
  std::vector<RecordedPixel> pixels;
  for (int y = 0; y < RECORD_SIZE; y += 3)
    for (int x = y % 2; x < RECORD_SIZE; x += 2) pixels.push_back({x, y, {}});
  return pixels;
}

std::vector<RecordedPixel> recordOf(const Scene& scene, const RecordCase& c, const PathClasses& classes) {
  std::vector<RecordedPixel> pixels = somePixels();
  RenderSettings settings;
  settings.samplesPerPixel = RECORD_SAMPLES;
  settings.seed = RECORD_SEED;
  const std::atomic<bool> stop{false};
  recordPixels(scene, *integratorFrom(c.integrator, c.parameters), classes, settings, RECORD_SAMPLES, pixels,
               stop);
  return pixels;
}

void expectClose(const Rgb& found, const Rgb& expected) {
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_NEAR(found[channel], expected[channel], 1e-5f * expected[channel]);
}

/** Sum of the contributions of a sample. */
Rgb sumOf(const PathRecorder& record, size_t sample) {
  Rgb sum(0);
  for (size_t i = record.samples()[sample].firstContribution; i < record.endContribution(sample); ++i)
    sum += record.contributions()[i].radiance;
  return sum;
}

TEST(PathRecorder, ContributionsAddUpToThePixelsOfTheRender) {
  for (const RecordCase& c : recordCases()) {
    SCOPED_TRACE(c.integrator + " " + c.parameters);
    const auto scene = sceneFrom(c.scene);
    const Rendered whole = renderScene(*scene, c.integrator, c.parameters, RECORD_SAMPLES, RECORD_SEED);
    size_t contributions = 0;
    for (const RecordedPixel& pixel : recordOf(*scene, c, PathClasses())) {
      SCOPED_TRACE(std::to_string(pixel.x) + "," + std::to_string(pixel.y));
      expectClose(pixel.value(), whole.value(size_t(pixel.y) * RECORD_SIZE + size_t(pixel.x)));
      ASSERT_EQ(pixel.record.samples().size(), size_t(RECORD_SAMPLES));
      for (size_t s = 0; s < size_t(RECORD_SAMPLES); ++s)
        expectClose(sumOf(pixel.record, s), pixel.record.samples()[s].total);
      contributions += pixel.record.contributions().size();
    }
    EXPECT_GT(contributions, somePixels().size());
  }
}

/** Word of a path as recorded on the camera's side: complete for hits and shadow rays. */
std::string recordedWord(const PathRecorder& record, const RecordedSource& source) {
  if (source.technique == PathTechnique::HIT) return "L" + record.letters(source.step) + "E";
  return "LD" + record.letters(record.vertices()[size_t(source.vertex)].step) + "E";
}

TEST(PathRecorder, LettersOfAPathAreThoseOfItsClass) {
  const std::vector<PathClass> list = defaultStillClasses();
  std::vector<PathAutomaton> automata;
  for (const PathClass& one : list) automata.push_back(PathAutomaton::compile(one.expression));
  const PathClasses classes(list);
  for (const RecordCase& c : recordCases()) {
    if (c.scene == mistyFloor() || c.integrator == "simplephotonmap") continue;
    SCOPED_TRACE(c.integrator + " " + c.parameters);
    const auto scene = sceneFrom(c.scene);
    size_t hits = 0, samples = 0, merges = 0;
    for (const RecordedPixel& pixel : recordOf(*scene, c, classes))
      for (const RecordedContribution& one : pixel.record.contributions()) {
        ASSERT_NE(one.source.technique, PathTechnique::UNKNOWN);
        if (one.source.technique == PathTechnique::MERGE) {
          ++merges;
          EXPECT_GT(pixel.record.estimates()[size_t(one.source.estimate)].radius, 0);
          continue;
        }
        ++(one.source.technique == PathTechnique::HIT ? hits : samples);
        const std::string word = recordedWord(pixel.record, one.source);
        for (size_t i = 0; i < list.size(); ++i)
          EXPECT_EQ(automata[i].accepts(word), (one.classes >> i & 1) != 0) << word << " " << list[i].name;
      }
    EXPECT_GT(hits, 0u);
    EXPECT_GT(samples, 0u);
    EXPECT_EQ(merges > 0, c.integrator == "photonmap");
  }
}

/** Word of a path that is joined with a light path. */
std::string joinedWord(const PathRecorder& record, const RecordedSource& source) {
  std::string light;
  for (int i = source.lightVertex;;) {
    const RecordedLightVertex& v = record.lightVertices[size_t(i)];
    if (record.lightVertices[size_t(v.previous)].kind == LightVertexKind::START) break;
    light = "SDV"[size_t(v.event)] + light;
    i = v.previous;
  }
  if (source.technique == PathTechnique::CONNECTION) light += "D";
  return "L" + light + "D" + record.letters(record.vertices()[size_t(source.vertex)].step) + "E";
}

TEST(PathRecorder, JoinsOfBothSidesAreWholePaths) {
  const std::vector<PathClass> list = defaultStillClasses();
  std::vector<PathAutomaton> automata;
  for (const PathClass& one : list) automata.push_back(PathAutomaton::compile(one.expression));
  const auto scene = sceneFrom(glassAndMirrorBox(RECORD_SIZE, 1.2));
  for (const char* integrator : {"bdpt", "vcm"}) {
    SCOPED_TRACE(integrator);
    std::map<PathTechnique, size_t> counts;
    for (const RecordedPixel& pixel : recordOf(*scene, {"", integrator, ""}, PathClasses(list))) {
      const PathRecorder& record = pixel.record;
      for (size_t s = 0; s < size_t(RECORD_SAMPLES); ++s)
        expectClose(sumOf(record, s), record.samples()[s].total);
      for (const RecordedContribution& one : record.contributions()) {
        const RecordedSource& source = one.source;
        ++counts[source.technique];
        EXPECT_GT(source.weight, 0);
        EXPECT_LE(source.weight, 1.0001f);
        const bool isJoin = source.lightVertex != NOT_RECORDED;
        const std::string word = isJoin ? joinedWord(record, source) : recordedWord(record, source);
        for (size_t i = 0; i < list.size(); ++i)
          EXPECT_EQ(automata[i].accepts(word), (one.classes >> i & 1) != 0) << word << " " << list[i].name;
        if (!isJoin) continue;
        EXPECT_EQ(record.lightVertices[size_t(source.lightVertex)].position, source.end);
        if (source.technique == PathTechnique::MERGE) {
          EXPECT_LE(glm::distance(source.end, record.vertices()[size_t(source.vertex)].position),
                    record.estimates()[size_t(source.estimate)].radius);
        }
      }
    }
    EXPECT_GT(counts[PathTechnique::HIT], 0u);
    EXPECT_GT(counts[PathTechnique::LIGHT_SAMPLE], 0u);
    EXPECT_GT(counts[PathTechnique::CONNECTION], 0u);
    EXPECT_EQ(counts[PathTechnique::MERGE] > 0, integrator == std::string("vcm"));
    EXPECT_EQ(counts.count(PathTechnique::UNKNOWN), 0u);
  }
}

TEST(PathRecorder, WeightsAreThePowerHeuristicOfTheDensities) {
  const auto scene = sceneFrom(glassAndMirrorBox(RECORD_SIZE, 1.2));
  for (const char* lightSamples : {"", "\"integer lightsamples\" 3"}) {
    SCOPED_TRACE(lightSamples);
    std::map<PathTechnique, size_t> shared;
    for (const RecordedPixel& pixel : recordOf(*scene, {"", "path", lightSamples}, PathClasses()))
      for (const RecordedContribution& one : pixel.record.contributions()) {
        const RecordedSource& s = one.source;
        if (!(s.otherPdf > 0)) continue;
        ++shared[s.technique];
        const double a = square(double(s.pdf)), b = square(double(s.otherPdf));
        EXPECT_NEAR(double(s.weight), a / (a + b), 1e-4);
      }
    EXPECT_GT(shared[PathTechnique::LIGHT_SAMPLE], 100u);
    EXPECT_GT(shared[PathTechnique::HIT], 5u);
  }
}

TEST(PathRecorder, VerticesLieOnTheRaysBetweenThem) {
  const auto scene = sceneFrom(glassAndMirrorBox(RECORD_SIZE, 1.2));
  for (const char* integrator : {"path", "photonmap"})
    for (const RecordedPixel& pixel : recordOf(
             *scene, {"", integrator, integrator == std::string("path") ? "" : "\"integer photons\" 1000"},
             PathClasses())) {
      const PathRecorder& record = pixel.record;
      for (size_t s = 0; s < record.samples().size(); ++s) {
        const size_t end =
            s + 1 < record.samples().size() ? record.samples()[s + 1].firstVertex : record.vertices().size();
        for (size_t i = record.samples()[s].firstVertex; i < end; ++i) {
          const RecordedVertex& v = record.vertices()[i];
          const bool first = v.step == CAMERA_STEP;
          const Vec3f from = first
                                 ? record.samples()[s].origin
                                 : record.vertices()[size_t(record.steps()[size_t(v.step)].vertex)].position;
          const Vec3f direction =
              first ? record.samples()[s].direction : record.steps()[size_t(v.step)].direction;
          const Vec3f way = v.position - from;
          EXPECT_NEAR(glm::dot(way, direction), glm::length(way), 1e-3f);
        }
      }
    }
}

TEST(PathRecorder, RefusesAPixelOutsideOfThePicture) {
  const auto scene = sceneFrom(litCorner(RECORD_SIZE));
  std::vector<RecordedPixel> pixels = {{RECORD_SIZE, 0, {}}};
  const std::atomic<bool> stop{false};
  EXPECT_THROW(recordPixels(*scene, *integratorFrom("path", ""), PathClasses(), {}, 1, pixels, stop), Error);
}

TEST(VisitPhotons, HandsOutTheWholeMap) {
  const auto scene = sceneFrom(glassAndMirrorBox(RECORD_SIZE, 1.2));
  for (const char* name : {"photonmap", "simplephotonmap"}) {
    const auto integrator = integratorFrom(name, "\"integer photons\" 1500");
    std::vector<RecordedPixel> none;
    const std::atomic<bool> stop{false};
    RenderSettings settings;
    settings.samplesPerPixel = 1;
    const RenderStatistics statistics =
        recordPixels(*scene, *integrator, PathClasses(), settings, 1, none, stop);
    uint64_t count = 0, caustics = 0;
    integrator->visitPhotons([&](const StoredPhoton& photon) {
      ++count;
      caustics += photon.caustic;
      EXPECT_NEAR(glm::length(photon.direction), 1, 1e-4f);
      EXPECT_GE(maxComponent(photon.power), 0);
      EXPECT_LE(glm::length(photon.position), 1.74f);
    });
    EXPECT_EQ(count, statistics.photonsStored);
    EXPECT_GT(count, 100u);
    EXPECT_EQ(caustics > 0, std::string(name) == "photonmap");
  }
}

} // namespace
} // namespace recurse
