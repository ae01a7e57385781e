/** @file
 * Displaced meshes: fineness of the subdivision, positions, and closed meshes that stay closed.
 */
#include "model/importTesting.h"
#include "model/mesh/viewDicing.h"
#include "model/shapeTesting.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/scene/plugIns.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::string sceneText(const std::string& camera, const std::string& world) {
  return camera + "\nWorldBegin\nMaterial \"diffuse\"\n" + world;
}

std::unique_ptr<Scene> sceneOf(const std::string& text, std::string* messages = nullptr) {
  Diagnostics diagnostics;
  auto scene = buildScene(parseScene(text, "test.pbrt", ".", diagnostics), {}, diagnostics);
  if (messages)
    *messages = diagnostics.format();
  else
    EXPECT_TRUE(scene) << diagnostics.format();
  return scene;
}

/** First mesh of the scene. */
const TriangleMesh& meshOf(const Scene& scene) {
  for (const SceneShape& s : scene.shapes())
    if (const TriangleMesh* mesh = s.shape->triangleMesh()) return *mesh;
  throw std::runtime_error("the scene has no mesh");
}

/** Calls visit(a, b) for each side of each triangle. */
template <class F> void forEdges(const TriangleMesh& mesh, const F& visit) {
  for (const glm::uvec3& t : mesh.indices())
    for (int k = 0; k < 3; ++k) visit(Vec3d(mesh.positions()[t[k]]), Vec3d(mesh.positions()[t[(k + 1) % 3]]));
}

const std::string FILM = "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 64\n";
const std::string WAVES = "Texture \"h\" \"float\" \"wrinkled\" \"integer octaves\" 3\n"
                          "Texture \"height\" \"float\" \"scale\" \"texture tex\" \"h\" \"float scale\" .2\n";
const std::string SQUARE = "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] "
                           "\"integer indices\" [0 1 2 0 2 3] \"point2 uv\" [0 0 1 0 1 1 0 1] "
                           "\"texture displacement\" \"height\" ";
/** Faces with separate corners and texture coordinates. */
const std::string CUBE =
    "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0  0 0 1 1 0 1 1 1 1 0 1 1  "
    "0 0 0 0 0 1 0 1 1 0 1 0  1 0 0 1 0 1 1 1 1 1 1 0  0 0 0 1 0 0 1 0 1 0 0 1  0 1 0 1 1 0 1 1 1 0 1 1] "
    "\"integer indices\" [0 2 1 0 3 2  4 5 6 4 6 7  8 9 10 8 10 11  12 14 13 12 15 14  16 17 18 16 18 19  "
    "20 22 21 20 23 22] \"point2 uv\" [0 0 1 0 1 1 0 1 0 0 1 0 1 1 0 1 0 0 1 0 1 1 0 1 0 0 1 0 1 1 0 1 "
    "0 0 1 0 1 1 0 1 0 0 1 0 1 1 0 1] \"texture displacement\" \"height\" ";

} // namespace

TEST(Displacement, PointsLieAsHighAsTheTextureSays) {
  // A height that is linear in both coordinates, far from the origin and scaled: in units of the shape.
  const std::string heights = "Texture \"height\" \"float\" \"bilerp\" \"float v00\" .1 \"float v01\" .4 "
                              "\"float v10\" .2 \"float v11\" .5\n";
  const auto scene = sceneOf(
      sceneText("", heights + "Translate 1000 2000 3000 Scale 2 2 2\n" + SQUARE + "\"float edgelength\" .1"));
  ASSERT_TRUE(scene);
  const TriangleMesh& mesh = meshOf(*scene);
  for (const Vec3f& p : mesh.positions()) {
    const Vec3d own = (Vec3d(p) + scene->origin() - Vec3d(1000, 2000, 3000)) / 2.0;
    EXPECT_NEAR(own.z, .1 + .1 * (own.x + 1) / 2 + .3 * (own.y + 1) / 2, 1e-4);
  }
  double longest = 0;
  forEdges(mesh, [&](const Vec3d& a, const Vec3d& b) { longest = std::max(longest, glm::length(b - a)); });
  EXPECT_LE(longest, .1 + 1e-6);
  EXPECT_GT(longest, .05);
  const SurfacePoint s = mesh.surfaceAt(5, HitParameters(Vec2f(.3f, .3f)));
  const Vec3f normal = glm::normalize(Vec3f(-.05f, -.15f, 1));
  EXPECT_GT(glm::dot(s.shadingNormal, normal), .9999f);
}

