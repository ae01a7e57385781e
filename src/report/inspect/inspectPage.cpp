/** @file
 * Data of the page of light in a scene. Points are relative to Scene::origin() [scene units].
 */
#include "recurse/report/inspect/inspect.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>

#include "recurse/pathclasses/pathExpression.h"
#include "recurse/report/stills/stills.h"
#include "recurse/transport/integrator/sceneNames.h"
#include "report/inspect/sceneMesh.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t MOST_TRIANGLES = 200000;
constexpr uint8_t NO_CLASS = 127, CAUSTIC = 128;
constexpr uint8_t UNCLASSIFIED = 126; ///< the page finds the class of a path

/** Number rounded to six digits; null where it is not finite. */
Json shortened(double x) {
  if (!std::isfinite(x)) return nullptr;
  if (x == 0) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(x))) - 5);
  return std::isnormal(unit) ? std::round(x / unit) * unit : x;
}

Json numbers(const Vec3f& v) {
  return {shortened(double(v.x)), shortened(double(v.y)), shortened(double(v.z))};
}

Json numbers(const Rgb& c) {
  return {shortened(double(c.r)), shortened(double(c.g)), shortened(double(c.b))};
}

/** Position of the lowest bit among `count` bits from `first` on; -1 where none is set. */
int firstOf(LayerMask mask, size_t first, size_t count) {
  if (count == 0) return -1;
  const LayerMask range = (mask >> first) & (~LayerMask(0) >> (64 - count));
  return range == 0 ? -1 : std::countr_zero(range);
}

/** Number of classes, without the layers of frames. */
size_t classCount(const PathClasses& classes) {
  return classes.isTransient() ? 1 : std::min<size_t>(classes.layerCount(), 64);
}

/** What the mask of a path says: its class on the page, its lamp, its depth. */
class MaskReader {
 public:
  MaskReader(const PathClasses& classes, const Inspection& inspection)
      : shown(inspection.shownClasses ? inspection.shownClasses : classCount(classes)),
        lamps(inspection.lamps.size()), depths(inspection.depths),
        lampClasses(inspection.shownClasses ? classes.layerCount() - shown - depths : 0) {
    for (size_t i = 0; i < shown; ++i)
      if (classes.classes()[i].expression != "all") telling |= LayerMask(1) << i;
  }

  /** A render of one class says nothing. */
  bool hasClasses() const { return shown > 1; }
  size_t shownClasses() const { return shown; }
  /** The first class of a path that is not the class of all paths. */
  uint8_t classOf(LayerMask mask) const {
    const int found = hasClasses() ? firstOf(mask & telling, 0, shown) : -1;
    return found < 0 ? NO_CLASS : static_cast<uint8_t>(found);
  }
  /** Index of the lamp; -1: not known. */
  int lampOf(LayerMask mask) const {
    if (lampClasses > 0) return firstOf(mask, shown, lampClasses);
    return lamps == 1 ? 0 : -1;
  }
  /** Number of events on a photon's path, with the one where it is; 0: not known. */
  uint8_t depthOf(LayerMask mask) const {
    return static_cast<uint8_t>(1 + firstOf(mask, shown + lampClasses, depths));
  }

 private:
  size_t shown, lamps, depths, lampClasses;
  LayerMask telling = 0; ///< shown classes that do not have all paths
};

Json meshJson(const SceneMesh& mesh) {
  return {{"triangles", mesh.triangles()},
          {"before", mesh.before},
          {"positions", encodedNumbers(mesh.positions)},
          {"colours", encodedNumbers(mesh.colours)},
          {"objects", encodedNumbers(mesh.objects)},
          {"specular", encodedNumbers(mesh.specular)},
          {"names", mesh.names},
          {"sampledShapes", mesh.sampledShapes},
          {"curves", mesh.curves},
          {"shownCurves", mesh.shownCurves}};
}

/** Boxes of the media that have one. */
Json mediaJson(const Scene& scene) {
  Json media = Json::array();
  for (uint16_t i = 1; i <= scene.mediumCount(); ++i) {
    const Bounds3f box = scene.medium(i)->bounds();
    if (glm::length(box.diagonal()) < INFINITE) media.push_back({numbers(box.lower), numbers(box.upper)});
  }
  return media;
}

/** Rays of the camera: origins and directions at the corners of the picture, clockwise from the upper left
 * corner, then at its middle; null where there is no ray. */
