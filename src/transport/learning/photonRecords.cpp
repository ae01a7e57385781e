/** @file
 * Records of the guide from photons.
 */
#include "transport/learning/photonRecords.h"

#include <cmath>

#include "transport/forward/shoot.h"

namespace recurse {

std::vector<GuideRecord> photonRecords(const Scene& scene, const Pass& pass, const ShootSettings& shoot,
                                       const ForwardControl& control, TransportCounts& counts) {
  const PathClasses allPaths;
  ForwardControl local;
  local.stop = control.stop;
  const ShotPhotons shot = shootPhotons(scene, allPaths, pass, shoot, local);
  counts.add(shot.counts);
  std::vector<GuideRecord> records;
  for (const Photon& p : shot.onSurfaces) {
    // reverseRatio 0: no ray can hit this light; skip its caustic photons.
    if (p.caustic && !(p.reverseRatio > 0)) continue;
    GuideRecord r;
    r.position = p.position;
    r.normal = unpackDirection(p.normal);
    r.direction = unpackDirection(p.direction);
    r.value = luminance(p.power);
    // A diffuse BSDF stands in for the unknown one.
    r.pdfBsdf = glm::dot(r.direction, r.normal) * INV_PI;
    r.fromPhoton = true;
    if (r.value > 0 && std::isfinite(r.value) && r.pdfBsdf > 0) records.push_back(r);
  }
  for (const VolumePhoton& p : shot.inMedia) {
    GuideRecord r;
    r.position = p.position;
    r.direction = -unpackDirection(p.direction);
    r.value = luminance(p.power);
    r.pdfBsdf = INV_PI / 4; // an isotropic phase function stands in
    r.fromPhoton = true;
    if (r.value > 0 && std::isfinite(r.value)) records.push_back(r);
  }
  return records;
}

} // namespace recurse
