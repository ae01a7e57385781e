/** @file
 * Shapes with baked transforms, in groups, and the groups' placements.
 */
#include "model/builder/shapeGroups.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "recurse/core/threads/interrupt.h"

namespace recurse {

namespace {

/** Adds the positions that the description alone has: "P", else the transform's origin. */
void addPlace(const ShapeDescription& s, const Mat4d& m, Bounds3d& bounds) {
  for (const ParsedParameter& p : s.shape.parameters)
    if (p.name == "P" && p.numbers.size() >= 3) {
      for (size_t i = 0; i + 2 < p.numbers.size(); i += 3)
        bounds.add(transformPoint(m, {p.numbers[i], p.numbers[i + 1], p.numbers[i + 2]}));
      return;
    }
  bounds.add(Vec3d(m[3]));
}

/** Origin that keeps the digits of positions: the centre of the bounds; 0 where they surround the origin. */
Vec3d originOf(const Bounds3d& b) {
  if (b.empty()) return Vec3d(0);
  const Vec3d c = b.center();
  const double size = glm::length(b.diagonal());
  const bool usable = std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z);
  return usable && glm::length(c) > 0.5 * size ? c : Vec3d(0);
}

AnimatedTransform motionOf(const ShapeDescription& s) {
  return {s.worldFromObject, s.worldFromObjectLast.value_or(s.worldFromObject)};
}
AnimatedTransform motionOf(const InstanceDescription& i) {
  return {i.worldFromInstance, i.worldFromInstanceLast.value_or(i.worldFromInstance)};
}
/** True for a shape of an object definition that has a motion of its own, or is a moving lamp: it needs a
 * group of its own. */
bool movesAlone(const ShapeDescription& s, const InstanceDescription& i) {
  return s.worldFromObjectLast || (s.areaLight >= 0 && i.worldFromInstanceLast);
}

/** Makes a shape of the registry. Null after an error, which the context's diagnostics have. */
std::unique_ptr<Shape> makeRegistered(const ParsedDirective& d, const ShapeContext& context,
                                      BuildContext& c) {
  const PlugIns& all = plugIns();
  if (all.shapes.find(d.type)) return all.shapes.make(d, context, c.diagnostics, c.lenient);
  std::vector<std::string> names = all.shapes.names();
  for (const std::string& import : all.imports.names()) names.push_back(import);
  reportUnknownPlugIn(all.shapes.kind(), d, names, c.diagnostics);
  return nullptr;
}

} // namespace

ShapeGroups::ShapeGroups(BuildContext& context, SceneMaterials& materials, SceneMedia& media,
                         std::vector<std::shared_ptr<Shape>>& shapes, KeptParts* kept)
    : c(context), materials(materials), media(media), shapes(shapes), kept(kept) {
  Bounds3d b;
  for (const ShapeDescription& s : c.description.shapes) addPlace(s, s.worldFromObject, b);
  for (const InstanceDescription& i : c.description.instances) b.add(Vec3d(i.worldFromInstance[3]));
  c.sceneOrigin = guessedOrigin = originOf(b);
}

std::unique_ptr<Dicing> ShapeGroups::dicingOf(const ShapeDescription& s, const Group& group) {
  const auto isDiced = [](const ShapeDescription& shape) { return isDicedByView(shape.shape); };
  // CSG may be made of objects with such a part.
  const bool mayBe =
      isDiced(s) ||
      (s.shape.type == "csg" &&
       std::any_of(c.description.objects.begin(), c.description.objects.end(), [&](const auto& o) {
         return std::any_of(o.second.shapes.begin(), o.second.shapes.end(), isDiced);
       }));
  if (!mayBe) return nullptr;
  if (!pixels) {
    Diagnostics saidLater;
    auto camera = makeCamera(c.description, c.description, film, guessedOrigin, saidLater, c.lenient);
    if (!camera) return nullptr;
    pixels = std::make_unique<PixelWidths>(std::move(camera), film);
  }
  std::vector<Mat4d> places;
  const auto add = [&](const Mat4d& m) {
    places.push_back(recentred(m, guessedOrigin) * translation(group.origin));
  };
  if (group.object.empty()) add(group.start);
  for (const InstanceDescription& i : c.description.instances)
    if (i.object == group.object) add(i.worldFromInstance);
  return std::make_unique<ViewDicing>(*pixels, std::move(places));
}

