/** @file
 * Data of the page of light in a scene. Points are relative to Scene::origin() [scene units].
 */
#include "recurse/report/inspect/inspect.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "recurse/pathclasses/pathExpression.h"
#include "recurse/report/stills/stills.h"
#include "recurse/transport/integrator/sceneNames.h"
#include "report/inspect/pixelJson.h"
#include "report/inspect/sceneMesh.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse {

namespace {

constexpr size_t MOST_TRIANGLES = 200000;

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

/** All names of the lists, sorted. */
std::set<std::string> uniqueNames(std::initializer_list<const std::vector<PathNames::List>*> lists) {
  std::set<std::string> out;
  for (const auto* list : lists)
    for (const PathNames::List& names : *list) out.insert(names.begin(), names.end());
  return out;
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
