/** @file
 * Rays against the scene, and the call-backs by which Embree asks shapes.
 */
#include "model/embreeScene.h"

#include <bit>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include "recurse/core/inPlace.h"
#include "recurse/core/sampler.h"
#include "recurse/model/curveShape.h"
#include "recurse/model/triangleMesh.h"

namespace recurse {

namespace {

/** Surfaces that emit and do not scatter are met by rays but cast no shadow. */
constexpr unsigned SEEN = 1, CASTS_SHADOW = 2;

/** So many rays are traced faster one by one than as a packet. */
constexpr size_t MAX_SINGLE_RAYS = 2;
/** So many rays are prepared together. */
constexpr size_t GROUP = 64;

void boundsCallback(const RTCBoundsFunctionArguments* a) {
  const Bounds3f b = static_cast<const SceneGeometry*>(a->geometryUserPtr)->shape->bounds(a->primID);
  *a->bounds_o = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, 0};
}

void transformToScene(const GeometryGroup::Instance& instance, float time, SurfacePoint& p);

HitParameters parametersOf(const RTCHit& h) { return {{h.u, h.v}, {h.Ng_x, h.Ng_y, h.Ng_z}}; }

void setParameters(RTCHitN* hits, unsigned count, unsigned i, const HitParameters& p) {
  RTCHitN_u(hits, count, i) = p.uv.x;
  RTCHitN_v(hits, count, i) = p.uv.y;
  RTCHitN_Ng_x(hits, count, i) = p.normal.x;
  RTCHitN_Ng_y(hits, count, i) = p.normal.y;
  RTCHitN_Ng_z(hits, count, i) = p.normal.z;
}

/**
 * Whether a ray passes through a surface with alpha, by a number that is hashed from the ray and the place:
 * the same whoever asks, and independent for each surface along the ray.
 */
bool passes(const SceneGeometry& g, unsigned primitive, const HitParameters& parameters, const Vec3f& origin,
            const Vec3f& direction, float time, unsigned instance) {
  SurfacePoint point = g.shape->surfaceAt(primitive, parameters);
  if (instance != RTC_INVALID_GEOMETRY_ID) transformToScene(g.top->instance(instance), time, point);
  point.time = time;
  const float alpha = g.shape->alpha->at(point).r;
  if (alpha >= 1) return false;
  if (alpha <= 0) return true;
  uint64_t h = hashCombine(primitive, instance);
  for (const Vec3f& v : {origin, direction, parameters.point()})
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
    if (passes(g, hit.primID, parametersOf(hit), {ray.org_x, ray.org_y, ray.org_z},
               {ray.dir_x, ray.dir_y, ray.dir_z}, ray.time, hit.instID[0]))
      a->valid[i] = 0;
  }
}

/** Embree halves flat curves into so many straight pieces. */
constexpr float FLAT_CURVE_PIECES = 16;

/** For curves: Embree's hit does not tell how the curve is turned to the ray, nor from which side it is met.
 */
void curveFilterCallback(const RTCFilterFunctionNArguments* a) {
  const auto& g = *static_cast<const SceneGeometry*>(a->geometryUserPtr);
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const RTCRay ray = rtcGetRayFromRayN(a->ray, a->N, i);
    const RTCHit hit = rtcGetHitFromHitN(a->hit, a->N, i);
    const Vec3f origin(ray.org_x, ray.org_y, ray.org_z), direction(ray.dir_x, ray.dir_y, ray.dir_z);
    const std::optional<HitParameters> p =
        g.curve->parametersOf(hit.primID, hit.u, origin, direction, ray.tfar);
    if (!p || (g.curve->alpha && passes(g, hit.primID, *p, origin, direction, ray.time, hit.instID[0])))
      a->valid[i] = 0;
    else
      setParameters(a->hit, a->N, i, *p);
  }
}

std::optional<PrimitiveHit> intersectPosition(const SceneGeometry& g, unsigned primitive, const RTCRay& ray,
                                              unsigned instance) {
  const Vec3f origin(ray.org_x, ray.org_y, ray.org_z);
  Vec3f direction(ray.dir_x, ray.dir_y, ray.dir_z);
  // Inside a scaled instance the direction is not of unit length; shapes want it so. A unit vector is left as
  // it is: dividing by a length that is rounded would turn the ray by a few units in the last place.
  float length = glm::length(direction);
  if (std::abs(length - 1) <= 4 * std::numeric_limits<float>::epsilon())
    length = 1;
  else
    direction /= length;
  std::optional<PrimitiveHit> hit =
      g.shape->intersect(primitive, origin, direction, ray.tnear * length, ray.tfar * length);
  if (g.shape->alpha)
    while (hit && passes(g, primitive, hit->parameters, origin, direction, ray.time, instance))
      hit = g.shape->intersect(primitive, origin, direction, hit->t, ray.tfar * length);
  if (hit) {
    hit->t /= length;
    if (!(hit->t < ray.tfar)) hit.reset();
  }
  return hit;
}

