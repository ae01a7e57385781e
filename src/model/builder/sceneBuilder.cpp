/** @file
 * Construction of the scene from its description: plug-ins, light table, trees.
 */
#include <map>
#include <optional>
#include <set>
#include <span>

#include "model/builder/objectNames.h"
#include "model/builder/openBoundaries.h"
#include "model/builder/rayWork.h"
#include "model/builder/shapeGroups.h"
#include "model/embree/embreeScene.h"
#include "model/light/scaledLight.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/importExpansion.h"
#include "recurse/model/scene/keptParts.h"
#include "recurse/model/scene/scene.h"
#include "recurse/model/scene/sceneImport.h"
#include "recurse/model/scene/surroundingMedium.h"

namespace recurse {

namespace {

ParsedDirective orDefault(const ParsedDirective& given, const char* type) {
  ParsedDirective d = given;
  if (!d.given()) d.type = type;
  return d;
}

} // namespace

std::unique_ptr<Camera> makeCamera(const CameraDescription& camera, const SceneDescription& description,
                                   const FilmSettings& film, const Vec3d& origin, Diagnostics& diagnostics,
                                   bool lenient) {
  CameraContext context;
  context.sceneFromCamera =
      AnimatedTransform(camera.worldFromCamera, camera.worldFromCameraLast.value_or(camera.worldFromCamera))
          .after(translation(-origin));
  context.startTime = description.startTime;
  context.endTime = description.endTime;
  context.width = film.width;
  context.height = film.height;
  context.diagonal = film.diagonal;
  return plugIns().cameras.make(orDefault(camera.camera, "perspective"), context, diagnostics, lenient);
}

/** State and steps of buildScene(). */
class SceneBuilder {
 public:
  SceneBuilder(const SceneDescription& description, const SceneOverrides& overrides, Diagnostics& diagnostics,
               KeptParts* kept)
      : description(description), overrides(overrides), diagnostics(diagnostics), kept(kept),
        device(kept && kept->device ? kept->device : std::make_shared<EmbreeDevice>()),
        scene(std::make_unique<EmbreeScene>(device)), context{description, overrides.lenient, diagnostics,
                                                              scene->sceneOrigin},
        materials(context, scene->textures, scene->materials), media(context),
        shapes(context, materials, media, scene->shapes, kept) {
    if (!kept) return;
    kept->device = device;
    kept->shapes.kept = kept->shapes.made = kept->trees.kept = kept->trees.made = 0;
    kept->media.kept = kept->media.made = 0;
  }

  std::unique_ptr<Scene> build() {
    buildFilm();
    const WorkSum work;
    const bool complete =
        shapes.build(scene->filmSettings) && allowsRayWork(shapes, scene->filmSettings, diagnostics);
    if (complete) measure();
    buildCamera();
    buildLights();
    buildMedia();
    if (!complete) return nullptr;
    scene->materialNames = materials.names();
    scene->labelsOfMaterials = materials.labels();
    for (size_t i = 0; i < media.count(); ++i) scene->namesOfMedia.push_back(media.name(i));
    buildTrees();
    if (diagnostics.hasErrors()) return nullptr;
    warnOfOpenBoundaries(*scene, shapes, media, diagnostics);
    findSurroundingMedia();
    return std::move(scene);
  }

 private:
  static bool isUnit(const Vec3f& v) { return std::abs(glm::length(v) - 1) < 1e-3f; }

  void buildFilm() {
    const PlugIns& all = plugIns();
    if (auto film = all.films.make(orDefault(description.film, "rgb"), {}, diagnostics, overrides.lenient)) {
      scene->filmSettings = *film;
      FilmSettings& f = scene->filmSettings;
      if (overrides.width > 0) {
        f.width = overrides.width;
        f.height = overrides.height;
        f.crop = f.whole();
      }
      const auto& w = overrides.cropWindow;
      if (w[1] > w[0]) f.crop = cropOf(f, w[0], w[1], w[2], w[3]);
      if (f.crop.x0 >= f.crop.x1 || f.crop.y0 >= f.crop.y1)
        throw Error("the crop window contains no pixel", ExitStatus::BAD_USAGE);
    }
    scene->pixelFilter =
        all.filters.make(orDefault(description.filter, "gaussian"), {}, diagnostics, overrides.lenient);
    scene->pixelSampler =
        all.samplers.make(orDefault(description.sampler, "sobol"), {}, diagnostics, overrides.lenient);
    if (description.accelerator.given())
      all.accelerators.make(description.accelerator, {}, diagnostics, overrides.lenient);
    scene->mediumOfCamera = media.number(description.cameraMedium, description.camera.location);
  }

