/** @file
 * Constructive solid geometry: unions, intersections and differences of solids. The crossings of a line with
 * the operands are sorted, and kept where the line enters or leaves the result (Roth, "Ray Casting for
 * Modeling Solids", 1982).
 */
#include <mutex>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/shape/boxTree.h"

namespace recurse {

namespace {

enum class Operation { UNION, INTERSECTION, DIFFERENCE };

/** Shape of an operand. */
struct Part {
  std::unique_ptr<Shape> shape;
  std::unique_ptr<Solid> solid;
  uint32_t operand = 0;
  uint32_t firstComponent = 0; ///< its components are numbered from here on
  bool isCompound = false;     ///< its components count, instead of its primitives
  bool turned = false;         ///< normals of the result are opposite to this shape's normals
};

class Csg final : public Shape {
 public:
  Csg(Operation operation, uint32_t operandCount, std::vector<Part> given, uint32_t componentCount,
      std::vector<const Material*> componentMaterials, std::vector<uint32_t> materialStarts,
      const ShapeContext& context)
      : operation(operation), operandCount(operandCount), parts(std::move(given)), components(componentCount),
        materials(std::move(componentMaterials)), materialStarts(std::move(materialStarts)),
        reversed(context.reverseOrientation) {
    std::vector<Bounds3d> boxes;
    for (Part& p : parts) {
      const Bounds3f b = p.shape->bounds();
      boxes.push_back({Vec3d(b.lower), Vec3d(b.upper)});
      const bool takenOff = operation == Operation::DIFFERENCE && p.operand > 0;
      p.turned = p.solid->normalsPointIn() != (takenOff != reversed);
      if (!takenOff) box.add(b);
    }
    if (operation == Operation::INTERSECTION) box = commonBox();
    // Distance below which faces coincide: they differ by rounding.
    coincidence = 0x1p-22 * glm::length(Vec3d(box.diagonal()));
    // Rays are intersected piece by piece, which spares the shapes behind the first hit. A piece that is a
    // few shapes long usually contains a hit where shapes are many; where they are few, it is the whole ray.
    constexpr double SHAPES_LONG = 4;
    for (const Bounds3d& b : boxes)
      firstStretch += SHAPES_LONG * glm::length(b.diagonal()) / double(boxes.size());
    if (!(firstStretch > 0)) firstStretch = std::numeric_limits<double>::infinity(); // shapes without size
    canEmit = std::all_of(parts.begin(), parts.end(), [](const Part& p) { return p.shape->canBeSampled(); });
    tree = BoxTree(boxes);
  }

  uint32_t primitiveCount() const override { return box.empty() ? 0 : 1; }
  bool isQuicklySampled() const override { return false; }
  double testsOfRay() const override {
    double most = 1;
    for (const Part& p : parts) most = std::max(most, p.shape->testsOfRay());
    return most;
  }
  Bounds3f bounds(uint32_t) const override { return box; }

  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override {
    static thread_local std::vector<Solid::Crossing> found;
    auto [begin, last] = withinBox(origin, direction);
    begin = std::max(begin, double(tMin));
    last = std::min(last, double(tMax));
    for (double length = firstStretch; begin <= last; length *= 2) {
      const double end = std::min(begin + length, last);
      found.clear();
      // Crossings of all shapes that may contain a point of the piece; invalid outside of the piece.
      crossings(origin, direction, begin - coincidence, end + coincidence, found);
      for (const Solid::Crossing& c : found) {
        const auto t = static_cast<float>(c.t);
        if (c.t >= begin && c.t <= end && t > tMin && t < tMax) return PrimitiveHit{t, c.parameters};
      }
      if (end >= last) break;
      begin = end;
    }
    return {};
  }

  SurfacePoint surfaceAt(uint32_t, const HitParameters& parameters) const override {
    const Part& part = partOf(parameters.component());
    const uint32_t component = parameters.component() - part.firstComponent;
    HitParameters own = parameters;
    own.setComponent(component);
    SurfacePoint s = part.shape->surfaceAt(part.isCompound ? 0 : component, own);
    if (part.turned) turn(s);
    return s;
  }

  /** Samples are points on the operands' surfaces; points that are not on the result's surface are rejected.
   */
  bool canBeSampled() const override { return canEmit; }
  float area() const override {
    knowAreas();
    return ownArea;
  }
  ShapeSample sampleArea(float pick, const Vec2f& u) const override {
    knowAreas();
    return samplePart(pick, u);
  }
  float pdfArea(uint32_t, const SurfacePoint& point) const override {
    knowAreas();
    const auto component = componentAt(point);
    return component ? pdfOnPart(partOf(*component), *component, point) : 0;
  }

