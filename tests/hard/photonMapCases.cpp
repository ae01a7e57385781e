/** @file
 * 8. The photon map with none, one, two and very many photons, all of them at one point; radii larger than
 * the scene and smaller than any distance; light through thin walls, into corners and over edges.
 */
#include "../transport/kernelTesting.h"
#include "hardCase.h"

#include "recurse/core/threads/parallel.h"
#include "transport/density/gather.h"

namespace recurse::hard {

namespace {

class NoTextures final : public TextureLookup {
  TexturedRgb rgb(const Parameters& p, const std::string& n) const override {
    return {Rgb(p.spectrum(n)), nullptr};
  }
  TexturedRgb real(const Parameters&, const std::string&) const override { return {}; }
};

constexpr double ALBEDO = 0.5;

/** Estimate of gather() from photons around the origin of a floor, towards a camera above. */
double gathered(const std::vector<Photon>& photons, const GatherSettings& settings, float footprint,
                PhotonIndexKind kind, std::string& problem) {
  Diagnostics diagnostics;
  const NoTextures textures;
  const auto material = plugIns().materials.make(parseParameterText("diffuse", "\"float reflectance\" 0.5"),
                                                 MaterialContext{textures, {}}, diagnostics);
  diagnostics.throwIfErrors();
  SurfacePoint point{};
  point.geometricNormal = point.shadingNormal = {0, 0, 1};
  BsdfArena arena;
  const ScatteringPoint scattering(*material->bsdfAt(point, arena), point);
  PhotonMap map;
  map.build(photons, kind);
  if (map.size() != photons.size()) problem = "photons were refused";
  const PathClasses classes;
  TransportCounts counts;
  PathRadiance out(classes, counts);
  gather(map, settings, scattering, point, {0, 0, 1}, footprint, Rgb(1),
         classes.step(classes.cameraStart(), PathEvent::D), out);
  if (counts.nonFinite > 0) problem = "the estimate is not finite";
  return double(out.total().g);
}

Photon photonAt(float x, float y, float power) {
  Photon p;
  p.position = {x, y, 0};
  p.direction = p.normal = packDirection({0, 0, 1});
  p.power = Rgb(power);
  return p;
}

void few(const Report& report) {
  const ThreadPool pool;
  const std::vector<Photon> two = {photonAt(0.03f, 0.04f, 2), photonAt(0, -0.1f, 3)};
  for (const PhotonIndexKind kind : {PhotonIndexKind::KDTREE, PhotonIndexKind::FLANN}) {
    const std::string index = kind == PhotonIndexKind::KDTREE ? "kd-tree" : "flann";
    for (int n = 0; n <= 2; ++n) {
      const std::vector<Photon> photons(two.begin(), two.begin() + n);
      for (const Kernel kernel : testing::ALL_KERNELS)
        for (const int nearest : {0, 1, 100}) {
          GatherSettings settings;
          settings.kernel = kernel;
          settings.nearest = nearest;
          settings.radius = 0.2f;
          // Closed form: ρ/π Σ Φ K(d). The farther of the two nearest photons is at the end of the disc,
          // where its weight is zero.
          double expected = 0;
          if (nearest != 1 || n == 0)
            for (const Photon& p : photons)
              expected += ALBEDO / M_PI * double(p.power.g) *
                          double(testing::kernelValue(
                              kernel, p.position.x * p.position.x + p.position.y * p.position.y, 0.04f));
          std::string problem;
          const double got = gathered(photons, settings, 0, kind, problem);
          report.atMost(shown("%.0f photons, ", n) + testing::kernelName(kernel) +
                            (nearest ? shown(", %.0f nearest", nearest) : ", all within the radius"),
                        index, "error", std::abs(got - expected), 1e-6 * std::max(1.0, expected), problem);
        }
    }
  }
  // Pictures from one to three photons, averaged over many maps. A lamp sends all its light down onto a
  // floor; the picture contains the whole disc of every photon: ρ Φ / π over its area.
  constexpr int PICTURES = SANITIZED ? 20 : 400;
  for (const int photons : {1, 2, 3}) {
    const auto scene =
        sceneFrom(view(4, 4, "0 0 1  0 0 0  0 1 0", orthographic(0.5)) + diffuse(ALBEDO) +
                  "Shape \"disk\" \"float radius\" 2\n"
                  "LightSource \"spot\" \"float power\" 3 \"point3 from\" [ 0 0 2 ] \"point3 to\" [ 0 0 0 ] "
                  "\"float coneangle\" 5 \"float conedeltaangle\" 0\n");
    const double expected = ALBEDO * 3 / M_PI;
    for (const Way& way : allWays(photons, "\"float radius\" .3 \"string kernel\" \"constant\"")) {
      if (!way.directPhotons) continue;
      double sum = 0, squares = 0;
      std::string problem;
      for (int i = 0; i < PICTURES; ++i) {
        const Rendered r = renderScene(*scene, way, 16, static_cast<uint64_t>(i + 1));
        sum += r.mean();
        squares += r.mean() * r.mean();
        if (problem.empty()) problem = r.unsound();
      }
      const double mean = sum / PICTURES,
                   error = std::sqrt(std::max(squares / PICTURES - mean * mean, 0.0) / PICTURES);
      report.atMost(shown("%.0f pictures from ", PICTURES) + shown("%.0f photons each", photons), way.label,
                    "relative error", std::abs(mean / expected - 1), 1e-3 + 4 * error / expected, problem);
    }
  }
}

void oneSpot(const Report& report) {
  const ThreadPool pool;
  for (const size_t count : {size_t(2), size_t(1000), size_t(1000000)})
    for (const PhotonIndexKind kind : {PhotonIndexKind::KDTREE, PhotonIndexKind::FLANN}) {
      if (kind == PhotonIndexKind::FLANN && count > 1000)
        continue; // the search of FLANN is linear in this case
      const std::string index = kind == PhotonIndexKind::KDTREE ? "kd-tree" : "flann";
      const std::vector<Photon> photons(count, photonAt(0, 0, 1 / static_cast<float>(count)));
      for (const int nearest : {0, 100}) {
        GatherSettings settings;
        settings.kernel = Kernel::CONSTANT;
        settings.nearest = nearest;
        settings.radius = 0.1f;
        // More photons in the spot than the search asks for: the smallest disc is the pixel's width, 0.02.
        const bool spot = nearest > 0 && count >= size_t(nearest);
        const double expected = ALBEDO / M_PI / (M_PI * (spot ? 1e-4 : 1e-2));
        std::string problem;
        const double got = gathered(photons, settings, 0.02f, kind, problem);
        // Eight partial sums in floats, with an eighth of the photons each.
        const double drift = 1e-5 + double(count) / 8 * 0x1p-24;
        report.atMost(shown("%.0f photons", double(count)) +
                          (nearest ? ", 100 nearest" : ", all within the radius"),
                      index, "relative error", std::abs(got / expected - 1), drift, problem);
        // Without a pixel width the disc has no area: the infinite density must be refused, not added to the
        // sum.
        if (!spot) continue;
        problem.clear();
        const double pinpoint = gathered(photons, settings, 0, kind, problem);
        report.holds(shown("%.0f photons, 100 nearest, no pixel width", double(count)), index,
                     "radiance " + shown("%.3g", pinpoint), problem.empty() && std::isfinite(pinpoint),
                     problem);
      }
    }
  // A beam of a spot light with a cone of 0.001 degrees: only energy can be checked. The floor's mean
  // radiance times the picture's area times π is ρ Φ.
  const auto scene =
      sceneFrom(view(9, 9, "0 0 1  0 0 0  0 1 0", orthographic(0.5)) + diffuse(0.5) +
                "Shape \"disk\" \"float radius\" 2\n"
                "LightSource \"spot\" \"float power\" 3 \"point3 from\" [ .01 .01 1 ] \"point3 to\" "
                "[ .01 .01 0 ] \"float coneangle\" .001 \"float conedeltaangle\" 0\n");
  for (const Way& way : allWays(1e4)) {
    if (!way.directPhotons) continue; // no camera path would hit the lit spot
    const Rendered r = renderScene(*scene, way, 1024);
    report.atMost("needle of light", way.label, "energy off by", std::abs(r.mean() * M_PI / (ALBEDO * 3) - 1),
                  0.01 + 4 * r.standardError() * M_PI / (ALBEDO * 3), r.unsound());
  }
}

/** A closed sphere that emits 1/2 and reflects 1/2: the radiance is 1 at any number of photons. */
void veryMany(const Report& report, double photons) {
  const auto scene =
      sceneFrom(view(32, 32, ".3 .2 -.5  0 0 0  0 1 0", perspective(60)) + diffuse(0.5) +
                "ReverseOrientation\nAreaLightSource \"diffuse\" \"rgb L\" [ .5 .5 .5 ]\nShape "
                "\"sphere\"\n");
  for (const Way& way : allWays(photons)) {
    if (!way.usesPhotons) continue;
    const Rendered r = renderScene(*scene, way, 4);
    report.atMost(shown("%.0f photons stored", double(r.statistics.photonsStored)), way.label,
                  "relative error", std::abs(r.mean() - 1), 5e-3, r.unsound());
  }
}

void radii(const Report& report) {
  const std::string scene = view(8, 8, "0 0 .8  0 0 0  0 1 0", perspective(6)) + diffuse(0.5) +
                            "Shape \"disk\" \"float radius\" 1\n"
                            "LightSource \"point\" \"rgb I\" [ 1 1 1 ] \"point3 from\" [ 0 0 1 ]\n";
  Budget budget;
  budget.photons = 4e5;
  budget.photonSamples = 64;
  budget.only = [](const Way& w) { return w.directPhotons; };
  budget.photonTolerance = 0.02;
  // All photons of the plate, whose flux is 2π (1 - 1/√2), spread over the plate, or over the search disc.
  const double spreadOverPlate = ALBEDO / M_PI * 2 * (1 - std::sqrt(0.5));
  const std::string wide = "\"float radius\" 1000 \"string kernel\" \"constant\"";
  budget.photonParameters = wide;
  checkMean(report, "radius of 1000 in a scene of 1", scene, spreadOverPlate, budget);
  budget.photonParameters = wide + " \"bool edges\" false";
  checkMean(report, "radius of 1000 in a scene of 1, blind to edges", scene, spreadOverPlate / 1e6, budget);
  // A radius below the width of a pixel, 0.01: the disc has the pixel's width, and the picture is right.
  budget.photonParameters = "\"float radius\" 1e-6";
  budget.photonSamples = 256;
  // About 64 discs of 5 photons each cover the picture.
  budget.photonTolerance = 0.15;
  checkMean(report, "radius of 1e-6", scene, ALBEDO / M_PI, budget);
}

/** Two rooms side by side with a wall of thickness 1e-3 between them; only the left one has light. */
std::string twoRooms(const std::string& lookAt, double half) {
  return view(16, 16, lookAt, orthographic(half)) + diffuse(0.7) +
         // Floor, ceiling, back, front, outer walls
         "Shape \"bilinearmesh\" \"point3 P\" [ -2 0 0  2 0 0  -2 2 0  2 2 0 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -2 0 2  2 0 2  -2 2 2  2 2 2 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -2 0 0  2 0 0  -2 0 2  2 0 2 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -2 2 0  2 2 0  -2 2 2  2 2 2 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -2 0 0  -2 2 0  -2 0 2  -2 2 2 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ 2 0 0  2 2 0  2 0 2  2 2 2 ]\n"
         // The wall, both faces
         "Shape \"bilinearmesh\" \"point3 P\" [ -.0005 0 0  -.0005 2 0  -.0005 0 2  -.0005 2 2 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ .0005 0 0  .0005 2 0  .0005 0 2  .0005 2 2 ]\n" +
         diffuse(0) +
         "AreaLightSource \"diffuse\" \"rgb L\" [ 10 10 10 ]\nTranslate -1 1 1.95\nReverseOrientation\n"
         "Shape \"disk\" \"float radius\" .3\n";
}

void walls(const Report& report) {
  const Way path = allWays(1)[0];
  const auto lit = sceneFrom(twoRooms("-1 1 1  0 1 1  0 0 1", 0.5)); // the lit face of the wall
  const double brightness = renderScene(*lit, path, SANITIZED ? 32 : 256).mean();
  struct Place {
    const char *name, *lookAt;
    double half;
  };
  for (const Place& place : {Place{"dark face of the wall", "1 1 1  0 1 1  0 0 1", 0.5},
                             Place{"dark floor away from the wall", "1 1 1  1 1 0  0 1 0", 0.5},
                             Place{"dark floor beside the wall", ".11 1 1  .11 1 0  0 1 0", 0.1}}) {
    const auto dark = sceneFrom(twoRooms(place.lookAt, place.half));
    for (const Way& way : allWays(2e5, "\"float radius\" .1")) {
      const Rendered r = renderScene(*dark, way, SANITIZED ? 4 : 16);
      report.atMost(std::string(place.name) + ", radius 100 times its thickness", way.label,
                    "leak over lit side", r.mean() / brightness, 0.01, r.unsound());
    }
  }
}

/** Bias of the density estimate if its disc is not in one plane: along a concave corner (light of the second
 * face is left out), and along a convex edge (half of the disc has no surface). The path tracer is the
 * reference; the mean is over a strip as wide as the radius on either side. */
void corners(const Report& report) {
  const std::string inner = diffuse(0.7) +
                            "Shape \"bilinearmesh\" \"point3 P\" [ 0 -1 0  1 -1 0  0 1 0  1 1 0 ]\n"
                            "Shape \"bilinearmesh\" \"point3 P\" [ 0 -1 0  0 1 0  0 -1 1  0 1 1 ]\n";
  const std::string outer = diffuse(0.7) +
                            "Shape \"bilinearmesh\" \"point3 P\" [ 0 -1 0  1 -1 0  0 1 0  1 1 0 ]\n"
                            "Shape \"bilinearmesh\" \"point3 P\" [ 0 -1 -1  0 1 -1  0 -1 0  0 1 0 ]\n";
  const std::string lamp = diffuse(0) +
                           "AreaLightSource \"diffuse\" \"rgb L\" [ 10 10 10 ]\nTranslate .6 0 1.4\n"
                           "Shape \"sphere\" \"float radius\" .2\n";
  const std::string from = "LookAt .05 0 2  .05 0 0  0 1 0\n";
  const std::string head =
      "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\nPixelFilter \"box\"\n" + from +
      "Camera \"orthographic\" \"float screenwindow\" [ -.04999 .04999 -.5 .5 ]\nWorldBegin\n";
  struct Place {
    const char* name;
    const std::string& surfaces;
    double bound;
  };
  for (const Place& place :
       {Place{"strip along a concave corner", inner, 0.4}, Place{"strip along an edge", outer, 0.4}}) {
    const auto scene = sceneFrom(head + place.surfaces + lamp);
    Way path;
    for (const Way& way : allWays(4e5, "\"float radius\" .1")) {
      if (!way.usesPhotons && path.integrator.empty()) path = way;
    }
    const double truth = renderScene(*scene, path, SANITIZED ? 64 : 512).mean();
    for (const Way& way : allWays(4e5, "\"float radius\" .1")) {
      if (!way.usesPhotons) continue;
      const Rendered r = renderScene(*scene, way, 16);
      report.atMost(place.name, way.label, "bias", std::abs(r.mean() / truth - 1),
                    way.directPhotons ? place.bound : 0.1, r.unsound());
    }
  }
}

} // namespace

void addPhotonMapCases(HardCases& cases) {
  cases.push_back({8, "few photons", false, few});
  cases.push_back({8, "all in one spot", false, oneSpot});
  cases.push_back({8, "many photons", false, [](const Report& r) { veryMany(r, 3e5); }});
  cases.push_back({8, "50 million photons", true, [](const Report& r) { veryMany(r, 5e7); }});
  cases.push_back({8, "search radius", false, radii});
  cases.push_back({8, "thin wall", false, walls});
  cases.push_back({8, "corner and edge", false, corners});
}

} // namespace recurse::hard
