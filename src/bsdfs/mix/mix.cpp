/** @file
 * Weighted sums of materials: `mix` of two, as in pbrt-v4, and `compound` of any number.
 */
#include <algorithm>
#include <bit>
#include <utility>

#include "bsdfs/mix/bsdfSum.h"
#include "recurse/model/bsdf/surfaceDetail.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

using Parts = std::vector<const Material*>;

bool isInterface(const Material* m) { return m->lobes() == NO_LOBE; }

LobeSet lobesOf(const Parts& parts) {
  LobeSet all = NO_LOBE;
  for (const Material* m : parts) {
    if (isInterface(m)) continue;
    all = all == NO_LOBE ? m->lobes() : lobesOfSum(all, m->lobes());
  }
  return all;
}

int refractionsOf(const Parts& parts) {
  int n = 0;
  for (const Material* m : parts) n += m->refractions();
  return n;
}

/** Lobes and refractions of any mix, computed once: components may be mixes, many levels deep. */
class MaterialOfParts : public Material {
 public:
  explicit MaterialOfParts(const Parts& parts)
      : parts(parts), allLobes(lobesOf(parts)), allRefractions(refractionsOf(parts)) {}
  LobeSet lobes() const override { return allLobes; }
  int refractions() const override { return allRefractions; }

 protected:
  Parts parts;

 private:
  LobeSet allLobes;
  int allRefractions;
};

/** Coverage of a surface by each component of a mix. `interface` covers nothing, and components that are
 * mixes with it have holes themselves. */
class Coverage {
 public:
  Coverage(const Parts& parts, const TexturedRgb& amount)
      : parts(parts), amount(amount), holes(std::any_of(parts.begin(), parts.end(), [](const Material* m) {
          return isInterface(m) || m->opacity;
        })) {}
  bool hasHoles() const { return holes; }
  float opacity(const SurfacePoint& point) const {
    const auto [first, second] = ofParts(point);
    return first + second;
  }
  /** Fraction of the covered area that belongs to the second component. */
  float second(const SurfacePoint& point) const {
    if (!holes) return amount.at(point).r;
    const auto [first, second] = ofParts(point);
    if (first + second == 0) return isInterface(parts[0]) ? 1 : 0;
    return second / (first + second);
  }

 private:
  static float ofPart(const Material* m, const SurfacePoint& point) {
    if (isInterface(m)) return 0;
    return m->opacity ? m->opacity->value(point).r : 1;
  }
  std::pair<float, float> ofParts(const SurfacePoint& point) const {
    const float a = amount.at(point).r;
    return {(1 - a) * ofPart(parts[0], point), a * ofPart(parts[1], point)};
  }

  Parts parts;
  TexturedRgb amount;
  bool holes;
};

class Mix final : public MaterialOfParts {
 public:
  Mix(const Parts& parts, Coverage coverage) : MaterialOfParts(parts), coverage(std::move(coverage)) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const float a = coverage.second(point);
    if (a == 0) return parts[0]->bsdfAt(point, arena);
    if (a == 1) return parts[1]->bsdfAt(point, arena);
    BsdfSum sum;
    sum.add(parts[0]->bsdfAt(point, arena), Rgb(1 - a));
    sum.add(parts[1]->bsdfAt(point, arena), Rgb(a));
    return arena.make<BsdfSum>(sum);
  }

 private:
  Coverage coverage;
};

/** Choice of one of two materials at each point, by a hash of its position. Where they have bumps, each
 * shading frame belongs to one material, as in pbrt-v4. */
class Choice {
 public:
  /** `level`: levels of mixes that choose inside of the parts. Their choices are independent of this one. */
  Choice(Parts parts, Coverage coverage, uint64_t level)
      : parts(std::move(parts)), coverage(std::move(coverage)), level(level) {}
  const Material& at(const SurfacePoint& point) const {
    uint64_t h = level;
    for (int i = 0; i < 3; ++i) h = hashCombine(h, std::bit_cast<uint32_t>(point.position[i]));
    return *parts[unitFloat(static_cast<uint32_t>(h >> 32)) < coverage.second(point) ? 1 : 0];
  }
  /** Probability that the chosen material keeps photons, if any does. */
  float chanceOfPhotons(const SurfacePoint& point) const {
    const auto keeps = [&](size_t i) { return (parts[i]->lobes() & NON_DELTA_LOBES) != 0; };
    if (keeps(0) == keeps(1)) return 1;
    return keeps(1) ? coverage.second(point) : 1 - coverage.second(point);
  }

 private:
  Parts parts;
  Coverage coverage;
  uint64_t level;
};

class ChosenDetail final : public SurfaceDetail {
 public:
  explicit ChosenDetail(Choice choice) : choice(std::move(choice)) {}
  void apply(SurfacePoint& point) const override {
    const Material& chosen = choice.at(point);
    // Camera rays read the photons of all points where the chosen material reads any.
    if (const float chance = choice.chanceOfPhotons(point); chance > 0) point.alpha *= chance;
    if (chosen.detail) chosen.detail->apply(point);
  }

 private:
  Choice choice;
};