namespace {

/** True where the shape's own transform flips its normal. As in pbrt, mirroring does so for quadrics, except
 * in light sampling, which uses ReverseOrientation alone. */
bool isTurnedOverByMirrors(const ShapeDescription& s) {
  static const std::set<std::string> QUADRICS = {"sphere", "cylinder",   "disk",
                                                 "cone",   "paraboloid", "hyperboloid"};
  return s.areaLight < 0 && swapsHandedness(s.worldFromObject) && QUADRICS.count(s.shape.type) > 0;
}

} // namespace

std::unique_ptr<Shape> ShapeGroups::newShape(const ShapeDescription& s, const ShapeContext& context) {
  try {
    return makeRegistered(s.shape, context, c);
  } catch (const Error& e) {
    if (e.status() != ExitStatus::FAILED) throw;
    c.diagnostics.error(s.shape.location, e.what());
  } catch (const std::bad_alloc&) {
    c.diagnostics.error(s.shape.location, "the shape needs more memory than is available");
  }
  return nullptr;
}

std::shared_ptr<Shape> ShapeGroups::makeShape(const ShapeDescription& s, const ShapeContext& context,
                                              std::string& key) {
  const auto isTexture = [](const ParsedParameter& p) { return p.type == "texture"; };
  const auto none = [&](const std::vector<ParsedParameter>& list) {
    return std::none_of(list.begin(), list.end(), isTexture);
  };
  const bool isCutOut = context.material && context.material->opacity;
  const bool hasNoTextures = none(s.shape.parameters) && (!s.shape.attributes || none(*s.shape.attributes));
  if (kept && !isCutOut && hasNoTextures && !context.dicing) {
    key = keyOf(s.shape, context.sceneFromObject) + (context.reverseOrientation ? "r" : "");
    if (std::shared_ptr<Shape> shape = kept->shapes.take(key)) {
      ++kept->shapes.kept;
      return shape;
    }
  }
  const size_t askedBefore = objectsAsked;
  std::shared_ptr<Shape> shape = newShape(s, context);
  if (kept) ++kept->shapes.made;
  if (objectsAsked > askedBefore) key.clear();
  return shape;
}

namespace {

/** Levels of CSG, which bound the recursion; and the number of solids in all, which take about 1 GB. */
constexpr int MAX_SOLID_LEVELS = 256;
constexpr double MAX_SOLIDS = 1e6;

const ParsedParameter* operandsOf(const ShapeDescription& s) {
  if (s.shape.type != "csg") return nullptr;
  const auto named = [](const std::vector<ParsedParameter>& list) -> const ParsedParameter* {
    const auto found =
        std::find_if(list.rbegin(), list.rend(), [](const auto& p) { return p.name == "operands"; });
    return found == list.rend() ? nullptr : &*found;
  };
  const ParsedParameter* own = named(s.shape.parameters);
  return own || !s.shape.attributes ? own : named(*s.shape.attributes);
}

} // namespace

ShapeGroups::SolidCount ShapeGroups::solidsIn(const ShapeDescription& s, int level) {
  const ParsedParameter* operands = operandsOf(s);
  if (!operands) return {1, 0};
  SolidCount all{0, 1};
  if (level >= MAX_SOLID_LEVELS) return all;
  for (const std::string& name : operands->strings) {
    const auto [place, isNew] = solidsOf.try_emplace(name); // an object made of itself counts nothing
    const auto object = c.description.objects.find(name);
    if (isNew && object != c.description.objects.end()) {
      SolidCount inside;
      for (const ShapeDescription& inner : object->second.shapes) {
        const SolidCount n = solidsIn(inner, level + 1);
        inside = {inside.solids + n.solids, std::max(inside.levels, n.levels)};
      }
      place->second = inside;
    }
    all.solids += place->second.solids;
    all.levels = std::max(all.levels, 1 + place->second.levels);
  }
  return all;
}

bool ShapeGroups::checkSolids() {
  double sum = 0;
  const auto isGood = [&](const ShapeDescription& s) {
    const ParsedParameter* operands = operandsOf(s);
    if (!operands) return true;
    const SolidCount all = solidsIn(s, 0);
    sum += all.solids;
    if (all.levels > MAX_SOLID_LEVELS)
      c.diagnostics.error(operands->location,
                          "solids are nested more than " + std::to_string(MAX_SOLID_LEVELS) + " levels");
    else if (sum > MAX_SOLIDS)
      c.diagnostics.error(operands->location,
                          "too many solids are combined: more than " + std::to_string(int(MAX_SOLIDS)));
    else
      return true;
    return false;
  };
  if (!std::all_of(c.description.shapes.begin(), c.description.shapes.end(), isGood)) return false;
  std::set<std::string> seen;
  for (const InstanceDescription& i : c.description.instances) {
    const auto object = c.description.objects.find(i.object);
    if (object == c.description.objects.end() || !seen.insert(i.object).second) continue;
    const std::vector<ShapeDescription>& list = object->second.shapes;
    if (!std::all_of(list.begin(), list.end(), isGood)) return false;
  }
  return true;
}

