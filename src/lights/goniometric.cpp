/** @file
 * A light at a point with an intensity of its own for each direction: from a picture, or from a photometric
 * file.
 */
#include <numbers>

#include "recurse/core/parallel.h"
#include "recurse/model/iesProfile.h"
#include "recurse/model/lightProbe.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

using std::numbers::pi;

class Goniometric final : public Light {
 public:
  Goniometric(EnvironmentMap distribution, const Rgb& intensity, const Mat4d& sceneFromLight)
      : distribution(std::move(distribution)), intensity(intensity),
        position(Vec3f(Vec3d(sceneFromLight[3]))), lightFromScene(glm::inverse(Mat3d(sceneFromLight))),
        sceneFromLight(sceneFromLight), determinant(std::abs(glm::determinant(lightFromScene))) {}

  LightKind kind() const override { return LightKind::POINT; }
  Rgb power() const override { return intensity * Rgb(distribution.integral()); }
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    const EnvironmentMap::Sample s =
        distribution.sample(sample.direction, EnvironmentMap::Sampling::COMPLETE);
    if (!(s.pdf > 0)) return {};
    const Vec3d direction =
        glm::normalize(sceneFromLight * Vec3d(s.direction.x, s.direction.z, s.direction.y));
    const Rgb along = intensityAlong(direction);
    const double pdf = pdfDirection(direction);
    return LeSample{
        {position, Vec3f(direction)}, along, 1, static_cast<float>(pdf), along * static_cast<float>(1 / pdf)};
  }
  LePdf pdfLe(const LeRay& ray) const override {
    return {0, static_cast<float>(pdfDirection(glm::normalize(Vec3d(ray.direction)))), true};
  }
  std::optional<LiSample> sampleLi(const Vec3f& point, float, const Vec2f&) const override {
    const Vec3f towards = position - point;
    const float distance2 = lengthSquared(towards);
    if (distance2 == 0) return {};
    const float distance = std::sqrt(distance2);
    const Rgb along = intensityAlong(-glm::normalize(Vec3d(towards)));
    if (isBlack(along)) return {};
    return LiSample{towards / distance, position, distance, along / distance2, 1, true};
  }

 private:
  /** In the picture, whose middle is light space +y. */
  Vec3d toPicture(const Vec3d& direction, double& stretch) const {
    const Vec3d d = lightFromScene * direction;
    const double length = glm::length(d);
    stretch = determinant / (length * length * length);
    return Vec3d(d.x, d.z, d.y) / length;
  }
  Rgb intensityAlong(const Vec3d& direction) const {
    double stretch;
    return intensity * distribution.value(toPicture(direction, stretch));
  }
  double pdfDirection(const Vec3d& direction) const {
    double stretch;
    const Vec3d d = toPicture(direction, stretch);
    return distribution.pdf(d, EnvironmentMap::Sampling::COMPLETE) * stretch;
  }

  EnvironmentMap distribution;
  Rgb intensity;
  Vec3f position;
  Mat3d lightFromScene, sceneFromLight;
  double determinant; ///< of lightFromScene
};

/** The profile as a picture of candela values; down is light space -y, C0 is +x, C90 is +z. */
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
      p.fail("profile", "the light has a picture, and a profile as well", "\"filename\" or \"profile\"");
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
           "a square, in the octahedral map of equal areas");
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
  const double determinant = glm::determinant(Mat3d(c.sceneFromLight));
  if (!std::isfinite(determinant) || determinant == 0)
    p.fail("", "the light's transform flattens directions: it cannot be inverted");
  double scale = p.real("scale");
  if (p.hasValue("power")) {
    const double whole = distribution.integral().g;
    if (!(whole > 0)) p.fail("power", "a light that is black everywhere cannot be scaled", "\"scale\"");
    scale *= p.real("power") / whole;
  }
  return std::make_unique<Goniometric>(std::move(distribution), Rgb(p.spectrum("I") * scale),
                                       c.sceneFromLight);
}

} // namespace

void registerGoniometric(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "goniometric",
        .summary =
            "A light at the origin of light space with an intensity of its own for each direction: of a "
            "picture in pbrt-v4's octahedral map, whose middle is +y, or of a photometric file, in "
            "which down is -y, C0 is +x and C90 is +z.",
        .parameters = {spectrumParameter("I", "1", SpectrumKind::ILLUMINANT, "factor for each colour [W/sr]"),
                       realParameter("scale", "1", "factor on I").range(0, 1e30),
                       realParameter("power", "", "total power [W]; replaces the scale of I").positive(),
                       stringParameter("filename", "", "a square picture; its colours are averaged"),
                       stringParameter("profile", "",
                                       "an IES file (IESNA LM-63), whose candela values count as W/sr")},
        .examples = {"\"rgb I\" [3 2 1]", "\"string filename\" \"scenes/textures/evening-square.hdr\"",
                     "\"string profile\" \"scenes/textures/downlight.ies\" \"float power\" 10"}},
       makeGoniometric});
}

} // namespace recurse
