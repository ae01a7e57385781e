/** @file
 * Solids: lines enter and leave alternately, volumes agree with closed forms, rays that leave a surface do
 * not hit it again; and constructive solid geometry.
 */
#include "model/shapeTesting.h"
#include "recurse/core/threads/parallel.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::unique_ptr<Solid> solidOf(const Shape& shape) {
  try {
    return shape.asSolid();
  } catch (const Error&) {
    return nullptr;
  }
}

std::vector<Solid::Crossing> crossingsOf(const Solid& solid, const Vec3d& origin, const Vec3d& direction) {
  std::vector<Solid::Crossing> found;
  solid.crossings(origin, direction, found);
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return found;
}

/** Volume by parallel lines through a grid of the bounds. */
double volumeByLines(const Shape& shape) {
  const auto solid = shape.asSolid();
  const Bounds3f box = shape.bounds();
  const Vec3d center = box.center();
  const double radius = 0.5 * glm::length(Vec3d(box.diagonal()));
  const Vec3d d = glm::normalize(Vec3d(0.31, 0.22, 0.93));
  const Frame frame{Vec3f(d)};
  constexpr int LINES = 400;
  const double step = 2 * radius / LINES;
  double length = 0;
  for (int i = 0; i < LINES; ++i)
    for (int k = 0; k < LINES; ++k) {
      const Vec3d o = center + Vec3d(frame.x) * ((i + 0.5) * step - radius) +
                      Vec3d(frame.y) * ((k + 0.5) * step - radius);
      for (const Solid::Crossing& c : crossingsOf(*solid, o, d)) length += c.entering ? -c.t : c.t;
    }
  return length * step * step;
}

/** Operands for the csg shapes of one test. */
struct Operands : TestObjects {
  explicit Operands(std::vector<std::array<std::string, 3>> objects) { list = std::move(objects); }
  std::unique_ptr<Shape> csg(const std::string& operation, const std::string& names,
                             const Mat4d& transform = Mat4d(1)) {
    ShapeContext context{transform};
    context.shapes = this;
    return make("csg", "\"string operation\" \"" + operation + "\" \"string operands\" [" + names + "]",
                context);
  }
};

std::string csgOf(const std::string& operation, const std::string& names) {
  return "\"string operation\" \"" + operation + "\" \"string operands\" [" + names + "]";
}

constexpr const char* CUBE_MESH =
    "\"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1] \"integer indices\" "
    "[0 2 1 1 2 3  4 5 6 5 7 6  0 1 4 1 5 4  2 6 3 3 6 7  0 4 2 2 4 6  1 3 5 3 7 5]";

} // namespace

TEST(Solid, LinesGoInAndOutByTurns) {
  Random random(21);
  size_t solids = 0;
  for (const Specimen& s : specimens()) {
    const auto solid = solidOf(*s.shape);
    if (!solid) continue;
    ++solids;
    size_t found = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto [origin, direction] = randomLine(random, s);
      const auto crossings = crossingsOf(*solid, origin, direction);
      EXPECT_EQ(crossings.size() % 2, 0u) << s.name;
      // Intersections of the line agree with the rays of the renderer.
      const auto meetings = allMeetings(*s.shape, origin, direction);
      ASSERT_EQ(crossings.size(), meetings.size()) << s.name;
      for (size_t k = 0; k < crossings.size(); ++k) {
        const Solid::Crossing& c = crossings[k];
        EXPECT_EQ(c.entering, k % 2 == 0) << s.name;
        EXPECT_NEAR(c.t, meetings[k].t, 1e-6 * c.t) << s.name;
        const SurfacePoint p = s.shape->surfaceAt(c.primitive, c.parameters);
        const float cosine = glm::dot(p.geometricNormal, direction);
        // Vertex normals may reverse a mesh's normal.
        if (std::abs(cosine) > 1e-3f && p.shadingNormal == p.geometricNormal) {
          EXPECT_EQ(cosine < 0, c.entering != solid->normalsPointIn()) << s.name << " " << cosine;
        }
        ++found;
      }
    }
    EXPECT_GT(found, 100u) << s.name;
  }
  EXPECT_GT(solids, 30u);
}