class ChosenMaterial final : public MaterialOfParts {
 public:
  ChosenMaterial(const Parts& parts, const Coverage& coverage)
      : MaterialOfParts(parts), level(levelAbove(parts)), choice(parts, coverage, level) {
    detail = std::make_unique<ChosenDetail>(choice);
  }
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    return choice.at(point).bsdfAt(point, arena);
  }

 private:
  static uint64_t levelAbove(const Parts& parts) {
    uint64_t level = 0;
    for (const Material* m : parts)
      if (const auto* chosen = dynamic_cast<const ChosenMaterial*>(m))
        level = std::max(level, chosen->level + 1);
    return level;
  }

  uint64_t level; ///< see Choice
  Choice choice;
};

/** Opacity of a mix with holes, used like an alpha texture. */
class Opacity final : public Texture {
 public:
  explicit Opacity(Coverage coverage) : coverage(std::move(coverage)) {}
  Rgb value(const SurfacePoint& point) const override { return Rgb(coverage.opacity(point)); }

 private:
  Coverage coverage;
};

class Compound final : public MaterialOfParts {
 public:
  Compound(const Parts& parts, std::vector<Rgb> weights)
      : MaterialOfParts(parts), weights(std::move(weights)) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    BsdfSum sum;
    for (size_t i = 0; i < parts.size(); ++i) sum.add(parts[i]->bsdfAt(point, arena), weights[i]);
    return arena.make<BsdfSum>(sum);
  }

 private:
  std::vector<Rgb> weights;
};

/** Materials that the parameter `materials` names. */
Parts namedParts(const Parameters& p, const MaterialContext& c, size_t mostInterfaces) {
  Parts parts;
  for (const std::string& name : p.strings("materials")) {
    parts.push_back(c.material(p, "materials", name));
    if (size_t(std::count_if(parts.begin(), parts.end(), isInterface)) > mostInterfaces)
      p.fail("materials", "\"" + name + "\" does not scatter and cannot be used in a sum");
  }
  // One entry is for the mirror direction, which all components share.
  if (refractionsOf(parts) > DeltaScatters::MAX_COUNT - 1)
    p.fail("materials", "more materials with smooth refraction than a sum supports",
           "at most " + std::to_string(DeltaScatters::MAX_COUNT - 1));
  return parts;
}

} // namespace

void registerMix(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "mix",
        .summary = "A weighted sum of two named materials with all their lobes. If one has bumps, each hit "
                   "chooses one of them at random; with `interface` the surface has holes, as with `alpha`.",
        .parameters =
            {arrayParameter(ParameterType::STRING, "materials", 2, "", "names of the two materials")
                 .require(),
             realParameter("amount", "0.5", "weight of the second material").range(0, 1).withTexture()},
        .examples = {"\"string materials\" [\"red\" \"gold\"] \"float amount\" .3",
                     "\"string materials\" [\"glass\" \"red\"] \"float amount\" .6",
                     "\"string materials\" [\"glass\" \"gold\"]",
                     "\"string materials\" [\"red\" \"frosted\"]",
                     "\"string materials\" [\"brushed\" \"glass\"] \"float amount\" .7"}},
       [](const Parameters& p, const MaterialContext& c) {
         const Parts parts = namedParts(p, c, 1);
         const Coverage coverage(parts, c.textures.real(p, "amount"));
         const auto hasBumps = [](const Material* m) { return m->detail != nullptr; };
         std::unique_ptr<Material> made;
         if (std::any_of(parts.begin(), parts.end(), hasBumps))
           made = std::make_unique<ChosenMaterial>(parts, coverage);
         else
           made = std::make_unique<Mix>(parts, coverage);
         if (coverage.hasHoles()) made->opacity = std::make_unique<Opacity>(coverage);
         return made;
       }});
  plugIns.materials.add(
      {{.name = "compound",
        .summary = "A weighted sum of named materials. In path classes their mirror and glass lobes are S, "
                   "the others D.",
        .parameters = {arrayParameter(ParameterType::STRING, "materials", 0, "",
                                      "names of the materials, 8 at most")
                           .require(),
                       arrayParameter(ParameterType::SPECTRUM, "weights", 0, "",
                                      "weight of each material as a colour; the sum may be at most 1")
                           .require()},
        .examples = {"\"string materials\" [\"red\" \"gold\" \"glass\"] "
                     "\"rgb weights\" [.5 .5 .5  .2 .3 .2  .3 .2 .3]",
                     "\"string materials\" [\"brushed\" \"red\" \"gold\" \"frosted\"] "
                     "\"rgb weights\" [.3 .3 .1  .1 .2 .3  .3 .3 .3  .2 .1 .2]"}},
       [](const Parameters& p, const MaterialContext& c) {
         const Parts parts = namedParts(p, c, 0);
         std::vector<Rgb> weights;
         Rgbd total(0);
         for (const Rgbd& w : p.spectra("weights")) {
           weights.emplace_back(w);
           total += w;
         }
         if (parts.empty() || parts.size() > BsdfSum::MAX_COUNT)
           p.fail("materials", "a compound has 1 to " + std::to_string(BsdfSum::MAX_COUNT) + " materials");
         if (weights.size() != parts.size())
           p.fail("weights",
                  "there are " + std::to_string(weights.size()) + " weights for " +
                      std::to_string(parts.size()) + " materials",
                  "one for each");
         if (std::max({total.r, total.g, total.b}) > 1 + 1e-6)
           p.fail("weights", "the weights add up to more than 1: more light would leave than arrives");
         return std::make_unique<Compound>(parts, std::move(weights));
       }});
}

} // namespace recurse
