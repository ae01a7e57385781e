/** @file
 * Slide projector: a light at a point that projects a picture.
 */
#include <numbers>

#include "lights/maps/lightProbe.h"
#include "lights/pattern/patternLight.h"
#include "recurse/core/sampling/distribution2d.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

using std::numbers::pi;

/** Projector at the origin of light space that projects a picture along +z. The intensity is taken from
 * the nearest pixel. */
class Projection final : public PatternLight {
 public:
  Projection(Image slide, double fov, const Rgb& scale, const Mat4d& sceneFromLight)
      : PatternLight(sceneFromLight), image(std::move(slide)), scale(scale) {
    const double half = std::tan(fov / 2 * pi / 180), aspect = double(image.width) / image.height;
    size = aspect > 1 ? Vec2d(half * aspect, half) : Vec2d(half, half / aspect);
    std::vector<double> cells;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const double part = solidAngle({(x + 0.5) / image.width, (y + 0.5) / image.height});
        cells.push_back(double(luminance(image.rgb(x, y))) * part);
        integral += Rgbd(image.rgb(x, y)) * (part / (double(image.width) * image.height));
      }
    table = WindowedDistribution2d(image.width, image.height, cells);
    total = table.sum({});
  }
  /** Integral of the picture over the lit directions. */
  const Rgbd& wholeIntegral() const { return integral; }
  void multiply(double factor) { scale *= static_cast<float>(factor); }

  Rgb power() const override { return Rgb(integral) * scale; }

 private:
  /** Jacobian of the picture [sr per unit area]. */
  double solidAngle(const Vec2d& place) const {
    const Vec2d p = (place * 2.0 - 1.0) * size;
    return 4 * size.x * size.y * std::pow(1 + glm::dot(p, p), -1.5);
  }
  /** Position of a direction in the picture, from its top left; empty where it is not lit. */
  std::optional<Vec2d> placeOf(const Vec3d& d) const {
    if (!(d.z > 0)) return {};
    const Vec2d place((d.x / (d.z * size.x) + 1) / 2, (1 - d.y / (d.z * size.y)) / 2);
    if (!(place.x >= 0 && place.x <= 1 && place.y >= 0 && place.y <= 1)) return {};
    return place;
  }
  Rgb intensity(const Vec3d& direction) const override {
    const std::optional<Vec2d> place = placeOf(direction);
    if (!place) return BLACK;
    return scale * image.rgb(std::min(static_cast<int>(place->x * image.width), image.width - 1),
                             std::min(static_cast<int>(place->y * image.height), image.height - 1));
  }
  std::optional<Vec3d> sampleDirection(const Vec2f& u) const override {
    if (!(total > 0)) return {};
    const Vec2d place = table.sample({}, Vec2d(u));
    return Vec3d((place.x * 2 - 1) * size.x, (1 - place.y * 2) * size.y, 1);
  }
  double pdfDirection(const Vec3d& direction) const override {
    const std::optional<Vec2d> place = placeOf(direction);
    return place ? table.pdf(total, *place) / solidAngle(*place) : 0;
  }

  Image image;
  Rgb scale;
  Vec2d size; ///< half the size of the picture at distance 1
  Rgbd integral{0};
  WindowedDistribution2d table;
  double total = 0;
};

std::unique_ptr<Light> makeProjection(const Parameters& p, const LightContext& c) {
  Image slide = readLightPicture(p);
  PatternLight::requireInvertible(c.sceneFromLight, p);
  auto light = std::make_unique<Projection>(std::move(slide), p.real("fov"),
                                            Rgb(static_cast<float>(p.real("scale"))), c.sceneFromLight);
  if (p.hasValue("power")) {
    const double whole = double(luminance(Rgb(light->wholeIntegral())));
    if (!(whole > 0)) p.fail("power", "a black picture has no power to scale", "\"scale\"");
    light->multiply(p.real("power") / whole);
  }
  return light;
}

} // namespace

void registerProjection(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "projection",
        .summary = "A slide projector at the origin of light space that projects a picture along +z, with +x "
                   "to the right and +y up; the intensity of a direction is that of the picture's pixel.",
        .parameters =
            {stringParameter("filename", "", "the picture").require(),
             realParameter("scale", "1", "factor on the picture").range(0, 1e30),
             realParameter("fov", "90", "angle of view along the shorter side [degrees]").range(1e-3, 179.9),
             realParameter("power", "", "total power [W]; replaces the scale of the picture").positive()},
        .examples = {"\"string filename\" \"scenes/textures/evening.hdr\" \"float fov\" 50",
                     "\"string filename\" \"scenes/textures/evening-square.hdr\" \"float power\" 5"}},
       makeProjection});
}

} // namespace recurse
