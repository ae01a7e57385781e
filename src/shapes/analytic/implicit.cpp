/** @file
 * Level sets of expressions: the boundary of the set where a function of x, y and z is negative. Roots along
 * a line are isolated by interval arithmetic (Mitchell, "Robust Ray Intersection with Interval Arithmetic",
 * 1990).
 */
#include "recurse/core/math/polynomialRoots.h"
#include "recurse/model/scene/plugIns.h"
#include "shapes/analytic/expression.h"
#include "shapes/analytic/mappedShape.h"

namespace recurse {

namespace {

class Implicit final : public MappedShape {
 public:
  Implicit(Expression function, const Bounds3d& limits, bool caps, const ShapeContext& context)
      : f(std::move(function)), middle(limits.center()), size(glm::length(limits.diagonal())) {
    half = limits.diagonal() * (0.5 / size);
    staysInside = !reachesFaces();
    hasCaps = caps || staysInside;
    Mat4d m = context.sceneFromObject;
    for (int i = 0; i < 3; ++i) m[i] *= size;
    m[3] = Vec4d(transformPoint(context.sceneFromObject, middle), 1);
    prepare(m, {-half, half}, {}, context.reverseOrientation);
  }

  bool canBeSampled() const override { return false; }
  /** A piece of zero length where the surface may end at the box: its edge has no known location. */
  std::vector<RimPiece> rim() const override {
    if (hasCaps) return {};
    const Vec3f center(inScene(Vec3d(0)));
    return {{center, center, center}};
  }

  /** A ray takes about 40 evaluations, and a test of a simple surface as long as 20 instructions. */
  double testsOfRay() const override { return std::max(1.0, 2.0 * double(f.size())); }

 protected:
  void intersectAll(const Line& line, LineHits& found) const override {
    const double speed = glm::length(line.direction);
    if (!(speed > 0)) return;
    // The origin is the point nearest to the middle of the box.
    const Vec3d d = line.direction / speed;
    const double tNear = -glm::dot(line.origin, d);
    const Chord chord = chordOf(line.origin + d * tNear, d);
    if (!(chord.from < chord.to)) return;
    // A positive tMin is a hit that was rounded to float: it is passed by a float step, not found again.
    const double tMin = line.tMin > 0 ? line.tMin * (1 + 0x1p-23) : line.tMin;
    const double from = std::max(chord.from, tMin * speed - tNear),
                 to = std::min(chord.to, line.tMax * speed - tNear);
    if (!(from < to)) return;
    const auto add = [&](double t, uint32_t part, bool entering) {
      found.add({(tNear + t) / speed, part, entering, chord.at(t)});
    };
    Search search{chord, line.nearestOnly, STEPS, add};
    const bool begins = isInside(chord.at(from)), ends = isInside(chord.at(to));
    if (hasCaps && from == chord.from && begins) {
      add(from, chord.faceFrom, true);
      if (line.nearestOnly) return;
    }
    if (!isolate(search, from, to, begins, ends)) return;
    if (hasCaps && to == chord.to && ends) add(to, chord.faceTo, false);
  }

  OwnPoint ownPoint(uint32_t part, const Vec3d& near) const override {
    if (part >= FIRST_FACE) return pointOfFace(part - FIRST_FACE, near);
    OwnPoint s;
    s.position = near;
    Jet jet = f.jet(inObject(near));
    double largest = MAX_STEP;
    for (int i = 0; i < 4 && part == SURFACE; ++i) { // Newton's method along the gradient
      const double g2 = glm::dot(jet.gradient, jet.gradient);
      const Vec3d step = jet.gradient * (jet.value / (g2 * size));
      const double length = glm::length(step);
      if (!(length < largest)) break;
      s.position -= step;
      largest = length;
      jet = f.jet(inObject(s.position));
    }
    if (part == TURNED) jet = definedNear(near);
    const double steepness = glm::length(jet.gradient);
    const bool isFlat = !(steepness > 0 && std::isfinite(steepness));
    s.normal = isFlat ? Vec3d(0, 0, 1) : jet.gradient * ((part == TURNED ? -1 : 1) / steepness);
    s.error = isFlat || part == TURNED ? MAX_ERROR : errorAt(s.position, steepness);
    setSphericalCoordinates(s);
    if (isFlat) return s;
    // Derivative of the unit normal along the surface: the second derivatives without their part along it.
    const auto bend = [&](const Vec3d& along) {
      const Vec3d change = jet.second * along * (size / steepness) * (part == TURNED ? -1.0 : 1.0);
      const Vec3d across = change - s.normal * glm::dot(s.normal, change);
      return std::isfinite(glm::dot(across, across)) ? across : Vec3d(0);
    };
    s.dndu = bend(s.dpdu);
    s.dndv = bend(s.dpdv);
    return s;
  }

