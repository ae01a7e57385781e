/** @file
 * Embree geometries of shapes, and the callbacks that intersect and filter.
 */
#include <bit>

#include "model/embree/embreeScene.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/surroundingMedium.h"
#include "recurse/model/shape/curveShape.h"

namespace recurse {

namespace {

void boundsCallback(const RTCBoundsFunctionArguments* a) {
  const Bounds3f b = static_cast<const SceneGeometry*>(a->geometryUserPtr)->shape->bounds(a->primID);
  *a->bounds_o = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, 0};
}

void setParameters(RTCHitN* hits, unsigned count, unsigned i, const HitParameters& p) {
  RTCHitN_u(hits, count, i) = p.uv.x;
  RTCHitN_v(hits, count, i) = p.uv.y;
  RTCHitN_Ng_x(hits, count, i) = p.normal.x;
  RTCHitN_Ng_y(hits, count, i) = p.normal.y;
  RTCHitN_Ng_z(hits, count, i) = p.normal.z;
}

/**
 * True where a ray passes through a surface with alpha. The random number is a hash of the ray and the hit
 * point: the same for every query of this ray, and independent for each surface along it.
 */
bool passes(const SceneGeometry& g, unsigned primitive, const HitParameters& parameters, const Vec3f& origin,
            const Vec3f& direction, const RTCRay& ray, unsigned instance) {
  SurfacePoint point = g.shape->surfaceAt(primitive, parameters);
  if (instance != RTC_INVALID_GEOMETRY_ID) transformToScene(g.top->instance(instance), ray.time, point);
  point.time = ray.time;
  const float alpha = g.shape->alpha->at(point).r;
  if (alpha >= 1) return false;
  if (alpha <= 0) return true;
  if (ray.mask & PROBES) return false;
  uint64_t h = hashCombine(primitive, instance);
  for (const Vec3f& v : {origin, direction, parameters.point()})
    for (int i = 0; i < 3; ++i) h = hashCombine(h, std::bit_cast<uint32_t>(v[i]));
  return unitFloat(static_cast<uint32_t>(h >> 32)) >= alpha;
}

/** Rejects the hits that alpha makes transparent, for triangles, which Embree intersects. */
void filterCallback(const RTCFilterFunctionNArguments* a) {
  const auto& g = *static_cast<const SceneGeometry*>(a->geometryUserPtr);
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const RTCRay ray = rtcGetRayFromRayN(a->ray, a->N, i);
    const RTCHit hit = rtcGetHitFromHitN(a->hit, a->N, i);
    if (passes(g, hit.primID, parametersOf(hit), {ray.org_x, ray.org_y, ray.org_z},
               {ray.dir_x, ray.dir_y, ray.dir_z}, ray, hit.instID[0]))
      a->valid[i] = 0;
  }
}

/** Straight segments into which Embree divides a flat curve. */
constexpr float FLAT_CURVE_PIECES = 16;

/** Completes hits of curves. Embree's hit has neither the curve's orientation to the ray nor the side that
 * the ray hits. */
void curveFilterCallback(const RTCFilterFunctionNArguments* a) {
  const auto& g = *static_cast<const SceneGeometry*>(a->geometryUserPtr);
  for (unsigned i = 0; i < a->N; ++i) {
    if (!a->valid[i]) continue;
    const RTCRay ray = rtcGetRayFromRayN(a->ray, a->N, i);
    const RTCHit hit = rtcGetHitFromHitN(a->hit, a->N, i);
    const Vec3f origin(ray.org_x, ray.org_y, ray.org_z), direction(ray.dir_x, ray.dir_y, ray.dir_z);
    const std::optional<HitParameters> p =
        g.curve->parametersOf(hit.primID, hit.u, origin, direction, ray.tfar);
    if (!p || (g.curve->alpha && passes(g, hit.primID, *p, origin, direction, ray, hit.instID[0])))
      a->valid[i] = 0;
    else
      setParameters(a->hit, a->N, i, *p);
  }
}

std::optional<PrimitiveHit> intersectPosition(const SceneGeometry& g, unsigned primitive, const RTCRay& ray,
                                              unsigned instance) {
  const Vec3f origin(ray.org_x, ray.org_y, ray.org_z);
  Vec3f direction(ray.dir_x, ray.dir_y, ray.dir_z);
  // Inside a scaled instance the direction is not of unit length, which shapes expect. A unit vector is left
  // unchanged: dividing by a rounded length would turn the ray by a few units in the last place.
  float length = glm::length(direction);
  if (std::abs(length - 1) <= 4 * std::numeric_limits<float>::epsilon())
    length = 1;
  else
    direction /= length;
  std::optional<PrimitiveHit> hit =
      g.shape->intersect(primitive, origin, direction, ray.tnear * length, ray.tfar * length);
  if (g.shape->alpha)
    while (hit && passes(g, primitive, hit->parameters, origin, direction, ray, instance))
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
  // Embree reads 16 bytes for a vertex, beyond the end of the last one in our array: it owns a padded copy.
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

unsigned maskOf(const Shape& shape, const Material* material, bool emits) {
  const auto scatters = [](const Material* m) { return m && m->lobes() != NO_LOBE; };
  const std::vector<const Material*> components = shape.componentMaterials();
  if (components.empty())
    return SEEN | (scatters(material) ? CASTS_SHADOW : 0u) |
           (isOpaque(material) ? (emits ? LAMP : OPAQUE) : 0u);
  return std::any_of(components.begin(), components.end(), scatters) ? SEEN | CASTS_SHADOW : SEEN;
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
  rtcSetGeometryMask(g, maskOf(*stored.shape, stored.material, stored.light != nullptr));
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
  rtcSetGeometryMask(g, SEEN | CASTS_SHADOW | OPAQUE | LAMP);
  rtcCommitGeometry(g);
  rtcAttachGeometryByID(tree, g, static_cast<unsigned>(geometries.size() + instances.size()));
  rtcReleaseGeometry(g);
  instances.push_back(
      {&group, sceneFromGroup, glm::transpose(glm::inverse(Mat3d(sceneFromGroup.first()))), object});
}

} // namespace recurse
