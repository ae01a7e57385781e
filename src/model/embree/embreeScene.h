/** @file
 * The scene on top of Embree: triangles are Embree's own, every other shape is user geometry, object
 * instances are Embree instances.
 */
#pragma once

#include <atomic>
#include <optional>
#include <set>

#include "model/builder/moving.h"
#include "model/embree/embree.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

class GeometryGroup;
class CurveShape;

/** Ray masks. Surfaces that emit and do not scatter are visible to rays but cast no shadow. For rays of
 * PROBES, too, surfaces with an alpha above 0 are solid. Light passes neither OPAQUE surfaces nor LAMP ones,
 * which emit. */
constexpr unsigned SEEN = 1, CASTS_SHADOW = 2, PROBES = 4, OPAQUE = 8, LAMP = 16;

/** One shape in a tree, with the attributes of hits on it. */
struct SceneGeometry {
  const Shape* shape = nullptr;
  const Material* material = nullptr;
  const AreaLight* light = nullptr;
  uint32_t lightIndex = 0;
  const GeometryGroup* top = nullptr; ///< owner of the instances through which alpha sees its points
  MediumInterface media;
  const TriangleMesh* mesh = nullptr; ///< the shape, if it is one; set by GeometryGroup::add
  const CurveShape* curve = nullptr;  ///< the shape, if it is a curve; set by GeometryGroup::add
  bool compound = false;              ///< the shape's components have materials of their own
  unsigned hiddenBy = 0; ///< mask of the surfaces that hide this one where both are in the same place
  int shapeIndex = -1;   ///< Hit::shape
  uint32_t object = 0;   ///< Hit::object, unless it is part of an instance
};

/** Device of Embree, with the memory that it has allocated [bytes]. */
class EmbreeDevice {
 public:
  EmbreeDevice();
  ~EmbreeDevice() { rtcReleaseDevice(handle); }
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  RTCDevice get() const { return handle; }
  size_t bytes() const { return static_cast<size_t>(taken.load()); }

 private:
  std::atomic<int64_t> taken{0};
  RTCDevice handle;
};

/** Mask of the rays that a shape is visible to; `emits`: it is the shape of an area light. */
unsigned maskOf(const Shape& shape, const Material* material, bool emits);

/** Shapes with a tree of their own: the top level, one object definition, or a moving shape. */
class GeometryGroup {
 public:
  /** `compact`: a smaller but slower tree. */
  GeometryGroup(std::shared_ptr<const EmbreeDevice> device, bool compact);
  ~GeometryGroup();
  GeometryGroup(const GeometryGroup&) = delete;
  GeometryGroup& operator=(const GeometryGroup&) = delete;

  /** Reserves memory for `count` geometries; their addresses must not change once they are attached. */
  void reserve(size_t count) { geometries.reserve(count); }
  void add(const SceneGeometry& geometry);
  /** Sets the attributes of hits on geometry `id` of a kept tree; the shape must be the same. */
  void update(size_t id, const SceneGeometry& geometry);
  void hide(size_t id, unsigned mask) { geometries[id].hiddenBy |= mask; }
  void addInstance(const GeometryGroup& group, const MatrixTrack& sceneFromGroup, uint32_t object);
  void commit() { rtcCommitScene(tree); }

  struct Instance {
    const GeometryGroup* group;
    MatrixTrack sceneFromGroup;
    glm::dmat3 normalFromGroup; ///< inverse transpose, of an instance that does not move
    uint32_t object;            ///< Hit::object
  };
  const SceneGeometry& geometry(uint32_t id) const { return geometries[id]; }
  const std::vector<SceneGeometry>& allGeometries() const { return geometries; }
  const std::vector<Instance>& allInstances() const { return instances; }
  const Instance& instance(uint32_t id) const { return instances[id - geometries.size()]; }
  RTCScene scene() const { return tree; }