  Vec3d ownSample(uint32_t, const Vec2d&) const override { return Vec3d(0); }
  std::string whyOpen() const override {
    return hasCaps ? "" : "the function is negative at a face of the box: \"bool caps\" true closes it";
  }

 private:
  // Parts: the level set, the level set where the function falls outwards (a pole or the end of its domain),
  // and the faces of the box.
  static constexpr uint32_t SURFACE = 0, TURNED = 1, FIRST_FACE = 2;
  // Lengths relative to the diagonal of the box.
  static constexpr double RESOLUTION = 0x1p-44;
  static constexpr double MAX_STEP = 1e-2;  ///< step limit of Newton's method, which diverges at flat points
  static constexpr double MAX_ERROR = 1e-5; ///< error bound where the function is flat
  /** Steps of a ray at most. Only functions that are 0, up to rounding, on a piece of the ray need so many;
   * beyond, pieces are judged by their ends. */
  static constexpr int STEPS = 1 << 14;

  /** Part of a line inside the box, in own space. */
  struct Chord {
    Vec3d origin, direction;
    double from = -INFINITE_D, to = std::numeric_limits<double>::infinity();
    uint32_t faceFrom = FIRST_FACE, faceTo = FIRST_FACE; ///< parts at its ends
    Vec3d at(double t) const { return origin + direction * t; }
  };
  template <class Add> struct Search {
    const Chord& chord;
    bool nearestOnly;
    int steps;
    const Add& add;
  };
  template <class Add> Search(const Chord&, bool, int, const Add&) -> Search<Add>;

  Vec3d inObject(const Vec3d& own) const { return middle + own * size; }
  bool isInside(const Vec3d& own) const { return f.value(inObject(own)) < 0; }

  Chord chordOf(const Vec3d& origin, const Vec3d& direction) const {
    Chord c{origin, direction};
    for (int i = 0; i < 3; ++i) {
      if (direction[i] == 0) {
        if (std::abs(origin[i]) > half[i]) c.to = c.from;
        continue;
      }
      const double low = (-half[i] - origin[i]) / direction[i], high = (half[i] - origin[i]) / direction[i];
      const auto face = [&](bool upper) { return FIRST_FACE + 2 * static_cast<uint32_t>(i) + upper; };
      const bool forward = direction[i] > 0;
      if (std::min(low, high) > c.from) {
        c.from = std::min(low, high);
        c.faceFrom = face(!forward);
      }
      if (std::max(low, high) < c.to) {
        c.to = std::max(low, high);
        c.faceTo = face(forward);
      }
    }
    return c;
  }

  std::array<Interval, 3> boxAlong(const Chord& c, const Interval& t) const {
    std::array<Interval, 3> p;
    for (int i = 0; i < 3; ++i) {
      const double o = middle[i] + c.origin[i] * size, d = c.direction[i] * size;
      const double a = o + d * t.low, b = o + d * t.high;
      const double slack = 0x1p-50 * (std::abs(middle[i]) + size);
      p[size_t(i)] = {std::min(a, b) - slack, std::max(a, b) + slack};
    }
    return p;
  }
  Slope slopeAlong(const Chord& c, const std::array<Interval, 3>& box) const {
    std::array<Slope, 3> p;
    for (int i = 0; i < 3; ++i)
      p[size_t(i)] = {box[size_t(i)], roundedOut(c.direction[i] * size, c.direction[i] * size, false)};
    return f.slope(p);
  }

