/** @file
 * How near the path tracer comes to bare rays: the same rays in the same order, traced by the path tracer and
 * by Embree alone, in turns on one thread. Ends with `rays: path_vs_bare=R`, the ratio of rays per second.
 */
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <sstream>

#include "model/embree/embree.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/scene/directives/loader.h"
#include "recurse/transport/integrator/integrator.h"

using namespace recurse;

namespace {

struct RecordedRay {
  Ray ray;
  bool shadow;
};

/** The scene, writing down every ray. The camera and the film stay with the original. */
class RecordingScene final : public Scene {
 public:
  explicit RecordingScene(const Scene& scene) : scene(scene) {
    lightTable = scene.lights();
    environmentLights = scene.environment();
    environmentLightIndices = scene.environmentIndices();
    sceneBounds = scene.bounds();
    sceneContents = scene.contents();
  }
  bool intersect(const Ray& ray, Hit& hit) const override {
    rays.push_back({ray, false});
    return scene.intersect(ray, hit);
  }
  bool occluded(const Ray& ray) const override {
    rays.push_back({ray, true});
    return scene.occluded(ray);
  }
  void intersectBatch(std::span<const Ray> batch, Coherence coherence, std::span<Hit> hits) const override {
    for (const Ray& ray : batch) rays.push_back({ray, false});
    scene.intersectBatch(batch, coherence, hits);
  }
  void occludedBatch(std::span<const Ray> batch, std::span<uint8_t> blocked) const override {
    for (const Ray& ray : batch) rays.push_back({ray, true});
    scene.occludedBatch(batch, blocked);
  }
  size_t memoryBytes() const override { return scene.memoryBytes(); }

  mutable std::vector<RecordedRay> rays;

 private:
  const Scene& scene;
};

struct Mesh {
  std::vector<Vec3f> positions;
  std::vector<glm::uvec3> triangles;
};

/** A room with a hilly floor of about `wanted` triangles, and a lamp. */
Mesh hillyRoom(size_t wanted) {
  Mesh m;
  const auto quad = [&](Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
    const auto i = static_cast<unsigned>(m.positions.size());
    for (const Vec3f& p : {a, b, c, d}) m.positions.push_back(p);
    m.triangles.push_back({i, i + 1, i + 2});
    m.triangles.push_back({i, i + 2, i + 3});
  };
  quad({-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}, {1, 1, -1});
  quad({-1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {1, -1, -1});
  quad({-1, -1, -1}, {-1, -1, 1}, {-1, 1, 1}, {-1, 1, -1});
  quad({1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1});
  const auto n = static_cast<unsigned>(std::sqrt(double(wanted) / 2));
  const auto first = static_cast<unsigned>(m.positions.size());
  for (unsigned j = 0; j <= n; ++j)
    for (unsigned i = 0; i <= n; ++i) {
      const float x = 2 * float(i) / float(n) - 1, z = 2 * float(j) / float(n) - 1;
      m.positions.push_back(
          {x, -0.8f + 0.1f * std::sin(9 * x) * std::cos(7 * z) + 0.01f * std::sin(90 * x + 60 * z), z});
    }
  for (unsigned j = 0; j < n; ++j)
    for (unsigned i = 0; i < n; ++i) {
      const unsigned a = first + j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      m.triangles.push_back({a, c, b});
      m.triangles.push_back({b, c, d});
    }
  return m;
}

const std::vector<Vec3f> LAMP = {
    {-.25f, .995f, -.25f}, {.25f, .995f, -.25f}, {.25f, .995f, .25f}, {-.25f, .995f, .25f}};

std::string sceneText(const Mesh& m) {
  std::ostringstream s;
  s.precision(9);
  s << "Film \"rgb\" \"integer xresolution\" 128 \"integer yresolution\" 128\nPixelFilter \"box\"\n"
       "LookAt 0 0 3.9  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 39.3\nWorldBegin\n"
       "Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\nShape \"trianglemesh\" \"point3 P\" [";
  for (const Vec3f& p : m.positions) s << p.x << ' ' << p.y << ' ' << p.z << ' ';
  s << "] \"integer indices\" [";
  for (const glm::uvec3& t : m.triangles) s << t.x << ' ' << t.y << ' ' << t.z << ' ';
  s << "]\nAreaLightSource \"diffuse\" \"rgb L\" [9 9 9]\nShape \"trianglemesh\" \"integer indices\" [0 1 2 "
       "0 2 3] \"point3 P\" [";
  for (const Vec3f& p : LAMP) s << p.x << ' ' << p.y << ' ' << p.z << ' ';
  s << "]\n";
  return s.str();
}

class BareScene {
 public:
  explicit BareScene(const Mesh& m) : device(rtcNewDevice(nullptr)), scene(rtcNewScene(device)) {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    add(m.positions, m.triangles);
    add(LAMP, {{0, 1, 2}, {0, 2, 3}});
    rtcCommitScene(scene);
  }
  ~BareScene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  size_t trace(const std::vector<RecordedRay>& rays) const {
    size_t hits = 0;
    for (const RecordedRay& r : rays) {
      RTCRayHit h;
      h.ray = {r.ray.origin.x,
               r.ray.origin.y,
               r.ray.origin.z,
               0,
               r.ray.direction.x,
               r.ray.direction.y,
               r.ray.direction.z,
               0,
               r.ray.tMax,
               ~0u,
               0,
               0};
      if (r.shadow) {
        embree::occluded(scene, h.ray);
        hits += h.ray.tfar < 0;
      } else {
        h.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        embree::intersect(scene, h);
        hits += h.hit.geomID != RTC_INVALID_GEOMETRY_ID;
      }
    }
    return hits;
  }

 private:
  void add(const std::vector<Vec3f>& positions, const std::vector<glm::uvec3>& triangles) {
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* p = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                          sizeof(Vec3f), positions.size()));
    std::copy(positions.begin(), positions.end(), p);
    auto* t = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                               sizeof(glm::uvec3), triangles.size()));
    std::copy(triangles.begin(), triangles.end(), t);
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene, g);
    rtcReleaseGeometry(g);
  }
  RTCDevice device;
  RTCScene scene;
};