  std::vector<const Material*> componentMaterials() const override { return materials; }
  const Material* materialAt(const HitParameters& parameters) const override {
    const auto next = std::upper_bound(materialStarts.begin(), materialStarts.end(), parameters.component());
    return materials[static_cast<size_t>(next - materialStarts.begin()) - 1];
  }
  const std::vector<uint32_t>& starts() const { return materialStarts; }
  uint32_t componentCount() const { return components; }

  std::unique_ptr<Solid> asSolid() const override { return std::make_unique<CsgSolid>(*this); }

  /** Appends the crossings of the result between tMin and tMax, sorted by t. Crossings outside this range
   * may be appended too, and may be wrong. */
  void crossings(const Vec3d& origin, const Vec3d& direction, double tMin, double tMax,
                 std::vector<Solid::Crossing>& found) const {
    const size_t first = found.size();
    tree.visit(origin, direction, tMin, tMax, [&](uint32_t i) {
      const Part& part = parts[i];
      const size_t before = found.size();
      part.solid->crossings(origin, direction, found);
      for (size_t k = before; k < found.size(); ++k) {
        Solid::Crossing& c = found[k];
        c.parameters.setComponent(part.firstComponent +
                                  (part.isCompound ? c.parameters.component() : c.primitive));
        c.primitive = part.operand; // operand, until keepResult() sets the result's only primitive
      }
    });
    std::sort(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(),
              [](const Solid::Crossing& a, const Solid::Crossing& b) {
                return a.t != b.t ? a.t < b.t : a.parameters.component() < b.parameters.component();
              });
    keepResult(found, first, coincidence / glm::length(direction));
  }

 private:
  class CsgSolid final : public Solid {
   public:
    explicit CsgSolid(const Csg& csg) : csg(csg) {}
    void crossings(const Vec3d& origin, const Vec3d& direction, std::vector<Crossing>& found) const override {
      constexpr double FAR = std::numeric_limits<double>::infinity();
      csg.crossings(origin, direction, -FAR, FAR, found);
    }
    bool normalsPointIn() const override { return csg.reversed; }

   private:
    const Csg& csg;
  };

  /** Number of shapes of each operand that contain a point along the line. */
  class State {
   public:
    State(Operation operation, uint32_t operandCount) : operation(operation) {
      if (operation == Operation::INTERSECTION) depths.assign(operandCount, 0);
    }
    void pass(const Solid::Crossing& c) {
      const int step = c.entering ? 1 : -1;
      if (operation == Operation::INTERSECTION) {
        int& depth = depths[c.primitive];
        inside += (depth + step > 0) - (depth > 0);
        depth += step;
      } else if (operation == Operation::DIFFERENCE && c.primitive > 0) {
        takenOff += step;
      } else {
        inside += step;
      }
    }
    bool isInside() const {
      if (operation == Operation::INTERSECTION) return inside == static_cast<int>(depths.size());
      return inside > 0 && takenOff <= 0;
    }

   private:
    Operation operation;
    int inside = 0, takenOff = 0;
    std::vector<int> depths;
  };

  /**
   * Crossings within `together` count as one, so that coincident faces leave no skin behind. Where they
   * change the result, its surface is the operand that is named first and has the right orientation. Its t is
   * the t of the first crossing, which does not depend on the order of names.
   */
  void keepResult(std::vector<Solid::Crossing>& found, size_t first, double together) const {
    if (found.size() == first) return;
    State state(operation, operandCount);
    size_t kept = first;
    for (size_t i = first; i < found.size();) {
      const bool wasInside = state.isInside();
      size_t end = i;
      for (; end < found.size() && found[end].t - found[i].t <= together; ++end) state.pass(found[end]);
      if (state.isInside() != wasInside) {
        size_t best = end;
        for (size_t k = i; k < end; ++k) {
          const bool takenOff = operation == Operation::DIFFERENCE && found[k].primitive > 0;
          if ((found[k].entering != takenOff) == wasInside) continue;
          if (best == end || found[k].parameters.component() < found[best].parameters.component()) best = k;
        }
        Solid::Crossing surface = found[best == end ? i : best];
        surface.t = found[i].t;
        surface.entering = !wasInside;
        surface.primitive = 0;
        found[kept++] = surface;
      }
      i = end;
    }
    found.resize(kept);
  }

