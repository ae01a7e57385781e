/** @file
 * BSDFs and materials: the plug-in interface of scattering. Transport directions, shading normals and cosines
 * are not a plug-in's business; ScatteringPoint (scatteringPoint.h) applies them in one place for both
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

/** Kinds of scattering, and sets of them. Delta lobes (MIRROR, REFRACTION) are S in path classes, the others
 * D. */
enum Lobe : uint16_t {
  NO_LOBE = 0,
  REFLECTION = 1,   ///< non-delta, to the side it came from
  TRANSMISSION = 2, ///< non-delta, to the other side
  MIRROR = 4,       ///< delta reflection
  REFRACTION = 8,   ///< delta transmission, with or without bending
  NON_DELTA_LOBES = REFLECTION | TRANSMISSION,
  DELTA_LOBES = MIRROR | REFRACTION,
  ALL_LOBES = NON_DELTA_LOBES | DELTA_LOBES,
  /** Besides REFLECTION, and without TRANSMISSION: value() is albedo/π on either side and sample() follows
   * the cosine, so that the constant may be factored out. */
  LAMBERTIAN = 16,
  /** Besides others: the x axis of the local frame lies along the surface's dpdu. */
  ANISOTROPIC = 32,
  /** Besides REFRACTION: it goes straight on, as through a thin pane, and shadow rays with it. */
  STRAIGHT = 64,
  /** Besides REFRACTION: it depends on SurfacePoint::wavelength. */
  DISPERSIVE = 128,
  /** Besides others: it scatters as a thread does. value(wi, wo) |wi.z| is bounded, value() is not, so that
   * no photons are kept there; and it is not reciprocal. */
  FIBRE = 256,
};
using LobeSet = uint16_t;

/** One delta lobe for a given wi. */
struct DeltaScatter {
  Vec3f wo{0, 0, 1}; ///< unit, local
  Rgb weight{0};     ///< the part of the flux that goes there, in [0, 1]
  float eta = 1;     ///< refractive index on the side of wo over that on the side of wi
  Lobe lobe = MIRROR;
};

/** The delta lobes for a given wi: a mirror direction and one refracted direction for each interface. */
struct DeltaScatters {
  static constexpr int MAX_COUNT = 4; ///< makers of materials see to it that there are no more
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
 * Scattering at one point, in the local frame: z is the shading normal, on the outer side of the surface.
 * Both directions are unit and point away from the surface: wi where the walk came from, wo where it goes on.
 * value is for flux that comes from wi and goes to wo; radiance is the same with both exchanged. It must be
 * reciprocal, transmission up to the refractive indices: value(a, b) n(a)² = value(b, a) n(b)²; only a FIBRE
 * need not be.
 */
class Bsdf {
 public:
  virtual LobeSet lobes() const = 0;
  /** The non-delta part of the BSDF [1/sr]; zero where it does not scatter. */
  virtual Rgb value(const Vec3f& /*wi*/, const Vec3f& /*wo*/) const { return BLACK; }
  /** The density with which sample() chooses wo [1/sr]. */
  virtual float pdf(const Vec3f& /*wi*/, const Vec3f& /*wo*/) const { return 0; }
  /** Chooses wo for the non-delta part from u in [0,1)² and `pick` in [0,1). Empty: absorbed. */
  virtual std::optional<Vec3f> sample(const Vec3f& /*wi*/, const Vec2f& /*u*/, float /*pick*/) const {
    return {};
  }
  /** All delta lobes for wi. */
  virtual void deltas(const Vec3f& /*wi*/, DeltaScatters& /*out*/) const {}
  /** The flux that the non-delta part scatters: exactly for LAMBERTIAN lobes, else nearly, as it only steers
   * the choice among lobes; not zero where there is any. */
  virtual Rgb albedo(const Vec3f& /*wi*/) const { return BLACK; }
  /** Refractive index below the surface over that above, by which the TRANSMISSION lobe bends. */
  virtual float eta() const { return 1; }
  bool isReciprocal() const { return !(lobes() & FIBRE); }
  /** True where nothing is absorbed, so that a white furnace stays white to within a hundredth. */
  virtual bool lossless() const { return false; }

 protected:
  ~Bsdf() = default; // lives in an arena that never destroys
};

/** Memory for BSDFs of a point, or of several. It keeps what it has got when it is reset. */
class BsdfArena {
 public:
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
  std::vector<std::unique_ptr<std::byte[]>> more; ///< deep mixes, or many points
};

/** A material of the scene: gives the BSDF of each point. Immutable. */
class Material {
 public:
  virtual ~Material() = default;
  /** Null where the surface does not scatter at all and rays pass straight through. */
  virtual const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const = 0;
  /** All lobes that any point may have: what a scene needs is read off this. */
  virtual LobeSet lobes() const = 0;
  /** How many directions of smooth refraction there are at one point. */
  virtual int refractions() const { return lobes() & REFRACTION ? 1 : 0; }
  /** Above 0: a solid that may overlap others, of which the one with the highest priority is there. Its BSDF
   * goes by the point's indexOutside. */
  virtual int priority() const { return 0; }
  /** The refractive index inside, of one with a priority. */
  virtual float indexInside() const { return 1; }

  std::shared_ptr<const SurfaceDetail> detail; ///< to be applied before bsdfAt; null: none
  std::unique_ptr<const Texture> opacity;      ///< in the place of a shape's alpha; null: that counts
  /** The medium inside of shapes of the material, as a directive of a medium says it; null: the one that
   * their MediumInterface says. */
  std::unique_ptr<const ParsedDirective> filling;
  int nesting = -1; ///< place among the scene's solids with priority, the strongest first; -1: has none.
                    ///< Those with the same priority and index are one matter
};

/** What makers of materials are given besides parameters. */
struct MaterialContext {
  const TextureLookup& textures;
  /** A named material that was declared or will be; throws SceneError, with the place, for others and for
   * cycles. */
  std::function<const Material*(const Parameters&, const std::string& parameter, const std::string& name)>
      material;
};

} // namespace recurse
