/** @file
 * Records of camera paths by every integrator of the registry: nothing is missing from them, and nothing in
 * them is false.
 */
#include "rendering.h"

#include <map>

#include "recurse/pathclasses/pathExpression.h"
#include "recurse/render/recordPixels.h"

namespace recurse {
namespace {

using namespace recurse::testing;

constexpr int SIZE = 12, SAMPLES = 3;
constexpr uint64_t SEED = 7;

/** A lamp above a floor, and fog in a box between them that glows. */
std::string glowingFog() {
  return view(SIZE, "0 -3 1  0 0 .5  0 0 1", 50) + R"(
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [ .5 .6 .7 ] "rgb sigma_a" [ .1 .1 .1 ] "rgb Le" [ .2 .1 .1 ]
Material "diffuse"
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 9 9 9 ]
Shape "trianglemesh" "integer indices" [ 0 2 1  0 3 2 ] "point3 P" [ -.5 -.5 2  .5 -.5 2  .5 .5 2  -.5 .5 2 ]
AttributeEnd
Material "interface"
MediumInterface "fog" ""
Translate 0 0 .7
Shape "sphere" "float radius" .6
)";
}

/** A floor and a mirror below a pane, lit by a lamp and a point above the pane, the sun and the sky. */
std::string glazedFloor() {
  return view(SIZE, "0 -3 1  0 0 .3  0 0 1", 50) + R"(
LightSource "infinite" "rgb L" [ .3 .4 .5 ]
LightSource "distant" "rgb L" [ 1 1 1 ] "point3 from" [ 1 -1 3 ] "point3 to" [ 0 0 0 ]
LightSource "point" "point3 from" [ -1 -1 1.5 ] "rgb I" [ 3 3 3 ]
Material "diffuse"
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Material "conductor"
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 1 0  1 1 0  1 1.2 1  -1 1.2 1 ]
Material "thindielectric"
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 1  1 -1 1  1 1 1  -1 1 1 ]
AreaLightSource "diffuse" "rgb L" [ 9 9 9 ]
Material "diffuse"
Shape "trianglemesh" "integer indices" [ 0 2 1  0 3 2 ] "point3 P" [ -.5 -.5 2  .5 -.5 2  .5 .5 2  -.5 .5 2 ]
)";
}

/** Each integrator of the registry with its examples of parameters, and with few photons and rays. */
std::vector<Way> allIntegrators() {
  std::vector<Way> out;
  for (const auto& entry : plugIns().integrators.entries())
    for (std::string parameters : entry.examples) {
      for (const auto& [name, few] : {std::pair{"photons", "20000"}, {"rays", "20000"}, {"lightpaths", "60"}})
        if (hasParameter(entry.name, name) && parameters.find(name + std::string("\"")) == std::string::npos)
          parameters += " \"integer " + std::string(name) + "\" " + few;
      if (hasParameter(entry.name, "photons") && hasParameter(entry.name, "passes") &&
          parameters.find("passes\"") == std::string::npos)
        parameters += " \"integer passes\" 0"; // without which a progressive render ignores "photons"
      out.push_back({entry.name, parameters});
    }
  return out;
}

/** A scene, and an integrator that renders it. */
struct Case {
  std::string text;
  Way way;
};
std::vector<Case> allCases() {
  std::vector<Case> out;
  const auto fog = sceneFrom(glowingFog());
  for (const Way& way : allIntegrators()) {
    out.push_back({glassAndMirrorBox(SIZE, 1.2), way});
    out.push_back({glazedFloor(), way});
    if (integratorFrom(way.integrator, way.parameters)->supportsMedia(*fog))
      out.push_back({glowingFog(), way});
  }
  return out;
}

class RecordOfAll {
 public:
  RecordOfAll(const Way& way, const std::string& text) : scene(sceneFrom(text)), classes(list(*scene)) {
    for (const PathClass& one : list(*scene)) automata.push_back(PathAutomaton::compile(one.expression));
    for (int y = 0; y < SIZE; y += 3)
      for (int x = y % 2; x < SIZE; x += 2) pixels.push_back({x, y, {}});
    RenderSettings settings;
    settings.samplesPerPixel = SAMPLES;
    settings.seed = SEED;
    const std::atomic<bool> stop{false};
    const auto integrator = integratorFrom(way.integrator, way.parameters);
    recordPixels(*scene, *integrator, classes, settings, SAMPLES, pixels, stop);
    splats = integrator->splats();
  }
  static std::vector<PathClass> list(const Scene& scene) { return defaultStillClasses(scene.hasMedia()); }

