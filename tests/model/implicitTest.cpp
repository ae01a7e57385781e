/** @file
 * Level sets of expressions: the expressions themselves, and the surfaces against analytic shapes, brute
 * force and closed forms.
 */
#include <ctime>

#include "model/shapeTesting.h"
#include "sanitized.h"
#include "shapes/analytic/expression.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::unique_ptr<Shape> implicit(const std::string& function, const std::string& rest = "",
                                const Mat4d& transform = Mat4d(1)) {
  return make("implicit", "\"string function\" \"" + function + "\" " + rest, {transform});
}

std::vector<Solid::Crossing> sortedCrossings(const Solid& solid, const Vec3d& o, const Vec3d& d) {
  std::vector<Solid::Crossing> found;
  solid.crossings(o, d, found);
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return found;
}

/** Expects the same crossings and normals of two solids along random lines through the unit ball. */
void expectSameSolid(const Shape& a, const Shape& b, uint64_t seed, double tolerance = 1e-9) {
  const auto one = a.asSolid(), other = b.asSolid();
  Random random(seed);
  size_t crossed = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3d o = random.direction() * 4.0;
    const Vec3d d = glm::normalize(random.direction() * random.uniform(0, 1.4) - o);
    const auto x = sortedCrossings(*one, o, d), y = sortedCrossings(*other, o, d);
    ASSERT_EQ(x.size(), y.size()) << i;
    for (size_t k = 0; k < x.size(); ++k) {
      const SurfacePoint p = a.surfaceAt(x[k].primitive, x[k].parameters),
                         q = b.surfaceAt(y[k].primitive, y[k].parameters);
      const double cosine = std::abs(glm::dot(Vec3d(q.geometricNormal), d));
      EXPECT_NEAR(x[k].t, y[k].t, tolerance / cosine) << i;
      EXPECT_EQ(x[k].entering, y[k].entering) << i;
      EXPECT_LT(glm::length(p.position - q.position), 1e-6f) << i;
      EXPECT_LT(glm::length(p.geometricNormal - q.geometricNormal), 2e-5f) << i;
      ++crossed;
    }
  }
  EXPECT_GT(crossed, 1000u);
}

} // namespace

TEST(Expression, ValuesAreThoseOfTheFormula) {
  const struct {
    const char* text;
    double (*formula)(double, double, double);
  } cases[] = {
      {"x^2+y^2+z^2-1", [](double x, double y, double z) { return x * x + y * y + z * z - 1; }},
      {"-x^2", [](double x, double, double) { return -(x * x); }},
      {"2^3^x", [](double x, double, double) { return std::exp(std::log(2) * std::pow(3, x)); }},
      {"x - y - z", [](double x, double y, double z) { return x - y - z; }},
      {"x / y / z", [](double x, double y, double z) { return x / y / z; }},
      {"x*-y", [](double x, double y, double) { return -x * y; }},
      {"- -+x", [](double x, double, double) { return x; }},
      {"x^-2", [](double x, double, double) { return 1 / (x * x); }},
      {"x^1.5 + y^(1/2)", [](double x, double y, double) { return x * std::sqrt(x) + std::sqrt(y); }},
      {"x^y", [](double x, double y, double) { return std::pow(x, y); }},
      {"x*x*x", [](double x, double, double) { return x * x * x; }},
      {"min(x, y, z)",
       [](double x, double y, double z) {
         return std::min({x, y, z});
       }},
      {"max(x, max(y, z))",
       [](double x, double y, double z) {
         return std::max({x, y, z});
       }},
      {"abs(x - y)", [](double x, double y, double) { return std::abs(x - y); }},
      {"sqrt(x) + log(y)", [](double x, double y, double) { return std::sqrt(x) + std::log(y); }},
      {"sin(pi*x)*cos(2*y)",
       [](double x, double y, double) { return std::sin(PI_DOUBLE * x) * std::cos(2 * y); }},
      {"exp(-x)/(1e-1 + y)", [](double x, double y, double) { return std::exp(-x) / (.1 + y); }},
      {" ( x ) + .5e1*sin( 1 ) ", [](double x, double, double) { return x + 5 * std::sin(1.0); }}};
  Random random(51);
  for (const auto& c : cases) {
    const Expression f{c.text};
    for (int i = 0; i < 200; ++i) {
      const Vec3d p(random.uniform(.01, 2), random.uniform(.01, 2), random.uniform(.01, 2));
      const double expected = c.formula(p.x, p.y, p.z), scale = 1 + std::abs(expected);
      EXPECT_NEAR(f.value(p), expected, 1e-13 * scale) << c.text;
      // Jet by finite differences.
      const Jet jet = f.jet(p);
      EXPECT_NEAR(jet.value, expected, 1e-13 * scale) << c.text;
      constexpr double STEP = 1e-6;
      for (int k = 0; k < 3; ++k) {
        Vec3d step(0);
        step[k] = STEP * std::min(p[k], 1.0);
        const Jet above = f.jet(p + step), below = f.jet(p - step);
        const double slope = (above.value - below.value) / (2 * step[k]);
        if (std::string(c.text).find_first_of("am") != std::string::npos) continue; // has creases
        EXPECT_NEAR(jet.gradient[k], slope, 1e-4 * (scale + std::abs(slope)) / std::min(p[k], 1.0)) << c.text;
        for (int j = 0; j < 3; ++j) {
          const double second = (above.gradient[j] - below.gradient[j]) / (2 * step[k]);
          EXPECT_NEAR(jet.second[j][k], second,
                      1e-4 * (scale + std::abs(second)) / square(std::min(p[k], 1.0)))
              << c.text;
        }
      }
    }
  }
}