TEST(Displacement, StaysClosedAndAsFineAtSeams) {
  for (const char* dicing : {"\"float edgelength\" .05", ""}) {
    const auto scene =
        sceneOf(sceneText(FILM + "LookAt 3 2 1.5 .5 .5 .5 0 0 1 Camera \"perspective\" \"float fov\" 30",
                          WAVES + CUBE + dicing));
    ASSERT_TRUE(scene);
    EXPECT_NO_THROW(meshOf(*scene).asSolid()) << dicing;
    EXPECT_GT(meshOf(*scene).primitiveCount(), 2000u);
    // The volume is larger: no face is inside out.
    for (uint32_t i = 0; i < meshOf(*scene).primitiveCount(); i += 7) {
      const SurfacePoint s = meshOf(*scene).surfaceAt(i, HitParameters(Vec2f(.3f, .3f)));
      EXPECT_GT(glm::dot(Vec3d(s.geometricNormal), Vec3d(s.position) + scene->origin() - .5), -.3);
    }
  }
}

TEST(Displacement, EdgesAreShorterThanAPixelWhereTheyAreSeen) {
  const Vec3d eye(0, -3, 1);
  const struct {
    const char* camera;
    std::function<double(const Vec3d&)> pixel; ///< width of a pixel by position
    std::function<Vec3d(const Vec3d&)> view;   ///< direction of view by position
  } views[] = {{"LookAt 0 -3 1  0 0 0  0 0 1 Camera \"perspective\" \"float fov\" 40",
                [&](const Vec3d& p) { return glm::length(p - eye) * 2 * std::tan(M_PI / 9) / 64; },
                [&](const Vec3d& p) { return glm::normalize(p - eye); }},
               {"LookAt 0 -3 1  0 0 0  0 0 1 Camera \"orthographic\"", [](const Vec3d&) { return 2.0 / 64; },
                [&](const Vec3d&) { return glm::normalize(-eye); }}};
  for (const auto& view : views)
    for (const char* placed : {"", "Scale .3 .3 .3 ", "instance"}) {
      const bool instanced = placed == std::string("instance");
      const auto scene = sceneOf(sceneText(
          FILM + view.camera,
          WAVES + (instanced ? "ObjectBegin \"o\" " + SQUARE +
                                   " ObjectEnd "
                                   "AttributeBegin Translate 0 50 0 ObjectInstance \"o\" AttributeEnd "
                                   "Scale .5 .5 .5 ObjectInstance \"o\""
                             : placed + SQUARE)));
      ASSERT_TRUE(scene);
      if (instanced) {
        // The nearer side counts: about 64 pixels across.
        EXPECT_GT(scene->contents().triangles, 2 * 20 * 20u);
        EXPECT_LT(scene->contents().triangles, 40 * 64 * 64u);
        continue;
      }
      double longest = 0, longestSeen = 0, mean = 0;
      size_t count = 0;
      forEdges(meshOf(*scene), [&](const Vec3d& a, const Vec3d& b) {
        const Vec3d place = .5 * (a + b) + scene->origin();
        if (std::max(std::abs(place.x), std::abs(place.y)) > .7)
          return; // the corners are outside of the view
        const double seen = glm::length(glm::cross(b - a, view.view(place))) / view.pixel(place);
        longestSeen = std::max(longestSeen, seen);
        longest = std::max(longest, glm::length(b - a) / view.pixel(place));
        mean += seen;
        ++count;
      });
      EXPECT_LT(longestSeen, 1.2) << view.camera
                                  << placed; // pixels at corners of the film are narrower than in the middle
      EXPECT_LT(longest, 4 * 1.2) << view.camera << placed; // bound for every angle
      EXPECT_GT(mean / double(count), .3) << view.camera << placed;
    }
}

