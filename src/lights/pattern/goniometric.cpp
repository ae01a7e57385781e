/** @file
 * Point light with a separate intensity for each direction, from a picture or from a photometric
 * file.
 */
#include <numbers>

#include "lights/maps/lightProbe.h"
#include "lights/pattern/iesProfile.h"
#include "lights/pattern/patternLight.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

using std::numbers::pi;

class Goniometric final : public PatternLight {
 public:
  Goniometric(EnvironmentMap distribution, const Rgb& factor, const Mat4d& sceneFromLight)
      : PatternLight(sceneFromLight), distribution(std::move(distribution)), factor(factor) {}

  Rgb power() const override { return factor * Rgb(distribution.integral()); }

 private:
  /** Converts between light space and the picture, whose middle is light space +y. */
  static Vec3d swapped(const Vec3d& d) { return {d.x, d.z, d.y}; }

  Rgb intensity(const Vec3d& direction) const override {
    return factor * distribution.value(swapped(glm::normalize(direction)));
  }
  std::optional<Vec3d> sampleDirection(const Vec2f& u) const override {
    const EnvironmentMap::Sample s = distribution.sample(u, EnvironmentMap::Sampling::COMPLETE);
    if (!(s.pdf > 0)) return {};
    return swapped(s.direction);
  }
  double pdfDirection(const Vec3d& direction) const override {
    return distribution.pdf(swapped(glm::normalize(direction)), EnvironmentMap::Sampling::COMPLETE);
  }

  EnvironmentMap distribution;
  Rgb factor;
};

/** Profile as a picture of candela values; down is light space -y, C0 is +x, C90 is +z. */
EnvironmentMap pictureOf(const IesProfile& profile) {
  constexpr int SIZE = 512, PARTS = 3; // about the half degree of the finest files
  Image image(SIZE, SIZE, {"R", "G", "B"});
  parallelFor(size_t(SIZE), [&](size_t y) {
    for (int x = 0; x < SIZE; ++x) {
      double sum = 0;
      for (int k = 0; k < PARTS * PARTS; ++k) {
        const Vec2d place(x + (k % PARTS + 0.5) / PARTS, double(y) + (k / PARTS + 0.5) / PARTS);
        const Vec3d d = directionOfPlace(EnvironmentMapping::EQUAL_AREA, place / double(SIZE));
        // The picture has y and z of light space exchanged.
        const double vertical = std::atan2(std::hypot(d.x, d.y), -d.z), horizontal = std::atan2(d.y, d.x);
        sum += profile.intensity(vertical * 180 / pi, horizontal * 180 / pi);
      }
      std::fill_n(image.at(x, static_cast<int>(y)), 3, static_cast<float>(sum / (PARTS * PARTS)));
    }
  });
  const double integral = EnvironmentMap(image, EnvironmentMapping::EQUAL_AREA).integral().g;
  const double flux = profile.flux();
  if (integral > 0)
    for (float& v : image.pixels) v *= static_cast<float>(flux / integral);
  return {image, EnvironmentMapping::EQUAL_AREA};
}

EnvironmentMap readDistribution(const Parameters& p) {
  if (p.has("profile")) {
    if (p.has("filename"))
      p.fail("profile", "both a picture and a profile are given", "\"filename\" or \"profile\"");
    const std::string path = p.filePath("profile");
    try {
      return pictureOf(IesProfile::read(path));
    } catch (const Error& e) {
      p.fail("profile", path + ": " + e.what(), "an IES file (IESNA LM-63) of type C");
    }
  }
  if (!p.has("filename")) {
    Image white(1, 1, {"R", "G", "B"});
    white.pixels = {1, 1, 1};
    return {white, EnvironmentMapping::EQUAL_AREA};
  }
  Image image = readLightPicture(p);
  if (image.width != image.height)
    p.fail("filename",
           "the picture has " + std::to_string(image.width) + " by " + std::to_string(image.height) +
               " pixels",
           "a square picture, in the octahedral map of equal areas");
  const int luminanceChannel = image.channel("Y");
  Image grey(image.width, image.height, {"R", "G", "B"});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const float* from = image.at(x, y);
      const float value = luminanceChannel >= 0 ? from[luminanceChannel] : (from[0] + from[1] + from[2]) / 3;
      std::fill_n(grey.at(x, y), 3, value);
    }
  return {grey, EnvironmentMapping::EQUAL_AREA};
}

std::unique_ptr<Light> makeGoniometric(const Parameters& p, const LightContext& c) {
  EnvironmentMap distribution = readDistribution(p);
  PatternLight::requireInvertible(c.sceneFromLight, p);
  double scale = p.real("scale");
  if (p.hasValue("power")) {
    const double whole = distribution.integral().g;
    if (!(whole > 0)) p.fail("power", "a black light has no power to scale", "\"scale\"");
    scale *= p.real("power") / whole;
  }
  return std::make_unique<Goniometric>(std::move(distribution), Rgb(p.spectrum("I") * scale),
                                       c.sceneFromLight);
}

} // namespace

void registerGoniometric(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "goniometric",
        .summary = "A light at the origin of light space with an intensity for each direction: from a "
                   "picture in pbrt-v4's octahedral map, with +y in the middle, or from a photometric file, "
                   "in which down is -y, C0 is +x and C90 is +z.",
        .parameters = {spectrumParameter("I", "1", SpectrumKind::ILLUMINANT, "factor on each colour [W/sr]"),
                       realParameter("scale", "1", "factor on I").range(0, 1e30),
                       realParameter("power", "", "total power [W]; replaces the scale of I").positive(),
                       stringParameter("filename", "",
                                       "square picture of the intensity; the mean of its colours is used"),
                       stringParameter("profile", "",
                                       "IES file (IESNA LM-63); its values in candela are used as W/sr")},
        .examples = {"\"rgb I\" [3 2 1]", "\"string filename\" \"scenes/textures/evening-square.hdr\"",
                     "\"string profile\" \"scenes/textures/downlight.ies\" \"float power\" 10"}},
       makeGoniometric});
}

} // namespace recurse
