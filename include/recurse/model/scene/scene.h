/** @file
 * The scene: immutable, in single precision, shared by all threads. It is built from a SceneDescription, with
 * Embree as its acceleration structure.
 */
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/camera/camera.h"
#include "recurse/model/camera/pixelSampler.h"
#include "recurse/model/light/light.h"
#include "recurse/model/medium/medium.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/shape/shape.h"
#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

class KeptParts;

/** Intersection of a ray with the scene. Of the point, queries set what Shape::surfaceAt() sets, and the
 * time. */
struct Hit {
  SurfacePoint point;
  float t = 0;                          ///< distance along the ray [scene units]
  uint32_t primitive = 0;               ///< index within the shape
  const Material* material = nullptr;   ///< null: the surface does not scatter
  const AreaLight* areaLight = nullptr; ///< null: the surface does not emit
  uint32_t lightIndex = 0;              ///< of areaLight in the light table
  int shape = -1;                       ///< in Scene::shapes(); -1: not one of them
  MediumInterface media;                ///< on both sides, where the surface is a boundary of media
  uint32_t object = 0;                  ///< see Scene::objectName()
};

/** Rest of a ray straight behind a surface that it has hit. At an edge it starts behind all surfaces there:
 * if it were displaced from one surface only, it would hit the rest of them again and again. */
inline Ray rayBehind(const Ray& ray, const Hit& hit) {
  constexpr float AT_ONCE = 2; // minimum distance to the next surface, over its position error
  SurfacePoint point = hit.point;
  if (!(hit.t * glm::length(ray.direction) > AT_ONCE * glm::length(hit.point.error))) {
    const Vec3f normal = hit.point.normalTowards(ray.direction);
    const float height = glm::dot(hit.point.rayOrigin(ray.direction) - ray.origin, normal);
    point.position = ray.origin + normal * std::max(0.0f, height);
  }
  return {point.rayOrigin(ray.direction), ray.direction, ray.tMax - hit.t, ray.time};
}

/** Shape at rest, outside of instances. Emitting shapes of instances at rest are included, once for each
 * instance. */
struct SceneShape {
  const Shape* shape = nullptr;
  const Material* material = nullptr; ///< null: no scattering, unless Shape::componentMaterials() has others
};

/** Names of a scene's objects. An object is an instance of an ObjectBegin, or a shape outside of any, which
 * is named by its parameter "name", else after its file, else after its kind. */
class ObjectNames {
 public:
  /** Adds an object; returns its index, counted from 0. */
  uint32_t add(const std::string& name);
  /** Unique name of an object, numbered from the second of a name: `tree`, `tree.2`; numbers that the name of
   * another object has are left out. Stable for the same scene; call when all objects are added. */
  std::string operator[](uint32_t object) const;
  /** The name without a number. */
  const std::string& common(uint32_t object) const { return names[objects[object].name]; }
  uint32_t size() const { return uint32_t(objects.size()); }

 private:
  struct Object {
    uint32_t name, copy;
  };
  std::map<std::string, uint32_t> known;
  std::vector<std::string> names;
  std::vector<uint32_t> copies;                    ///< number of objects for each of names
  std::map<std::string, std::set<uint32_t>> taken; ///< numbers behind a name and a point in other names
  std::vector<Object> objects;
};

/** Lamp: the lights that one LightSource or one emitting Shape makes; a Shape makes one in each instance. */
struct Lamp {
  std::string name;        ///< of the light's directive, else of its shape, else `light-N`, counted from 1
  std::string kind;        ///< type of the LightSource or Shape
  SourceLocation location; ///< of the LightSource or Shape
};

/** Medium around a finite light or the camera. */
struct SurroundingMedium {
  uint16_t index = 0;  ///< number of the medium; if it varies, of the one that no boundary determines
  bool varies = false; ///< rays from different points or sides start in different media
};

/** Light chosen from the table. */
struct ChosenLight {
  const Light* light = nullptr;
  float probability = 0; ///< of the choice
  uint32_t index = 0;    ///< in the table
};

/** Lights with selection probabilities in proportion to their power, in its largest channel; all
 * probabilities are 0 where no light has power. */
