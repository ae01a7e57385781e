/** @file
 * Rays against the scene, and the call-backs by which Embree asks shapes.
 */
#include "model/embreeScene.h"

#include <bit>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include "recurse/core/sampler.h"
#include "recurse/model/triangleMesh.h"

namespace recurse {

namespace {

/** Surfaces that emit and do not scatter are met by rays but cast no shadow. */
constexpr unsigned SEEN = 1, CASTS_SHADOW = 2;

void boundsCallback(const RTCBoundsFunctionArguments* a) {
  const Bounds3f b = static_cast<const SceneGeometry*>(a->geometryUserPtr)->shape->bounds(a->primID);
  *a->bounds_o = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, 0};
}

void transformToScene(const GeometryGroup::Instance& instance, SurfacePoint& p);

/**
 * Whether a ray passes through a surface with alpha, by a number that is hashed from the ray and the place:
 * the same whoever asks, and independent for each surface along the ray.
 */
bool passes(const SceneGeometry& g, unsigned primitive, const Vec2f& parameters, const Vec3f& origin,
            const Vec3f& direction, unsigned instance) {
  SurfacePoint point = g.shape->surfaceAt(primitive, parameters);
  if (instance != RTC_INVALID_GEOMETRY_ID) transformToScene(g.top->instance(instance), point);
  const float alpha = g.shape->alpha->at(point).r;
  if (alpha >= 1) return false;
  if (alpha <= 0) return true;
  uint64_t h = hashCombine(primitive, instance);
  for (const Vec3f& v : {origin, direction, Vec3f(parameters, 0)})
    for (int i = 0; i < 3; ++i) h = hashCombine(h, std::bit_cast<uint32_t>(v[i]));
  return unitFloat(static_cast<uint32_t>(h >> 32)) >= alpha;
}

/** For triangles, which Embree intersects: turns down the meetings that alpha does not make. */
void filterCallback(const RTCFilterFunctionNArguments* a) {
  const auto& g = *static_cast<const SceneGeometry*>(a->geometryUserPtr);
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const RTCRay ray = rtcGetRayFromRayN(a->ray, a->N, i);
    const RTCHit hit = rtcGetHitFromHitN(a->hit, a->N, i);
    if (passes(g, hit.primID, {hit.u, hit.v}, {ray.org_x, ray.org_y, ray.org_z},
               {ray.dir_x, ray.dir_y, ray.dir_z}, hit.instID[0]))
      a->valid[i] = 0;
  }
}

std::optional<PrimitiveHit> meet(const SceneGeometry& g, unsigned primitive, const RTCRay& ray,
                                 unsigned instance) {
  const Vec3f origin(ray.org_x, ray.org_y, ray.org_z);
  Vec3f direction(ray.dir_x, ray.dir_y, ray.dir_z);
  // Inside a scaled instance the direction is not of unit length; shapes want it so.
  const float length = glm::length(direction);
  direction /= length;
  std::optional<PrimitiveHit> hit =
      g.shape->intersect(primitive, origin, direction, ray.tnear * length, ray.tfar * length);
  if (g.shape->alpha)
    while (hit && passes(g, primitive, hit->parameters, origin, direction, instance))
      hit = g.shape->intersect(primitive, origin, direction, hit->t, ray.tfar * length);
  if (hit) {
    hit->t /= length;
    if (!(hit->t < ray.tfar)) hit.reset();
  }
  return hit;
}

void intersectCallback(const RTCIntersectFunctionNArguments* a) {
  if (!a->valid[0]) return;
  auto* rayHit = reinterpret_cast<RTCRayHit*>(a->rayhit);
  const auto& g = *static_cast<const SceneGeometry*>(a->geometryUserPtr);
  const std::optional<PrimitiveHit> hit = meet(g, a->primID, rayHit->ray, a->context->instID[0]);
  if (!hit) return;
  rayHit->ray.tfar = hit->t;
  rayHit->hit.u = hit->parameters.x;
  rayHit->hit.v = hit->parameters.y;
  rayHit->hit.geomID = a->geomID;
  rayHit->hit.primID = a->primID;
  rayHit->hit.instID[0] = a->context->instID[0];
}

void occludedCallback(const RTCOccludedFunctionNArguments* a) {
  if (!a->valid[0]) return;
  auto* ray = reinterpret_cast<RTCRay*>(a->ray);
  if (meet(*static_cast<const SceneGeometry*>(a->geometryUserPtr), a->primID, *ray, a->context->instID[0]))
    ray->tfar = -INFINITE;
}

void setRay(RTCRay& r, const Ray& ray, unsigned mask) {
  r.org_x = ray.origin.x;
  r.org_y = ray.origin.y;
  r.org_z = ray.origin.z;
  r.tnear = 0;
  r.dir_x = ray.direction.x;
  r.dir_y = ray.direction.y;
  r.dir_z = ray.direction.z;
  r.time = 0;
  r.tfar = ray.tMax;
  r.mask = mask;
  r.id = 0;
  r.flags = 0;
}

