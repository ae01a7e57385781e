/** @file
 * Bumps in pictures: shading against the formulas of pbrt, and photons against paths.
 */
#include "model/textureTesting.h"
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr double WAVES = 3;

/** A sphere of triangles with normals and texture coordinates, and waves along u and v as bumps. */
struct BumpySphere {
  static constexpr int ROUND = 24, DOWN = 12;
  double height;
  std::vector<Vec3d> normals;
  std::vector<Vec2d> uvs;
  std::vector<glm::uvec3> triangles;

  explicit BumpySphere(double height) : height(height) {
    for (int j = 0; j <= DOWN; ++j)
      for (int i = 0; i <= ROUND; ++i) {
        const double u = double(i) / ROUND, v = double(j) / DOWN, phi = 2 * M_PI * u, theta = M_PI * v;
        uvs.emplace_back(u, v);
        normals.emplace_back(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                             std::cos(theta));
      }
    for (unsigned j = 0; j < DOWN; ++j)
      for (unsigned i = 0; i < ROUND; ++i) {
        const unsigned a = j * (ROUND + 1) + i, b = a + ROUND + 1;
        triangles.emplace_back(a, b, b + 1);
        triangles.emplace_back(a, b + 1, a + 1);
      }
  }
  double at(const Vec2d& uv) const {
    return height * (2 + std::sin(2 * M_PI * WAVES * uv.x) + std::cos(2 * M_PI * WAVES * uv.y));
  }
  std::string shape() const {
    std::ostringstream out;
    const auto list = [&](const char* name, const auto& values) {
      out << " \"" << name << "\" [";
      for (const auto& v : values)
        for (int i = 0; i < int(v.length()); ++i) out << ' ' << v[i];
      out << " ]";
    };
    out.precision(9);
    out << "Shape \"trianglemesh\"";
    list("point3 P", normals);
    list("normal N", normals);
    list("point2 uv", uvs);
    list("integer indices", triangles);
    return out.str() + "\n";
  }
  /** Shading normal at a point of a triangle, by the frame of pbrt-v4 for meshes with normals, and its
   * bumps. */
  Vec3d shadingNormal(const glm::uvec3& t, const Vec3d& weights) const {
    const auto mix = [&](const auto& values) {
      return values[t.x] * weights.x + values[t.y] * weights.y + values[t.z] * weights.z;
    };
    const Vec2d a = uvs[t.x] - uvs[t.z], b = uvs[t.y] - uvs[t.z];
    const double determinant = a.x * b.y - a.y * b.x;
    const auto byU = [&](const auto& f) {
      return ((f[t.x] - f[t.z]) * b.y - (f[t.y] - f[t.z]) * a.y) / determinant;
    };
    const auto byV = [&](const auto& f) {
      return ((f[t.y] - f[t.z]) * a.x - (f[t.x] - f[t.z]) * b.x) / determinant;
    };
    const Vec2d uv = mix(uvs);
    const Vec3d n = glm::normalize(mix(normals)), along = byU(normals);
    const Vec3d across = glm::cross(n, along), straight = glm::cross(across, n);
    const double w = 2 * M_PI * WAVES, h = at(uv), hu = height * w * std::cos(w * uv.x),
                 hv = -height * w * std::sin(w * uv.y);
    const Vec3d bent =
        glm::normalize(glm::cross(straight + hu * n + h * byU(normals), across + hv * n + h * byV(normals)));
    const Vec3d flat = glm::cross(normals[t.y] - normals[t.x], normals[t.z] - normals[t.x]);
    return glm::dot(bent, glm::dot(flat, n) < 0 ? -flat : flat) < 0 ? -bent : bent;
  }
};

} // namespace

