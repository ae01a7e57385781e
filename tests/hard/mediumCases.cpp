/** @file
 * 11. Media thin and thick, that absorb all or nothing, scatter in needles, at any scale, with the camera on
 * their boundary, and grids of one cell.
 */
#include "hardCase.h"

namespace recurse::hard {

namespace {

Budget ofPaths(double tolerance) {
  Budget b;
  b.samples = 1024;
  b.photonSamples = 32;
  b.photons = 2e4;
  b.tolerance = tolerance;
  b.photonTolerance = tolerance + 0.02;
  b.only = [](const Way& way) { return way.integrator == "path" || way.integrator == "photonmap"; };
  return b;
}

std::string medium(const std::string& absorption, const std::string& scattering,
                   const std::string& more = {}) {
  return "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ " + absorption + " " +
         absorption + " " + absorption + " ] \"rgb sigma_s\" [ " + scattering + " " + scattering + " " +
         scattering + " ] " + more + "\n";
}

/** Along z through a slab from z = 0 to `size`, from before it, under an even sky. */
std::string slab(const std::string& medium, double size, double eye, double width = 20, double window = 1e-3,
                 int pixels = 2) {
  const std::string s = number(size), w = number(width * size);
  return view(pixels, pixels, "0 0 " + number(eye) + "  0 0 " + number(eye + size) + "  0 1 0",
              orthographic(size * window)) +
         medium + constantLight(1) +
         "MediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"box\" \"point3 p1\" [ -" + w + " -" +
         w + " 0 ] \"point3 p2\" [ " + w + " " + w + " " + s + " ]\n";
}

void thickness(const Report& report) {
  // What emits all that it absorbs hides the sky behind.
  checkMean(report, "optical thickness 10000, glows", slab(medium("1e4", "0", "\"rgb Le\" [ 3 3 3 ]"), 1, -1),
            3, ofPaths(2e-3));
  // Light is turned back from the first free paths, or not for thousands of events.
  checkMean(report, "optical thickness 10000, scatters", slab(medium("0", "1e4"), 1, -1, 1, 1, 16), 1,
            ofPaths(2e-2));
  for (const double depth : {1e-6, 1.0, 5.0}) {
    const std::string d = number(depth), name = "optical thickness " + shown("%g", depth);
    Budget budget = ofPaths(2e-3);
    if (depth > 1) budget.samples *= 8; // one path in 150 comes through
    checkMean(report, name + ", absorbs", slab(medium(d, "0"), 1, -1), std::exp(-depth), budget);
    // A furnace is of any shape: photons in a wide one would be far apart. All of it is seen, rim and all.
    if (depth <= 1)
      checkMean(report, name + ", scatters", slab(medium("0", d), 1, -1, 1, 1, 16), 1, ofPaths(5e-3));
  }
}

void needles(const Report& report) {
  // Of photons hardly any fly along the camera's ray, and those count thousandfold.
  Budget budget = ofPaths(5e-3);
  budget.only = [](const Way& way) { return way.integrator == "path"; };
  for (const double g : {-0.99, 0.99})
    checkMean(report, "g = " + shown("%g", g), slab(medium("0", "3", "\"float g\" " + number(g)), 1, -1), 1,
              budget);
}

void scales(const Report& report) {
  for (const double scale : {1e-6, 1e6})
    checkMean(report, "scale " + shown("%g", scale), slab(medium(number(0.7 / scale), "0"), scale, -scale),
              std::exp(-0.7), ofPaths(2e-3));
}

void boundary(const Report& report) {
  // On the boundary, as inside: the file says what the camera stands in.
  const std::string text = slab(medium("1", "0"), 1, 0);
  checkMean(report, "the camera on a boundary", text, std::exp(-1.0), ofPaths(2e-3));
  // Turned round it looks out of the medium, whatever the file says.
  const std::string out = view(2, 2, "0 0 1  0 0 2  0 1 0", orthographic(1e-3));
  const std::string inside = text.substr(text.find("MakeNamedMedium"));
  checkMean(report, "the camera on a boundary, looking out", out + inside, 1, ofPaths(2e-3));
}

void overlap(const Report& report) {
  // Two slabs that touch: the boundary in between is one of each.
  const std::string second = "Shape \"box\" \"point3 p1\" [ -20 -20 1 ] \"point3 p2\" [ 20 20 2 ]\n";
  checkMean(report, "slabs that touch", slab(medium(".5", "0"), 1, -1) + second, std::exp(-1.0),
            ofPaths(2e-3));
  // Another medium, seen from either end.
  const std::string other = "MakeNamedMedium \"n\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 1 1 ] "
                            "\"rgb sigma_s\" [ 0 0 0 "
                            "]\nMediumInterface \"n\" \"\"\n";
  const std::string both = slab(medium(".5", "0"), 1, -1) + other + second;
  checkMean(report, "slabs of two media", both, std::exp(-1.5), ofPaths(2e-3));
  checkMean(report, "slabs of two media, from behind",
            view(2, 2, "0 0 3  0 0 0  0 1 0", orthographic(1e-3)) + both.substr(both.find("MakeNamedMedium")),
            std::exp(-1.5), ofPaths(2e-3));
}

void oneCell(const Report& report) {
  // Along its middle the density rises from a half to 1 and falls again.
  checkMean(report, "a grid of one cell",
            slab("MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"point3 p0\" [ -20 -20 0 ] \"point3 "
                 "p1\" [ 20 20 1 "
                 "] \"float density\" 1 \"rgb sigma_a\" [ 1 1 1 ] \"rgb sigma_s\" [ 0 0 0 ]\n",
                 1, -1),
            std::exp(-0.75), ofPaths(1e-2));
}

} // namespace

void addMediumCases(HardCases& cases) {
  cases.push_back({11, "thin and thick media", false, thickness});
  cases.push_back({11, "needles", false, needles});
  cases.push_back({11, "media of any scale", false, scales});
  cases.push_back({11, "camera and boundary", false, boundary});
  cases.push_back({11, "media that touch", false, overlap});
  cases.push_back({11, "grids", false, oneCell});
}

} // namespace recurse::hard