class LightTable {
 public:
  void build(const std::vector<const Light*>& lights);
  /** Builds the table with probabilities in proportion to `weights`, one of at least 0 for each light,
   * instead of power. */
  void build(const std::vector<const Light*>& lights, const std::vector<double>& weights);
  size_t size() const { return lights.size(); }
  const Light& operator[](size_t i) const { return *lights[i]; }
  float probability(size_t i) const { return probabilities[i]; }
  /** Chooses by u in [0,1), which becomes a fresh number in [0,1). The table must not be empty. */
  size_t chooseIndex(float& u) const { return lights.size() == 1 ? 0 : chooseOfMany(u); }
  ChosenLight choose(float& u) const {
    const size_t i = chooseIndex(u);
    return {lights[i], probabilities[i], static_cast<uint32_t>(i)};
  }

 private:
  size_t chooseOfMany(float& u) const;

  std::vector<const Light*> lights;
  std::vector<float> probabilities, cumulative;
};

/** Contents of a scene: integrators adapt to them, and `--check` prints them. Shapes and primitives of an
 * object count once for all of its instances. Area lights, and shapes that emit or move by themselves, count
 * once for each instance. Each shape that moves by itself also counts as an instance. */
struct SceneContents {
  size_t shapes = 0, triangles = 0, otherPrimitives = 0, instances = 0, materials = 0;
  size_t areaLights = 0, deltaLights = 0, environmentLights = 0;
  size_t media = 0;
  LobeSet lobes = NO_LOBE;
};

/** Scene. Any thread may call its functions; queries of rays throw Interrupted (see checkInterrupted()). */
class Scene {
 public:
  virtual ~Scene() = default;

  /** Finds the nearest surface that scatters, emits or bounds a medium, up to ray.tMax. Returns false for
   * a miss, and then leaves the hit unchanged. */
  virtual bool intersect(const Ray& ray, Hit& hit) const = 0;
  /** Partial intersect(): of hit.point, only position, error and geometric normal are set. */
  virtual bool intersectPosition(const Ray& ray, Hit& hit) const { return intersect(ray, hit); }
  /** intersectPosition() for probes of geometry: the ray hits all surfaces whose alpha is not 0. */
  virtual bool probePosition(const Ray& ray, Hit& hit) const { return intersectPosition(ray, hit); }
  /** True where a scattering surface blocks the ray (t < ray.tMax). */
  virtual bool occluded(const Ray& ray) const = 0;
  /** Similarity of the rays in a batch: COHERENT for rays of neighbouring pixels. A hint that affects only
   * performance. */
  enum class Coherence { NONE, COHERENT };
  /**
   * Batched intersect(), which is faster, with a hit for each ray. hits[i].t is infinite where ray i misses.
   * The parameters of a hit may differ from intersect() by rounding, and of two surfaces at the same distance
   * either may be reported.
   */
  virtual void intersectBatch(std::span<const Ray> rays, Coherence coherence, std::span<Hit> hits) const;
  /** Batched occluded(): blocked[i] is 1 where ray i is blocked, else 0. */
  virtual void occludedBatch(std::span<const Ray> rays, std::span<uint8_t> blocked) const;

