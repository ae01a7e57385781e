/** @file
 * Starts of photons that trial photons have shown to be useful, and their densities.
 */
#include "integrators/photonmap/photonPass.h"

#include "recurse/core/io/text.h"

namespace recurse {

EmissionSettings PhotonPass::emission() const {
  EmissionSettings starts;
  if (settings.guided) starts.lights = &lights;
  starts.guide = &guidance.emission;
  starts.portals = &portals;
  starts.aim = &aim;
  starts.outside = outside;
  starts.outsideTransmittance = outsideTransmittance;
  return starts;
}

LePdf PhotonPass::pdfLe(uint32_t index, const Light& light, const LeRay& ray) const {
  return emission().pdfLe(index, light, ray);
}

float PhotonPass::probability(const Scene& scene, uint32_t light) const {
  return emission().table(scene).probability(light);
}

LightTable PhotonPass::lightsByPower(const LightTable& all) const {
  const double open = portals.active() ? std::min(1.0, double(portals.openPart())) : 1;
  std::vector<const Light*> each;
  std::vector<double> powers;
  for (uint32_t i = 0; i < all.size(); ++i) {
    each.push_back(&all[i]);
    powers.push_back(
        double(maxComponent(all[i].power())) *
        (all[i].isInfinite() ? open * double(maxComponent(outsideTransmittance)) : double(aim.powerPart(i))));
  }
  LightTable table;
  table.build(each, powers);
  return table;
}

void PhotonPass::learnStarts(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& shoot, const ForwardControl& control,
                             TransportCounts& counts) {
  LightPortals openings;
  if (settings.without != Mechanism::PORTALS) openings.learn(scene, seed, counts);
  PhotonAim farLamps;
  if (settings.without != Mechanism::AIM) farLamps.learn(scene, seed, counts);
  if (!openings.active() && !farLamps.active()) return;
  const auto tryThese = [&] { return tryStarts(scene, classes, seed, shoot, region, counts); };
  StartTrial best = tryThese();
  const auto adoptIfBetter = [&](LightPortals otherPortals, PhotonAim otherAim) {
    constexpr double WORTH_IT = 2;                       // ratio of variances, which trials estimate badly
    constexpr uint64_t FEW_TRIALS = 256, MANY_TIMES = 4; // of about 32,000 trial photons
    if (control.stopped()) return;
    const auto exchange = [&] {
      std::swap(portals, otherPortals);
      std::swap(aim, otherAim);
      lights = lightsByPower(scene.lights());
    };
    exchange();
    const StartTrial with = tryThese();
    // With very few useful photons their second moment is unknown, and their number decides.
    const bool areManyMore =
        best.useful < FEW_TRIALS && with.useful >= MANY_TIMES * std::max<uint64_t>(1, best.useful);
    const bool isBetter = with.secondMoment > 0 && with.secondMoment * WORTH_IT < best.secondMoment;
    if (areManyMore || isBetter)
      best = with;
    else
      exchange();
  };
  if (openings.active()) adoptIfBetter(openings, {});
  if (farLamps.active()) adoptIfBetter(portals, farLamps);
  // A powerful far light without an aim leaves too few photons to judge the portals, so both are tried.
  if (openings.active() && farLamps.active() && !portals.active()) adoptIfBetter(openings, farLamps);
}

void PhotonPass::learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                               const ShootSettings& shoot, const ForwardControl& control,
                               ForwardStatistics& statistics) {
  region = probeRegion(scene, settings.weighting, statistics.counts);
  lights = lightsByPower(scene.lights());
  // A search for the nearest photons of one map needs photons of nearly equal power.
  if (progressive) learnStarts(scene, classes, seed, shoot, control, statistics.counts);
  guidance = recurse::learnGuidance(scene, classes, seed, shoot, region, control, statistics.counts,
                                    settings.without != Mechanism::GUIDE);
  if (settings.without == Mechanism::SPLITTING) guidance.splitPower = INFINITE;
  noteGuidance(statistics.notes);
}

void PhotonPass::noteGuidance(std::vector<std::string>& notes) const {
  if (portals.active())
    notes.push_back(formatted("photons: emission of infinite and distant lights is guided through %zu "
                              "openings that camera paths see",
                              portals.size()));
  if (aim.active())
    notes.push_back(formatted("photons: emission of %zu far lamp%s aimed at surfaces that camera paths hit",
                              aim.lampCount(), aim.lampCount() == 1 ? " is" : "s are"));
  if (guidance.emission.active())
    notes.push_back(formatted("photons: emission is guided to surfaces that the camera sees; the variance of "
                              "a photon is %.3g times smaller",
                              guidance.emission.gain()));
}

} // namespace recurse