TEST(Solid, VolumesAreThoseOfClosedForms) {
  const struct {
    const char *name, *parameters;
    double volume;
  } cases[] = {
      {"sphere", "\"float radius\" 0.7", 4 / 3.0 * PI_DOUBLE * 0.343},
      {"cylinder", "\"float radius\" 0.5 \"float zmin\" -1 \"float zmax\" 2 \"bool caps\" true",
       PI_DOUBLE * 0.25 * 3},
      {"cone", "\"float radius\" 0.5 \"float height\" 3 \"bool caps\" true", PI_DOUBLE * 0.25},
      {"paraboloid", "\"float radius\" 1 \"float zmax\" 2 \"bool caps\" true", PI_DOUBLE},
      // Through (1, t, t), t from -1 to 1, the squared radius is 1 + t².
      {"hyperboloid", "\"point3 p1\" [1 -1 -1] \"point3 p2\" [1 1 1] \"bool caps\" true",
       PI_DOUBLE * (2 + 2 / 3.0)},
      {"torus", "\"float majorradius\" 1 \"float minorradius\" 0.4", 2 * PI_DOUBLE * PI_DOUBLE * 0.16},
      {"box", "\"point3 p1\" [1 2 3] \"point3 p2\" [2 0 3.5]", 1},
      {"trianglemesh", CUBE_MESH, 1}};
  for (const auto& c : cases) {
    const auto shape = make(c.name, c.parameters);
    EXPECT_NEAR(volumeByLines(*shape), c.volume, 2e-3 * c.volume) << c.name;
  }
}

TEST(Solid, LeftOnTheRightSide) {
  // A ray to the outside intersects the surface an even number of times, a ray to the inside an odd number.
  setThreadFloatMode();
  Random random(22);
  for (const auto& entry : plugIns().shapes.entries())
    for (const std::string& example : entry.examples) {
      int wrong = 0, rays = 0;
      for (const double distance : {0.0, 1.0, 1e2})
        for (const double ratio : {1.0, 10.0})
          for (int k = 0; k < 15; ++k) {
            Specimen s{"", make(entry.name, example, {randomTransform(random, ratio, distance), false})};
            if (s.shape->triangleMesh() || !solidOf(*s.shape)) continue;
            for (int i = 0; i < 50; ++i) {
              const auto [origin, direction] = randomLine(random, s);
              for (const Meeting& m : allMeetings(*s.shape, origin, direction)) {
                const SurfacePoint p = s.shape->surfaceAt(m.primitive, m.parameters);
                const Vec3f away = randomLeaving(random, p.geometricNormal);
                const size_t met = allMeetings(*s.shape, p.rayOrigin(away), away).size();
                wrong += (met % 2 == 0) != (glm::dot(away, p.geometricNormal) >= 0);
                ++rays;
              }
            }
          }
      EXPECT_EQ(wrong, 0) << entry.name << " " << example << " of " << rays;
    }
}

