/** @file
 * Checks of the photon mapper's gaps: closed forms, a search of all photons one by one, and a closed sphere.
 */
#include <cmath>

#include <recurse/scene/directives/loader.h>

#include "checks/checks.h"
#include "frame/photonMapper.h"

namespace course {

namespace {

using namespace photon;

Verdict checkPhotonPower() {
  const Rgb lamp(5, 4, 3);
  struct Case {
    float cosine, pdfArea, pdfDirection;
    int photons;
  };
  const auto by = [&](const std::function<float(const Case&)>& factor) {
    Values values;
    for (const Case& c : {Case{0.5f, 2, 0.2f, 10}, Case{0.9f, 0.3f, 0.6f, 1000}})
      values.push_back(lamp * factor(c));
    return values;
  };
  Values values;
  for (const Case& c : {Case{0.5f, 2, 0.2f, 10}, Case{0.9f, 0.3f, 0.6f, 1000}})
    values.push_back(photonPower(lamp, c.cosine, c.pdfArea, c.pdfDirection, c.photons));
  Verdict verdict = judge(
      values, by([](const Case& c) { return c.cosine / (c.pdfArea * c.pdfDirection * float(c.photons)); }),
      {{"the cosine at the lamp is missing",
        by([](const Case& c) { return 1 / (c.pdfArea * c.pdfDirection * float(c.photons)); })},
       {"radiance is no power: the cosine and both densities are missing",
        by([](const Case& c) { return 1 / float(c.photons); })},
       {"cosine / pdfDirection is pi for cosine-weighted directions only: use the arguments",
        by([](const Case& c) { return PI / (c.pdfArea * float(c.photons)); })},
       {"the photons must share the power: divide by their number",
        by([](const Case& c) { return c.cosine / (c.pdfArea * c.pdfDirection); })},
       {"the division by the density of the direction is missing",
        by([](const Case& c) { return c.cosine / (c.pdfArea * float(c.photons)); })},
       {"the division by the density of the point is missing",
        by([](const Case& c) { return c.cosine / (c.pdfDirection * float(c.photons)); })},
       {"densities are divisors, not factors",
        by([](const Case& c) { return c.cosine * c.pdfArea * c.pdfDirection / float(c.photons); })}});
  if (verdict.state != State::WRONG) return verdict;
  // Power balance: a lamp of 2 m² that emits cosine-weighted photons.
  constexpr int PHOTONS = 1000;
  double sum = 0;
  for (int i = 0; i < PHOTONS; ++i) {
    const float cosine = std::sqrt((float(i) + 0.5f) / PHOTONS);
    sum += double(photonPower(lamp, cosine, 0.5f, cosine * INV_PI, PHOTONS).r);
  }
  verdict.hint +=
      text(" (all photons together have %.3g times the power of the lamp, pi A L)", sum / (PI_D * 2 * 5));
  return verdict;
}

Verdict checkMaps() {
  using Kind = Surface::Kind;
  bool isMissing = true, storesAtMirrors = false, storesAtBlack = false, lacksDirect = false,
       lacksOther = false, causticDirect = false, causticLater = false, lacksCaustic = false;
  for (int specular = 0; specular < 4; ++specular)
    for (int diffuse = 0; diffuse < 4; ++diffuse)
      for (const Kind kind : {Kind::DIFFUSE, Kind::MIRROR, Kind::GLASS, Kind::BLACK}) {
        const Maps maps = mapsOf(kind, {specular, diffuse});
        const bool isStored = maps.global || maps.caustic;
        isMissing = isMissing && !isStored;
        if (kind != Kind::DIFFUSE) {
          (kind == Kind::BLACK ? storesAtBlack : storesAtMirrors) |= isStored;
          continue;
        }
        const bool isDirect = specular == 0 && diffuse == 0;
        if (!maps.global) (isDirect ? lacksDirect : lacksOther) = true;
        if (maps.caustic && isDirect) causticDirect = true;
        if (maps.caustic && diffuse > 0) causticLater = true;
        if (!maps.caustic && specular > 0 && diffuse == 0) lacksCaustic = true;
      }
  if (isMissing) return {State::MISSING, ""};
  if (storesAtMirrors)
    return wrong("photons are stored at mirrors or glass, whose BSDF no density estimate can see");
  if (storesAtBlack) return wrong("photons are stored at black surfaces, which reflect nothing");
  if (causticDirect)
    return wrong(
        "the caustic map has photons straight from the lamp: shadow rays count LDE, which is counted twice");
  if (causticLater)
    return wrong("the caustic map has photons that were scattered diffusely before: the final gather counts "
                 "LD(S|D)*DE, too");
  if (lacksCaustic) return wrong("the caustic map lacks photons that came through mirrors or glass only");
  if (lacksDirect)
    return wrong("the global map lacks photons straight from the lamp: the final gather needs them for LDDE");
  if (lacksOther)
    return wrong("the global map lacks photons: it has every photon at a diffuse surface, those of caustics "
                 "too, which light "
                 "other surfaces");
  return {};
}

Verdict checkScattering() {
  const Rgb power(0.3f, 0.2f, 0.1f);
  return judgeRoulette(
      {{power, Rgb(0.5f)}, {power, Rgb(0.2f, 0.4f, 0.1f)}, {Rgb(4), Rgb(0.3f)}, {power, Rgb(1)}},
      survivesScattering);
}

/** Searches that find other photons than the nearest ones, of 200. */
int wrongSearches() {
  std::vector<Photon> all;
  Sampler sampler(1, 2, 3);
  const auto somewhere = [&] {
    const Vec2f xy = sampler.next2D();
    return Vec3f(xy.x, xy.y, sampler.next1D());
  };
  for (int i = 0; i < 1000; ++i) all.push_back({somewhere(), Vec3f(0, 0, i % 2 ? 1 : -1), Rgb(1), 0});
  PhotonTree tree;
  tree.build(all);
  int wrong = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3f point = somewhere();
    std::vector<float> distances;
    for (const Photon& photon : all)
      if (photon.normal.z > 0) distances.push_back(lengthSquared(photon.position - point));
    std::sort(distances.begin(), distances.end());
    const NearPhotons found = tree.nearest(point, Vec3f(0, 0, 1), 20, 10);
    if (found.photons.size() != 20 || !isNear(double(found.radius2), double(distances[20]), 1e-5)) ++wrong;
  }
  return wrong;
}

Verdict checkTree() {
  bool isMissing = true, visitsTooMany = false, misses = false;
  for (const float distance : {0.01f, 0.5f, 0.9f, 2.0f, -0.01f, -0.5f, -0.9f, -2.0f})
    for (const float radius2 : {0.04f, 0.2f, 0.3f, 0.85f, 3.0f, 5.0f}) {
      const bool visits = visitsFarSide(distance, radius2), needed = distance * distance < radius2;
      isMissing = isMissing && !visits;
      misses = misses || (needed && !visits);
      visitsTooMany = visitsTooMany || (visits && !needed);
    }
  if (isMissing) return {State::MISSING, ""};
  if (const int count = wrongSearches(); misses || count > 0)
    return wrong(text("searches miss photons on the far side: %d of 200 did not find the nearest 20; compare "
                      "squares of distances",
                      count));
  if (visitsTooMany)
    return wrong("the photons are right, but searches visit parts of the tree that are too far away: compare "
                 "the squared "
                 "distance of the plane with the squared radius");
  return {};
}

Verdict checkEstimate() {
  const Rgb bsdf(0.1f, 0.2f, 0.3f);
  const std::vector<NearPhoton> photons{
      {Rgb(1, 2, 3), 0.1f}, {Rgb(4, 2, 1), 0.3f}, {Rgb(0.5f), 0.2f}, {Rgb(2), 0.01f}};
  Rgb flux(0);
  for (const NearPhoton& p : photons) flux += p.power;
  const auto by = [&](const std::function<float(float)>& factor) {
    Values values;
    for (const float radius2 : {0.4f, 2.5f}) values.push_back(bsdf * flux * factor(radius2));
    return values;
  };
  Values values, withoutBsdf;
  for (const float radius2 : {0.4f, 2.5f}) {
    values.push_back(radianceEstimate(photons, radius2, bsdf));
    withoutBsdf.push_back(flux / (PI * radius2));
  }
  return judge(
      values, by([](float r2) { return 1 / (PI * r2); }),
      {{"pi is missing: the photons of the sphere lie on a disc of the area pi r²",
        by([](float r2) { return 1 / r2; })},
       {"4 pi r² is the surface of the sphere; photons lie on a disc of the area pi r²",
        by([](float r2) { return 1 / (4 * PI * r2); })},
       {"this is the volume of the sphere; photons lie on a disc of the area pi r²",
        by([](float r2) { return 3 / (4 * PI * r2 * std::sqrt(r2)); })},
       {"radius2 is the squared radius already", by([](float r2) { return 1 / (PI * r2 * r2); })},
       {"the area has the squared radius, not the radius",
        by([](float r2) { return 1 / (PI * std::sqrt(r2)); })},
       {"the power of photons is added up, not averaged", by([](float r2) { return 0.25f / (PI * r2); })},
       {"the division by the area of the disc is missing", by([](float) { return 1.0f; })},
       {"the BSDF is missing", withoutBsdf}});
}

Verdict checkKernel() {
  constexpr int STEPS = 2000;
  constexpr float R2 = 0.25f;
  double integral = 0;
  for (int i = 0; i < STEPS; ++i) { // rings of the same area
    integral += double(coneKernel(R2 * (float(i) + 0.5f) / STEPS, R2)) * PI_D * double(R2) / STEPS;
  }
  Values values, expected, unnormalised, constant, parabola;
  for (const float r2 : {0.25f, 4.0f})
    for (const float fraction : {0.0f, 0.25f, 0.81f, 1.0f}) { // squared distances
      values.emplace_back(coneKernel(fraction * r2, r2));
      expected.emplace_back(3 * (1 - std::sqrt(fraction)) / (PI * r2));
      unnormalised.emplace_back(1 - std::sqrt(fraction));
      constant.emplace_back(1 / (PI * r2));
      parabola.emplace_back(2 * (1 - fraction) / (PI * r2));
    }
  Verdict verdict =
      judge(values, expected,
            {{"this is the constant kernel; the cone falls to zero at the radius", constant},
             {"this is the parabola (Epanechnikov's kernel): the cone takes the distance, not its square",
              parabola},
             {"the division by the volume of the cone, pi r² / 3, is missing", unnormalised}});
  if (verdict.state == State::WRONG)
    verdict.hint += text(" (over a disc of radius 0.5 the kernel integrates to %.4g instead of 1)", integral);
  return verdict;
}

Verdict checkDirectLight() {
  const Rgb bsdf(0.1f, 0.2f, 0.3f), radiance(5, 4, 3);
  const auto by = [&](const std::function<float(float, float)>& factor) {
    Values values;
    for (const auto& [cosine, pdf] : {std::pair{0.5f, 0.2f}, {0.9f, 3.0f}})
      values.push_back(bsdf * radiance * factor(cosine, pdf));
    return values;
  };
  Values values;
  for (const auto& [cosine, pdf] : {std::pair{0.5f, 0.2f}, {0.9f, 3.0f}})
    values.push_back(directLight(bsdf, cosine, radiance, pdf));
  return judge(
      values, by([](float cosine, float pdf) { return cosine / pdf; }),
      {{"the cosine is missing", by([](float, float pdf) { return 1 / pdf; })},
       {"the division by the density is missing", by([](float cosine, float) { return cosine; })},
       {"the density is a divisor, not a factor", by([](float cosine, float pdf) { return cosine * pdf; })}});
}

std::unique_ptr<Scene> sceneOf(const std::string& world) {
  Diagnostics diagnostics;
  const SceneDescription description = parseScene("Film \"rgb\" \"integer xresolution\" 4 \"integer "
                                                  "yresolution\" 4\nCamera \"perspective\"\nWorldBegin\n" +
                                                      world,
                                                  "check.pbrt", ".", diagnostics);
  std::unique_ptr<Scene> scene = buildScene(description, {}, diagnostics);
  diagnostics.throwIfErrors();
  return scene;
}

/** Mean of final gathers of a point on the inside of a sphere that emits, around a mirror ball. */
struct GatherResult {
  Rgb mean{0};
  bool asksSpecular = false; ///< whether the radiance of a mirror was asked for
};
GatherResult gatherInSphere(const Rgb& radiance) {
  static const std::unique_ptr<Scene> SCENE = sceneOf(R"(
    AttributeBegin
      AreaLightSource "diffuse" "rgb L" [ 1 1 1 ]
      ReverseOrientation
      Material "diffuse" "rgb reflectance" [ .8 .6 .4 ]
      Shape "sphere" "float radius" 2
    AttributeEnd
    Material "conductor" "rgb reflectance" [ .5 .5 .5 ]
    Shape "sphere" "float radius" 1
  )");
  constexpr int COUNT = 1024;
  GatherResult result;
  TransportCounts counts;
  Ray ray;
  ray.origin = Vec3f(Vec3d(0, 0, 1.5) - SCENE->origin());
  ray.direction = Vec3f(0, 0, 1);
  const std::optional<Surface> surface = traceRay(*SCENE, ray, counts);
  for (int i = 0; surface && i < COUNT; ++i) {
    Sampler sampler(7, 0, uint32_t(i));
    const Estimate estimate = [&](const Surface& s) {
      result.asksSpecular = result.asksSpecular || s.kind != Surface::Kind::DIFFUSE;
      return radiance;
    };
    result.mean += finalGather(*SCENE, *surface, estimate, sampler, counts) / float(COUNT);
  }
  return result;
}

Verdict checkFinalGather() {
  const GatherResult dark = gatherInSphere(BLACK), lit = gatherInSphere(Rgb(1));
  if (isBlack(lit.mean) && isBlack(dark.mean)) return {State::MISSING, ""};
  if (lit.asksSpecular || dark.asksSpecular)
    return wrong(
        "estimate() is asked for the radiance of a mirror: seeThrough() goes on to the next diffuse surface");
  if (!isBlack(dark.mean))
    return wrong("light that a lamp emits is added: shadow rays and the caustic map count it already");
  // The ball of half the radius fills a quarter of the cosine-weighted directions, and reflects a half.
  const Rgb expected = Rgb(0.8f, 0.6f, 0.4f) * 0.875f;
  if (isNear(lit.mean, expected, 0.02)) return {};
  if (isNear(lit.mean, Rgb(0.8f, 0.6f, 0.4f), 0.02))
    return wrong("the reflectance of mirrors on the way, Seen::weight, is missing");
  if (isNear(lit.mean, Rgb(0.8f, 0.6f, 0.4f) * 0.933f, 0.02)) // of all directions the ball fills 1 - cos 30°
    return wrong("the directions are uniform, and their weight is that of cosine-weighted ones");
  if (isNear(lit.mean, Rgb(0.875f), 0.02)) return wrong("the albedo of the surface is missing");
  const double factor = double(lit.mean.r / expected.r);
  if (isNear(lit.mean, expected * float(factor), 0.02))
    return wrong(factorInWords(factor, 0.02) +
                 ": BSDF times cosine over the density of the direction is the factor of a ray");
  return wrong(text("in a sphere of radiance 1 around a mirror the mean is (%.3g, %.3g, %.3g) instead of "
                    "(%.3g, %.3g, %.3g)",
                    double(lit.mean.r), double(lit.mean.g), double(lit.mean.b), double(expected.r),
                    double(expected.g), double(expected.b)));
}

} // namespace

std::vector<Gap> photonMapperGaps() {
  return {{1, "power of a photon", checkPhotonPower},
          {2, "photons of each map", checkMaps},
          {3, "Russian roulette of photons", checkScattering},
          {4, "search in the tree", checkTree},
          {5, "radiance estimate", checkEstimate},
          {6, "cone kernel", checkKernel},
          {7, "direct light", checkDirectLight},
          {8, "final gather", checkFinalGather}};
}

} // namespace course
