/** @file
 * Microfacet distributions (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces";
 * Heitz 2014, "Understanding the Masking-Shadowing Function"), and sampling of visible normals (Dupuy and
 * Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"; Jakob 2014, "An Improved Visible Normal
 * Sampling Routine", for Beckmann). Directions are local with normal z; only |z| counts.
 */
#pragma once

#include "recurse/core/sampling/sampling.h"

namespace recurse {

enum class MicrofacetKind { TROWBRIDGE_REITZ, BECKMANN };

/** Microfacet distribution at one point, with alpha along x and y. */
class Microfacets {
 public:
  /** Alpha below which, along both axes, the surface is a mirror, as in pbrt-v4. Float directions cannot
   * distinguish such a lobe from its limit. */
  static constexpr float SMOOTH_BELOW = 1e-3f;

  Microfacets() = default;
  Microfacets(MicrofacetKind kind, const Vec2f& alpha) : kind(kind), alpha(alpha) {
    // Lower bound of pbrt-v4 for a small alpha beside a large one.
    if (!smooth()) this->alpha = glm::max(alpha, Vec2f(1e-4f));
  }

  bool smooth() const { return !(std::max(alpha.x, alpha.y) >= SMOOTH_BELOW); }
  bool anisotropic() const { return alpha.x != alpha.y; }
  const Vec2f& roughness() const { return alpha; }
  /** Isotropic alpha whose lobe has the same extent. */
  float meanRoughness() const { return std::sqrt(alpha.x * alpha.y); }

  /** D(m) of a unit normal [1/sr]: the integral of D cos over the hemisphere is 1. */
  float density(const Vec3f& m) const {
    const float e = square(m.x / alpha.x) + square(m.y / alpha.y), z2 = square(m.z);
    if (kind == MicrofacetKind::TROWBRIDGE_REITZ) return INV_PI / (alpha.x * alpha.y * square(e + z2));
    const float x = z2 > 0 ? std::exp(-e / z2) : 0;
    return x > 0 ? x * INV_PI / (alpha.x * alpha.y * square(z2)) : 0;
  }

  /** |w.z| / G1(w) = |w.z| (1 + Lambda(w)): finite at grazing directions too. */
  float shadowed(const Vec3f& w) const {
    const float z = std::abs(w.z), spread2 = square(alpha.x * w.x) + square(alpha.y * w.y);
    if (kind == MicrofacetKind::TROWBRIDGE_REITZ) return 0.5f * (z + std::sqrt(square(z) + spread2));
    const float spread = std::sqrt(spread2);
    if (z >= 5 * spread) return z; // Lambda < 1e-12
    const float a = z / spread;
    return z + 0.5f * (spread * std::exp(-square(a)) * INV_SQRT_PI - z * std::erfc(a));
  }
  /** G1: fraction of the facets facing w that are visible from w. */
  float g1(const Vec3f& w) const {
    const float s = shadowed(w);
    return s > 0 ? std::abs(w.z) / s : 0;
  }
  /** G2 / |a.z b.z| with Smith's height-correlated G2 (Heitz 2014, equation 99). */
  float shadowedPair(const Vec3f& a, const Vec3f& b) const {
    const float za = std::abs(a.z), zb = std::abs(b.z);
    const float d = zb * shadowed(a) + za * shadowed(b) - za * zb;
    return d > 0 ? 1 / d : 0;
  }
  /** Density of sampleVisible for a unit m that faces w [1/sr]. */
  float visibleDensity(const Vec3f& w, const Vec3f& m) const {
    const float s = shadowed(w);
    return s > 0 ? density(m) * absDot(w, m) / s : 0;
  }

  /** Samples a visible unit normal with z > 0, for a direction w with z > 0. */
  Vec3f sampleVisible(const Vec3f& w, const Vec2f& u) const {
    const Vec3f stretched = glm::normalize(Vec3f(alpha.x * w.x, alpha.y * w.y, w.z));
    if (kind == MicrofacetKind::TROWBRIDGE_REITZ) {
      // On the unit hemisphere the normals are halfway between w and a uniform point of the spherical cap.
      const float below = u.y * (1 + stretched.z); // 1 - z of that point
      const float r = std::sqrt(std::max(0.0f, below * (2 - below))), phi = 2 * PI * u.x;
      return glm::normalize(Vec3f(alpha.x * (stretched.x + r * std::cos(phi)),
                                  alpha.y * (stretched.y + r * std::sin(phi)),
                                  std::max(1e-12f, (1 + stretched.z) * (1 - u.y))));
    }
    const float sine = std::hypot(stretched.x, stretched.y);
    const Vec2f towards = sine > 0 ? Vec2f(stretched) / sine : Vec2f(1, 0);
    const float along = visibleBeckmannSlope(stretched.z, sine, u.x);
    const float across = inverseErf(2 * u.y - 1);
    const Vec2f slope = towards * along + Vec2f(-towards.y, towards.x) * across;
    return glm::normalize(Vec3f(-alpha.x * slope.x, -alpha.y * slope.y, 1));
  }

