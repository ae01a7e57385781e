/** @file
 * Textures against closed forms, mappings against their formulas, filtering against averages.
 */
#include "model/textureTesting.h"

#include <numbers>
#include <random>

#include "recurse/model/texture/noise.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

using std::numbers::pi;

Rgb at(const Texture& t, double u, double v) { return t.value(flatPoint(u, v)); }

/** Mean of f over a box around (x, y), by points. */
template <class F> double boxMean(double x, double y, double w, double h, const F& f) {
  constexpr int N = 200;
  double sum = 0;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j)
      sum += f(x + w * ((i + 0.5) / N - 0.5), y + h * ((j + 0.5) / N - 0.5)) / (N * N);
  return sum;
}

} // namespace

TEST(Texture, EveryExampleOfEitherKindCanBeMadeAndIsSound) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-20, 20);
  const Textures none;
  for (const auto& entry : plugIns().textures.entries()) {
    EXPECT_FALSE(entry.summary.empty()) << entry.name;
    for (const ParameterSpec& p : entry.parameters)
      EXPECT_FALSE(p.description.empty()) << entry.name << " " << p.name;
    for (const std::string& example : entry.examples) {
      int kinds = 0;
      for (const bool spectrum : {false, true}) {
        Diagnostics diagnostics;
        const auto texture = tryTexture(entry.name, example, {none, spectrum}, diagnostics);
        if (!texture) {
          EXPECT_NE(diagnostics.format().find("cannot be a"), std::string::npos) << diagnostics.format();
          continue;
        }
        ++kinds;
        for (int i = 0; i < 500; ++i) {
          SurfacePoint p = pointAt({uniform(random), uniform(random), uniform(random)});
          p.uv = {uniform(random), uniform(random)};
          if (i % 2) p = seen(p, std::exp2(0.5f * uniform(random)));
          const Rgb v = texture->value(p);
          EXPECT_TRUE(isFinite(v)) << entry.name;
          EXPECT_EQ(v, texture->value(p)) << entry.name;
          if (!spectrum) {
            EXPECT_TRUE(v.r == v.g && v.g == v.b) << entry.name;
          }
        }
      }
      EXPECT_GT(kinds, 0) << entry.name << " " << example;
    }
  }
}

TEST(Texture, ConstantScaleMix) {
  expectNear(at(*makeTexture("constant", "\"rgb value\" [.1 .2 .3]"), 4, 5), {.1f, .2f, .3f}, 1e-7);
  EXPECT_EQ(at(*makeTexture("constant", "\"float value\" -2", false), 0, 0), Rgb(-2));
  expectNear(at(*makeTexture("scale", "\"rgb tex\" [.1 .2 .3] \"float scale\" 3"), 0, 0), {.3f, .6f, .9f},
             1e-6);
  expectNear(at(*makeTexture("mix", "\"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] \"float amount\" .25"), 0, 0),
             {.75f, 0, .25f}, 1e-7);
  const auto red = makeTexture("constant", "\"rgb value\" [1 0 0]"),
             blue = makeTexture("constant", "\"rgb value\" [0 0 1]"),
             half = makeTexture("constant", "\"float value\" 7", false); // clamped to the range of the amount
  Textures named;
  named.named = {{"red", red.get()}, {"blue", blue.get()}, {"half", half.get()}};
  const auto mix =
      makeTexture("mix", "\"texture tex1\" \"red\" \"texture tex2\" \"blue\" \"texture amount\" \"half\"",
                  true, Mat4d(1), named);
  EXPECT_EQ(at(*mix, 0, 0), Rgb(0, 0, 1));
}

TEST(Texture, DirectionMixFollowsTheCosineInTheSceneOfItsTransform) {
  // The y axis of the texture is the x axis of the scene, scaled.
  Mat4d turned(1);
  turned[1] = Vec4d(5, 0, 0, 0);
  turned[0] = Vec4d(0, 1, 0, 0);
  const auto t = makeTexture("directionmix", "\"float tex1\" .9 \"float tex2\" .1", false, turned);
  for (const double degrees : {0.0, 30.0, 90.0, 180.0}) {
    SurfacePoint p = flatPoint(0, 0);
    const double a = glm::radians(degrees), c = std::abs(std::cos(a));
    p.geometricNormal = Vec3f(Vec3d(std::cos(a), 0, std::sin(a)));
    EXPECT_NEAR(t->value(p).r, .9 * c + .1 * (1 - c), 1e-6) << degrees;
  }
}