  void buildCamera() {
    const auto make = [this](const CameraDescription& camera) {
      return makeCamera(camera, description, scene->filmSettings, scene->sceneOrigin, diagnostics,
                        overrides.lenient);
    };
    scene->sceneCamera = make(description);
    for (const CameraDescription& other : description.otherCameras) { // to report its errors
      make(other);
      media.number(other.cameraMedium, other.camera.location);
    }
    if (!scene->sceneCamera) return;
    scene->filmSettings.imagingRatio *= scene->sceneCamera->exposureTime();
    const FilmSettings& f = scene->filmSettings;
    for (const Vec2f& corner : {Vec2f(0), Vec2f(f.width, 0), Vec2f(0, f.height), Vec2f(f.width, f.height)}) {
      const std::optional<CameraRay> ray = scene->sceneCamera->sampleRay({corner});
      // Rays from too far away, or with a vanishing direction, have no reliable intersections.
      if (!ray || (representable(ray->origin) && isUnit(ray->direction))) continue;
      diagnostics.error(description.camera.location,
                        "the camera's rays are not distinct in single precision: the camera is too far from "
                        "the scene, or its window is too large");
      break;
    }
  }

  /** Computes the scene's bounds and counts its contents. */
  void measure() {
    const Bounds3d b = shapes.bounds();
    if (!b.empty()) {
      scene->sceneBounds.center = Vec3f(b.center());
      scene->sceneBounds.radius = static_cast<float>(glm::length(b.diagonal()) / 2 * (1 + 1e-6));
    }
    shapes.count(scene->sceneContents);
    scene->sceneContents.materials = scene->materials.size();
    materials.numberNested(scene->nestedDielectrics, scene->nestedMedia);
  }

  /** Largest extinction of a medium [1/scene units], a power of two: its mean free path is a few times the
   * rounding error of positions on the boundary. Denser matter would trap the light that enters it. */
  float maxExtinctionOf(uint16_t medium) const {
    constexpr int RESOLVED_BITS = 20;
    const Bounds3d b = shapes.boundsOfMedium(medium);
    const Vec3d corner = glm::max(glm::abs(b.lower), glm::abs(b.upper));
    const double largest = std::max(corner.x, std::max(corner.y, corner.z));
    if (b.empty() || !(largest > 0)) return INFINITE;
    return static_cast<float>(std::ldexp(1.0, RESOLVED_BITS - std::ilogb(largest)));
  }

  /** Makes the media in use. Call when the scene's origin and bounds are known. */
  void buildMedia() {
    std::multimap<std::string, std::shared_ptr<Medium>> all;
    for (size_t i = 0; i < media.count() && !context.enoughErrors(); ++i) {
      const float maxExtinction = maxExtinctionOf(static_cast<uint16_t>(i + 1));
      const std::string key = kept ? media.key(i, maxExtinction) : "";
      std::shared_ptr<Medium> medium = kept ? kept->media.take(key) : nullptr;
      if (kept) ++(medium ? kept->media.kept : kept->media.made);
      if (!medium) medium = media.make(i, maxExtinction);
      all.emplace(key, medium);
      scene->sceneMedia.push_back(std::move(medium));
    }
    if (kept) kept->media.replace(std::move(all));
    scene->sceneContents.media = media.count();
    media.warnOfUnknownTypes();
  }