TEST(Displacement, EdgesMayBeAsLongAsTheyAreForeshortened) {
  for (const char* kind : {"perspective", "orthographic"}) {
    FilmSettings film;
    film.width = film.height = 64;
    CameraContext context;
    context.width = context.height = 64;
    Diagnostics diagnostics;
    const PixelWidths pixels(plugIns().cameras.make(parseParameterText(kind, ""), context, diagnostics),
                             film);
    const ViewDicing dicing(pixels, {Mat4d(1)});
    const auto lengthAt = [&](double degrees) { // angle from the direction of view
      const Vec3d half = .001 * Vec3d(std::sin(glm::radians(degrees)), 0, std::cos(glm::radians(degrees)));
      return dicing.edgeLength(Vec3d(0, 0, 5) - half, Vec3d(0, 0, 5) + half);
    };
    const double across = lengthAt(90);
    EXPECT_NEAR(lengthAt(30) / across, 2, .01) << kind;
    EXPECT_NEAR(lengthAt(45) / across, std::sqrt(2), .01) << kind;
    EXPECT_NEAR(lengthAt(5) / across, 4, .01) << kind; // the ratio is at most 4
    EXPECT_NEAR(lengthAt(0) / across, 4, .01) << kind;
  }
}

TEST(Displacement, WhatIsNotSeenIsCoarser) {
  const auto scene =
      sceneOf(sceneText(FILM + "LookAt 0 0 1  1 0 1  0 0 1 Camera \"perspective\" \"float fov\" 40",
                        WAVES + "Scale 20 20 1 " + SQUARE));
  ASSERT_TRUE(scene);
  double ahead = 0, behind = 0;
  forEdges(meshOf(*scene), [&](const Vec3d& a, const Vec3d& b) {
    const Vec3d place = .5 * (a + b) + scene->origin() - Vec3d(0, 0, 1);
    const double angle = glm::length(glm::cross(b - a, place)) / glm::dot(place, place);
    if (place.x > 3.5 && std::abs(place.y) < .25 * place.x) ahead = std::max(ahead, angle);
    if (place.x < -1) behind = std::max(behind, angle);
  });
  EXPECT_LT(ahead, 1.2 * 2 * std::tan(M_PI / 9) / 64);
  EXPECT_GT(behind, 3 * ahead);
}

TEST(Displacement, SaysWhatIsWrong) {
  std::string messages;
  EXPECT_FALSE(sceneOf(
      sceneText("", "Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] "
                    "\"float edgelength\" 1"),
      &messages));
  EXPECT_NE(messages.find("there is no displacement"), std::string::npos) << messages;
  EXPECT_FALSE(sceneOf(sceneText("", SQUARE), &messages));
  EXPECT_NE(messages.find("height"), std::string::npos) << messages;
}

TEST(Displacement, MemoryIsForetoldAtTheShape) {
  std::string polygon = "\"integer levels\" 8 \"integer corners\" [1000] \"point3 P\" [", indices;
  for (int i = 0; i < 1000; ++i) {
    const double angle = 2 * M_PI * i / 1000;
    polygon += std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0 ";
    indices += std::to_string(i) + " ";
  }
  setMemoryLimit(8e9);
  for (const std::string& shape :
       {"\"catmullclark\" " + polygon + "] \"integer indices\" [" + indices + "]",
        std::string("\"loopsubdiv\" \"integer levels\" 12 \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] "
                    "\"integer indices\" [0 1 2 0 2 3]"),
        std::string("\"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] "
                    "\"float displacement\" .1 \"float edgelength\" 1e-9")}) {
    std::string messages;
    EXPECT_FALSE(sceneOf(sceneText("", "Shape " + shape), &messages));
    EXPECT_EQ(messages.find("test.pbrt:4:"), 0u) << messages;
    EXPECT_NE(messages.find(" needs about "), std::string::npos) << messages;
    EXPECT_NE(messages.find("(--memory)"), std::string::npos) << messages;
  }
  setMemoryLimit(INFINITY);
}
