/** @file
 * Exercise 1: a path tracer (Kajiya 1986, "The Rendering Equation") with light sampling and multiple
 * importance sampling (Veach 1997, chapters 8 and 9). README.md explains each gap.
 */
#include "frame/pathTracer.h"

namespace course::path {

// Gap 1: radiance that a lamp emits. It is the same in all directions in front of the lamp, and zero behind.
Rgb emittedRadiance(const Rgb& lampRadiance, float cosLamp) {
  return BLACK; // gap 1 is open
}

// Gap 2: BSDF of a Lambertian surface [1/sr].
Rgb lambertianBsdf(const Rgb& albedo) {
  return BLACK; // gap 2 is open
}

// Gap 3: direction with a density in proportion to the cosine, from u in [0, 1)², and its density [1/sr].
DirectionSample sampleCosine(const Vec2f& u) {
  return {Vec3f(0, 0, 1), 0}; // gap 3 is open
}

// Gap 4: factor of the throughput at a scattering event whose direction was sampled with the density pdf.
Rgb scatteringWeight(const Rgb& bsdf, float cosine, float pdf) {
  return BLACK; // gap 4 is open
}

// Gap 5: direct light from a lamp point that was sampled with the density pdfArea [1/length²].
Rgb directLight(const Rgb& bsdf, const Rgb& lampRadiance, const Connection& c, float pdfArea) {
  return BLACK; // gap 5 is open
}

// Gap 6: Russian roulette by u in [0, 1). False: the path ends. The expected throughput must not change.
bool survivesRoulette(Rgb& throughput, float u) {
  return false; // gap 6 is open
}

// Gap 7: direction in which a mirror reflects.
Vec3f mirrored(const Vec3f& wo) {
  return Vec3f(0, 0, 1); // gap 7 is open
}

// Gap 8: direction into glass, and the fraction of the light that is reflected. eta: refractive index behind
// the surface over the index on the side of wo. Empty: total internal reflection.
std::optional<Refraction> refracted(const Vec3f& wo, float eta) {
  return Refraction{-wo, 0}; // gap 8 is open
}

// Gap 9: density of a lamp point by solid angle [1/sr], from its density by area [1/length²]; and the MIS
// weight of a sample that has the density pdf by its own technique and otherPdf by the alternative.
float pdfSolidAngle(float pdfArea, float distance2, float cosLamp) {
  return 0; // gap 9 is open
}
float misWeight(float pdf, float otherPdf) {
  return 1; // gap 9 is open
}

// Gap 10: weight of the emission of a lamp that a ray hits. The ray comes from the camera, a mirror or glass
// if lastWasDelta, else from a diffuse surface with the density pdfRay; light sampling has pdfLamp [1/sr].
float emissionWeight(bool lastWasDelta, float pdfRay, float pdfLamp) {
  if (lastWasDelta) return 1;
  return 0; // gap 10 is open
}

class PathTracer final : public Tracer {
 public:
  Rgb radiance(const Scene& scene, const Ray& cameraRay, Sampler& sampler,
               TransportCounts& counts) const override {
    Rgb sum(0), throughput(1);
    Ray ray = cameraRay;
    bool lastWasDelta = true;
    float pdfRay = 0;
    for (int depth = 0; depth < MAX_DEPTH; ++depth) {
      const std::optional<Surface> hit = traceRay(scene, ray, counts);
      if (!hit) break;
      if (hit->isLamp) {
        const float pdfLamp = pdfSolidAngle(hit->lampPdfArea, hit->distance2, std::abs(hit->lampCosine));
        sum += throughput * emittedRadiance(hit->lampRadiance, hit->lampCosine) *
               emissionWeight(lastWasDelta, pdfRay, pdfLamp);
      }
      Vec3f next;
      if (hit->kind == Surface::Kind::DIFFUSE) {
        sum += throughput * sampledLight(scene, *hit, sampler, counts);
        const DirectionSample sample = sampleCosine(sampler.next2D());
        if (!(sample.pdf > 0)) break;
        throughput *= scatteringWeight(lambertianBsdf(hit->colour), sample.direction.z, sample.pdf);
        next = sample.direction;
        pdfRay = sample.pdf;
      } else if (hit->kind == Surface::Kind::MIRROR) {
        throughput *= hit->colour;
        next = mirrored(hit->wo);
      } else if (hit->kind == Surface::Kind::GLASS) {
        next = throughGlass(*hit, sampler);
      } else {
        break;
      }
      lastWasDelta = hit->kind != Surface::Kind::DIFFUSE;
      if (isBlack(throughput)) break;
      if (depth >= ROULETTE_DEPTH && !survivesRoulette(throughput, sampler.next1D())) break;
      ray = rayFrom(*hit, next);
    }
    return sum;
  }

  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LS*E", "none: lamps seen directly, in mirrors and in glass", "", true},
            {"emission after scattering", "LS+D(S|D)*E", "none: continued rays", "", true},
            {"light sampling", "LD(S|D)*E", "one shadow ray at each diffuse surface", "MIS"},
            {"rays that hit lamps", "LD(S|D)*E", "none: continued rays", "MIS", true}};
  }

 private:
  static constexpr int ROULETTE_DEPTH = 3; ///< scattering events before paths may end

  static Rgb sampledLight(const Scene& scene, const Surface& surface, Sampler& sampler,
                          TransportCounts& counts) {
    const std::optional<LampPoint> lamp = sampleLamp(scene, sampler);
    if (!lamp) return BLACK;
    const std::optional<Connection> c = connect(scene, surface, *lamp, counts);
    if (!c) return BLACK;
    const float pdfLamp = pdfSolidAngle(lamp->pdfArea, c->distance2, c->cosLamp);
    const float pdfRay = c->cosSurface * INV_PI; // density of sampleCosine()
    return directLight(lambertianBsdf(surface.colour), lamp->radiance, *c, lamp->pdfArea) *
           misWeight(pdfLamp, pdfRay);
  }

  /** Reflects with the probability of the Fresnel reflectance, else refracts. Radiance is multiplied by η²
   * where light enters glass, and divided by η² where it leaves. Both are left out: camera and lamps are
   * outside of the glass, so that they cancel. */
  static Vec3f throughGlass(const Surface& surface, Sampler& sampler) {
    const std::optional<Refraction> refraction = refracted(surface.wo, surface.eta);
    const bool reflects = !refraction || sampler.next1D() < refraction->reflectance;
    return reflects ? mirrored(surface.wo) : refraction->direction;
  }
};

} // namespace course::path

std::unique_ptr<course::Tracer> course::makePathTracer() { return std::make_unique<path::PathTracer>(); }
