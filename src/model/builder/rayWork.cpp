/** @file
 * Predicted work of overlapping surfaces: a ray tests all surfaces at one place, which no tree can separate.
 */
#include "model/builder/rayWork.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "recurse/core/io/text.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/core/threads/resources.h"

namespace recurse {

namespace {

/** A surface or an instance, as rays find it. */
struct Candidate {
  uint64_t place; ///< hash
  double tests;   ///< by a ray that comes there
  const SourceLocation* location;
};

template <class Numbers> uint64_t hashOf(uint64_t group, const Numbers& numbers) {
  uint64_t hash = group;
  for (const double x : numbers) hash = hashCombine(hash, std::bit_cast<uint64_t>(x));
  return hash;
}

uint64_t placeOf(size_t group, const Bounds3f& b) {
  return hashOf(group, std::array<double, 6>{double(b.lower.x), double(b.lower.y), double(b.lower.z),
                                             double(b.upper.x), double(b.upper.y), double(b.upper.z)});
}

uint64_t placeOf(const ShapeGroups::Instance& i) {
  const Mat4d m = i.instance.start() * i.shape.start();
  return hashOf(i.group, std::span(&m[0][0], 16));
}

std::vector<Candidate> candidatesOf(const ShapeGroups& shapes) {
  std::vector<Candidate> all;
  for (size_t g = 0; g < shapes.groups().size(); ++g)
    for (const ShapeGroups::Placed& p : shapes.groups()[g].placed)
      all.push_back({placeOf(g, p.shape->bounds()), p.shape->testsOfRay(), &p.from->shape.location});
  for (const ShapeGroups::Instance& i : shapes.instances())
    all.push_back({placeOf(i), 1, i.partOf ? &i.partOf->location : &i.from->shape.location});
  return all;
}

/** The place with the most tests, of all that is there. */
Candidate costliest(std::vector<Candidate> all) {
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& a, const Candidate& b) { return a.place < b.place; });
  Candidate most{};
  for (size_t i = 0; i < all.size();) {
    Candidate here = all[i];
    while (++i < all.size() && all[i].place == here.place) here.tests += all[i].tests;
    if (here.tests > most.tests) most = here;
  }
  return most;
}

} // namespace

bool allowsRayWork(const ShapeGroups& shapes, const FilmSettings& film, Diagnostics& diagnostics) {
  constexpr double TEST_SECONDS = 1e-7; // a test of a ray and a surface
  const Candidate most = costliest(candidatesOf(shapes));
  if (!most.location) return true;
  const double pixels = double(film.crop.area());
  try {
    requireWork(formatted("a ray for each of %.3g pixels through about %.3g surfaces at one place", pixels,
                          most.tests),
                TEST_SECONDS * pixels * (most.tests - 1)); // the first needs no limit
    return true;
  } catch (const Error& e) {
    diagnostics.error(*most.location, e.what());
    return false;
  }
}

} // namespace recurse