  /** Medium where all rays start, the camera or a lamp, by the surfaces around. Camera paths and light paths
   * must agree about media. Warns if it is not the `named` one, but not of lamps for which none is named.
   * `otherwise`: the medium where no surface and no name determines it; `what`: "camera" or "lamp". */
  SurroundingMedium surroundingMedium(std::span<const Ray> rays, uint16_t named, uint16_t otherwise,
                                      const std::string& what, const SourceLocation& where) {
    uint64_t traced = 0;
    const SurroundingMedium around = mediumAround(*scene, rays, named ? named : otherwise, traced);
    if (around.varies && what == "lamp") return {named ? named : otherwise, true};
    const uint16_t found = around.index;
    const std::string name = found ? media.name(found - 1u) : "";
    const bool isOfMaterial = found && name.empty(); // which no MediumInterface can name
    if (found != named && !isOfMaterial && (named != 0 || what == "camera"))
      diagnostics.warning(
          where, "the " + what + " is inside of " + media.title(found) + ", not of " + media.title(named),
          "MediumInterface \"\" \"" + name + "\" before it");
    return around;
  }

  /** Finds the media around the camera and the finite lights. */
  void findSurroundingMedia() {
    constexpr uint32_t RAYS = 16;
    if (!scene->hasMedia()) return;
    Sampler sampler(0, 0, 0);
    std::vector<Ray> rays;
    const float time = scene->sceneCamera->timeAt(0);
    const Vec2f size(scene->filmSettings.width, scene->filmSettings.height);
    for (uint32_t i = 0; i < RAYS; ++i)
      if (const std::optional<CameraRay> ray = scene->sceneCamera->sampleRay({size * sampler.next2D()}))
        rays.push_back({ray->origin, ray->direction, INFINITE, time});
    uint16_t& ofCamera = scene->mediumOfCamera;
    ofCamera = surroundingMedium(rays, ofCamera, 0, "camera", description.camera.location).index;
    for (size_t i = 0; i < scene->lights().size(); ++i) {
      const Light& light = scene->lights()[i];
      SurroundingMedium& medium = scene->mediaOfLights[i];
      if (light.isInfinite() || medium.varies) continue;
      rays.clear();
      for (uint32_t k = 0; k < RAYS; ++k) {
        const LeRandom random{sampler.next1D(), sampler.next2D(), sampler.next2D(), time};
        if (const std::optional<LeSample> s = light.sampleLe(random))
          rays.push_back({s->origin, s->direction, INFINITE, time});
      }
      medium = surroundingMedium(rays, medium.index, ofCamera, "lamp",
                                 scene->sceneLamps[scene->lampsOfLights[i]].location);
    }
  }

  /** Adds the lamp of a light's directive at a place: that directive, or the emitting shape. */
  void addLamp(const ParsedDirective& light, const ParsedDirective& place) {
    std::string name = givenName(light);
    if (name.empty()) name = givenName(place);
    if (name.empty()) {
      if (!givenNames) givenNames = allGivenNames();
      name = "light-" + std::to_string(scene->sceneLamps.size() + 1);
      while (givenNames->count(name) > 0) name += "_";
    }
    scene->sceneLamps.push_back({name, place.type, place.location});
  }

  /** Names that the scene gives to lights and shapes. */
  std::set<std::string> allGivenNames() const {
    std::set<std::string> names;
    const auto add = [&](const std::vector<ShapeDescription>& shapes) {
      for (const ShapeDescription& s : shapes) names.insert(givenName(s.shape));
    };
    add(description.shapes);
    for (const auto& [name, object] : description.objects) add(object.shapes);
    for (const LightDescription& l : description.lights) names.insert(givenName(l.light));
    for (const ParsedDirective& d : description.areaLights) names.insert(givenName(d));
    return names;
  }

  /** Product of the LightScale directives of a lamp. */
  Rgb scaleOf(const Lamp& lamp) const {
    Rgbd scale(1);
    for (const LightScaleDescription& s : description.lightScales)
      if (s.lamp == lamp.name) scale *= s.scale;
    return Rgb(scale);
  }

  void checkLightScales() {
    std::vector<std::string> names;
    for (const Lamp& lamp : scene->sceneLamps) names.push_back(lamp.name);
    for (const LightScaleDescription& s : description.lightScales)
      if (std::find(names.begin(), names.end(), s.lamp) == names.end())
        diagnostics.error(s.location, "there is no lamp named \"" + s.lamp + "\"",
                          names.empty() ? "no LightScale: the scene has no lamp" : lampsLike(s.lamp, names));
  }

