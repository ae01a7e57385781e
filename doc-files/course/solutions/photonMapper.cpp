/** @file
 * Exercise 2: a photon mapper with a caustic map and a global map (Jensen 2001, "Realistic Image Synthesis
 * Using Photon Mapping"). README.md explains each gap.
 */
#include "frame/photonMapper.h"

#include <recurse/core/sampling/sampling.h>

namespace course::photon {

// Gap 1: power [W] of one of `photons` photons. It leaves a lamp with a cosine to the normal, from a point of
// the density pdfArea [1/length²], in a direction of the density pdfDirection [1/sr].
Rgb photonPower(const Rgb& lampRadiance, float cosine, float pdfArea, float pdfDirection, int photons) {
  // solution 1 {
  return lampRadiance * (cosine / (pdfArea * pdfDirection * float(photons)));
  // } handout: return BLACK;
}

// Gap 2: maps that store a photon that arrives at a surface with this history. The table of paths in
// README.md says what each map accounts for.
Maps mapsOf(Surface::Kind kind, const PhotonHistory& history) {
  // solution 2 {
  const bool isStored = kind == Surface::Kind::DIFFUSE;
  return {isStored, isStored && history.specular > 0 && history.diffuse == 0};
  // } handout: return {};
}

// Gap 3: Russian roulette by u in [0, 1) at a surface with a reflectance. False: the photon is absorbed. The
// expected power must be the reflected power.
bool survivesScattering(Rgb& power, const Rgb& reflectance, float u) {
  // solution 3 {
  const float probability = std::min(1.0f, maxComponent(reflectance));
  if (u >= probability) return false;
  power *= reflectance / probability;
  return true;
  // } handout: return false;
}

// Gap 4: whether the search for photons within a radius goes to the far side of a split plane.
bool visitsFarSide(float planeDistance, float radius2) {
  // solution 4 {
  return planeDistance * planeDistance < radius2;
  // } handout: return false;
}

// Gap 5: radiance from the photons in a sphere around a point of a flat diffuse surface.
Rgb radianceEstimate(const std::vector<NearPhoton>& photons, float radius2, const Rgb& bsdf) {
  // solution 5 {
  Rgb flux(0);
  for (const NearPhoton& photon : photons) flux += photon.power;
  return bsdf * flux / (PI * radius2);
  // } handout: return BLACK;
}

// Gap 6: cone kernel [1/length²], highest in the middle and zero at the radius.
float coneKernel(float distance2, float radius2) {
  // solution 6 {
  return 3 * (1 - std::sqrt(distance2 / radius2)) / (PI * radius2);
  // } handout: return 0;
}

// Gap 7: direct light from a direction towards a lamp that was sampled with the density pdf [1/sr].
Rgb directLight(const Rgb& bsdf, float cosine, const Rgb& radiance, float pdf) {
  // solution 7 {
  return bsdf * radiance * (cosine / pdf);
  // } handout: return BLACK;
}

// Gap 8: radiance that a diffuse surface reflects of the light from other diffuse surfaces. One ray samples
// it: seeThrough() follows it to a diffuse surface, of which estimate() gives the radiance.
Rgb finalGather(const Scene& scene, const Surface& surface, const Estimate& estimate, Sampler& sampler,
                TransportCounts& counts) {
  // solution 8 {
  const Vec3f direction = cosineHemisphere(sampler.next2D());
  const Seen seen = seeThrough(scene, rayFrom(surface, direction), sampler, counts);
  return seen.surface ? surface.colour * seen.weight * estimate(*seen.surface) : BLACK;
  // } handout: return BLACK;
}

class PhotonMapper final : public Tracer {
 public:
  PhotonMapper(int photons, int nearest) : photons(photons), nearest(size_t(nearest)) {}

  ForwardStatistics forward(const Scene& scene, const PathClasses&, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics;
    std::vector<Photon> global, caustic;
    for (int i = 0; i < photons && !control.stopped(); ++i)
      shootPhoton(scene, Sampler(pass.seed, 0x70686f746f6e73, uint32_t(i)), global, caustic,
                  statistics.counts);
    globalMap.build(std::move(global));
    causticMap.build(std::move(caustic));
    maxRadius = 0.1f * scene.bounds().radius;
    statistics.photonsEmitted = uint64_t(photons);
    statistics.photonsStored = globalMap.size();
    return statistics;
  }

