/** @file
 * Progressive refinement radiosity (Cohen, Chen, Wallace, Greenberg 1988) with form factors by rays: the
 * triangles of matt meshes are diced to patches, the patch with most unshot power shoots next, and what the
 * patches receive is interpolated between their corners. Direct light is found by shadow rays instead.
 */
#include <algorithm>
#include <array>
#include <map>
#include <queue>

#include "recurse/core/sampling.h"
#include "recurse/core/text.h"
#include "recurse/model/plugIns.h"
#include "recurse/model/triangleMesh.h"
#include "recurse/transport/localShading.h"
#include "recurse/transport/pathEnds.h"
#include "recurse/transport/walker.h"

namespace recurse {

namespace {

constexpr uint64_t LIGHT_RAYS = 0x5241444c49474854ull, PATCH_RAYS = 0x5241445041544348ull;
/** Of the first unshot power: the shooting ends when so little is left. */
constexpr double CONVERGED = 1e-3;
/** Rays of one shot at the least: fewer would make single patches bright. */
constexpr int MIN_RAYS = 32;
constexpr size_t MAX_PATCHES = 100000;
constexpr int MAX_DIVISIONS = 128;

/** A place on a diced triangle: the part that it lies in, and its corners with their weights. */
struct DicedPlace {
  uint32_t patch = 0;
  std::array<uint32_t, 3> corner{};
  std::array<float, 3> weight{};
};

/** A triangle cut into n² equal ones; corners and patches are numbered from a first one on. */
struct DicedTriangle {
  Vec3f origin, u, v; ///< a vertex, and the edges from it
  Vec3f normal;       ///< geometric, unit
  uint32_t mesh = 0, primitive = 0;
  uint32_t divisions = 1, firstPatch = 0, firstCorner = 0;

  uint32_t patchCount() const { return divisions * divisions; }
  uint32_t cornerCount() const { return (divisions + 1) * (divisions + 2) / 2; }
  float patchArea() const { return glm::length(glm::cross(u, v)) / 2 / static_cast<float>(patchCount()); }
  uint32_t corner(uint32_t i, uint32_t j) const {
    return firstCorner + i * (divisions + 1) - i * (i - 1) / 2 + j;
  }
  DicedPlace place(const Vec3f& position) const {
    // Barycentric coordinates by the normal equations.
    const Vec3f d = position - origin;
    const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), du = glm::dot(d, u),
                 dv = glm::dot(d, v), det = uu * vv - uv * uv;
    const double n = divisions, most = std::nextafter(1.0, 0.0);
    double a = det > 0 ? std::clamp((vv * du - uv * dv) / det, 0.0, most) : 0;
    double b = det > 0 ? std::clamp((uu * dv - uv * du) / det, 0.0, most) : 0;
    if (a + b > most) {
      const double scale = most / (a + b);
      a *= scale;
      b *= scale;
    }
    auto i = std::min(static_cast<uint32_t>(a * n), divisions - 1);
    auto j = std::min(static_cast<uint32_t>(b * n), divisions - 1 - i);
    const float f = std::clamp(static_cast<float>(a * n - i), 0.0f, 1.0f),
                g = std::clamp(static_cast<float>(b * n - j), 0.0f, 1.0f);
    const bool upper = f + g > 1 && i + j + 2 <= divisions;
    DicedPlace out;
    out.patch = firstPatch + i * (2 * divisions - i) + 2 * j + upper;
    if (upper) {
      out.corner = {corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)};
      out.weight = {1 - g, 1 - f, f + g - 1};
    } else {
      out.corner = {corner(i, j), corner(i + 1, j), corner(i, j + 1)};
      out.weight = {std::max(0.0f, 1 - f - g), f, g};
    }
    return out;
  }
  /** Corners of patch number k of the triangle, as parts of u and v. */
  std::array<Vec2f, 3> cornersOf(uint32_t k) const {
    uint32_t i = 0;
    while (i + 1 < divisions && k >= (i + 1) * (2 * divisions - (i + 1))) ++i;
    const uint32_t rest = k - i * (2 * divisions - i), j = rest / 2;
    const auto n = static_cast<float>(divisions);
    const auto at = [n](uint32_t x, uint32_t y) {
      return Vec2f(static_cast<float>(x) / n, static_cast<float>(y) / n);
    };
    if (rest % 2) return {at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)};
    return {at(i, j), at(i + 1, j), at(i, j + 1)};
  }
};