TEST(Expression, IntervalsContainEveryValueAndSlope) {
  Random random(52);
  for (const char* text :
       {"x^2 - y*z", "x^3 - 2*x^5*y", "sin(7*x)*cos(5*y) - sin(x - z)", "exp(sin(9*x) - y)",
        "abs(x - y) - abs(z)", "min(x, y*z, x*y) - max(z, x)", "sqrt(abs(x) + y^2)", "sqrt(max(x, 0)) - y",
        "x/(2 + y) - 1/(z^2 + .1)", "log(3 + x*y)^3", "(x^2 + .1)^.7 - (y^2 + .2)^-1.3", "x^-2 + y^-3",
        "sqrt(x) - log(y)", "1/(x - y)", "(x + 2)^z"}) {
    const Expression f{text};
    for (int i = 0; i < 3000; ++i) {
      const double width = random.powerOfTen(-9, 0.3);
      const Vec3d o(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)),
          d = random.direction();
      std::array<Interval, 3> box;
      std::array<Slope, 3> along;
      for (int k = 0; k < 3; ++k) {
        box[size_t(k)] = Interval(o[k]) + Interval(d[k]) * Interval(0, width);
        along[size_t(k)] = {box[size_t(k)], Interval(d[k])};
      }
      const Interval bounds = f.value(box);
      const Slope slope = f.slope(along);
      if (bounds.isEmpty()) {
        EXPECT_TRUE(slope.value.isEmpty()) << text;
      } else {
        EXPECT_EQ(slope.value.low, bounds.low) << text;
        EXPECT_EQ(slope.value.high, bounds.high) << text;
      }
      double before = 0;
      bool hasBefore = false;
      for (int k = 0; k <= 8; ++k) {
        const double value = f.value(o + d * (width * k / 8));
        if (std::isnan(value)) {
          EXPECT_TRUE(bounds.isPartial) << text;
        } else if (std::isfinite(value)) {
          EXPECT_TRUE(bounds.contains(value)) << text << ": " << value;
          // Mean value theorem, if the function has no jumps. Positions and values are rounded.
          const double steepest = std::max(std::abs(slope.slope.low), std::abs(slope.slope.high));
          const double rounding =
              (1e-14 * (1 + std::abs(value) + std::abs(before)) + 1e-14 * steepest) * 8 / width;
          if (hasBefore && !bounds.isPartial && rounding < 1) {
            EXPECT_GE((value - before) * 8 / width, slope.slope.low - rounding) << text;
            EXPECT_LE((value - before) * 8 / width, slope.slope.high + rounding) << text;
          }
        }
        before = value;
        hasBefore = std::isfinite(value);
      }
    }
  }
}