  Rgb radiance(const Scene& scene, const Ray& ray, Sampler& sampler, TransportCounts& counts) const override {
    const Seen seen = seeThrough(scene, ray, sampler, counts);
    if (!seen.surface) return seen.emitted;
    const Surface& surface = *seen.surface;
    const Estimate estimate = [this](const Surface& s) { return fromGlobalMap(s); };
    return seen.emitted +
           seen.weight * (sampledLight(scene, surface, sampler, counts) + fromCausticMap(surface) +
                          finalGather(scene, surface, estimate, sampler, counts));
  }

  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LS*E", "none: lamps seen directly, in mirrors and in glass", "", true},
            {"direct light", "LDS*E", "one shadow ray", ""},
            {"caustic map", "LS+DS*E", "one estimate", ""},
            {"final gather from the global map", "L(S|D)*DS*DS*E", "one ray and one estimate", ""}};
  }

 private:
  /** Traces a photon until it is absorbed. */
  void shootPhoton(const Scene& scene, Sampler sampler, std::vector<Photon>& global,
                   std::vector<Photon>& caustic, TransportCounts& counts) const {
    const std::optional<LampPoint> lamp = sampleLamp(scene, sampler);
    if (!lamp) return;
    const Vec3f local = cosineHemisphere(sampler.next2D());
    const Vec3f direction = Frame(lamp->point.geometricNormal).toWorld(local);
    Rgb power = photonPower(lamp->radiance, local.z, lamp->pdfArea, local.z * INV_PI, photons);
    Ray ray{lamp->point.rayOrigin(direction), direction};
    PhotonHistory history;
    for (int depth = 0; depth < MAX_DEPTH; ++depth) {
      const std::optional<Surface> hit = traceRay(scene, ray, counts);
      if (!hit) return;
      const Maps maps = mapsOf(hit->kind, history);
      const Photon photon{hit->point.position, hit->frame.z, power, 0};
      if (maps.global) global.push_back(photon);
      if (maps.caustic) caustic.push_back(photon);
      if (hit->kind == Surface::Kind::BLACK) return;
      const bool isDiffuse = hit->kind == Surface::Kind::DIFFUSE;
      const Rgb reflectance = hit->kind == Surface::Kind::GLASS ? Rgb(1) : hit->colour;
      if (!survivesScattering(power, reflectance, sampler.next1D())) return;
      ++(isDiffuse ? history.diffuse : history.specular);
      ray = rayFrom(*hit, isDiffuse ? cosineHemisphere(sampler.next2D()) : specularStep(*hit, sampler));
    }
  }

  Rgb fromGlobalMap(const Surface& s) const {
    const NearPhotons found = globalMap.nearest(s.point.position, s.frame.z, nearest, maxRadius);
    return radianceEstimate(found.photons, found.radius2, s.colour * INV_PI);
  }

  Rgb fromCausticMap(const Surface& s) const {
    const NearPhotons found = causticMap.nearest(s.point.position, s.frame.z, nearest, maxRadius);
    Rgb sum(0);
    for (const NearPhoton& photon : found.photons)
      sum += photon.power * coneKernel(photon.distance2, found.radius2);
    return s.colour * INV_PI * sum;
  }

  static Rgb sampledLight(const Scene& scene, const Surface& surface, Sampler& sampler,
                          TransportCounts& counts) {
    const std::optional<LampPoint> lamp = sampleLamp(scene, sampler);
    if (!lamp) return BLACK;
    const std::optional<Connection> c = connect(scene, surface, *lamp, counts);
    if (!c) return BLACK;
    return directLight(surface.colour * INV_PI, c->cosSurface, lamp->radiance, pdfTowardsLamp(*lamp, *c));
  }

  int photons;    ///< number emitted
  size_t nearest; ///< number of photons in an estimate
  float maxRadius = 0;
  PhotonTree globalMap, causticMap;
};

} // namespace course::photon

std::unique_ptr<course::Tracer> course::makePhotonMapper(int photons, int nearest) {
  return std::make_unique<photon::PhotonMapper>(photons, nearest);
}
