/** @file
 * libFuzzer target: media of grids. The first byte chooses uniformgrid, rgbgrid or nanovdb, the remaining
 * bytes are their numbers or changes of a good file. Media that are not refused with the file's name have
 * finite coefficients that are not negative, and no extinction above its bound.
 */
#include <cmath>
#include <cstdio>
#include <fstream>

#include "fuzz/fuzzing.h"
#include "fuzz/nanoVdbFuzzing.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/scene/sceneImport.h"
#include "recurse/scene/directives/loader.h"

namespace {

using namespace recurse;

/** Numbers from bytes; zeros at the end. */
class Numbers {
 public:
  Numbers(const uint8_t* data, size_t size) : data(data), left(size) {}

  uint8_t byte() { return left == 0 ? 0 : (--left, *data++); }
  /** Small numbers, or special cases for a reader. */
  double real() {
    static const double HARD[] = {0,    1,    -1,    0.5,  1e-45, 1e-30,  1e-6,   1e6, 1e17, 1e18,
                                  1e20, 3e38, -3e38, 1e39, 1e300, -1e300, 1e-300, 2e3, 4e6};
    const uint8_t b = byte();
    return b < 128 ? b / 32.0 : HARD[b % std::size(HARD)];
  }
  std::string reals(int count) {
    std::string text = "[";
    for (int i = 0; i < count; ++i) text += " " + sceneText(real());
    return text + " ]";
  }

 private:
  const uint8_t* data;
  size_t left;
};

/** Parameters of a grid of any kind; each bit of `given` includes an optional one. */
std::string gridParameters(bool isRgb, Numbers& numbers) {
  const unsigned given = numbers.byte() | unsigned(numbers.byte()) << 8;
  const int sizes[] = {numbers.byte() % 4 + 1, numbers.byte() % 4 + 1, numbers.byte() % 4 + 1};
  const int cells = sizes[0] * sizes[1] * sizes[2] + (given & 1 ? numbers.byte() % 3 - 1 : 0);
  std::string text;
  for (int i = 0; i < 3; ++i)
    text += std::string("\"integer n") + "xyz"[i] + "\" " + std::to_string(sizes[i]) + " ";
  const auto add = [&](unsigned bit, const char* name, int count) {
    if (given >> bit & 1) text += "\"" + std::string(name) + "\" " + numbers.reals(count) + " ";
  };
  if (isRgb) {
    add(1, "rgb sigma_a", 3 * cells);
    add(2, "rgb sigma_s", 3 * cells);
    add(3, "rgb Le", 3 * cells);
  } else {
    text += "\"float density\" " + numbers.reals(cells) + " ";
    add(1, "rgb sigma_a", 3);
    add(2, "rgb sigma_s", 3);
    add(3, "rgb Le", 3);
    add(4, "float temperature", cells);
    add(5, "float temperatureoffset", 1);
    add(6, "float temperaturescale", 1);
  }
  add(7, "float scale", 1);
  add(8, "float Lescale", 1);
  add(9, "point3 p0", 3);
  add(10, "point3 p1", 3);
  return text;
}

bool isCoefficient(const Rgb& c) {
  return c.r >= 0 && c.g >= 0 && c.b >= 0 && c.r < INFINITE && c.g < INFINITE && c.b < INFINITE;
}

/** Traverses the medium's box from corner to corner and along its axes. */
void check(const Medium& medium) {
  const Bounds3f box = medium.bounds();
  const Vec3f size = box.upper - box.lower;
  for (const Vec3f towards :
       {Vec3f(1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, 0, 1), Vec3f(1, 1, 1), Vec3f(1, 0.3f, 0.7f)}) {
    const Vec3f way = towards * size, from = box.lower + (Vec3f(1) - towards) * 0.37f * size;
    const float length = glm::length(way);
    if (!(length > 0) || !std::isfinite(length)) continue;
    const Ray ray{from, way / length};
    MajorantSegments segments = medium.segments(ray, length);
    MajorantSegment s;
    float last = 0;
    for (int count = 0; segments.next(s); ++count) {
      if (count > 1000 || !(s.begin >= last) || !(s.end >= s.begin) || !(s.end <= length)) std::abort();
      last = s.end;
      for (const float part : {0.1f, 0.5f, 0.9f}) {
        const MediumPoint m = medium.at(ray.origin + ray.direction * (s.begin + (s.end - s.begin) * part));
        if (!isCoefficient(m.absorption) || !isCoefficient(m.scattering) || !isCoefficient(m.emission))
          std::abort();
        const Rgb most = s.majorant * 1.001f + Rgb(1e-30f), there = m.extinction();
        if (there.r > most.r || there.g > most.g || there.b > most.b) std::abort();
      }
    }
  }
}

void make(const char* kind, const std::string& parameters, const std::string& file) {
  Diagnostics diagnostics;
  const auto medium = plugIns().media.make(parseParameterText(kind, parameters), {}, diagnostics);
  if (medium)
    check(*medium);
  else if (!diagnostics.hasErrors() || diagnostics.format().find(file) == std::string::npos)
    std::abort(); // the error must name the file
}

void makeFromFile(const std::string& bytes) {
  const std::string name = scratchFile(".nvdb");
  std::ofstream(name, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  make("nanovdb", "\"string filename\" \"" + name + "\"", name);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  // A file may claim a box as large as memory, which is smaller for a fuzzer.
  static const bool LIMITED = (setMemoryLimit(1.5e9), true);
  (void)LIMITED;
  Numbers numbers(data + 1, size - 1);
  switch (data[0] % 4) {
  case 0:
    make("uniformgrid", gridParameters(false, numbers), "");
    break;
  case 1:
    make("rgbgrid", gridParameters(true, numbers), "");
    break;
  default:
    makeFromFile(changedNanoVdb(data + 1, size - 1));
  }
  return 0;
}
