/** @file
 * Smooth or rough interface between two dielectrics, for flux (Walter et al. 2007). It is the scattering
 * model of `dielectric`, and the top layer of the coated materials.
 */
#pragma once

#include <optional>

#include "bsdfs/microfacet/fresnel.h"
#include "bsdfs/microfacet/microfacet.h"
#include "recurse/model/bsdf/bsdf.h"

namespace recurse {

/** Dielectric interface with outer side +z. Smooth `facets` are only for the functions that say so. */
struct DielectricInterface {
  float eta = 1.5f; ///< refractive index below over above
  Microfacets facets;

  /** Sampled direction; weight = f cos / pdf of the chosen kind of scattering. */
  struct Step {
    Vec3f wo{0, 0, 1};
    float weight = 0;
  };

  /** Facet that scatters wi to wo. */
  struct Facet {
    Vec3f m{0, 0, 1};   ///< its normal, on the side of wi
    float fresnel = 0;  ///< reflectance, or transmittance of a refraction
    float cosAbove = 0; ///< cosine of the ray above with the normal; 0 at total reflection from below
    float jacobian =
        0; ///< refraction: solid angle of normals per solid angle of wo (Walter et al. 2007, eq. 17)
  };

  /** Relative index: the index beyond the interface over the index on the side of w. */
  float relative(const Vec3f& w) const { return w.z > 0 ? eta : 1 / eta; }

  /** BRDF or BTDF for flux from wi to wo [1/sr]. */
  float value(const Vec3f& wi, const Vec3f& wo) const {
    Facet f;
    return facet(wi, wo, f) ? valueOf(f, f.fresnel, wi, wo) : 0;
  }
  /** Value of a facet with this reflectance or transmittance. */
  template <class T> T valueOf(const Facet& f, const T& fresnel, const Vec3f& wi, const Vec3f& wo) const {
    if (wi.z * wo.z > 0) return fresnel * facets.reflection(wi, wo, f.m);
    return fresnel * facets.density(f.m) * facets.shadowedPair(wi, wo) * absDot(wi, f.m) * f.jacobian;
  }

  /** Density of sample() for the same lobes [1/sr]. */
  float pdf(const Vec3f& wi, const Vec3f& wo, LobeSet lobes = NON_DELTA_LOBES) const {
    const bool reflection = wi.z * wo.z > 0;
    if (!(lobes & (reflection ? REFLECTION : TRANSMISSION))) return 0;
    Facet f;
    if (!facet(wi, wo, f)) return 0;
    const float chance = (lobes & NON_DELTA_LOBES) == NON_DELTA_LOBES ? f.fresnel
                         : f.fresnel > 0                              ? 1.0f
                                                                      : 0.0f;
    if (reflection) return chance * facets.reflectionPdf(wi, f.m);
    return chance * facets.visibleDensity(wi, f.m) * f.jacobian;
  }

  /** Chooses wo; `pick` decides between reflection and transmission where both are allowed. */
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick,
                              LobeSet lobes = NON_DELTA_LOBES) const {
    const float side = wi.z > 0 ? 1.0f : -1.0f;
    Vec3f m = facets.sampleVisible({wi.x * side, wi.y * side, wi.z * side}, u) * side;
    const float c = glm::dot(wi, m), rel = relative(wi);
    if (!(c > 0)) return {};
    const DielectricFresnel f = dielectricFresnel(std::min(c, 1.0f), rel);
    const bool both = (lobes & NON_DELTA_LOBES) == NON_DELTA_LOBES;
    Vec3f wo;
    if (both ? pick < f.reflectance : (lobes & REFLECTION) != 0) {
      wo = mirrored(wi, m);
      if (!(wo.z * side > 0)) return {};
    } else {
      if (f.reflectance >= 1) return {};
      wo = m * (c / rel - f.cosTransmitted) - wi / rel;
      if (!(wo.z * side < 0)) return {};
    }
    return glm::normalize(wo);
  }

