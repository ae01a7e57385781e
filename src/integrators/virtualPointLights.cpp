/** @file
 * Instant radiosity (Keller 1997): the vertices of light paths are virtual point lights, which illuminate all
 * that the camera sees. The geometry term is bounded, and paths that continue add the bias that this causes
 * (Kollig and Keller 2004, "Illumination in the Presence of Weak Singularities").
 */
#include <map>
#include <set>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/direct/localShading.h"
#include "transport/emission/emissionSampler.h"
#include "transport/forward/photonGuidance.h"
#include "transport/integrator/maxDepthParameter.h"
#include "transport/learning/lightLearning.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/recordedWalk.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

struct VplSettings {
  int maxDepth = -1;
  int lightPaths = 32;     ///< number in each pass
  int passes = 0;          ///< 0: one for each sample
  float clampDistance = 0; ///< geometry term is bounded by its reciprocal square [scene units]; 0: unbounded
  bool clampChosen = true; ///< clamp distance is chosen by the number of lights
  bool compensate = true;
};

/** Vertex of a light path, as a virtual point light. */
struct VirtualLight {
  SurfacePoint point;
  Vec3f wi;                 ///< unit, back along the light path
  Rgb flux;                 ///< flux on arrival, divided by the number of light paths
  LightState state, afterD; ///< before and after the event there
  int path = 0;             ///< number of the light path in its pass
  int events = 0;
  bool bounded =
      true; ///< false after a delta event: no ray that continues could add the light that a bound removes
  ScatteringPoint scattering;
};

/** Whether a path class contains paths with D events on both sides of a virtual light's connection. */
bool joinsVirtualLights(const PathClasses& classes) {
  std::set<uint8_t> light;
  std::set<uint16_t> camera;
  for (size_t kind = 0; kind < classes.surfaceKindCount(); ++kind) {
    const SurfaceKind surface(static_cast<uint8_t>(kind));
    for (size_t i = 0; i < classes.lightStateCount(); ++i)
      light.insert(classes.step(LightState(static_cast<uint8_t>(i)), PathEvent::D, surface).byte);
    for (size_t j = 0; j < classes.cameraStateCount(); ++j)
      camera.insert(classes.step(CameraState(static_cast<uint16_t>(j)), PathEvent::D, surface).index);
  }
  for (const uint8_t i : light)
    for (const uint16_t j : camera)
      if (classes.join(LightState(i), CameraState(j)) != 0) return true;
  return false;
}

class VirtualPointLights final : public Integrator {
 public:
  explicit VirtualPointLights(const VplSettings& settings) : settings(settings) {}