  // Mirror reflection at the facets, for directions on one side.

  /** BRDF of perfect mirrors, D G2 / (4 |a.z b.z|): multiply by Fresnel's reflectance at dot(a, m). */
  float reflection(const Vec3f& a, const Vec3f& b, const Vec3f& m) const {
    return 0.25f * density(m) * shadowedPair(a, b);
  }
  /** Density of w mirrored at a normal m of sampleVisible [1/sr]. */
  float reflectionPdf(const Vec3f& w, const Vec3f& m) const {
    const float s = shadowed(w);
    return s > 0 ? 0.25f * density(m) / s : 0;
  }

 private:
  static constexpr float INV_SQRT_PI = 0.56418958354775628695f;

  /** Inverse of erf (Giles 2010, "Approximating the erfinv function", single precision). */
  static float inverseErf(float y) {
    float w = -std::log(std::max((1 - y) * (1 + y), 1e-30f)), p;
    if (w < 5) {
      w -= 2.5f;
      p = 2.81022636e-08f;
      for (const float c : {3.43273939e-07f, -3.5233877e-06f, -4.39150654e-06f, 0.00021858087f,
                            -0.00125372503f, -0.00417768164f, 0.246640727f, 1.50140941f})
        p = c + p * w;
    } else {
      w = std::sqrt(w) - 3;
      p = -0.000200214257f;
      for (const float c : {0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f, -0.0076224613f,
                            0.00943887047f, 1.00167406f, 2.83297682f})
        p = c + p * w;
    }
    return p * y;
  }

  /**
   * The slope x in the plane of incidence for alpha 1, with density max(0, cos - x sin) exp(-x²): its
   * cumulative distribution cos (1 + erf x) / 2 + sin exp(-x²) / (2 sqrt π) is inverted by Newton steps that
   * are kept inside a bracket.
   */
  static float visibleBeckmannSlope(float cosine, float sine, float u) {
    const auto cumulative = [&](float x) {
      return 0.5f * (cosine * std::erfc(-x) + sine * INV_SQRT_PI * std::exp(-square(x)));
    };
    constexpr float FAR = 6; // exp(-36) is nothing
    float low = -FAR, high = cosine < FAR * sine ? cosine / sine : FAR;
    const float wanted = u * cumulative(high);
    float x = std::clamp(inverseErf(2 * u - 1), low, high);
    for (int i = 0; i < 32; ++i) {
      const float excess = cumulative(x) - wanted;
      (excess > 0 ? high : low) = x;
      const float slope = (cosine - x * sine) * INV_SQRT_PI * std::exp(-square(x));
      float next = x - excess / slope;
      if (!(next > low && next < high)) next = 0.5f * (low + high);
      if (std::abs(next - x) <= 1e-6f * (1 + std::abs(x))) return next;
      x = next;
    }
    return x;
  }

  MicrofacetKind kind = MicrofacetKind::TROWBRIDGE_REITZ;
  Vec2f alpha{0};
};

/** Unit half vector with z > 0 of two directions on one side of the surface. */
inline Vec3f halfVector(const Vec3f& a, const Vec3f& b) {
  Vec3f h = a + b;
  if (std::abs(h.z) < 0.25f) {
    // Near the plane, x and y of both directions almost cancel and rounding dominates the sum. Their length
    // follows more accurately from z and the unit length.
    const auto horizontal = [](const Vec3f& w) {
      const Vec2d p(w);
      return p * std::sqrt((1 - square(double(w.z))) / glm::dot(p, p));
    };
    h = Vec3f(Vec2f(horizontal(a) + horizontal(b)), h.z);
  }
  h = glm::normalize(h);
  return h.z < 0 ? -h : h;
}

/** w mirrored at the unit normal m. */
inline Vec3f mirrored(const Vec3f& w, const Vec3f& m) { return m * (2 * glm::dot(w, m)) - w; }

} // namespace recurse