  /** Samples transmission or reflection alone. Smooth facets are allowed; their density is a delta. */
  std::optional<Step> step(const Vec3f& wi, const Vec2f& u, Lobe lobe) const {
    if (facets.smooth()) {
      const float rel = relative(wi);
      const DielectricFresnel f = dielectricFresnel(std::min(std::abs(wi.z), 1.0f), rel);
      if (lobe == REFLECTION) return Step{{-wi.x, -wi.y, wi.z}, f.reflectance};
      if (f.reflectance >= 1) return {};
      return Step{{-wi.x / rel, -wi.y / rel, -std::copysign(f.cosTransmitted, wi.z)}, 1 - f.reflectance};
    }
    const std::optional<Vec3f> wo = sample(wi, u, 0, lobe);
    if (!wo) return {};
    const float p = pdf(wi, *wo, lobe);
    if (!(p > 0)) return {};
    return Step{*wo, value(wi, *wo) * std::abs(wo->z) / p};
  }

  /** Adds the delta lobes of a smooth interface. */
  void deltas(const Vec3f& wi, DeltaScatters& out) const {
    const float rel = relative(wi);
    const DielectricFresnel f = dielectricFresnel(std::min(std::abs(wi.z), 1.0f), rel);
    if (f.reflectance > 0) out.add({{-wi.x, -wi.y, wi.z}, Rgb(f.reflectance), 1, MIRROR});
    if (f.reflectance < 1)
      out.add({{-wi.x / rel, -wi.y / rel, -std::copysign(f.cosTransmitted, wi.z)},
               Rgb(1 - f.reflectance),
               rel,
               REFRACTION});
  }

  /** Finds the facet; false where none scatters wi to wo. */
  bool facet(const Vec3f& wi, const Vec3f& wo, Facet& f) const {
    const float product = wi.z * wo.z;
    if (product > 0) {
      f.m = halfVector(wi, wo);
      if (wi.z < 0) f.m = -f.m;
      const float c = glm::dot(wi, f.m);
      const DielectricFresnel fresnel = dielectricFresnel(std::clamp(c, 0.0f, 1.0f), relative(wi));
      f.fresnel = fresnel.reflectance;
      f.cosAbove = wi.z > 0 ? std::min(c, 1.0f) : fresnel.cosTransmitted;
      return c > 0;
    }
    if (!(product < 0)) return false;
    // The facet is computed from the upper and lower direction, so that the reverse path finds it too.
    const Vec3f& up = wi.z > 0 ? wi : wo;
    const Vec3f& down = wi.z > 0 ? wo : wi;
    Vec3f m = up + down * eta;
    const float length2 = lengthSquared(m);
    if (!(length2 > 0)) return false;
    m /= std::sqrt(length2);
    if (m.z < 0) m = -m;
    const float cosUp = glm::dot(up, m), cosDown = -glm::dot(down, m);
    if (!(cosUp > 0 && cosDown > 0)) return false;
    // On the optically thinner side there is no critical angle, near which a rounded cosine is inaccurate.
    const DielectricFresnel fresnel = eta > 1 ? dielectricFresnel(std::min(cosUp, 1.0f), eta)
                                              : dielectricFresnel(std::min(cosDown, 1.0f), 1 / eta);
    f.fresnel = 1 - fresnel.reflectance;
    f.cosAbove = std::min(cosUp, 1.0f);
    f.jacobian = (wi.z > 0 ? cosDown * square(eta) : cosUp) / length2;
    f.m = wi.z < 0 ? -m : m;
    return true;
  }
};

/** Smooth dielectric interface, with delta lobes. */
class DielectricBsdf final : public Bsdf {
 public:
  explicit DielectricBsdf(float eta) : surface{eta, {}} {}
  LobeSet lobes() const override { return MIRROR | REFRACTION; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override { surface.deltas(wi, out); }
  bool lossless() const override { return true; }

 private:
  DielectricInterface surface;
};

/** Rough dielectric interface. */
class RoughDielectricBsdf : public Bsdf {
 public:
  explicit RoughDielectricBsdf(const DielectricInterface& surface) : surface(surface) {}
  LobeSet lobes() const override {
    return surface.facets.anisotropic() ? NON_DELTA_LOBES | ANISOTROPIC : NON_DELTA_LOBES;
  }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override { return Rgb(surface.value(wi, wo)); }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override { return surface.pdf(wi, wo); }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    return surface.sample(wi, u, pick);
  }
  Rgb albedo(const Vec3f&) const override { return Rgb(1); }
  float eta() const override { return surface.eta; }

 protected:
  ~RoughDielectricBsdf() = default;
  DielectricInterface surface;
};

/** Rough dielectric interface without light that hits several facets. */
class SingleScatteringDielectric final : public RoughDielectricBsdf {
 public:
  using RoughDielectricBsdf::RoughDielectricBsdf;
};

} // namespace recurse
