/** @file
 * Hair: a dielectric cylinder with tilted scales and absorption inside (Chiang, Bitterli, Tappan, Burley, "A
 * Practical and Controllable Hair and Fur Model for Production Path Tracing", 2016), with the parameters of
 * pbrt-v4. Light is reflected (R), transmitted (TT), or leaves after internal reflections (TRT and longer).
 */
#include <cfloat>

#include "bsdfs/microfacet/fresnel.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

constexpr size_t LOBES = 4; ///< R, TT, TRT, and all paths with more internal reflections

double power(double x, int n) {
  double y = 1;
  for (; n > 0; --n) y *= x;
  return y;
}

double cosineOf(double sine) { return std::sqrt(std::max(0.0, 1 - sine * sine)); }

/** log I₀(x), the modified Bessel function, from its series or, for large x, the asymptotic series. */
double logBesselI0(double x) {
  if (x > 12) return x - 0.5 * std::log(2 * M_PI * x) + std::log1p(1 / (8 * x) + 9 / (128 * x * x));
  double sum = 1, term = 1;
  for (int k = 1; term > 1e-12 * sum; ++k) {
    term *= x * x / (4.0 * k * k);
    sum += term;
  }
  return std::log(sum);
}

/** Inclination to the normal plane of the hair. */
struct Inclination {
  double sine, cosine;
  /** Inclination increased by an angle of sine `s` and cosine `c`. */
  Inclination turned(double s, double c) const {
    return {sine * c + cosine * s, std::abs(cosine * c - sine * s)};
  }
};

/** Longitudinal scattering M_p of variance v, a density over the sine (d'Eon et al. 2011, equation 7). */
double longitudinal(const Inclination& a, const Inclination& b, double v) {
  // exp(-ab/v) I₀ / (2v sinh(1/v)), as one exponent: each of the factors may overflow.
  const double exponent =
      logBesselI0(a.cosine * b.cosine / v) - a.sine * b.sine / v - 1 / v - std::log1p(-std::exp(-2 / v));
  return std::exp(exponent) / v;
}

/** A logistic distribution of scale s on [-π, π] (Chiang et al., section 3.3). */
struct TrimmedLogistic {
  double s;
  double cumulative(double x) const { return 1 / (1 + std::exp(-x / s)); }
  double density(double x) const {
    const double e = std::exp(-std::abs(x) / s);
    return e / (s * square(1 + e)) / (cumulative(M_PI) - cumulative(-M_PI));
  }
  double sample(double u) const {
    const double low = cumulative(-M_PI), p = low + u * (cumulative(M_PI) - low);
    return std::clamp(-s * std::log(1 / p - 1), -M_PI, M_PI);
  }
};

/** Variances, tilts and azimuthal distribution of the lobes, from roughnesses and the tilt of the scales. */
struct HairShape {
  HairShape(double eta, double betaM, double betaN, double alpha) : eta(eta) {
    const double root = 0.726 * betaM + 0.812 * square(betaM) + 3.7 * power(betaM, 20);
    variances = {square(root), square(root) / 4, 4 * square(root), 4 * square(root)};
    logistic.s = std::sqrt(M_PI / 8) * (0.265 * betaN + 1.194 * square(betaN) + 5.372 * power(betaN, 22));
    // Slopes of the scales turn R by -2α, TT by α, TRT by 4α.
    const double turns[LOBES] = {-2 * alpha, alpha, 4 * alpha, 0};
    for (size_t p = 0; p < LOBES; ++p) tilts[p] = {std::sin(turns[p]), std::cos(turns[p])};
  }
  double eta;
  std::array<double, LOBES> variances;
  std::array<std::pair<double, double>, LOBES> tilts; ///< sine and cosine
  TrimmedLogistic logistic{};
};

/** Hair BSDF in a frame with x along the hair. The walk arrives from wi at offset h [radii] from the axis,
 * on the side of +y. As in pbrt-v4, values are divided by the cosine of the light. */