TEST(Csg, VolumesAreThoseOfClosedForms) {
  Operands o(
      {{"left", "sphere", ""},
       {"along x", "cylinder", "\"float radius\" 1 \"float zmin\" -2 \"float zmax\" 2 \"bool caps\" true"},
       {"drill", "cylinder", "\"float radius\" .6 \"float zmin\" -2 \"float zmax\" 2 \"bool caps\" true"},
       {"block", "box", "\"point3 p1\" [-2 -2 0] \"point3 p2\" [2 2 2]"},
       {"mesh", "trianglemesh", CUBE_MESH}});
  // A sphere with a hole along its axis has the volume of a sphere of the hole's height.
  EXPECT_NEAR(volumeByLines(*o.csg("difference", "\"left\" \"drill\"")), 4 / 3.0 * PI_DOUBLE * 0.512, 3e-3);
  EXPECT_NEAR(volumeByLines(*o.csg("intersection", "\"left\" \"block\"")), 2 / 3.0 * PI_DOUBLE, 4e-3);
  EXPECT_NEAR(volumeByLines(*o.csg("union", "\"left\" \"block\"")), 32 + 2 / 3.0 * PI_DOUBLE, 7e-2);
  // The sphere contains one corner of the mesh: an octant.
  EXPECT_NEAR(volumeByLines(*o.csg("intersection", "\"mesh\" \"left\"")), PI_DOUBLE / 6, 2e-3);
}

namespace {

/** Operands with a transform before each object. */
struct PlacedOperands : TestObjects {
  struct Placed {
    std::string name, plugIn, parameters;
    Mat4d transform{1};
  };
  std::vector<Placed> placed;
  std::vector<ComponentShape> object(const Parameters& p, const std::string&, const std::string& name,
                                     const ShapeContext& context) override {
    std::vector<ComponentShape> made;
    for (const Placed& o : placed)
      if (o.name == name) {
        ShapeContext inner = context;
        inner.sceneFromObject = context.sceneFromObject * o.transform;
        made.push_back({make(o.plugIn, o.parameters, inner), nullptr, p.location()});
      }
    return made;
  }
  std::unique_ptr<Shape> csg(const std::string& operation, const std::string& names,
                             const Mat4d& transform = Mat4d(1)) {
    ShapeContext context{transform};
    context.shapes = this;
    return make("csg", csgOf(operation, names), context);
  }
};

} // namespace

TEST(Csg, SteinmetzSolidAndLens) {
  PlacedOperands o;
  Mat4d toX(0);
  toX[0][2] = toX[1][0] = toX[2][1] = toX[3][3] = 1; // maps x to z, y to x and z to y
  const char* rod = "\"float zmin\" -2 \"float zmax\" 2 \"bool caps\" true";
  o.placed = {{"a", "cylinder", rod},
              {"b", "cylinder", rod, toX},
              {"left", "sphere", ""},
              {"right", "sphere", "", affine(Mat3d(1), {1, 0, 0})}};
  EXPECT_NEAR(volumeByLines(*o.csg("intersection", "\"a\" \"b\"")), 16 / 3.0, 1e-2);
  // Two unit spheres at distance d: π (2 - d)² (d² + 4 d) / (12 d)
  EXPECT_NEAR(volumeByLines(*o.csg("intersection", "\"left\" \"right\"")), PI_DOUBLE * 5 / 12, 3e-3);
  // An affine transform multiplies the volume by its determinant.
  const Mat4d m = affine(diagonal(2, -0.5, 3), {4, 5, 6});
  EXPECT_NEAR(volumeByLines(*o.csg("intersection", "\"left\" \"right\"", m)), 3 * PI_DOUBLE * 5 / 12, 1e-2);
}

