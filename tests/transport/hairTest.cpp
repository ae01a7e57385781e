/** @file
 * Hair in whole scenes: invisible without absorption in uniform light, and the same by photons and by rays,
 * though no photons are stored on it.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Curves on the ground in a ring, some of them bent. */
std::string tuft(const std::string& material, const std::string& type) {
  std::string text = material + "\n";
  for (int i = 0; i < 9; ++i) {
    const double a = 0.7 * i, x = 0.4 * std::cos(a), y = 0.4 * std::sin(a);
    const auto point = [&](double out, double z) {
      return std::to_string(x * out) + " " + std::to_string(y * out) + " " + std::to_string(z) + " ";
    };
    text += "Shape \"curve\" \"string type\" \"" + type + "\" \"float width\" .12 \"point3 P\" [" +
            point(1, 0) + point(1, .4) + point(1.2, .7) + point(i % 3 ? 1.2 : 2.2, 1) + "]\n";
  }
  return text;
}

const char* const HAIR = "Material \"hair\" \"rgb sigma_a\" [.1 .3 .6] \"float beta_n\" .4";
const char* const HAIR_LAMP =
    "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 20 20 20 ]\nTranslate 1.5 -1 2\n"
    "Shape \"sphere\" \"float radius\" .4\nAttributeEnd\n";
const char* const GROUND =
    "Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\nShape \"disk\" \"float radius\" 3\n";
const char* const VIEW = "0 -3 1.5  0 0 .4  0 0 1";

void expectSameMean(const Rendered& a, const Rendered& b, double bias = 0) {
  EXPECT_NEAR(a.mean(), b.mean(), 4 * std::hypot(a.standardError(), b.standardError()) + bias * a.mean());
}

} // namespace

TEST(Hair, WhiteHairVanishesInAFurnace) {
  for (const char* type : {"flat", "cylinder"}) {
    const Rendered r = renderText(view(16, VIEW, 40) + "LightSource \"infinite\" \"rgb L\" [1 1 1]\n" +
                                      tuft("Material \"hair\" \"rgb sigma_a\" [0 0 0]", type),
                                  "path", "", samples(256));
    for (size_t i = 0; i < r.pixels(); ++i)
      EXPECT_NEAR(double(luminance(r.value(i))), 1, 0.005 + 5 * std::sqrt(r.film.variance(i) / samples(256)))
          << type << " " << i;
  }
}

TEST(Hair, PhotonsBringTheSameLightAsRays) {
  const std::string photons = "\"integer passes\" 32 \"integer photons\" 20000";
  const std::vector<Way> ways = {{"photonmap", photons},
                                 {"photonmap", photons + " \"string direct\" \"photons\""},
                                 {"photonmap", photons + " \"integer finalgather\" 1"}};
  size_t scenes = 1;
  for (const char* material : {HAIR, "Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]"}) {
    const auto scene = sceneFrom(view(16, VIEW, 40) + HAIR_LAMP + GROUND + tuft(material, "cylinder"));
    const Rendered rays = renderScene(*scene, "path", "", samples(1024));
    for (const Way& way : dealt(ways, scenes++)) {
      SCOPED_TRACE(std::string(material) + " " + way.parameters);
      expectSameMean(rays, renderScene(*scene, way.integrator, way.parameters, samples(128)), 0.01);
    }
  }
}

TEST(Hair, NoPhotonIsKeptOnIt) {
  const auto scene = sceneFrom(view(8, VIEW, 40) + HAIR_LAMP + tuft(HAIR, "flat"));
  const Rendered r = renderScene(
      *scene, "photonmap", "\"integer passes\" 1 \"integer photons\" 5000 \"string direct\" \"photons\"", 4);
  EXPECT_EQ(r.statistics.photonsStored, 0u);
  EXPECT_GT(r.mean(), 0);
}

TEST(Hair, WhatNeedsReciprocityLeavesItToPath) {
  const auto scene = sceneFrom(view(8, VIEW, 40) + HAIR_LAMP + tuft(HAIR, "flat"));
  for (const char* name : {"bdpt", "vcm", "lightpath", "vpl", "simplephotonmap"})
    EXPECT_EQ(unsupportedPart(*integratorFrom(name, ""), *scene), "hair") << name;
  for (const char* name : {"path", "simplepath", "photonmap", "whitted"})
    EXPECT_EQ(unsupportedPart(*integratorFrom(name, ""), *scene), "") << name;
}