TEST(Expression, ErrorsPointAtTheCharacter) {
  std::string deep(300, '('), longest = "x";
  for (int i = 0; i < 1200; ++i) longest += "+sin(" + std::to_string(i) + "*x)";
  const struct {
    std::string text;
    size_t offset;
    const char* message;
  } cases[] = {{"", 0, "the expression is empty"},
               {"   ", 3, "ends where a value belongs"},
               {"x +", 3, "ends where a value belongs"},
               {"x + * y", 4, "a value is missing before \"*\""},
               {"(x + y", 0, "this parenthesis is not closed"},
               {"x + y)", 5, "closes none"},
               {"()", 1, "a value is missing before \")\""},
               {"x y", 2, "an operator is missing before \"y\""},
               {"2x", 1, "an operator is missing before \"x\""},
               {"(x 2)", 3, "an operator is missing before \"2\""},
               {"x # y", 2, "an operator is missing before \"#\""},
               {"x + #", 4, "\"#\" is not allowed"},
               {"x + \xc3\xa9", 4, "this character is not allowed"},
               {"x + w", 4, "\"w\" is neither a variable nor a function"},
               {"x + tan(y)", 4, "\"tan\" is neither"},
               {"x(2)", 1, "an operator is missing before \"(\""},
               {"x + sin", 4, "the function has no arguments"},
               {"x + sin y", 4, "the function has no arguments"},
               {"x + sin()", 8, "the function has no arguments"},
               {"sin(x, y)", 5, "too many arguments"},
               {"(x, y)", 2, "too many arguments"},
               {"x, y", 1, "a comma outside of the arguments"},
               {"x + min(y)", 9, "needs a second argument"},
               {"min(x, )", 7, "a value is missing before \")\""},
               {"sin(x", 3, "this parenthesis is not closed"},
               {"x + 1.2.3", 7, "a second point"},
               {"x + .", 4, "this is no number"},
               {"x + 1e999", 4, "too large"},
               {"x + 1/0", 5, "not finite"},
               {"x + sqrt(-1)", 4, "not finite"},
               {"x + log(0)", 4, "not finite"},
               {"1 + 2", 0, "the function is constant"},
               {"x^0", 0, "the function is constant"},
               {"x^65", 1, "the exponent is too large"},
               {deep, 200, "nested too deeply"},
               {longest, 0, "too long"}};
  for (const auto& c : cases) {
    try {
      const Expression f{c.text};
      ADD_FAILURE() << c.text;
    } catch (const ExpressionError& e) {
      EXPECT_NE(e.message.find(c.message), std::string::npos) << c.text << ": " << e.message;
      if (c.text != longest) {
        EXPECT_EQ(e.offset, c.offset) << c.text << ": " << e.message;
      }
    }
  }
}

TEST(Expression, AnyTextIsReadOrExplained) {
  // Random pieces of expressions: every text either has an error at a position in it, or a value.
  Random random(64);
  const char* const pieces[] = {"x", "y", "z", "pi", "2", ".5", "1e3", "+",    "-",    "*",    "/",    "^",
                                "(", ")", ",", " ",  "(", ")",  "x",   "min(", "abs(", "sin(", "log(", "#"};
  size_t read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (int k = static_cast<int>(random.uniform(1, 12)); k > 0; --k)
      text += pieces[static_cast<size_t>(random.uniform(0, std::size(pieces)))];
    try {
      const Expression f{text};
      const double value = f.value(Vec3d(.3, .4, .5));
      const std::array box{Interval(.3), Interval(.4), Interval(.5)};
      const Interval bounds = f.value(box);
      EXPECT_TRUE(bounds.contains(value) || bounds.isPartial || !std::isfinite(value)) << text;
      ++read;
    } catch (const ExpressionError& e) {
      EXPECT_LE(e.offset, text.size()) << text;
      EXPECT_FALSE(e.message.empty()) << text;
    }
  }
  EXPECT_GT(read, 300u);
}