  Passes passes(int samplesPerPixel) const override {
    if (settings.passes == 0) return Passes::perSample();
    return Passes::fixed(samplesPerPixel > 0 ? std::min(settings.passes, samplesPerPixel) : settings.passes);
  }
  bool passHasOneTime() const override { return true; }
  TransportCounts prepare(const Scene& scene, const PathClasses&) override {
    // Default clamp distance: scene radius / sqrt(light paths), about the spacing of light paths.
    const float distance = settings.clampChosen
                               ? scene.bounds().radius / std::sqrt(static_cast<float>(settings.lightPaths))
                               : settings.clampDistance;
    bound = distance > 0 ? 1 / square(distance) : INFINITE;
    return learnLights(scene, lights);
  }

  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics;
    current = pass;
    virtualLights.clear();
    arena.reset();
    if (scene.lights().size() == 0 || !joinsVirtualLights(classes)) return statistics;
    if (pass.index == 0) {
      const ProcessorTimer timer(statistics.learningSeconds);
      guide = learnEmission(scene, classes, pass.seed, settings.maxDepth, control, statistics.counts);
      if (guide.active())
        statistics.notes.push_back(formatted("virtual lights: %.0f %% of the light paths are aimed at "
                                             "visible surfaces and openings",
                                             100 * guide.boxPart()));
    }
    const auto start = std::chrono::steady_clock::now();
    if (control.lightPaths) control.lightPaths->beginPass(static_cast<uint64_t>(settings.lightPaths));
    for (int i = 0; i < settings.lightPaths && !control.stopped(); ++i) {
      RecordedWalk record(control.lightPaths, static_cast<uint64_t>(i),
                          1 / static_cast<float>(settings.lightPaths));
      walkLightPath(scene, classes, i, statistics.counts, record,
                    [&](const LightSubpath& path, const LightVertex& vertex) { store(path, vertex, i); });
    }
    statistics.photonsEmitted = static_cast<uint64_t>(settings.lightPaths);
    statistics.photonsStored = virtualLights.size();
    statistics.shootSeconds = secondsSince(start);
    return statistics;
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    CameraWalker walker(scene, classes, out.counts, settings.maxDepth);
    CameraSubpath path = startCameraSubpath(scene, classes, ray, out.counts);
    CameraVertex vertex;
    RecordedCameraPath record(out.recorder);
    RecordedLights recordedLights;
    const auto addEmission = [&](const Hit* hit) {
      addSeenEmission(scene, lights, path, hit, record.step(), out);
    };
    while (walker.next(path, vertex, sampler, addEmission)) {
      record.arrive(vertex);
      if (vertex.isConnectable()) {
        shade(scene, vertex, path.nesting, sampler, recordedLights, out);
        if (settings.compensate && bound < INFINITE)
          compensate(scene, path, vertex, record, sampler, recordedLights, out);
      }
      vertex.allowed &= DELTA_LOBES;
      if (vertex.allowed == NO_LOBE) return;
      const std::optional<Scatter> s = walker.scatter(path, vertex, sampler);
      if (!s) return;
      record.leave(vertex, *s, path.throughput);
    }
  }

  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override {
    for (const VirtualLight& light : virtualLights)
      visit({light.point.position, light.wi, light.point.normalTowards(light.wi), light.flux, light.state});
  }
  std::string photonName() const override { return "virtual point lights"; }
  std::string claims() const override { return "LD?S*E | L(S|D)*DDS*E"; }
  std::string suppositions() const override {
    return settings.compensate || (!settings.clampChosen && settings.clampDistance <= 0)
               ? ""
               : "that surfaces close to each other exchange less light than they do: corners are too dark";
  }
  bool supportsFibres() const override { return false; }
  std::vector<EstimatorDomain> domains() const override {
    std::vector<EstimatorDomain> all = {
        {"emission", "LS*E", "none: found by rays through mirrors and glass", "", true},
        {"shadow rays", "LDS*E", "one for each surface of a camera path", "direct light"},
        {"BSDF rays", "LDS*E", "one for each surface of a camera path", "direct light", true},
        {"virtual lights", "L(S|D)*DDS*E",
         "one shadow ray to each virtual light from each surface of a camera path", "near and far"}};
    if (settings.compensate)
      all.push_back({"bias compensation", "L((S|D)*D)?DDS*E", "one continued ray, up to the clamp distance",
                     "near and far"});
    return all;
  }

 private:
  /** Index of the start of each recorded light path in PathRecorder::lightVertices, by its number. */
  using RecordedLights = std::map<int, int>;

  /** Follows light path `number` of the current pass, and calls visit(path, vertex) at each vertex. */
  template <class Visit>
  void walkLightPath(const Scene& scene, const PathClasses& classes, int number, TransportCounts& counts,
                     RecordedWalk& record, const Visit& visit) const {
    followLightPath(scene, classes, current, static_cast<uint64_t>(number), settings.maxDepth, &guide, counts,
                    record, visit);
  }

  void store(const LightSubpath& path, const LightVertex& vertex, int number) {
    if (!vertex.isConnectable()) return;
    if (const Bsdf* bsdf = vertex.hit.material->bsdfAt(vertex.point(), arena))
      virtualLights.push_back({vertex.point(), vertex.wi,
                               vertex.throughput / static_cast<float>(settings.lightPaths), vertex.state,
                               vertex.afterD, number, vertex.depth, !path.delta,
                               ScatteringPoint(*bsdf, vertex.point())});
  }

  /** Sets the source of the next contribution to the connection of `vertex` with a virtual light in unit
   * `direction`. Light paths are not kept: a recorded one is followed again. */
  void recordConnection(const Scene& scene, const PathClasses& classes, const VirtualLight& light,
                        const CameraVertex& vertex, const Vec3f& direction, float weight,
                        RecordedLights& recorded, PathRecorder& recorder) const {
    std::vector<RecordedLightVertex>& list = recorder.lightVertices;
    const auto [entry, isNew] = recorded.try_emplace(light.path, static_cast<int>(list.size()));
    if (isNew) {
      TransportCounts counts;
      RecordedWalk record(&list, 1 / static_cast<float>(settings.lightPaths));
      walkLightPath(scene, classes, light.path, counts, record,
                    [](const LightSubpath&, const LightVertex&) {});
    }
    recorder.source = {
        .technique = PathTechnique::CONNECTION,
        .vertex = recorder.source.vertex,
        .lightVertex = entry->second + light.events,
        .end = light.point.position,
        .weight = weight,
        .vertexPdf = float(vertex.pdfDirection(direction)),
        .vertexPdfReverse = float(vertex.pdfReverse(direction)),
        .lightVertexPdf = light.scattering.pdf(light.wi, -direction, ALL_LOBES, Transport::FLUX),
        .lightVertexPdfReverse = light.scattering.pdf(-direction, light.wi, ALL_LOBES, Transport::RADIANCE)};
  }

  /** Geometry term |cos| |cos| / distance², with the direction and distance of a connection. */
  struct Geometry {
    Vec3f direction; ///< unit, towards the light
    float distance = 0, term = 0;
  };
  static Geometry geometryOf(const SurfacePoint& from, const SurfacePoint& light) {
    const Vec3f way = light.position - from.position;
    const float distance = glm::length(way);
    if (!(distance > 0)) return {};
    const Vec3f direction = way / distance;
    return {direction, distance,
            absDot(direction, from.geometricNormal) * absDot(direction, light.geometricNormal) /
                square(distance)};
  }

  /** Adds direct light and the contribution of the virtual lights. */
  void shade(const Scene& scene, const CameraVertex& vertex, const Nesting& nesting, Sampler& sampler,
             RecordedLights& recorded, PathRadiance& out) const {
    addDirectLight(scene, lights, vertex, nesting, sampler, out);
    for (const VirtualLight& light : virtualLights) {
      if (out.abandoned()) return;
      if (out.pathClasses().join(light.afterD, vertex.afterD) == 0 ||
          (settings.maxDepth >= 0 && vertex.depth + light.events > settings.maxDepth))
        continue;
      const Geometry g = geometryOf(vertex.point(), light.point);
      if (!(g.term > 0)) continue;
      const float kept = isBounded(light) && g.term > bound ? bound / g.term : 1;
      const Rgb radiance = vertex.throughput * vertex.scattering->evaluate(vertex.wi, g.direction) *
                           light.flux * light.scattering.evaluateFlux(light.wi, -g.direction) *
                           (kept / square(g.distance));
      if (isBlack(radiance) ||
          !visible(scene, vertex.hit, vertex.wi,
                   visibilityTarget(light.point.rayOrigin(-g.direction), g.direction, g.distance), nesting,
                   out.counts))
        continue;
      if (out.recorder)
        recordConnection(scene, out.pathClasses(), light, vertex, g.direction, kept, recorded, *out.recorder);
      out.add(light.afterD, vertex.afterD, radiance);
    }
  }
  bool isBounded(const VirtualLight& light) const { return light.bounded || !settings.compensate; }

  /** Adds the light that the bound removes: the path continues to surfaces within the clamp distance,
   * weighted by the missing fraction. */
  void compensate(const Scene& scene, CameraSubpath path, CameraVertex vertex, RecordedCameraPath record,
                  Sampler& sampler, RecordedLights& recorded, PathRadiance& out) const {
    CameraWalker walker(scene, out.pathClasses(), out.counts, settings.maxDepth);
    while (!out.abandoned()) {
      vertex.allowed &= NON_DELTA_LOBES;
      const std::optional<Scatter> s =
          vertex.scattering->scatterNonDelta(vertex.wi, Transport::RADIANCE, sampler);
      if (!s) return;
      const SurfacePoint from = vertex.point();
      walker.follow(path, vertex, *s);
      record.leave(vertex, *s, path.throughput);
      path.ray.tMax = 1 / std::sqrt(bound);
      if (isBlack(path.throughput) || !walker.next(path, vertex, sampler) || !vertex.isConnectable()) return;
      const Geometry g = geometryOf(from, vertex.point());
      if (!(g.term > bound)) return;
      vertex.throughput *= 1 - bound / g.term;
      path.throughput = vertex.throughput;
      record.arrive(vertex);
      shade(scene, vertex, path.nesting, sampler, recorded, out);
    }
  }

  VplSettings settings;
  LightSampler lights;
  float bound = INFINITE; ///< maximum of the geometry term
  EmissionMixture guide;  ///< emission density of the light paths
  // State of the current pass:
  Pass current;
  std::vector<VirtualLight> virtualLights;
  BsdfArena arena; ///< memory of the virtual lights' BSDFs
};

} // namespace

