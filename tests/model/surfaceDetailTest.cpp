/** @file
 * Bumps and normal maps against normals known in closed form, on every registered shape.
 */
#include <random>

#include "model/bsdfTesting.h"
#include "model/shapeTesting.h"
#include "model/textureTesting.h"
#include "recurse/model/bsdf/surfaceDetail.h"
#include "recurse/model/mesh/triangleMesh.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Calls test(name, point) for points on each example of each shape, under a transform with shear. */
template <class F> void atPointsOfShapes(const F& test) {
  Mat4d m(1);
  m[0] = Vec4d(.8, .3, .1, 0);
  m[1] = Vec4d(-.2, 1.3, .2, 0);
  m[3] = Vec4d(1, 2, 3, 1);
  for (const auto& entry : plugIns().shapes.entries())
    for (const std::string& example : entry.examples) {
      Diagnostics diagnostics;
      const auto shape = plugIns().shapes.make(parseParameterText(entry.name, example),
                                               {m, false, nullptr, testObjects()}, diagnostics);
      ASSERT_TRUE(shape) << diagnostics.format();
      if (!shape->canBeSampled()) continue;
      for (uint32_t i = 0; i < 200; ++i) {
        Sampler sampler(1, 2, i);
        const float pick = sampler.next1D();
        const ShapeSample sample = shape->sampleArea(pick, sampler.next2D());
        if (sample.pdf > 0) test(entry.name + " " + example, sample.point);
      }
    }
}

Vec3d tangential(const Vec3d& v, const Vec3d& n) { return v - n * glm::dot(v, n); }

} // namespace

TEST(Bumps, NormalsAreThoseOfTheRaisedSurface) {
  // The height is a linear function of space, so its gradient along every surface is known.
  const Vec3d slope(.1, -.2, .25);
  const auto height = makeTexture("bilerp",
                                  "\"string mapping\" \"planar\" \"vector3 v1\" [.1 -.2 .25] "
                                  "\"float v01\" 0 \"float v10\" 1",
                                  false);
  const auto detail = bumps({BLACK, height.get()});
  int compared = 0;
  atPointsOfShapes([&](const std::string& name, const SurfacePoint& p) {
    const Vec3d n = p.shadingNormal, u = tangential(p.dpdu, n), v = tangential(p.dpdv, n);
    const double lengths = glm::length(u) * glm::length(v);
    if (!(glm::length(glm::cross(u, v)) > .05 * lengths) || lengths < 1e-3) return; // beside a pole
    // Where the shading normal is not the surface's, differences along dpdu are not along its tangent.
    if (p.crossTangent != 0 || p.shadingNormal != p.geometricNormal) return;
    SurfacePoint bent = p;
    detail->apply(bent);
    const double h = glm::dot(slope, Vec3d(p.position));
    const auto raised = [&](const Vec3d& dp, const Vec3d& dn) {
      return dp + glm::dot(slope, dp) * n + h * dn;
    };
    Vec3d wanted = glm::normalize(glm::cross(raised(u, p.dndu), raised(v, p.dndv)));
    if (glm::dot(wanted, Vec3d(p.geometricNormal)) < 0) wanted = -wanted;
    EXPECT_LT(glm::length(Vec3d(bent.shadingNormal) - wanted), 4e-3) << name;
    EXPECT_NEAR(glm::length(bent.shadingNormal), 1, 1e-6);
    EXPECT_EQ(bent.position, p.position);
    EXPECT_EQ(bent.uv, p.uv);
    EXPECT_EQ(bent.geometricNormal, p.geometricNormal);
    // The width of a pixel sets the step, which has no effect if the slope is constant.
    bent = p;
    bent.footprint = {-p.geometricNormal, .01f};
    detail->apply(bent);
    EXPECT_LT(glm::length(Vec3d(bent.shadingNormal) - wanted), 4e-3) << name;
    ++compared;
  });
  EXPECT_GT(compared, 1500);
}

