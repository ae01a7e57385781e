/** @file
 * The scene: immutable, in float, shared by every thread. Built from a SceneDescription, with Embree as its
 * tree.
 */
#pragma once

#include <array>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/camera/camera.h"
#include "recurse/model/light/light.h"
#include "recurse/model/medium/medium.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/shape/shape.h"
#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

class KeptParts;

/** Where a ray met the scene. */
struct Hit {
  SurfacePoint point;
  float t = 0;
  uint32_t primitive = 0;
  const Material* material = nullptr;   ///< null: the surface does not scatter
  const AreaLight* areaLight = nullptr; ///< null: the surface does not emit
  uint32_t lightIndex = 0;              ///< of areaLight in the light table
  int shape = -1;                       ///< in Scene::shapes(); -1: a part of an instance
  MediumInterface media;                ///< on both sides, where the surface is their boundary
  uint32_t object = 0;                  ///< by Scene::objectName()
};

/** A shape at rest that is no part of an instance. */
struct SceneShape {
  const Shape* shape = nullptr;
  const Material* material = nullptr; ///< null: it does not scatter
};

/** Names of a scene's objects. An object is an instance of an ObjectBegin, or a shape that stands by itself,
 * which is called after its file or its kind. */
class ObjectNames {
 public:
  /** A new object, numbered from 0. */
  uint32_t add(const std::string& name);
  /** The same names for the same scene: those that are not alone with theirs have a number, `tree.2`. */
  std::string operator[](uint32_t object) const;

 private:
  struct Object {
    uint32_t name, copy;
  };
  std::map<std::string, uint32_t> known;
  std::vector<std::string> names;
  std::vector<uint32_t> copies; ///< for each of names
  std::vector<Object> objects;
};

/** A light chosen from the table. */
struct ChosenLight {
  const Light* light = nullptr;
  float probability = 0;
  uint32_t index = 0; ///< in the table
};

/** The lights with probabilities in proportion to their power. */
class LightTable {
 public:
  void build(const std::vector<const Light*>& lights);
  /** The same with probabilities in proportion to other numbers than their power. */
  void build(const std::vector<const Light*>& lights, const std::vector<double>& weights);
  size_t size() const { return lights.size(); }
  const Light& operator[](size_t i) const { return *lights[i]; }
  float probability(size_t i) const { return probabilities[i]; }
  /** u in [0,1) is used up and replaced by a fresh number in [0,1). Not to be called on an empty table. */
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

/** What a scene contains; decides what the integrators need to do, and is told by `--check`. */
struct SceneContents {
  size_t shapes = 0, triangles = 0, otherPrimitives = 0, instances = 0, materials = 0;
  size_t areaLights = 0, deltaLights = 0, environmentLights = 0;
  size_t media = 0;
  LobeSet lobes = NO_LOBE;
};

class Scene {
 public:
  virtual ~Scene() = default;

  /** The nearest surface along the ray. */
  virtual bool intersect(const Ray& ray, Hit& hit) const = 0;
  /** The same for rays that only ask where the surface is: of the hit's point nothing is set but position,
   * error and geometric normal. */
  virtual bool intersectPosition(const Ray& ray, Hit& hit) const { return intersect(ray, hit); }
  /** True when something scattering lies between the points' ends of the ray (t < ray.tMax). */
  virtual bool occluded(const Ray& ray) const = 0;
  /** How alike the rays of a batch are: COHERENT for those of neighbouring pixels. It changes only the speed.
   */
  enum class Coherence { NONE, COHERENT };
  /**
   * intersect() for many rays at once, which is faster. hits[i].t is infinite where ray i meets nothing. The
   * parameters of a hit may differ from those of a single ray by rounding, and of two surfaces at the same
   * distance either may be met.
   */
  virtual void intersectBatch(std::span<const Ray> rays, Coherence coherence, std::span<Hit> hits) const;
  virtual void occludedBatch(std::span<const Ray> rays, std::span<uint8_t> blocked) const;

