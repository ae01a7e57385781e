/** @file
 * The program of the course: checks the exercises and renders with them.
 */
#include <cstdio>
#include <cstdlib>
#include <exception>

#include <recurse/core/io/error.h>

#include "checks/checks.h"

using namespace course;

namespace {

constexpr const char* USAGE = R"(Usage:
  course check path|photons [--no-picture]            says which gaps are filled right, and marks a picture
  course render path|photons SCENE OUTPUT [SAMPLES]   renders a scene file to an EXR or PNG (16 samples per pixel)

The exit status is 0 if everything is right, 1 if not, 2 for a wrong command.
)";

constexpr int PHOTONS = 100000, NEAREST = 30;
constexpr int PATH_SAMPLES = 64, PHOTON_SAMPLES = 32; ///< of a pixel of the picture that is marked

bool isPath(const std::string& exercise) {
  if (exercise == "path") return true;
  if (exercise == "photons") return false;
  throw Error("the exercises are 'path' and 'photons', not '" + exercise + "'", ExitStatus::BAD_USAGE);
}

std::unique_ptr<Tracer> tracerOf(const std::string& exercise) {
  return isPath(exercise) ? makePathTracer() : makePhotonMapper(PHOTONS, NEAREST);
}

int check(const std::string& exercise, bool withPicture) {
  bool isRight = checkGaps(isPath(exercise) ? pathTracerGaps() : photonMapperGaps());
  if (withPicture)
    isRight = markPicture(*tracerOf(exercise), exercise, isPath(exercise) ? PATH_SAMPLES : PHOTON_SAMPLES) &&
              isRight;
  return isRight ? 0 : 1;
}

int run(const std::vector<std::string>& arguments) {
  const size_t count = arguments.size();
  if (count >= 2 && arguments[0] == "check" && (count == 2 || (count == 3 && arguments[2] == "--no-picture")))
    return check(arguments[1], count == 2);
  if ((count == 4 || count == 5) && arguments[0] == "render") {
    const int samples = count == 5 ? std::atoi(arguments[4].c_str()) : 16;
    if (samples < 1) throw Error("the number of samples is not positive", ExitStatus::BAD_USAGE);
    renderPicture(*tracerOf(arguments[1]), arguments[2], arguments[3], samples);
    return 0;
  }
  std::fputs(USAGE, stderr);
  return count == 1 && (arguments[0] == "-h" || arguments[0] == "--help") ? 0 : 2;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const Error& e) {
    std::fprintf(stderr, "course: %s\n", e.what());
    return int(e.status());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "course: %s\n", e.what());
    return 1;
  }
}
