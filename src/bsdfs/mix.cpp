/** @file
 * A weighted sum of two materials.
 */
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

/** Lambertian where every part that scatters diffusely is. */
LobeSet lobesOfMix(LobeSet a, LobeSet b) {
  const LobeSet both = a | b;
  const auto constant = [](LobeSet l) { return !(l & DIFFUSE_LOBES) || (l & LAMBERTIAN); };
  return constant(a) && constant(b) ? both : LobeSet(both & ~LAMBERTIAN);
}

class MixBsdf final : public Bsdf {
 public:
  MixBsdf(const Bsdf* first, const Bsdf* second, float amount)
      : parts{first, second}, shares{1 - amount, amount} {}

  LobeSet lobes() const override { return lobesOfMix(parts[0]->lobes(), parts[1]->lobes()); }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    return parts[0]->value(wi, wo) * shares[0] + parts[1]->value(wi, wo) * shares[1];
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    const float second = chanceOfSecond(wi);
    return (second < 1 ? (1 - second) * parts[0]->pdf(wi, wo) : 0) +
           (second > 0 ? second * parts[1]->pdf(wi, wo) : 0);
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    // A Lambertian mix gets no third number; its parts have the same density, so that either will do.
    const float second = chanceOfSecond(wi);
    if (pick < second || second == 1)
      return parts[1]->sample(wi, u, second > 0 ? std::min(pick / second, ONE_MINUS_EPSILON) : 0);
    return parts[0]->sample(wi, u, std::min((pick - second) / (1 - second), ONE_MINUS_EPSILON));
  }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    for (size_t i = 0; i < 2; ++i) {
      DeltaScatters own;
      parts[i]->deltas(wi, own);
      for (DeltaScatter& d : own) {
        d.weight *= shares[i];
        merge(d, out);
      }
    }
  }
  Rgb albedo(const Vec3f& wi) const override {
    return parts[0]->albedo(wi) * shares[0] + parts[1]->albedo(wi) * shares[1];
  }

 private:
  /** Lobes in one direction are one lobe: the mirror direction does not depend on the material. */
  static void merge(const DeltaScatter& d, DeltaScatters& out) {
    for (DeltaScatter& o : out)
      if (o.lobe == d.lobe && o.eta == d.eta && o.wo == d.wo) {
        o.weight += d.weight;
        return;
      }
    out.add(d);
  }
  float chanceOfSecond(const Vec3f& wi) const {
    const float a = shares[0] * maxComponent(parts[0]->albedo(wi));
    const float b = shares[1] * maxComponent(parts[1]->albedo(wi));
    return a + b > 0 ? b / (a + b) : 0;
  }

  const Bsdf* parts[2];
  float shares[2];
};

class Mix final : public Material {
 public:
  Mix(const Material* first, const Material* second, const TexturedRgb& amount)
      : first(first), second(second), amount(amount) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const float a = std::clamp(amount.at(point).r, 0.0f, 1.0f);
    if (a == 0) return first->bsdfAt(point, arena);
    if (a == 1) return second->bsdfAt(point, arena);
    const Bsdf* x = first->bsdfAt(point, arena);
    const Bsdf* y = second->bsdfAt(point, arena);
    return arena.make<MixBsdf>(x, y, a);
  }
  LobeSet lobes() const override { return lobesOfMix(first->lobes(), second->lobes()); }

 private:
  const Material *first, *second;
  TexturedRgb amount;
};

} // namespace

void registerMix(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "mix",
        .summary = "A weighted sum of two named materials; all their lobes are followed.",
        .parameters =
            {arrayParameter(ParameterType::STRING, "materials", 2, "", "names of the two materials")
                 .require(),
             realParameter("amount", "0.5", "the part of the second material").range(0, 1).withTexture()},
        .examples = {}},
       [](const Parameters& p, const MaterialContext& c) {
         const std::vector<std::string> names = p.strings("materials");
         const Material* both[2] = {c.material(p, "materials", names[0]),
                                    c.material(p, "materials", names[1])};
         for (size_t i = 0; i < 2; ++i)
           if (both[i]->lobes() == NO_LOBE)
             p.fail("materials", "\"" + names[i] + "\" does not scatter and cannot be mixed");
         return std::make_unique<Mix>(both[0], both[1], c.textures.real(p, "amount"));
       }});
}

} // namespace recurse