Json cameraJson(const Scene& scene) {
  const PixelBounds& crop = scene.film().crop;
  const auto x0 = float(crop.x0), x1 = float(crop.x1), y0 = float(crop.y0), y1 = float(crop.y1);
  Json rays = Json::array();
  for (const Vec2f& film :
       {Vec2f(x0, y0), Vec2f(x1, y0), Vec2f(x1, y1), Vec2f(x0, y1), Vec2f((x0 + x1) / 2, (y0 + y1) / 2)}) {
    const std::optional<CameraRay> ray = scene.camera().validRay({film});
    rays.push_back(ray ? Json{{"origin", numbers(ray->origin)}, {"direction", numbers(ray->direction)}}
                       : Json(nullptr));
  }
  return rays;
}

/** Table of names that many entries share. */
class NameTable {
 public:
  size_t index(const std::string& name) {
    const auto [found, isNew] = known.try_emplace(name, names.size());
    if (isNew) names.push_back(name);
    return found->second;
  }
  std::vector<std::string> names;

 private:
  std::map<std::string, size_t> known;
};

/** All names of the lists, sorted. */
std::set<std::string> uniqueNames(std::initializer_list<const std::vector<PathNames::List>*> lists) {
  std::set<std::string> out;
  for (const auto* list : lists)
    for (const PathNames::List& names : *list) out.insert(names.begin(), names.end());
  return out;
}

std::string lobeName(LobeSet lobe) {
  if (lobe & MIRROR) return "mirror";
  if (lobe & REFRACTION) return "refraction";
  if (lobe & TRANSMISSION) return "transmission";
  return lobe & REFLECTION ? "reflection" : "";
}

/** Non-delta lobes, of which light samples, connections and merges evaluate the sum. */
std::string nonDeltaNames(LobeSet lobes, bool inMedium) {
  if (inMedium) return "phase";
  const bool both = (lobes & NON_DELTA_LOBES) == NON_DELTA_LOBES;
  return both ? "reflection, transmission" : lobeName(lobes & NON_DELTA_LOBES);
}

/** Surface at a point of it, seen from the unit direction `from`; empty: none is that near. */
std::optional<Hit> surfaceNear(const Scene& scene, const Vec3f& point, const Vec3f& from) {
  constexpr float NEAR = 1e-4f; // fraction of the scene's radius
  const float distance = NEAR * scene.bounds().radius;
  Ray ray;
  ray.origin = point + distance * from;
  ray.direction = -from;
  ray.tMax = 2 * distance;
  Hit hit;
  if (!scene.intersect(ray, hit)) return {};
  return hit;
}

/** Record of one pixel. Indices refer to entries of the same pixel. Each kind of entry is a list of lists,
 * whose columns pathView.js defines. */
class PixelJson {
 public:
  PixelJson(const Scene& scene, const PathNames& names, const MaskReader& reader, NameTable& table)
      : scene(scene), names(names), reader(reader), table(table) {}

  Json of(const RecordedPixel& pixel) {
    const PathRecorder& record = pixel.record;
    Json out = {
        {"x", pixel.x}, {"y", pixel.y}, {"value", numbers(pixel.value())}, {"splats", numbers(pixel.splats)}};
    for (const char* name : {"samples", "vertices", "steps", "estimates", "contributions", "lightVertices"})
      out[name] = Json::array();
    for (size_t i = 0; i < record.samples().size(); ++i)
      out["samples"].push_back(sample(record.samples()[i], record.endContribution(i)));
    for (const RecordedVertex& v : record.vertices()) out["vertices"].push_back(vertex(v));
    for (const RecordedStep& s : record.steps())
      out["steps"].push_back({s.vertex, std::string(1, "SDV"[size_t(s.event)]), table.index(lobeName(s.lobe)),
                              shortened(double(s.pdf)), shortened(double(s.pdfReverse)),
                              numbers(s.throughput), numbers(s.direction)});
    for (const RecordedEstimate& e : record.estimates())
      out["estimates"].push_back({e.vertex, e.caustic, shortened(double(e.radius)), e.photons});
    for (const RecordedContribution& c : record.contributions())
      out["contributions"].push_back(contribution(record, c));
    for (const RecordedLightVertex& v : record.lightVertices) out["lightVertices"].push_back(lightVertex(v));
    return out;
  }