TEST(Texture, BilerpIsBilinear) {
  const auto t =
      makeTexture("bilerp", "\"float v00\" 1 \"float v01\" 2 \"float v10\" 4 \"float v11\" 8", false);
  EXPECT_FLOAT_EQ(at(*t, 0, 0).r, 1);
  EXPECT_FLOAT_EQ(at(*t, 0, 1).r, 2);
  EXPECT_FLOAT_EQ(at(*t, 1, 0).r, 4);
  EXPECT_FLOAT_EQ(at(*t, 1, 1).r, 8);
  EXPECT_NEAR(at(*t, .25, .5).r, .75 * 1.5 + .25 * 6, 1e-6);
  // The defaults increase with t.
  EXPECT_NEAR(at(*makeTexture("bilerp", "", false), .3, .7).r, .7, 1e-6);
}

TEST(Texture, CheckerboardOfTwoDimensions) {
  const auto t =
      makeTexture("checkerboard", "\"float uscale\" 4 \"float vscale\" 2 \"float udelta\" 1", false);
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 6; ++j) {
      const double s = i - 3 + .5, v = j - 2 + .3;
      EXPECT_EQ(at(*t, (s - 1) / 4, v / 2).r, (i - 3 + j - 2) % 2 == 0 ? 1 : 0) << i << " " << j;
    }
}

TEST(Texture, CheckerboardIsTheMeanOverTheFootprint) {
  const auto t = makeTexture("checkerboard", "\"float tex1\" .9 \"float tex2\" .3", false);
  const auto sharp = [&](double s, double v) { return double(at(*t, s, v).r); };
  for (const double x : {.2, .9, 5.05, -1.1})
    for (const float width : {.01f, .3f, 1.f, 1.7f, 6.3f}) {
      // From above the footprint is a circle; the texture averages over the box around it.
      EXPECT_NEAR(t->value(seen(flatPoint(x, .4), width)).r,
                  boxMean(x, .4, double(width), double(width), sharp), .006)
          << x << " " << width;
    }
  // At an oblique angle it is longer, along the ray's direction.
  SurfacePoint p = flatPoint(.3, .4);
  p.footprint = {glm::normalize(Vec3f(1, 0, -.5f)), .2f};
  EXPECT_NEAR(t->value(p).r, boxMean(.3, .4, .2 * std::sqrt(1.25) / .5, .2, sharp), .006);
}

TEST(Texture, CheckerboardOfThreeDimensionsHasItsOwnSpace) {
  Mat4d moved = glm::dmat4(1);
  moved[0] *= .5;
  moved[3] = Vec4d(10, 0, 0, 1);
  const auto t = makeTexture("checkerboard", "\"integer dimension\" 3", false, moved);
  for (const auto& [p, wanted] : std::vector<std::pair<Vec3f, float>>{{{10.1f, .5f, .5f}, 1},
                                                                      {{10.6f, .5f, .5f}, 0},
                                                                      {{10.6f, 1.5f, .5f}, 1},
                                                                      {{10.6f, 1.5f, -.5f}, 0},
                                                                      {{9.9f, .5f, .5f}, 0}})
    EXPECT_EQ(t->value(pointAt(p)).r, wanted) << p.x << " " << p.y << " " << p.z;
}

TEST(TextureMapping, FollowsItsFormulas) {
  // bilerp shows the coordinates: s in red, t in green.
  const auto shown = [](const std::string& mapping, const Mat4d& m = Mat4d(1)) {
    return makeTexture("bilerp",
                       mapping +
                           " \"rgb v00\" [0 0 0] \"rgb v10\" [1 0 0] \"rgb v01\" [0 1 0] \"rgb v11\" [1 1 0]",
                       true, m);
  };
  expectNear(
      at(*shown("\"float uscale\" 2 \"float vscale\" 3 \"float udelta\" .1 \"float vdelta\" .2"), .25, .1),
      {.6f, .5f, 0}, 1e-6);
  const Vec3f p(1, 2, -3);
  expectNear(shown("\"string mapping\" \"planar\" \"vector3 v1\" [.1 0 .1] \"vector3 v2\" [0 .2 0] \"float "
                   "udelta\" .5")
                 ->value(pointAt(p)),
             {.3f, .4f, 0}, 1e-6);
  const double r = std::sqrt(14.), theta = std::acos(-3 / r), phi = std::atan2(2., 1.);
  expectNear(shown("\"string mapping\" \"spherical\"")->value(pointAt(p)),
             Rgb(float(theta / pi), float(phi / (2 * pi)), 0), 1e-6);
  expectNear(shown("\"string mapping\" \"cylindrical\"")->value(pointAt(p)),
             Rgb(float((pi + phi) / (2 * pi)), -3, 0), 1e-6);
  // In the space of the transform at the Texture directive.
  Mat4d moved(2);
  moved[3] = Vec4d(1, 2, -13, 1);
  expectNear(shown("\"string mapping\" \"cylindrical\"", moved)->value(pointAt({1, 4, -3})), {.75f, 5, 0},
             1e-6);
}

