/** @file
 * Metaballs: the surface where a sum of fields around points reaches a threshold. Along a line the field is a
 * polynomial between the points where it enters or leaves the support of a ball; its roots are isolated.
 */
#include "recurse/core/math/polynomialRoots.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/shape/ballField.h"
#include "recurse/model/shape/boxTree.h"
#include "shapes/analytic/mappedShape.h"

namespace recurse {

namespace {

struct Ball {
  Vec3d center;
  double radius, strength;
};

/** Product of two polynomials in Bernstein form over the same interval. */
template <size_t N, size_t M>
BernsteinForm<N + M> product(const BernsteinForm<N>& a, const BernsteinForm<M>& b) {
  constexpr auto binomial = [](size_t n, size_t k) {
    double x = 1;
    for (size_t i = 0; i < k; ++i) x = x * double(n - i) / double(i + 1);
    return x;
  };
  BernsteinForm<N + M> c{};
  for (size_t i = 0; i <= N; ++i)
    for (size_t k = 0; k <= M; ++k)
      c[i + k] += a[i] * b[k] * (binomial(N, i) * binomial(M, k) / binomial(N + M, i + k));
  return c;
}

struct Quartic {
  static constexpr size_t DEGREE = 4;
  static double value(double q) { return quarticField(q); }
  static double derivative(double q) { return -2 * (1 - q); }
  static BernsteinForm<DEGREE> along(const BernsteinForm<2>& q) {
    const BernsteinForm<2> w{1 - q[0], 1 - q[1], 1 - q[2]};
    return {w[0] * w[0], w[0] * w[1], (w[0] * w[2] + 2 * w[1] * w[1]) / 3, w[1] * w[2], w[2] * w[2]};
  }
};

struct Sextic {
  static constexpr size_t DEGREE = 6;
  static double value(double q) { return sexticField(q); }
  static double derivative(double q) { return -3 * square(1 - q); }
  static BernsteinForm<DEGREE> along(const BernsteinForm<2>& q) {
    return product<4, 2>(Quartic::along(q), {1 - q[0], 1 - q[1], 1 - q[2]});
  }
};

struct Wyvill {
  static constexpr size_t DEGREE = 6;
  static double value(double q) { return wyvillField(q); }
  static double derivative(double q) { return (-22 + q * (34 - 12 * q)) / 9; }
  static BernsteinForm<DEGREE> along(const BernsteinForm<2>& q) {
    // (1 - q)² (1 - 4/9 q), whose factors are never negative
    const BernsteinForm<2> factor{1 - 4 / 9.0 * q[0], 1 - 4 / 9.0 * q[1], 1 - 4 / 9.0 * q[2]};
    return product<4, 2>(Quartic::along(q), factor);
  }
};

struct Blinn {
  static constexpr size_t DEGREE = 8;
  static double value(double q) { return blinnField(q); }
  static double derivative(double q) { return (1 - q) * (-4 + q * (10 - 8 * q)); }
  static BernsteinForm<DEGREE> along(const BernsteinForm<2>& q) {
    const BernsteinForm<4> falling = Quartic::along(q), squared = product<2, 2>(q, q);
    BernsteinForm<4> sum;
    for (size_t i = 0; i < sum.size(); ++i) sum[i] = falling[i] + squared[i];
    return product<4, 4>(falling, sum);
  }
};

template <class Field> class Metaballs final : public MappedShape {
 public:
  Metaballs(std::vector<Ball> given, double threshold, const ShapeContext& context)
      : balls(std::move(given)), threshold(threshold) {
    Bounds3d all;
    for (const Ball& b : balls)
      if (b.strength > 0) {
        all.add(b.center - b.radius);
        all.add(b.center + b.radius);
      }
    const Vec3d middle = all.center();
    const double size = glm::length(all.diagonal());
    std::vector<Bounds3d> boxes;
    double reach = 0;
    for (Ball& b : balls) {
      b.center = (b.center - middle) / size;
      b.radius /= size;
      reach += b.radius / double(balls.size());
      strengths += std::abs(b.strength);
      boxes.push_back({b.center - b.radius, b.center + b.radius});
    }
    window = std::max(4 * reach, 1 / 64.0);
    tree = BoxTree(boxes);
    ownBounds = {(all.lower - middle) / size, (all.upper - middle) / size};
    Mat4d m = context.sceneFromObject;
    for (int i = 0; i < 3; ++i) m[i] *= size;
    m[3] = Vec4d(transformPoint(context.sceneFromObject, middle), 1);
    prepare(m, ownBounds, {}, context.reverseOrientation);
  }

  bool canBeSampled() const override { return false; }

  /** Balls around the centre of a ball, over some of them. */
  double testsOfRay() const override {
    constexpr size_t PROBES = 64;
    const size_t step = (balls.size() + PROBES - 1) / PROBES;
    double found = 0, probes = 0;
    for (size_t i = 0; i < balls.size(); i += step, ++probes)
      tree.visit(balls[i].center, {1, 0, 0}, 0, 0, [&](uint32_t) { ++found; });
    return found / probes;
  }

 protected:
  void intersectAll(const Line& line, LineHits& found) const override {
    const double speed = glm::length(line.direction);
    if (!(speed > 0)) return;
    const Vec3d d = line.direction / speed;
    // Segment of the line inside the bounds, measured from its middle.
    const double tNear = -glm::dot(line.origin, d);
    const Vec3d o = line.origin + d * tNear;
    const double half2 = square(0.5 * (1 + 1e-6)) - glm::dot(o, o);
    if (!(half2 > 0)) return;
    const double half = std::sqrt(half2);
    double from = std::max(-half, line.tMin * speed - tNear), to = std::min(half, line.tMax * speed - tNear);
    static thread_local std::vector<Reach> reaches;
    bool inside = false;
    bool first = true;
    const double step = line.nearestOnly ? window : INFINITE_D;
    for (; from < to; from += step) {
      const double end = std::min(to, from + step);
      reaches.clear();
      tree.visit(o, d, from, end, [&](uint32_t i) { addReach(balls[i], o, d, from, end, reaches); });
      if (first && line.tMin > -INFINITE_D) inside = fieldAlong(reaches, from) > 0;
      first = false;
      Sum sum;
      sum.fill(-threshold);
      intersectPiece(reaches, 0, from, end, sum, inside, [&](double t, bool entering) {
        found.add({(tNear + t) / speed, 0, entering, o + d * t});
        return !line.nearestOnly;
      });
      if (line.nearestOnly && !found.empty()) return;
    }
  }

  OwnPoint ownPoint(uint32_t, const Vec3d& near) const override {
    Vec3d p = near, gradient(0);
    double largest = 0;
    for (int i = 0; i < 4; ++i) {
      const double f = fieldAt(p, gradient);
      const double g2 = glm::dot(gradient, gradient);
      if (!(g2 > 0)) break;
      const Vec3d step = gradient * (f / g2);
      const double length = glm::length(step);
      if (length > MAX_STEP || (i > 0 && length >= largest)) break;
      p -= step;
      largest = length;
    }
    const double steepness = glm::length(gradient);
    OwnPoint s;
    s.position = p;
    s.normal = steepness > 0 ? -gradient / steepness : Vec3d(0, 0, 1);
    // Rounding of the field moves the surface.
    s.error = steepness > 0 ? std::min(0x1p-48 * strengths / steepness, MAX_ERROR) : MAX_ERROR;
    setSphericalCoordinates(s);
    return s;
  }

  Vec3d ownSample(uint32_t, const Vec2d&) const override { return Vec3d(0); }
  std::string whyOpen() const override { return ""; }

 private:
  // Lengths relative to the size of the whole shape.
  static constexpr double MAX_STEP = 1e-2;  ///< step limit of Newton's method, which diverges at flat points
  static constexpr double MAX_ERROR = 1e-5; ///< error bound where the field is flat

  /** Segment of a line inside the support of a ball. */
  struct Reach {
    double from, to;
    double nearest, distance2; ///< centre along the line, squared distance off it [radii]
    double scale;              ///< 1 / radius
    double strength;
    double q(double t) const { return square(t * scale - nearest) + distance2; }
  };

  static void addReach(const Ball& b, const Vec3d& o, const Vec3d& d, double from, double to,
                       std::vector<Reach>& reaches) {
    const Vec3d c = b.center - o;
    const double along = glm::dot(c, d);
    const Vec3d off = c - d * along;
    const double scale = 1 / b.radius, distance2 = glm::dot(off, off) * square(scale);
    if (!(distance2 < 1)) return;
    const double half = std::sqrt(1 - distance2) * b.radius;
    if (along + half <= from || along - half >= to) return;
    reaches.push_back({std::max(from, along - half), std::min(to, along + half), along * scale, distance2,
                       scale, b.strength});
  }

  double fieldAlong(const std::vector<Reach>& reaches, double t) const {
    double f = -threshold;
    for (const Reach& r : reaches)
      if (t >= r.from && t <= r.to) f += r.strength * Field::value(std::min(r.q(t), 1.0));
    return f;
  }

  /** Field minus the threshold, and its gradient. */
  double fieldAt(const Vec3d& p, Vec3d& gradient) const {
    double f = -threshold;
    gradient = Vec3d(0);
    tree.visit(p, {1, 0, 0}, 0, 0, [&](uint32_t i) {
      const Ball& b = balls[i];
      const Vec3d away = (p - b.center) / b.radius;
      const double q = glm::dot(away, away);
      if (q >= 1) return;
      f += b.strength * Field::value(q);
      gradient += away * (2 / b.radius * b.strength * Field::derivative(q));
    });
    return f;
  }

  using Sum = BernsteinForm<Field::DEGREE>;

  static void addField(const Reach& r, double low, double high, Sum& sum) {
    const double a = low * r.scale - r.nearest, b = high * r.scale - r.nearest;
    const auto f = Field::along({a * a + r.distance2, a * b + r.distance2, b * b + r.distance2});
    for (size_t k = 0; k < f.size(); ++k) sum[k] += r.strength * f[k];
  }

  /**
   * Calls visit(t, entering) for the crossings in ascending order while it returns true; false where it did
   * not. `inside` is the state at `low`, and on return at `high`. The field is `sum`, of balls whose support
   * covers the whole piece, plus the balls of reaches[first] to the last, which are removed from the list. A
   * piece in which supports begin or end is split there, unless the field cannot change its sign.
   */
  template <class Visit>
  bool intersectPiece(std::vector<Reach>& reaches, size_t first, double low, double high, Sum sum,
                      bool& inside, const Visit& visit) const {
    static thread_local std::vector<double> ends;
    ends.clear();
    double least = 0, most = 0; // field bounds of balls that begin or end in the piece
    size_t kept = first;
    for (size_t i = first; i < reaches.size(); ++i) {
      const Reach r = reaches[i];
      if (r.from <= low && r.to >= high) {
        addField(r, low, high, sum);
        continue;
      }
      reaches[kept++] = r;
      (r.strength > 0 ? most : least) += r.strength * Field::value(r.distance2);
      if (r.from > low) ends.push_back(r.from);
      if (r.to < high) ends.push_back(r.to);
    }
    reaches.resize(kept);
    least += *std::min_element(sum.begin(), sum.end());
    most += *std::max_element(sum.begin(), sum.end());
    bool goesOn = true;
    const auto change = [&](double t) {
      inside = !inside;
      goesOn = visit(t, inside) && goesOn;
    };
    const bool isSimple = least >= 0 || most < 0;
    if (isSimple || kept == first) {
      // Crossing that rounding has moved between two pieces.
      if ((isSimple ? least >= 0 : sum[0] >= 0) != inside) change(low);
      const auto field = [&](double t) {
        return bernsteinValue<Field::DEGREE>(sum, (t - low) / (high - low));
      };
      if (!isSimple)
        isolateRoots<Field::DEGREE>(sum, low, high, RESOLUTION, [&](double a, double b, bool rising) {
          if (rising != inside) change(refineRoot(field, a, b));
        });
      reaches.resize(first);
      return goesOn;
    }
    const auto median = ends.begin() + static_cast<std::ptrdiff_t>(ends.size() / 2);
    std::nth_element(ends.begin(), median, ends.end());
    const double middle = *median;
    const Sum rightSum = splitBernstein<Field::DEGREE>(sum, (middle - low) / (high - low));
    for (size_t i = first; i < kept; ++i)
      if (const Reach r = reaches[i]; r.from < middle) reaches.push_back(r);
    goesOn = intersectPiece(reaches, kept, low, middle, sum, inside, visit);
    if (!goesOn) return false;
    const auto endsBefore = [middle](const Reach& r) { return r.to <= middle; };
    reaches.erase(
        std::remove_if(reaches.begin() + static_cast<std::ptrdiff_t>(first), reaches.end(), endsBefore),
        reaches.end());
    return intersectPiece(reaches, first, middle, high, rightSum, inside, visit);
  }

  static constexpr double RESOLUTION = 1e-13;

  std::vector<Ball> balls;
  BoxTree tree;
  Bounds3d ownBounds;
  double threshold;
  double strengths = 0; ///< sum of their absolute values
  double window = 1;    ///< length of the ray pieces that are intersected at a time
};

std::unique_ptr<Shape> makeMetaballs(const Parameters& p, const ShapeContext& context) {
  const std::vector<Vec3d> centers = p.vector3s("P");
  const std::vector<double> radii = numbersOfBalls(p, "radius", centers.size()),
                            strengths = numbersOfBalls(p, "strength", centers.size());
  const double threshold = p.real("threshold");
  std::vector<Ball> balls;
  double sum = 0;
  for (size_t i = 0; i < centers.size(); ++i) {
    balls.push_back({centers[i], radii[i], strengths[i]});
    sum += std::max(0.0, strengths[i]);
  }
  if (!(sum > threshold))
    p.fail(p.has("threshold") ? "threshold" : "strength", "the field is below the threshold everywhere",
           "positive strengths that add up to more than the threshold");
  if (p.string("field") == "sextic")
    return std::make_unique<Metaballs<Sextic>>(std::move(balls), threshold, context);
  if (p.string("field") == "wyvill")
    return std::make_unique<Metaballs<Wyvill>>(std::move(balls), threshold, context);
  if (p.string("field") == "blinn")
    return std::make_unique<Metaballs<Blinn>>(std::move(balls), threshold, context);
  return std::make_unique<Metaballs<Quartic>>(std::move(balls), threshold, context);
}

} // namespace

void registerMetaballs(PlugIns& plugIns) {
  ParameterSpec radius = arrayParameter(ParameterType::REAL, "radius", 0, "1",
                                        "radius of each ball's field; one for all or one each");
  plugIns.shapes.add(
      {{.name = "metaballs",
        .summary = "The surface where the sum of the balls' fields is a threshold; a solid. The texture "
                   "\"metaballs\" blends colours by the same fields.",
        .parameters =
            {arrayParameter(ParameterType::POINT3, "P", 0, "", "centers of the balls").require(),
             radius.positive(),
             arrayParameter(
                 ParameterType::REAL, "strength", 0, "1",
                 "strength: field at the centre of each ball, may be negative; one for all or one each"),
             realParameter("threshold", "0.5", "field at the surface").positive(),
             stringParameter(
                 "field", "quartic",
                 "falloff of the field with q, the squared distance divided by the squared radius: "
                 "\"quartic\" (1 - q)², \"sextic\" (1 - q)³ as in Blender, \"wyvill\" 1 - 22/9 q + 17/9 q² - "
                 "4/9 q³, \"blinn\" approximately exp(-4 q), (1 - q)² ((1 - q)² + q²)")
                 .oneOf({"quartic", "sextic", "wyvill", "blinn"})},
        .examples = {"\"point3 P\" [0 0 0]",
                     "\"point3 P\" [-.5 0 0  .5 .1 0  0 .6 .2] \"float radius\" [1 .9 .7] "
                     "\"float strength\" [1 1.2 -.6]",
                     "\"point3 P\" [-.6 0 0  .6 0 0] \"float threshold\" .3 \"string field\" \"wyvill\"",
                     "\"point3 P\" [-.5 0 0  .5 .1 0] \"string field\" \"sextic\" \"float strength\" 2",
                     "\"point3 P\" [-.5 0 0  .5 .2 0] \"float threshold\" .2 \"string field\" \"blinn\""}},
       makeMetaballs});
}

} // namespace recurse