void registerVirtualPointLights(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "vpl",
        .summary = "Instant radiosity: light paths store virtual point lights, which illuminate what the "
                   "camera sees. No caustics.",
        .parameters =
            {maxDepthParameter(),
             integerParameter("lightpaths", "32",
                              "number of light paths in each pass; each stores about three lights")
                 .range(1, 1e6),
             integerParameter("passes", "0",
                              "number of sets of virtual lights, between which the samples are divided; 0: a "
                              "new set for each sample")
                 .range(0, 1e9),
             realParameter("clampdistance", "",
                           "clamp distance: nearer virtual lights illuminate as from this distance [scene "
                           "units]; 0: no clamping; by default chosen from the number of light paths")
                 .range(0, 1e30),
             booleanParameter("compensate", "true", "compensate the bias of clamping by continued rays")},
        .examples = {"", "\"integer lightpaths\" 8 \"bool compensate\" false",
                     "\"integer passes\" 1 \"float clampdistance\" .1"}},
       [](const Parameters& p, const NoContext&) {
         VplSettings s;
         s.maxDepth = p.integer("maxdepth");
         s.lightPaths = p.integer("lightpaths");
         s.passes = p.integer("passes");
         s.clampChosen = !p.hasValue("clampdistance");
         if (!s.clampChosen) s.clampDistance = static_cast<float>(p.real("clampdistance"));
         s.compensate = p.boolean("compensate");
         return std::make_unique<VirtualPointLights>(s);
       }});
}

} // namespace recurse
