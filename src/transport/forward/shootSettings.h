/** @file
 * Settings of the forward pass: how many photons, where they start, where they are sent, what is stored.
 */
#pragma once

#include <vector>

#include "transport/direct/lightPortals.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/emissionGuide.h"
#include "transport/emission/emissiveMedia.h"
#include "transport/emission/photonAim.h"

namespace recurse {

/**
 * A sphere that photons are sent to from every matt surface outside, by directions of their own: those that
 * the surface's BSDF would send there are left out in return, so that nothing is counted twice (the DXTRAN
 * spheres of neutron transport; X-5 Monte Carlo Team, "MCNP", 2003, volume I, section 2.IV.E.9). They carry
 * little each and are many; when they leave the sphere, roulette makes them few.
 */
struct DxtranSphere {
  Vec3f center{0};
  float radius = 0;
  float part = 1;       ///< of a photon's power that one sent to the sphere should carry
  float importance = 0; ///< how much of what is seen lies in so much of a surface
};

/** What walks leave behind in media. Each medium keeps either points or beams, so that nothing is counted
 * twice. */
struct KeptInMedia {
  std::vector<bool> byBeams;         ///< by medium; empty: none
  float pointPart = 1, beamPart = 1; ///< of all, with so much more power

  bool isByBeams(uint16_t medium) const { return medium < byBeams.size() && byBeams[medium]; }
};

struct ShootSettings {
  uint64_t photons = 0; ///< emitted
  int maxDepth =
      -1; ///< most scattering events of a photon, the one where it is stored included; -1: no limit
  /** Store photons that come straight from a light, thin panes included, as well. Those of media always are:
   * nothing else finds their light. */
  bool direct = true;
  bool causticsOnly = false;             ///< photons end at the first non-delta surface, and in media
  const EmissiveMedia* media = nullptr;  ///< that emit as well as the lights; null: none
  uint16_t outside = 0;                  ///< medium that light from infinitely far starts in
  Rgb outsideTransmittance{1};           ///< what it has come through before: transmittance
  const EmissionGuide* guide = nullptr;  ///< where photons are worth most; null: everywhere
  const LightPortals* portals = nullptr; ///< where light from infinitely far comes in; null: everywhere
  const PhotonAim* aim = nullptr;        ///< where far lamps send photons; null: everywhere
  const LightTable* lights = nullptr;    ///< by which lights are chosen; null: the scene's
  /** By which shadow rays choose lights, for Photon::reverseRatio; null: no light is sampled by shadow rays.
   */
  const LightSampler* shadowRays = nullptr;
  /** Photons from infinitely far that start less densely [1/length²] are so strong that each would be seen:
   * what they bring to the first matt surface straight from the light, rays find from there on. */
  float minStartDensity = 0;
  std::vector<DxtranSphere> targets;
  KeptInMedia inMedia;
  const VisibleRegion* region = nullptr; ///< where strong photons are split; null: nowhere
  float splitPower = INFINITE;           ///< about what each part of a strong one carries; at most 256 parts
};

} // namespace recurse