/** A point of an object definition, seen from the scene. */
void transformToScene(const GeometryGroup::Instance& instance, SurfacePoint& p) {
  const Mat4d& m = instance.sceneFromGroup;
  const Vec3d local = p.position;
  const Vec3d position = transformPoint(m, local);
  const Mat3d linear(m);
  const Mat3d magnitude(glm::abs(linear[0]), glm::abs(linear[1]), glm::abs(linear[2]));
  // Embree transforms the ray in float, so that the hit is off by the rounding of the ray's coordinates too.
  const Vec3d error = magnitude * Vec3d(p.error) +
                      double(roundingBound(6)) * (magnitude * glm::abs(local) + glm::abs(Vec3d(m[3])));
  p.position = Vec3f(position);
  p.error = Vec3f(error);
  p.geometricNormal = Vec3f(glm::normalize(instance.normalFromGroup * Vec3d(p.geometricNormal)));
  p.shadingNormal = Vec3f(glm::normalize(instance.normalFromGroup * Vec3d(p.shadingNormal)));
  p.dpdu = Vec3f(linear * Vec3d(p.dpdu));
  p.dpdv = Vec3f(linear * Vec3d(p.dpdv));
}

RTCDevice newDevice() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (!device)
    throw Error("Embree does not start (error " + std::to_string(rtcGetDeviceError(nullptr)) + ")");
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

GeometryGroup::GeometryGroup(RTCDevice device) : device(device), tree(rtcNewScene(device)) {
  rtcSetSceneFlags(tree, RTC_SCENE_FLAG_ROBUST);
}

GeometryGroup::~GeometryGroup() { rtcReleaseScene(tree); }

void GeometryGroup::add(const SceneGeometry& added) {
  geometries.push_back(added);
  SceneGeometry& stored = geometries.back();
  const TriangleMesh* mesh = stored.shape->triangleMesh();
  RTCGeometry g = rtcNewGeometry(device, mesh ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_USER);
  if (mesh) {
    const auto& positions = mesh->positions();
    const auto& indices = mesh->indices();
    // Embree reads 16 bytes a vertex, so the last one must not end at the end of our array: let it own a
    // copy.
    void* vertices = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                                             positions.size());
    std::copy(positions.begin(), positions.end(), static_cast<Vec3f*>(vertices));
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices.data(), 0,
                               sizeof(glm::uvec3), indices.size());
    if (mesh->alpha) {
      rtcSetGeometryUserData(g, &stored);
      rtcSetGeometryIntersectFilterFunction(g, filterCallback);
      rtcSetGeometryOccludedFilterFunction(g, filterCallback);
    }
  } else {
    rtcSetGeometryUserPrimitiveCount(g, stored.shape->primitiveCount());
    rtcSetGeometryUserData(g, &stored);
    rtcSetGeometryBoundsFunction(
        g, [](const RTCBoundsFunctionArguments* a) { boundsCallback(a); }, nullptr);
    rtcSetGeometryIntersectFunction(g, intersectCallback);
    rtcSetGeometryOccludedFunction(g, occludedCallback);
  }
  const bool scatters = stored.material && stored.material->lobes() != NO_LOBE;
  rtcSetGeometryMask(g, scatters ? SEEN | CASTS_SHADOW : SEEN);
  rtcCommitGeometry(g);
  rtcAttachGeometryByID(tree, g, static_cast<unsigned>(geometries.size() - 1));
  rtcReleaseGeometry(g);
}

void GeometryGroup::addInstance(const GeometryGroup& group, const Mat4d& sceneFromGroup) {
  RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(g, group.tree);
  const glm::mat4 transform(sceneFromGroup);
  rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &transform[0][0]);
  rtcSetGeometryMask(g, SEEN | CASTS_SHADOW);
  rtcCommitGeometry(g);
  rtcAttachGeometryByID(tree, g, static_cast<unsigned>(geometries.size() + instances.size()));
  rtcReleaseGeometry(g);
  instances.push_back({&group, sceneFromGroup, glm::transpose(glm::inverse(Mat3d(sceneFromGroup)))});
}

EmbreeScene::EmbreeScene() : device(newDevice()) {
  rtcSetDeviceMemoryMonitorFunction(
      device,
      [](void* scene, ssize_t added, bool) {
        static_cast<EmbreeScene*>(scene)->bytes += added;
        return true;
      },
      this);
}

EmbreeScene::~EmbreeScene() {
  while (!groups.empty()) groups.pop_back();
  rtcReleaseDevice(device);
}

bool EmbreeScene::intersect(const Ray& ray, Hit& hit) const {
  RTCRayHit rayHit;
  setRay(rayHit.ray, ray, SEEN);
  rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  const GeometryGroup* group = groups.front().get();
  embree::intersect(group->scene(), rayHit);
  const RTCHit& h = rayHit.hit;
  if (h.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  const GeometryGroup::Instance* instance = nullptr;
  if (h.instID[0] != RTC_INVALID_GEOMETRY_ID) {
    instance = &group->instance(h.instID[0]);
    group = instance->group;
  }
  const SceneGeometry& g = group->geometry(h.geomID);
  hit.point = g.shape->surfaceAt(h.primID, {h.u, h.v});
  if (instance) transformToScene(*instance, hit.point);
  hit.t = rayHit.ray.tfar;
  hit.primitive = h.primID;
  hit.material = g.material;
  hit.areaLight = g.light;
  hit.lightIndex = g.lightIndex;
  return true;
}

bool EmbreeScene::occluded(const Ray& ray) const {
  RTCRay r;
  setRay(r, ray, CASTS_SHADOW);
  embree::occluded(groups.front()->scene(), r);
  return r.tfar < 0;
}

} // namespace recurse