  const LightTable& lights() const { return lightTable; }
  const std::vector<const EnvironmentLight*>& environment() const { return environmentLights; }
  /** Index of environment()[i] in lights(). */
  const std::vector<uint32_t>& environmentIndices() const { return environmentLightIndices; }
  const std::vector<SceneShape>& shapes() const { return sceneShapes; }
  const SceneBounds& bounds() const { return sceneBounds; }
  /** World coordinates of the scene's origin, which is subtracted from every position. */
  const Vec3d& origin() const { return sceneOrigin; }
  const SceneContents& contents() const { return sceneContents; }
  /** Name of the object of a hit. */
  std::string objectName(uint32_t object) const { return objectNames[object]; }
  const ObjectNames& objects() const { return objectNames; }
  /** Lamps in the order of the light table. */
  const std::vector<Lamp>& lamps() const { return sceneLamps; }
  /** Index of the lamp of a light of the table. */
  uint32_t lampOf(size_t light) const { return lampsOfLights[light]; }
  /** Names that the file gives to materials, by Material::number; empty for a material without. */
  const std::vector<std::string>& materialLabels() const { return labelsOfMaterials; }
  /** Names of media, by their index less one; empty: the medium inside a material. */
  const std::vector<std::string>& mediumNames() const { return namesOfMedia; }
  /** Name of a material in the file, else its kind, numbered from the second of a kind; empty for null. */
  std::string materialName(const Material* material) const;
  /** Maximum number of dielectrics with priority in a scene, equal ones counted once. */
  static constexpr size_t MAX_NESTED = 32;
  /** Refractive indices of nested dielectrics, highest priority first. */
  const std::vector<float>& nestedIndices() const { return nestedDielectrics; }
  /** Whether the scene has media; without any, rays skip all medium queries. */
  bool hasMedia() const { return !sceneMedia.empty(); }
  bool hasEmissiveMedia() const {
    for (const auto& medium : sceneMedia)
      if (medium->isEmissive()) return true;
    return false;
  }
  /** Medium by its index in a MediumInterface; null: vacuum. */
  const Medium* medium(uint16_t number) const { return number ? sceneMedia[number - 1u].get() : nullptr; }
  size_t mediumCount() const { return sceneMedia.size(); }
  /** Index of the medium around the camera, by the surfaces around; if they bound none, the one named. */
  uint16_t cameraMedium() const { return mediumOfCamera; }
  /** Medium around a finite light, by the surfaces around; if they bound none, the one named, else the
   * camera's. */
  const SurroundingMedium& lightMedium(size_t light) const { return mediaOfLights[light]; }
  static constexpr uint16_t SURROUNDING_MEDIUM = 0xffff; ///< the medium around a dielectric
  /** Index of the medium inside of a nested dielectric with priority, or SURROUNDING_MEDIUM. */
  uint16_t nestedMedium(size_t nested) const { return nestedMedia[nested]; }
  const Camera& camera() const { return *sceneCamera; }
  /** True where the scene or the camera moves while the shutter is open, so that rays of different times may
   * differ. */
  bool moves() const {
    return (shapesMove || sceneCamera->usesTime()) && sceneCamera->timeAt(0) < sceneCamera->timeAt(1);
  }
  const Filter& filter() const { return *pixelFilter; }
  const FilmSettings& film() const { return filmSettings; }
  const PixelSampler& sampler() const { return *pixelSampler; }
  /** Memory that Embree has for the trees and its copies of vertices [bytes]. Shapes are not counted; parts
   * kept for other frames are. */
  virtual size_t memoryBytes() const = 0;

 protected:
  LightTable lightTable;
  std::vector<const EnvironmentLight*> environmentLights;
  std::vector<uint32_t> environmentLightIndices;
  std::vector<SceneShape> sceneShapes;
  SceneBounds sceneBounds;
  Vec3d sceneOrigin{0};
  SceneContents sceneContents;
  ObjectNames objectNames;
  std::map<const Material*, std::string> materialNames;
  std::vector<Lamp> sceneLamps;
  std::vector<uint32_t> lampsOfLights;
  std::vector<std::string> labelsOfMaterials, namesOfMedia;
  std::vector<float> nestedDielectrics;
  std::vector<std::shared_ptr<Medium>> sceneMedia;
  std::vector<uint16_t> nestedMedia;            ///< medium inside each entry of nestedDielectrics
  std::vector<SurroundingMedium> mediaOfLights; ///< in the order of the light table
  uint16_t mediumOfCamera = 0;
  std::unique_ptr<Camera> sceneCamera;
  bool shapesMove = false;
  std::unique_ptr<Filter> pixelFilter;
  std::unique_ptr<PixelSampler> pixelSampler;
  FilmSettings filmSettings;
};

/** Command-line values that replace settings of the scene file. */
struct SceneOverrides {
  int width = 0, height = 0;                    ///< both given, for the whole film; or 0: from the file
  std::array<double, 4> cropWindow{0, 0, 0, 0}; ///< x0 x1 y0 y1 in [0,1]; x0 == x1: not replaced
  bool lenient = false;                         ///< unknown parameters are warnings
  bool compact = false;                         ///< smaller and slower trees
};

/**
 * Expands imports, and makes the plug-ins in use except the integrator. Errors of the scene are reported to
 * `diagnostics`; the result is null when there was any. Throws Error (BAD_USAGE) where the crop window
 * contains no pixel. `kept`: reusable parts are taken from it, and the parts for the next frame are left in
 * it.
 */
std::unique_ptr<Scene> buildScene(const SceneDescription& description, const SceneOverrides& overrides,
                                  Diagnostics& diagnostics, KeptParts* kept = nullptr);

} // namespace recurse