TEST(Csg, IdentitiesOfSets) {
  PlacedOperands o;
  const Mat4d moved = affine(Mat3d(1), {0.4, 0.3, 0.2});
  o.placed = {{"a", "sphere", ""},
              {"b", "torus", "", moved},
              {"c", "box", "", affine(diagonal(0.6, 0.7, 0.5), {-0.2, 0.1, 0})},
              {"b and c", "csg", csgOf("union", "\"b\" \"c\"")},
              {"a without b", "csg", csgOf("difference", "\"a\" \"b\"")},
              {"a without c", "csg", csgOf("difference", "\"a\" \"c\"")},
              {"a with b", "csg", csgOf("intersection", "\"a\" \"b\"")},
              {"all", "sphere", "\"float radius\" 50"},
              {"not b", "csg", csgOf("difference", "\"all\" \"b\"")}};
  const std::array<std::pair<std::unique_ptr<Shape>, std::unique_ptr<Shape>>, 6> same = {
      {{o.csg("union", "\"a\" \"b\""), o.csg("union", "\"b\" \"a\"")},
       {o.csg("intersection", "\"a\" \"b\" \"c\""), o.csg("intersection", "\"c\" \"a\" \"b\"")},
       {o.csg("difference", "\"a\" \"b and c\""), o.csg("difference", "\"a without b\" \"c\"")},
       {o.csg("difference", "\"a\" \"b\" \"c\""), o.csg("intersection", "\"a without b\" \"a without c\"")},
       {o.csg("difference", "\"a\" \"b\""), o.csg("difference", "\"a\" \"a with b\"")},
       {o.csg("difference", "\"a\" \"b\""), o.csg("intersection", "\"a\" \"not b\"")}}};
  Random random(23);
  for (size_t k = 0; k < same.size(); ++k) {
    const auto one = same[k].first->asSolid(), other = same[k].second->asSolid();
    int crossed = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3d origin = random.direction() * 4.0, target = random.direction() * random.uniform(0, 1.5);
      const Vec3d direction = glm::normalize(target - origin);
      const auto x = crossingsOf(*one, origin, direction), y = crossingsOf(*other, origin, direction);
      ASSERT_EQ(x.size(), y.size()) << k;
      for (size_t n = 0; n < x.size(); ++n) {
        EXPECT_EQ(x[n].t, y[n].t) << k;
        EXPECT_EQ(x[n].entering, y[n].entering) << k;
      }
      crossed += !x.empty();
    }
    EXPECT_GT(crossed, 1000) << k;
  }
}

TEST(Csg, FacesThatCoincideLeaveNoSkin) {
  Operands o({{"block", "box", ""},
              {"same", "box", ""},
              {"half", "box", "\"point3 p1\" [-1 -1 -1] \"point3 p2\" [1 1 0]"},
              {"rest", "box", "\"point3 p1\" [-1 -1 0] \"point3 p2\" [1 1 1]"}});
  Random random(24);
  for (int k = 0; k < 20; ++k) {
    const Mat4d m = randomTransform(random, 3, 1);
    const auto nothing = o.csg("difference", "\"block\" \"same\"", m),
               empty = o.csg("intersection", "\"half\" \"rest\"", m),
               whole = o.csg("union", "\"half\" \"rest\"", m),
               half = o.csg("difference", "\"block\" \"rest\"", m);
    const Mat3d linear(m);
    for (int i = 0; i < 2000; ++i) {
      const Vec3d origin = Vec3d(m[3]) + linear * (random.direction() * 5.0);
      const Vec3d target = Vec3d(m[3]) + linear * (random.direction() * 0.9);
      const Vec3d d = glm::normalize(target - origin);
      EXPECT_TRUE(crossingsOf(*nothing->asSolid(), origin, d).empty());
      EXPECT_TRUE(crossingsOf(*empty->asSolid(), origin, d).empty());
      EXPECT_EQ(crossingsOf(*whole->asSolid(), origin, d).size(), 2u);
      EXPECT_LE(crossingsOf(*half->asSolid(), origin, d).size(), 2u);
    }
  }
}

TEST(Csg, MeshesAndBoxesMakeTheSameSolid) {
  Operands o({{"cube mesh", "trianglemesh", CUBE_MESH},
              {"cube", "box", "\"point3 p1\" [0 0 0] \"point3 p2\" [1 1 1]"},
              {"ball", "sphere", ""}});
  const auto mesh = o.csg("difference", "\"cube mesh\" \"ball\""),
             box = o.csg("difference", "\"cube\" \"ball\"");
  const auto meshSolid = mesh->asSolid(), boxSolid = box->asSolid();
  Random random(25);
  int crossed = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3d origin = random.direction() * 4.0;
    const Vec3d d = glm::normalize(Vec3d(random.uniform(), random.uniform(), random.uniform()) - origin);
    const auto x = crossingsOf(*meshSolid, origin, d), y = crossingsOf(*boxSolid, origin, d);
    ASSERT_EQ(x.size(), y.size());
    for (size_t n = 0; n < x.size(); ++n) EXPECT_NEAR(x[n].t, y[n].t, 1e-12);
    crossed += !x.empty();
  }
  EXPECT_GT(crossed, 10000);
}