  std::shared_ptr<const Scene> scene;
  PathClasses classes;
  std::vector<PathAutomaton> automata;
  std::vector<RecordedPixel> pixels;
  bool splats = false;
};

/** Light of a pixel in one layer, from the contributions. */
Rgb recordedLight(const PathRecorder& record, size_t layer) {
  Rgbd sum(0);
  double weights = 0;
  for (size_t s = 0; s < record.samples().size(); ++s) {
    const RecordedSample& sample = record.samples()[s];
    weights += double(sample.filterWeight);
    for (size_t i = sample.firstContribution; i < record.endContribution(s); ++i)
      if (record.contributions()[i].classes >> layer & 1)
        sum += Rgbd(record.contributions()[i].radiance) * double(sample.filterWeight * sample.rayWeight);
  }
  return Rgb(sum / weights);
}

TEST(RecordOfEveryIntegrator, AddsUpToThePixelsOfEachClass) {
  for (const auto& [text, way] : allCases()) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordOfAll record(way, text);
    const auto integrator = integratorFrom(way.integrator, way.parameters);
    const Rendered whole = renderScene(*record.scene, *integrator, record.classes, SAMPLES, SEED);
    EXPECT_EQ(whole.film.splats() != nullptr, record.splats);
    size_t contributions = 0;
    for (const RecordedPixel& pixel : record.pixels) {
      SCOPED_TRACE(std::to_string(pixel.x) + "," + std::to_string(pixel.y));
      const size_t p = size_t(pixel.y) * SIZE + size_t(pixel.x);
      for (size_t layer = 0; layer < record.classes.layerCount(); ++layer) {
        Rgb expected = whole.value(p, layer);
        if (record.splats) expected -= whole.film.splats()->value(p, layer);
        const Rgb found = recordedLight(pixel.record, layer);
        for (int c = 0; c < 3; ++c) // the splats are subtracted from a sum of both
          EXPECT_NEAR(found[c], expected[c], 2e-5f * whole.value(p, layer)[c])
              << record.classes.classes()[layer].name;
      }
      contributions += pixel.record.contributions().size();
    }
    EXPECT_EQ(contributions > 0, way.integrator != "lightpath"); // which has nothing but splats
  }
}

/** Steps of the camera's side of a path, by hits up to the light. */
bool endsByRay(const RecordedSource& s) {
  return s.technique == PathTechnique::HIT || s.technique == PathTechnique::FLIGHT;
}

/** Letters of a path that are recorded, between L or an unknown beginning and E. */
std::string recordedLetters(const PathRecorder& record, const RecordedSource& s) {
  if (endsByRay(s)) return record.letters(s.step);
  std::string out;
  for (int i = s.lightVertex;
       i != NOT_RECORDED && record.lightVertices[size_t(i)].previous != NOT_RECORDED;) {
    const RecordedLightVertex& v = record.lightVertices[size_t(i)];
    if (record.lightVertices[size_t(v.previous)].kind != LightVertexKind::START)
      out = "SDV"[size_t(v.event)] + out;
    i = v.previous;
  }
  if (s.technique == PathTechnique::CONNECTION) out += "D";
  const RecordedVertex& v = record.vertices()[size_t(s.vertex)];
  out += std::string(size_t(s.panes), 'S');
  return out + (v.inMedium ? "V" : "D") + record.letters(v.step);
}

/** Whether the classes are those of a path with these letters after any others. */
bool isPossible(const std::string& letters, const std::vector<PathClass>& list, LayerMask classes) {
  std::string expression = "(L(S|D|V)*" + letters + "E)";
  for (size_t i = 0; i < list.size(); ++i)
    expression += (classes >> i & 1 ? " & (" : " - (") + list[i].expression + ")";
  return !PathAutomaton::compile(expression, PathAutomaton::Empty::ALLOWED).isEmpty();
}

