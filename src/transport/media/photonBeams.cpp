/** @file
 * Construction of the tree of boxes over photon beams.
 */
#include "transport/media/photonBeams.h"

#include <algorithm>
#include <cmath>

namespace recurse {

namespace {

/** Mean spacing of beams of this total length in the box: the side of a square that on average one of
 * parallel beams crosses. */
float spacingIn(const Bounds3f& box, double length) {
  const Vec3d sides(thickSides(box));
  return static_cast<float>(std::sqrt(sides.x * sides.y * sides.z / length));
}

} // namespace

void PhotonBeamMap::build(std::vector<PhotonBeam> all, float scale, float widest) {
  constexpr float RADIUS = 0.25f;       // radius over the spacing
  constexpr float PIECE = 4;            // length of a piece over the spacing
  constexpr double MAX_MEAN_PIECES = 8; // maximum mean number of pieces of a beam
  beams = std::move(all);
  Bounds3f box;
  double length = 0;
  for (const PhotonBeam& b : beams) {
    box.add(b.origin);
    box.add(b.origin + b.direction * b.length);
    length += double(b.length);
  }
  const double longest = std::max(double(PIECE * spacingIn(box, length)),
                                  length / (MAX_MEAN_PIECES * double(std::max<size_t>(1, beams.size()))));
  pieces.clear();
  for (size_t i = 0; i < beams.size(); ++i) {
    const auto count = static_cast<int>(std::ceil(double(beams[i].length) / longest));
    for (int k = 0; k < count; ++k) {
      const auto at = [&](int j) {
        return j == count ? beams[i].length
                          : beams[i].length * static_cast<float>(j) / static_cast<float>(count);
      };
      pieces.push_back({static_cast<uint32_t>(i), at(k), at(k + 1), 0});
    }
  }
  const auto point = [&](const Piece& p, float s) {
    return beams[p.beam].origin + beams[p.beam].direction * s;
  };
  const auto middle = [&](const Piece& p) { return point(p, (p.begin + p.end) / 2); };
  tree.sort(pieces, middle);
  tree.forParts([&](size_t first, size_t end) {
    Bounds3f bounds;
    double totalLength = 0;
    for (size_t k = first; k < end; ++k) {
      bounds.add(middle(pieces[k]));
      totalLength += double(pieces[k].end - pieces[k].begin);
    }
    float radius = totalLength > 0 ? RADIUS * spacingIn(bounds, totalLength) : 0;
    if (!(radius > 0)) radius = widest; // all in one point
    for (size_t k = first; k < end; ++k) pieces[k].radius = scale * std::min(radius, widest);
  });
  tree.enclose([&](Bounds3f& leaf, size_t k) {
    const Piece& p = pieces[k];
    for (const float s : {p.begin, p.end}) {
      leaf.add(point(p, s) - p.radius);
      leaf.add(point(p, s) + p.radius);
    }
  });
}

} // namespace recurse
