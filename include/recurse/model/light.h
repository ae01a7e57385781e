/** @file
 * Lights: the plug-in interface of emission, for both passes.
 */
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "recurse/core/ray.h"
#include "recurse/core/rgb.h"
#include "recurse/core/sampler.h"
#include "recurse/model/shape.h"
#include "recurse/model/texture.h"

namespace recurse {

/** A photon at its start. */
struct Emission {
  Vec3f origin;    ///< displaced already from an emitting surface
  Vec3f direction; ///< unit
  Rgb flux;        ///< emitted radiance · cosine / density: its mean over samples is the light's power [W]
};

/** The numbers in [0, 1) that a photon starts by. A light need not use all, but no others: where they come
 * from is the business of whoever shoots. */
struct EmissionSample {
  float pick = 0; ///< of the part of the light
  Vec2f place;
  Vec2f direction;
};

/** Light that may arrive at a point. */
struct Illumination {
  Vec3f direction;    ///< unit, towards the light
  Vec3f target;       ///< the point on the light that must be seen; unused when distance is infinite
  float distance = 0; ///< to the target; infinite for distant and environment light
  Rgb radiance;       ///< arriving radiance; for a delta light the irradiance at perpendicular incidence
  float pdf = 0;      ///< per solid angle [1/sr]; 1 for a delta light
  bool delta = false; ///< the direction cannot be found by chance
};

/** The sphere that holds the scene, for lights that come from outside. */
struct SceneBounds {
  Vec3f center{0};
  float radius = 1;
};

class Light {
 public:
  virtual ~Light() = default;
  /** Called once before any other function. */
  virtual void prepare(const SceneBounds&) {}
  /** Emitted flux [W]; what enters the scene's bounding sphere for distant and environment lights. */
  virtual Rgb power() const = 0;
  /** The forward pass: one photon. Empty: nothing is emitted for this sample. */
  virtual std::optional<Emission> emit(const EmissionSample& sample) const = 0;
  /** The backward pass: light towards a point, not tested for visibility. Empty: none. */
  virtual std::optional<Illumination> illuminate(const Vec3f& point, float pick, const Vec2f& u) const = 0;
  /** True for lights at a point or in one direction, which rays cannot meet. */
  virtual bool isDelta() const { return false; }
};

/** A light that rays meet because it sits on a surface. */
class AreaLight : public Light {
 public:
  explicit AreaLight(const Shape& shape) : shapeOfLight(shape) {
    if (const TexturedRgb* a = shape.alpha.get()) {
      unseen = !a->texture && a->constant.r <= 0;
      if (!unseen) alpha = a;
    }
  }
  const Shape& shape() const { return shapeOfLight; }
  /** Emitted radiance at a point of the shape, towards unit `direction`. */
  virtual Rgb radiance(const SurfacePoint& point, const Vec3f& direction) const = 0;
  /** The part of the light that leaves at a point of the shape: what alpha cuts out does not shine. */
  float opacity(const SurfacePoint& point) const {
    return alpha ? std::clamp(alpha->at(point).r, 0.0f, 1.0f) : 1;
  }
  /** As in pbrt, a light whose alpha is the number 0 shines like any, but no ray ever meets it. */
  bool isUnseen() const { return unseen; }
  /** Density with which illuminate(from) chooses this point [1/sr]. */
  float pdfIlluminate(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const {
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
  virtual Rgb radiance(const Vec3f& direction) const = 0;
  /** Density with which illuminate chooses the direction [1/sr]. */
  virtual float pdfIlluminate(const Vec3f& direction) const = 0;
};

/** What makers of lights are given besides parameters. */
struct LightContext {
  Mat4d sceneFromLight{1};
};
struct AreaLightContext {
  const Shape& shape;
};

} // namespace recurse