TEST(Implicit, MatchesAnalyticShapes) {
  expectSameSolid(*implicit("x^2 + y^2 + z^2 - .81"), *make("sphere", "\"float radius\" .9"), 53);
  // A sphere that touches the box, which is a solid without caps.
  expectSameSolid(*implicit("sqrt(x^2 + y^2 + z^2) - 1"), *make("sphere", ""), 54);
  expectSameSolid(*implicit("(sqrt(x^2 + y^2) - .7)^2 + z^2 - .04"),
                  *make("torus", "\"float majorradius\" .7 \"float minorradius\" .2"), 55);
  expectSameSolid(*implicit("abs(z - .1) - .3", "\"bool caps\" true"),
                  *make("box", "\"point3 p1\" [-1 -1 -.2] \"point3 p2\" [1 1 .4]"), 56);
  expectSameSolid(*implicit("max(abs(x) - .5, abs(y) - .4, abs(z) - .3)"),
                  *make("box", "\"point3 p1\" [-.5 -.4 -.3] \"point3 p2\" [.5 .4 .3]"), 57);
  // Two separate slabs: four crossings of a line.
  const auto slabs = implicit("(z^2 - .25)^2 - .01", "\"bool caps\" true");
  const auto found = sortedCrossings(*slabs->asSolid(), {.1, .2, -3}, {0, 0, 1});
  ASSERT_EQ(found.size(), 4u);
  const double expected[] = {3 - std::sqrt(.35), 3 - std::sqrt(.15), 3 + std::sqrt(.15), 3 + std::sqrt(.35)};
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(found[k].t, expected[k], 1e-14);
}

TEST(Implicit, ThinShellsAreNotMissed) {
  for (const double thickness : {1e-3, 1e-6, 1e-9}) {
    std::ostringstream text;
    text.precision(17);
    text << "(sqrt(x^2 + y^2 + z^2) - .8)^2 - " << square(thickness / 2);
    const auto shape = implicit(text.str());
    const auto solid = shape->asSolid();
    Random random(58);
    for (int i = 0; i < 500; ++i) {
      const Vec3d d = random.direction(), o = random.direction() * .3 - d * 3.0;
      const auto found = sortedCrossings(*solid, o, d);
      ASSERT_EQ(found.size(), 4u) << thickness;
      const double cosine = std::sqrt(1 - square(glm::length(glm::cross(o, d)) / .8));
      EXPECT_NEAR((found[1].t - found[0].t) * cosine, thickness, 1e-2 * thickness + 2e-15) << thickness;
      const auto hit = shape->intersect(0, Vec3f(o), Vec3f(d), 0, INFINITE);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(double(hit->t), found[0].t, 1e-6);
    }
  }
}

TEST(Implicit, RandomPolynomialsAgainstBruteForce) {
  Random random(59);
  size_t crossed = 0;
  for (int scene = 0; scene < 40; ++scene) {
    struct Term {
      double factor;
      int x, y, z;
    };
    std::vector<Term> terms;
    std::ostringstream text;
    text.precision(17);
    text << random.uniform(-.3, .3);
    for (int i = 0; i < 8; ++i) {
      const auto exponent = [&] { return static_cast<int>(random.uniform(0, 4)); };
      terms.push_back({random.uniform(-2, 2), exponent(), exponent(), exponent()});
      const Term& t = terms.back();
      text << " + (" << t.factor << ")*x^" << t.x << "*y^" << t.y << "*z^" << t.z;
    }
    const double constant = std::stod(text.str());
    const auto inside = [&](const Vec3d& p) {
      long double sum = constant;
      for (const Term& t : terms)
        sum += t.factor * std::pow(static_cast<long double>(p.x), t.x) *
               std::pow(static_cast<long double>(p.y), t.y) * std::pow(static_cast<long double>(p.z), t.z);
      return sum < 0;
    };
    const auto shape = implicit(text.str(), "\"bool caps\" true");
    const auto solid = shape->asSolid();
    for (int i = 0; i < 40; ++i) {
      const Vec3d o = random.direction() * 3.0, d = glm::normalize(random.direction() * .9 - o);
      const auto found = sortedCrossings(*solid, o, d);
      crossed += found.size();
      // At each of many points, the crossings decide whether it is inside.
      size_t next = 0;
      bool state = false;
      constexpr int POINTS = 2000;
      for (int k = 0; k < POINTS; ++k) {
        const double t = 6.0 * k / POINTS;
        while (next < found.size() && found[next].t < t) {
          state = found[next].entering;
          ++next;
        }
        const Vec3d p = o + d * t;
        const bool inBox = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 1;
        const double gap =
            std::min(next > 0 ? t - found[next - 1].t : 1, next < found.size() ? found[next].t - t : 1);
        if (gap > 1e-9) {
          EXPECT_EQ(state, inBox && inside(p)) << text.str();
        }
      }
      // Between adjacent crossings the state is constant, at any distance between them.
      for (size_t k = 0; k + 1 < found.size(); ++k) {
        EXPECT_NE(found[k].entering, found[k + 1].entering);
        if (found[k + 1].t - found[k].t > 1e-8) {
          EXPECT_EQ(inside(o + d * (.5 * (found[k].t + found[k + 1].t))), found[k].entering);
        }
      }
    }
  }
  EXPECT_GT(crossed, 2000u);
}

