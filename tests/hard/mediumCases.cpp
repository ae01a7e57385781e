/** @file
 * 11. Thin and dense media, with absorption or scattering alone, with peaked phase functions, at any scale,
 * with the camera on a boundary, nested, without a closed boundary, and grids of one cell or with bad
 * numbers.
 */
#include "hardCase.h"

#include "model/nanoVdbTesting.h"
#include "recurse/scene/directives/loader.h"

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

/** View along z through a slab from z = 0 to `size`, from in front of it, under a uniform sky. */
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
  // A medium that emits as much as it absorbs hides the sky behind it.
  checkMean(report, "optical thickness 10000, glows", slab(medium("1e4", "0", "\"rgb Le\" [ 3 3 3 ]"), 1, -1),
            3, ofPaths(2e-3));
  // Light is reflected within the first free paths, or after thousands of events.
  checkMean(report, "optical thickness 10000, scatters", slab(medium("0", "1e4"), 1, -1, 1, 1, 16), 1,
            ofPaths(2e-2));
  for (const double depth : {1e-6, 1.0, 5.0}) {
    const std::string d = number(depth), name = "optical thickness " + shown("%g", depth);
    Budget budget = ofPaths(2e-3);
    if (depth > 1) budget.samples *= 8; // one path in 150 is transmitted
    checkMean(report, name + ", absorbs", slab(medium(d, "0"), 1, -1), std::exp(-depth), budget);
    // A furnace may have any shape: in a wide one the density of photons would be low. The view includes the
    // whole rim.
    if (depth <= 1)
      checkMean(report, name + ", scatters", slab(medium("0", d), 1, -1, 1, 1, 16), 1, ofPaths(5e-3));
  }
}

void needles(const Report& report) {
  // Very few photons fly along the camera's ray, and these have weights of thousands.
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
  // On the boundary as inside: the file defines the medium of the camera.
  const std::string text = slab(medium("1", "0"), 1, 0);
  checkMean(report, "the camera on a boundary", text, std::exp(-1.0), ofPaths(2e-3));
  // In the opposite direction the camera looks out of the medium, whatever the file says.
  const std::string out = view(2, 2, "0 0 1  0 0 2  0 1 0", orthographic(1e-3));
  const std::string inside = text.substr(text.find("MakeNamedMedium"));
  checkMean(report, "the camera on a boundary, looking out", out + inside, 1, ofPaths(2e-3));
}

void overlap(const Report& report) {
  // Two adjacent slabs: each has its own boundary in the common plane.
  const std::string second = "Shape \"box\" \"point3 p1\" [ -20 -20 1 ] \"point3 p2\" [ 20 20 2 ]\n";
  checkMean(report, "slabs that touch", slab(medium(".5", "0"), 1, -1) + second, std::exp(-1.0),
            ofPaths(2e-3));
  // A second medium, seen from both ends.
  const std::string other = "MakeNamedMedium \"n\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 1 1 ] "
                            "\"rgb sigma_s\" [ 0 0 0 "
                            "]\nMediumInterface \"n\" \"\"\n";
  const std::string both = slab(medium(".5", "0"), 1, -1) + other + second;
  checkMean(report, "slabs of two media", both, std::exp(-1.5), ofPaths(2e-3));
  checkMean(report, "slabs of two media, from behind",
            view(2, 2, "0 0 3  0 0 0  0 1 0", orthographic(1e-3)) + both.substr(both.find("MakeNamedMedium")),
            std::exp(-1.5), ofPaths(2e-3));
}

void nested(const Report& report) {
  const auto box = [](const char* media, double near, double far) {
    return "MediumInterface " + std::string(media) + "\nShape \"box\" \"point3 p1\" [ -20 -20 " +
           number(near) + " ] \"point3 p2\" [ 20 20 " + number(far) + " ]\n";
  };
  const std::string media = medium(".5", "0") +
                            "MakeNamedMedium \"n\" \"string type\" \"homogeneous\" "
                            "\"rgb sigma_a\" [ 1 1 1 ] \"rgb sigma_s\" [ 0 0 0 ]\n" +
                            constantLight(1) + "Material \"interface\"\n";
  const std::string within = media + box("\"m\" \"\"", 0, 1) + box("\"n\" \"m\"", 0.25, 0.75);
  // The next boundary defines the medium in front of it: none by the second slab, then the medium of the
  // first slab, then of the second.
  const std::string overlapping = media + box("\"m\" \"\"", 0, 1) + box("\"n\" \"\"", 0.5, 1.5);
  for (const bool behind : {false, true}) {
    const std::string eye =
        view(2, 2, behind ? "0 0 3  0 0 0  0 1 0" : "0 0 -1  0 0 0  0 1 0", orthographic(1e-3));
    const std::string from = behind ? ", from behind" : "";
    checkMean(report, "a slab within another" + from, eye + within, std::exp(-0.75), ofPaths(2e-3));
    checkMean(report, "slabs that overlap" + from, eye + overlapping, std::exp(-0.75), ofPaths(2e-3));
  }
}

