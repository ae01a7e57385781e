/** @file
 * Lights: the plug-in interface of emission, for both passes.
 */
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/core/math/rgb.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/model/shape/shape.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

/** Kind of a light: determines which of its densities are deltas, and the measure of its densities. */
enum class LightKind {
  POINT,      ///< one position, which rays cannot hit
  DISTANT,    ///< one direction, infinitely far, which rays cannot hit
  AREA,       ///< a surface
  ENVIRONMENT ///< all directions, infinitely far: seen by rays that leave the scene
};

inline bool isInfinite(LightKind kind) {
  return kind == LightKind::DISTANT || kind == LightKind::ENVIRONMENT;
}

/** Ray that a light may have emitted; for infinite lights it may start anywhere on its line. */
struct LeRay {
  Vec3f origin;    ///< on the light: on its surface, or offset from it
  Vec3f direction; ///< unit, away from the light
  /** Unit geometric normal of an emitting surface, on either side if both emit; zero for other lights. */
  Vec3f normal{0};
  uint32_t primitive = 0; ///< of the emitting shape
  float time = 0;         ///< see Ray::time; lights that do not move leave it 0 in their samples
};

/**
 * Density of a ray in sampleLe(), the product of two densities. Finite lights: the density of the position
 * [1/length²], and of the direction given the position [1/sr]. Infinite lights: the density of the direction
 * [1/sr], and of the position on a plane perpendicular to it [1/length²]. A delta distribution has zero
 * density here.
 */
struct LePdf {
  float position = 0, direction = 0;
  bool deltaPosition = false, deltaDirection = false;
};

/** Emission sample: start of a photon. */
struct LeSample : LeRay { ///< the origin is already offset from an emitting surface
  Rgb radiance; ///< along the ray [W/(m² sr)]; POINT: intensity [W/sr]; DISTANT: irradiance across it [W/m²]
  float pdfPosition = 1;  ///< LePdf::position, but 1 for a delta
  float pdfDirection = 1; ///< LePdf::direction, but 1 for a delta
  /** radiance · cosine / (pdfPosition · pdfDirection) with common factors cancelled; the cosine only for
   * surfaces. The mean over samples is the light's exact power, without parts that alpha cuts out [W]. */
  Rgb flux;
};

/** Random numbers in [0, 1) of a photon's emission. A light may use some or all of these, and no others: the
 * caller decides on their source. */
struct LeRandom {
  float pick = 0; ///< chooses a part of the light
  Vec2f position;
  Vec2f direction;
  float time = 0; ///< Ray::time of the photon
};

/** Light sample: radiance that may arrive at a point. */
struct LiSample {
  Vec3f direction;    ///< unit, towards the light
  Vec3f target;       ///< point on the light to be tested for visibility; the lit point for infinite lights
  float distance = 0; ///< to the target [scene units]; infinite for distant and environment lights
  Rgb radiance;  ///< incident [W/(m² sr)]; POINT and DISTANT: irradiance perpendicular to the ray [W/m²]
  float pdf = 0; ///< density [1/sr]; 1 for POINT and DISTANT
  bool unhittable = false; ///< true: BSDF sampling cannot find the light, since no ray hits it
  Vec3f normal{0};         ///< LeRay::normal at the target
  uint32_t primitive = 0;  ///< of the emitting shape
  float time = 0;          ///< see LeRay::time

  /** Ray from the target along which the light arrives, for pdfLe(). */
  LeRay emitted() const { return {target, -direction, normal, primitive, time}; }
};

/** Bounding sphere of the scene, for infinite lights. */
struct SceneBounds {
  Vec3f center{0};
  float radius = 1;

  /** Density of positions on a disc of the sphere's radius, from which rays of infinite lights start
   * [1/length²]. */
  float pdfDisc() const { return 1 / (PI * square(radius)); }
};