  /** Names next to a wrong one, or some of all. */
  static std::string lampsLike(const std::string& wrong, const std::vector<std::string>& names) {
    constexpr size_t MOST = 8;
    std::vector<std::string> shown = nearestNames(wrong, names);
    if (!shown.empty()) return quotedList(shown);
    const std::set<std::string> all(names.begin(), names.end());
    for (const std::string& name : all)
      if (shown.size() < MOST) shown.push_back(name);
    return quotedList(shown) + (all.size() > MOST ? ", ..." : "");
  }

  /** Prepares and checks a light, and adds it to the table. */
  void keep(std::unique_ptr<Light> light, const SourceLocation& where, std::vector<const Light*>& table) {
    if (diagnostics.hasErrors()) return; // the scene's bounds may be unknown
    light->prepare(scene->sceneBounds);
    // The origin of a photon is checked as the light's position.
    const std::optional<LeSample> emission = light->sampleLe({0.5f, Vec2f(0.5f), Vec2f(0.25f)});
    if (!isFinite(light->power()) || (emission && !isFinite(emission->flux)))
      diagnostics.error(where, "the light's power is too large for single precision");
    else if (emission && !(representable(emission->origin) && isUnit(emission->direction)))
      diagnostics.error(where, "the light is too far from the scene for single precision",
                        "coordinates below 1e18");
    table.push_back(light.get());
    scene->ownLights.push_back(std::move(light));
  }

  void buildLights() {
    std::vector<const Light*> table;
    std::map<const ShapeDescription*, uint32_t> lampOfShape;
    const auto addAreaLight = [&](const ShapeGroups::Placed& p, const MatrixTrack& track) {
      if (p.from->areaLight < 0 || context.enoughErrors()) return;
      const ParsedDirective& d = description.areaLights[static_cast<size_t>(p.from->areaLight)];
      if (!p.shape->canBeSampled()) {
        diagnostics.error(p.from->shape.location,
                          "shape \"" + p.from->shape.type +
                              "\" cannot be a lamp: points on it cannot be sampled",
                          "another shape after the AreaLightSource");
        return;
      }
      std::unique_ptr<AreaLight> light =
          plugIns().areaLights.make(d, {*p.shape}, diagnostics, overrides.lenient);
      if (!light) return;
      if (track.moves()) light = std::make_unique<MovingAreaLight>(std::move(light), track);
      const auto [lamp, isNew] = lampOfShape.try_emplace(p.from, uint32_t(scene->sceneLamps.size()));
      if (isNew) addLamp(d, p.from->shape);
      if (const Rgb scale = scaleOf(scene->sceneLamps[lamp->second]); scale != Rgb(1))
        light = scaledAreaLight(std::move(light), scale);
      lightOf[p.shape] = {light.get(), static_cast<uint32_t>(table.size())};
      ++scene->sceneContents.areaLights;
      scene->lampsOfLights.push_back(lamp->second);
      scene->mediaOfLights.push_back({p.media.outside, p.media.isBoundary() && !isOpaque(p.material)});
      keep(std::move(light), d.location, table);
    };
    for (const ShapeGroups::Placed& p : shapes.groups().front().placed) addAreaLight(p, Mat4d(1));
    for (const ShapeGroups::Instance& i : shapes.instances())
      for (const ShapeGroups::Placed& p : shapes.groups()[i.group].placed)
        addAreaLight(p, shapes.sceneFromGroup(i));
    for (const LightDescription& l : description.lights) {
      if (context.enoughErrors()) return;
      std::unique_ptr<Light> light = plugIns().lights.make(
          l.light, {recentred(l.worldFromLight, scene->sceneOrigin), scene->sceneOrigin}, diagnostics,
          overrides.lenient);
      if (!light) continue;
      scene->lampsOfLights.push_back(uint32_t(scene->sceneLamps.size()));
      addLamp(l.light, l.light);
      if (const Rgb scale = scaleOf(scene->sceneLamps.back()); scale != Rgb(1))
        light = scaledLight(std::move(light), scale);
      if (const auto* e = dynamic_cast<const EnvironmentLight*>(light.get())) {
        scene->environmentLights.push_back(e);
        scene->environmentLightIndices.push_back(static_cast<uint32_t>(table.size()));
        ++scene->sceneContents.environmentLights;
      } else if (light->isDelta()) {
        ++scene->sceneContents.deltaLights;
      }
      scene->mediaOfLights.push_back({media.number(l.medium, l.light.location)});
      keep(std::move(light), l.light.location, table);
    }
    if (!diagnostics.hasErrors()) checkLightScales();
    scene->lightTable.build(table);
  }