class HairBsdf final : public Bsdf {
 public:
  /** `twoSided`: the surface does not turn to face the ray, and light from the side where h was not
   * measured leaves on the opposite side. */
  HairBsdf(const HairShape& shape, const Rgb& absorption, float h, bool twoSided)
      : shape(shape), absorption(absorption), h(std::clamp(double(h), -1.0, 1.0)), twoSided(twoSided) {}

  LobeSet lobes() const override { return REFLECTION | TRANSMISSION | ANISOTROPIC | FIBRE; }

  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (wi.z == 0) return BLACK;
    const Lobes all(*this, wo);
    Rgbd sum(0);
    for (size_t p = 0; p < LOBES; ++p) sum += all.attenuation[p] * density(all, p, wo, wi, h);
    return Rgb(sum / double(std::abs(wi.z)));
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    const Lobes all(*this, wi);
    double sum = 0;
    for (size_t p = 0; p < LOBES; ++p)
      sum += all.chance[p] * (twoSided ? 0.5 * (density(all, p, wi, wo, h) + density(all, p, wi, wo, -h))
                                       : density(all, p, wi, wo, h));
    return static_cast<float>(sum);
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    const Lobes all(*this, wi);
    double rest = double(pick), side = 1;
    if (twoSided) {
      side = rest < 0.5 ? 1 : -1;
      rest = 2 * rest - (rest < 0.5 ? 0 : 1);
    }
    size_t p = 0;
    while (p + 1 < LOBES && rest >= all.chance[p]) rest -= all.chance[p++];
    rest = std::clamp(rest / std::max(all.chance[p], DBL_MIN), 0.0, 1 - 0x1p-24);
    const double v = shape.variances[p];
    // A cone around the mirrored inclination (d'Eon et al. 2013, section 4).
    const double cone = std::max(-1.0, 1 + v * std::log1p(-double(u.x) * (1 - std::exp(-2 / v))));
    const Inclination from = all.tilted(p);
    const double sine = std::clamp(
        -cone * from.sine + cosineOf(cone) * std::cos(2 * M_PI * double(u.y)) * from.cosine, -1.0, 1.0);
    const double turn = p + 1 < LOBES ? side * all.exit(p, h) + shape.logistic.sample(rest) : 2 * M_PI * rest;
    const double phi = azimuth(wi) + turn, cosine = cosineOf(sine);
    return glm::normalize(Vec3f(Vec3d(sine, cosine * std::cos(phi), cosine * std::sin(phi))));
  }
  Rgb albedo(const Vec3f& wi) const override {
    const Lobes all(*this, wi);
    Rgbd sum(0);
    for (const Rgbd& a : all.attenuation) sum += a;
    return min(Rgb(sum), Rgb(1));
  }
  bool lossless() const override { return isBlack(absorption); }

 private:
  static double azimuth(const Vec3f& w) { return std::atan2(double(w.z), double(w.y)); }

  /** Attenuations and exit angles of the lobes for the direction of h, in either sense of travel. */
  struct Lobes {
    Lobes(const HairBsdf& hair, const Vec3f& w) : shape(hair.shape) {
      const double h = hair.h;
      inclination = {double(w.x), cosineOf(double(w.x))};
      const double sineT = inclination.sine / shape.eta, cosineT = cosineOf(sineT);
      // Modified index of refraction in the normal plane, which depends on the inclination.
      const double bent = std::sqrt(std::max(DBL_MIN, square(shape.eta) - square(inclination.sine)));
      sineGammaT = std::clamp(h * inclination.cosine / bent, -1.0, 1.0);
      const double length = 2 * cosineOf(sineGammaT) / std::max(cosineT, DBL_MIN); // one crossing [radii]
      const Rgbd transmitted = exp(Rgbd(hair.absorption) * -length);
      const auto f = double(dielectricFresnel(static_cast<float>(inclination.cosine * cosineOf(h)),
                                              static_cast<float>(shape.eta))
                                .reflectance);
      attenuation[0] = Rgbd(f);
      attenuation[1] = square(1 - f) * transmitted;
      attenuation[2] = attenuation[1] * transmitted * f;
      attenuation[3] = f < 1 ? attenuation[2] * f * transmitted / (1.0 - transmitted * f) : Rgbd(0);
      double total = 0;
      for (size_t p = 0; p < LOBES; ++p) total += chance[p] = channelSum(attenuation[p]) / 3;
      if (total == 0) chance[0] = total = 1; // everything is absorbed
      for (double& c : chance) c /= total;
    }
    Inclination tilted(size_t p) const {
      return inclination.turned(shape.tilts[p].first, shape.tilts[p].second);
    }
    /** Azimuthal deflection by a smooth cylinder [rad]. */
    double exit(size_t p, double h) const {
      const double gammaT = h < 0 ? -std::asin(std::abs(sineGammaT)) : std::asin(std::abs(sineGammaT));
      return 2 * double(p) * gammaT - 2 * std::asin(h) + double(p) * M_PI;
    }
    const HairShape& shape;
    Inclination inclination{};
    double sineGammaT = 0; ///< sine of the refracted azimuthal angle γt
    std::array<Rgbd, LOBES> attenuation;
    std::array<double, LOBES> chance{};
  };

  /** Density of lobe p for `to` [1/sr], where light arrives from `from` at the given offset. */
  double density(const Lobes& all, size_t p, const Vec3f& from, const Vec3f& to, double offset) const {
    const double m = longitudinal({double(to.x), cosineOf(double(to.x))}, all.tilted(p), shape.variances[p]);
    if (p + 1 == LOBES) return m / (2 * M_PI);
    const double turn = std::remainder(azimuth(to) - azimuth(from) - all.exit(p, offset), 2 * M_PI);
    return m * shape.logistic.density(turn);
  }

  const HairShape& shape;
  Rgb absorption; ///< [1/radius]
  double h;
  bool twoSided;
};