TEST(Bumps, OfASphereAreThoseOfTheSphereOfAnotherRadius) {
  // r(n) = R + h with h = a · position: the normal of a star-shaped surface is r n minus its gradient.
  const Vec3d a(.3, -.2, .25);
  const double radius = 2;
  const auto height = makeTexture("bilerp",
                                  "\"string mapping\" \"planar\" \"vector3 v1\" [.3 -.2 .25] "
                                  "\"float v01\" 0 \"float v10\" 1",
                                  false);
  const auto detail = bumps({BLACK, height.get()});
  for (const bool inside : {false, true}) {
    ShapeContext context;
    context.reverseOrientation = inside;
    const auto sphere = make("sphere", "\"float radius\" 2", context);
    for (uint32_t i = 0; i < 200; ++i) {
      Sampler sampler(1, 2, i);
      const float pick = sampler.next1D();
      SurfacePoint p = sphere->sampleArea(pick, sampler.next2D()).point;
      if (std::abs(p.position.z) > 1.9f) continue; // beside a pole
      const Vec3d outwards = glm::normalize(Vec3d(p.position));
      const double side = inside ? -1 : 1, raisedRadius = radius + side * glm::dot(a, Vec3d(p.position));
      const Vec3d wanted =
          glm::normalize(outwards * raisedRadius - tangential(side * a, outwards) * radius) * side;
      detail->apply(p);
      EXPECT_LT(glm::length(Vec3d(p.shadingNormal) - wanted), 2e-3);
    }
  }
}

TEST(Bumps, GoAcrossDpduOnMeshesWithNormals) {
  // Shading frame of a mesh with normals as in pbrt-v4, made of n and dpdu: v is along n x dpdu, with the
  // length of dpdu, regardless of the texture's stretch.
  const auto height = makeTexture("bilerp", "\"float v10\" .6 \"float v11\" 1 \"float v01\" .4", false);
  const auto detail = bumps({BLACK, height.get()}); // dh/du = .6, dh/dv = .4
  const std::string plane = "\"integer indices\" [0 1 2  0 2 3] \"point3 P\" [0 0 0  2 0 0  2 5 0  0 5 0] "
                            "\"point2 uv\" [0 0  1 0  1 1  0 1] ";
  const auto bent = [&](const std::string& parameters, const Mat4d& map) {
    const auto mesh = make("trianglemesh", parameters);
    SurfacePoint p = mesh->surfaceAt(0, HitParameters(Vec2f(.3f, .3f)));
    transformDirections(Mat3d(map), glm::transpose(glm::inverse(Mat3d(map))), p);
    detail->apply(p);
    return Vec3d(p.shadingNormal);
  };
  Mat4d mirrored(1);
  mirrored[1][1] = -1;
  const std::string normals = "\"normal N\" [0 0 1  0 0 1  0 0 1  0 0 1] ";
  const Vec3d flat = bent(plane, Mat4d(1)), smooth = bent(plane + normals, Mat4d(1)),
              seenInAMirror = bent(plane + normals, mirrored);
  EXPECT_LT(glm::length(flat - glm::normalize(Vec3d(-.6 / 2, -.4 / 5, 1))), 1e-4);
  EXPECT_LT(glm::length(smooth - glm::normalize(Vec3d(-.6 / 2, -.4 / 2, 1))), 1e-4);
  EXPECT_LT(glm::length(seenInAMirror - glm::normalize(Vec3d(-.6 / 2, .4 / 2, 1))), 1e-4);
}

TEST(Bumps, FollowTheCoordinatesOfTheSurface) {
  // The height is an image of a known function: a checkerboard has slopes at its edges only, and marble is
  // not a float.
  const Folder folder;
  constexpr int N = 64;
  const auto h = [](double u, double v) { return .1 * std::sin(2 * M_PI * u) * std::cos(2 * M_PI * v); };
  const std::string file = folder.picture(
      "h.exr", N, N, [&](int x, int y) { return Rgb(float(h((x + .5) / N, 1 - (y + .5) / N))); });
  const auto texture = makeTexture("imagemap", "\"string filename\" \"" + file + "\"", false);
  const auto detail = bumps({BLACK, texture.get()});
  for (const double flipped : {1., -1.}) // coordinates of either handedness
    for (int i = 0; i < 300; ++i) {
      Sampler sampler(1, 1, uint32_t(i));
      const Vec2f uv = sampler.next2D();
      SurfacePoint p = flatPoint(double(uv.x), double(uv.y));
      p.dpdu = {2, 0, 0};
      p.dpdv = {1, float(3 * flipped), 0};
      const double u = double(p.uv.x), v = double(p.uv.y), w = 2 * M_PI;
      const double hu = .1 * w * std::cos(w * u) * std::cos(w * v),
                   hv = -.1 * w * std::sin(w * u) * std::sin(w * v);
      // x = 2 u + v, y = 3 v: dh/dx = hu / 2, dh/dy = (hv - hu / 2) / 3.
      const Vec3d wanted = glm::normalize(Vec3d(-hu / 2, -(hv - hu / 2) / (3 * flipped), 1));
      detail->apply(p);
      EXPECT_LT(glm::length(Vec3d(p.shadingNormal) - wanted), .03);
    }
}