 private:
  static Json sample(const RecordedSample& s, size_t end) {
    return {s.firstContribution, end, numbers(s.origin), numbers(s.direction), numbers(s.total)};
  }
  Json vertex(const RecordedVertex& v) {
    const std::string object = v.inMedium ? "medium" : scene.objectName(v.object);
    return {v.step,
            numbers(v.position),
            numbers(v.normal),
            table.index(object),
            table.index(v.material ? scene.materialName(v.material) : ""),
            v.inMedium,
            numbers(v.throughput),
            table.index(nonDeltaNames(v.lobes, v.inMedium)),
            v.inMedium ? Json::array() : surfaceNames(v.object, v.material)};
  }
  /** Names by which expressions know the surface. */
  Json surfaceNames(uint32_t object, const Material* material) {
    Json out = Json::array();
    for (const std::string& name : names.objects[object]) out.push_back(table.index(name));
    for (const std::string& name : names.materials[material ? material->number : 0])
      out.push_back(table.index(name));
    return out;
  }
  /** Names of the vertex of a light path; null where there is no event. */
  Json namesOf(const RecordedLightVertex& v) {
    if (v.kind == LightVertexKind::SURFACE) return surfaceNames(v.object, v.material);
    return v.kind == LightVertexKind::MEDIUM ? Json::array() : Json(nullptr);
  }
  std::string objectOf(const RecordedLightVertex& v) const {
    switch (v.kind) {
    case LightVertexKind::START:
      return "light";
    case LightVertexKind::MEDIUM:
      return "medium";
    case LightVertexKind::SURFACE:
      return scene.objectName(v.object);
    case LightVertexKind::ESCAPE:
      break;
    }
    return "";
  }
  Json lightVertex(const RecordedLightVertex& v) {
    return {v.previous,
            std::string(1, "SDV"[size_t(v.event)]),
            numbers(v.position),
            numbers(v.flux),
            table.index(objectOf(v)),
            table.index(v.material ? scene.materialName(v.material) : ""),
            table.index(nonDeltaNames(v.lobes, v.kind == LightVertexKind::MEDIUM)),
            table.index(lobeName(v.lobe)),
            shortened(double(v.pdf)),
            shortened(double(v.pdfReverse)),
            namesOf(v)};
  }
  /** Weights of all techniques: a list of technique, number of camera vertices, weight. */
  Json weights(const PathRecorder& record, const RecordedSource& s) {
    Json out = Json::array();
    for (size_t i = s.firstWeight; i < s.firstWeight + s.weightCount; ++i) {
      const RecordedWeight& w = record.weights[i];
      out.push_back({table.index(techniqueName(w.technique)), w.cameraVertices, shortened(double(w.weight))});
    }
    return out;
  }
  Json contribution(const PathRecorder& record, const RecordedContribution& c) {
    const RecordedSource& s = c.source;
    const char* omission = s.omission();
    return {table.index(techniqueName(s.technique)),
            s.vertex,
            s.step,
            s.estimate,
            numbers(s.end),
            s.isInfinite,
            shortened(double(s.weight)),
            shortened(double(s.pdf)),
            shortened(double(s.otherPdf)),
            reader.hasClasses() ? reader.classOf(c.classes) : UNCLASSIFIED,
            numbers(c.radiance),
            s.lightVertex,
            {shortened(double(s.vertexPdf)), shortened(double(s.vertexPdfReverse)),
             shortened(double(s.lightVertexPdf)), shortened(double(s.lightVertexPdfReverse))},
            weights(record, s),
            table.index(omission ? omission : ""),
            s.panes,
            reader.lampOf(c.classes)};
  }

  const Scene& scene;
  const PathNames& names;
  const MaskReader& reader;
  NameTable& table;
};

int8_t signedByte(float x) { return static_cast<int8_t>(std::lround(std::clamp(x, -1.0f, 1.0f) * 127)); }

/** Kind of the surface at a point, seen from the unit direction `from`. */
SurfaceKind surfaceKindAt(const Scene& scene, const PathClasses& classes, const Vec3f& point,
                          const Vec3f& from) {
  const std::optional<Hit> hit = surfaceNear(scene, point, from);
  if (!hit) return SurfaceKind();
  return classes.surfaceKind(hit->object, hit->material ? hit->material->number : 0);
}

/** Classes of a photon on a surface, whose path goes on by DE. */
LayerMask maskOf(const PathClasses& classes, const StoredPhoton& photon, SurfaceKind kind) {
  return classes.join(photon.state, classes.step(classes.cameraStart(), PathEvent::D, kind));
}

