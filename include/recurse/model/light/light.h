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

/** Where light comes from: which of its densities are deltas, and in which measure the others are. */
enum class LightKind {
  POINT,      ///< one position, which rays cannot meet
  DISTANT,    ///< one direction, infinitely far, which rays cannot meet
  AREA,       ///< a surface
  ENVIRONMENT ///< all directions, infinitely far: what a ray sees that leaves the scene
};

inline bool isInfinite(LightKind kind) {
  return kind == LightKind::DISTANT || kind == LightKind::ENVIRONMENT;
}

/** A ray that a light may have emitted; of a light infinitely far it may start anywhere on its line. */
struct LeRay {
  Vec3f origin;           ///< on the light; on a surface or displaced from it
  Vec3f direction;        ///< unit, away from the light
  Vec3f normal{0};        ///< unit, of an emitting surface; else zero
  uint32_t primitive = 0; ///< of the emitting shape
  float time = 0;         ///< see Ray::time
};

/**
 * The density with which sampleLe() emits a ray is the product of two. From finite lights it is that of the
 * position, a unit of area [1/length²], and that of the direction from there [1/sr]. From lights infinitely
 * far it is that of the direction [1/sr], and that of the position on a plane across it [1/length²]. A delta
 * has density 0 here.
 */
struct LePdf {
  float position = 0, direction = 0;
  bool deltaPosition = false, deltaDirection = false;
};

/** A photon at its start. */
struct LeSample : LeRay { ///< the origin is displaced already from an emitting surface
  Rgb radiance; ///< along the ray; of POINT the intensity [W/sr], of DISTANT the irradiance across it
  float pdfPosition = 1;  ///< as LePdf::position; 1 for a delta
  float pdfDirection = 1; ///< as LePdf::direction; 1 for a delta
  /** radiance · cosine / (pdfPosition · pdfDirection) without what cancels; the cosine only where there is a
   * surface. Its mean over samples is the light's power [W]. */
  Rgb flux;
};

/** The numbers in [0, 1) that a photon starts by. A light need not use all, but no others: where they come
 * from is the business of whoever shoots. */
struct LeRandom {
  float pick = 0; ///< of the part of the light
  Vec2f place;
  Vec2f direction;
  float time = 0; ///< of the photon: Ray::time
};

/** Light that may arrive at a point. */
struct LiSample {
  Vec3f direction;    ///< unit, towards the light
  Vec3f target;       ///< the point on the light that must be seen; the lit point itself where that is far
  float distance = 0; ///< to the target; infinite for distant and environment light
  Rgb radiance;       ///< arriving radiance; for a delta light the irradiance at perpendicular incidence
  float pdf = 0;      ///< per solid angle [1/sr]; 1 for a delta light
  bool delta = false; ///< the direction cannot be found by chance
  Vec3f normal{0};    ///< at the target where that is a surface, on either side
  uint32_t primitive = 0; ///< of the emitting shape
  float time = 0;         ///< see Ray::time

  /** The light's way from the target, to ask for the density of its emission. */
  LeRay emitted() const { return {target, -direction, normal, primitive, time}; }
};

/** The sphere that holds the scene, for lights that come from outside. */
struct SceneBounds {
  Vec3f center{0};
  float radius = 1;

  /** The density of positions on a disc that covers it, from which the rays of such lights start [1/length²].
   */
  float pdfDisc() const { return 1 / (PI * square(radius)); }
};

class Light {
 public:
  virtual ~Light() = default;
  virtual LightKind kind() const = 0;
  /** True for lights at a point or in one direction, which no ray can hit. */
  bool isDelta() const { return kind() == LightKind::POINT || kind() == LightKind::DISTANT; }
  bool isInfinite() const { return recurse::isInfinite(kind()); }
  /** Whether rays can hit it. */
  virtual bool isIntersectable() const { return !isDelta(); }
  /** Called once before any other function. */
  virtual void prepare(const SceneBounds&) {}
  /** Emitted flux [W]; what enters the scene's bounding sphere for distant and environment lights. */
  virtual Rgb power() const = 0;
  /** The forward pass: one photon. Empty: nothing is emitted for this sample. */
  virtual std::optional<LeSample> sampleLe(const LeRandom& sample) const = 0;
  /** The densities with which sampleLe() emits the ray. */
  virtual LePdf pdfLe(const LeRay& ray) const = 0;
  /** LeSample::radiance for another unit direction from the same place, on the same side of a surface. Area
   * lights are taken to shine evenly wherever they shine: those that do not have to say so. */
  virtual Rgb radianceTowards(const LeSample& sample, const Vec3f& direction) const;
  /** The backward pass: light towards a point, not tested for visibility. Empty: none. */
  virtual std::optional<LiSample> sampleLi(const Vec3f& point, float pick, const Vec2f& u) const = 0;
  /** The same at a time (Ray::time), for lights that move. */
  virtual std::optional<LiSample> sampleLiAt(float /*time*/, const Vec3f& point, float pick,
                                             const Vec2f& u) const {
    return sampleLi(point, pick, u);
  }
};

/** A light on a surface. */
class AreaLight : public Light {
 public:
  explicit AreaLight(const Shape& shape) : shapeOfLight(shape) {
    if (const TexturedRgb* a = shape.alpha.get()) {
      unseen = !a->texture && a->constant.r <= 0;
      if (!unseen) alpha = a;
    }
  }
  LightKind kind() const override { return LightKind::AREA; }
  const Shape& shape() const { return shapeOfLight; }
  /** Emitted radiance at a point of the shape, towards unit `direction`. */
  virtual Rgb radiance(const SurfacePoint& point, const Vec3f& direction) const = 0;
  /** The part of the light that leaves at a point of the shape: what alpha cuts out does not shine. */
  float opacity(const SurfacePoint& point) const {
    return alpha ? std::clamp(alpha->at(point).r, 0.0f, 1.0f) : 1;
  }
  /** As in pbrt, a light whose alpha is the number 0 shines like any, but no ray hits it. */
  bool isIntersectable() const override { return !unseen; }
  /** Density with which sampleLi(from) chooses this point [1/sr]. */
  virtual float pdfLi(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const {
    return shapeOfLight.pdfDirection(from, primitive, point);
  }

 private:
  const Shape& shapeOfLight;
  const TexturedRgb* alpha = nullptr; ///< null: 1
  bool unseen = false;
};

/** A light that rays meet when they leave the scene. */
class EnvironmentLight : public Light {
 public:
  LightKind kind() const override { return LightKind::ENVIRONMENT; }
  virtual Rgb radiance(const Vec3f& direction) const = 0;
  /** Density with which sampleLi(from) chooses the direction, which points to the light [1/sr]. */
  virtual float pdfLi(const Vec3f& from, const Vec3f& direction) const = 0;
};

/** What makers of lights are given besides parameters. */
struct LightContext {
  Mat4d sceneFromLight{1};
  Vec3d sceneOrigin{0}; ///< in world coordinates: to be taken off positions there
};
struct AreaLightContext {
  const Shape& shape;
};

} // namespace recurse