  const LightTable& lights() const { return lightTable; }
  const std::vector<const EnvironmentLight*>& environment() const { return environmentLights; }
  /** Index in lights() of environment()[i]. */
  const std::vector<uint32_t>& environmentIndices() const { return environmentLightIndices; }
  const std::vector<SceneShape>& shapes() const { return sceneShapes; }
  const SceneBounds& bounds() const { return sceneBounds; }
  /** World coordinates of the scene's origin: what was taken off every position. */
  const Vec3d& origin() const { return sceneOrigin; }
  const SceneContents& contents() const { return sceneContents; }
  /** What a hit's object is called. */
  std::string objectName(uint32_t object) const { return objectNames[object]; }
  /** The name in the file, or the kind with a number; empty for what has none. */
  std::string materialName(const Material* material) const;
  /** Dielectrics with priority that a scene may have, those of the same matter counted once. */
  static constexpr size_t MAX_NESTED = 32;
  /** Their refractive indices, the strongest first. */
  const std::vector<float>& nestedIndices() const { return nestedDielectrics; }
  /** Whether there are media at all; where not, no ray asks for them. */
  bool hasMedia() const { return !sceneMedia.empty(); }
  /** By its number in a MediumInterface; null: vacuum. */
  const Medium* medium(uint16_t number) const { return number ? sceneMedia[number - 1u].get() : nullptr; }
  size_t mediumCount() const { return sceneMedia.size(); }
  /** What the camera stands in. */
  uint16_t cameraMedium() const { return mediumOfCamera; }
  /** What the file says that a light stands in; for areas, on the outer side of the shape. */
  uint16_t lightMedium(size_t light) const { return mediaOfLights[light]; }
  /** What fills a dielectric with priority. */
  static constexpr uint16_t SURROUNDING_MEDIUM = 0xffff; ///< the same as what is around it
  uint16_t nestedMedium(size_t nested) const { return nestedMedia[nested]; }
  const Camera& camera() const { return *sceneCamera; }
  /** Whether rays of different times may see something else, the camera's shutter being open for long enough.
   */
  bool moves() const {
    return (shapesMove || sceneCamera->usesTime()) && sceneCamera->timeAt(0) < sceneCamera->timeAt(1);
  }
  const Filter& filter() const { return *pixelFilter; }
  const FilmSettings& film() const { return filmSettings; }
  const SamplerSettings& sampler() const { return samplerSettings; }
  /** Bytes that the geometry and its tree take. */
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
  std::vector<float> nestedDielectrics;
  std::vector<std::shared_ptr<Medium>> sceneMedia;
  std::vector<uint16_t> nestedMedia;   ///< one for each of nestedDielectrics, where there are media
  std::vector<uint16_t> mediaOfLights; ///< as in the light table
  uint16_t mediumOfCamera = 0;
  std::unique_ptr<Camera> sceneCamera;
  bool shapesMove = false;
  std::unique_ptr<Filter> pixelFilter;
  FilmSettings filmSettings;
  SamplerSettings samplerSettings;
};

/** What the command line may put in the place of the scene file's settings. */
struct SceneOverrides {
  int width = 0, height = 0;                   ///< 0: as in the file
  std::array<float, 4> cropWindow{0, 0, 0, 0}; ///< x0 x1 y0 y1 in [0,1]; x0 == x1: as in the file
  bool lenient = false;                        ///< unknown parameters are warnings
  bool compact = false;                        ///< trees that take less memory and more time
};

/**
 * Makes every plug-in of the description. Everything wrong goes to `diagnostics`; the result is null when
 * there was an error. `kept`: takes what it can from there, and leaves there what the next frame may take.
 */
std::unique_ptr<Scene> buildScene(const SceneDescription& description, const SceneOverrides& overrides,
                                  Diagnostics& diagnostics, KeptParts* kept = nullptr);

} // namespace recurse