Json photonsJson(const PathClasses& classes, const MaskReader& reader, const Inspection& inspection) {
  std::vector<float> positions, powers;
  std::vector<int8_t> normals, directions;
  std::vector<uint8_t> kinds, depths;
  for (size_t i = 0; i < inspection.photons.size(); ++i) {
    const StoredPhoton& p = inspection.photons[i];
    positions.insert(positions.end(), {p.position.x, p.position.y, p.position.z});
    powers.insert(powers.end(), {p.power.r, p.power.g, p.power.b});
    for (int k = 0; k < 3; ++k) {
      normals.push_back(signedByte(p.normal[k]));
      directions.push_back(signedByte(p.direction[k]));
    }
    const LayerMask mask = maskOf(classes, p, inspection.kinds.empty() ? SurfaceKind() : inspection.kinds[i]);
    kinds.push_back(uint8_t(reader.classOf(mask) | (p.caustic ? CAUSTIC : 0)));
    depths.push_back(reader.depthOf(mask));
  }
  return {{"name", inspection.photonName},          {"limit", inspection.shownPhotons},
          {"count", inspection.photons.size()},     {"inMap", inspection.photonsInMap},
          {"positions", encodedNumbers(positions)}, {"powers", encodedNumbers(powers)},
          {"normals", encodedNumbers(normals)},     {"directions", encodedNumbers(directions)},
          {"kinds", encodedNumbers(kinds)},         {"depths", encodedNumbers(depths)}};
}

Json boxesJson(const std::vector<PhotonBox>& boxes) {
  std::vector<float> bounds;
  std::vector<uint8_t> levels, caustic;
  std::vector<uint32_t> photons;
  for (const PhotonBox& b : boxes) {
    for (const Vec3f& p : {b.box.lower, b.box.upper}) bounds.insert(bounds.end(), {p.x, p.y, p.z});
    levels.push_back(static_cast<uint8_t>(b.level));
    caustic.push_back(b.caustic);
    photons.push_back(static_cast<uint32_t>(b.photons));
  }
  return {{"count", boxes.size()},
          {"bounds", encodedNumbers(bounds)},
          {"levels", encodedNumbers(levels)},
          {"caustic", encodedNumbers(caustic)},
          {"photons", encodedNumbers(photons)}};
}

/** Vertices of light paths; `kinds` has the vertex's kind in the lowest two bits, then whether it is stored.
 */
Json lightPathsJson(const PathClasses& classes, const MaskReader& reader, const LightPathRecorder& record) {
  constexpr unsigned STORED = 4;
  std::vector<float> positions, powers;
  std::vector<int32_t> previous;
  std::vector<uint8_t> kinds, classOfVertex;
  for (const RecordedLightVertex& v : record.vertices()) {
    positions.insert(positions.end(), {v.position.x, v.position.y, v.position.z});
    powers.push_back(luminance(v.flux));
    previous.push_back(v.previous);
    kinds.push_back(static_cast<uint8_t>(unsigned(v.kind) | (v.stored ? STORED : 0)));
    const PathEvent seenBy = v.kind == LightVertexKind::MEDIUM ? PathEvent::V : PathEvent::D;
    const SurfaceKind kind = v.kind == LightVertexKind::SURFACE
                                 ? classes.surfaceKind(v.object, v.material ? v.material->number : 0)
                                 : SurfaceKind();
    classOfVertex.push_back(
        reader.classOf(classes.join(v.state, classes.step(classes.cameraStart(), seenBy, kind))));
  }
  return {{"paths", record.pathsRecorded()},   {"emitted", record.pathsEmitted()},
          {"count", record.vertices().size()}, {"positions", encodedNumbers(positions)},
          {"powers", encodedNumbers(powers)},  {"previous", encodedNumbers(previous)},
          {"kinds", encodedNumbers(kinds)},    {"classes", encodedNumbers(classOfVertex)}};
}

