/** @file
 * 3. Slivers, triangles without area, duplicates, coplanar surfaces, a plane of a million triangles. In
 * uniform light of radiance 1 a convex diffuse surface has the radiance of its albedo: self-intersections
 * make it darker.
 */
#include "hardCase.h"

namespace recurse::hard {

namespace {

class MeshText {
 public:
  int vertex(double x, double y, double z) {
    positions += number(x) + " " + number(y) + " " + number(z) + "  ";
    return count++;
  }
  void triangle(int a, int b, int c) {
    indices += std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "  ";
  }
  std::string text() const {
    return "Shape \"trianglemesh\" \"point3 P\" [ " + positions + "] \"integer indices\" [ " + indices +
           "]\n";
  }

 private:
  std::string positions, indices;
  int count = 0;
};

/** A rotation, so that no coordinate is exact. */
constexpr const char* TILT = "Rotate 33 .3 1 .2\n";

Budget even() {
  Budget b;
  b.samples = 32;
  b.photonSamples = 4;
  b.tolerance = 2e-3;
  // A thirtieth of the sky's photons arrives in the visible region.
  b.photons = 1e6;
  b.photonTolerance = 0.01 + 4 / std::sqrt(b.photons / 30);
  return b;
}

/** Strips of a unit square, every second one of width `thin`. */
std::string strips(double thin) {
  MeshText mesh;
  constexpr int STRIPS = 32;
  double y = -0.5;
  int left = mesh.vertex(-0.5, y, 0), right = mesh.vertex(0.5, y, 0);
  for (int i = 0; i < STRIPS; ++i) {
    y = i % 2 ? -0.5 + (i + 1) / double(STRIPS) : y + thin;
    const int l = mesh.vertex(-0.5, y, 0), r = mesh.vertex(0.5, y, 0);
    mesh.triangle(left, right, r);
    mesh.triangle(left, r, l);
    left = l;
    right = r;
  }
  return mesh.text();
}

void slivers(const Report& report) {
  checkMean(report, "square cut into strips of 1:1e7",
            view(16, 16, "0 0 2  0 0 0  0 1 0", orthographic(0.45)) + constantLight(1) + diffuse(0.5) +
                strips(1e-7),
            0.5, even());
  checkMean(report, "the same, tilted by 20 degrees",
            view(16, 16, "0 0 2  0 0 0  0 1 0", orthographic(0.3)) + constantLight(1) + diffuse(0.5) +
                "Rotate 20 .3 1 .2\n" + strips(1e-7),
            0.5, even());
  // A single sliver that fills the picture: 1 long, 1e-7 wide.
  Budget cameraOnly = even();
  // No photon of the sky would hit an area of 5e-8.
  cameraOnly.only = [](const Way& w) { return !w.directPhotons; };
  checkMean(report, "one sliver of 1:1e7 from near",
            view(8, 8, "0 0 1  0 0 0  0 1 0",
                 "Camera \"orthographic\" \"float screenwindow\" [ -.4 0 -4e-9 4e-9 ]") +
                constantLight(1) + diffuse(0.5) +
                "Shape \"trianglemesh\" \"point3 P\" [ -.5 -5e-8 0  .5 0 0  -.5 5e-8 0 ]\n",
            0.5, cameraOnly);
  // The sliver as a lamp.
  const double height = 1, power = 3;
  Budget lamp;
  lamp.tolerance = 0.01; // the lamp's length is half of its distance
  lamp.photons = 4e5;
  lamp.photonTolerance = 0.01 + photonNoise(1000);
  lamp.photonParameters = "\"float radius\" .1";
  // A line of length a along x, seen from below its middle: Φ/π ∫ h² / (h² + x²)² dx / a weighted by the
  // triangle's width, which grows from 0 to w along x.
  double irradiance = 0;
  constexpr int STEPS = 100000;
  const double length = 0.5;
  for (int i = 0; i < STEPS; ++i) {
    const double t = (i + 0.5) / STEPS, x = (t - 2.0 / 3) * length;
    irradiance += 2 * t / STEPS * std::pow(height, 2) / std::pow(height * height + x * x, 2);
  }
  irradiance *= power / M_PI;
  checkMean(report, "lamp in the shape of a sliver",
            view(8, 8, "0 0 .9  0 0 0  0 1 0", perspective(6)) + diffuse(0.5) +
                "Shape \"bilinearmesh\" \"point3 P\" [ -.6 -.6 0  .6 -.6 0  -.6 .6 0  .6 .6 0 ]\n" +
                diffuse(0) +
                "AreaLightSource \"diffuse\" \"float power\" 3\nShape \"trianglemesh\" \"point3 P\" [ " +
                number(-length * 2 / 3) + " 0 1  " + number(length / 3) + " 2.5e-8 1  " + number(length / 3) +
                " -2.5e-8 1 ]\n",
            0.5 / M_PI * irradiance, lamp);
}

/** A square with additional triangles without area: a point, a line, repeated corners; and every triangle
 * twice. */
std::string strewn(bool twice) {
  MeshText mesh;
  const int a = mesh.vertex(-0.5, -0.5, 0), b = mesh.vertex(0.5, -0.5, 0), c = mesh.vertex(0.5, 0.5, 0),
            d = mesh.vertex(-0.5, 0.5, 0), middle = mesh.vertex(0, 0, 0), again = mesh.vertex(-0.5, -0.5, 0),
            quarter = mesh.vertex(0.25, 0.25, 0);
  for (int i = 0; i < (twice ? 2 : 1); ++i) {
    mesh.triangle(a, b, c);
    mesh.triangle(a, c, d);
  }
  mesh.triangle(a, a, a);
  mesh.triangle(a, a, c);
  mesh.triangle(a, again, a);
  mesh.triangle(a, middle, c);
  mesh.triangle(middle, quarter, c);
  mesh.triangle(b, middle, d);
  return mesh.text();
}

void degenerate(const Report& report) {
  for (const bool twice : {false, true})
    for (const char* tilt : {"", TILT})
      checkMean(report,
                std::string(twice ? "and duplicates" : "triangles of no area") + (*tilt ? ", tilted" : ""),
                view(16, 16, "0 0 2  0 0 0  0 1 0", orthographic(0.3)) + constantLight(1) + diffuse(0.5) +
                    tilt + strewn(twice),
                0.5, even());
  // A lamp that contains such triangles: irradiance under the centre of a square (configuration factor of a
  // rectangle parallel to a small patch, four times the factor for a corner).
  const double x = 0.5, s = std::sqrt(1 + x * x), factor = 4 / (2 * M_PI) * 2 * (x / s * std::atan(x / s));
  Budget lamp;
  lamp.samples = 256;
  lamp.tolerance = 5e-3;
  lamp.photons = 4e5;
  lamp.photonTolerance = 0.01 + photonNoise(1000);
  lamp.photonParameters = "\"float radius\" .1";
  checkMean(report, "lamp with triangles of no area",
            view(8, 8, "0 0 .9  0 0 0  0 1 0", perspective(6)) + diffuse(0.5) +
                "Shape \"bilinearmesh\" \"point3 P\" [ -.6 -.6 0  .6 -.6 0  -.6 .6 0  .6 .6 0 ]\n" +
                diffuse(0) +
                "AreaLightSource \"diffuse\" \"rgb L\" [ 2 2 2 ]\nTranslate 0 0 1\nReverseOrientation\n" +
                strewn(false),
            0.5 * 2 * factor, lamp);
  // Only such triangles: no emission and no occlusion.
  checkMean(report, "lamp without any area",
            view(8, 8, "0 0 2  0 0 0  0 1 0", orthographic(0.3)) + constantLight(1) + diffuse(0.5) +
                strewn(false) +
                "AreaLightSource \"diffuse\" \"rgb L\" [ 9 9 9 ]\nShape \"trianglemesh\" \"point3 P\" "
                "[ -1 0 1  0 0 1  1 0 1 ]\n",
            0.5, even());
}

void coplanar(const Report& report) {
  const std::string square =
      "Shape \"bilinearmesh\" \"point3 P\" [ -.5 -.5 0  .5 -.5 0  -.5 .5 0  .5 .5 0 ]\n";
  const std::string quads = square +
                            "Shape \"trianglemesh\" \"point3 P\" [ -.6 -.5 0  .6 -.5 0  0 .9 0 ]\n"
                            "Shape \"disk\" \"float radius\" .5\n" +
                            square;
  for (const char* tilt : {"", TILT})
    checkMean(report, std::string("square, triangle and disc in one plane") + (*tilt ? ", tilted" : ""),
              view(16, 16, "0 0 2  0 0 0  0 1 0", orthographic(0.25)) + constantLight(1) + diffuse(0.5) +
                  tilt + quads,
              0.5, even());
  // With different albedos either surface may be visible, but no other value.
  const auto scene = sceneFrom(view(32, 32, "0 0 2  0 0 0  0 1 0", orthographic(0.25)) + constantLight(1) +
                               TILT + diffuse(0.2) + square + diffuse(0.6) + square);
  for (const Way& way : allWays(even().photons)) {
    const Rendered r = renderScene(*scene, way, even());
    report.atMost("albedo 0.2 and 0.6 in one plane", way.label, "off the middle by", std::abs(r.mean() - 0.4),
                  0.2 + (way.directPhotons ? 0.2 * even().photonTolerance : 1e-3) + 4 * r.standardError(),
                  r.unsound());
  }
}

/** 2 n² triangles in a tilted plane. */
void fine(const Report& report, int n) {
  MeshText mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) mesh.vertex(double(x) / n - 0.5, double(y) / n - 0.5, 0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int i = y * (n + 1) + x;
      mesh.triangle(i, i + 1, i + n + 2);
      mesh.triangle(i, i + n + 2, i + n + 1);
    }
  for (const char* tilt : {"", TILT})
    checkMean(report, shown("%.0f triangles in one plane", 2.0 * n * n) + (*tilt ? ", tilted" : ""),
              view(32, 32, "0 0 2  0 0 0  0 1 0", orthographic(0.3)) + constantLight(1) + diffuse(0.5) +
                  tilt + mesh.text(),
              0.5, even());
}

} // namespace

void addMeshCases(HardCases& cases) {
  cases.push_back({3, "slivers", false, slivers});
  cases.push_back({3, "degenerate", false, degenerate});
  cases.push_back({3, "coplanar", false, coplanar});
  cases.push_back({3, "fine mesh", false, [](const Report& r) { fine(r, SANITIZED ? 50 : 150); }});
  cases.push_back({3, "fine mesh", true, [](const Report& r) { fine(r, 708); }});
}

} // namespace recurse::hard
