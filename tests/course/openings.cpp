/** @file
 * Checks the solutions with openings, and the files given to students. Each line of the input has a command,
 * `check`, `mark` or `lamps`, an exercise, and the numbers of the openings; each output ends with a line of
 * dashes.
 */
#include "openings.h"

#include <cstdio>
#include <iostream>
#include <sstream>

#include <recurse/scene/directives/loader.h>

#include "checks/checks.h"

using namespace course;

namespace {

/** Samples two lamps of different shape, size and radiance: the density of each point is equal to the density
 * of a ray that hits it, and the mean of the inverse densities is the total area. Prints both errors. */
void checkLamps() {
  Diagnostics diagnostics;
  const SceneDescription description = parseScene(R"(
    Camera "perspective"
    WorldBegin
    Material "diffuse" "rgb reflectance" [ 0 0 0 ]
    AttributeBegin
      AreaLightSource "diffuse" "rgb L" [ 2 1 4 ]
      Shape "disk" "float radius" 1
    AttributeEnd
    AttributeBegin
      AreaLightSource "diffuse" "rgb L" [ 5 5 5 ]
      Translate 0 0 -3
      Shape "sphere" "float radius" .5
    AttributeEnd
  )",
                                                  "lamps.pbrt", ".", diagnostics);
  const std::unique_ptr<Scene> scene = buildScene(description, {}, diagnostics);
  diagnostics.throwIfErrors();
  constexpr int COUNT = 1 << 14;
  double area = 0, largestError = 0;
  TransportCounts counts;
  for (int i = 0; i < COUNT; ++i) {
    Sampler sampler(1, 2, uint32_t(i));
    const std::optional<LampPoint> lamp = sampleLamp(*scene, sampler);
    area += 1 / double(lamp->pdfArea) / COUNT;
    const Vec3f& normal = lamp->point.geometricNormal;
    const Ray ray{lamp->point.position + 0.1f * normal, -normal};
    const std::optional<Surface> hit = traceRay(*scene, ray, counts);
    largestError = std::max(largestError, std::abs(double(hit->lampPdfArea / lamp->pdfArea) - 1));
  }
  std::printf("%g %g\n", area / (2 * PI_D) - 1, largestError);
}

} // namespace

int main() {
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string command, exercise;
    words >> command >> exercise;
    openings.reset();
    for (size_t number = 0; words >> number;) openings.set(number);
    const bool isPath = exercise == "path";
    if (command == "lamps") {
      checkLamps();
    } else if (command == "check") {
      checkGaps(isPath ? pathTracerGaps() : photonMapperGaps());
    } else {
      const std::unique_ptr<Tracer> tracer = isPath ? makePathTracer() : makePhotonMapper(100000, 30);
      markPicture(*tracer, "switched-" + exercise, 32);
    }
    std::printf("-----\n");
    std::fflush(stdout);
  }
}