void intersectCallback(const RTCIntersectFunctionNArguments* a) {
  const auto& g = *static_cast<const SceneGeometry*>(a->geometryUserPtr);
  RTCRayN* rays = RTCRayHitN_RayN(a->rayhit, a->N);
  RTCHitN* hits = RTCRayHitN_HitN(a->rayhit, a->N);
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const std::optional<PrimitiveHit> hit =
        intersectPosition(g, a->primID, rtcGetRayFromRayN(rays, a->N, i), a->context->instID[0]);
    if (!hit) continue;
    RTCRayN_tfar(rays, a->N, i) = hit->t;
    setParameters(hits, a->N, i, hit->parameters);
    RTCHitN_geomID(hits, a->N, i) = a->geomID;
    RTCHitN_primID(hits, a->N, i) = a->primID;
    RTCHitN_instID(hits, a->N, i, 0) = a->context->instID[0];
  }
}

void occludedCallback(const RTCOccludedFunctionNArguments* a) {
  const auto& g = *static_cast<const SceneGeometry*>(a->geometryUserPtr);
  for (unsigned i = 0; i < a->N; ++i)
    if (a->valid[i] &&
        intersectPosition(g, a->primID, rtcGetRayFromRayN(a->ray, a->N, i), a->context->instID[0]))
      RTCRayN_tfar(a->ray, a->N, i) = -INFINITE;
}

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

/** Also for the ray part of an RTCRayHit8. */
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

/** A point of an object definition, seen from the scene. */
void transformToScene(const GeometryGroup::Instance& instance, float time, SurfacePoint& p) {
  if (instance.sceneFromGroup.moves()) return placeByMotion(instance.sceneFromGroup.at(time), p);
  const Mat4d& m = instance.sceneFromGroup.first();
  const Vec3d local = p.position;
  const Vec3d position = transformPoint(m, local);
  const Mat3d linear(m);
  const Mat3d magnitude(glm::abs(linear[0]), glm::abs(linear[1]), glm::abs(linear[2]));
  // Embree transforms the ray in float, so that the hit is off by the rounding of the ray's coordinates too.
  const Vec3d error = magnitude * Vec3d(p.error) +
                      double(roundingBound(6)) * (magnitude * glm::abs(local) + glm::abs(Vec3d(m[3])));
  p.position = Vec3f(position);
  p.error = Vec3f(error);
  transformDirections(linear, instance.normalFromGroup, p);
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

GeometryGroup::GeometryGroup(std::shared_ptr<const EmbreeDevice> device, bool compact)
    : device(std::move(device)), tree(rtcNewScene(this->device->get())) {
  const int flags = RTC_SCENE_FLAG_ROBUST | (compact ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE);
  rtcSetSceneFlags(tree, static_cast<RTCSceneFlags>(flags));
}

GeometryGroup::~GeometryGroup() { rtcReleaseScene(tree); }

RTCGeometry GeometryGroup::newTriangles(const TriangleMesh& mesh, SceneGeometry& stored) const {
  RTCGeometry g = rtcNewGeometry(device->get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto& positions = mesh.positions();
  const auto& indices = mesh.indices();
  // Embree reads 16 bytes a vertex, so the last one must not end at the end of our array: let it own a copy.
  void* vertices = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                                           positions.size());
  std::copy(positions.begin(), positions.end(), static_cast<Vec3f*>(vertices));
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices.data(), 0,
                             sizeof(glm::uvec3), indices.size());
  if (mesh.alpha) {
    rtcSetGeometryUserData(g, &stored);
    rtcSetGeometryIntersectFilterFunction(g, filterCallback);
    rtcSetGeometryOccludedFilterFunction(g, filterCallback);
  }
  return g;
}

