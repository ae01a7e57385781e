/** @file
 * Models with animations for tests, and their closed forms.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gltfFile.h"
#include "model/importTesting.h"
#include "recurse/model/mesh/plyFile.h"

namespace recurse::testing {

constexpr double RIGHT_ANGLE = std::numbers::pi / 2, TOLERANCE = 2e-6;
constexpr float HALF_SQRT2 = 0.70710678f;

inline std::string indexText(int i) { return std::to_string(i); }

class MeshPoseTest : public ImportTest {
 protected:
  SceneDescription pose(const std::string& parameters, bool wantErrors = false) {
    return load("Shape \"mesh\" \"string filename\" \"m.gltf\" " + parameters, wantErrors);
  }
  SceneDescription poseAt(double time, const std::string& more = {}, bool wantErrors = false) {
    return pose("\"float time\" " + recurse::sceneText(time) + " " + more, wantErrors);
  }
  static MeshData meshOf(const ShapeDescription& s) {
    const std::string& name = s.shape.parameters.at(0).strings.at(0);
    return readPly({name, s.shape.files->at(name)}).mesh;
  }
  /** Vertices of a shape in the space of the scene. */
  static std::vector<Vec3d> vertices(const ShapeDescription& s) {
    std::vector<Vec3d> points = meshOf(s).positions;
    for (Vec3d& p : points) p = transformPoint(s.worldFromObject, p);
    return points;
  }
  static void expectNear(const Vec3d& a, const Vec3d& b, const std::string& where) {
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(a[k], b[k], TOLERANCE * (1 + std::abs(b[k]))) << where << ", axis " << k;
  }
  static void expectNear(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b, const std::string& where) {
    ASSERT_EQ(a.size(), b.size()) << where;
    for (size_t i = 0; i < a.size(); ++i) expectNear(a[i], b[i], where + ", vertex " + std::to_string(i));
  }
};

inline Vec3d turnedAboutX(const Vec3d& v, double angle) {
  return {v.x, std::cos(angle) * v.y - std::sin(angle) * v.z, std::sin(angle) * v.y + std::cos(angle) * v.z};
}
inline Vec3d turnedAboutZ(const Vec3d& v, double angle) {
  return {std::cos(angle) * v.x - std::sin(angle) * v.y, std::sin(angle) * v.x + std::cos(angle) * v.y, v.z};
}

inline const std::vector<Vec3d> TRIANGLE = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

/** A triangle in nodes; "arm" moves from x = 0 to 4 until 2 s, turns by 90° about z until 1 s, and grows
 * along y from 1 to 3 between 1 s and 2 s. Its children include a camera and a lamp. */
inline std::string movingTriangle(const std::string& interpolation = "LINEAR", bool isBinary = false) {
  GltfFile f;
  const int triangle = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0}), twoTimes = f.floats("SCALAR", {0, 2}),
            places = f.floats("VEC3", {0, 0, 0, 4, 0, 0}), oneSecond = f.floats("SCALAR", {0, 1}),
            turns = f.floats("VEC4", {0, 0, 0, 1, 0, 0, HALF_SQRT2, HALF_SQRT2}),
            late = f.floats("SCALAR", {1, 2}), sizes = f.floats("VEC3", {1, 1, 1, 1, 3, 1});
  const auto sampler = [&interpolation](int input, int output) {
    return R"({"interpolation":")" + interpolation + R"(","input":)" + indexText(input) + R"(,"output":)" +
           indexText(output) + "}";
  };
  const std::string members =
      R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[1,3],"translation":[0,10,0]},)"
      R"({"name":"arm","mesh":0,"children":[2,4],"translation":[9,9,9]},)"
      R"({"name":"eye","camera":0,"translation":[0,0,5]},{"mesh":0,"translation":[0,0,7]},)"
      R"({"name":"lamp","translation":[1,0,0],"extensions":{"KHR_lights_punctual":{"light":0}}}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":)" +
      indexText(triangle) +
      R"(}}]}],"cameras":[{"type":"perspective","perspective":{"yfov":0.6,"aspectRatio":2,"znear":0.1}}],)"
      R"("extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[)"
      R"({"type":"point","intensity":3,"name":"lamp"}]}},)"
      R"("animations":[{"name":"wave","channels":[)"
      R"({"sampler":0,"target":{"node":1,"path":"translation"}},)"
      R"({"sampler":1,"target":{"node":1,"path":"rotation"}},)"
      R"({"sampler":2,"target":{"node":1,"path":"scale"}}],"samplers":[)" +
      sampler(twoTimes, places) + "," + sampler(oneSecond, turns) + "," + sampler(late, sizes) +
      R"(]},{"channels":[{"sampler":0,"target":{"node":3,"path":"translation"}}],"samplers":[)" +
      sampler(twoTimes, places) + "]}]";
  return isBinary ? f.binary(members) : f.text(members);
}