TEST(Bumps, OfAMeshWithNormalsShadeAsInPbrt) {
  const Folder folder;
  for (const double height : {.02, .2}) {
    const BumpySphere sphere(height);
    constexpr int N = 256, SIZE = 48;
    const std::string waves = folder.picture("waves.exr", N, N, [&](int x, int y) {
      return Rgb(float(sphere.at({(x + .5) / N, 1 - (y + .5) / N})));
    });
    const std::string size = std::to_string(SIZE);
    // View from the side, so that the poles are at the rim.
    const Rendered r =
        renderText("Film \"rgb\" \"integer xresolution\" " + size + " \"integer yresolution\" " + size +
                       "\nPixelFilter \"box\" \"float xradius\" .01 \"float yradius\" .01\n"
                       "LookAt 0 -4 0  0 0 0  0 0 1\nCamera \"orthographic\"\nWorldBegin\n"
                       "LightSource \"distant\" \"point3 from\" [1 -2 1] \"point3 to\" [0 0 0]\n"
                       "Texture \"waves\" \"float\" \"imagemap\" \"string filename\" \"" +
                       waves +
                       "\"\nMaterial \"diffuse\" \"rgb reflectance\" [.5 .5 .5] "
                       "\"texture displacement\" \"waves\"\n" +
                       sphere.shape(),
                   "path", "\"integer maxdepth\" 1", 4);
    const Vec3d light = glm::normalize(Vec3d(1, -2, 1)), eye(0, -1, 0);
    double sum = 0, error = 0;
    int compared = 0;
    for (int y = 4; y < SIZE - 4; ++y)
      for (int x = 4; x < SIZE - 4; ++x) {
        // In the camera frame, right is up x forward.
        const double px = 1 - 2 * (x + .5) / SIZE, pz = 1 - 2 * (y + .5) / SIZE;
        for (const glm::uvec3& t : sphere.triangles) {
          const Vec3d p0 = sphere.normals[t.x], p1 = sphere.normals[t.y], p2 = sphere.normals[t.z];
          const Vec3d flat = glm::cross(p1 - p0, p2 - p0);
          if (!(flat.y < 0)) continue; // faces away from the camera
          const auto area = [&](const Vec3d& a, const Vec3d& b) {
            return (a.x - px) * (b.z - pz) - (a.z - pz) * (b.x - px);
          };
          const Vec3d weights =
              Vec3d(area(p1, p2), area(p2, p0), area(p0, p1)) / (area(p1, p2) + area(p2, p0) + area(p0, p1));
          if (weights.x < 0 || weights.y < 0 || weights.z < 0) continue;
          const Vec3d n = sphere.shadingNormal(t, weights);
          const double cosine = glm::dot(n, light);
          const bool lit = glm::dot(flat, light) > 0 && cosine * glm::dot(n, eye) > 0;
          const double expected = lit ? .5 / M_PI * std::abs(cosine) : 0;
          const double value = double(r.value(size_t(y * SIZE + x)).g);
          sum += expected;
          error += std::abs(value - expected);
          ++compared;
          break;
        }
      }
    EXPECT_GT(compared, 1000);
    // A pixel is as wide as a fifth of a wave, and edges of triangles cross some pixels.
    EXPECT_LT(error / sum, .05) << height;
  }
}

TEST(Bumps, PhotonsAndPathsAgreeInASteepRoom) {
  const Folder folder;
  const std::string waves = folder.picture("waves.exr", 64, 64, [](int x, int y) {
    return Rgb(float(.05 * (std::sin(2 * M_PI * x / 64) * std::cos(2 * M_PI * y / 64))));
  });
  const std::string room = view(12, "0 -1.8 .1  0 0 -.3  0 0 1", 70) + R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [6 6 6]
AttributeBegin Translate .3 .2 .5 Shape "sphere" "float radius" .2 AttributeEnd
AttributeEnd
Material "diffuse" "rgb reflectance" [.7 .6 .5]
ReverseOrientation
Shape "box" "point3 p1" [-2 -2 -1] "point3 p2" [2 2 1]
ReverseOrientation
Texture "waves" "float" "imagemap" "string filename" ")" +
                           waves + R"(" "float uscale" 8 "float vscale" 8
Material "diffuse" "rgb reflectance" [.6 .7 .8] "texture displacement" "waves"
Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-2 -2 -.9  2 -2 -.9  2 2 -.9  -2 2 -.9]
  "normal N" [0 0 1  0 0 1  0 0 1  0 0 1] "point2 uv" [0 0  1 0  1 1  0 1]
