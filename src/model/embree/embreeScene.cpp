/** @file
 * Intersection and occlusion queries of the scene.
 */
#include "model/embree/embreeScene.h"

#include <algorithm>
#include <cfloat>
#include <unordered_map>

#include "recurse/core/sampling/sampler.h"
#include "recurse/core/threads/inPlace.h"
#include "recurse/core/threads/interrupt.h"
#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/surroundingMedium.h"

namespace recurse {

namespace {

/** Up to this number of rays, single queries are faster than a packet. */
constexpr size_t MAX_SINGLE_RAYS = 2;
/** Number of rays that are prepared together. */
constexpr size_t GROUP = 64;

void setRay(RTCRay& r, const Ray& ray, unsigned mask) {
  r.org_x = ray.origin.x;
  r.org_y = ray.origin.y;
  r.org_z = ray.origin.z;
  r.tnear = 0;
  r.dir_x = ray.direction.x;
  r.dir_y = ray.direction.y;
  r.dir_z = ray.direction.z;
  r.time = ray.time;
  r.tfar = ray.tMax;
  r.mask = mask;
  r.id = 0;
  r.flags = 0;
}

/** Sets ray `i` of an RTCRay8, or of the ray part of an RTCRayHit8. */
template <class Packet> void setRay(Packet& r, size_t i, const Ray& ray, unsigned mask) {
  r.org_x[i] = ray.origin.x;
  r.org_y[i] = ray.origin.y;
  r.org_z[i] = ray.origin.z;
  r.tnear[i] = 0;
  r.dir_x[i] = ray.direction.x;
  r.dir_y[i] = ray.direction.y;
  r.dir_z[i] = ray.direction.z;
  r.time[i] = ray.time;
  r.tfar[i] = ray.tMax;
  r.mask[i] = mask;
  r.id[i] = 0;
  r.flags[i] = 0;
}

RTCDevice newDevice() {
  RTCDevice device = rtcNewDevice(nullptr);
  const RTCError problem = device ? RTC_ERROR_NONE : rtcGetDeviceError(nullptr);
  if (problem == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (!device) throw Error("Embree does not start (error " + std::to_string(problem) + ")");
  rtcSetDeviceErrorFunction(
      device,
      [](void*, RTCError code, const char* text) {
        if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
        throw Error("Embree: " + std::string(text));
      },
      nullptr);
  return device;
}

} // namespace

void transformToScene(const GeometryGroup::Instance& instance, float time, SurfacePoint& p) {
  if (instance.sceneFromGroup.moves()) return placeByMotion(instance.sceneFromGroup.at(time), p);
  const Mat4d& m = instance.sceneFromGroup.first();
  const Vec3d local = p.position;
  const Vec3d position = transformPoint(m, local);
  const Mat3d linear(m);
  const Mat3d magnitude(glm::abs(linear[0]), glm::abs(linear[1]), glm::abs(linear[2]));
  // Embree transforms the ray in float, so that the rounding of its coordinates adds to the error.
  const Vec3d error = magnitude * Vec3d(p.error) +
                      double(roundingBound(6)) * (magnitude * glm::abs(local) + glm::abs(Vec3d(m[3])));
  p.position = Vec3f(position);
  p.error = Vec3f(error);
  transformDirections(linear, instance.normalFromGroup, p);
}

EmbreeDevice::EmbreeDevice() : handle(newDevice()) {
  rtcSetDeviceMemoryMonitorFunction(
      handle,
      [](void* device, ssize_t added, bool) {
        static_cast<EmbreeDevice*>(device)->taken += added;
        return true;
      },
      this);
}

EmbreeScene::EmbreeScene(std::shared_ptr<const EmbreeDevice> device)
    : device(std::move(device)),
      packets(rtcGetDeviceProperty(this->device->get(), RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0) {}

EmbreeScene::PositionHit EmbreeScene::nearest(const Ray& ray, unsigned mask, float tMin) const {
  checkInterrupted();
  RTCRayHit rayHit;
  setRay(rayHit.ray, ray, mask);
  rayHit.ray.tnear = tMin;
  rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(groups.front()->scene(), rayHit);
  const RTCHit& h = rayHit.hit;
  return {rayHit.ray.tfar, parametersOf(h), h.geomID, h.primID, h.instID[0]};
}

const GeometryGroup& EmbreeScene::groupOf(const PositionHit& position) const {
  return position.instance == RTC_INVALID_GEOMETRY_ID ? top() : *top().instance(position.instance).group;
}

const TriangleMesh* EmbreeScene::meshOf(const PositionHit& position) const {
  return position.geometry == RTC_INVALID_GEOMETRY_ID ? nullptr
                                                      : groupOf(position).geometry(position.geometry).mesh;
}

std::optional<EmbreeScene::PositionHit>
EmbreeScene::inSamePlace(const Ray& ray, const Hit& hit, unsigned mask, Wanted wanted, Hit& other) const {
  constexpr float MIN_COSINE = 0.05f, WIDER = 64; // WIDER: largest error of the other surface over this one's
  const Vec3f normal = magnitude(hit.point.geometricNormal);
  const float cosine =
      std::max(absDot(ray.direction, hit.point.geometricNormal), MIN_COSINE * glm::length(ray.direction));
  const auto errorOf = [&](const Hit& h) { return 2 * glm::dot(normal, h.point.error) / cosine; };
  // Positions on triangles may be exact, but the distances of hits are rounded.
  const float error = errorOf(hit) + roundingBound(8) * hit.t;
  Ray near = ray;
  near.tMax = std::min(ray.tMax, hit.t + WIDER * error);
  const float tMin = std::max(0.0f, hit.t - WIDER * error);
  if (!(tMin < near.tMax && near.tMax < INFINITE)) return {};
  const PositionHit found = nearest(near, mask, tMin);
  if (found.geometry == RTC_INVALID_GEOMETRY_ID) return {};
  computeHit(found, ray.time, wanted, other);
  if (!(std::abs(other.t - hit.t) <= error + errorOf(other))) return {};
  return found;
}

std::set<const Shape*> EmbreeScene::findTouching() {
  // Numbers of points: on a mesh, on another shape, and in all.
  constexpr size_t OF_MESH = 256, OF_OTHERS = 32, OF_ALL = 1 << 18;
  constexpr float HEIGHT = 128; // height at which the probing rays start, over the error of the point
  GeometryGroup& top = *groups.front();
  const auto passesLight = [](const SceneGeometry& g) { return g.compound || !isOpaque(g.material); };
  const auto isAsked = [&](const SceneGeometry& g) { return !g.curve && (g.light || passesLight(g)); };
  size_t count = 0;
  std::unordered_map<const GeometryGroup*, GeometryGroup*> changeable;
  for (const auto& group : groups) changeable.emplace(group.get(), group.get());
  const auto forAll = [&](const auto& visit) {
    for (size_t id = 0; id < top.allGeometries().size(); ++id) visit(top, nullptr, id);
    for (const GeometryGroup::Instance& i : top.allInstances())
      for (size_t id = 0; id < i.group->allGeometries().size(); ++id) visit(*changeable.at(i.group), &i, id);
  };
  forAll([&](GeometryGroup& group, const GeometryGroup::Instance*, size_t id) {
    count += isAsked(group.allGeometries()[id]);
  });
  const size_t most = std::max<size_t>(OF_ALL / std::max<size_t>(count, 1), 1);
  std::set<const Shape*> unseen;
  forAll([&](GeometryGroup& group, const GeometryGroup::Instance* instance, size_t id) {
    const SceneGeometry& g = group.allGeometries()[id];
    const bool passes = passesLight(g);
    if (!isAsked(g) || (passes && g.hiddenBy)) return;
    if (!g.shape->isQuicklySampled()) return group.hide(id, passes ? OPAQUE : 0u);
    const size_t points = std::min(most, g.mesh ? OF_MESH : OF_OTHERS);
    size_t hidden = 0, asked = 0;
    // One hidden point of a surface that light passes is enough to mark it. Further points then only tell
    // whether all of it is hidden.
    while (asked < points && (!passes || hidden == asked || hidden == 0)) {
      Sampler sampler(0, id, asked++);
      const float pick = sampler.next1D();
      Hit hit, other;
      hit.point = g.shape->sampleArea(pick, sampler.next2D()).point;
      if (instance) transformToScene(*instance, 0, hit.point);
      if (!isFinite(hit.point.position)) continue;
      const Vec3f& normal = hit.point.geometricNormal;
      const float height = HEIGHT * std::max(glm::dot(magnitude(normal), hit.point.error),
                                             roundingBound(1) * glm::length(hit.point.position));
      const Ray down{hit.point.position + normal * height, -normal, INFINITE, 0};
      hit.t = glm::dot(down.origin - hit.point.position, normal);
      const auto found = inSamePlace(down, hit, passes ? OPAQUE | LAMP : OPAQUE, Wanted::PLACE, other);
      if (!found) continue;
      ++hidden;
      if (passes)
        group.hide(id, OPAQUE | LAMP);
      else
        changeable.at(&groupOf(*found))->hide(found->geometry, LAMP);
    }
    if (!instance && passes && hidden == points && points >= OF_OTHERS && !g.media.isBoundary() &&
        !shapesMove)
      unseen.insert(g.shape);
  });
  return unseen;
}

void EmbreeScene::complete(const PositionHit& position, const Ray& ray, Wanted wanted, Hit& hit) const {
  const SceneGeometry& g = computeHit(position, ray.time, wanted, hit);
  if (!g.hiddenBy) return;
  // Without the first rule, a ray that is refracted into the floor under a block of glass would start below
  // the floor. Without the second, a lamp in the plane of a ceiling would be dark where the ceiling is hit
  // first.
  const unsigned mask = isOpaque(hit.material) ? g.hiddenBy & LAMP : g.hiddenBy;
  if (Hit other; mask && inSamePlace(ray, hit, mask, wanted, other)) hit = other;
}

const SceneGeometry& EmbreeScene::computeHit(const PositionHit& position, float time, Wanted wanted,
                                             Hit& hit) const {
  const GeometryGroup* group = groups.front().get();
  const GeometryGroup::Instance* instance = nullptr;
  if (position.instance != RTC_INVALID_GEOMETRY_ID) {
    instance = &group->instance(position.instance);
    group = instance->group;
  }
  const SceneGeometry& g = group->geometry(position.geometry);
  if (wanted == Wanted::PLACE && !instance)
    makeAt(hit.point, [&] { return g.shape->placeAt(position.primitive, position.parameters); });
  else
    makeAt(hit.point, [&] { return g.shape->surfaceAt(position.primitive, position.parameters); });
  if (instance) transformToScene(*instance, time, hit.point);
  hit.point.time = time;
  if (wanted == Wanted::SURFACE && g.shape->alpha)
    hit.point.alpha = std::clamp(g.shape->alpha->at(hit.point).r, FLT_MIN, 1.0f);
  hit.t = position.t;
  hit.primitive = position.primitive;
  hit.material = g.compound ? g.shape->materialAt(position.parameters) : g.material;
  hit.areaLight = g.light;
  hit.lightIndex = g.lightIndex;
  hit.shape = g.shapeIndex;
  hit.media = g.media;
  hit.object = instance ? instance->object : g.object;
  return g;
}

bool EmbreeScene::find(const Ray& ray, unsigned mask, Wanted wanted, Hit& hit) const {
  const PositionHit position = nearest(ray, mask);
  if (position.geometry == RTC_INVALID_GEOMETRY_ID) return false;
  complete(position, ray, wanted, hit);
  return true;
}

bool EmbreeScene::intersect(const Ray& ray, Hit& hit) const { return find(ray, SEEN, Wanted::SURFACE, hit); }

bool EmbreeScene::intersectPosition(const Ray& ray, Hit& hit) const {
  return find(ray, SEEN, Wanted::PLACE, hit);
}

bool EmbreeScene::probePosition(const Ray& ray, Hit& hit) const {
  return find(ray, SEEN | PROBES, Wanted::PLACE, hit);
}

void EmbreeScene::nearestOfEach(std::span<const Ray> rays, Coherence coherence,
                                PositionHit* positions) const {
  size_t done = 0;
  if (packets && rays.size() > MAX_SINGLE_RAYS) {
    RTCRayHit8 packet[GROUP / embree::PACKET];
    // All packets are filled before the first is traced: a wide load soon after narrow stores to the same
    // memory is slow.
    for (size_t i = 0; i < rays.size(); ++i) {
      RTCRayHit8& p = packet[i / embree::PACKET];
      const size_t lane = i % embree::PACKET;
      setRay(p.ray, lane, rays[i], SEEN);
      p.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      p.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
    for (RTCRayHit8* p = packet; done < rays.size(); ++p) {
      checkInterrupted();
      const embree::Lanes lanes(rays.size() - done);
      embree::intersect(groups.front()->scene(), lanes, *p, coherence == Coherence::COHERENT);
      for (size_t i = 0; i < embree::PACKET && done < rays.size(); ++i)
        positions[done++] = {p->ray.tfar[i],
                             {{p->hit.u[i], p->hit.v[i]}, {p->hit.Ng_x[i], p->hit.Ng_y[i], p->hit.Ng_z[i]}},
                             p->hit.geomID[i],
                             p->hit.primID[i],
                             p->hit.instID[0][i]};
    }
  }
  for (; done < rays.size(); ++done) makeAt(positions[done], [&] { return nearest(rays[done], SEEN); });
}

void EmbreeScene::intersectBatch(std::span<const Ray> rays, Coherence coherence, std::span<Hit> hits) const {
  PositionHit positions[GROUP];
  const TriangleMesh* meshes[GROUP];
  while (!rays.empty()) {
    const size_t count = std::min(GROUP, rays.size());
    nearestOfEach(rays.first(count), coherence, positions);
    for (size_t i = 0; i < count; ++i) {
      meshes[i] = meshOf(positions[i]);
      if (meshes[i]) meshes[i]->prefetchTriangle(positions[i].primitive);
    }
    for (size_t i = 0; i < count; ++i)
      if (meshes[i]) meshes[i]->prefetchVertices(positions[i].primitive);
    for (size_t i = 0; i < count; ++i)
      if (positions[i].geometry != RTC_INVALID_GEOMETRY_ID)
        complete(positions[i], rays[i], Wanted::SURFACE, hits[i]);
      else
        hits[i].t = INFINITE;
    rays = rays.subspan(count);
    hits = hits.subspan(count);
  }
}

bool EmbreeScene::occluded(const Ray& ray) const {
  checkInterrupted();
  RTCRay r;
  setRay(r, ray, CASTS_SHADOW);
  embree::occluded(groups.front()->scene(), r);
  return r.tfar < 0;
}

void EmbreeScene::occludedBatch(std::span<const Ray> rays, std::span<uint8_t> blocked) const {
  size_t done = 0;
  while (packets && done + MAX_SINGLE_RAYS < rays.size()) {
    RTCRay8 packet[GROUP / embree::PACKET];
    const size_t end = std::min(rays.size(), done + GROUP);
    for (size_t i = done; i < end; ++i)
      setRay(packet[(i - done) / embree::PACKET], (i - done) % embree::PACKET, rays[i], CASTS_SHADOW);
    for (RTCRay8* p = packet; done < end; ++p) {
      checkInterrupted();
      embree::occluded(groups.front()->scene(), embree::Lanes(end - done), *p);
      for (size_t i = 0; i < embree::PACKET && done < end; ++i) blocked[done++] = p->tfar[i] < 0;
    }
  }
  for (; done < rays.size(); ++done) blocked[done] = occluded(rays[done]);
}

} // namespace recurse