/** Light of a scene. Immutable after prepare(): any thread may then call it. */
class Light {
 public:
  virtual ~Light() = default;
  virtual LightKind kind() const = 0;
  /** True for lights at a point or in one direction, which no ray can hit. */
  bool isDelta() const { return kind() == LightKind::POINT || kind() == LightKind::DISTANT; }
  bool isInfinite() const { return recurse::isInfinite(kind()); }
  /** Whether rays can hit the light. */
  virtual bool isIntersectable() const { return !isDelta(); }
  /** Sets the bounds of the scene. Called once, before power(), samples and densities; kind() may be called
   * earlier. */
  virtual void prepare(const SceneBounds&) {}
  /** Emitted flux [W]; for infinite lights, the flux that enters the scene's bounding sphere. Parts that
   * alpha cuts out are included, and transforms with different scales by direction make it approximate. */
  virtual Rgb power() const = 0;
  /** Emission sample for the forward pass: one photon. Empty: no emission for this sample. */
  virtual std::optional<LeSample> sampleLe(const LeRandom& sample) const = 0;
  /** Densities of the ray in sampleLe(). */
  virtual LePdf pdfLe(const LeRay& ray) const = 0;
  /** LeSample::radiance for a different unit direction from the same point, on the same side of a surface;
   * for finite lights. By default black where pdfLe() has no density of the direction; else for area lights
   * the radiance of the sample, and for POINT the intensity that follows from sampleLiAt(). */
  virtual Rgb radianceTowards(const LeSample& sample, const Vec3f& direction) const;
  /** Light sample at a point by numbers in [0, 1), without a visibility test. Empty: none. */
  virtual std::optional<LiSample> sampleLi(const Vec3f& point, float pick, const Vec2f& u) const = 0;
  /** Light sample at a time (Ray::time), for lights that move. */
  virtual std::optional<LiSample> sampleLiAt(float /*time*/, const Vec3f& point, float pick,
                                             const Vec2f& u) const {
    return sampleLi(point, pick, u);
  }
};

/** Light on a surface. */
class AreaLight : public Light {
 public:
  /** The shape must outlive the light, and already have its alpha. */
  explicit AreaLight(const Shape& shape) : shapeOfLight(shape) {
    if (const TexturedRgb* a = shape.alpha.get()) {
      unseen = !a->texture && a->constant.r <= 0;
      if (!unseen) alpha = a;
    }
  }
  LightKind kind() const override { return LightKind::AREA; }
  const Shape& shape() const { return shapeOfLight; }
  /** Emitted radiance at a point of the shape, towards unit `direction` [W/(m² sr)]; without opacity(). */
  virtual Rgb radiance(const SurfacePoint& point, const Vec3f& direction) const = 0;
  /** Fraction of the radiance that leaves a point of the shape: parts cut out by alpha do not emit. */
  float opacity(const SurfacePoint& point) const {
    return alpha ? std::clamp(alpha->at(point).r, 0.0f, 1.0f) : 1;
  }
  /** False where alpha is the constant 0: as in pbrt, such a light emits as usual, but no ray hits it. */
  bool isIntersectable() const override { return !unseen; }
  /** Density in sampleLi(from) of the direction to this point of `primitive` [1/sr]. */
  virtual float pdfLi(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const {
    return shapeOfLight.pdfDirection(from, primitive, point);
  }

 private:
  const Shape& shapeOfLight;
  const TexturedRgb* alpha = nullptr; ///< null: 1
  bool unseen = false;
};

/** Infinite light that rays hit when they leave the scene. */
class EnvironmentLight : public Light {
 public:
  LightKind kind() const override { return LightKind::ENVIRONMENT; }
  /** Radiance that arrives from a unit direction, towards the light [W/(m² sr)]. */
  virtual Rgb radiance(const Vec3f& direction) const = 0;
  /** Density of a direction towards the light in sampleLi(from) [1/sr]. */
  virtual float pdfLi(const Vec3f& from, const Vec3f& direction) const = 0;
};

/** Arguments of makers of lights besides parameters. */
struct LightContext {
  Mat4d sceneFromLight{1};
  Vec3d sceneOrigin{0}; ///< world coordinates of the scene's origin, to be subtracted from world positions
};
struct AreaLightContext {
  const Shape& shape;
};

} // namespace recurse