TEST(Bumps, StayOnTheSideOfTheSurface) {
  const auto steep = makeTexture("bilerp", "\"float v10\" 900 \"float v11\" 900 \"float v01\" 0", false);
  SurfacePoint p = flatPoint(.3, .3);
  p.shadingNormal = glm::normalize(Vec3f(-.6f, 0, .8f));
  bumps({BLACK, steep.get()})->apply(p);
  EXPECT_GT(glm::dot(p.shadingNormal, p.geometricNormal), 0);
  EXPECT_NEAR(glm::length(p.shadingNormal), 1, 1e-6);
  // Bumps need coordinates.
  SurfacePoint q = flatPoint(.3, .3);
  q.dpdu = Vec3f(0);
  bumps({BLACK, steep.get()})->apply(q);
  EXPECT_EQ(q.shadingNormal, q.geometricNormal);
}

TEST(NormalMap, TurnsTheNormalInTheFrameOfTheSurface) {
  const Folder folder;
  const Vec3f wanted = glm::normalize(Vec3f(.3f, -.5f, .8f));
  const auto map =
      normalMap(folder.picture("n.exr", 4, 4, [&](int, int) { return Rgb(0.5f * (wanted + 1.0f)); }));
  atPointsOfShapes([&](const std::string& name, const SurfacePoint& p) {
    if (!(glm::length(tangential(p.dpdu, p.shadingNormal)) > 1e-3f)) return;
    SurfacePoint bent = p;
    map->apply(bent);
    const Frame frame(p.shadingNormal, p.dpdu);
    Vec3f n = frame.toWorld(wanted);
    if (glm::dot(n, p.geometricNormal) < 0) n = -n;
    EXPECT_LT(glm::length(bent.shadingNormal - n), 1e-3f) << name;
  });
  // Eight bits are linear: (128, 128, 255) is nearly the normal.
  const auto flat =
      normalMap(folder.picture("flat.png", 4, 4, [](int, int) { return Rgb(.2159f, .2159f, 1); }));
  SurfacePoint p = flatPoint(.2, .3);
  flat->apply(p);
  EXPECT_GT(p.shadingNormal.z, .9999f);
}

TEST(SurfaceDetail, EveryMaterialTakesIt) {
  const auto height = makeTexture("fbm", "", false);
  Textures textures;
  textures.named["h"] = height.get();
  const NamedMaterials named;
  const MaterialContext context{textures, named.context().material};
  for (const auto& entry : plugIns().materials.entries())
    for (const std::string& example : entry.examples) {
      Diagnostics diagnostics;
      const auto made = plugIns().materials.make(
          parseParameterText(entry.name, example + " \"texture displacement\" \"h\""), context, diagnostics);
      if (entry.name == "interface") {
        EXPECT_FALSE(made);
        continue;
      }
      ASSERT_TRUE(made) << diagnostics.format();
      EXPECT_TRUE(made->detail) << entry.name;
      const auto plain =
          plugIns().materials.make(parseParameterText(entry.name, example), context, diagnostics);
      EXPECT_FALSE(plain->detail) << entry.name;
    }
  Diagnostics diagnostics;
  EXPECT_FALSE(plugIns().materials.make(parseParameterText("diffuse", "\"float displacement\" 2"),
                                        {textures, {}}, diagnostics));
  EXPECT_FALSE(plugIns().materials.make(
      parseParameterText("diffuse", "\"texture displacement\" \"h\" \"string normalmap\" \"x.png\""),
      {textures, {}}, diagnostics));
}
