/** @file
 * BSDFs and materials: the plug-in interface of scattering. Plug-ins do not deal with transport directions,
 * shading normals and cosines; ScatteringPoint (scatteringPoint.h) applies these in one place for both
 * passes.
 */
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <type_traits>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

class SurfaceDetail; // surfaceDetail.h

/** Kinds of scattering, and sets of them. Delta lobes (MIRROR, REFRACTION) are S in path classes, non-delta
 * lobes are D. */
enum Lobe : uint16_t {
  NO_LOBE = 0,
  REFLECTION = 1,   ///< non-delta, to the side of the incident direction
  TRANSMISSION = 2, ///< non-delta, to the opposite side
  MIRROR = 4,       ///< delta reflection
  REFRACTION = 8,   ///< delta transmission, with or without bending
  NON_DELTA_LOBES = REFLECTION | TRANSMISSION,
  DELTA_LOBES = MIRROR | REFRACTION,
  ALL_LOBES = NON_DELTA_LOBES | DELTA_LOBES,
  /** Modifier of REFLECTION without TRANSMISSION: value() is the constant albedo/π where wi and wo are on the
   * same side, above or below, and sample() is cosine-weighted. ScatteringPoint caches the constant. */
  LAMBERTIAN = 16,
  /** Modifier: the x axis of the local frame is aligned with the surface's dpdu. */
  ANISOTROPIC = 32,
  /** Modifier of REFRACTION: passes straight through, as in a thin pane, and so do shadow rays. */
  STRAIGHT = 64,
  /** Modifier of REFRACTION: depends on SurfacePoint::wavelength. */
  DISPERSIVE = 128,
  /** Modifier: scatters like a fibre. value(wi, wo) |wi.z| is bounded but value() is not, so that no photons
   * are stored there; and the BSDF is not reciprocal. */
  FIBRE = 256,
};
using LobeSet = uint16_t;

/** One delta lobe for a given wi. */
struct DeltaScatter {
  Vec3f wo{0, 0, 1}; ///< unit, local
  Rgb weight{0};     ///< fraction of the flux scattered into the lobe, in [0, 1]
  float eta = 1;     ///< refractive index on the side of wo over that on the side of wi
  Lobe lobe = MIRROR;
};

/** Delta lobes for a given wi: a mirror direction, and one refracted direction for each interface. */
struct DeltaScatters {
  static constexpr int MAX_COUNT = 4; ///< makers of materials ensure this limit; add() drops more
  std::array<DeltaScatter, MAX_COUNT> entries;
  int count = 0;
  void add(const DeltaScatter& d) {
    if (count < MAX_COUNT) entries[static_cast<size_t>(count++)] = d;
  }
  const DeltaScatter* begin() const { return entries.data(); }
  const DeltaScatter* end() const { return entries.data() + count; }
  DeltaScatter* begin() { return entries.data(); }
  DeltaScatter* end() { return entries.data() + count; }
};

/**
 * Scattering at one point, in the local frame: z is the shading normal, on the outer side of the surface; on
 * the inner side z < 0. Both directions are unit and point away from the surface: wi to the previous vertex
 * of the walk, wo to the next one. value(wi, wo) is for light that arrives from wi and leaves towards wo; for
 * camera paths ScatteringPoint calls value(wo, wi). The BSDF must be reciprocal up to the refractive indices
 * (Veach 1997, section 5.2): value(a, b) n(a)² = value(b, a) n(b)², with n(a) on the side of a. Only a FIBRE
 * need not be.
 */
class Bsdf {
 public:
  virtual LobeSet lobes() const = 0;
  /** Non-delta part of the BSDF [1/sr]; zero for pairs of directions without scattering. */
  virtual Rgb value(const Vec3f& /*wi*/, const Vec3f& /*wo*/) const { return BLACK; }
  /** Density of wo in sample() [1/sr]. */
  virtual float pdf(const Vec3f& /*wi*/, const Vec3f& /*wo*/) const { return 0; }
  /** Samples unit wo with the density pdf(), by u in [0,1)² and a further number `pick` in [0,1), which may
   * choose a part of the BSDF. Empty: absorbed. */
  virtual std::optional<Vec3f> sample(const Vec3f& /*wi*/, const Vec2f& /*u*/, float /*pick*/) const {
    return {};
  }
  /** Appends all delta lobes for wi. */
  virtual void deltas(const Vec3f& /*wi*/, DeltaScatters& /*out*/) const {}
  /** Fraction of the flux from wi that the non-delta part scatters. Exact for LAMBERTIAN lobes. For
   * others an approximation suffices, since it only steers their choice, but not zero where they scatter. */
  virtual Rgb albedo(const Vec3f& /*wi*/) const { return BLACK; }
  /** Refractive index below the surface over the index above, for the bending of the TRANSMISSION lobe. */
  virtual float eta() const { return 1; }
  bool isReciprocal() const { return !(lobes() & FIBRE); }
  /** True where nothing is absorbed, so that a white furnace stays white to within 1 %. */
  virtual bool lossless() const { return false; }