void openBoundary(const Report& report) {
  const std::string open = "AttributeBegin\nMediumInterface \"m\" \"\"\nMaterial \"interface\"\n"
                           "Shape \"cylinder\" \"float zmin\" 0 \"float zmax\" 1\nAttributeEnd\n";
  Diagnostics diagnostics;
  const SceneDescription d = parseScene(view(2, 2, "0 0 -3  0 0 0  0 1 0", orthographic(1)) +
                                            medium("1", "1") + constantLight(1) + open,
                                        "hard.pbrt", ".", diagnostics);
  const bool built = buildScene(d, {}, diagnostics) != nullptr;
  int told = 0;
  for (const Diagnostic& one : diagnostics.all())
    told +=
        one.severity == Severity::WARNING && one.location.lineText().find("cylinder") != std::string::npos;
  report.holds("an open boundary", "-", "told " + std::to_string(told) + " times, with the shape's place",
               built && told == 1, diagnostics.format());
}

/** Expects that the scene is refused with the position in it and with `part` in the message. */
void refused(const Report& report, const std::string& what, const std::string& medium,
             const std::string& part = "") {
  Diagnostics diagnostics;
  const SceneDescription d = parseScene(slab("MakeNamedMedium \"m\" \"string type\" " + medium + "\n", 1, -1),
                                        "hard.pbrt", ".", diagnostics);
  const bool built = !diagnostics.hasErrors() && buildScene(d, {}, diagnostics);
  const std::string told = diagnostics.format();
  const bool isTold = told.find("hard.pbrt:") != std::string::npos && told.find(part) != std::string::npos;
  report.holds(what, "-", built ? "taken" : "refused", !built && isTold, told);
}

void badGrids(const Report& report) {
  for (const std::string density : {"nan", "-1", "1e20"}) {
    refused(report, "uniformgrid with " + density, "\"uniformgrid\" \"float density\" " + density);
    refused(report, "rgbgrid with " + density, "\"rgbgrid\" \"rgb sigma_s\" [ 0 " + density + " 0 ]");
  }
}

void badFiles(const Report& report) {
  using testing::NanoVdbWriter;
  const auto check = [&](const std::string& what, const std::string& bytes, const std::string& part) {
    const testing::NanoVdbFile file(bytes);
    refused(report, "nanovdb " + what, "\"nanovdb\" " + file.parameter(), file.path + part);
  };
  testing::WrittenGrid smoke;
  smoke(1, 2, 3) = 1e20f;
  const std::string dense = NanoVdbWriter::file({smoke});
  check("of density 1e20", dense, ": the densities are too high");
  check("that is cut off", dense.substr(0, dense.size() / 2), ": at byte");
  std::string large = dense;
  for (size_t axis = 0; axis < 3; ++axis)
    NanoVdbWriter::put(large, NanoVdbWriter::firstGrid(smoke) + NanoVdbWriter::GRID + 64 + 12 + 4 * axis,
                       (1 << 24) - 1);
  check("of 2^24 voxels along each axis", large,
        ": grid \"density\": a grid of 2097152 x 2097152 x 2097152 blocks needs");
  smoke.name = "heat";
  check("without a grid \"density\"", NanoVdbWriter::file({smoke}), " has no grid \"density\"");
  refused(report, "nanovdb that is not there", "\"nanovdb\" \"string filename\" \"/no/such.nvdb\"",
          "/no/such.nvdb");
}

void oneCell(const Report& report) {
  // Along the middle of the cell the density rises from a half to 1 and falls again.
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
  cases.push_back({11, "media in each other", false, nested});
  cases.push_back({11, "boundaries", false, openBoundary});
  cases.push_back({11, "grids", false, oneCell});
  cases.push_back({11, "bad grids", false, badGrids});
  cases.push_back({11, "bad files of grids", false, badFiles});
}

} // namespace recurse::hard