TEST(TextureMapping, ChangesOverTheFootprintAreDerivatives) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Textures none;
  Mat4d m(1);
  m[0] = Vec4d(.8, .3, .1, 0);
  m[3] = Vec4d(.2, -.1, .3, 1);
  for (const char* text :
       {"\"string mapping\" \"planar\" \"vector3 v1\" [.1 .5 .1] \"vector3 v2\" [-.7 .2 0]",
        "\"string mapping\" \"spherical\"", "\"string mapping\" \"cylindrical\"",
        "\"float uscale\" 3 \"float vscale\" -2"}) {
    Diagnostics diagnostics;
    const ParsedDirective d = parseParameterText("x", text);
    const TextureMapping mapping(bindParameters(d, withMapping({}), diagnostics, false),
                                 {none, true, m, nullptr});
    ASSERT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
    for (int i = 0; i < 100; ++i) {
      const auto vector = [&] { return Vec3d(uniform(random), uniform(random), uniform(random)); };
      const Vec3d n = glm::normalize(vector()), u = glm::cross(n, vector()), v = glm::cross(n, vector());
      const Vec3d position = vector() + Vec3d(3, 0, 0);
      SurfacePoint p{};
      p.position = Vec3f(position);
      p.geometricNormal = Vec3f(n);
      p.dpdu = Vec3f(u);
      p.dpdv = Vec3f(v);
      p.uv = {.3f, .4f};
      Vec3d view = glm::normalize(vector());
      if (std::abs(glm::dot(view, n)) < .1 || glm::length(glm::cross(u, v)) < .05) continue;
      p.footprint = {Vec3f(view), .01f};
      const FootprintAxes axes(p);
      const double cosine = std::abs(glm::dot(view, n));
      EXPECT_NEAR(glm::length(axes.x), .01 / cosine, 1e-4 / cosine);
      EXPECT_NEAR(glm::length(axes.y), .01, 1e-5);
      EXPECT_NEAR(glm::dot(axes.x, p.geometricNormal), 0, 1e-6);
      EXPECT_NEAR(glm::dot(axes.x, axes.y), 0, 1e-7);
      const MappedCoordinates found = mapping.at(p);
      for (const bool second : {false, true}) {
        const Vec3d along = second ? axes.y : axes.x;
        // The step in (u, v) solves du u + dv v = along.
        const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), det = uu * vv - uv * uv;
        const Vec2d step = Vec2d(vv * glm::dot(along, u) - uv * glm::dot(along, v),
                                 uu * glm::dot(along, v) - uv * glm::dot(along, u)) /
                           det;
        SurfacePoint a = p, b = p;
        a.position = Vec3f(position - 8.0 * along);
        b.position = Vec3f(position + 8.0 * along);
        a.uv -= Vec2f(8.0 * step);
        b.uv += Vec2f(8.0 * step);
        const Vec2f wanted = (mapping.at(b).st - mapping.at(a).st) / 16.0f;
        if (glm::length(mapping.at(b).st - mapping.at(a).st) > .4f) continue; // across the seam, or very long
        const Vec2f got = second ? found.alongY : found.alongX;
        EXPECT_LT(glm::length(got - wanted), .05f * glm::length(wanted) + 1e-5f) << text;
      }
    }
  }
}

TEST(Noise, IsThatOfTheReference) {
  // Value of K. Perlin's reference implementation at the point that ports use for comparison.
  EXPECT_NEAR(perlinNoise({3.14, 42, 7}), 0.13691995878400012, 1e-12);
}

TEST(Noise, VanishesOnTheLatticeAndRepeats) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-300, 300);
  double sum = 0, highest = 0;
  constexpr int N = 20000;
  for (int i = 0; i < N; ++i) {
    const Vec3d p(uniform(random), uniform(random), uniform(random));
    EXPECT_EQ(perlinNoise(glm::floor(p)), 0);
    EXPECT_NEAR(perlinNoise(p), perlinNoise(p + Vec3d(256, -512, 768)), 1e-9);
    EXPECT_LT(std::abs(perlinNoise(p) - perlinNoise(p + 1e-7)), 1e-5); // continuous
    sum += perlinNoise(p);
    highest = std::max(highest, std::abs(perlinNoise(p)));
  }
  EXPECT_NEAR(sum / N, 0, 0.01);
  EXPECT_LE(highest, 1.1);
  EXPECT_GT(highest, 0.6);
  // Slope at lattice points: the gradient of the nearest point alone.
  const Vec3d h(1e-6, 0, 0);
  const double slope = (perlinNoise(h) - perlinNoise(-h)) / 2e-6;
  EXPECT_NEAR(slope, std::round(slope), 1e-4);
}