/** Absorption of the two pigments of human hair (d'Eon et al. 2011), for a concentration of 1. */
const Rgb EUMELANIN(0.419f, 0.697f, 1.37f), PHEOMELANIN(0.187f, 0.4f, 1.05f);

class Hair final : public Material {
 public:
  enum class Colour { ABSORPTION, REFLECTANCE, PIGMENTS };
  struct Values {
    Colour by = Colour::PIGMENTS;
    TexturedRgb colour, eumelanin, pheomelanin;
  };
  Hair(const Values& values, const TexturedRgb& eta, const TexturedRgb& betaM, const TexturedRgb& betaN,
       const TexturedRgb& alpha)
      : values(values), eta(eta), betaM(betaM), betaN(betaN), alpha(alpha) {}

  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const float roughness = betaN.at(point).r;
    const auto* shape = arena.make<HairShape>(double(eta.at(point).r), double(betaM.at(point).r),
                                              double(roughness), glm::radians(double(alpha.at(point).r)));
    return arena.make<HairBsdf>(*shape, absorption(point, roughness), 1 - 2 * point.uv.y,
                                point.curve != SurfacePoint::Curve::FACES_RAY);
  }
  LobeSet lobes() const override { return REFLECTION | TRANSMISSION | ANISOTROPIC | FIBRE; }

 private:
  Rgb absorption(const SurfacePoint& point, float roughness) const {
    switch (values.by) {
    case Colour::ABSORPTION:
      return values.colour.at(point);
    case Colour::PIGMENTS:
      return EUMELANIN * values.eumelanin.at(point).r + PHEOMELANIN * values.pheomelanin.at(point).r;
    case Colour::REFLECTANCE:
      break;
    }
    // Absorption fitted to the albedo of many hairs (Chiang et al., equation 9).
    const float b = roughness, b2 = b * b;
    const float fit =
        5.969f - 0.215f * b + 2.532f * b2 - 10.73f * b2 * b + 5.574f * b2 * b2 + 0.245f * b2 * b2 * b;
    const Rgb root = log(max(values.colour.at(point), FLT_MIN)) / fit;
    return root * root;
  }

  Values values;
  TexturedRgb eta, betaM, betaN, alpha;
};