 protected:
  ~Bsdf() = default; // objects live in an arena that calls no destructors
};

/** Memory for the BSDFs of one or several points, which are valid until reset(). reset() keeps the allocated
 * blocks. Belongs to one thread, and must not be moved, since it refers to itself. */
class BsdfArena {
 public:
  BsdfArena() = default;
  BsdfArena(const BsdfArena&) = delete; // `block` may point into the object itself
  BsdfArena& operator=(const BsdfArena&) = delete;
  template <class T, class... Arguments> const T* make(Arguments&&... arguments) {
    static_assert(std::is_trivially_destructible_v<T>);
    static_assert(sizeof(T) <= BLOCK && alignof(T) <= alignof(std::max_align_t));
    return new (allocate(sizeof(T), alignof(T))) T(std::forward<Arguments>(arguments)...);
  }
  void reset() {
    used = 0;
    block = inlined;
    nextBlock = 0;
  }

 private:
  static constexpr size_t BLOCK = 2048;

  void* allocate(size_t size, size_t alignment) {
    size_t begin = (used + alignment - 1) / alignment * alignment;
    if (begin + size > BLOCK) {
      if (nextBlock == more.size()) more.push_back(std::make_unique<std::byte[]>(BLOCK));
      block = more[nextBlock++].get();
      begin = 0;
    }
    used = begin + size;
    return block + begin;
  }
  alignas(std::max_align_t) std::byte inlined[BLOCK];
  std::byte* block = inlined;
  size_t used = 0, nextBlock = 0;
  std::vector<std::unique_ptr<std::byte[]>> more; ///< further blocks, for deep mixes or many points
};

/** Material of the scene: makes the BSDF of each point. Immutable; any thread may call it. */
class Material {
 public:
  virtual ~Material() = default;
  /** BSDF at a point, made in the arena. The caller has applied `detail` to the point. Null: the surface does
   * not scatter, and rays pass straight through. */
  virtual const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const = 0;
  /** Union of the lobes at all points; determines the features that the scene needs. LAMBERTIAN and STRAIGHT
   * are included only if they hold at all points with the lobe that they modify. NO_LOBE: no scattering. */
  virtual LobeSet lobes() const = 0;
  /** Maximum number of directions of smooth refraction at one point. */
  virtual int refractions() const { return lobes() & REFRACTION ? 1 : 0; }
  /** Priority of nested dielectrics. Above 0: a solid that may overlap others; where solids overlap, only the
   * one of highest priority exists. Its BSDF uses the point's indexOutside. */
  virtual int priority() const { return 0; }
  /** Refractive index inside of a closed shape: absolute with a priority, else relative to the outside. */
  virtual float indexInside() const { return 1; }

  std::shared_ptr<const SurfaceDetail> detail; ///< applied before bsdfAt; null: none
  /** Alpha of shapes, in red; an alpha of their own below 1 is an error then. Null: their alpha is used. */
  std::unique_ptr<const Texture> opacity;
  /** Medium inside of shapes of the material, as a directive describes it; null: the medium of their
   * MediumInterface. */
  std::unique_ptr<const ParsedDirective> filling;
  uint32_t number = 0; ///< index in Scene::materialLabels()
  int nesting = -1;    ///< index among the scene's solids with priority, highest priority first; -1: no
                       ///< priority. Solids of equal priority, refractive index and medium share one index
};

/** Arguments of makers of materials besides parameters; both are valid during construction only. */
struct MaterialContext {
  const TextureLookup& textures;
  /** Finds a named material, declared before or after. The result belongs to the scene, and is never null.
   * Throws SceneError at the parameter for an unknown name, a cycle, and a material that cannot be a part of
   * others. */
  std::function<const Material*(const Parameters&, const std::string& parameter, const std::string& name)>
      material;
};

} // namespace recurse