TEST(Implicit, IsAnOperandOfCsg) {
  TestObjects objects;
  objects.list = {{"level set", "implicit", "\"string function\" \"x^2 + y^2 + (z - .3)^2 - .49\""},
                  {"gyroid", "implicit",
                   "\"string function\" \"sin(4*x)*cos(4*y) + sin(4*y)*cos(4*z) + sin(4*z)*cos(4*x)\" "
                   "\"bool caps\" true"},
                  {"inverse gyroid", "implicit",
                   "\"string function\" \"-(sin(4*x)*cos(4*y) + sin(4*y)*cos(4*z) + sin(4*z)*cos(4*x))\" "
                   "\"bool caps\" true"},
                  {"cube", "box", ""},
                  {"ball", "sphere", "\"float radius\" .8"},
                  {"open", "implicit", "\"string function\" \"z\""}};
  ShapeContext context;
  context.shapes = &objects;
  const auto csg = [&](const std::string& operation, const std::string& names) {
    return make("csg", "\"string operation\" \"" + operation + "\" \"string operands\" [" + names + "]",
                context);
  };
  const auto volume = [](const Shape& shape) {
    const auto solid = shape.asSolid();
    constexpr int GRID = 300;
    constexpr double STEP = 2.4 / GRID;
    double length = 0;
    for (int i = 0; i < GRID; ++i)
      for (int k = 0; k < GRID; ++k)
        for (const Solid::Crossing& c :
             sortedCrossings(*solid, {(i + .5) * STEP - 1.2, (k + .5) * STEP - 1.2, -3}, {0, 0, 1}))
          length += c.entering ? -c.t : c.t;
    return length * STEP * STEP;
  };
  // Lens of two balls with radii a and b at a distance of d.
  const double a = .8, b = .7, d = .3;
  const double lens =
      PI_DOUBLE * square(a + b - d) * (d * d + 2 * d * (a + b) - 3 * square(a - b)) / (12 * d);
  EXPECT_NEAR(volume(*csg("intersection", "\"level set\" \"ball\"")), lens, 2e-3);
  EXPECT_NEAR(volume(*csg("difference", "\"ball\" \"level set\"")), 4 / 3.0 * PI_DOUBLE * a * a * a - lens,
              2e-3);
  // The gyroid and its inverse have the same surface and fill the cube together.
  const auto all = csg("union", "\"gyroid\" \"inverse gyroid\"");
  expectSameSolid(*all, *make("box", ""), 60);
  EXPECT_NEAR(
      volume(*csg("difference", "\"cube\" \"gyroid\"")),
      volume(*implicit("-(sin(4*x)*cos(4*y) + sin(4*y)*cos(4*z) + sin(4*z)*cos(4*x))", "\"bool caps\" true")),
      1e-6);

  Diagnostics diagnostics;
  const auto use = parseParameterText("csg", "\"string operands\" [\"ball\" \"open\"]");
  EXPECT_FALSE(plugIns().shapes.make(use, context, diagnostics));
  EXPECT_NE(diagnostics.format().find("\"bool caps\" true closes it"), std::string::npos)
      << diagnostics.format();
}

TEST(Implicit, IsOpenWhereItReachesTheBox) {
  const struct {
    const char *function, *rest;
    bool isOpen;
  } cases[] = {{"z", "", true},
               {"z", "\"bool caps\" true", false},
               {"x^2 + y^2 + z^2 - 1", "", false}, // touches the faces
               {"x^2 + y^2 + z^2 - 1.001", "", true},
               {"x^2 + y^2 + z^2 - 1", "\"point3 p2\" [1 1 .999]", true},
               {"1 - 1000*((x - 1)^2 + (y - .3)^2 + (z - .41)^2)", "", true},  // outside of a ball
               {"1000*((x - 1)^2 + (y - .3)^2 + (z - .41)^2) - 1", "", true}}; // a small ball in a face
  for (const auto& c : cases) {
    const auto shape = implicit(c.function, c.rest);
    EXPECT_EQ(shape->rim().empty(), !c.isOpen) << c.function << c.rest;
    if (c.isOpen)
      EXPECT_THROW(shape->asSolid(), Error) << c.function << c.rest;
    else
      EXPECT_TRUE(shape->asSolid()) << c.function << c.rest;
  }
}

