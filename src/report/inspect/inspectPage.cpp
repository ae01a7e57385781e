/** @file
 * Data of the page of light in a scene. Points are relative to Scene::origin() [scene units].
 */
#include "recurse/report/inspect/inspect.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "recurse/report/stills/stills.h"
#include "report/inspect/sceneMesh.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t MOST_TRIANGLES = 200000;
constexpr uint8_t NO_CLASS = 127, CAUSTIC = 128;

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

/** The first class of a mask; NO_CLASS where there is none. */
uint8_t classOf(LayerMask mask) {
  return mask == 0 ? NO_CLASS : static_cast<uint8_t>(std::min(std::countr_zero(mask), int(NO_CLASS)));
}

Json meshJson(const SceneMesh& mesh) {
  Json boxes = Json::array();
  for (const Bounds3f& b : mesh.boxes) boxes.push_back({numbers(b.lower), numbers(b.upper)});
  return {{"triangles", mesh.triangles()},
          {"before", mesh.before},
          {"positions", encodedNumbers(mesh.positions)},
          {"colours", encodedNumbers(mesh.colours)},
          {"objects", encodedNumbers(mesh.objects)},
          {"names", mesh.names},
          {"boxes", std::move(boxes)}};
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

/** Record of one pixel. Indices refer to entries of the same pixel. Each kind of entry is a list of lists,
 * whose columns pathView.js defines. */
class PixelJson {
 public:
  PixelJson(const Scene& scene, NameTable& table) : scene(scene), table(table) {}

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
            table.index(nonDeltaNames(v.lobes, v.inMedium))};
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
            shortened(double(v.pdfReverse))};
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
            classOf(c.classes),
            numbers(c.radiance),
            s.lightVertex,
            {shortened(double(s.vertexPdf)), shortened(double(s.vertexPdfReverse)),
             shortened(double(s.lightVertexPdf)), shortened(double(s.lightVertexPdfReverse))},
            weights(record, s),
            table.index(omission ? omission : ""),
            s.panes};
  }

  const Scene& scene;
  NameTable& table;
};

int8_t signedByte(float x) { return static_cast<int8_t>(std::lround(std::clamp(x, -1.0f, 1.0f) * 127)); }

Json photonsJson(const PathClasses& classes, const Inspection& inspection) {
  std::vector<float> positions, powers;
  std::vector<int8_t> normals, directions;
  std::vector<uint8_t> kinds;
  const CameraState seen = classes.step(classes.cameraStart(), PathEvent::D);
  for (const StoredPhoton& p : inspection.photons) {
    positions.insert(positions.end(), {p.position.x, p.position.y, p.position.z});
    powers.insert(powers.end(), {p.power.r, p.power.g, p.power.b});
    for (int k = 0; k < 3; ++k) {
      normals.push_back(signedByte(p.normal[k]));
      directions.push_back(signedByte(p.direction[k]));
    }
    kinds.push_back(uint8_t(classOf(classes.join(p.state, seen)) | (p.caustic ? CAUSTIC : 0)));
  }
  return {{"name", inspection.photonName},          {"limit", inspection.shownPhotons},
          {"count", inspection.photons.size()},     {"inMap", inspection.photonsInMap},
          {"positions", encodedNumbers(positions)}, {"powers", encodedNumbers(powers)},
          {"normals", encodedNumbers(normals)},     {"directions", encodedNumbers(directions)},
          {"kinds", encodedNumbers(kinds)}};
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
Json lightPathsJson(const PathClasses& classes, const LightPathRecorder& record) {
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
    classOfVertex.push_back(classOf(classes.join(v.state, classes.step(classes.cameraStart(), seenBy))));
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

std::string photonExpression(const PathClasses& classes, const std::vector<StoredPhoton>& photons,
                             const std::string& photonPaths) {
  const CameraState seen = classes.step(classes.cameraStart(), PathEvent::D);
  LayerMask all = 0;
  for (const StoredPhoton& photon : photons) {
    const LayerMask mask = classes.join(photon.state, seen);
    if (mask == 0) return "";
    all |= mask;
  }
  std::string text;
  for (size_t i = 0; i < classes.layerCount(); ++i)
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
  Json classList = Json::array();
  for (const PathClass& c : classes.classes())
    classList.push_back({{"name", c.name}, {"expression", c.expression}});
  const PixelBounds& crop = scene.film().crop;
  Json picture = {{"name", "picture"},       {"width", crop.width()},
                  {"height", crop.height()}, {"x0", crop.x0},
                  {"y0", crop.y0},           {"exposure", automaticExposure(inspection.picture)}};
  addPixels(picture, inspection.picture);
  NameTable names;
  Json pixels = Json::array();
  for (const RecordedPixel& pixel : inspection.pixels) pixels.push_back(PixelJson(scene, names).of(pixel));
  const Json data = {{"title", inspection.title},
                     {"label", inspection.label},
                     {"origin", {origin.x, origin.y, origin.z}},
                     {"center", numbers(scene.bounds().center)},
                     {"radius", scene.bounds().radius},
                     {"classes", std::move(classList)},
                     {"mesh", meshJson(meshOf(scene, MOST_TRIANGLES))},
                     {"media", mediaJson(scene)},
                     {"camera", cameraJson(scene)},
                     {"picture", std::move(picture)},
                     {"pixels", std::move(pixels)},
                     {"names", names.names},
                     {"notes", inspection.notes},
                     {"photons", photonsJson(classes, inspection)},
                     {"boxes", boxesJson(inspection.boxes)},
                     {"lightPaths", lightPathsJson(classes, inspection.lightPaths)},
                     {"references", referencesJson(scene, inspection.references)},
                     {"patches", patchesJson(inspection)},
                     {"live", inspection.isLive}};
  return htmlPage(
      {page::INSPECT_HTML,
       inspection.title + " · light in the scene",
       {page::PAGE_CSS, page::INSPECT_CSS},
       {page::THREE_MIN_JS, page::ORBIT_CONTROLS_JS},
       {page::PIXELS_JS, page::SCENE_VIEW_JS, page::PATH_VIEW_JS, page::ESTIMATE_JS, page::PHOTON_VIEW_JS,
        page::FLIGHT_VIEW_JS, page::BOX_VIEW_JS, page::PATCH_VIEW_JS, page::INSPECT_JS}},
      data);
}

} // namespace recurse