inline Vec3d movedTriangle(const Vec3d& p, double time) {
  const double t = std::clamp(time, 0.0, 2.0), turn = RIGHT_ANGLE * std::min(t, 1.0),
               size = 1 + 2 * std::max(t - 1, 0.0);
  return turnedAboutZ({p.x, size * p.y, p.z}, turn) + Vec3d(2 * t, 10, 0);
}

/** A strip of six vertices up to y = 2, two at each of y = 0, 1, 2, with two bones: the lower one is fixed,
 * the upper one turns about the x axis through (0, 1, 0) by 90° in a second. Vertices at y = 1 belong to both
 * halves. Two triangles with a common vertex at (3, 1, 0) follow, one for each bone. The node of the mesh has
 * a different position. */
inline std::string bendingStrip(const std::string& upperBone = R"("name":"upper")") {
  GltfFile f;
  const int positions = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0, 1, 2, 0,
                                          3, 1, 0, 4, 0, 0, 3, 0, 0, 3, 1, 0, 4, 2, 0, 3, 2, 0}),
            normals = f.floats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1,
                                        0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}),
            indices = f.bytes("SCALAR", {0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4, 6, 7, 8, 9, 10, 11});
  std::vector<uint8_t> joints;
  std::vector<float> weights;
  for (const float upper : {0.f, 0.f, 0.5f, 0.5f, 1.f, 1.f, 0.f, 0.f, 0.f, 1.f, 1.f, 1.f}) {
    joints.insert(joints.end(), {0, 1, 0, 0});
    weights.insert(weights.end(), {1 - upper, upper, 0, 0});
  }
  const int jointsAt = f.bytes("VEC4", joints), weightsAt = f.floats("VEC4", weights),
            inverseBinds = f.floats("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                             1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1}),
            times = f.floats("SCALAR", {0, 1}),
            turns = f.floats("VEC4", {0, 0, 0, 1, HALF_SQRT2, 0, 0, HALF_SQRT2});
  return f.text(
      R"("scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"skin":0,"translation":[100,0,0]},)"
      R"({"name":"lower","children":[2]},{)" +
      upperBone + R"(,"translation":[0,1,0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":)" +
      indexText(positions) + R"(,"NORMAL":)" + indexText(normals) + R"(,"JOINTS_0":)" + indexText(jointsAt) +
      R"(,"WEIGHTS_0":)" + indexText(weightsAt) + R"(},"indices":)" + indexText(indices) +
      R"(}]}],"skins":[{"joints":[1,2],"inverseBindMatrices":)" + indexText(inverseBinds) +
      R"(}],"animations":[{"name":"bend","channels":[{"sampler":0,"target":{"node":2,)"
      R"("path":"rotation"}}],"samplers":[{"input":)" +
      indexText(times) + R"(,"output":)" + indexText(turns) + "}]}]");
}

/** A triangle with two morph targets in two nodes, with static weights .5 and 0. In the animation the weights
 * of the first node change from 0, 1 to 1, 0 in two seconds. */