  /** Roots of the function in a piece of a line, by interval arithmetic. */
  enum class Piece { NO_ROOT, ONE_ROOT_AT_MOST, UNDECIDED, UNDECIDABLE };
  Piece judge(const Chord& c, double low, double high) const {
    const std::array<Interval, 3> box = boxAlong(c, {low, high});
    const Interval value = f.value(box);
    if (value.isEmpty() || value.low > 0 || (value.high < 0 && !value.isPartial)) return Piece::NO_ROOT;
    if (value.isPartial) return Piece::UNDECIDED;
    const Slope s = slopeAlong(c, box);
    if (s.slope.isEmpty()) return Piece::UNDECIDED;
    if (!s.slope.contains(0)) return Piece::ONE_ROOT_AT_MOST;
    // The mean value theorem gives tighter bounds on short pieces.
    const double center = 0.5 * (low + high);
    const Interval there = f.value(boxAlong(c, Interval(center)));
    const Interval change = s.slope * (Interval(low, high) - Interval(center)), bounds = there + change;
    if (!bounds.contains(0)) return Piece::NO_ROOT;
    const bool isRounding = std::isfinite(there.width()) && change.width() <= there.width();
    return isRounding ? Piece::UNDECIDABLE : Piece::UNDECIDED;
  }

  /** Adds the roots between low and high, in ascending order; false where the search ends with one. */
  template <class Add>
  bool isolate(Search<Add>& search, double low, double high, bool insideLow, bool insideHigh) const {
    const double center = 0.5 * (low + high);
    const bool canSplit = high - low > RESOLUTION && center > low && center < high;
    const Piece piece = !canSplit || --search.steps < 0 ? Piece::UNDECIDABLE : judge(search.chord, low, high);
    if (piece == Piece::UNDECIDED) {
      const bool inside = isInside(search.chord.at(center));
      return isolate(search, low, center, insideLow, inside) &&
             isolate(search, center, high, inside, insideHigh);
    }
    if (insideLow == insideHigh) return true;
    const double t = changeBetween(search.chord, low, high, insideLow, piece == Piece::ONE_ROOT_AT_MOST);
    const bool isTurned = piece != Piece::ONE_ROOT_AT_MOST && fallsOutwards(search.chord, t, insideHigh);
    search.add(t, isTurned ? TURNED : SURFACE, insideHigh);
    return !search.nearestOnly;
  }

  double changeBetween(const Chord& c, double low, double high, bool insideLow, bool isContinuous) const {
    if (isContinuous) return refineRoot([&](double t) { return f.value(inObject(c.at(t))); }, low, high);
    for (double t = 0.5 * (low + high); t > low && t < high; t = 0.5 * (low + high))
      (isInside(c.at(t)) == insideLow ? low : high) = t;
    return high;
  }

  /** Whether the function has the wrong slope for the change of sign at t, as at a pole. */
  bool fallsOutwards(const Chord& c, double t, bool entering) const {
    const double slope = glm::dot(definedNear(c.at(t)).gradient, c.direction);
    return entering ? slope > 0 : slope < 0;
  }

  /** Derivatives at a point or, where they are not defined, at one beside it. */
  Jet definedNear(const Vec3d& own) const {
    constexpr double BESIDE = 1e-6;
    Jet jet = f.jet(inObject(own));
    for (int i = 0; i < 6; ++i) {
      if (std::isfinite(jet.value) && std::isfinite(glm::length(jet.gradient))) break;
      Vec3d p = own;
      p[i / 2] += i % 2 == 0 ? BESIDE : -BESIDE;
      jet = f.jet(inObject(p));
    }
    return jet;
  }

  /** Bound on the distance from the surface of a point on it, up to rounding. */
  double errorAt(const Vec3d& own, double steepness) const {
    const Interval value = valueIn(own, own);
    const double largest = std::max(std::abs(value.low), std::abs(value.high));
    return std::min(largest / (steepness * size), MAX_ERROR);
  }

  OwnPoint pointOfFace(uint32_t face, const Vec3d& near) const {
    const int axis = static_cast<int>(face / 2), u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double sign = face % 2 == 0 ? -1 : 1;
    OwnPoint s;
    s.position = glm::clamp(near, -half, half);
    s.position[axis] = sign * half[axis];
    s.normal = s.dpdu = s.dpdv = Vec3d(0);
    s.normal[axis] = sign;
    s.dpdu[u] = 2 * half[u];
    s.dpdv[v] = 2 * half[v];
    s.uv = {0.5 + 0.5 * s.position[u] / half[u], 0.5 + 0.5 * s.position[v] / half[v]};
    return s;
  }

