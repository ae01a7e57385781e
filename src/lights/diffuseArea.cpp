/** @file
 * Area light from one side or both, with the same radiance in all directions or one that falls with a power
 * of the cosine. The radiance is constant or given by a picture.
 */
#include "lights/maps/lightProbe.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Picture over (u, v), with v upwards. */
class Slide {
 public:
  Slide(Image picture, bool repeats) : image(std::move(picture)), repeats(repeats) {}

  /** Bilinear interpolation between pixels; beyond the edges the edge pixel, or the repeated picture. */
  Rgb at(const Vec2f& uv) const {
    const float x = wrapped(uv.x) * static_cast<float>(image.width) - 0.5f,
                y = wrapped(1 - uv.y) * static_cast<float>(image.height) - 0.5f;
    const float left = std::floor(x), top = std::floor(y), s = x - left, t = y - top;
    const auto pixel = [&](int dx, int dy) {
      return image.rgb(neighbour(static_cast<int>(left) + dx, image.width),
                       neighbour(static_cast<int>(top) + dy, image.height));
    };
    return (pixel(0, 0) * (1 - s) + pixel(1, 0) * s) * (1 - t) +
           (pixel(0, 1) * (1 - s) + pixel(1, 1) * s) * t;
  }
  Rgbd mean() const {
    Rgbd sum(0);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) sum += Rgbd(image.rgb(x, y));
    return sum / (double(image.width) * image.height);
  }

 private:
  float wrapped(float x) const {
    if (repeats) x -= std::floor(x);
    return x > 0 ? std::min(x, 1.0f) : 0;
  }
  /** Index of a pixel that may be one beyond the edges. */
  int neighbour(int i, int size) const { return repeats ? (i + size) % size : std::clamp(i, 0, size - 1); }
  Image image;
  bool repeats;
};

/** Radiance by direction: cosⁿ of the angle to the normal, which is 1 for n = 0. */
class CosineLobe {
 public:
  explicit CosineLobe(double exponent) : exponent(static_cast<float>(exponent)) {}

  bool isEven() const { return exponent == 0; }
  float at(float cosine) const { return isEven() ? 1 : std::pow(std::max(cosine, 0.0f), exponent); }
  /** Integral of the lobe times the cosine over the hemisphere: 2π / (n + 2). */
  float integral() const { return isEven() ? PI : 2 * PI / (exponent + 2); }
  /** Direction around +z with the density pdf(). */
  Vec3f sample(const Vec2f& u) const {
    if (isEven()) return cosineHemisphere(u);
    // cos² is u^(2 / (n + 2)); its difference from 1 keeps its digits for narrow lobes.
    const double sine2 = -std::expm1(std::log(1 - double(u.x)) * 2 / (double(exponent) + 2));
    const auto sine = static_cast<float>(std::sqrt(sine2)), phi = 2 * PI * u.y;
    return {sine * std::cos(phi), sine * std::sin(phi), static_cast<float>(std::sqrt(1 - sine2))};
  }
  /** Density [1/sr] in proportion to the lobe times the cosine. */
  float pdf(float cosine) const {
    if (isEven()) return std::max(cosine, 0.0f) * INV_PI;
    return at(cosine) * std::max(cosine, 0.0f) / integral();
  }

 private:
  float exponent;
};

class DiffuseArea final : public AreaLight {
 public:
  /** `radiance` along the normal is a factor on the picture where there is one. */
  DiffuseArea(const Shape& shape, const Rgb& radiance, const CosineLobe& lobe, bool twoSided,
              std::optional<Slide> picture)
      : AreaLight(shape), constant(radiance), lobe(lobe), twoSided(twoSided), picture(std::move(picture)) {
    if (this->picture) mean = meanOverShape();
  }

