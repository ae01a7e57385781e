/** @file
 * Path classes that each estimator of photon mapping finds.
 */
#include "integrators/photonmap/photonMapping.h"

namespace recurse {

void PhotonMapping::addMedia(std::vector<EstimatorDomain>& all) const {
  const std::string each = "one density estimate for each flight of a path in a medium";
  if (!settings.directLight) {
    all.push_back({"light from emitting media", "LDS*E", "one for each non-delta surface of a path",
                   "direct light", false, false, true});
    all.push_back({"shadow rays in media", "LVS*E",
                   std::to_string(settings.lightSamples) +
                       " for each flight of a path in a medium; four times as many from lights that are not "
                       "surfaces, before the first surface",
                   "direct light in media"});
    all.push_back({"shadow rays in media through panes", "LS+VS*E", "included in shadow rays",
                   "light in media", false, true});
    all.push_back({"in-scattered light from emitting media", "LVS*E", each, "direct light in media"});
  }
  all.push_back({"photons in media", settings.directLight ? "L(S|D|V)*VS*E" : "L(S|D|V)+VS*E", each,
                 settings.directLight ? "" : "light in media"});
}

std::vector<EstimatorDomain> PhotonMapping::domains() const {
  const std::string each = "one for each non-delta surface of a path";
  std::vector<EstimatorDomain> all = {
      {"emission", "LS*E", "none: found by rays through mirrors and glass", "", true}};
  const std::string caustics = settings.directLight ? "LS*DS*E" : "LS+DS*E",
                    indirect = settings.causticsOnly ? "L(S|D)*DS*DS*E" : "L(S|D|V)*(D|V)S*DS*E";
  if (!settings.directLight) {
    all.push_back({"shadow rays", "LDS*E",
                   std::to_string(settings.lightSamples) + " for each non-delta surface of a path",
                   "direct light"});
    all.push_back({"BSDF rays", "LDS*E", each, "direct light", true});
    all.push_back(
        {"shadow rays through panes", "LS+DS*E", "included in shadow rays", "caustics", false, true});
  }
  if (!settings.causticsOnly) addMedia(all);
  const bool rays = !settings.directLight || settings.weighting.ever();
  all.push_back({"caustic photons", caustics, "one density estimate for each non-delta surface of a path",
                 rays ? "caustics" : ""});
  if (rays)
    all.push_back({"BSDF rays by mirrors and glass", caustics, "included in BSDF rays", "caustics", true});
  const bool reads = settings.finalGather <= 0 && !settings.causticsOnly;
  const bool goOn = !reads || settings.weighting.ever() ||
                    (settings.finalGather < 0 && settings.passes.schedule() != PassSchedule::ONE_MAP);
  const char* group = reads && goOn ? "indirect light" : "";
  if (reads)
    all.push_back({"photon map", indirect, "one density estimate for the first non-delta surface", group});
  if (goOn)
    all.push_back(
        {"continued paths", indirect,
         (settings.finalGather > 0 ? std::to_string(settings.finalGather) : "one") +
             std::string(
                 " from the first non-delta surface; all estimators of this table apply where it ends"),
         group});
  return all;
}

} // namespace recurse