TEST(Noise, FractalSumsAreTheOctaves) {
  const auto t = makeTexture("fbm", "\"integer octaves\" 3 \"float roughness\" .7", false);
  const auto w = makeTexture("wrinkled", "\"integer octaves\" 3 \"float roughness\" .7", false);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> uniform(-5, 5);
  for (int i = 0; i < 50; ++i) {
    const Vec3d p(uniform(random), uniform(random), uniform(random)), q = Vec3d(Vec3f(p));
    double sum = 0, absolute = 0, f = 1, o = 1;
    for (int k = 0; k < 3; ++k, f *= 1.99, o *= .7) {
      sum += o * perlinNoise(f * q);
      absolute += o * std::abs(perlinNoise(f * q));
    }
    EXPECT_NEAR(t->value(pointAt(Vec3f(p))).r, sum, 1e-5);
    EXPECT_NEAR(w->value(pointAt(Vec3f(p))).r, absolute + o * .2, 1e-5);
  }
}

TEST(Noise, OctavesBelowTheFootprintAreAveragedAway) {
  const auto fbm = makeTexture("fbm", "", false),
             wrinkled = makeTexture("wrinkled", "\"integer octaves\" 5", false);
  const SurfacePoint p = pointAt({.3f, .4f, .6f});
  EXPECT_EQ(fbm->value(seen(p, 4)).r, 0);
  // With a footprint of 1/8 only the octaves of wavelength 1 and 1/2 remain.
  EXPECT_NEAR(fbm->value(seen(p, .125f)).r,
              perlinNoise(p.position) + .5 * perlinNoise(1.99 * Vec3d(p.position)), 1e-6);
  EXPECT_NEAR(wrinkled->value(seen(p, 4)).r, .2 * (1 + 1 + .5 + .25 + .125 + .0625), 1e-6);
}

TEST(Noise, WindyAndMarble) {
  const auto windy = makeTexture("windy", "", false);
  const Vec3d p(.4, 2.3, 5.2), q = Vec3d(Vec3f(p));
  const auto fractal = [](const Vec3d& x, int n) {
    double sum = 0, f = 1, o = 1;
    for (int k = 0; k < n; ++k, f *= 1.99, o *= .5) sum += o * perlinNoise(f * x);
    return sum;
  };
  EXPECT_NEAR(windy->value(pointAt(Vec3f(p))).r, std::abs(fractal(.1 * q, 3)) * fractal(q, 6), 1e-6);
  // Without noise, marble has layers: the ends of the spline are at the extremes of the sine.
  const auto marble = makeTexture("marble", "\"float variation\" 0 \"float scale\" 2");
  expectNear(marble->value(pointAt({3, float(pi / 4), 1})), Rgb(.58f, .58f, .6f) * 1.5f, 1e-3);
  expectNear(marble->value(pointAt({3, -float(pi / 4), 1})), Rgb(.58f, .58f, .6f) * 1.5f, 1e-3);
  // In the middle, at three of six segments, the Bézier curve begins at its first point.
  expectNear(marble->value(pointAt({3, 0, 1})), Rgb(.5f, .5f, .5f) * 1.5f, 1e-3);
}