TEST(Implicit, PolesAndEndsOfTheDomainAreBoundaries) {
  // The interior is x < 0 (pole), 0 <= x < .25 (domain of the root), and .2 < x < .5 (log).
  const struct {
    const char* function;
    double low, high;
  } cases[] = {
      {"1/x", -1, 0}, {"sqrt(x) - .5", 0, .25}, {"log(x - .2) - log(.3)", .2, .5}, {"x*sqrt(y - 5)", 0, 0}};
  for (const auto& c : cases) {
    const auto shape = implicit(c.function, "\"bool caps\" true");
    const auto found = sortedCrossings(*shape->asSolid(), {-3, .1, .2}, {1, 0, 0});
    if (c.low == c.high) {
      EXPECT_TRUE(found.empty());
      continue;
    }
    ASSERT_EQ(found.size(), 2u) << c.function;
    EXPECT_NEAR(found[0].t - 3, c.low, 1e-12) << c.function;
    EXPECT_NEAR(found[1].t - 3, c.high, 1e-12) << c.function;
    for (const Solid::Crossing& x : found) {
      const SurfacePoint p = shape->surfaceAt(0, x.parameters);
      EXPECT_NEAR(p.geometricNormal.x, x.entering ? -1 : 1, 1e-5) << c.function;
    }
  }
}

TEST(Implicit, FlatAndSteepFunctionsKeepTheirRoots) {
  // Roots have an infinite slope at 0; exponentials overflow in most of the ball.
  const struct {
    const char* function;
    Vec3d origin;
    double radius;
  } cases[] = {{"sqrt(max(x, 0)) + y^2 + z^2 - .3", {-.5, 0, -3}, std::sqrt(.3)},
               {"1 - exp(4000*(.25 - x^2 - y^2 - z^2))", {.2, .1, -3}, std::sqrt(.25 - .05)}};
  for (const auto& c : cases) {
    const auto found =
        sortedCrossings(*implicit(c.function, "\"bool caps\" true")->asSolid(), c.origin, {0, 0, 1});
    ASSERT_EQ(found.size(), 2u) << c.function;
    EXPECT_NEAR(found[0].t, 3 - c.radius, 1e-9) << c.function;
    EXPECT_NEAR(found[1].t, 3 + c.radius, 1e-9) << c.function;
  }
}

TEST(Implicit, FunctionsThatVanishOnAPieceOfTheRayTakeLimitedTime) {
  // Zero everywhere up to rounding; zero on a plane that contains the rays; zero beyond a point.
  for (const char* function : {"sin(x)^2 + cos(x)^2 - 1", "z*(2 + x)", "max(x, 0)",
                               "(x + y)^2 - x^2 - 2*x*y - y^2", "x^63*y^63*z^63"}) {
    const auto shape = implicit(function);
    const std::clock_t start = std::clock();
    for (int i = 0; i < 20; ++i)
      shape->intersect(0, {-3, .01f * static_cast<float>(i), 0}, {1, 0, 0}, 0, INFINITE);
    // Twenty rays of 2^14 steps take a tenth of a second; full precision would take hours.
    EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, SANITIZED ? 60 : 5) << function;
  }
}

TEST(Implicit, BadParametersAreExplained) {
  const auto complaint = [](const std::string& parameters) {
    Diagnostics diagnostics;
    EXPECT_FALSE(plugIns().shapes.make(parseParameterText("implicit", parameters), {}, diagnostics));
    return diagnostics.format();
  };
  const auto has = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << text;
  };
  has(complaint(""), "function");
  has(complaint("\"string function\" \"x\" \"point3 p2\" [1 -1 1]"), "the box is flat");
  // The caret is at the character, also after an escaped one.
  const std::string message = complaint("\"string function\" [\"x +\\ty + w\"]");
  has(message, "\"w\" is neither a variable nor a function");
  has(message, "\n    \"string function\" [\"x +\\ty + w\"]\n");
  has(message, "\n                                 ^\n");
}