void ShapeGroups::keepShapes() {
  if (!kept) return;
  std::multimap<std::string, std::shared_ptr<Shape>> all;
  for (size_t i = 0; i < shapes.size(); ++i)
    if (!keys[i].empty()) all.emplace(keys[i], shapes[i]);
  kept->shapes.replace(std::move(all));
}

void ShapeGroups::addShape(const ShapeDescription& s, const Mat4d& placement, Group& group,
                           const InstanceDescription* partOf) {
  checkInterrupted();
  if (c.enoughErrors()) return;
  MediumInterface around = media.numbers(s.medium, s.shape.location);
  const Material* m = materials.material(s.material);
  if (m && m->filling) around.inside = media.number(*m->filling);
  if (m && m->opacity && around.isBoundary())
    c.diagnostics.error(s.shape.location, "a mix with \"interface\" cannot bound a medium",
                        "a material without holes, or the same medium on both sides");
  const Mat4d sceneFromObject = recentred(placement, group.origin);
  const double determinant = glm::determinant(Mat3d(sceneFromObject));
  if (!std::isfinite(determinant) || determinant == 0) {
    c.diagnostics.error(s.shape.location, "the shape's transform is singular: it cannot be inverted");
    return;
  }
  const std::unique_ptr<Dicing> dicing = dicingOf(s, group);
  const bool turnsOver = isTurnedOverByMirrors(s);
  const bool hasSides = around.isBoundary() || (m && (m->lobes() & REFRACTION));
  if (turnsOver && hasSides && !s.reverseOrientation)
    c.diagnostics.warning(s.shape.location, "the transform mirrors this shape and turns it inside out, as in "
                                            "pbrt: ReverseOrientation before the Shape reverses it again");
  const ShapeContext context{sceneFromObject, s.reverseOrientation != turnsOver, &materials, this, m,
                             dicing.get(),    group.origin - c.sceneOrigin};
  std::string key;
  std::shared_ptr<Shape> shape = makeShape(s, context, key);
  if (!shape || shape->primitiveCount() == 0) return;
  const bool scatters = (m && m->lobes() != NO_LOBE) || !shape->componentMaterials().empty();
  if (s.areaLight < 0 && !scatters && !around.isBoundary()) return;
  if (m && m->priority() > 0) materials.fillNested(*m, around, s.shape.location);
  const Bounds3f bounds = shape->bounds();
  if (!representable(bounds.lower) || !representable(bounds.upper)) {
    c.diagnostics.error(s.shape.location,
                        "the shape is too large, or too far from the others, for single precision",
                        "coordinates below 1e18");
    return;
  }
  // Squares of smaller distances are denormal numbers.
  const Vec3f sides = bounds.diagonal();
  if (const float size = sides[widestAxis(sides)]; size > 0 && size < 1e-15f) {
    c.diagnostics.error(s.shape.location, "the shape is too small for single precision", "sizes above 1e-15");
    return;
  }
  group.placed.push_back({shape.get(), m, &s, around, partOf});
  shapes.push_back(std::move(shape));
  keys.push_back(std::move(key));
}

