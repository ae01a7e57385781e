/** @file
 * Metaballs against interval arithmetic.
 */
#include <ctime>

#include "model/shapeTesting.h"
#include "recurse/model/shape/ballField.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

struct Ball {
  Vec3d center;
  double radius, strength;
};

struct Interval {
  double low, high;
};

/** Field along a line, and its bounds over a part of the line. */
struct Field {
  std::vector<Ball> balls;
  double threshold = 0.5;
  std::string kind;

  /** Field of a ball by the squared distance in radii. */
  double fall(double q) const {
    if (q >= 1) return 0;
    if (kind == "wyvill") return 1 - 22 / 9.0 * q + 17 / 9.0 * q * q - 4 / 9.0 * q * q * q;
    if (kind == "blinn") return std::pow(1 - q, 4) + square((1 - q) * q);
    if (kind == "sextic") return std::pow(1 - q, 3);
    return square(1 - q);
  }

  double at(const Vec3d& p) const {
    double f = -threshold;
    for (const Ball& b : balls) {
      const double q = glm::dot(p - b.center, p - b.center) / square(b.radius);
      f += b.strength * fall(q);
    }
    return f;
  }
  Interval over(const Vec3d& o, const Vec3d& d, double t0, double t1) const {
    Interval f{-threshold, -threshold};
    for (const Ball& b : balls) {
      const double middle = glm::dot(b.center - o, d);
      const auto q = [&](double t) {
        const Vec3d away = o + d * t - b.center;
        return glm::dot(away, away) / square(b.radius);
      };
      const double qHigh = std::max(q(t0), q(t1)), qLow = q(std::clamp(middle, t0, t1));
      const double low = b.strength * fall(qHigh), high = b.strength * fall(qLow);
      f.low += std::min(low, high);
      f.high += std::max(low, high);
    }
    return f;
  }
  /** Roots by bisection of all intervals that may contain one, down to `resolution`. */
  void roots(const Vec3d& o, const Vec3d& d, double t0, double t1, double resolution,
             std::vector<double>& found) const {
    const Interval f = over(o, d, t0, t1);
    if (f.low > 0 || f.high < 0) return;
    const double middle = 0.5 * (t0 + t1);
    if (t1 - t0 < resolution) {
      if ((at(o + d * t0) < 0) != (at(o + d * t1) < 0)) found.push_back(middle);
      return;
    }
    roots(o, d, t0, middle, resolution, found);
    roots(o, d, middle, t1, resolution, found);
  }
};

} // namespace

TEST(Metaballs, BlinnFieldDiffersFromTheExponentialByUpTo0Point0201) {
  double largest = 0;
  for (double q = 0; q <= 1; q += 1e-5)
    largest = std::max(largest, std::abs(blinnField(q) - std::exp(-4 * q)));
  EXPECT_NEAR(largest, 0.0201, 5e-5);
}

TEST(Metaballs, AreMetWhereIntervalArithmeticFindsThem) {
  Random random(31);
  size_t rays = 0, crossed = 0, disagreed = 0;
  for (int scene = 0; scene < 40; ++scene) {
    Field field;
    const char* const kinds[] = {"quartic", "wyvill", "sextic", "blinn"};
    field.kind = kinds[scene % 4];
    std::string p, radius, strength;
    const int count = 1 + scene % 8;
    for (int i = 0; i < count; ++i) {
      const Ball b{random.direction() * random.uniform(0, 0.8), random.uniform(0.3, 1),
                   random.uniform() < 0.8 || i == 0 ? random.uniform(0.6, 1.5) : random.uniform(-1, 0)};
      field.balls.push_back(b);
      std::ostringstream number;
      number.precision(17);
      number << b.center.x << " " << b.center.y << " " << b.center.z << " ";
      p += number.str();
      number.str("");
      number << b.radius << " ";
      radius += number.str();
      number.str("");
      number << b.strength << " ";
      strength += number.str();
    }
    const auto shape =
        make("metaballs", "\"point3 P\" [" + p + "] \"float radius\" [" + radius + "] \"float strength\" [" +
                              strength + "] \"string field\" \"" + field.kind + "\"");
    const auto solid = shape->asSolid();
    for (int i = 0; i < 500; ++i) {
      const Vec3d o = random.direction() * 3.0;
      const Vec3d d = glm::normalize(random.direction() * random.uniform(0, 1.2) - o);
      std::vector<Solid::Crossing> found;
      solid->crossings(o, d, found);
      std::vector<double> expected;
      constexpr double RESOLUTION = 1e-9;
      field.roots(o, d, 0, 6, RESOLUTION, expected);
      ++rays;
      crossed += !expected.empty();
      if (found.size() != expected.size()) {
        ++disagreed; // two roots in one step of the search, or grazing by rounding
        continue;
      }
      for (size_t k = 0; k < found.size(); ++k) {
        EXPECT_NEAR(found[k].t, expected[k], 2 * RESOLUTION);
        EXPECT_EQ(found[k].entering, k % 2 == 0);
      }
    }
  }
  EXPECT_GT(crossed, rays / 4);
  EXPECT_EQ(disagreed, 0u);
}