TEST(Csg, SolidsWithoutSizeHaveAnEnd) {
  // All positions of the mesh round to the same point.
  Operands o({{"point", "trianglemesh", CUBE_MESH}});
  const Mat4d m = affine(diagonal(1e-30, 1e-30, 1e-30), {1, 1, 1});
  for (const char* operation : {"union", "intersection", "difference"}) {
    const auto csg = o.csg(operation, "\"point\" \"point\"", m);
    EXPECT_FALSE(csg->intersect(0, {1, 1, 0}, {0, 0, 1}, 0, INFINITE)) << operation;
    EXPECT_FALSE(csg->intersect(0, {1, 1, 0}, {0, 0, 1}, 0, 10)) << operation;
  }
}

TEST(Csg, AreasAreThoseOfClosedForms) {
  Operands o(
      {{"ball", "sphere", ""},
       {"half space", "box", "\"point3 p1\" [-2 -2 0] \"point3 p2\" [2 2 2]"},
       {"drill", "cylinder", "\"float radius\" .6 \"float zmin\" -2 \"float zmax\" 2 \"bool caps\" true"},
       {"half ball", "csg", csgOf("intersection", "\"ball\" \"half space\"")}});
  const auto expectArea = [](const Shape& shape, double area) {
    EXPECT_NEAR(double(shape.area()), area, 0.01 * area);
  };
  expectArea(*o.csg("intersection", "\"ball\" \"half space\""), 3 * PI_DOUBLE);
  expectArea(*o.csg("difference", "\"ball\" \"half space\""), 3 * PI_DOUBLE);
  // The zone of the sphere with the height of the hole, 1.6, and the wall of the hole.
  expectArea(*o.csg("difference", "\"ball\" \"drill\""), 2 * PI_DOUBLE * 1.6 + 2 * PI_DOUBLE * .6 * 1.6);
  // A csg of a stretched csg: half of a spheroid with axes 1, 1, 2, and the disc.
  const double e = std::sqrt(1 - 1 / 4.0);
  expectArea(*o.csg("union", "\"half ball\" \"half ball\"", affine(diagonal(1, 1, 2), {0, 0, 0})),
             PI_DOUBLE * (1 + 2 / e * std::asin(e)) + PI_DOUBLE);
}

TEST(Csg, OpenShapesAreTurnedDown) {
  const auto complaint = [](const char* plugIn, const char* parameters) {
    Operands o({{"ball", "sphere", ""}, {"other", plugIn, parameters}});
    ShapeContext context;
    context.shapes = &o;
    Diagnostics diagnostics;
    const auto use = parseParameterText("csg", csgOf("union", "\"ball\" \"other\""));
    EXPECT_FALSE(plugIns().shapes.make(use, context, diagnostics));
    return diagnostics.format();
  };
  const auto expect = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  expect(complaint("cylinder", ""), "it is open: \"bool caps\" true closes it");
  expect(complaint("disk", ""), "it is not a closed surface");
  expect(complaint("sphere", "\"float zmin\" 0"), "only a part of a sphere");
  expect(complaint("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0]"),
         "the edge between positions 0 and 1 (triangle 0) belongs to one triangle only");
  // Two faces of a tetrahedron with opposite orientation.
  expect(complaint("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" "
                                   "[0 1 2  0 1 3  1 2 3  2 0 3]"),
         "with different orientations");
}