  /** Whether the function may be negative on a face of the box; spots smaller than 2^-20 of its diagonal are
   * ignored. */
  bool reachesFaces() const {
    int steps = 1 << 14;
    for (uint32_t face = 0; face < 6; ++face) {
      const int axis = static_cast<int>(face / 2);
      Vec3d low = -half, high = half;
      (face % 2 == 0 ? high : low)[axis] = face % 2 == 0 ? low[axis] : high[axis];
      if (isNegativeIn(low, high, (axis + 1) % 3, steps)) return true;
    }
    return false;
  }
  Interval valueIn(const Vec3d& low, const Vec3d& high) const {
    std::array<Interval, 3> p;
    for (int i = 0; i < 3; ++i)
      p[size_t(i)] = Interval(middle[i]) + Interval(size) * Interval(low[i], high[i]);
    return f.value(p);
  }
  bool isNegativeIn(const Vec3d& low, const Vec3d& high, int axis, int& steps) const {
    const Interval value = valueIn(low, high);
    if (value.isEmpty() || value.low >= 0) return false;
    const Vec3d center = 0.5 * (low + high);
    const Interval there = valueIn(center, center);
    if (!there.isEmpty() && there.high < 0) return true; // in spite of rounding
    constexpr double SPOT = 0x1p-20;
    const Vec3d extent = high - low;
    if (std::max(extent.x, std::max(extent.y, extent.z)) < SPOT) return false;
    if (--steps < 0) return true;
    int longest = axis;
    for (int i = 0; i < 3; ++i)
      if (extent[i] > extent[longest]) longest = i;
    Vec3d lowEnd = high, highStart = low;
    lowEnd[longest] = highStart[longest] = 0.5 * (low[longest] + high[longest]);
    return isNegativeIn(low, lowEnd, longest, steps) || isNegativeIn(highStart, high, longest, steps);
  }

  Expression f;
  Vec3d middle; ///< of the box in object space
  double size;  ///< length of its diagonal, the unit of own space
  Vec3d half;   ///< half of the box in own space
  bool staysInside = false, hasCaps = false;
};

Expression expressionOf(const Parameters& p) {
  try {
    return Expression(p.string("function"));
  } catch (const ExpressionError& e) {
    throw SceneError(locationInString(p.location("function"), e.offset), e.message, e.accepted);
  }
}

std::unique_ptr<Shape> makeImplicit(const Parameters& p, const ShapeContext& context) {
  const Vec3d a = p.vector3("p1"), b = p.vector3("p2");
  const Bounds3d box{glm::min(a, b), glm::max(a, b)};
  const Vec3d extent = box.diagonal();
  if (!(extent.x > 0 && extent.y > 0 && extent.z > 0))
    p.fail(p.has("p2") ? "p2" : "p1", "the box is flat", "corners that differ in all coordinates");
  return std::make_unique<Implicit>(expressionOf(p), box, p.boolean("caps"), context);
}

} // namespace

void registerImplicit(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "implicit",
        .summary = "The boundary of the set where a function of x, y and z is negative, inside a box. It is "
                   "a solid if the set stays clear of the box's faces, or with caps. It cannot emit light.",
        .parameters = {stringParameter(
                           "function", "",
                           "expression of x, y, z, numbers and pi, with + - * / ^, parentheses, and min max "
                           "(of two values or more) abs sqrt sin cos exp log (of one); angles in radians. "
                           "Where it is undefined is outside")
                           .require(),
                       arrayParameter(ParameterType::POINT3, "p1", 1, "-1 -1 -1", "corner of the box"),
                       arrayParameter(ParameterType::POINT3, "p2", 1, "1 1 1", "opposite corner"),
                       booleanParameter("caps", "false", "close the set with the faces of the box")},
        .examples = {"\"string function\" \"x^2 + y^2/.6 + (z - .3*x^2)^2 - .7\"",
                     "\"string function\" \"sin(4*x)*cos(4*y) + sin(4*y)*cos(4*z) + sin(4*z)*cos(4*x) - .3\" "
                     "\"bool caps\" true",
                     "\"string function\" \"sqrt((sqrt(x^2 + y^2) - 2)^2 + z^2) - .2*exp(x/4) - .3\" "
                     "\"point3 p1\" [-3 -3 -1] \"point3 p2\" [3.5 3 1.5]",
                     "\"string function\" \"z + .6 - .2*sin(3*x)*cos(2*y)\""}},
       makeImplicit});
}

} // namespace recurse