class Radiosity final : public Integrator {
 public:
  Radiosity(int rays, float patchSize) : rays(rays), patchSize(patchSize) {}

  void prepare(const Scene& scene, const PathClasses& classes) override {
    lights.learn(scene);
    dice(scene);
    states = classes.lightStateCount();
  }

  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics;
    statistics.notes.push_back(formatted("radiosity: %zu patches of about %.3g on %zu triangles",
                                         patchTriangle.size(), double(size), triangles.size()));
    if (ignored > 0)
      statistics.warnings.push_back(formatted(
          "radiosity: %zu of the scene's shapes are no meshes of one matt material at rest, and reflect no "
          "indirect light",
          ignored));
    solve(scene, classes, pass, control, statistics);
    reconstruct();
    statistics.photonsEmitted = static_cast<uint64_t>(rays);
    return statistics;
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    CameraWalker walker(scene, classes, out.counts, 1);
    CameraSubpath path = startCameraSubpath(scene, classes, ray, out.counts);
    CameraVertex vertex;
    const auto addEmission = [&](const Hit* hit) { addSeenEmission(scene, lights, path, hit, out); };
    if (!walker.next(path, vertex, sampler, addEmission)) return;
    addDirectLight(scene, lights, vertex, path.nesting, sampler, out);
    const DicedTriangle* t = vertex.isConnectable() ? triangleOf(vertex.hit, *vertex.scattering) : nullptr;
    if (!t) return;
    const DicedPlace place = t->place(vertex.point().position);
    const Vec3f normal = vertex.point().normalTowards(vertex.wi);
    const Rgb f = vertex.scattering->value(vertex.wi, normal);
    const size_t side = sideOf(vertex.wi, vertex.point());
    for (size_t s = 0; s < states; ++s) {
      Rgb e = BLACK;
      for (size_t k = 0; k < 3; ++k)
        e += cornerIrradiance[at(sharedCorner[place.corner[k]], side, s)] * place.weight[k];
      if (!isBlack(e)) out.add(LightState(static_cast<uint8_t>(s)), vertex.afterD, f * e);
    }
  }

  std::string claims() const override { return "LD*E"; }
  std::string suppositions() const override {
    return "that indirect light changes little over a patch, and is reflected by matt meshes alone";
  }
  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LE", "none: met by camera rays", "", true},
            {"shadow rays", "LDE", "one for each camera ray", "direct light"},
            {"BSDF rays", "LDE", "one for each camera ray", "direct light", true},
            {"patches", "LDD+E", "none: looked up", ""}};
  }

 private:
  /** Place of a patch's or corner's side and state in the arrays. */
  size_t at(size_t item, size_t side, size_t state) const { return (2 * item + side) * states + state; }
  static size_t sideOf(const Vec3f& wi, const SurfacePoint& point) {
    return glm::dot(wi, point.geometricNormal) > 0 ? 0 : 1;
  }
  static bool isMatt(const Material* material) {
    return material && (material->lobes() & (ALL_LOBES | LAMBERTIAN)) == (REFLECTION | LAMBERTIAN);
  }

  // ---------------------------------------------------------------------------------------------- patches

  void dice(const Scene& scene) {
    const std::vector<SceneMesh>& meshes = scene.meshes();
    size = patchSize > 0 ? patchSize : scene.bounds().radius / 20;
    size_t matt = 0;
    for (const SceneMesh& m : meshes) matt += isMatt(m.material);
    ignored = scene.contents().shapes > matt ? scene.contents().shapes - matt : 0;
    for (;; size *= 1.25f) {
      triangles.clear();
      firstTriangle.assign(meshes.size(), -1);
      uint32_t patches = 0, corners = 0;
      for (uint32_t m = 0; m < meshes.size(); ++m) {
        if (!isMatt(meshes[m].material)) continue;
        firstTriangle[m] = static_cast<int>(triangles.size());
        diceMesh(*meshes[m].mesh, m, patches, corners);
      }
      // Triangles without a cut are the least that there can be.
      if (patches <= MAX_PATCHES || patches == triangles.size()) break;
    }
    patchTriangle.clear();
    for (uint32_t t = 0; t < triangles.size(); ++t)
      patchTriangle.insert(patchTriangle.end(), triangles[t].patchCount(), t);
    shareCorners();
  }

  void diceMesh(const TriangleMesh& mesh, uint32_t number, uint32_t& patches, uint32_t& corners) {
    for (uint32_t i = 0; i < mesh.primitiveCount(); ++i) {
      const glm::uvec3& index = mesh.indices()[i];
      DicedTriangle t;
      t.origin = mesh.positions()[index.x];
      t.u = mesh.positions()[index.y] - t.origin;
      t.v = mesh.positions()[index.z] - t.origin;
      t.normal = mesh.placeAt(i, HitParameters(Vec2f(1.0f / 3))).geometricNormal;
      t.mesh = number;
      t.primitive = i;
      const float longest = std::max({glm::length(t.u), glm::length(t.v), glm::length(t.u - t.v)});
      t.divisions = static_cast<uint32_t>(
          std::clamp(std::ceil(longest / size), 1.0f, static_cast<float>(MAX_DIVISIONS)));
      t.firstPatch = patches;
      t.firstCorner = corners;
      patches += t.patchCount();
      corners += t.cornerCount();
      triangles.push_back(t);
    }
  }

  /** Corners of patches that touch and lie in nearly the same plane are one. */
  void shareCorners() {
    constexpr float COPLANAR = 0.9f; // cosine of the angle between their normals
    struct Shared {
      Vec3f normal;
      uint32_t index;
    };
    const float grain = size * 1e-3f;
    std::map<std::array<int64_t, 3>, std::vector<Shared>> found;
    sharedCorner.clear();
    cornerCount = 0;
    for (const DicedTriangle& t : triangles)
      for (uint32_t i = 0; i <= t.divisions; ++i)
        for (uint32_t j = 0; i + j <= t.divisions; ++j) {
          const auto n = static_cast<float>(t.divisions);
          const Vec3f p = t.origin + t.u * (static_cast<float>(i) / n) + t.v * (static_cast<float>(j) / n);
          auto& there =
              found[{std::llround(p.x / grain), std::llround(p.y / grain), std::llround(p.z / grain)}];
          const auto same = std::find_if(there.begin(), there.end(), [&](const Shared& s) {
            return glm::dot(s.normal, t.normal) > COPLANAR;
          });
          const uint32_t index = same == there.end() ? cornerCount++ : same->index;
          if (same == there.end()) there.push_back({t.normal, index});
          sharedCorner.push_back(index);
        }
  }

  /** Null where the surface does not take part. */
  const DicedTriangle* triangleOf(const Hit& hit, const ScatteringPoint& scattering) const {
    if (hit.mesh < 0 || firstTriangle[static_cast<size_t>(hit.mesh)] < 0) return nullptr;
    if (!(scattering.lobes() & LAMBERTIAN)) return nullptr;
    return &triangles[static_cast<size_t>(firstTriangle[static_cast<size_t>(hit.mesh)]) + hit.primitive];
  }

  // --------------------------------------------------------------------------------------------- shooting

  /** Power of light in each state, W. */
  using Power = std::vector<Rgb>;

  void solve(const Scene& scene, const PathClasses& classes, const Pass& pass, const ForwardControl& control,
             ForwardStatistics& statistics) {
    const size_t patches = patchTriangle.size();
    received.assign(2 * patches * states, BLACK);
    unshot.assign(2 * patches * states, BLACK);
    queue = {};
    queued.assign(2 * patches, 0);
    Power power(states, BLACK);
    for (int i = 0; i < rays && !control.stopped() && scene.lights().size() > 0; ++i) {
      Sampler sampler(hashCombine(pass.seed, pass.index), LIGHT_RAYS, static_cast<uint32_t>(i));
      const auto start = startLightSubpath(scene, classes, pass.time, sampler, statistics.counts);
      if (!start) continue;
      power[start->path.state.byte] = start->path.throughput / static_cast<float>(rays);
      send(scene, classes, start->path.ray, start->path.nesting, power, true, statistics.counts);
      power[start->path.state.byte] = BLACK;
    }
    double total = 0;
    for (size_t i = 0; i < 2 * patches; ++i) total += powerOf(i);
    double left = total;
    uint64_t shot = 0;
    while (!queue.empty() && left > CONVERGED * total && !control.stopped()) {
      const auto [value, index] = queue.top();
      queue.pop();
      const size_t i = ~index;
      const double now = powerOf(i);
      queued[i] = 0;
      if (now != value) { // it has got more since
        enqueue(i, now);
        continue;
      }
      left += shoot(scene, classes, pass, i, now / total, shot, power, statistics.counts) - now;
      control.progress(
          std::clamp(std::log(std::max(left / total, CONVERGED)) / std::log(CONVERGED), 0.0, 1.0));
    }
    statistics.notes.push_back(
        formatted("radiosity: %.3g %% of the reflected light was left unshot", 100 * left / total));
  }

  double powerOf(size_t patchSide) const {
    double sum = 0;
    for (size_t s = 0; s < states; ++s) sum += double(luminance(unshot[patchSide * states + s]));
    return sum;
  }
  /** Of equal power the lower index comes first. */
  void enqueue(size_t patchSide, double power) {
    if (!(power > 0)) return;
    queued[patchSide] = power;
    queue.push({power, ~patchSide});
  }

  /** Shoots all of a patch's unshot power. Returns how much power has come to be unshot by it. */
  double shoot(const Scene& scene, const PathClasses& classes, const Pass& pass, size_t patchSide,
               double part, uint64_t& shot, Power& power, TransportCounts& counts) {
    const size_t patch = patchSide / 2;
    const DicedTriangle& t = triangles[patchTriangle[patch]];
    const std::array<Vec2f, 3> corners = t.cornersOf(static_cast<uint32_t>(patch) - t.firstPatch);
    const int count = std::max(MIN_RAYS, static_cast<int>(std::ceil(part * rays)));
    for (size_t s = 0; s < states; ++s) {
      power[s] = unshot[patchSide * states + s] / static_cast<float>(count);
      unshot[patchSide * states + s] = BLACK;
    }
    double gained = 0;
    for (int i = 0; i < count; ++i, ++shot) {
      Sampler sampler(hashCombine(pass.seed, pass.index), PATCH_RAYS + patchSide, static_cast<uint32_t>(i));
      const Vec2f a = sampler.next2D();
      const float root = std::sqrt(a.x);
      const Vec2f at = corners[0] * (1 - root) + corners[1] * (root * (1 - a.y)) + corners[2] * (root * a.y);
      const SurfacePoint from = scene.meshes()[t.mesh].mesh->placeAt(t.primitive, HitParameters(at));
      const Vec3f normal = from.geometricNormal * (patchSide % 2 == 0 ? 1.0f : -1.0f);
      const Ray ray = spawn(from, Frame(normal).toWorld(cosineHemisphere(sampler.next2D())));
      gained += send(scene, classes, ray, {}, power, false, counts);
    }
    std::fill(power.begin(), power.end(), BLACK);
    return gained;
  }

  /** Light along a ray to the surface that it meets. Direct light is only reflected: what receives it is seen
   * by shadow rays. Returns the power that is reflected. */
  double send(const Scene& scene, const PathClasses& classes, Ray ray, Nesting nesting, const Power& power,
              bool direct, TransportCounts& counts) {
    Hit hit;
    for (;;) {
      if (!intersect(scene, ray, hit, counts)) return 0;
      arena.reset();
      const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena);
      if (!bsdf) {
        ray = spawn(hit.point, ray.direction);
        continue;
      }
      const ScatteringPoint scattering(*bsdf, hit.point);
      const DicedTriangle* t = triangleOf(hit, scattering);
      if (!t) return 0;
      const Vec3f wi = -ray.direction;
      const uint32_t patch = t->place(hit.point.position).patch;
      const size_t side = sideOf(wi, hit.point);
      const Rgb albedo = scattering.value(wi, hit.point.normalTowards(wi)) * PI;
      const float perArea = 1 / t->patchArea();
      const double before = powerOf(2 * patch + side);
      for (size_t s = 0; s < states; ++s) {
        if (isBlack(power[s])) continue;
        if (!direct) received[this->at(patch, side, s)] += power[s] * perArea;
        const LightState after = classes.step(LightState(static_cast<uint8_t>(s)), PathEvent::D);
        if (!classes.dead(after)) unshot[this->at(patch, side, after.byte)] += power[s] * albedo;
      }
      const double after = powerOf(2 * patch + side);
      // Seldom enough for the queue to stay short.
      if (after > 2 * queued[2 * patch + side]) enqueue(2 * patch + side, after);
      return after - before;
    }
  }

  /** Means at the corners over the patches around them. */
  void reconstruct() {
    cornerIrradiance.assign(2 * size_t(cornerCount) * states, BLACK);
    std::vector<float> area(cornerCount, 0);
    for (const DicedTriangle& t : triangles) {
      const float a = t.patchArea();
      for (uint32_t k = 0; k < t.patchCount(); ++k) {
        const std::array<Vec2f, 3> corners = t.cornersOf(k);
        for (const Vec2f& c : corners) {
          const auto n = static_cast<float>(t.divisions);
          const uint32_t corner = sharedCorner[t.corner(static_cast<uint32_t>(std::lround(c.x * n)),
                                                        static_cast<uint32_t>(std::lround(c.y * n)))];
          area[corner] += a;
          for (size_t side = 0; side < 2; ++side)
            for (size_t s = 0; s < states; ++s)
              cornerIrradiance[at(corner, side, s)] += received[at(t.firstPatch + k, side, s)] * a;
        }
      }
    }
    for (uint32_t c = 0; c < cornerCount; ++c)
      if (area[c] > 0)
        for (size_t k = 0; k < 2 * states; ++k) cornerIrradiance[2 * states * c + k] /= area[c];
  }

  int rays;
  float patchSize;
  LightSampler lights;
  float size = 0;     ///< longest edge of patches [scene units]
  size_t ignored = 0; ///< shapes
  std::vector<DicedTriangle> triangles;
  std::vector<int> firstTriangle;      ///< of each mesh of the scene; -1: it does not take part
  std::vector<uint32_t> patchTriangle; ///< of each patch
  std::vector<uint32_t> sharedCorner;  ///< of each triangle's corners
  uint32_t cornerCount = 0;            ///< of shared ones
  size_t states = 1;                   ///< that a light path can be in
  std::vector<Rgb> received;         ///< irradiance, but for direct light [W/area], by patch, side and state
  std::vector<Rgb> unshot;           ///< reflected power that has not been shot [W], the same
  std::vector<Rgb> cornerIrradiance; ///< by corner, side and state
  std::priority_queue<std::pair<double, size_t>>
      queue;                  ///< unshot power, and the complement of patch and side
  std::vector<double> queued; ///< power with which a side is in the queue
  BsdfArena arena;
};

} // namespace

void registerRadiosity(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "radiosity",
        .summary = "Radiosity: indirect light between patches of matt triangle meshes, smooth between them. "
                   "Other surfaces get direct light alone.",
        .parameters = {integerParameter("rays", "1000000", "rays that the form factors are found by, about")
                           .range(1, 1e9),
                       realParameter(
                           "patchsize", "",
                           "longest edge of a patch [scene units]; by default a twentieth of the scene's "
                           "radius")
                           .positive()},
        .examples = {"", "\"integer rays\" 20000 \"float patchsize\" .5"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<Radiosity>(
             p.integer("rays"), p.hasValue("patchsize") ? static_cast<float>(p.real("patchsize")) : 0);
       }});
}

} // namespace recurse
