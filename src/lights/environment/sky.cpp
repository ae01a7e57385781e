/** @file
 * Clear sky and sun: the model of A. J. Preetham, P. Shirley and B. Smits, "A Practical Analytic Model for
 * Daylight" (SIGGRAPH 1999). Light space has +z up, +x to the north and +y to the east.
 */
#include <numbers>

#include "lights/environment/environmentMapLight.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

namespace {

using std::numbers::pi;
constexpr double DEGREE = pi / 180;
/** Angular radius of the sun at its mean distance [rad]. */
constexpr double SUN_RADIUS = 0.2666 * DEGREE;

/** Perez' distribution of luminance, or of a chromaticity, over the sky. */
struct Perez {
  double a, b, c, d, e;
  /** `gamma`: angle to the sun. */
  double at(double cosTheta, double gamma) const {
    return (1 + a * std::exp(b / cosTheta)) * (1 + c * std::exp(d * gamma) + e * square(std::cos(gamma)));
  }
};

/** Sky radiance of section A.2 of the paper; luminance in kcd/m². */
class PreethamSky {
 public:
  PreethamSky(double turbidity, double sunTheta) : sunTheta(sunTheta) {
    const double t = turbidity, s = sunTheta, s2 = s * s, s3 = s2 * s;
    luminance = {0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771,
                 -0.0670 * t + 0.3703};
    x = {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
         -0.0033 * t + 0.0452};
    y = {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
         -0.0109 * t + 0.0529};
    const double chi = (4.0 / 9 - t / 120) * (pi - 2 * s);
    zenithLuminance = (4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192;
    zenithX = t * t * (0.00166 * s3 - 0.00375 * s2 + 0.00209 * s) +
              t * (-0.02903 * s3 + 0.06377 * s2 - 0.03202 * s + 0.00394) +
              (0.11693 * s3 - 0.21196 * s2 + 0.06052 * s + 0.25886);
    zenithY = t * t * (0.00275 * s3 - 0.00610 * s2 + 0.00317 * s) +
              t * (-0.04214 * s3 + 0.08970 * s2 - 0.04153 * s + 0.00516) +
              (0.15346 * s3 - 0.26756 * s2 + 0.06670 * s + 0.26688);
  }

  /** Sky radiance above the horizon; linear Rec. 709. */
  Rgbd at(double cosTheta, double gamma) const {
    const double l = relative(luminance, zenithLuminance, cosTheta, gamma);
    const double cx = relative(x, zenithX, cosTheta, gamma), cy = relative(y, zenithY, cosTheta, gamma);
    return max(rgbOfXyz(Vec3d(cx / cy, 1, (1 - cx - cy) / cy) * std::max(l, 0.0)), 0.0);
  }

 private:
  double relative(const Perez& f, double zenith, double cosTheta, double gamma) const {
    return zenith * f.at(cosTheta, gamma) / f.at(1, sunTheta);
  }

  double sunTheta;
  Perez luminance{}, x{}, y{};
  double zenithLuminance, zenithX, zenithY;
};

/** Illuminance of a surface that faces the sun [klx], attenuated by Rayleigh scattering and aerosol (section
 * A.1 of the paper). Ozone, water vapour and mixed gases, which absorb a few per cent, are ignored. */
Rgbd sunIlluminance(double turbidity, double theta) {
  constexpr double OUTSIDE = 128, TEMPERATURE = 5772; // solar constant [klx], effective temperature [K]
  const double mass = 1 / (std::cos(theta) + 0.15 * std::pow(93.885 - theta / DEGREE, -1.253));
  const double beta = 0.04608 * turbidity - 0.04586; // Ångström's coefficient
  const auto through = [&](double micrometres) {
    return std::exp(-mass * (0.008735 * std::pow(micrometres, -4.08) + beta * std::pow(micrometres, -1.3)));
  };
  const auto planck = [](double nanometres) {
    return std::pow(nanometres / 560, -5) / std::expm1(1.438776877e7 / (nanometres * TEMPERATURE));
  };
  // Colours have luminance 1; the transmitted fraction is measured with one photopic curve before and after.
  SampledSpectrum before, after;
  double allLuminance = 0, luminance = 0;
  for (int w = 360; w <= 780; w += 5) {
    before.wavelengths.push_back(w);
    before.values.push_back(planck(w));
    after.wavelengths.push_back(w);
    after.values.push_back(planck(w) * through(w / 1000.0));
    // The photopic curve by its single Gaussian lobe (Wyman, Sloan and Shirley 2013, section 2.1).
    const double eye = 1.014 * std::exp(-0.5 * square((w - 556.1) / 46.14));
    allLuminance += before.values.back() * eye;
    luminance += after.values.back() * eye;
  }
  return rgbOfSpectrum(after, SpectrumKind::ILLUMINANT) * (OUTSIDE * luminance / allLuminance);
}

Vec3d fromAngles(double elevation, double azimuth) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

/** Direction towards the sun; section A.6 of the paper. */
Vec3d sunAt(double latitude, double longitude, int day, double hour, double zone) {
  const double j = day;
  const double solar = hour + 0.170 * std::sin(4 * pi * (j - 80) / 373) -
                       0.129 * std::sin(2 * pi * (j - 8) / 355) + longitude / 15 - zone;
  const double declination = 0.4093 * std::sin(2 * pi * (j - 81) / 368);
  const double hourAngle = pi / 12 * (solar - 12), l = latitude * DEGREE;
  return {std::cos(l) * std::sin(declination) - std::sin(l) * std::cos(declination) * std::cos(hourAngle),
          -std::cos(declination) * std::sin(hourAngle),
          std::sin(l) * std::sin(declination) + std::cos(l) * std::cos(declination) * std::cos(hourAngle)};
}

Vec3d sunDirection(const Parameters& p) {
  const bool byTime =
      p.has("latitude") || p.has("longitude") || p.has("day") || p.has("hour") || p.has("timezone");
  if (byTime) {
    for (const char* other : {"elevation", "azimuth"})
      if (p.has(other))
        p.fail(other, "the sun's position is given both by angles and by location and time", "one of them");
    return sunAt(p.real("latitude"), p.real("longitude"), p.integer("day"), p.real("hour"),
                 p.real("timezone"));
  }
  return fromAngles(p.real("elevation") * DEGREE, p.real("azimuth") * DEGREE);
}

std::unique_ptr<Light> makeSky(const Parameters& p, const LightContext& c) {
  const Vec3d towardsSun = sunDirection(p);
  constexpr double LOWEST = 0.5; // [degrees]: the sun's disc is just above the horizon
  if (!(towardsSun.z > std::sin(LOWEST * DEGREE)))
    p.fail(p.has("elevation") ? "elevation" : "hour",
           "the sun is " + std::to_string(std::asin(towardsSun.z) / DEGREE) +
               " degrees above the horizon, where the sky model is not valid",
           "an elevation above half a degree");
  const double turbidity = p.real("turbidity"), theta = std::acos(std::min(towardsSun.z, 1.0));
  const PreethamSky sky(turbidity, theta);
  const Rgbd sun = p.boolean("sun") ? sunIlluminance(turbidity, theta) : Rgbd(0);

  constexpr int SIZE = 512;
  Image image(SIZE, SIZE, {"R", "G", "B"});
  // Pixels just below the horizon are those of the sky, so that interpolation does not mix ground into it.
  constexpr double HORIZON = -6.0 / SIZE; // lowest direction of the sky, over one diagonal of a pixel
  const auto fill = [&](bool upper, const auto& value) {
    parallelFor(size_t(SIZE), [&](size_t y) {
      for (int x = 0; x < SIZE; ++x) {
        const Vec3d d =
            directionOfPlace(EnvironmentMapping::EQUAL_AREA, Vec2d(x + 0.5, double(y) + 0.5) / double(SIZE));
        if ((d.z > HORIZON) != upper) continue;
        const Rgbd v = value(d);
        for (int k = 0; k < 3; ++k) image.at(x, static_cast<int>(y))[k] = static_cast<float>(v[k]);
      }
    });
  };
  fill(true, [&](const Vec3d& d) {
    const Vec3d away = d - towardsSun;
    return sky.at(std::max(d.z, 1e-6), 2 * std::asin(std::min(1.0, glm::length(away) / 2)));
  });
  // The ground reflects a fraction of its irradiance.
  Rgbd upward(0);
  for (int y = 0; y < SIZE; ++y)
    for (int x = 0; x < SIZE; ++x) {
      const double z =
          directionOfPlace(EnvironmentMapping::EQUAL_AREA, Vec2d(x + 0.5, y + 0.5) / double(SIZE)).z;
      if (z > 0) upward += Rgbd(image.rgb(x, y)) * (z * 4 * pi / (double(SIZE) * SIZE));
    }
  const Rgbd ground = p.spectrum("ground") * (upward + sun * towardsSun.z) / pi;
  fill(false, [&](const Vec3d&) { return ground; });

  const double determinant = glm::determinant(Mat3d(c.sceneFromLight));
  if (!std::isfinite(determinant) || determinant == 0)
    p.fail("", "the light's transform is singular: it cannot be inverted");
  const auto scale = static_cast<float>(p.real("scale"));
  auto light = std::make_unique<EnvironmentMapLight>(EnvironmentMap(image, EnvironmentMapping::EQUAL_AREA),
                                                     Rgb(scale), c.sceneFromLight);
  if (p.boolean("sun")) {
    const double opening = 2 * square(std::sin(SUN_RADIUS * p.real("sunsize") / 2));
    // The irradiance of a disc that faces the surface is its radiance times the projected solid angle.
    const double projected = pi * opening * (2 - opening);
    light->addSun(
        {glm::normalize(Mat3d(c.sceneFromLight) * towardsSun), opening, Rgb(sun / projected) * scale});
  }
  return light;
}

} // namespace

void registerSky(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "sky",
        .summary = "A clear sky with the sun (Preetham, Shirley, Smits 1999), by the sun's angles, or by "
                   "location and time. In light space +z is up, +x north and +y east.",
        .parameters =
            {realParameter("turbidity", "3", "turbidity (haze): 2 is very clear, 6 hazy").range(1.9, 10),
             realParameter("elevation", "45", "elevation of the sun above the horizon [degrees]")
                 .range(-90, 90),
             realParameter("azimuth", "135", "azimuth of the sun, from north to east [degrees]")
                 .range(-360, 360),
             realParameter("latitude", "0", "northern [degrees]").range(-90, 90),
             realParameter("longitude", "0", "eastern [degrees]").range(-180, 180),
             integerParameter("day", "172", "day of the year, from 1").range(1, 366),
             realParameter("hour", "12", "standard time of the time zone [hours]").range(0, 24),
             realParameter("timezone", "0", "time zone [hours ahead of Greenwich]").range(-14, 14),
             booleanParameter("sun", "true", "include the disc of the sun"),
             realParameter("sunsize", "1",
                           "diameter of the sun relative to the real one, with the same irradiance")
                 .range(0.1, 40),
             spectrumParameter("ground", "0.2", SpectrumKind::ALBEDO,
                               "reflectance of the ground, which fills all directions below the horizon"),
             realParameter("scale", "1", "factor; 1 gives radiance 1 for 1000 cd/m²").range(0, 1e30)},
        .examples = {"\"float elevation\" 30 \"float turbidity\" 2.5 \"float sunsize\" 20",
                     "\"float latitude\" 52 \"float longitude\" 13 \"integer day\" 100 \"float hour\" 9 "
                     "\"float timezone\" 1 \"bool sun\" false"}},
       makeSky});
}

} // namespace recurse