  /** Range of t in which the line is inside the box, with some slack. */
  std::pair<double, double> withinBox(const Vec3d& origin, const Vec3d& direction) const {
    constexpr double FAR = std::numeric_limits<double>::infinity();
    double begin = -FAR, end = FAR;
    for (int i = 0; i < 3; ++i) {
      if (direction[i] == 0) continue;
      const double a = (double(box.lower[i]) - origin[i]) / direction[i],
                   b = (double(box.upper[i]) - origin[i]) / direction[i];
      begin = std::max(begin, std::min(a, b));
      end = std::min(end, std::max(a, b));
    }
    return {begin - coincidence, end + coincidence};
  }

  const Part& partOf(uint32_t component) const {
    const auto next = std::upper_bound(parts.begin(), parts.end(), component,
                                       [](uint32_t c, const Part& p) { return c < p.firstComponent; });
    return *(next - 1);
  }

  static void turn(SurfacePoint& s) {
    s.geometricNormal = -s.geometricNormal;
    s.shadingNormal = -s.shadingNormal;
    s.dndu = -s.dndu;
    s.dndv = -s.dndv;
    s.crossTangent = static_cast<int8_t>(-s.crossTangent);
  }

  /** Component whose surface the result has at a point, within rounding; empty where there is none. */
  std::optional<uint32_t> componentAt(const SurfacePoint& point) const {
    static thread_local std::vector<Solid::Crossing> found;
    found.clear();
    const Vec3d normal = point.geometricNormal;
    const double near = 8 * coincidence + 0x1p-20 * glm::length(Vec3d(point.position));
    crossings(point.position, normal, -near, near, found);
    const Solid::Crossing* nearest = nullptr;
    for (const Solid::Crossing& c : found)
      if (c.entering == reversed && std::abs(c.t) <= near &&
          (!nearest || std::abs(c.t) < std::abs(nearest->t)))
        nearest = &c;
    return nearest ? std::optional(nearest->parameters.component()) : std::nullopt;
  }

  void knowAreas() const {
    std::call_once(areasKnown, [this] { measureAreas(); });
  }

  /** Area of the parts before part i. */
  double areaBefore(size_t i) const { return i > 0 ? cumulativeArea[i - 1] : 0; }

  ShapeSample samplePart(float pick, const Vec2f& u) const {
    const double chosen = double(pick) * cumulativeArea.back();
    const auto next = std::upper_bound(cumulativeArea.begin(), cumulativeArea.end() - 1, chosen);
    const auto i = static_cast<size_t>(next - cumulativeArea.begin());
    const double before = areaBefore(i), own = cumulativeArea[i] - before;
    const Part& part = parts[i];
    ShapeSample s = part.shape->sampleArea(
        own > 0 ? std::min(static_cast<float>((chosen - before) / own), ONE_MINUS_EPSILON) : 0, u);
    if (part.turned) turn(s.point);
    if (!(s.pdf > 0)) return {};
    const auto component = componentAt(s.point);
    if (!component || &partOf(*component) != &part) return {};
    s.pdf = pdfOnPart(part, *component, s.point);
    s.primitive = 0;
    return s;
  }

  float pdfOnPart(const Part& part, uint32_t component, const SurfacePoint& point) const {
    const auto i = static_cast<size_t>(&part - parts.data());
    const double own = cumulativeArea[i] - areaBefore(i);
    const uint32_t primitive = part.isCompound ? 0 : component - part.firstComponent;
    return static_cast<float>(own / cumulativeArea.back()) * part.shape->pdfArea(primitive, point);
  }

  /** Measures the areas of the parts, and the area of the result by points on them. */
  void measureAreas() const {
    double sum = 0;
    for (const Part& p : parts) cumulativeArea.push_back(sum += double(p.shape->area()));
    if (!(sum > 0)) return;
    constexpr uint32_t POINTS = 1 << 18; // 1 % error where a tenth of the operands' surface is the result's
    double own = 0;
    for (uint32_t i = 0; i < POINTS; ++i) {
      Sampler sampler(0, 0, i);
      const float pick = (static_cast<float>(i) + sampler.next1D()) / POINTS;
      const ShapeSample s = samplePart(std::min(pick, ONE_MINUS_EPSILON), sampler.next2D());
      if (s.pdf > 0) own += 1 / double(s.pdf);
    }
    ownArea = static_cast<float>(own / POINTS);
  }