/** Colour from the first parameter that is given, with a warning that any further one has no effect. */
Hair::Values colourOf(const Parameters& p, const MaterialContext& c) {
  Hair::Values values;
  std::string taken;
  const auto takes = [&](const char* name) {
    if (!p.has(name)) return false;
    if (!taken.empty()) p.warn(name, "is ignored: \"" + taken + "\" sets the colour");
    return taken.empty();
  };
  for (const char* name : {"sigma_a", "reflectance", "color"})
    if (takes(name)) {
      taken = name;
      values.by = taken == "sigma_a" ? Hair::Colour::ABSORPTION : Hair::Colour::REFLECTANCE;
      values.colour = c.textures.rgb(p, name);
    }
  constexpr float BROWN = 1.3f;
  const bool eumelanin = takes("eumelanin"), pheomelanin = takes("pheomelanin");
  if (eumelanin) values.eumelanin = c.textures.real(p, "eumelanin");
  if (pheomelanin) values.pheomelanin = c.textures.real(p, "pheomelanin");
  if (!eumelanin && !pheomelanin) values.eumelanin.constant = Rgb(BROWN);
  return values;
}

} // namespace

void registerHair(PlugIns& plugIns) {
  const double most = std::numeric_limits<double>::infinity();
  plugIns.materials.add(
      {{.name = "hair",
        .summary =
            "Hair and fur, for shapes of type \"curve\". Absorption, reflectance or pigments set its colour.",
        .parameters =
            {spectrumParameter("sigma_a", "", SpectrumKind::UNBOUNDED, "absorption [1/radius of the hair]")
                 .withTexture(),
             spectrumParameter("reflectance", "", SpectrumKind::ALBEDO, "colour of dense hair").withTexture(),
             spectrumParameter("color", "", SpectrumKind::ALBEDO, "another name of reflectance")
                 .withTexture(),
             realParameter("eumelanin", "",
                           "concentration of the pigment of brown and black hair (eumelanin): 0.3 is blond, "
                           "8 is black; 1.3 if no parameter sets the colour")
                 .range(0, most)
                 .withTexture(),
             realParameter("pheomelanin", "", "concentration of the pigment of red hair (pheomelanin)")
                 .range(0, most)
                 .withTexture(),
             realParameter("eta", "1.55", "refractive index").range(1, 10).withTexture(),
             realParameter("beta_m", "0.3", "roughness along the hair").range(0.01, 1).withTexture(),
             realParameter("beta_n", "0.3", "roughness around the hair").range(0.01, 1).withTexture(),
             realParameter("alpha", "2", "angle between the scales and the hair [degrees]")
                 .range(-10, 10)
                 .withTexture()},
        .examples = {"", "\"rgb sigma_a\" [0 0 0] \"float beta_m\" .6", "\"rgb reflectance\" [.8 .5 .3]",
                     "\"float pheomelanin\" 1.5 \"float beta_n\" .7",
                     "\"rgb sigma_a\" [0 0 0] \"float beta_m\" .15 \"float beta_n\" .2 \"float alpha\" 4",
                     "\"rgb color\" [.1 .4 .9] \"float eta\" 1.2 \"float beta_m\" .9 \"float beta_n\" 1"}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<Hair>(colourOf(p, c), c.textures.real(p, "eta"),
                                       c.textures.real(p, "beta_m"), c.textures.real(p, "beta_n"),
                                       c.textures.real(p, "alpha"));
       }});
}

} // namespace recurse