Json patchesJson(const Inspection& inspection) {
  std::vector<float> positions, radiosities, areas;
  std::vector<uint8_t> sides;
  std::vector<uint32_t> ends, columns;
  std::vector<uint16_t> rays;
  for (size_t i = 0; i < inspection.patches.size(); ++i) {
    const RadiosityPatch& patch = inspection.patches[i];
    const FormFactors& factors = inspection.factors[i];
    for (const Vec3f& p : patch.corners) positions.insert(positions.end(), {p.x, p.y, p.z});
    const Rgb radiosity = patch.radiosity(factors.side);
    radiosities.insert(radiosities.end(), {radiosity.r, radiosity.g, radiosity.b});
    areas.push_back(patch.area);
    sides.push_back(static_cast<uint8_t>(factors.side));
    for (const FormFactorHits& hits : factors.hits) {
      columns.push_back(hits.patch);
      rays.push_back(static_cast<uint16_t>(hits.rays));
    }
    ends.push_back(static_cast<uint32_t>(columns.size()));
  }
  return {{"count", inspection.patches.size()},
          {"rays", inspection.factorRays},
          {"positions", encodedNumbers(positions)},
          {"radiosities", encodedNumbers(radiosities)},
          {"areas", encodedNumbers(areas)},
          {"sides", encodedNumbers(sides)},
          {"ends", encodedNumbers(ends)},
          {"columns", encodedNumbers(columns)},
          {"hits", encodedNumbers(rays)}};
}

Json referenceJson(const Scene& scene, const ReferencePoint& r) {
  return {{"x", r.x},
          {"y", r.y},
          {"position", numbers(r.position)},
          {"normal", numbers(r.normal)},
          {"object", scene.objectName(r.object)},
          {"irradiance", numbers(r.irradiance)},
          {"error", shortened(double(r.standardError))},
          {"samples", r.samples}};
}

Json referencesJson(const Scene& scene, const std::vector<ReferencePoint>& references) {
  Json out = Json::array();
  for (const ReferencePoint& r : references) out.push_back(referenceJson(scene, r));
  return out;
}

} // namespace

std::vector<StoredPhoton> photonsOf(const Integrator& integrator, size_t most, size_t& inMap) {
  inMap = 0;
  integrator.visitPhotons([&](const StoredPhoton&) { ++inMap; });
  std::vector<StoredPhoton> out;
  if (most == 0) return out;
  // The map is in spatial order, so that a stride leaves photons everywhere.
  const size_t stride = (inMap + most - 1) / most;
  size_t i = 0;
  integrator.visitPhotons([&](const StoredPhoton& photon) {
    if (i++ % stride != 0) return;
    out.push_back(photon);
    out.back().power *= static_cast<float>(stride);
  });
  return out;
}

InspectClasses inspectClasses(const std::vector<PathClass>& shown, const Scene& scene,
                              const Integrator* integrator, size_t pixels) {
  constexpr size_t MOST_VALUES = 20'000'000; // pixels of all layers of the film
  constexpr size_t MOST_CLASSES = 64;
  const PathNames names = pathNames(scene, integrator);
  std::vector<std::string> lamps;
  for (const LampGroup& lamp : lampGroups(scene)) lamps.push_back(lamp.name);
  const bool isAlone = lamps.size() == 1 && !(integrator && integrator->addsLightOfNoLamp());
  for (const bool withLamps : {true, false})
    for (const size_t depths : {size_t(8), size_t(6), size_t(4), size_t(3), size_t(0)}) {
      std::vector<PathClass> all = shown;
      const auto add = [&](const std::string& expression) {
        all.push_back({" " + std::to_string(all.size()), expression});
      };
      if (withLamps && !isAlone)
        for (const std::string& lamp : lamps) {
          std::string quoted;
          for (const char c : lamp) quoted += c == '\'' ? "''" : std::string(1, c);
          add("L'" + quoted + "'.*E");
        }
      for (size_t depth = 1; depth <= depths; ++depth)
        add("L.{" + std::to_string(depth) + (depth == depths ? ",}E" : "}E"));
      const bool isLast = !withLamps && depths == 0;
      if (!isLast && (all.size() > MOST_CLASSES || all.size() * pixels > MOST_VALUES)) continue;
      try {
        return {PathClasses(all, names), shown.size(),
                withLamps || isAlone ? lamps : std::vector<std::string>(), depths};
      } catch (const Error&) { // too many states
        if (isLast) throw;
      }
    }
  return {};
}

std::vector<SurfaceKind> surfaceKindsOf(const Scene& scene, const PathClasses& classes,
                                        const std::vector<StoredPhoton>& photons) {
  std::vector<SurfaceKind> kinds;
  if (!classes.distinguishesSurfaces()) return kinds;
  for (const StoredPhoton& p : photons)
    kinds.push_back(glm::length(p.normal) > 0 ? surfaceKindAt(scene, classes, p.position, p.normal)
                                              : SurfaceKind());
  return kinds;
}