AttributeBegin Translate -.6 .3 -.4 Shape "sphere" "float radius" .5 AttributeEnd
)";
  const Rendered path = renderText(room, "path", "", samples(150));
  for (const std::string direct : {"shadowrays", "photons"}) {
    const Rendered photons = renderText(
        room, "photonmap", "\"integer photons\" 20000 \"string direct\" \"" + direct + "\"", samples(10));
    EXPECT_NEAR(photons.mean(), path.mean(),
                .02 * path.mean() + 4 * (path.standardError() + photons.standardError()))
        << direct;
  }
  const Rendered light = renderText(room, "bdpt", "", samples(40));
  EXPECT_NEAR(light.mean(), path.mean(),
              .01 * path.mean() + 4 * (path.standardError() + light.standardError()));
}

TEST(Bumps, SmallerThanAKernelShadeThePhotonsOfEachDirection) {
  // Light at a low angle: half of each wave faces away from it, and from the camera, which is as low.
  const Folder folder;
  constexpr int N = 64;
  const std::string waves = folder.picture(
      "waves.exr", N, N, [](int x, int) { return Rgb(float(.05 * std::sin(2 * M_PI * x / N))); });
  for (const std::string material : {"\"diffuse\"", "\"conductor\" \"float roughness\" .6"})
    for (const std::string eye : {"0 0 4", "-3.8 0 1.2"}) {
      const auto scene = sceneFrom(view(8, eye + "  0 0 0  0 1 0", 12) +
                                   "LightSource \"distant\" \"point3 from\" [1 0 .4] \"point3 to\" [0 0 0]\n"
                                   "Texture \"waves\" \"float\" \"imagemap\" \"string filename\" \"" +
                                   waves + "\" \"float uscale\" 8 \"float vscale\" 8\nMaterial " + material +
                                   " \"texture displacement\" \"waves\"\n"
                                   "Shape \"bilinearmesh\" \"point3 P\" [-2 -2 0  2 -2 0  -2 2 0  2 2 0]\n");
      const Rendered path = renderScene(*scene, "path", "", 16);
      const Rendered photons =
          renderScene(*scene, "photonmap",
                      "\"integer passes\" 1 \"integer photons\" 50000 \"float radius\" .3 "
                      "\"string direct\" \"photons\" \"float followroughness\" 0",
                      16);
      EXPECT_NEAR(photons.mean(), path.mean(), .03 * path.mean()) << material << " from " << eye;
    }
}

TEST(Bumps, OfMixedMaterialsAreThoseOfEach) {
  const std::string
      red = "MakeNamedMaterial \"red\" \"string type\" \"diffuse\" \"rgb reflectance\" [.8 0 0] "
            "\"texture displacement\" \"slope\"\n",
      green = "MakeNamedMaterial \"green\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 .6 0]\n";
  const Rendered r = renderText(
      view(8, "0 0 4  0 0 0  0 1 0", 30) +
          "LightSource \"distant\" \"point3 from\" [1 0 1] \"point3 to\" [0 0 0]\n"
          "Texture \"slope\" \"float\" \"bilerp\" \"float v10\" 1 \"float v11\" 1 \"float v01\" 0\n" +
          red + green +
          "Material \"mix\" \"string materials\" [\"red\" \"green\"] \"float amount\" .25\n"
          "Shape \"bilinearmesh\" \"point3 P\" [-2 -2 0  2 -2 0  -2 2 0  2 2 0]\n",
      "path", "\"integer maxdepth\" 1", samples(4096));
  Rgbd mean(0);
  for (size_t i = 0; i < r.pixels(); ++i) mean += Rgbd(r.value(i)) / double(r.pixels());
  // The slope is a quarter along x.
  const double bent = glm::dot(glm::normalize(Vec3d(-.25, 0, 1)), glm::normalize(Vec3d(1, 0, 1)));
  EXPECT_NEAR(mean.r, .75 * .8 / M_PI * bent, .001);
  EXPECT_NEAR(mean.g, .25 * .6 / M_PI * std::sqrt(.5), .001);
}