RTCGeometry GeometryGroup::newCurve(const CurveShape& curve, SceneGeometry& stored) const {
  RTCGeometry g = rtcNewGeometry(device->get(), RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE);
  const auto copy = [&](RTCBufferType type, RTCFormat format, const auto& values) {
    using Value = typename std::decay_t<decltype(values)>::value_type;
    std::copy(values.begin(), values.end(),
              static_cast<Value*>(rtcSetNewGeometryBuffer(g, type, 0, format, sizeof(Value), values.size())));
  };
  copy(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, curve.controls());
  std::vector<uint32_t> first(curve.primitiveCount());
  for (uint32_t i = 0; i < first.size(); ++i) first[i] = 4 * i;
  copy(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, first);
  rtcSetGeometryTessellationRate(g, FLAT_CURVE_PIECES);
  rtcSetGeometryUserData(g, &stored);
  rtcSetGeometryIntersectFilterFunction(g, curveFilterCallback);
  if (curve.alpha || curve.kind() == CurveShape::Kind::RIBBON)
    rtcSetGeometryOccludedFilterFunction(g, curveFilterCallback);
  return g;
}

RTCGeometry GeometryGroup::newUserGeometry(SceneGeometry& stored) const {
  RTCGeometry g = rtcNewGeometry(device->get(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(g, stored.shape->primitiveCount());
  rtcSetGeometryUserData(g, &stored);
  rtcSetGeometryBoundsFunction(
      g, [](const RTCBoundsFunctionArguments* a) { boundsCallback(a); }, nullptr);
  rtcSetGeometryIntersectFunction(g, intersectCallback);
  rtcSetGeometryOccludedFunction(g, occludedCallback);
  return g;
}

bool scatters(const Shape& shape, const Material* material) {
  const auto isSeen = [](const Material* m) { return m && m->lobes() != NO_LOBE; };
  const std::vector<const Material*> components = shape.componentMaterials();
  return components.empty() ? isSeen(material) : std::any_of(components.begin(), components.end(), isSeen);
}

void GeometryGroup::update(size_t id, const SceneGeometry& geometry) {
  SceneGeometry& stored = geometries[id];
  stored = geometry;
  stored.mesh = stored.shape->triangleMesh();
  stored.curve = dynamic_cast<const CurveShape*>(stored.shape);
  stored.compound = !stored.shape->componentMaterials().empty();
}

void GeometryGroup::add(const SceneGeometry& added) {
  geometries.emplace_back();
  update(geometries.size() - 1, added);
  SceneGeometry& stored = geometries.back();
  RTCGeometry g = stored.mesh    ? newTriangles(*stored.mesh, stored)
                  : stored.curve ? newCurve(*stored.curve, stored)
                                 : newUserGeometry(stored);
  rtcSetGeometryMask(g, scatters(*stored.shape, stored.material) ? SEEN | CASTS_SHADOW : SEEN);
  rtcCommitGeometry(g);
  rtcAttachGeometryByID(tree, g, static_cast<unsigned>(geometries.size() - 1));
  rtcReleaseGeometry(g);
}

void GeometryGroup::addInstance(const GeometryGroup& group, const MatrixTrack& sceneFromGroup,
                                uint32_t object) {
  RTCGeometry g = rtcNewGeometry(device->get(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(g, group.tree);
  const auto steps = static_cast<unsigned>(sceneFromGroup.steps().size());
  rtcSetGeometryTimeStepCount(g, steps);
  for (unsigned i = 0; i < steps; ++i) {
    const glm::mat4 transform(sceneFromGroup.steps()[i]);
    rtcSetGeometryTransform(g, i, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &transform[0][0]);
  }
  rtcSetGeometryMask(g, SEEN | CASTS_SHADOW);
  rtcCommitGeometry(g);
  rtcAttachGeometryByID(tree, g, static_cast<unsigned>(geometries.size() + instances.size()));
  rtcReleaseGeometry(g);
  instances.push_back(
      {&group, sceneFromGroup, glm::transpose(glm::inverse(Mat3d(sceneFromGroup.first()))), object});
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

EmbreeScene::PositionHit EmbreeScene::nearest(const Ray& ray) const {
  RTCRayHit rayHit;
  setRay(rayHit.ray, ray, SEEN);
  rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(groups.front()->scene(), rayHit);
  const RTCHit& h = rayHit.hit;
  return {rayHit.ray.tfar, parametersOf(h), h.geomID, h.primID, h.instID[0]};
}

const TriangleMesh* EmbreeScene::meshOf(const PositionHit& met) const {
  if (met.geometry == RTC_INVALID_GEOMETRY_ID) return nullptr;
  const GeometryGroup* group = groups.front().get();
  if (met.instance != RTC_INVALID_GEOMETRY_ID) group = group->instance(met.instance).group;
  return group->geometry(met.geometry).mesh;
}

void EmbreeScene::complete(const PositionHit& met, float time, Wanted wanted, Hit& hit) const {
  const GeometryGroup* group = groups.front().get();
  const GeometryGroup::Instance* instance = nullptr;
  if (met.instance != RTC_INVALID_GEOMETRY_ID) {
    instance = &group->instance(met.instance);
    group = instance->group;
  }
  const SceneGeometry& g = group->geometry(met.geometry);
  if (wanted == Wanted::PLACE && !instance)
    makeAt(hit.point, [&] { return g.shape->placeAt(met.primitive, met.parameters); });
  else
    makeAt(hit.point, [&] { return g.shape->surfaceAt(met.primitive, met.parameters); });
  if (instance) transformToScene(*instance, time, hit.point);
  hit.point.time = time;
  hit.t = met.t;
  hit.primitive = met.primitive;
  hit.material = g.compound ? g.shape->materialAt(met.parameters) : g.material;
  hit.areaLight = g.light;
  hit.lightIndex = g.lightIndex;
  hit.shape = g.shapeIndex;
  hit.media = g.media;
  hit.object = instance ? instance->object : g.object;
}

bool EmbreeScene::intersect(const Ray& ray, Hit& hit) const {
  const PositionHit met = nearest(ray);
  if (met.geometry == RTC_INVALID_GEOMETRY_ID) return false;
  complete(met, ray.time, Wanted::SURFACE, hit);
  return true;
}

bool EmbreeScene::intersectPosition(const Ray& ray, Hit& hit) const {
  const PositionHit met = nearest(ray);
  if (met.geometry == RTC_INVALID_GEOMETRY_ID) return false;
  complete(met, ray.time, Wanted::PLACE, hit);
  return true;
}

void EmbreeScene::nearestOfEach(std::span<const Ray> rays, Coherence coherence, PositionHit* met) const {
  size_t done = 0;
  if (packets && rays.size() > MAX_SINGLE_RAYS) {
    RTCRayHit8 packet[GROUP / embree::PACKET];
    // All packets are filled before the first is traced: what was just written singly is slow to read at
    // once.
    for (size_t i = 0; i < rays.size(); ++i) {
      RTCRayHit8& p = packet[i / embree::PACKET];
      const size_t lane = i % embree::PACKET;
      setRay(p.ray, lane, rays[i], SEEN);
      p.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      p.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
    for (RTCRayHit8* p = packet; done < rays.size(); ++p) {
      const embree::Lanes lanes(rays.size() - done);
      embree::intersect(groups.front()->scene(), lanes, *p, coherence == Coherence::COHERENT);
      for (size_t i = 0; i < embree::PACKET && done < rays.size(); ++i)
        met[done++] = {p->ray.tfar[i],
                       {{p->hit.u[i], p->hit.v[i]}, {p->hit.Ng_x[i], p->hit.Ng_y[i], p->hit.Ng_z[i]}},
                       p->hit.geomID[i],
                       p->hit.primID[i],
                       p->hit.instID[0][i]};
    }
  }
  for (; done < rays.size(); ++done) makeAt(met[done], [&] { return nearest(rays[done]); });
}

void EmbreeScene::intersectBatch(std::span<const Ray> rays, Coherence coherence, std::span<Hit> hits) const {
  PositionHit met[GROUP];
  const TriangleMesh* meshes[GROUP];
  while (!rays.empty()) {
    const size_t count = std::min(GROUP, rays.size());
    nearestOfEach(rays.first(count), coherence, met);
    for (size_t i = 0; i < count; ++i) {
      meshes[i] = meshOf(met[i]);
      if (meshes[i]) meshes[i]->prefetchTriangle(met[i].primitive);
    }
    for (size_t i = 0; i < count; ++i)
      if (meshes[i]) meshes[i]->prefetchVertices(met[i].primitive);
    for (size_t i = 0; i < count; ++i)
      if (met[i].geometry != RTC_INVALID_GEOMETRY_ID)
        complete(met[i], rays[i].time, Wanted::SURFACE, hits[i]);
      else
        hits[i].t = INFINITE;
    rays = rays.subspan(count);
    hits = hits.subspan(count);
  }
}

bool EmbreeScene::occluded(const Ray& ray) const {
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
      embree::occluded(groups.front()->scene(), embree::Lanes(end - done), *p);
      for (size_t i = 0; i < embree::PACKET && done < end; ++i) blocked[done++] = p->tfar[i] < 0;
    }
  }
  for (; done < rays.size(); ++done) blocked[done] = occluded(rays[done]);
}

} // namespace recurse