std::string photonExpression(const PathClasses& classes, const std::vector<StoredPhoton>& photons,
                             const std::string& photonPaths, const std::vector<SurfaceKind>& kinds,
                             size_t shown) {
  if (shown == 0) shown = classCount(classes);
  const LayerMask isShown = ~LayerMask(0) >> (64 - std::min<size_t>(shown, 64));
  LayerMask all = 0;
  for (size_t i = 0; i < photons.size(); ++i) {
    const LayerMask mask = isShown & maskOf(classes, photons[i], kinds.empty() ? SurfaceKind() : kinds[i]);
    if (mask == 0) return "";
    all |= mask;
  }
  std::string text;
  for (size_t i = 0; i < shown; ++i)
    if (all >> i & 1) text += (text.empty() ? "(" : " | (") + classes.classes()[i].expression + ")";
  return text.empty() ? "" : "(" + text + ") & (" + photonPaths + ")";
}

std::vector<std::string> recordNotes(const Integrator& integrator) {
  std::vector<std::string> notes;
  if (integrator.splats())
    notes.emplace_back(
        "Connections of light paths to the camera are not recorded: the picture has their light in "
        "addition to these paths.");
  if (const std::string supposed = integrator.suppositions(); !supposed.empty())
    notes.push_back("This integrator supposes " + supposed + ".");
  return notes;
}

std::string referenceText(const Scene& scene, const ReferencePoint& reference) {
  return referenceJson(scene, reference).dump();
}

std::string inspectPage(const Scene& scene, const PathClasses& classes, const Inspection& inspection) {
  const Vec3d origin = scene.origin();
  const MaskReader reader(classes, inspection);
  const PathNames pathNames = recurse::pathNames(scene);
  std::vector<PathClass> shown(classes.classes().begin(),
                               classes.classes().begin() + std::ptrdiff_t(reader.shownClasses()));
  if (!reader.hasClasses()) shown = defaultStillClasses(scene.hasMedia());
  Json classList = Json::array(), named = Json::array();
  for (const PathClass& c : shown) classList.push_back({{"name", c.name}, {"expression", c.expression}});
  for (const NamedPathClass& c : namedPathClasses())
    named.push_back({{"name", c.name}, {"expression", c.expression}});
  const PixelBounds& crop = scene.film().crop;
  Json picture = {{"name", "picture"},       {"width", crop.width()},
                  {"height", crop.height()}, {"x0", crop.x0},
                  {"y0", crop.y0},           {"exposure", automaticExposure(inspection.picture)}};
  addPixels(picture, inspection.picture);
  NameTable names;
  Json pixels = Json::array();
  for (const RecordedPixel& pixel : inspection.pixels)
    pixels.push_back(PixelJson(scene, pathNames, reader, names).of(pixel));
  const Json data = {{"title", inspection.title},
                     {"label", inspection.label},
                     {"origin", {origin.x, origin.y, origin.z}},
                     {"center", numbers(scene.bounds().center)},
                     {"radius", scene.bounds().radius},
                     {"classes", std::move(classList)},
                     {"namedClasses", std::move(named)},
                     {"lamps", inspection.lamps},
                     {"lightNames", uniqueNames({&pathNames.lights})},
                     {"surfaceNames", uniqueNames({&pathNames.objects, &pathNames.materials})},
                     {"depths", inspection.depths},
                     {"mesh", meshJson(meshOf(scene, MOST_TRIANGLES))},
                     {"media", mediaJson(scene)},
                     {"camera", cameraJson(scene)},
                     {"picture", std::move(picture)},
                     {"pixels", std::move(pixels)},
                     {"names", names.names},
                     {"notes", inspection.notes},
                     {"photons", photonsJson(classes, reader, inspection)},
                     {"boxes", boxesJson(inspection.boxes)},
                     {"lightPaths", lightPathsJson(classes, reader, inspection.lightPaths)},
                     {"references", referencesJson(scene, inspection.references)},
                     {"patches", patchesJson(inspection)},
                     {"live", inspection.isLive}};
  return htmlPage({page::INSPECT_HTML,
                   inspection.title + " · light in the scene",
                   {page::PAGE_CSS, page::INSPECT_CSS},
                   {page::THREE_MIN_JS, page::ORBIT_CONTROLS_JS},
                   {page::PIXELS_JS, page::PATH_EXPRESSION_JS, page::SCENE_VIEW_JS, page::PATH_VIEW_JS,
                    page::ESTIMATE_JS, page::PHOTON_VIEW_JS, page::FLIGHT_VIEW_JS, page::BOX_VIEW_JS,
                    page::PATCH_VIEW_JS, page::INSPECT_JS}},
                  data);
}

} // namespace recurse