template <class F> double seconds(const F& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double compare(size_t triangles) {
  const Mesh mesh = hillyRoom(triangles);
  Diagnostics diagnostics;
  const SceneDescription description = parseScene(sceneText(mesh), "rays", ".", diagnostics);
  const std::unique_ptr<Scene> scene = buildScene(description, {}, diagnostics);
  diagnostics.throwIfErrors();
  const auto integrator = plugIns().integrators.make(parseParameterText("path", ""), {}, diagnostics);
  const PathClasses classes;
  const auto render = [&](const Scene& s) {
    TransportCounts counts;
    std::vector<PathRadiance> radiance(CAMERA_BATCH, PathRadiance(classes, counts));
    std::vector<CameraPath> paths;
    paths.reserve(CAMERA_BATCH);
    double sum = 0;
    const auto walk = [&] {
      integrator->backwardBatch(s, paths);
      for (const CameraPath& p : paths) sum += double(p.out->total().r);
      paths.clear();
    };
    const FilmSettings& film = scene->film();
    for (int y = 0; y < film.height; ++y)
      for (int x = 0; x < film.width; ++x)
        for (uint32_t i = 0; i < 8; ++i) {
          PathRadiance& out = radiance[paths.size()];
          out.reset();
          CameraPath& path = paths.emplace_back(Sampler(1, uint64_t(y) << 32 | uint32_t(x), i), out);
          const Vec2f place = Vec2f(float(x), float(y)) + path.sampler.next2D();
          path.ray = *scene->camera().sampleRay({place});
          if (paths.size() == CAMERA_BATCH) walk();
        }
    walk();
    if (!(sum > 0)) throw Error("the picture is black");
    return counts.rays;
  };
  RecordingScene recording(*scene);
  render(recording);
  const BareScene bare(mesh);
  std::vector<double> ratios;
  double pathBest = INFINITY, bareBest = INFINITY;
  for (int repeat = 0; repeat < 9; ++repeat) {
    const double path = seconds([&] { render(*scene); });
    size_t hits = 0;
    const double rays = seconds([&] { hits = bare.trace(recording.rays); });
    if (hits == 0) throw Error("the bare rays hit nothing");
    ratios.push_back(rays / path);
    pathBest = std::min(pathBest, path);
    bareBest = std::min(bareBest, rays);
  }
  std::nth_element(ratios.begin(), ratios.begin() + 4, ratios.end());
  const auto million = double(recording.rays.size()) / 1e6;
  std::printf("%8zu triangles: path %.2f Mrays/s, bare %.2f Mrays/s (best of 9), ratio %.3f (median)\n",
              mesh.triangles.size(), million / pathBest, million / bareBest, ratios[4]);
  return ratios[4];
}

} // namespace

int main() {
  try {
    const ThreadPool pool(1);
    compare(8);
    compare(1000000);
    std::printf("rays: path_vs_bare=%.3f\n", compare(100000));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "rays: %s\n", e.what());
    return 1;
  }
}