  // ---- trees

  void buildTrees() {
    ObjectNamer objects(scene->objectNames, description);
    std::multimap<KeptParts::TreeKey, std::shared_ptr<GeometryGroup>> trees;
    for (size_t i = 0; i < shapes.groups().size(); ++i) {
      const std::vector<ShapeGroups::Placed>& placed = shapes.groups()[i].placed;
      KeptParts::TreeKey key;
      for (const ShapeGroups::Placed& p : placed)
        key.emplace_back(p.shape, maskOf(*p.shape, p.material, lightOf.contains(p.shape)));
      std::shared_ptr<GeometryGroup> tree = kept && i > 0 ? kept->trees.take(key) : nullptr;
      const bool isKept = tree != nullptr;
      if (kept && i > 0) ++(isKept ? kept->trees.kept : kept->trees.made);
      if (!tree) tree = std::make_shared<GeometryGroup>(device, overrides.compact);
      scene->groups.push_back(tree);
      if (!isKept) tree->reserve(placed.size());
      for (size_t k = 0; k < placed.size(); ++k) {
        const ShapeGroups::Placed& p = placed[k];
        const auto light = lightOf.find(p.shape);
        SceneGeometry g{p.shape, p.material, nullptr, 0, scene->groups.front().get(), p.media};
        if (i == 0) g.object = objects.objectAtTop(p.from, p.partOf);
        if (light != lightOf.end()) std::tie(g.light, g.lightIndex) = light->second;
        if (i == 0) {
          g.shapeIndex = static_cast<int>(scene->sceneShapes.size());
          scene->sceneShapes.push_back({p.shape, p.material});
        }
        isKept ? tree->update(k, g) : tree->add(g);
      }
      if (i > 0 && !isKept) tree->commit();
      if (i > 0) trees.emplace(std::move(key), std::move(tree));
    }
    if (kept) kept->trees.replace(std::move(trees));
    for (const ShapeGroups::Instance& i : shapes.instances()) {
      const MatrixTrack track = shapes.sceneFromGroup(i);
      scene->shapesMove = scene->shapesMove || track.moves();
      scene->groups.front()->addInstance(*scene->groups[i.group], track, objects.objectOf(i.from, i.partOf));
    }
    scene->groups.front()->commit();
    warnOfHidden(scene->findTouching());
  }

  void warnOfHidden(const std::set<const Shape*>& hidden) {
    for (const ShapeGroups::Placed& p : shapes.groups().front().placed)
      if (hidden.contains(p.shape))
        diagnostics.warning(
            p.from->shape.location,
            "this shape is not seen: light passes it, and an opaque surface is in the same place",
            "a Translate by a thousandth of its size, to the side that it is seen from");
  }

  const SceneDescription& description;
  const SceneOverrides& overrides;
  Diagnostics& diagnostics;
  KeptParts* kept; ///< null: nothing is kept
  std::shared_ptr<EmbreeDevice> device;
  std::unique_ptr<EmbreeScene> scene;
  BuildContext context;
  SceneMaterials materials;
  SceneMedia media;
  ShapeGroups shapes;
  std::map<const Shape*, std::pair<const AreaLight*, uint32_t>> lightOf;
  std::optional<std::set<std::string>> givenNames; ///< see allGivenNames(); found when first needed
};

std::unique_ptr<Scene> buildScene(const SceneDescription& description, const SceneOverrides& overrides,
                                  Diagnostics& diagnostics, KeptParts* kept) {
  if (!hasImports(description)) return SceneBuilder(description, overrides, diagnostics, kept).build();
  SceneDescription expanded = description;
  expandImports(expanded, diagnostics, overrides.lenient, kept);
  return SceneBuilder(expanded, overrides, diagnostics, kept).build();
}

} // namespace recurse
