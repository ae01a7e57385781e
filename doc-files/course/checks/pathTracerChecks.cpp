/** @file
 * Checks of the path tracer's gaps: closed forms, and densities by quadrature.
 */
#include <cmath>

#include "checks/checks.h"
#include "frame/pathTracer.h"

namespace course {

namespace {

using namespace path;

Verdict checkEmission() {
  const Rgb lamp(2, 3, 5);
  Values values, expected, byCosine, everywhere;
  for (const float cosine : {1.0f, 0.5f, 0.1f, -0.1f, -1.0f}) {
    values.push_back(emittedRadiance(lamp, cosine));
    expected.push_back(cosine > 0 ? lamp : BLACK);
    byCosine.push_back(lamp * std::max(cosine, 0.0f));
    everywhere.push_back(lamp);
  }
  return judge(
      values, expected,
      {{"the lamp must emit nothing behind it", everywhere},
       {"radiance does not depend on the cosine here, which is part of the geometry term", byCosine}});
}

Verdict checkBsdf() {
  const Values albedos{Rgb(0.8f, 0.5f, 0.2f), Rgb(0.1f, 0.4f, 0.9f)};
  Values values, expected, withoutPi, byHemisphere;
  for (const Rgb& albedo : albedos) {
    values.push_back(lambertianBsdf(albedo));
    expected.push_back(albedo * INV_PI);
    withoutPi.push_back(albedo);
    byHemisphere.push_back(albedo * (INV_PI / 2));
  }
  return judge(values, expected,
               {{"a factor of pi is missing: the integral of BSDF times cosine over the hemisphere is pi "
                 "times the albedo, "
                 "so that the surface reflects more than it receives",
                 withoutPi},
                {"the integral of the cosine over the hemisphere is pi, not 2 pi", byHemisphere}});
}

/** Moments of sampled directions. */
struct Moments {
  double z = 0, z2 = 0, x = 0, y = 0, xy = 0, x2 = 0;
};

Verdict checkSampledDirections(const Moments& m) {
  if (isNear(m.z, 0.5, 0.01))
    return wrong("the mean cosine is 0.5: directions are uniform over the hemisphere");
  if (!isNear(m.z, 2.0 / 3, 0.01) || !isNear(m.z2, 0.5, 0.01))
    return wrong(
        text("the mean cosine is %.3f instead of 2/3: the density is not in proportion to the cosine", m.z));
  if (std::abs(m.x) > 0.01 || std::abs(m.y) > 0.01 || std::abs(m.xy) > 0.01 || !isNear(m.x2, 0.25, 0.02))
    return wrong("directions are not uniform around the normal: does the angle phi go from 0 to 2 pi?");
  return {};
}

Verdict checkSampling() {
  constexpr int N = 128;
  Moments m;
  double integral = 0; // of pdf over solid angle, if it is in proportion to the cosine
  bool isProportional = true, isConstant = true, hasSine = true, isMissing = true;
  double first = 0;
  for (int i = 0; i < N * N; ++i) {
    const Vec2f u((float(i % N) + 0.5f) / N, (float(i / N) + 0.5f) / N);
    const DirectionSample s = sampleCosine(u);
    isMissing = isMissing && s.pdf == 0;
    if (isMissing) continue;
    const double x = double(s.direction.x), y = double(s.direction.y), z = double(s.direction.z),
                 pdf = double(s.pdf), length = std::sqrt(x * x + y * y + z * z);
    if (!isNear(length, 1, 1e-3)) return wrong(text("a direction has the length %.3g instead of 1", length));
    if (!(z >= 0)) return wrong("a direction points below the surface");
    if (!(pdf > 0)) return wrong(text("a density is %.3g: it must be positive", pdf));
    const double ratio = pdf / (z / PI_D);
    if (i == 0) {
      integral = ratio;
      first = pdf;
    }
    isProportional = isProportional && isNear(ratio, integral, 1e-3);
    isConstant = isConstant && isNear(pdf, first, 1e-3);
    hasSine = hasSine && isNear(pdf, z * std::sqrt(std::max(0.0, 1 - z * z)) / PI_D, 1e-3);
    m.z += z / (N * N);
    m.z2 += z * z / (N * N);
    m.x += x / (N * N);
    m.y += y / (N * N);
    m.xy += x * y / (N * N);
    m.x2 += x * x / (N * N);
  }
  if (isMissing) return {State::MISSING, ""};
  if (const Verdict v = checkSampledDirections(m); v.state != State::RIGHT) return v;
  if (isConstant)
    return wrong(
        text("the directions are right, but their density is always %.3g: it is in proportion to the cosine",
             first));
  if (hasSine)
    return wrong(
        "the directions are right, but their density has a factor sin(theta): that is the density over the "
        "angles theta and phi, and the one over solid angle has none");
  if (!isProportional)
    return wrong("the directions are right, but their density is not in proportion to the cosine");
  if (!isNear(integral, 1, 1e-3))
    return wrong(text("the density does not integrate to one over the hemisphere, but to %.4g", integral));
  return {};
}

Verdict checkScatteringWeight() {
  struct Case {
    Rgb bsdf;
    float cosine, pdf;
  };
  Values values, expected, withoutCosine, withoutPdf, timesPdf, withPi, onlyCosine;
  for (const Case& c : {Case{Rgb(0.1f, 0.2f, 0.3f), 0.5f, 0.2f}, Case{Rgb(0.05f, 0.3f, 0.2f), 0.8f, 0.7f}}) {
    values.push_back(scatteringWeight(c.bsdf, c.cosine, c.pdf));
    expected.push_back(c.bsdf * (c.cosine / c.pdf));
    withoutCosine.push_back(c.bsdf / c.pdf);
    withoutPdf.push_back(c.bsdf * c.cosine);
    timesPdf.push_back(c.bsdf * (c.cosine * c.pdf));
    onlyCosine.push_back(c.bsdf * PI);
    withPi.push_back(c.bsdf * (c.cosine / c.pdf * INV_PI));
  }
  return judge(values, expected,
               {{"the cosine is missing: the rendering equation has BSDF times cosine", withoutCosine},
                {"the division by the density is missing", withoutPdf},
                {"the density is a divisor, not a factor", timesPdf},
                {"1 / pi is part of the BSDF already, and here a second time", withPi},
                {"cosine / pdf is pi for cosine-weighted directions only: use the arguments", onlyCosine}});
}

/** Direct light by a function of (BSDF, lamp, connection, density), for two connections. */
template <class Function> Values directLightBy(const Function& function) {
  Values values;
  for (const auto& [surface, lamp, distance2, pdf] :
       {std::array{0.5f, 0.8f, 4.0f, 0.5f}, std::array{0.9f, 0.3f, 0.25f, 2.0f}})
    values.push_back(function(Rgb(0.1f, 0.2f, 0.3f), Rgb(5, 4, 3),
                              Connection{Vec3f(0, 0, 1), surface, lamp, distance2}, pdf));
  return values;
}

/** Irradiance below the middle of a disc of radius and height 1, over the closed form pi L / 2. */
double discIrradiance() {
  constexpr int RINGS = 2000;
  double sum = 0;
  for (int i = 0; i < RINGS; ++i) {
    const float r2 = (float(i) + 0.5f) / RINGS; // uniform over the area
    const float cosine = 1 / std::sqrt(1 + r2);
    const Connection c{Vec3f(0, 0, 1), cosine, cosine, 1 + r2};
    sum += double(directLight(Rgb(1), Rgb(1), c, INV_PI).r) / RINGS;
  }
  return sum / (PI_D / 2);
}

Verdict checkDirectLight() {
  const auto by = [](const auto& factor) {
    return directLightBy([&](const Rgb& f, const Rgb& lamp, const Connection& c, float pdf) {
      return f * lamp * factor(c, pdf);
    });
  };
  Verdict verdict = judge(
      directLightBy(directLight),
      by([](const Connection& c, float pdf) { return c.cosSurface * c.cosLamp / (c.distance2 * pdf); }),
      {{"the cosine at the surface is missing",
        by([](const Connection& c, float pdf) { return c.cosLamp / (c.distance2 * pdf); })},
       {"the cosine at the lamp is missing",
        by([](const Connection& c, float pdf) { return c.cosSurface / (c.distance2 * pdf); })},
       {"both cosines of the geometry term are missing",
        by([](const Connection& c, float pdf) { return 1 / (c.distance2 * pdf); })},
       {"the division by the squared distance is missing",
        by([](const Connection& c, float pdf) { return c.cosSurface * c.cosLamp / pdf; })},
       {"the distance is squared twice: distance2 is the square", by([](const Connection& c, float pdf) {
          return c.cosSurface * c.cosLamp / (square(c.distance2) * pdf);
        })},
       {"the distance must be squared", by([](const Connection& c, float pdf) {
          return c.cosSurface * c.cosLamp / (std::sqrt(c.distance2) * pdf);
        })},
       {"1 / pi is part of the BSDF already, and here a second time", by([](const Connection& c, float pdf) {
          return c.cosSurface * c.cosLamp * INV_PI / (c.distance2 * pdf);
        })},
       {"the division by the density is missing",
        by([](const Connection& c, float) { return c.cosSurface * c.cosLamp / c.distance2; })},
       {"the density is a divisor, not a factor",
        by([](const Connection& c, float pdf) { return c.cosSurface * c.cosLamp / c.distance2 * pdf; })}});
  if (verdict.state == State::WRONG)
    verdict.hint +=
        text(" (irradiance in the middle below a disc: %.3g times the closed form)", discIrradiance());
  return verdict;
}

Verdict checkRoulette() {
  return judgeRoulette(
      {{Rgb(0.5f, 0.2f, 0.1f)}, {Rgb(0.02f, 0.03f, 0.05f)}, {Rgb(0.9f, 0.3f, 0.6f)}, {Rgb(2, 1, 0.5f)}},
      [](Rgb& value, const Rgb&, float u) { return survivesRoulette(value, u); });
}

bool isNearVector(const Vec3f& a, const Vec3f& b) { return glm::length(a - b) < 1e-4f; }

/** Directions from grazing to steep. */
std::vector<Vec3f> someDirections() {
  std::vector<Vec3f> all;
  for (const float z : {0.2f, 0.5f, 0.8f, 0.95f}) {
    const float sine = std::sqrt(1 - z * z);
    all.emplace_back(0.6f * sine, -0.8f * sine, z);
  }
  return all;
}

Verdict checkMirror() {
  bool isMissing = true, isRight = true, isBack = true, isThrough = true;
  for (const Vec3f& wo : someDirections()) {
    const Vec3f wi = mirrored(wo);
    isMissing = isMissing && isNearVector(wi, {0, 0, 1});
    isRight = isRight && isNearVector(wi, {-wo.x, -wo.y, wo.z});
    isBack = isBack && isNearVector(wi, wo);
    isThrough = isThrough && wi.z < 0;
  }
  if (isRight) return {};
  if (isMissing) return {State::MISSING, ""};
  if (isBack) return wrong("the light goes back to where it came from");
  if (isThrough)
    return wrong("the direction points into the mirror: both directions point away from the surface");
  const Vec3f wi = mirrored({0.6f, 0, 0.8f});
  return wrong(text("(0.6, 0, 0.8) is mirrored to (%.3g, %.3g, %.3g) instead of (-0.6, 0, 0.8)", double(wi.x),
                    double(wi.y), double(wi.z)));
}

/** Fresnel reflectance for (perpendicular, parallel) polarisation. */
std::pair<double, double> polarisedReflectances(double cosine, double eta) {
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (eta * eta));
  const double s = (cosine - eta * inside) / (cosine + eta * inside);
  const double p = (eta * cosine - inside) / (eta * cosine + inside);
  return {s * s, p * p};
}

Verdict checkRefractedDirection(const Vec3f& wo, float eta) {
  const std::optional<Refraction> r = refracted(wo, eta);
  const float sin2 = (1 - wo.z * wo.z) / (eta * eta);
  if (sin2 >= 1) {
    if (!r) return {};
    return wrong(std::isfinite(r->direction.z)
                     ? "there is no total internal reflection: where the sine would be above 1, return {}"
                     : "the square root of a negative number: where the sine would be above 1, return {}");
  }
  if (!r) return wrong("total internal reflection where there is none: is eta upside down?");
  const Vec3f expected(-wo.x / eta, -wo.y / eta, -std::sqrt(1 - sin2));
  if (isNearVector(r->direction, expected)) return {};
  if (isNearVector(r->direction, {expected.x, expected.y, -expected.z}))
    return wrong("the direction must point behind the surface: z < 0");
  if (isNearVector(r->direction, {-expected.x, -expected.y, expected.z}))
    return wrong("the refracted ray must cross the normal: x and y change their signs");
  if (isNear(double(r->direction.x), double(-wo.x * eta), 1e-3))
    return wrong("eta is upside down: sine behind the surface = sine / eta");
  if (!isNear(double(glm::length(r->direction)), 1, 1e-3))
    return wrong(text("the direction has the length %.3g instead of 1", double(glm::length(r->direction))));
  return wrong(text("the sine behind the surface is %.4g instead of %.4g",
                    double(std::hypot(r->direction.x, r->direction.y)), double(std::sqrt(sin2))));
}

Verdict checkReflectance(float cosine, float eta) {
  const std::optional<Refraction> r = refracted({std::sqrt(1 - cosine * cosine), 0, cosine}, eta);
  if (!r) return wrong("total internal reflection where there is none: is eta upside down?");
  const auto [s, p] = polarisedReflectances(double(cosine), double(eta));
  const double own = double(r->reflectance), expected = (s + p) / 2,
               normal = square((double(eta) - 1) / (double(eta) + 1));
  if (isNear(own, expected, 1e-3)) return {};
  const double inside = std::sqrt(1 - (1 - double(cosine) * double(cosine)) / double(eta * eta));
  if (isNear(own, normal + (1 - normal) * std::pow(1 - double(cosine), 5), 1e-3) ||
      isNear(own, normal + (1 - normal) * std::pow(1 - inside, 5), 1e-3))
    return wrong("this is Schlick's approximation; the gap is Fresnel's formula");
  if (isNear(own, 1 - expected, 1e-3)) return wrong("this is the fraction that is refracted");
  if (isNear(own, s + p, 1e-3))
    return wrong("unpolarised light has the mean of both polarisations, not the sum");
  if (isNear(own, (std::sqrt(s) + std::sqrt(p)) / 2, 1e-3)) return wrong("the amplitudes must be squared");
  if (!isNear(s, p, 1e-3) && (isNear(own, s, 1e-3) || isNear(own, p, 1e-3)))
    return wrong("this is one polarisation only; unpolarised light has the mean of both");
  return wrong(text("the reflectance at the cosine %.3g and eta %.3g is %.4g instead of %.4g", double(cosine),
                    double(eta), own, expected));
}

Verdict checkGlass() {
  bool isMissing = true;
  for (const Vec3f& wo : someDirections()) {
    const std::optional<Refraction> r = refracted(wo, 1.5f);
    isMissing = isMissing && r && isNearVector(r->direction, -wo) && r->reflectance == 0;
  }
  if (isMissing) return {State::MISSING, ""};
  for (const float eta : {1.5f, 1 / 1.5f})
    for (const Vec3f& wo : someDirections())
      if (const Verdict v = checkRefractedDirection(wo, eta); v.state != State::RIGHT) return v;
  for (const float cosine : {0.5f, 0.3f, 0.55f, 1.0f})
    if (const Verdict v = checkReflectance(cosine, 1.5f); v.state != State::RIGHT) return v;
  return checkReflectance(0.9f, 1 / 1.5f);
}

Verdict checkPdfSolidAngle() {
  Values values, expected, inverse, withoutCosine, timesCosine, distance;
  for (const auto& [pdf, distance2, cosine] : {std::array{2.0f, 4.0f, 0.5f}, std::array{0.3f, 0.25f, 0.8f}}) {
    values.emplace_back(pdfSolidAngle(pdf, distance2, cosine));
    expected.emplace_back(pdf * distance2 / cosine);
    inverse.emplace_back(pdf * cosine / distance2);
    withoutCosine.emplace_back(pdf * distance2);
    timesCosine.emplace_back(pdf * distance2 * cosine);
    distance.emplace_back(pdf * std::sqrt(distance2) / cosine);
  }
  return judge(
      values, expected,
      {{"pdfSolidAngle: cosine / distance2 is solid angle per area; a density is the other way round",
        inverse},
       {"pdfSolidAngle: the cosine at the lamp is missing", withoutCosine},
       {"pdfSolidAngle: the cosine is a divisor, not a factor", timesCosine},
       {"pdfSolidAngle: the distance must be squared", distance}});
}

bool isMisWeightOpen() { return misWeight(1, 1) == 1 && misWeight(1, 4) == 1 && misWeight(4, 1) == 1; }

Verdict checkMisWeight() {
  if (isMisWeightOpen()) return {State::MISSING, ""};
  for (const auto& [a, b] : {std::pair{1.0f, 1.0f}, {1.0f, 4.0f}, {0.2f, 3.0f}, {50.0f, 0.1f}}) {
    const double one = double(misWeight(a, b)), other = double(misWeight(b, a));
    if (!isNear(one + other, 1, 1e-3))
      return wrong(text("misWeight: the weights of both techniques must add up to 1, but %.3g + %.3g = %.3g",
                        one, other, one + other));
    if (!(one >= 0 && one <= 1)) return wrong("misWeight: a weight is below 0 or above 1");
  }
  const double more = double(misWeight(4, 1));
  if (isNear(more, 0.5))
    return wrong(
        "misWeight: weights of 1/2 give the right mean, but the noise of both techniques; use the densities");
  if (more < 0.5)
    return wrong("misWeight: the technique with the higher density must have the larger weight");
  if (misWeight(1, 0) != 1) return wrong("misWeight: a technique that alone finds a path has the weight 1");
  return {};
}

Verdict checkMis() {
  const Verdict pdf = checkPdfSolidAngle(), weight = checkMisWeight();
  if (pdf.state == State::WRONG) return pdf;
  if (weight.state == State::WRONG) return weight;
  if (pdf.state != weight.state)
    return wrong(std::string("the other half of the gap is open: ") +
                 (pdf.state == State::MISSING ? "pdfSolidAngle" : "misWeight"));
  return pdf;
}

Verdict checkEmissionWeight() {
  if (emissionWeight(true, 0, 2) != 1)
    return wrong("after the camera, a mirror or glass no shadow ray finds the lamp: the weight is 1");
  const std::array<std::pair<float, float>, 3> densities{{{1, 1}, {0.2f, 3}, {3, 0.2f}}};
  bool isZero = true, isOne = true, isRight = true, isSwapped = true;
  for (const auto& [ray, lamp] : densities) {
    const double weight = double(emissionWeight(false, ray, lamp));
    isZero = isZero && weight == 0;
    isOne = isOne && weight == 1;
    isRight = isRight && isNear(weight, double(misWeight(ray, lamp)));
    isSwapped = isSwapped && isNear(weight, double(misWeight(lamp, ray)));
  }
  if (isZero) return {State::MISSING, ""};
  if (isMisWeightOpen()) return {State::WAITS, "its weights are those of gap 9, which is open"};
  if (isRight) return {};
  if (isOne)
    return wrong("after a diffuse surface shadow rays count this light, too: LDE is counted twice; take the "
                 "MIS weight");
  if (isSwapped)
    return wrong("the densities are exchanged: this technique is the ray, the other one light sampling");
  return wrong(text("with the densities 0.2 and 3 the weight is %.3g instead of misWeight(0.2, 3) = %.3g",
                    double(emissionWeight(false, 0.2f, 3)), double(misWeight(0.2f, 3))));
}

} // namespace

std::vector<Gap> pathTracerGaps() {
  return {{1, "emitted radiance", checkEmission},
          {2, "BSDF of a diffuse surface", checkBsdf},
          {3, "cosine-weighted direction", checkSampling},
          {4, "weight of a scattering event", checkScatteringWeight},
          {5, "direct light", checkDirectLight},
          {6, "Russian roulette", checkRoulette},
          {7, "mirror", checkMirror},
          {8, "glass", checkGlass},
          {9, "densities and MIS weights", checkMis},
          {10, "lamps hit by chance", checkEmissionWeight}};
}

} // namespace course
