/** @file
 * Emission of photons: from lights, chosen by power, and from emissive media.
 */
#pragma once

#include <algorithm>
#include <optional>

#include "transport/forward/shootSettings.h"
#include "transport/paths/walk.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Photon between two scattering events. */
struct PhotonState {
  Ray ray;
  Rgb flux;
  LightState state;
  Nesting nesting;
  ReverseRatio ratio;
  int depth = 0;
  bool caustic = true;
  bool straight = true;           ///< only thin panes are between the light and the photon
  float wavelength = 0;           ///< see Subpath
  PathEvent event = PathEvent::D; ///< last event
  RecordedLightPath record{};
  // Spectral state in media:
  Rgb pathPdf{1};        ///< see SpectralPath
  int hero = 0;          ///< colour channel that draws distances
  OpticalPath optical{}; ///< up to the ray's origin; up to the next event once it is found
};

/** Emission of a photon: its light, position and densities. */
struct PhotonOrigin {
  LightKind kind = LightKind::POINT;
  LePdf pdf;
  Vec3f position{0};
  uint32_t light = 0;
  float probability = 0; ///< selection probability of the light
};

/** Samples the starts of photons, each with its own random numbers. */
class PhotonStart {
 public:
  PhotonStart(const Scene& scene, const PathClasses& classes, const ShootSettings& settings,
              TransportCounts& counts)
      : scene(scene), classes(classes), settings(settings), counts(counts), mediaPart(partOfMedia()) {}

  /** Starts a photon in an emissive medium. */
  std::optional<PhotonState> fromMedium(const EmissionGuide::TrainingSample& start, float time,
                                        Sampler& sampler) {
    const auto& n = start.numbers;
    auto [position, nesting, power, medium] =
        settings.media->sample(scene, time, n[0], {n[1], n[2], n[3]}, counts);
    const Rgb flux = power * (start.weight / mediaPart / static_cast<float>(settings.photons));
    const LightState state = startInMedium(scene, classes, medium);
    if (!isUseful(flux, state)) return {};
    const Ray ray{position, uniformSphere({n[4], n[5]}), INFINITE, time};
    PhotonState photon{ray, flux, state, nesting, {}};
    photon.optical = opticalStart(scene, classes, ray, nesting, false, counts);
    photon.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
    return photon;
  }

  /** Starts a photon at a light, which is chosen by power. */
  std::optional<PhotonState> fromLight(const EmissionGuide::TrainingSample& start, float time,
                                       Sampler& sampler) {
    const auto& n = start.numbers;
    float pick = n[0];
    const size_t index = lights().chooseIndex(pick);
    const Light& source = lights()[index];
    const float probability = lights().probability(index);
    if (!(probability > 0)) return {};
    const bool aimed = settings.aim && settings.aim->isAimed(static_cast<uint32_t>(index));
    const Vec2f towards{n[4], n[5]};
    std::optional<LeSample> emission =
        source.sampleLe({n[1], {n[2], n[3]}, aimed ? sampler.next2D() : towards, time});
    if (!emission) return {};
    if (aimed) settings.aim->redirect(source, *emission, pick, towards);
    if (isBlack(emission->flux)) return {};
    LePdf pdf = source.pdfLe(*emission);
    if (aimed) pdf.direction = emission->pdfDirection;
    if (source.isInfinite() && settings.portals && settings.portals->active()) {
      settings.portals->redirect(*emission, pick, {n[2], n[3]});
      pdf.position = emission->pdfPosition;
    }
    origin = {source.kind(), pdf, emission->origin, static_cast<uint32_t>(index), probability};
    Rgb flux = emission->flux / (probability * (1 - mediaPart) * static_cast<float>(settings.photons));
    if (source.isInfinite()) flux *= settings.outsideTransmittance;
    const LightState state = classes.lightStart(index);
    if (!isUseful(flux, state)) return {};
    const Ray ray{emission->origin, emission->direction, INFINITE, time};
    const ReverseRatio ratio =
        source.isIntersectable() ? ReverseRatio::atLight(*emission, pdf, probability) : ReverseRatio();
    PhotonState photon{ray, flux * start.weight, state, nestingAt(scene, ray, counts), ratio};
    photon.optical = opticalStart(scene, classes, ray, photon.nesting, source.isInfinite(), counts);
    if (scene.hasMedia()) {
      const uint16_t declared = source.isInfinite() ? settings.outside : scene.lightMedium(index);
      photon.nesting.startIn(declared ? declared : mediumAround(scene, ray, 0, counts));
      photon.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
    }
    return photon;
  }

  /** Fraction of the photons that emissive media emit. */
  float byMedia() const { return mediaPart; }

  PhotonOrigin origin; ///< origin of the last photon that a light emitted

 private:
  const LightTable& lights() const { return settings.lights ? *settings.lights : scene.lights(); }

  /** Fraction of the photons that emissive media emit: proportional to power, but between a tenth and nine
   * tenths if the scene has lights, too. */
  float partOfMedia() const {
    constexpr double MAX_PART = 0.9;
    if (!settings.media || settings.media->empty()) return 0;
    double byLights = 0;
    for (size_t i = 0; i < lights().size(); ++i) byLights += double(maxComponent(lights()[i].power()));
    if (!(byLights > 0)) return 1;
    const double byMedia = settings.media->power();
    return static_cast<float>(std::clamp(byMedia / (byMedia + byLights), 1 - MAX_PART, MAX_PART));
  }

  /** Whether a photon with this initial flux and state is followed. Counts fluxes that are not finite. */
  bool isUseful(const Rgb& flux, LightState state) {
    if (!recurse::isFinite(flux)) {
      ++counts.nonFinite;
      return false;
    }
    return !isBlack(flux) && !classes.dead(state);
  }

  const Scene& scene;
  const PathClasses& classes;
  const ShootSettings& settings;
  TransportCounts& counts;
  float mediaPart;
};

} // namespace recurse