TEST(Texture, ValuesOfBallsAreBlendedByTheirFields) {
  const std::string
      balls = "\"point3 P\" [-1 0 0  1 0 0  0 9 0] \"float radius\" [2 2.5 1] \"float strength\" [1 3 -1] ",
      colours = "\"rgb values\" [1 0 .5  0 1 .5  7 7 7] ";
  const Vec3f p(.25f, .5f, -.3f);
  const double q[2] = {(1.25 * 1.25 + .25 + .09) / 4, (.75 * .75 + .25 + .09) / 6.25};
  for (const auto& [name, field] : std::map<std::string, double (*)(double)>{
           {"quartic", [](double x) { return (1 - x) * (1 - x); }},
           {"sextic", [](double x) { return (1 - x) * (1 - x) * (1 - x); }},
           {"wyvill", [](double x) { return 1 - 22 / 9. * x + 17 / 9. * x * x - 4 / 9. * x * x * x; }},
           {"blinn", [](double x) { return (1 - x) * (1 - x) * ((1 - x) * (1 - x) + x * x); }}}) {
    const auto t = makeTexture("metaballs", balls + colours + "\"string field\" \"" + name + "\"");
    const double a = field(q[0]), b = 3 * field(q[1]);
    expectNear(t->value(pointAt(p)), Rgb(float(a / (a + b)), float(b / (a + b)), .5f), 1e-6, name);
  }
  // Within reach of one of them, and of none; a negative ball has no colour.
  const auto t = makeTexture("metaballs", balls + colours);
  expectNear(t->value(pointAt({-2.5f, 0, 0})), {1, 0, .5f}, 1e-6);
  expectNear(t->value(pointAt({40, 0, 0})), {0, 1, .5f}, 1e-6);
  expectNear(t->value(pointAt({0, 9, 0})), {0, 1, .5f}, 1e-6);
  // The balls move with their transform, as the shape does.
  Mat4d moved(2);
  moved[3] = Vec4d(5, 6, 7, 1);
  expectNear(makeTexture("metaballs", balls + colours, true, moved)->value(pointAt(Vec3f(5, 6, 7) + 2.f * p)),
             t->value(pointAt(p)), 1e-6);
  EXPECT_NEAR(makeTexture("metaballs", balls + "\"float values\" [.2 .2 .9]", false)->value(pointAt(p)).g, .2,
              1e-6);
  const auto refused = [&](const std::string& parameters, const std::string& part) {
    Diagnostics diagnostics;
    EXPECT_FALSE(tryTexture("metaballs", parameters, {Textures(), false}, diagnostics));
    EXPECT_NE(diagnostics.format().find(part), std::string::npos) << diagnostics.format();
  };
  refused(balls + "\"float values\" [1 2]", "2 given for 3 positions");
  refused(balls + colours, "a float texture cannot have colours");
  refused("\"point3 P\" [0 0 0] \"float strength\" 0 \"float values\" [1]",
          "no ball has a positive strength");
}

TEST(Texture, DotsAreDiscsInSomeCells) {
  const auto t = makeTexture("dots", "\"float inside\" .8 \"float outside\" .1", false);
  constexpr int CELLS = 24, FINE = 40;
  int full = 0, empty = 0;
  for (int x = 0; x < CELLS; ++x)
    for (int y = 0; y < CELLS; ++y) {
      double inside = 0;
      for (int i = 0; i < FINE; ++i)
        for (int j = 0; j < FINE; ++j) {
          const float v = at(*t, x - .5 + (i + .5) / FINE, y - .5 + (j + .5) / FINE).r;
          EXPECT_TRUE(v == .8f || v == .1f);
          inside += v == .8f;
        }
      const double area = inside / (FINE * FINE);
      if (area == 0) {
        ++empty;
        continue;
      }
      ++full;
      EXPECT_NEAR(area, pi * .35 * .35, .02) << "a whole disc lies in its cell";
    }
  EXPECT_GT(full, CELLS * CELLS / 4);
  EXPECT_GT(empty, CELLS * CELLS / 4);
}

TEST(Texture, WrongKindsAndParametersAreRefused) {
  const Textures none;
  const auto complaint = [&](const std::string& name, const std::string& parameters, bool spectrum) {
    Diagnostics diagnostics;
    EXPECT_FALSE(tryTexture(name, parameters, {none, spectrum}, diagnostics)) << name << " " << parameters;
    return diagnostics.format();
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  has(complaint("marble", "", false), "cannot be a float texture");
  has(complaint("fbm", "", true), "cannot be a spectrum texture");
  has(complaint("constant", "\"rgb value\" [1 0 0]", false), "is a colour");
  has(complaint("mix", "\"rgb tex1\" [1 -1 0]", true), "is negative");
  has(complaint("bilerp", "\"string mapping\" \"planar\" \"float uscale\" 2", true), "has no \"uscale\"");
  has(complaint("bilerp", "\"vector3 v1\" [1 0 0]", true), "has no \"v1\"");
  has(complaint("bilerp", "\"string mapping\" \"cubic\"", true), "cannot be \"cubic\"");
  has(complaint("checkerboard", "\"integer dimension\" 4", true), "2 to 3");
  has(complaint("directionmix", "\"vector3 dir\" [0 0 0]", true), "no direction");
  has(complaint("fbm", "\"integer octaves\" 0", false), "1 to 64");
}