 private:
  /** Makes the Embree geometry of a shape. */
  RTCGeometry newTriangles(const TriangleMesh& mesh, SceneGeometry& stored) const;
  RTCGeometry newCurve(const CurveShape& curve, SceneGeometry& stored) const;
  RTCGeometry newUserGeometry(SceneGeometry& stored) const;

  std::shared_ptr<const EmbreeDevice> device;
  RTCScene tree;
  std::vector<SceneGeometry> geometries; ///< by Embree's geometry id
  std::vector<Instance> instances;       ///< by id, which continues after the geometries
};

/** Transforms a point of an object definition to the scene, at a time of the instance's motion. */
void transformToScene(const GeometryGroup::Instance& instance, float time, SurfacePoint& p);

inline HitParameters parametersOf(const RTCHit& h) { return {{h.u, h.v}, {h.Ng_x, h.Ng_y, h.Ng_z}}; }

class EmbreeScene final : public Scene {
 public:
  explicit EmbreeScene(std::shared_ptr<const EmbreeDevice> device);

  bool intersect(const Ray& ray, Hit& hit) const override;
  bool intersectPosition(const Ray& ray, Hit& hit) const override;
  bool probePosition(const Ray& ray, Hit& hit) const override;
  bool occluded(const Ray& ray) const override;
  void intersectBatch(std::span<const Ray> rays, Coherence coherence, std::span<Hit> hits) const override;
  void occludedBatch(std::span<const Ray> rays, std::span<uint8_t> blocked) const override;
  size_t memoryBytes() const override { return device->bytes(); }
  const GeometryGroup& top() const { return *groups.front(); }

 private:
  friend class SceneBuilder;
  /** Nearest hit of a ray, as Embree returns it. */
  struct PositionHit {
    float t;
    HitParameters parameters;
    unsigned geometry, primitive, instance;
  };
  PositionHit nearest(const Ray& ray, unsigned mask, float tMin = 0) const;
  /** Finds the nearest hits of up to GROUP rays. */
  void nearestOfEach(std::span<const Ray> rays, Coherence coherence, PositionHit* positions) const;
  /** Group of the geometry that was hit. */
  const GeometryGroup& groupOf(const PositionHit& position) const;
  const TriangleMesh* meshOf(const PositionHit& position) const;
  /** Parts of a hit to be computed: the whole surface point, or only its position. */
  enum class Wanted { SURFACE, PLACE };
  /** Finds the nearest surface for rays of a mask. */
  bool find(const Ray& ray, unsigned mask, Wanted wanted, Hit& hit) const;
  /** Completes a hit. If another surface hides it in the same place, the hit is on that one. */
  void complete(const PositionHit& position, const Ray& ray, Wanted wanted, Hit& hit) const;
  /** Computes the members of a hit. Returns the geometry. */
  const SceneGeometry& computeHit(const PositionHit& position, float time, Wanted wanted, Hit& hit) const;
  /** Finds a surface of `mask` in the same place as a hit on another one: nearer than the errors of both
   * positions. */
  std::optional<PositionHit> inSamePlace(const Ray& ray, const Hit& hit, unsigned mask, Wanted wanted,
                                         Hit& other) const;
  /** Sets SceneGeometry::hiddenBy by points on the surfaces that light passes, and on lamps. Returns the
   * shapes outside of instances of which no point is seen; none where shapes move, or where they are the
   * boundaries of media. */
  std::set<const Shape*> findTouching();

  std::shared_ptr<const EmbreeDevice> device;
  bool packets; ///< Embree supports packets of 8 rays on this processor
  std::vector<std::unique_ptr<Texture>> textures;
  std::vector<std::unique_ptr<Material>> materials;
  std::vector<std::shared_ptr<Shape>> shapes;
  std::vector<std::unique_ptr<Light>> ownLights;
  std::vector<std::shared_ptr<GeometryGroup>> groups; ///< [0] is the top level
};

} // namespace recurse
