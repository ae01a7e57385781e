/** @file
 * Sampling and learning of the mixture of emission.
 */
#include "transport/emission/emissionMixture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "recurse/core/math/cone.h"

namespace recurse {

namespace {

/** Probability of the lights' own sampling before anything is learned. */
constexpr float OWN_PART = 0.5f;
/** Part of all probabilities that is not learned, for paths that no trial photon has found. */
constexpr float UNLEARNED = 0.2f;
/** Maximum number of groups of lights of a kind. */
constexpr size_t MAX_GROUPS = 256;

/** Origin of a ray on the silhouette of a box, at the scene's disc. `pick` and `u` are in [0, 1). */
Vec3f originThrough(const Bounds3f& box, const SceneBounds& scene, const Vec3f& w, float pick,
                    const Vec2f& u) {
  // Samples a side that faces the light, in proportion to its projected area.
  const Vec3f d = box.diagonal(), a = magnitude(w);
  const Vec3f sides(a.x * d.y * d.z, a.y * d.z * d.x, a.z * d.x * d.y);
  float remaining = pick * (sides.x + sides.y + sides.z);
  int axis = 0;
  while (axis < 2 && (remaining >= sides[axis] || sides[axis] == 0)) remaining -= sides[axis++];
  Vec3f point = box.lower;
  if (w[axis] < 0) point[axis] = box.upper[axis];
  point[(axis + 1) % 3] += u.x * d[(axis + 1) % 3];
  point[(axis + 2) % 3] += u.y * d[(axis + 2) % 3];
  return point - w * (glm::dot(point - scene.center, w) + scene.radius);
}

float ownDensity(const Light& light, const LePdf& pdf) {
  return light.isInfinite() ? pdf.position : pdf.direction;
}

} // namespace

EmissionMixture::EmissionMixture(const Scene& scene, uint64_t seed, TransportCounts& counts)
    : bounds(scene.bounds()) {
  if (scene.lights().size() == 0) return;
  boxes.learn(scene, seed, counts);
  if (!boxes.empty()) gather(scene);
}

void EmissionMixture::gather(const Scene& scene) {
  const LightTable& all = scene.lights();
  const auto isInfinite = [&](size_t i) { return all[i].isInfinite(); };
  groupOfLight.resize(all.size());
  for (const bool infinite : {false, true}) {
    size_t count = 0, index = 0;
    for (size_t i = 0; i < all.size(); ++i) count += isInfinite(i) == infinite;
    if (count == 0) continue;
    const size_t first = groups.size(), groupCount = std::min(count, MAX_GROUPS);
    Group group;
    group.firstBlock = infinite ? 0 : boxes.exitBlocks;
    group.chances.assign(boxes.chances.begin() + static_cast<std::ptrdiff_t>(8 * group.firstBlock),
                         boxes.chances.end());
    const bool hasBoth = infinite && boxes.exitBlocks > 0;
    for (float& chance : group.chances) chance *= (1 - OWN_PART) / (hasBoth ? 2 : 1);
    group.lightSamplingProbability = OWN_PART;
    group.firstGuess = group.chances;
    groups.resize(first + groupCount, group);
    for (size_t i = 0; i < all.size(); ++i)
      if (isInfinite(i) == infinite)
        groupOfLight[i] = static_cast<uint32_t>(first + index++ * groupCount / count);
  }
  for (size_t i = 0; i < all.size(); ++i) {
    powerShares.push_back(double(all.probability(i)));
    Group& group = groups[groupOfLight[i]];
    group.powerShare += all.probability(i);
  }
  for (Group& group : groups)
    group.probability = group.firstProbability =
        (group.powerShare + 1 / static_cast<float>(groups.size())) / 2;
  table = all;
  buildTable();
}

LePdf EmissionMixture::pdfLe(uint32_t light, const LeRay& ray) const {
  const Light& emitter = table[light];
  LePdf pdf = emitter.pdfLe(ray);
  float& replaced = emitter.isInfinite() ? pdf.position : pdf.direction;
  replaced = density(light, ray, replaced, -1);
  return pdf;
}

float EmissionMixture::density(uint32_t light, const LeRay& ray, float lightDensity, int hitLane) const {
  const Group& group = groupOf(light);
  const Light& emitter = table[light];
  const BoxBlock::Line line(emitter, ray, lightDensity);
  Float8 total(0);
  for (size_t i = 0; i < group.lanes.size(); ++i) {
    const uint32_t lanes = hitLane >= 0 && static_cast<size_t>(hitLane) / 8 == i ? 1u << (hitLane % 8) : 0;
    total += group.lanes[i] * boxes.blocks[group.firstBlock + i].density(line, lanes);
  }
  return group.lightSamplingProbability * lightDensity + sum(total);
}

void EmissionMixture::redirect(uint32_t light, LeSample& sample, float pick, const Vec2f& u) const {
  const Light& emitter = table[light];
  const Group& group = groupOf(light);
  int hitLane = -1;
  LeRay ray = sample;
  if (pick >= group.lightSamplingProbability) {
    float remaining = pick - group.lightSamplingProbability;
    size_t lane = 0;
    for (size_t i = 0; i < group.chances.size(); ++i) {
      if (!(group.chances[i] > 0)) continue;
      lane = i;
      if (remaining < group.chances[i]) break;
      remaining -= group.chances[i];
    }
    const float rescaled = std::clamp(remaining / group.chances[lane], 0.0f, 1.0f);
    const BoxBlock& block = boxes.blocks[group.firstBlock + lane / 8];
    if (emitter.isInfinite()) {
      ray.origin = originThrough(block.bounds(lane % 8), bounds, ray.direction, rescaled, u);
      hitLane = static_cast<int>(lane);
    } else {
      const Cone cone = Cone::toSphere(ray.origin, block.center(lane % 8), block.radius(lane % 8));
      if (cone.opening < 2) { // else its own sampling
        ray.direction = cone.sample(u);
        hitLane = static_cast<int>(lane);
      }
    }
  }
  if (hitLane < 0 || emitter.isInfinite()) {
    // The density of the sample itself: rounding may deny that the light emits in its direction. With a
    // portal, the density of a replaced origin differs from it.
    float& replaced = emitter.isInfinite() ? sample.pdfPosition : sample.pdfDirection;
    const float own = hitLane < 0 ? replaced : emitter.pdfLe(ray).position;
    const float mixed = density(light, ray, own, hitLane);
    sample.origin = ray.origin;
    sample.flux *= replaced / mixed;
    replaced = mixed;
    return;
  }
  const bool behind = sample.normal != Vec3f(0) && glm::dot(ray.direction, sample.normal) <= 0;
  const float cosine = sample.normal == Vec3f(0) ? 1 : absDot(ray.direction, sample.normal);
  sample.radiance = behind ? BLACK : emitter.radianceTowards(sample, ray.direction);
  sample.direction = ray.direction;
  sample.pdfDirection = density(light, ray, emitter.pdfLe(ray).direction, hitLane);
  sample.flux = sample.radiance * (cosine / (sample.pdfPosition * sample.pdfDirection));
}

EmissionMixture::Moments::Moments(const EmissionMixture& mixture)
    : mixture(mixture), sums(mixture.groups.size() * mixture.components()) {}

void EmissionMixture::Moments::add(uint32_t light, const LeRay& ray, double squared) {
  const EmissionMixture& m = mixture;
  const Group& group = m.groupOf(light);
  const Light& emitter = m.table[light];
  const float lightDensity = ownDensity(emitter, emitter.pdfLe(ray));
  const double scale =
      squared / (double(group.probability) * double(m.density(light, ray, lightDensity, -1)));
  if (!std::isfinite(scale)) return; // a ray on the edge of the only box that samples it
  double* const first = &sums[m.groupOfLight[light] * m.components()];
  first[0] += scale * double(lightDensity);
  const BoxBlock::Line line(emitter, ray, lightDensity);
  for (size_t i = 0; i < group.lanes.size(); ++i) {
    const Float8 all = m.boxes.blocks[group.firstBlock + i].density(line, 0);
    for (size_t lane = 0; lane < 8; ++lane)
      if (group.chances[8 * i + lane] > 0)
        first[1 + 8 * i + lane] += scale * double(all[static_cast<int>(lane)]);
  }
}

void EmissionMixture::Moments::add(const Moments& o) {
  for (size_t i = 0; i < sums.size(); ++i) sums[i] += o.sums[i];
}

void EmissionMixture::adapt(const Moments& moments) {
  std::vector<double> totals(groups.size());
  std::vector<std::vector<double>> learned(groups.size());
  double all = 0;
  for (size_t g = 0; g < groups.size(); ++g) {
    const Group& group = groups[g];
    const double* const sums = &moments.sums[g * components()];
    const auto add = [&](float before, double moment) {
      learned[g].push_back(double(group.probability) * double(before) * std::sqrt(moment));
      totals[g] += learned[g].back();
    };
    add(group.lightSamplingProbability, sums[0]);
    for (size_t i = 0; i < group.chances.size(); ++i) add(group.chances[i], sums[1 + i]);
    all += totals[g];
  }
  if (!(all > 0)) return;
  for (size_t g = 0; g < groups.size(); ++g) {
    Group& group = groups[g];
    group.probability =
        UNLEARNED * group.firstProbability + (1 - UNLEARNED) * static_cast<float>(totals[g] / all);
    if (!(totals[g] > 0)) continue;
    const auto learnedProbability = [&](size_t i) {
      return (1 - UNLEARNED) * static_cast<float>(learned[g][i] / totals[g]);
    };
    group.lightSamplingProbability = UNLEARNED * OWN_PART + learnedProbability(0);
    for (size_t i = 0; i < group.chances.size(); ++i)
      group.chances[i] = UNLEARNED * group.firstGuess[i] + learnedProbability(1 + i);
  }
  buildTable();
}

void EmissionMixture::buildTable() {
  std::vector<const Light*> each;
  std::vector<double> weights;
  // Lights of a group are chosen by power.
  for (size_t i = 0; i < table.size(); ++i) {
    const Group& group = groups[groupOfLight[i]];
    each.push_back(&table[i]);
    weights.push_back(
        group.powerShare > 0 ? double(group.probability) * powerShares[i] / double(group.powerShare) : 0);
  }
  table.build(each, weights);
  for (Group& group : groups) {
    group.lanes.clear();
    for (size_t i = 0; i < group.chances.size(); i += 8) {
      alignas(32) float lanes[8];
      std::copy_n(group.chances.begin() + static_cast<std::ptrdiff_t>(i), 8, lanes);
      group.lanes.push_back(Float8::load(lanes));
    }
  }
}

double EmissionMixture::boxPart() const {
  double fraction = 0;
  for (const Group& group : groups)
    fraction += double(group.probability) * double(1 - group.lightSamplingProbability);
  return fraction;
}

template <class Value> float EmissionMixture::medianOf(const Value& value) const {
  std::vector<std::pair<float, float>> values; // with probabilities
  float all = 0, sum = 0;
  for (size_t i = 8 * boxes.exitBlocks; i < boxes.chances.size(); ++i) {
    if (!(boxes.chances[i] > 0)) continue;
    values.emplace_back(value(boxes.blocks[i / 8].center(i % 8)), boxes.chances[i]);
    all += boxes.chances[i];
  }
  std::sort(values.begin(), values.end());
  for (const auto& [median, chance] : values)
    if ((sum += chance) >= all / 2) return median;
  return 0;
}

bool EmissionMixture::isFar(uint32_t light) const {
  constexpr float FAR = 0.25f; // 1 - cosine of the half-angle of all boxes: an eighth of all directions
  if (!active() || table[light].isInfinite()) return false;
  LeRandom any;
  any.pick = 0.3f;
  any.position = any.direction = Vec2f(0.3f, 0.6f);
  const std::optional<LeSample> sample = table[light].sampleLe(any);
  if (!sample) return false;
  // A sphere around most of the vertices: a lamp that few camera paths hit is not among them.
  Vec3f center;
  for (int axis = 0; axis < 3; ++axis) center[axis] = medianOf([&](const Vec3f& p) { return p[axis]; });
  const float typical = medianOf([&](const Vec3f& p) { return glm::distance(p, center); });
  return Cone::toSphere(sample->origin, center, 2 * typical).opening < FAR;
}

} // namespace recurse