TEST(RecordOfEveryIntegrator, HasTheClassesThatTheLettersSay) {
  std::map<PathTechnique, size_t> counts;
  size_t throughPanes = 0;
  for (const auto& [text, way] : allCases()) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordOfAll all(way, text);
    const std::vector<PathClass> list = RecordOfAll::list(*all.scene);
    std::map<std::pair<std::string, LayerMask>, bool> known;
    for (const RecordedPixel& pixel : all.pixels)
      for (const RecordedContribution& one : pixel.record.contributions()) {
        const RecordedSource& s = one.source;
        ASSERT_NE(s.technique, PathTechnique::UNKNOWN);
        ASSERT_NE(s.technique, PathTechnique::SPLAT);
        ++counts[s.technique];
        throughPanes += s.panes > 0;
        const std::string letters = recordedLetters(pixel.record, s);
        if (s.omission()) {
          const auto [entry, isNew] = known.try_emplace({letters, one.classes}, false);
          if (isNew) entry->second = isPossible(letters, list, one.classes);
          EXPECT_TRUE(entry->second) << letters << " " << one.classes;
          continue;
        }
        for (size_t i = 0; i < list.size(); ++i)
          EXPECT_EQ(all.automata[i].accepts("L" + letters + "E"), (one.classes >> i & 1) != 0)
              << letters << " " << list[i].name << " " << techniqueName(s.technique);
      }
  }
  EXPECT_EQ(counts.size(), 7u); // all but SPLAT and UNKNOWN
  EXPECT_GT(throughPanes, 100u);
}

/** Whether a surface passes through a point. */
bool isOnSurface(const Scene& scene, const Vec3f& p) {
  const float near = 1e-3f * scene.bounds().radius;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      Ray ray;
      ray.direction = Vec3f(0);
      ray.direction[axis] = side;
      ray.origin = p - near * ray.direction;
      ray.tMax = 2 * near;
      Hit hit;
      if (scene.intersect(ray, hit)) return true;
    }
  return false;
}

/** Whether only this number of thin panes is between two points. */
bool isFree(const Scene& scene, const Vec3f& from, const Vec3f& to, int panes = 0) {
  constexpr float END = 2e-3f;
  const float distance = glm::distance(from, to);
  if (distance < 3 * END) return true;
  Ray ray;
  ray.direction = (to - from) / distance;
  ray.origin = from + END * ray.direction;
  ray.tMax = distance - 2 * END;
  if (panes == 0) return !scene.occluded(ray);
  Hit hit;
  while (scene.intersect(ray, hit)) {
    if (!(hit.material && hit.material->lobes() & STRAIGHT) && hit.material) return false;
    panes -= hit.material != nullptr;
    ray.origin = hit.point.position + END * ray.direction;
    ray.tMax -= hit.t + END;
  }
  return panes == 0;
}

/** Points of a path from the camera on, up to the light where it is known; checks those between. */
void expectTruePath(const Scene& scene, const PathRecorder& record, size_t sample, const RecordedSource& s) {
  std::vector<Vec3f> points; // from the light's side to the camera
  if (endsByRay(s) || s.technique == PathTechnique::LIGHT_SAMPLE)
    points.push_back(s.isInfinite ? Vec3f(0) : s.end);
  const bool isOnLamp =
      s.technique == PathTechnique::HIT || (s.technique == PathTechnique::LIGHT_SAMPLE && s.pdf > 0);
  if (isOnLamp && !s.isInfinite) {
    EXPECT_TRUE(isOnSurface(scene, s.end));
  }
  const int last = endsByRay(s)
                       ? (s.step == CAMERA_STEP ? NOT_RECORDED : record.steps()[size_t(s.step)].vertex)
                       : s.vertex;
  for (int i = last; i != NOT_RECORDED;) {
    const RecordedVertex& v = record.vertices()[size_t(i)];
    points.push_back(v.position);
    if (!v.inMedium) {
      EXPECT_TRUE(isOnSurface(scene, v.position));
      EXPECT_NE(v.material, nullptr);
    }
    i = v.step == CAMERA_STEP ? NOT_RECORDED : record.steps()[size_t(v.step)].vertex;
  }
  points.push_back(record.samples()[sample].origin);
  for (size_t i = s.isInfinite ? 2 : 1; i < points.size(); ++i)
    EXPECT_TRUE(isFree(scene, points[i - 1], points[i], i == 1 ? s.panes : 0)) << i;
  // The light path.
  const bool hasOnlyAreaLights = scene.contents().areaLights > 0 && scene.environment().empty();
  if (s.lightVertex == NOT_RECORDED) return;
  if (s.technique == PathTechnique::CONNECTION) {
    EXPECT_TRUE(isFree(scene, record.vertices()[size_t(s.vertex)].position, s.end));
  }
  for (int i = s.lightVertex; i != NOT_RECORDED;) {
    const RecordedLightVertex& v = record.lightVertices[size_t(i)];
    if (v.kind == LightVertexKind::SURFACE || hasOnlyAreaLights) {
      EXPECT_TRUE(isOnSurface(scene, v.position));
    }
    EXPECT_EQ(v.material != nullptr, v.kind == LightVertexKind::SURFACE);
    EXPECT_EQ(v.previous == NOT_RECORDED, v.kind == LightVertexKind::START);
    EXPECT_GT(maxComponent(v.flux), 0);
    if (v.previous != NOT_RECORDED) {
      EXPECT_TRUE(isFree(scene, v.position, record.lightVertices[size_t(v.previous)].position));
      const bool isAtLamp = record.lightVertices[size_t(v.previous)].kind == LightVertexKind::START;
      EXPECT_EQ(v.lobe == NO_LOBE, isAtLamp);
      if (!isAtLamp || hasOnlyAreaLights) {
        EXPECT_EQ(v.pdf > 0, isAtLamp || v.event != PathEvent::S);
      }
      EXPECT_EQ(v.pdfReverse > 0, !isAtLamp && v.event != PathEvent::S);
    }
    i = v.previous;
  }
}

