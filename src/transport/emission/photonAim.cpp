/** @file
 * Choice of the aimed lights and of their directions.
 */
#include "transport/emission/photonAim.h"

#include <algorithm>

#include "transport/direct/cameraPaths.h"

namespace recurse {

namespace {

/** Probability of the light's own directions, for surfaces that no camera path has hit. */
constexpr float OWN_PART = 0.1f;

bool isTwoSided(const Light& light, LeRay ray) {
  ray.direction = -ray.direction;
  return ray.normal != Vec3f(0) && light.pdfLe(ray).direction > 0;
}

/** Vertices of camera paths of a few bounces, weighted by throughput (at most 1). */
std::vector<WeightedPosition> findPositions(const Scene& scene, uint64_t seed, TransportCounts& counts) {
  constexpr int ACROSS = 64, MAX_DEPTH = 3;
  constexpr uint64_t STREAM = 0x41494d53ull;
  using Positions = std::vector<WeightedPosition>;
  const auto follow = [](Positions& found, CameraSubpath& path, CameraWalker& walker, Sampler& sampler,
                         TransportCounts&) {
    CameraVertex vertex;
    while (walker.next(path, vertex, sampler)) {
      found.push_back({vertex.point().position, std::min(maxComponent(path.throughput), 1.0f)});
      if (!walker.scatter(path, vertex, sampler)) break;
    }
  };
  Positions positions;
  for (const Positions& row :
       followCameraPaths(scene, ACROSS, MAX_DEPTH, hashCombine(seed, STREAM), counts, Positions(), follow))
    positions.insert(positions.end(), row.begin(), row.end());
  return positions;
}

LeRandom randomStart(Sampler& sampler) {
  LeRandom start;
  start.pick = sampler.next1D();
  start.position = sampler.next2D();
  start.direction = sampler.next2D();
  return start;
}

} // namespace

void PhotonAim::learn(const Scene& scene, uint64_t seed, TransportCounts& counts) {
  constexpr size_t MIN_POSITIONS = 64;
  constexpr int LEVELS = 4;       // at most 2^LEVELS leaves; the emission guide refines them
  constexpr float MARGIN = 1e-3f; // relative to the scene's radius
  constexpr uint32_t PLACES = 32, FLIGHTS = 64;
  constexpr double MIN_GAIN = 8; // density of photons at a vertex, relative to emission without an aim
  boxes = {};
  powerParts.clear();
  const LightTable& lights = scene.lights();
  bool finite = false;
  for (size_t i = 0; i < lights.size(); ++i) finite = finite || !lights[i].isInfinite();
  if (!finite) return;
  const std::vector<WeightedPosition> positions = findPositions(scene, seed, counts);
  if (positions.size() < MIN_POSITIONS) return;
  boxes = NestedBoxes(positions, LEVELS, MARGIN * scene.bounds().radius);
  std::vector<float> found(lights.size(), 1.0f);
  parallelFor(lights.size(), [&](size_t i) {
    const Light& light = lights[i];
    if (light.isInfinite()) return;
    double ratios = 0, shoneAt = 0;
    for (uint32_t k = 0; k < PLACES; ++k) {
      Sampler sampler(seed, i, k);
      const std::optional<LeSample> start = light.sampleLe(randomStart(sampler));
      if (!start) continue;
      const auto which = static_cast<size_t>(sampler.next1D() * static_cast<float>(positions.size()));
      const Vec3f way = positions[std::min(which, positions.size() - 1)].position - start->origin;
      if (way == Vec3f(0)) continue;
      LeRay ray = *start;
      ray.direction = glm::normalize(way);
      const float unaimed = light.pdfLe(ray).direction;
      if (!(unaimed > 0)) continue;
      ++shoneAt;
      ratios += double(unaimed / pdfDirection(light, ray, unaimed));
    }
    if (!(shoneAt > MIN_GAIN * ratios)) return;
    double flux = 0;
    for (uint32_t k = 0; k < FLIGHTS; ++k) {
      Sampler sampler(seed, i, PLACES + k);
      std::optional<LeSample> sample = light.sampleLe(randomStart(sampler));
      if (!sample) continue;
      const float pick = sampler.next1D();
      redirect(light, *sample, pick, sampler.next2D());
      // Only the flux towards the boxes: sample.flux is divided by the density of all directions.
      const float all = sample->pdfDirection, unaimed = light.pdfLe(*sample).direction;
      if (all > 0)
        flux += double(maxComponent(sample->flux)) * double(1 - OWN_PART * unaimed / all) / FLIGHTS;
    }
    const auto power = double(maxComponent(light.power()));
    if (flux > 0 && flux < power) found[i] = static_cast<float>(flux / power);
  });
  if (std::any_of(found.begin(), found.end(), [](float p) { return p < 1; })) powerParts = std::move(found);
}

size_t PhotonAim::lampCount() const {
  return size_t(std::count_if(powerParts.begin(), powerParts.end(), [](float p) { return p < 1; }));
}

Cone PhotonAim::coneTo(const NestedBoxes::Box& box, const Vec3f& from) const {
  return Cone::toSphere(from, box.bounds.center(), glm::length(box.bounds.diagonal()) / 2);
}

void PhotonAim::redirect(const Light& light, LeSample& sample, float pick, const Vec2f& u) const {
  const NestedBoxes::Box* chosen = nullptr;
  LeRay ray = sample;
  if (pick >= OWN_PART) {
    pick = (pick - OWN_PART) / (1 - OWN_PART);
    chosen = &boxes.choose(pick);
    ray.direction = coneTo(*chosen, sample.origin).sample(u);
  }
  const float unaimed = light.pdfLe(ray).direction;
  const bool behind = sample.normal != Vec3f(0) && glm::dot(ray.direction, sample.normal) <= 0;
  const Rgb radiance = behind ? BLACK : light.radianceTowards(sample, ray.direction);
  const float cosine = sample.normal == Vec3f(0) ? 1 : absDot(ray.direction, sample.normal);
  static_cast<LeRay&>(sample) = ray;
  sample.radiance = radiance;
  sample.pdfDirection = OWN_PART * unaimed + (1 - OWN_PART) * pdfThroughBoxes(light, ray, chosen);
  sample.flux = radiance * (cosine / (sample.pdfPosition * sample.pdfDirection));
}

float PhotonAim::pdfDirection(const Light& light, const LeRay& ray, float unaimed) const {
  return OWN_PART * unaimed + (1 - OWN_PART) * pdfThroughBoxes(light, ray, nullptr);
}

float PhotonAim::pdfThroughBoxes(const Light& light, const LeRay& ray, const NestedBoxes::Box* met) const {
  float sum = 0;
  for (const NestedBoxes::Box& box : boxes)
    if (const Cone cone = coneTo(box, ray.origin); &box == met || cone.contains(ray.direction))
      sum += box.chance * cone.pdf();
  return isTwoSided(light, ray) ? sum / 2 : sum; // the light samples a side before the direction
}

} // namespace recurse
