/** @file
 * From the description to the scene: every plug-in made, transforms baked, lights tabulated, trees built.
 */
#include "recurse/model/scene.h"

#include <algorithm>
#include <deque>
#include <map>

#include "model/embreeScene.h"
#include "recurse/model/moving.h"
#include "recurse/model/sceneImport.h"
#include "recurse/model/triangleMesh.h"

namespace recurse {

void LightTable::build(const std::vector<const Light*>& all) {
  std::vector<double> powers;
  for (const Light* light : all) powers.push_back(double(maxComponent(light->power())));
  build(all, powers);
}

void LightTable::build(const std::vector<const Light*>& all, const std::vector<double>& powers) {
  lights = all;
  probabilities.assign(all.size(), 0);
  cumulative.assign(all.size(), 0);
  double total = 0, sum = 0;
  for (const double power : powers) total += power;
  for (size_t i = 0; i < all.size(); ++i) {
    sum += powers[i];
    probabilities[i] = total > 0 ? static_cast<float>(powers[i] / total) : 0;
    cumulative[i] = total > 0 ? static_cast<float>(sum / total) : 0;
  }
}

size_t LightTable::chooseOfMany(float& u) const {
  const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, u);
  const auto i = static_cast<size_t>(found - cumulative.begin());
  const float below = i > 0 ? cumulative[i - 1] : 0;
  if (probabilities[i] > 0) u = std::clamp((u - below) / (cumulative[i] - below), 0.0f, ONE_MINUS_EPSILON);
  return i;
}

void Scene::intersectBatch(std::span<const Ray> rays, Coherence, std::span<Hit> hits) const {
  for (size_t i = 0; i < rays.size(); ++i)
    if (!intersect(rays[i], hits[i])) hits[i].t = INFINITE;
}

void Scene::occludedBatch(std::span<const Ray> rays, std::span<uint8_t> blocked) const {
  for (size_t i = 0; i < rays.size(); ++i) blocked[i] = occluded(rays[i]);
}

/** The work of buildScene, with what it has to remember meanwhile. */
class SceneBuilder final : public TextureLookup, public ShapeLookup {
 public:
  SceneBuilder(const SceneDescription& description, const SceneOverrides& overrides, Diagnostics& diagnostics)
      : description(description), overrides(overrides), diagnostics(diagnostics),
        scene(std::make_unique<EmbreeScene>()) {}

  std::unique_ptr<Scene> build() {
    scene->sceneOrigin = guessOrigin();
    buildFilm();
    const bool complete = buildShapes();
    buildCamera();
    buildLights();
    if (!complete) return nullptr;
    buildTrees();
    if (diagnostics.hasErrors()) return nullptr;
    return std::move(scene);
  }

  TexturedRgb rgb(const Parameters& p, const std::string& name) const override {
    return lookUp(p, name, true);
  }
  TexturedRgb real(const Parameters& p, const std::string& name) const override {
    return lookUp(p, name, false);
  }

 private:
  /** A shape with its place in a group, before the lights are known. */
  struct Placed {
    const Shape* shape;
    const Material* material;
    const ShapeDescription* from;
  };
  struct Group {
    Vec3d origin{0}; ///< taken off the object's positions
    std::vector<Placed> placed;
  };

  /** A group in the scene: world from instance space, and that from the space of a shape that moves. */
  struct GroupInstance {
    size_t group;
    AnimatedTransform instance, shape;
  };

  /** Squares of coordinates must fit single precision. */
  static constexpr float LARGEST_COORDINATE = 1e18f;
  static constexpr size_t MAX_ERRORS = 50;
  static constexpr const char* LATER_MEDIA = "participating media are not rendered yet";

  /** True after so many errors that more would only bury the first ones; says so once. */
  bool enoughErrors() {
    if (diagnostics.errors() < MAX_ERRORS) return false;
    if (!saidEnough) diagnostics.warning({}, "further errors are not shown");
    saidEnough = true;
    return true;
  }

  static bool representable(const Vec3f& p) {
    return glm::all(
        glm::lessThanEqual(glm::abs(p), Vec3f(LARGEST_COORDINATE))); // false for what is no number
  }