TEST(RecordOfEveryIntegrator, HasVerticesOnSurfacesAndFreeEdges) {
  for (const auto& [text, way] : allCases()) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordOfAll all(way, text);
    size_t whole = 0;
    for (const RecordedPixel& pixel : all.pixels)
      for (size_t s = 0; s < pixel.record.samples().size(); ++s)
        for (size_t i = pixel.record.samples()[s].firstContribution; i < pixel.record.endContribution(s);
             ++i) {
          const RecordedSource& source = pixel.record.contributions()[i].source;
          whole += source.omission() == nullptr;
          SCOPED_TRACE(techniqueName(source.technique));
          expectTruePath(*all.scene, pixel.record, s, source);
          if (::testing::Test::HasFailure()) return;
        }
    EXPECT_EQ(whole > 0, way.integrator != "lightpath");
  }
}

TEST(RecordOfEveryIntegrator, HasTheDensitiesAndTheWeightsOfJoinedPaths) {
  const std::string text = glassAndMirrorBox(SIZE, 1.2);
  size_t lists = 0;
  for (const Way& way : allIntegrators()) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const RecordOfAll all(way, text);
    for (const RecordedPixel& pixel : all.pixels)
      for (const RecordedContribution& one : pixel.record.contributions()) {
        const RecordedSource& s = one.source;
        const bool isConnection = s.technique == PathTechnique::CONNECTION;
        if (isConnection || s.technique == PathTechnique::LIGHT_SAMPLE) {
          EXPECT_GT(s.vertexPdf, 0);
          EXPECT_GT(s.vertexPdfReverse, 0);
        }
        EXPECT_EQ(s.lightVertexPdf > 0, isConnection);
        EXPECT_EQ(s.lightVertexPdfReverse > 0, isConnection);
        if (s.weightCount == 0) continue;
        ++lists;
        float sum = 0, own = 0;
        for (size_t i = s.firstWeight; i < s.firstWeight + s.weightCount; ++i) {
          const RecordedWeight& w = pixel.record.weights[i];
          sum += w.weight;
          int vertices = 0; // of the camera's side
          for (int v = s.vertex; v != NOT_RECORDED; ++vertices) {
            const int step = pixel.record.vertices()[size_t(v)].step;
            v = step == CAMERA_STEP ? NOT_RECORDED : pixel.record.steps()[size_t(step)].vertex;
          }
          const bool isOne = isConnection || s.technique == PathTechnique::MERGE;
          if (w.technique == s.technique && (!isOne || w.cameraVertices == vertices)) own += w.weight;
        }
        EXPECT_NEAR(sum, 1, 1e-3f);
        EXPECT_NEAR(own, s.weight, 1e-3f);
      }
  }
  EXPECT_GT(lists, 1000u);
}

} // namespace
} // namespace recurse
