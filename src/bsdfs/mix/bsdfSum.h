/** @file
 * Weighted sums of BSDFs with delta and non-delta lobes: the scattering of `mix` and `compound`.
 */
#pragma once

#include "recurse/model/bsdf/bsdf.h"

namespace recurse {

/** Lobes of a sum. It is Lambertian where every component with non-delta lobes is, and straight where
 * every component that refracts is. */
inline LobeSet lobesOfSum(LobeSet a, LobeSet b) {
  LobeSet both = a | b;
  const auto constant = [](LobeSet l) { return !(l & NON_DELTA_LOBES) || (l & LAMBERTIAN); };
  const auto straight = [](LobeSet l) { return !(l & REFRACTION) || (l & STRAIGHT); };
  if (!constant(a) || !constant(b)) both &= ~LAMBERTIAN;
  if (!straight(a) || !straight(b)) both &= ~STRAIGHT;
  return both;
}

class BsdfSum final : public Bsdf {
 public:
  static constexpr int MAX_COUNT = 8;
  /** Weights are in [0, 1] and add up to at most 1. Null components and black weights are skipped. */
  void add(const Bsdf* part, const Rgb& weight) {
    if (!part || isBlack(weight)) return;
    parts[count] = part;
    weights[count++] = weight;
    lobeSet = count == 1 ? part->lobes() : lobesOfSum(lobeSet, part->lobes());
  }
  int size() const { return count; }

  LobeSet lobes() const override { return lobeSet; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    Rgb sum(0);
    for (int i = 0; i < count; ++i) sum += parts[i]->value(wi, wo) * weights[i];
    return sum;
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    std::array<float, MAX_COUNT> chances;
    const float total = shares(wi, chances);
    float sum = 0;
    for (int i = 0; i < count; ++i)
      if (chances[size_t(i)] > 0) sum += chances[size_t(i)] / total * parts[i]->pdf(wi, wo);
    return sum;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    // A Lambertian sum gets no third number; all its components have one density, so that any is valid.
    std::array<float, MAX_COUNT> chances;
    float rest = pick * shares(wi, chances);
    int chosen = -1;
    for (int i = 0; i < count; ++i) {
      const float share = chances[size_t(i)];
      if (!(share > 0)) continue;
      chosen = i;
      if (rest < share) break;
      rest -= share;
    }
    if (chosen < 0) return {};
    return parts[chosen]->sample(wi, u, std::clamp(rest / chances[size_t(chosen)], 0.0f, ONE_MINUS_EPSILON));
  }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    for (int i = 0; i < count; ++i) {
      DeltaScatters own;
      parts[i]->deltas(wi, own);
      for (DeltaScatter& d : own) {
        d.weight *= weights[i];
        merge(d, out);
      }
    }
  }
  Rgb albedo(const Vec3f& wi) const override {
    Rgb sum(0);
    for (int i = 0; i < count; ++i) sum += parts[i]->albedo(wi) * weights[i];
    return sum;
  }
  /** Relative index of the first component that transmits. */
  float eta() const override {
    for (int i = 0; i < count; ++i)
      if (parts[i]->lobes() & TRANSMISSION) return parts[i]->eta();
    return 1;
  }
  bool lossless() const override {
    Rgb sum(0);
    for (int i = 0; i < count; ++i) {
      if (!parts[i]->lossless()) return false;
      sum += weights[i];
    }
    return std::min({sum.r, sum.g, sum.b}) > 0.999f;
  }

 private:
  /** Adds a delta lobe to an identical one (same lobe, eta and direction), else to the list. */
  static void merge(const DeltaScatter& d, DeltaScatters& out) {
    for (DeltaScatter& o : out)
      if (o.lobe == d.lobe && o.eta == d.eta && o.wo == d.wo) {
        o.weight += d.weight;
        return;
      }
    out.add(d);
  }
  /** Weighted albedo of the non-delta lobes of each component for wi; returns the sum. */
  float shares(const Vec3f& wi, std::array<float, MAX_COUNT>& out) const {
    float total = 0;
    for (int i = 0; i < count; ++i) {
      const bool scatters = (parts[i]->lobes() & NON_DELTA_LOBES) != 0;
      total += out[size_t(i)] = scatters ? maxComponent(parts[i]->albedo(wi) * weights[i]) : 0;
    }
    return total;
  }

  const Bsdf* parts[MAX_COUNT] = {};
  Rgb weights[MAX_COUNT];
  int count = 0;
  LobeSet lobeSet = NO_LOBE;
};

} // namespace recurse