  static std::string quotedList(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& n : names) list += (list.empty() ? "\"" : ", \"") + n + "\"";
    return list;
  }

  std::vector<std::string> objectNames() const {
    std::vector<std::string> names;
    for (const auto& object : description.objects) names.push_back(object.first);
    return names;
  }

  static bool isUnit(const Vec3f& v) { return std::abs(glm::length(v) - 1) < 1e-3f; }

  Mat4d recentred(const Mat4d& worldFromObject, const Vec3d& origin) const {
    Mat4d m = worldFromObject;
    m[3] -= Vec4d(origin, 0);
    return m;
  }

  AnimatedTransform recentred(const AnimatedTransform& m) const {
    return m.after(translation(-scene->sceneOrigin));
  }

  static Mat4d translation(const Vec3d& by) {
    Mat4d m(1);
    m[3] = Vec4d(by, 1);
    return m;
  }

  // ---- where the scene is

  /** Adds what the description alone tells about a shape's place. */
  static void addPlace(const ShapeDescription& s, const Mat4d& m, Bounds3d& bounds) {
    for (const ParsedParameter& p : s.shape.parameters)
      if (p.name == "P" && p.numbers.size() >= 3) {
        for (size_t i = 0; i + 2 < p.numbers.size(); i += 3)
          bounds.add(transformPoint(m, {p.numbers[i], p.numbers[i + 1], p.numbers[i + 2]}));
        return;
      }
    bounds.add(Vec3d(m[3]));
  }

  /** Positions near the origin keep their digits; a scene that surrounds the origin stays as it is. */
  static Vec3d originOf(const Bounds3d& b) {
    if (b.empty()) return Vec3d(0);
    const Vec3d c = b.center();
    const double size = glm::length(b.diagonal());
    const bool usable = std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z);
    return usable && glm::length(c) > 0.5 * size ? c : Vec3d(0);
  }

  Vec3d guessOrigin() const {
    Bounds3d b;
    for (const ShapeDescription& s : description.shapes) addPlace(s, s.worldFromObject, b);
    for (const InstanceDescription& i : description.instances) b.add(Vec3d(i.worldFromInstance[3]));
    return originOf(b);
  }

  // ---- film, filter, sampler, camera

  static ParsedDirective orDefault(const ParsedDirective& given, const char* type) {
    ParsedDirective d = given;
    if (!d.given()) d.type = type;
    return d;
  }

  void buildFilm() {
    const PlugIns& all = plugIns();
    if (auto film = all.films.make(orDefault(description.film, "rgb"), {}, diagnostics, overrides.lenient)) {
      scene->filmSettings = *film;
      FilmSettings& f = scene->filmSettings;
      if (overrides.width > 0) {
        f.width = overrides.width;
        f.height = overrides.height;
        f.crop = {0, 0, f.width, f.height};
      }
      const auto& w = overrides.cropWindow;
      if (w[1] > w[0]) f.crop = cropOf(f, double(w[0]), double(w[1]), double(w[2]), double(w[3]));
      if (f.crop.x0 >= f.crop.x1 || f.crop.y0 >= f.crop.y1)
        throw Error("no pixel lies in the crop window", ExitStatus::BAD_USAGE);
    }
    scene->pixelFilter =
        all.filters.make(orDefault(description.filter, "gaussian"), {}, diagnostics, overrides.lenient);
    if (auto s =
            all.samplers.make(orDefault(description.sampler, "zsobol"), {}, diagnostics, overrides.lenient))
      scene->samplerSettings = *s;
    if (description.accelerator.given())
      all.accelerators.make(description.accelerator, {}, diagnostics, overrides.lenient);
    if (!description.cameraMedium.empty()) diagnostics.error(description.camera.location, LATER_MEDIA);
  }

  void buildCamera() {
    CameraContext context;
    context.sceneFromCamera = recentred(AnimatedTransform(
        description.worldFromCamera, description.worldFromCameraLast.value_or(description.worldFromCamera)));
    context.startTime = description.startTime;
    context.endTime = description.endTime;
    context.width = scene->filmSettings.width;
    context.height = scene->filmSettings.height;
    context.diagonal = scene->filmSettings.diagonal;
    scene->sceneCamera = plugIns().cameras.make(orDefault(description.camera, "perspective"), context,
                                                diagnostics, overrides.lenient);
    if (!scene->sceneCamera) return;
    scene->filmSettings.imagingRatio *= scene->sceneCamera->exposureTime();
    const FilmSettings& f = scene->filmSettings;
    for (const Vec2f& corner : {Vec2f(0), Vec2f(f.width, 0), Vec2f(0, f.height), Vec2f(f.width, f.height)}) {
      const std::optional<CameraRay> ray = scene->sceneCamera->sampleRay({corner});
      // A ray from too far away, or of a direction that has come to nothing, meets anything or nothing.
      if (!ray || (representable(ray->origin) && isUnit(ray->direction))) continue;
      diagnostics.error(description.camera.location,
                        "the camera's rays cannot be told in single precision: it is "
                        "too far from the scene, or its window is too large");
      break;
    }
  }

  // ---- textures and materials, made when they are first used

  /** The first of the nested materials that is the same matter: priority and index are; or their number. */
  size_t sameNested(const Material& material) const {
    const auto same = [&](const Material* m) {
      return m->priority() == material.priority() && m->indexInside() == material.indexInside();
    };
    return static_cast<size_t>(std::find_if(nested.begin(), nested.end(), same) - nested.begin());
  }

  TexturedRgb lookUp(const Parameters& p, const std::string& name, bool spectrum) const {
    const std::string texture = p.texture(name);
    if (texture.empty()) return {spectrum ? Rgb(p.spectrum(name)) : Rgb(static_cast<float>(p.real(name)))};
    const auto [lowest, highest] = p.range(name);
    const auto textured = [&, low = float(lowest), high = float(highest)](const Texture* t) {
      return TexturedRgb{BLACK, t, low, high};
    };
    const auto key = std::make_pair(texture, spectrum);
    const auto found = texturesByName.find(key);
    if (found != texturesByName.end()) {
      if (found->second.underWay) p.fail(name, "texture \"" + texture + "\" is made of itself");
      return textured(found->second.texture);
    }
    std::vector<std::string> names;
    for (auto t = description.textures.rbegin(); t != description.textures.rend(); ++t) {
      if (t->spectrum != spectrum) continue;
      if (t->name != texture) {
        names.push_back(t->name);
        continue;
      }
      texturesByName[key] = {nullptr, true};
      const TextureContext context{*this, spectrum, t->worldFromTexture, &scene->sceneOrigin};
      std::unique_ptr<Texture> made =
          plugIns().textures.make(t->texture, context, diagnostics, overrides.lenient);
      const Texture* pointer = made.get();
      if (made) scene->textures.push_back(std::move(made));
      texturesByName[key] = {pointer, false};
      return textured(pointer);
    }
    p.fail(name,
           "there is no " + std::string(spectrum ? "spectrum" : "float") + " texture \"" + texture + "\"",
           quotedList(nearestNames(texture, names)));
  }

  const Material* makeMaterial(const ParsedDirective& d) {
    const MaterialContext context{
        *this, [this](const Parameters& p, const std::string& parameter, const std::string& name) {
          SourceLocation where = p.location(parameter);
          const Material* m = namedMaterial(name, where);
          if (!m) p.fail(parameter, "material \"" + name + "\" cannot be used here");
          if (m->detail)
            p.fail(parameter,
                   "material \"" + name + "\" has bumps of its own, and cannot be a part of another",
                   "\"displacement\" or \"normalmap\" of \"" + p.plugInName() + "\" itself");
          return m;
        }};
    std::unique_ptr<Material> m = plugIns().materials.make(d, context, diagnostics, overrides.lenient);
    if (!m) return nullptr;
    if (m->priority() > 0) {
      if (sameNested(*m) == nested.size() && ++nestedKinds > Scene::MAX_NESTED)
        diagnostics.error(d.location,
                          "there are more than " + std::to_string(Scene::MAX_NESTED) +
                              " dielectrics with a priority that differ",
                          "a priority and eta that another has too");
      nested.push_back(m.get());
    }
    scene->materials.push_back(std::move(m));
    return scene->materials.back().get();
  }

  const Material* namedMaterial(const std::string& name, const SourceLocation& where) {
    const auto known = materialsByName.find(name);
    if (known != materialsByName.end()) {
      if (known->second.underWay) diagnostics.error(where, "material \"" + name + "\" is made of itself");
      return known->second.material;
    }
    const auto found = description.namedMaterials.find(name);
    if (found == description.namedMaterials.end()) {
      std::vector<std::string> names;
      for (const auto& entry : description.namedMaterials) names.push_back(entry.first);
      diagnostics.error(where, "there is no material named \"" + name + "\"",
                        quotedList(nearestNames(name, names)));
      materialsByName[name] = {};
      return nullptr;
    }
    materialsByName[name] = {nullptr, true};
    const Material* m = makeMaterial(found->second);
    materialsByName[name] = {m, false};
    return m;
  }

  const Material* material(const MaterialReference& r) {
    switch (r.kind) {
    case MaterialReference::Kind::NONE:
      return nullptr;
    case MaterialReference::Kind::NAME:
      return namedMaterial(r.name, r.location);
    case MaterialReference::Kind::INDEX:
      break;
    }
    const auto i = static_cast<size_t>(r.index);
    if (materialsByIndex.size() <= i) materialsByIndex.resize(description.materials.size());
    if (!materialsByIndex[i].first) materialsByIndex[i] = {true, makeMaterial(description.materials[i])};
    return materialsByIndex[i].second;
  }

  // ---- shapes

  /** Makes a shape into `group`, unless it can neither be seen nor stop light. */
  void addShape(const ShapeDescription& s, const Mat4d& placement, Group& group) {
    if (enoughErrors()) return;
    if (!s.medium.inside.empty() || !s.medium.outside.empty()) {
      diagnostics.error(s.shape.location, LATER_MEDIA);
      return;
    }
    const Material* m = material(s.material);
    const Mat4d sceneFromObject = recentred(placement, group.origin);
    const double determinant = glm::determinant(Mat3d(sceneFromObject));
    if (!std::isfinite(determinant) || determinant == 0) {
      diagnostics.error(s.shape.location, "the shape's transform flattens it: it cannot be inverted");
      return;
    }
    const ShapeContext context{sceneFromObject, s.reverseOrientation, this, this, m};
    std::unique_ptr<Shape> shape = plugIns().shapes.make(s.shape, context, diagnostics, overrides.lenient);
    if (!shape || shape->primitiveCount() == 0) return;
    const bool scatters = (m && m->lobes() != NO_LOBE) || !shape->componentMaterials().empty();
    if (s.areaLight < 0 && !scatters) return;
    const Bounds3f bounds = shape->bounds();
    if (!representable(bounds.lower) || !representable(bounds.upper)) {
      diagnostics.error(s.shape.location,
                        "the shape is too large, or too far from the rest, for single precision",
                        "coordinates below 1e18");
      return;
    }
    group.placed.push_back({shape.get(), m, &s});
    scene->shapes.push_back(std::move(shape));
  }

  std::vector<ComponentShape> object(const Parameters& p, const std::string& parameter,
                                     const std::string& name, const ShapeContext& context) override {
    const auto found = description.objects.find(name);
    if (found == description.objects.end()) {
      const std::vector<std::string> names = objectNames();
      p.fail(parameter, "there is no object named \"" + name + "\"",
             names.empty() ? "the name of an ObjectBegin" : quotedList(nearestNames(name, names)));
    }
    if (std::find(objectsUnderWay.begin(), objectsUnderWay.end(), name) != objectsUnderWay.end())
      p.fail(parameter, "object \"" + name + "\" is made of itself");
    objectsUnderWay.push_back(name);
    std::vector<ComponentShape> made;
    for (const ShapeDescription& s : found->second.shapes) {
      if (enoughErrors()) break;
      const Material* m = material(s.material);
      const ShapeContext inner{context.sceneFromObject * s.worldFromObject, s.reverseOrientation, this, this,
                               m};
      const double determinant = glm::determinant(Mat3d(inner.sceneFromObject));
      if (s.worldFromObjectLast)
        diagnostics.error(s.shape.location, "a part of another shape does not move by itself",
                          "the whole's Shape under the motion");
      else if (s.areaLight >= 0)
        diagnostics.error(s.shape.location, "a part of another shape does not emit by itself",
                          "the AreaLightSource at the shape that it is a part of");
      else if (!std::isfinite(determinant) || determinant == 0)
        diagnostics.error(s.shape.location, "the shape's transform flattens it: it cannot be inverted");
      else if (auto shape = plugIns().shapes.make(s.shape, inner, diagnostics, overrides.lenient))
        made.push_back({std::move(shape), m, s.shape.location});
    }
    objectsUnderWay.pop_back();
    return made;
  }

  static Bounds3d boundsOf(const Group& g) {
    Bounds3d b;
    for (const Placed& p : g.placed) {
      const Bounds3f s = p.shape->bounds();
      if (s.empty()) continue;
      b.add(Vec3d(s.lower) + g.origin);
      b.add(Vec3d(s.upper) + g.origin);
    }
    return b;
  }

  /** Fills a group; a second time, better centred, when the first guess of its place was bad. */
  template <class Fill> void fillGroup(Group& group, const Fill& fill) {
    const size_t shapesBefore = scene->shapes.size();
    fill();
    const Bounds3d b = boundsOf(group);
    if (b.empty() || diagnostics.hasErrors()) return;
    if (glm::length(b.center() - group.origin) <= 2 * glm::length(b.diagonal())) return;
    group.origin = originOf(b);
    group.placed.clear();
    scene->shapes.resize(shapesBefore);
    fill();
  }

  bool buildShapes() {
    Group& top = groups.emplace_back();
    top.origin = scene->sceneOrigin;
    std::map<std::string, size_t> groupOf;
    fillGroup(top, [&] {
      for (const ShapeDescription& s : description.shapes)
        if (!s.worldFromObjectLast) addShape(s, s.worldFromObject, top);
      // Emitting shapes of an object are baked, one for each instance: a light has one place.
      for (const InstanceDescription& i : description.instances) {
        const auto object = description.objects.find(i.object);
        if (object == description.objects.end()) continue;
        for (const ShapeDescription& s : object->second.shapes)
          if (s.areaLight >= 0 && !movesAlone(s, i))
            addShape(s, i.worldFromInstance * s.worldFromObject, top);
      }
    });
    scene->sceneOrigin = groups.front().origin;
    for (const InstanceDescription& i : description.instances) {
      if (enoughErrors()) break;
      const auto object = description.objects.find(i.object);
      if (object == description.objects.end()) {
        diagnostics.error(i.location, "there is no object named \"" + i.object + "\"",
                          quotedList(objectNames()));
        continue;
      }
      const double determinant = glm::determinant(Mat3d(i.worldFromInstance));
      if (!std::isfinite(determinant) || determinant == 0) {
        diagnostics.error(i.location, "the instance's transform flattens it: it cannot be inverted");
        continue;
      }
      if (!groupOf.count(i.object)) {
        groupOf[i.object] = groups.size();
        Group& g = groups.emplace_back();
        Bounds3d place;
        for (const ShapeDescription& s : object->second.shapes) addPlace(s, s.worldFromObject, place);
        g.origin = originOf(place);
        fillGroup(g, [&] {
          for (const ShapeDescription& s : object->second.shapes)
            if (s.areaLight < 0 && !s.worldFromObjectLast) addShape(s, s.worldFromObject, g);
        });
      }
      if (!groups[groupOf[i.object]].placed.empty())
        instances.push_back({groupOf[i.object], motionOf(i), {}});
      for (const ShapeDescription& s : object->second.shapes)
        if (movesAlone(s, i)) addMoving(s, motionOf(i), i.location);
    }
    for (const ShapeDescription& s : description.shapes)
      if (s.worldFromObjectLast) addMoving(s, {}, s.shape.location);
    if (diagnostics.hasErrors()) return false;
    measure();
    return true;
  }

  // ---- motion

  static AnimatedTransform motionOf(const ShapeDescription& s) {
    return {s.worldFromObject, s.worldFromObjectLast.value_or(s.worldFromObject)};
  }
  static AnimatedTransform motionOf(const InstanceDescription& i) {
    return {i.worldFromInstance, i.worldFromInstanceLast.value_or(i.worldFromInstance)};
  }
  /** Whether a shape of an object definition moves otherwise than the rest of it, or is a lamp that moves: it
   * is a group of its own then. */
  static bool movesAlone(const ShapeDescription& s, const InstanceDescription& i) {
    return s.worldFromObjectLast || (s.areaLight >= 0 && i.worldFromInstanceLast);
  }

  /** A moving shape as a group of its own, as it is at the start. */
  void addMoving(const ShapeDescription& s, const AnimatedTransform& instance, const SourceLocation& where) {
    if (enoughErrors()) return;
    const AnimatedTransform motion = motionOf(s);
    const auto volume = [&](const Mat4d& a, const Mat4d& b) { return glm::determinant(Mat3d(a) * Mat3d(b)); };
    const double first = volume(instance.start(), motion.start()),
                 last = volume(instance.end(), motion.end());
    if (!std::isfinite(first) || !std::isfinite(last) || !(first * last > 0)) {
      diagnostics.error(where, "a transform of the motion flattens the shape or turns it inside out");
      return;
    }
    const size_t index = groups.size();
    Group& g = groups.emplace_back();
    Bounds3d place;
    addPlace(s, s.worldFromObject, place);
    g.origin = originOf(place);
    fillGroup(g, [&] { addShape(s, s.worldFromObject, g); });
    if (!g.placed.empty()) instances.push_back({index, instance, motion});
  }

  MatrixTrack sceneFromGroup(const GroupInstance& i) const {
    const Mat4d fromStart = glm::inverse(i.shape.start()) * translation(groups[i.group].origin);
    const auto at = [&](double time) {
      return recentred(i.instance.at(time) * i.shape.at(time), scene->sceneOrigin) * fromStart;
    };
    if (!i.instance.moves() && !i.shape.moves()) return at(0);
    // The product of two motions is curved even where neither turns.
    constexpr int CURVED = 16, MAX_PARTS = 128; // Embree has no more
    const int parts = i.instance.moves() && i.shape.moves()
                          ? std::min(CURVED + i.instance.linearParts() + i.shape.linearParts(), MAX_PARTS)
                          : std::max(i.instance.linearParts(), i.shape.linearParts());
    std::vector<Mat4d> steps;
    for (int k = 0; k <= parts; ++k) steps.push_back(at(double(k) / parts));
    return MatrixTrack(steps);
  }

  /** The scene's bounds, and what it contains. */
  void measure() {
    Bounds3d b;
    for (const Placed& p : groups.front().placed) {
      const Bounds3f s = p.shape->bounds();
      b.add(Vec3d(s.lower));
      b.add(Vec3d(s.upper));
    }
    for (const GroupInstance& i : instances) {
      const Bounds3d local = boundsOf(groups[i.group]);
      const MatrixTrack track = sceneFromGroup(i);
      for (const Mat4d& step : track.steps()) {
        const Mat4d m = step * translation(-groups[i.group].origin);
        for (int corner = 0; corner < 8; ++corner)
          b.add(transformPoint(m, {corner & 1 ? local.upper.x : local.lower.x,
                                   corner & 2 ? local.upper.y : local.lower.y,
                                   corner & 4 ? local.upper.z : local.lower.z}));
      }
    }
    if (!b.empty()) {
      scene->sceneBounds.center = Vec3f(b.center());
      scene->sceneBounds.radius = static_cast<float>(glm::length(b.diagonal()) / 2 * (1 + 1e-6));
    }
    SceneContents& c = scene->sceneContents;
    for (const Group& g : groups)
      for (const Placed& p : g.placed) {
        ++c.shapes;
        (p.shape->triangleMesh() ? c.triangles : c.otherPrimitives) += p.shape->primitiveCount();
        for (const Material* m : p.shape->componentMaterials())
          if (m) c.lobes |= m->lobes();
        if (p.material) c.lobes |= p.material->lobes();
      }
    c.instances = instances.size();
    c.materials = scene->materials.size();
    std::stable_sort(nested.begin(), nested.end(),
                     [](const Material* a, const Material* b) { return a->priority() > b->priority(); });
    for (size_t i = 0; i < nested.size(); ++i) {
      const size_t same = sameNested(*nested[i]);
      if (same < i) {
        nested[i]->nesting = nested[same]->nesting;
        continue;
      }
      nested[i]->nesting = static_cast<int>(scene->nestedDielectrics.size());
      scene->nestedDielectrics.push_back(nested[i]->indexInside());
    }
  }

  // ---- lights

  void buildLights() {
    std::vector<const Light*> table;
    const auto keep = [&](std::unique_ptr<Light> light, const SourceLocation& where) {
      if (diagnostics.hasErrors()) return; // where the scene ends may not be known
      light->prepare(scene->sceneBounds);
      // A light is where its photons start.
      const std::optional<LeSample> emission = light->sampleLe({0.5f, Vec2f(0.5f), Vec2f(0.25f)});
      if (!isFinite(light->power()) || (emission && !isFinite(emission->flux)))
        diagnostics.error(where, "the light's power is too large for single precision");
      else if (emission && !(representable(emission->origin) && isUnit(emission->direction)))
        diagnostics.error(where, "the light is too far from the scene for single precision",
                          "coordinates below 1e18");
      table.push_back(light.get());
      scene->ownLights.push_back(std::move(light));
    };
    const auto addAreaLight = [&](const Placed& p, const MatrixTrack& track) {
      if (p.from->areaLight < 0 || enoughErrors()) return;
      const ParsedDirective& d = description.areaLights[static_cast<size_t>(p.from->areaLight)];
      if (!p.shape->canBeSampled()) {
        diagnostics.error(p.from->shape.location,
                          "shape \"" + p.from->shape.type +
                              "\" cannot be a lamp: no points are sampled on it",
                          "another shape after the AreaLightSource");
        return;
      }
      std::unique_ptr<AreaLight> light =
          plugIns().areaLights.make(d, {*p.shape}, diagnostics, overrides.lenient);
      if (!light) return;
      if (track.moves()) light = std::make_unique<MovingAreaLight>(std::move(light), track);
      lightOf[p.shape] = {light.get(), static_cast<uint32_t>(table.size())};
      ++scene->sceneContents.areaLights;
      keep(std::move(light), d.location);
    };
    for (const Placed& p : groups.front().placed) addAreaLight(p, Mat4d(1));
    for (const GroupInstance& i : instances)
      for (const Placed& p : groups[i.group].placed) addAreaLight(p, sceneFromGroup(i));
    for (const LightDescription& l : description.lights) {
      if (enoughErrors()) return;
      if (!l.medium.empty()) {
        diagnostics.error(l.light.location, LATER_MEDIA);
        continue;
      }
      std::unique_ptr<Light> light = plugIns().lights.make(
          l.light, {recentred(l.worldFromLight, scene->sceneOrigin), scene->sceneOrigin}, diagnostics,
          overrides.lenient);
      if (!light) continue;
      if (const auto* e = dynamic_cast<const EnvironmentLight*>(light.get())) {
        scene->environmentLights.push_back(e);
        scene->environmentLightIndices.push_back(static_cast<uint32_t>(table.size()));
        ++scene->sceneContents.environmentLights;
      } else if (light->isDelta()) {
        ++scene->sceneContents.deltaLights;
      }
      keep(std::move(light), l.light.location);
    }
    scene->lightTable.build(table);
  }

  // ---- trees

  void buildTrees() {
    for (size_t i = 0; i < groups.size(); ++i) {
      auto& made = scene->groups.emplace_back(std::make_unique<GeometryGroup>(scene->device));
      made->reserve(groups[i].placed.size());
      for (const Placed& p : groups[i].placed) {
        const auto light = lightOf.find(p.shape);
        SceneGeometry g{p.shape, p.material, nullptr, 0, scene->groups.front().get()};
        if (light != lightOf.end()) std::tie(g.light, g.lightIndex) = light->second;
        made->add(g);
      }
      if (i > 0) made->commit();
    }
    for (const GroupInstance& i : instances) {
      const MatrixTrack track = sceneFromGroup(i);
      scene->shapesMove = scene->shapesMove || track.moves();
      scene->groups.front()->addInstance(*scene->groups[i.group], track);
    }
    scene->groups.front()->commit();
  }

  struct NamedTexture {
    const Texture* texture = nullptr;
    bool underWay = false;
  };
  struct Named {
    const Material* material = nullptr;
    bool underWay = false;
  };

  const SceneDescription& description;
  const SceneOverrides& overrides;
  Diagnostics& diagnostics;
  std::unique_ptr<EmbreeScene> scene;
  bool saidEnough = false;
  mutable std::map<std::pair<std::string, bool>, NamedTexture> texturesByName;
  std::map<std::string, Named> materialsByName;
  std::vector<std::pair<bool, const Material*>> materialsByIndex;
  std::vector<Material*> nested;            ///< those with a priority, in the order of their use
  std::vector<std::string> objectsUnderWay; ///< whose shapes are being made into others
  size_t nestedKinds = 0;                   ///< of those, the ones that are not the same matter as another
  std::deque<Group> groups;                 ///< [0] is the top level; addresses stay
  std::vector<GroupInstance> instances;
  std::map<const Shape*, std::pair<const AreaLight*, uint32_t>> lightOf;
};

std::unique_ptr<Scene> buildScene(const SceneDescription& description, const SceneOverrides& overrides,
                                  Diagnostics& diagnostics) {
  if (!hasImports(description)) return SceneBuilder(description, overrides, diagnostics).build();
  SceneDescription expanded = description;
  expandImports(expanded, diagnostics, overrides.lenient);
  return SceneBuilder(expanded, overrides, diagnostics).build();
}

} // namespace recurse