  /** Intersection of the bounding boxes of all operands. */
  Bounds3f commonBox() const {
    std::vector<Bounds3f> boxes(operandCount);
    for (const Part& p : parts) boxes[p.operand].add(p.shape->bounds());
    Bounds3f common = boxes.front();
    for (const Bounds3f& b : boxes) {
      common.lower = glm::max(common.lower, b.lower);
      common.upper = glm::min(common.upper, b.upper);
    }
    return common;
  }

  Operation operation;
  uint32_t operandCount;
  std::vector<Part> parts; ///< sorted by operand
  uint32_t components;     ///< number of components of all parts
  std::vector<const Material*> materials;
  std::vector<uint32_t> materialStarts; ///< first component of each material
  bool reversed;
  double coincidence = 0, firstStretch = 0; ///< [scene units]
  Bounds3f box;
  BoxTree tree;

  bool canEmit = false;
  mutable std::once_flag areasKnown;          ///< guards the areas, which only lamps need
  mutable std::vector<double> cumulativeArea; ///< total area of parts [0, i]
  mutable float ownArea = 0;
};

std::unique_ptr<Shape> makeCsg(const Parameters& p, const ShapeContext& context) {
  if (!context.shapes) p.fail("operands", "objects are not supported here");
  const std::vector<std::string> names = p.strings("operands");
  if (names.size() < 2)
    p.fail("operands", std::to_string(names.size()) + " operand given", "the names of two objects or more");
  const std::string word = p.string("operation");
  const Operation operation = word == "union"          ? Operation::UNION
                              : word == "intersection" ? Operation::INTERSECTION
                                                       : Operation::DIFFERENCE;
  std::vector<Part> parts;
  std::vector<const Material*> materials;
  std::vector<uint32_t> starts;
  uint32_t components = 0;
  for (uint32_t operand = 0; operand < names.size(); ++operand) {
    ShapeContext inner = context;
    inner.reverseOrientation = false;
    std::vector<ComponentShape> made = context.shapes->object(p, "operands", names[operand], inner);
    if (made.empty())
      throw SceneError(p.location("operands"),
                       "object \"" + names[operand] + "\" has no shape that can be an operand");
    for (ComponentShape& c : made) {
      if (c.shape->primitiveCount() == 0) continue;
      if (c.shape->alpha)
        throw SceneError(c.location, "an operand cannot have alpha", "alpha of the \"csg\" itself");
      Part part;
      try {
        part.solid = c.shape->asSolid();
      } catch (const Error& e) {
        throw SceneError(c.location, "the shape cannot be an operand of \"csg\": " + std::string(e.what()),
                         "closed shapes: sphere, box, torus, cylinder and cone with caps, csg, metaballs, "
                         "implicit, "
                         "triangle meshes without open edges");
      }
      part.operand = operand;
      part.firstComponent = components;
      if (const auto* nested = dynamic_cast<const Csg*>(c.shape.get())) {
        part.isCompound = true;
        const std::vector<const Material*> own = nested->componentMaterials();
        for (size_t i = 0; i < own.size(); ++i) {
          materials.push_back(own[i]);
          starts.push_back(components + nested->starts()[i]);
        }
        components += nested->componentCount();
      } else {
        materials.push_back(c.material);
        starts.push_back(components);
        components += c.shape->primitiveCount();
      }
      part.shape = std::move(c.shape);
      parts.push_back(std::move(part));
    }
  }
  if (p.boolean("onematerial")) {
    materials = {context.material};
    starts = {0};
  }
  return std::make_unique<Csg>(operation, static_cast<uint32_t>(names.size()), std::move(parts), components,
                               std::move(materials), std::move(starts), context);
}

} // namespace

void registerCsg(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "csg",
        .summary = "Constructive solid geometry: the union, intersection or difference of solids that "
                   "ObjectBegin defines. If surfaces coincide, the first operand is used. It may emit light "
                   "if its operands may.",
        .parameters =
            {stringParameter("operation", "union", "operation on the operands")
                 .oneOf({"union", "intersection", "difference"}),
             arrayParameter(
                 ParameterType::STRING, "operands", 0, "",
                 "names of objects, two or more; up to 256 levels of csg, and a million solids in a scene")
                 .require(),
             booleanParameter(
                 "onematerial", "false",
                 "use the material of this shape everywhere, instead of the operands' materials")},
        .examples = {"\"string operation\" \"difference\" \"string operands\" [\"block\" \"ball\"]",
                     "\"string operation\" \"intersection\" \"string operands\" [\"block\" \"ball\"] "
                     "\"bool onematerial\" true",
                     "\"string operands\" [\"ball\" \"block\"]"}},
       makeCsg});
}

} // namespace recurse
