/** @file
 * 9. Spheres stretched by up to 1:1e4: hit points and normals against the analytic ellipsoid, and rays that
 * leave the surface without hitting it again.
 */
#include "hardCase.h"

#include <random>

#include "recurse/core/sampling/sampling.h"

namespace recurse::hard {

namespace {

using Real = long double;
using Vec3r = glm::vec<3, Real>;
using Mat3r = glm::mat<3, 3, Real>;

struct Ellipsoid {
  const char* name;
  Vec3d axes;
  bool turned;
  double moved; ///< displacement relative to the longest axis
};

constexpr const char* TURN = "Rotate 40 .5 1 .3\n";

/** The matrix of TURN, from its definition (Rodrigues' formula). */
Mat3r turn() {
  const Real angle = 40 * M_PIl / 180, c = std::cos(angle), s = std::sin(angle);
  const Vec3r a = glm::normalize(Vec3r(Real(.5L), 1, Real(.3L)));
  Mat3r m;
  for (int i = 0; i < 3; ++i) {
    Vec3r e(0);
    e[i] = 1;
    m[i] = e * c + glm::cross(a, e) * s + a * (glm::dot(a, e) * (1 - c));
  }
  return m;
}

std::string text(const Ellipsoid& e) {
  const double far = e.moved * std::max(e.axes.x, std::max(e.axes.y, e.axes.z));
  return "Translate " + number(far) + " " + number(-far / 2) + " " + number(far / 3) + "\n" +
         (e.turned ? TURN : "") + "Scale " + number(e.axes.x) + " " + number(e.axes.y) + " " +
         number(e.axes.z) + "\n";
}

void hits(const Report& report, const Ellipsoid& e) {
  const auto scene = sceneFrom(view(1, 1, "0 0 1  0 0 0  0 1 0", orthographic(1)) + diffuse(0.5) + text(e) +
                               "Shape \"sphere\"\n");
  const double far = e.moved * std::max(e.axes.x, std::max(e.axes.y, e.axes.z));
  const Vec3r centre = Vec3r(Vec3d(far, -far / 2, far / 3)) - Vec3r(scene->origin());
  Mat3r m = e.turned ? turn() : Mat3r(1);
  for (int i = 0; i < 3; ++i) m[i] *= Real(e.axes[i]);
  const Mat3r inverse = glm::inverse(m);
  const Real size = std::max(Real(e.axes.x), std::max(Real(e.axes.y), Real(e.axes.z)));

  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  constexpr int COUNT = 100000;
  double worstPoint = 0, worstNormal = 0, worstDistance = 0;
  int missed = 0, selfHits = 0, lost = 0;
  for (int i = 0; i < COUNT; ++i) {
    // Ray towards a random point of the ellipsoid, from a random point outside at up to 10 times its size.
    const Vec3r target =
        centre + m * Vec3r(uniformSphere({uniform(random), uniform(random)})) * Real(uniform(random));
    const Vec3f from = Vec3f(centre + Vec3r(uniformSphere({uniform(random), uniform(random)})) *
                                          (size * Real(2 + 8 * uniform(random))));
    Ray ray{from, glm::normalize(Vec3f(Vec3r(target) - Vec3r(from))), INFINITE};
    // Intersection for exactly this ray of floats, whatever its rounding.
    const Vec3r o = inverse * (Vec3r(ray.origin) - centre), d = inverse * Vec3r(ray.direction);
    const Real a = glm::dot(d, d), b = glm::dot(o, d);
    const Vec3r nearest = o - d * (b / a);
    const Real discriminant = 1 - glm::dot(nearest, nearest);
    // Within rounding of a miss, both results are correct.
    if (discriminant < Real(1e-10L)) continue;
    const Real t = (-b - std::sqrt(discriminant * a)) / a;
    Hit hit;
    if (!scene->intersect(ray, hit)) {
      ++missed;
      continue;
    }
    const Vec3r unit = o + d * t;
    const Vec3r point = centre + m * unit, normal = glm::normalize(glm::transpose(inverse) * unit);
    worstPoint =
        std::max(worstPoint, static_cast<double>(glm::length(Vec3r(hit.point.position) - point) / size));
    worstDistance = std::max(worstDistance, static_cast<double>(std::abs(Real(hit.t) - t) / t));
    // The angle between two unit vectors is approximately the length of their difference.
    worstNormal =
        std::max(worstNormal, static_cast<double>(glm::length(Vec3r(hit.point.geometricNormal) - normal)));

    // A ray to the outside hits nothing; a ray to the inside hits the far side.
    const Frame frame(hit.point.geometricNormal);
    const Vec3f out = frame.toWorld(cosineHemisphere({uniform(random), uniform(random)}));
    Hit next;
    if (scene->intersect({hit.point.rayOrigin(out), out, INFINITE}, next)) ++selfHits;
    const Vec3f in = -out;
    if (!scene->intersect({hit.point.rayOrigin(in), in, INFINITE}, next)) ++lost;
  }
  report.atMost("rays that miss", "-", "of 1e5", missed, 0);
  report.atMost("hit point", "-", "error over size", worstPoint, 1e-5);
  report.atMost("distance", "-", "relative error", worstDistance, 1e-5);
  report.atMost("normal", "-", "angle [rad]", worstNormal, 1e-5);
  report.atMost("meets itself outwards", "-", "of 1e5", selfHits, 0);
  report.atMost("lost inwards", "-", "of 1e5", lost, 0);
}

/** In uniform light a convex body has the radiance of its albedo. */
void picture(const Report& report, const Ellipsoid& e) {
  const double size = std::max(e.axes.x, std::max(e.axes.y, e.axes.z)), far = e.moved * size;
  const double least = std::min(e.axes.x, std::min(e.axes.y, e.axes.z));
  // Cameras at the side, above, and with a window as small as the shortest axis.
  const std::string middle = number(far) + " " + number(-far / 2) + " " + number(far / 3);
  const auto from = [&](double x, double y, double z) {
    return number(far + x * size) + " " + number(-far / 2 + y * size) + " " + number(far / 3 + z * size) +
           "  " + middle + "  .1 .2 1";
  };
  Budget budget;
  budget.samples = 64;
  budget.photonSamples = 8;
  budget.tolerance = 2e-3;
  // A map of direct light would need photons at distances much smaller than the shortest axis.
  budget.only = [](const Way& w) { return !w.directPhotons; };
  for (const auto& [detail, eye] :
       {std::pair{"seen along x", from(2, .01, .02)}, std::pair{"seen askew", from(1, 1.5, 1)}})
    checkMean(report, std::string(detail) + ", in even light",
              view(8, 8, eye, orthographic(0.3 * least)) + constantLight(1) + diffuse(0.5) + text(e) +
                  "Shape \"sphere\"\n",
              0.5, budget);
}

} // namespace

void addEllipsoidCases(HardCases& cases) {
  static const Ellipsoid ALL[] = {{"sphere", {1, 1, 1}, false, 0},
                                  {"needle 1e4:1:1", {1, 1e-4, 1e-4}, false, 0},
                                  {"needle 1e4:1:1, turned", {1, 1e-4, 1e-4}, true, 0},
                                  {"lens 1:1:1e-4", {1, 1, 1e-4}, false, 0},
                                  {"lens 1:1:1e-4, turned", {1, 1, 1e-4}, true, 0},
                                  {"lens 1:1:1e-4, turned and moved by 1e5", {1, 1, 1e-4}, true, 1e5},
                                  {"1:1e-2:1e-4, turned", {1, 1e-2, 1e-4}, true, 0},
                                  {"needle of length 1e4, turned", {1e4, 1, 1}, true, 0}};
  for (const Ellipsoid& e : ALL) {
    cases.push_back({9, e.name, false, [&e](const Report& r) {
                       hits(r, e);
                       picture(r, e);
                     }});
  }
}

} // namespace recurse::hard