std::vector<ComponentShape> ShapeGroups::object(const Parameters& p, const std::string& parameter,
                                                const std::string& name, const ShapeContext& context) {
  ++objectsAsked;
  const auto found = c.description.objects.find(name);
  if (found == c.description.objects.end()) {
    const std::vector<std::string> names = namesOf(c.description.objects);
    p.fail(parameter, "there is no object named \"" + name + "\"",
           names.empty() ? "the name of an ObjectBegin" : quotedList(nearestNames(name, names)));
  }
  if (std::find(objectsUnderWay.begin(), objectsUnderWay.end(), name) != objectsUnderWay.end())
    p.fail(parameter, "object \"" + name + "\" contains itself");
  objectsUnderWay.push_back(name);
  std::vector<ComponentShape> made;
  for (const ShapeDescription& s : found->second.shapes) {
    if (c.enoughErrors()) break;
    const Material* m = materials.material(s.material);
    const ShapeContext inner{context.sceneFromObject * s.worldFromObject,
                             s.reverseOrientation,
                             &materials,
                             this,
                             m,
                             context.dicing,
                             context.textureShift};
    const double determinant = glm::determinant(Mat3d(inner.sceneFromObject));
    if (s.worldFromObjectLast)
      c.diagnostics.error(s.shape.location, "an operand of another shape cannot move by itself",
                          "the motion at the whole Shape");
    else if (s.areaLight >= 0)
      c.diagnostics.error(s.shape.location, "an operand of another shape cannot emit by itself",
                          "the AreaLightSource at the whole Shape");
    else if (!std::isfinite(determinant) || determinant == 0)
      c.diagnostics.error(s.shape.location, "the shape's transform is singular: it cannot be inverted");
    else if (m && m->filling)
      c.diagnostics.error(s.shape.location,
                          "an operand of another shape cannot have a material with a medium",
                          "a material without a medium");
    else if (s.medium.inside != s.medium.outside)
      c.diagnostics.error(s.shape.location, "an operand of another shape cannot bound a medium by itself",
                          "the MediumInterface at the whole Shape");
    else if (auto shape = newShape(s, inner))
      made.push_back({std::move(shape), m, s.shape.location});
  }
  objectsUnderWay.pop_back();
  return made;
}

namespace {

bool every(const ShapeGroups::Placed&) { return true; }

} // namespace

template <class Counts> Bounds3d ShapeGroups::boundsOf(const Group& g, const Counts& counts) {
  Bounds3d b;
  for (const Placed& p : g.placed) {
    if (!counts(p)) continue;
    const Bounds3f s = p.shape->bounds();
    if (s.empty()) continue;
    b.add(Vec3d(s.lower) + g.origin);
    b.add(Vec3d(s.upper) + g.origin);
  }
  return b;
}

template <class Fill> void ShapeGroups::fillGroup(Group& group, const Fill& fill) {
  const size_t shapesBefore = shapes.size();
  fill();
  const Bounds3d b = boundsOf(group, every);
  if (b.empty() || c.diagnostics.hasErrors()) return;
  if (glm::length(b.center() - group.origin) <= 2 * glm::length(b.diagonal())) return;
  group.origin = originOf(b);
  group.placed.clear();
  shapes.resize(shapesBefore);
  keys.resize(shapesBefore);
  fill();
}

bool ShapeGroups::build(const FilmSettings& filmSettings) {
  film = filmSettings;
  Group& top = all.emplace_back();
  top.origin = c.sceneOrigin;
  if (!checkSolids()) return false;
  std::map<std::string, size_t> groupOf;
  fillGroup(top, [&] {
    for (const ShapeDescription& s : c.description.shapes)
      if (!s.worldFromObjectLast) addShape(s, s.worldFromObject, top);
    // Emitting shapes of an object are baked, one for each instance: a light has one position.
    for (const InstanceDescription& i : c.description.instances) {
      const auto object = c.description.objects.find(i.object);
      if (object == c.description.objects.end()) continue;
      for (const ShapeDescription& s : object->second.shapes)
        if (s.areaLight >= 0 && !movesAlone(s, i))
          addShape(s, i.worldFromInstance * s.worldFromObject, top, &i);
    }
  });
  c.sceneOrigin = all.front().origin;
  for (const InstanceDescription& i : c.description.instances) {
    if (c.enoughErrors()) break;
    const auto object = c.description.objects.find(i.object);
    if (object == c.description.objects.end()) {
      c.diagnostics.error(i.location, "there is no object named \"" + i.object + "\"",
                          quotedList(namesOf(c.description.objects)));
      continue;
    }
    const double determinant = glm::determinant(Mat3d(i.worldFromInstance));
    if (!std::isfinite(determinant) || determinant == 0) {
      c.diagnostics.error(i.location, "the instance's transform is singular: it cannot be inverted");
      continue;
    }
    if (!groupOf.count(i.object)) {
      groupOf[i.object] = all.size();
      Group& g = all.emplace_back();
      g.object = i.object;
      Bounds3d place;
      for (const ShapeDescription& s : object->second.shapes) addPlace(s, s.worldFromObject, place);
      g.origin = originOf(place);
      fillGroup(g, [&] {
        for (const ShapeDescription& s : object->second.shapes)
          if (s.areaLight < 0 && !s.worldFromObjectLast) addShape(s, s.worldFromObject, g);
      });
    }
    if (!all[groupOf[i.object]].placed.empty())
      placedInstances.push_back({groupOf[i.object], motionOf(i), {}, nullptr, &i});
    for (const ShapeDescription& s : object->second.shapes)
      if (movesAlone(s, i)) addMoving(s, motionOf(i), i.location, &i);
  }
  for (const ShapeDescription& s : c.description.shapes)
    if (s.worldFromObjectLast) addMoving(s, {}, s.shape.location, nullptr);
  keepShapes();
  return !c.diagnostics.hasErrors();
}