  Rgb power() const override {
    const Rgb flux = constant * (lobe.integral() * shape().area() * (twoSided ? 2.0f : 1.0f));
    return picture ? flux * mean : flux;
  }
  Rgb radiance(const SurfacePoint& point, const Vec3f& direction) const override {
    const float cosine = glm::dot(point.geometricNormal, direction);
    return twoSided || cosine > 0 ? emitted(point) * lobe.at(std::abs(cosine)) : BLACK;
  }
  Rgb radianceTowards(const LeSample& sample, const Vec3f& direction) const override {
    if (lobe.isEven() || isBlack(sample.radiance)) return Light::radianceTowards(sample, direction);
    const float cosine = glm::dot(sample.normal, direction), before = absDot(sample.normal, sample.direction);
    return twoSided || cosine > 0 ? sample.radiance * (lobe.at(std::abs(cosine)) / lobe.at(before)) : BLACK;
  }
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    const ShapeSample s = shape().sampleArea(sample.pick, sample.position);
    if (!(s.pdf > 0)) return {};
    Vec3f normal = s.point.geometricNormal;
    float sides = 1;
    Vec2f u = sample.direction;
    if (twoSided) { // one number chooses the side and is rescaled
      if (u.x < 0.5f) normal = -normal;
      u.x = 2 * u.x - (u.x < 0.5f ? 0.0f : 1.0f);
      sides = 2;
    }
    const Vec3f local = lobe.sample(u);
    return leaving(s, Frame(normal).toWorld(local), normal, local.z, sides);
  }
  LePdf pdfLe(const LeRay& ray) const override {
    SurfacePoint point;
    point.position = ray.origin;
    point.geometricNormal = ray.normal;
    const float cosine = glm::dot(ray.normal, ray.direction);
    return {shape().pdfArea(ray.primitive, point),
            twoSided ? lobe.pdf(std::abs(cosine)) / 2 : lobe.pdf(cosine)};
  }
  std::optional<LiSample> sampleLi(const Vec3f& point, float pick, const Vec2f& u) const override {
    std::optional<LiSample> light;
    const std::optional<ShapeSample> s = shape().sampleDirection(point, pick, u);
    if (!s) return light;
    const Vec3f towards = s->point.position - point;
    const float distance = glm::length(towards);
    if (!(distance > 0)) return light;
    const Vec3f direction = towards / distance;
    const Rgb l = DiffuseArea::radiance(s->point, -direction);
    if (isBlack(l)) return light;
    light.emplace();
    light->direction = direction;
    light->target = s->point.rayOrigin(-direction);
    light->distance = distance;
    light->radiance = l * opacity(s->point);
    light->pdf = s->pdf;
    light->unhittable = !isIntersectable();
    light->normal = s->point.geometricNormal;
    light->primitive = s->primitive;
    return light;
  }

 private:
  /** Emission sample; empty along the surface, where the density is 0. */
  std::optional<LeSample> leaving(const ShapeSample& s, const Vec3f& direction, const Vec3f& normal,
                                  float cosine, float sides) const {
    const float pdf = lobe.pdf(cosine);
    if (!(pdf > 0)) return {};
    const Rgb even = emitted(s.point) * opacity(s.point);
    return LeSample{{s.point.rayOrigin(direction), direction, normal, s.primitive},
                    even * lobe.at(cosine),
                    s.pdf,
                    pdf / sides,
                    even * (lobe.integral() * sides / s.pdf)};
  }
  Rgb emitted(const SurfacePoint& point) const {
    return picture ? constant * picture->at(point.uv) : constant;
  }

  /** Area-weighted mean of the picture over the shape. */
  Rgb meanOverShape() const {
    constexpr uint32_t POINTS = 16384;
    Rgbd sum(0);
    double weights = 0;
    for (uint32_t i = 0; i < POINTS; ++i) {
      Sampler sampler(0, 0, i);
      const float pick = sampler.next1D();
      const ShapeSample s = shape().sampleArea(pick, sampler.next2D());
      if (!(s.pdf > 0)) continue;
      sum += Rgbd(picture->at(s.point.uv)) / double(s.pdf);
      weights += 1 / double(s.pdf);
    }
    return weights > 0 ? Rgb(sum / weights) : BLACK;
  }

  Rgb constant;
  CosineLobe lobe;
  bool twoSided;
  std::optional<Slide> picture;
  Rgb mean{1};
};

std::unique_ptr<AreaLight> makeDiffuseArea(const Parameters& p, const AreaLightContext& c) {
  const bool twoSided = p.boolean("twosided");
  const double exponent = p.real("exponent");
  double scale = p.real("scale");
  std::optional<Slide> picture;
  Rgbd colour(1);
  double mean = 1;
  if (p.has("filename")) {
    if (p.has("L"))
      p.fail("L", "both a picture and \"L\" are given", "\"filename\" or \"L\"; \"scale\" for both");
    picture.emplace(readLightPicture(p), p.string("wrap") == "repeat");
    mean = double(luminance(Rgb(picture->mean())));
    if (p.hasValue("power") && !(mean > 0))
      p.fail("power", "a black picture has no power to scale", "\"scale\"");
  } else {
    colour = p.spectrum("L");
  }
  if (p.hasValue("power")) {
    if (!(c.shape.area() > 0))
      p.fail("power", "the shape has no area: are all its vertices on one line?",
             "a shape with an area, or a light \"point\"");
    scale *= p.real("power") * (exponent + 2) / 2 /
             (double(PI) * double(c.shape.area()) * (twoSided ? 2 : 1) * mean);
  }
  return std::make_unique<DiffuseArea>(c.shape, Rgb(colour * scale), CosineLobe(exponent), twoSided,
                                       std::move(picture));
}

} // namespace

void registerDiffuseArea(PlugIns& plugIns) {
  plugIns.areaLights.add(
      {{.name = "diffuse",
        .summary =
            "A surface that emits the same radiance in all directions, or more along its normal; it also "
            "reflects with its material.",
        .parameters =
            {spectrumParameter("L", "1", SpectrumKind::ILLUMINANT,
                               "emitted radiance [W/(m² sr)], along the normal"),
             realParameter(
                 "exponent", "0",
                 "n: the radiance falls with cosⁿ of the angle to the normal, for the power 2π / (n + "
                 "2) times area and L; 0: the same radiance in all directions")
                 .range(0, 1e4),
             realParameter("scale", "1", "factor on L or on the picture").range(0, 1e30),
             realParameter("power", "", "total power [W]: L, or the mean of the picture, is scaled to it")
                 .positive(),
             booleanParameter("twosided", "false", "emit from both sides"),
             stringParameter("filename", "",
                             "picture of the emitted radiance; its lower left corner is at (u, v) = (0, 0)"),
             stringParameter("wrap", "clamp", "lookup outside of the picture").oneOf({"clamp", "repeat"})},
        .examples = {"\"rgb L\" [4 3 2]", "\"float power\" 10 \"bool twosided\" true",
                     "\"rgb L\" [4 3 2] \"float exponent\" 2.5",
                     "\"float power\" 10 \"float exponent\" .5 \"bool twosided\" true",
                     "\"string filename\" \"scenes/textures/evening.hdr\" \"bool twosided\" true"}},
       makeDiffuseArea});
}

} // namespace recurse