inline std::string morphingTriangle(bool isAnimated, const std::string& interpolation = "LINEAR") {
  const bool isSpline = interpolation == "CUBICSPLINE";
  GltfFile f;
  const int positions = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0}),
            normals = f.floats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1}),
            first = f.floats("VEC3", {0, 0, 1, 0, 0, 2, 0, 0, 3}),
            firstNormals = f.floats("VEC3", {1, 0, -1, 0, 0, 0, 0, 1, 0}),
            second = f.floats("VEC3", {4, 0, 0, 4, 0, 0, 4, 0, 0}), times = f.floats("SCALAR", {0, 2}),
            weights = f.floats("SCALAR", isSpline ? std::vector<float>{7, 8, 0, 1, 9, 7, 6, 5, 1, 0, 4, 3}
                                                  : std::vector<float>{0, 1, 1, 0});
  std::string members =
      R"("scenes":[{"nodes":[0,1]}],"nodes":[{"name":"a","mesh":0},{"name":"b","mesh":0,"translation":[0,9,0]}],)"
      R"("meshes":[{"weights":[0.5,0],"primitives":[{"attributes":{"POSITION":)" +
      indexText(positions) + R"(,"NORMAL":)" + indexText(normals) + R"(},"targets":[{"POSITION":)" +
      indexText(first) + R"(,"NORMAL":)" + indexText(firstNormals) + R"(},{"POSITION":)" + indexText(second) +
      "}]}]}]";
  if (isAnimated)
    members += R"(,"animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"weights"}}],)"
               R"("samplers":[{"interpolation":")" +
               interpolation + R"(","input":)" + indexText(times) + R"(,"output":)" + indexText(weights) +
               "}]}]";
  return f.text(members);
}

/** Keyframes of a property of a node, as members of an animation. */
inline std::string channelMembers(int node, const std::string& property, int times, int values,
                                  const std::string& interpolation = "LINEAR") {
  return R"("channels":[{"sampler":0,"target":{"node":)" + indexText(node) + R"(,"path":")" + property +
         R"("}}],"samplers":[{"interpolation":")" + interpolation + R"(","input":)" + indexText(times) +
         R"(,"output":)" + indexText(values) + "}]";
}

/** A triangle in the node "n". `node`: further members of the node; `animations`: JSON of animations. */
inline std::string triangleInNode(GltfFile& f, const std::string& node, const std::string& animations) {
  const int positions = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  return f.text(R"("scenes":[{"nodes":[0]}],"nodes":[{"name":"n","mesh":0)" + node +
                R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":)" + indexText(positions) +
                R"(}}]}],"animations":[)" + animations + "]");
}

/** A triangle in the node "skinned", which follows the joint "a"; the second joint is "b". `joint` and
 * `other`: additional members of the nodes "a" and "other". The two skins have `matrices` inverse bind
 * matrices. `hasTwoSets`: the vertices have a second set of weights, of integers. */
inline std::string skinnedTriangle(int matrices, const std::string& joint = {}, const std::string& other = {},
                                   bool hasTwoSets = false) {
  GltfFile f;
  const int positions = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0}),
            normals = f.floats("VEC3", {0.6F, 0, 0.8F, 0.6F, 0, 0.8F, 0.6F, 0, 0.8F}),
            joints = f.bytes("VEC4", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}),
            weights = f.floats("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  std::string sets = R"("JOINTS_0":)" + indexText(joints) + R"(,"WEIGHTS_0":)" + indexText(weights);
  if (hasTwoSets)
    sets += R"(,"JOINTS_1":)" + indexText(joints) + R"(,"WEIGHTS_1":)" +
            indexText(f.bytes("VEC4", {255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0}));
  std::string binds;
  if (matrices > 0) {
    std::vector<float> values;
    for (int i = 0; i < matrices; ++i)
      values.insert(values.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    binds = R"(,"inverseBindMatrices":)" + indexText(f.floats("MAT4", values));
  }
  return f.text(
      R"("scenes":[{"nodes":[0,1,2,3]}],"nodes":[{"name":"skinned","mesh":0,"skin":0},{"name":"a")" + joint +
      R"(},{"name":"b"},{"name":"other")" + other +
      R"(}],"meshes":[{"name":"flag","primitives":[{"attributes":{"POSITION":)" + indexText(positions) +
      R"(,"NORMAL":)" + indexText(normals) + "," + sets + R"(}}]}],"skins":[{"joints":[1,2])" + binds +
      R"(},{"joints":[2,1])" + binds + "}]");
}

inline std::vector<Vec3d> morphedTriangle(double first, double second) {
  return {{4 * second, 0, first}, {1 + 4 * second, 0, 2 * first}, {4 * second, 1, 3 * first}};
}

} // namespace recurse::testing