void ShapeGroups::addMoving(const ShapeDescription& s, const AnimatedTransform& instance,
                            const SourceLocation& where, const InstanceDescription* partOf) {
  if (c.enoughErrors()) return;
  const AnimatedTransform motion = motionOf(s);
  const auto volume = [&](const Mat4d& a, const Mat4d& b) { return glm::determinant(Mat3d(a) * Mat3d(b)); };
  const double first = volume(instance.start(), motion.start()), last = volume(instance.end(), motion.end());
  if (!std::isfinite(first) || !std::isfinite(last) || !(first * last > 0)) {
    c.diagnostics.error(where, "a transform of the motion is singular or mirrors the shape");
    return;
  }
  const size_t index = all.size();
  Group& g = all.emplace_back();
  g.start = instance.start();
  Bounds3d place;
  addPlace(s, s.worldFromObject, place);
  g.origin = originOf(place);
  fillGroup(g, [&] { addShape(s, s.worldFromObject, g); });
  if (!g.placed.empty()) placedInstances.push_back({index, instance, motion, &s, partOf});
}

MatrixTrack ShapeGroups::sceneFromGroup(const Instance& i) const {
  const Mat4d fromStart = glm::inverse(i.shape.start()) * translation(all[i.group].origin);
  const auto at = [&](double time) {
    return recentred(i.instance.at(time) * i.shape.at(time), c.sceneOrigin) * fromStart;
  };
  if (!i.instance.moves() && !i.shape.moves()) return at(0);
  // The product of two motions is not linear even where neither rotates.
  constexpr int CURVED = 16, MAX_PARTS = 128; // MAX_PARTS: limit of Embree
  const int parts = i.instance.moves() && i.shape.moves()
                        ? std::min(CURVED + i.instance.linearParts() + i.shape.linearParts(), MAX_PARTS)
                        : std::max(i.instance.linearParts(), i.shape.linearParts());
  std::vector<Mat4d> steps;
  for (int k = 0; k <= parts; ++k) steps.push_back(at(double(k) / parts));
  return MatrixTrack(steps);
}

Bounds3d ShapeGroups::bounds() const { return boundsOfAll(every); }

Bounds3d ShapeGroups::boundsOfMedium(uint16_t medium) const {
  return boundsOfAll([&](const Placed& p) {
    return p.media.isBoundary() && (p.media.inside == medium || p.media.outside == medium);
  });
}

template <class Counts> Bounds3d ShapeGroups::boundsOfAll(const Counts& counts) const {
  Bounds3d b;
  for (const Placed& p : all.front().placed) {
    if (!counts(p)) continue;
    const Bounds3f s = p.shape->bounds();
    b.add(Vec3d(s.lower));
    b.add(Vec3d(s.upper));
  }
  std::vector<Bounds3d> ofGroups; // once for each group, which may have many instances
  for (const Group& g : all) ofGroups.push_back(boundsOf(g, counts));
  for (const Instance& i : placedInstances) {
    const Bounds3d& local = ofGroups[i.group];
    if (local.empty()) continue;
    const MatrixTrack track = sceneFromGroup(i);
    for (const Mat4d& step : track.steps()) {
      const Mat4d m = step * translation(-all[i.group].origin);
      for (int corner = 0; corner < 8; ++corner)
        b.add(transformPoint(m, {corner & 1 ? local.upper.x : local.lower.x,
                                 corner & 2 ? local.upper.y : local.lower.y,
                                 corner & 4 ? local.upper.z : local.lower.z}));
    }
  }
  return b;
}

void ShapeGroups::count(SceneContents& contents) const {
  for (const Group& g : all)
    for (const Placed& p : g.placed) {
      ++contents.shapes;
      (p.shape->triangleMesh() ? contents.triangles : contents.otherPrimitives) += p.shape->primitiveCount();
      for (const Material* m : p.shape->componentMaterials())
        if (m) contents.lobes |= m->lobes();
      if (p.material) contents.lobes |= p.material->lobes();
    }
  contents.instances = placedInstances.size();
}

} // namespace recurse