TEST(Metaballs, ThinNecksAreNotLost) {
  // Two balls whose sum of fields is slightly above the threshold in the middle: rays through the neck hit
  // it.
  const double reach = std::sqrt(1 - std::sqrt(0.25)); // where one field is 1/4
  for (const double closer : {1e-3, 1e-5, 1e-7, 1e-9}) {
    std::ostringstream text;
    text.precision(17);
    const double x = reach * (1 - closer);
    text << "\"point3 P\" [" << -x << " 0 0 " << x << " 0 0]";
    const auto shape = make("metaballs", text.str());
    const auto solid = shape->asSolid();
    Random random(32);
    for (int i = 0; i < 1000; ++i) {
      Vec3d d = random.direction();
      d.x *= 1e-3;
      d = glm::normalize(d);
      std::vector<Solid::Crossing> found;
      solid->crossings(d * -2.0, d, found);
      ASSERT_EQ(found.size(), 2u) << closer;
      EXPECT_LT(found[0].t, 2) << closer;
      EXPECT_GT(found[1].t, 2) << closer;
    }
  }
}

TEST(Metaballs, RaysFindTheNearestInAnyCloud) {
  // The renderer traces rays in segments: the result is the same as for the whole line.
  Random random(33);
  std::ostringstream text;
  text << "\"float radius\" .08 \"point3 P\" [";
  for (int i = 0; i < 3000; ++i) {
    const Vec3d p = random.direction() * std::cbrt(random.uniform());
    text << p.x << " " << p.y << " " << p.z << " ";
  }
  const auto shape = make("metaballs", text.str() + "]");
  const auto solid = shape->asSolid();
  int met = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3f o(random.direction() * random.uniform(0, 2)), d(random.direction());
    std::vector<Solid::Crossing> found;
    solid->crossings(o, d, found);
    std::erase_if(found, [](const Solid::Crossing& c) { return !(static_cast<float>(c.t) > 0); });
    const auto hit = shape->intersect(0, o, d, 0, INFINITE);
    ASSERT_EQ(hit.has_value(), !found.empty());
    if (!hit) continue;
    ++met;
    EXPECT_NEAR(double(hit->t), found[0].t, 1e-6);
  }
  EXPECT_GT(met, 1000);
}

TEST(Metaballs, TimeGrowsNoFasterThanTheirNumber) {
  // Time of rays through clouds in which each ball reaches half of all balls.
  const auto secondsFor = [](int count) {
    Random random(34);
    std::ostringstream text;
    text << "\"point3 P\" [";
    for (int i = 0; i < count; ++i) {
      const Vec3d p = random.direction() * std::cbrt(random.uniform());
      text << p.x << " " << p.y << " " << p.z << " ";
    }
    const auto shape = make("metaballs", text.str() + "]");
    const auto now = [] {
      timespec t{};
      ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
      return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double start = now();
    for (int i = 0; i < 20; ++i) {
      const Vec3d to = random.direction() * 0.5, d = random.direction();
      EXPECT_TRUE(shape->intersect(0, Vec3f(to - 3.0 * d), Vec3f(d), 0, INFINITE));
    }
    return now() - start;
  };
  secondsFor(250); // the first call loads the code
  const auto fastest = [&](int count) {
    return std::min({secondsFor(count), secondsFor(count), secondsFor(count)});
  };
  EXPECT_LT(fastest(8000) / fastest(250), 32 * 4);
}
