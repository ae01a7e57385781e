/** @file
 * Models at a time of their animations: node keyframes, skeletons and morph targets against closed forms.
 */
#include <algorithm>
#include <cmath>
#include <numbers>

#include "gltfFile.h"
#include "model/importTesting.h"
#include "recurse/model/mesh/plyFile.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr double RIGHT_ANGLE = std::numbers::pi / 2, TOLERANCE = 2e-6;
constexpr float HALF_SQRT2 = 0.70710678f;

std::string indexText(int i) { return std::to_string(i); }

class MeshPose : public ImportTest {
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

Vec3d turnedAboutX(const Vec3d& v, double angle) {
  return {v.x, std::cos(angle) * v.y - std::sin(angle) * v.z, std::sin(angle) * v.y + std::cos(angle) * v.z};
}
Vec3d turnedAboutZ(const Vec3d& v, double angle) {
  return {std::cos(angle) * v.x - std::sin(angle) * v.y, std::sin(angle) * v.x + std::cos(angle) * v.y, v.z};
}

const std::vector<Vec3d> TRIANGLE = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

/** A triangle in nodes of which "arm" moves from x = 0 to 4 until 2 s, turns by 90° about z until 1 s, and
 * grows along y from 1 to 3 between 1 s and 2 s. Under it are a camera and a lamp. */
std::string movingTriangle(const std::string& interpolation = "LINEAR", bool isBinary = false) {
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

Vec3d movedTriangle(const Vec3d& p, double time) {
  const double t = std::clamp(time, 0.0, 2.0), turn = RIGHT_ANGLE * std::min(t, 1.0),
               size = 1 + 2 * std::max(t - 1, 0.0);
  return turnedAboutZ({p.x, size * p.y, p.z}, turn) + Vec3d(2 * t, 10, 0);
}

/**
 * A strip of six vertices up to y = 2, two at each of y = 0, 1, 2, of two bones: the lower one is fixed, the
 * upper one turns about the x axis through (0, 1, 0) by 90° in a second. Vertices at y = 1 belong to each
 * half. After them come two triangles that touch at (3, 1, 0), one of each bone. The node of the mesh is
 * elsewhere.
 */
std::string bendingStrip(const std::string& upperBone = R"("name":"upper")") {
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

/** A triangle with two morph targets in two nodes, with static weights .5 and 0. In the animation the first
 * node's weights go from 0, 1 to 1, 0 in two seconds. */
std::string morphingTriangle(bool isAnimated, const std::string& interpolation = "LINEAR") {
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

/** Keyframes of a property of a node, as an animation's members. */
std::string channelMembers(int node, const std::string& property, int times, int values,
                           const std::string& interpolation = "LINEAR") {
  return R"("channels":[{"sampler":0,"target":{"node":)" + indexText(node) + R"(,"path":")" + property +
         R"("}}],"samplers":[{"interpolation":")" + interpolation + R"(","input":)" + indexText(times) +
         R"(,"output":)" + indexText(values) + "}]";
}

/** A triangle in the node "n". `node`: further members of the node; `animations`: JSON of animations. */
std::string triangleInNode(GltfFile& f, const std::string& node, const std::string& animations) {
  const int positions = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  return f.text(R"("scenes":[{"nodes":[0]}],"nodes":[{"name":"n","mesh":0)" + node +
                R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":)" + indexText(positions) +
                R"(}}]}],"animations":[)" + animations + "]");
}

/** A triangle in the node "skinned", which follows the joint "a"; the second joint is "b". `joint` and
 * `other`: further members of the nodes "a" and "other". The two skins have `matrices` inverse bind matrices.
 * `hasTwoSets`: the vertices have a second set of weights, of integers. */
std::string skinnedTriangle(int matrices, const std::string& joint = {}, const std::string& other = {},
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

std::vector<Vec3d> morphedTriangle(double first, double second) {
  return {{4 * second, 0, first}, {1 + 4 * second, 0, 2 * first}, {4 * second, 1, 3 * first}};
}

} // namespace

TEST_F(MeshPose, NodesHaveTheTransformsBetweenTheirKeyframes) {
  write("m.gltf", movingTriangle());
  for (const double time : {-1.0, 0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 50.0}) {
    const SceneDescription scene = poseAt(time);
    const std::string where = "time " + recurse::sceneText(time);
    ASSERT_EQ(scene.instances.size(), 2u);
    std::vector<Vec3d> expected, found;
    for (const Vec3d& p : TRIANGLE) {
      expected.push_back(movedTriangle(p, time));
      found.push_back(transformPoint(scene.instances[0].worldFromInstance, p));
    }
    expectNear(found, expected, where);
    expectNear(Vec3d(scene.instances[1].worldFromInstance[3]), {0, 10, 7}, where);
  }
}

TEST_F(MeshPose, CamerasAndLampsFollowTheirNodes) {
  write("m.gltf", movingTriangle());
  for (const double time : {0.0, 0.5, 2.0}) {
    const SceneDescription scene = poseAt(time, "\"string camera\" \"eye\"");
    const std::string where = "time " + recurse::sceneText(time);
    expectNear(Vec3d(scene.worldFromCamera[3]), movedTriangle({0, 0, 5}, time), where);
    const double turn = RIGHT_ANGLE * std::min(time, 1.0);
    expectNear(Vec3d(scene.worldFromCamera[0]), turnedAboutZ({1, 0, 0}, turn), where + ", to the right");
    ASSERT_EQ(scene.lights.size(), 1u);
    const Vec3d lamp = movedTriangle({1, 0, 0}, time);
    for (size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(numberOf(scene.lights[0].light, "from", k), lamp[static_cast<int>(k)], 2e-5) << where;
  }
}

TEST_F(MeshPose, AnimationsAreChosenByName) {
  write("m.gltf", movingTriangle());
  const SceneDescription second = poseAt(1, "\"string animation\" \"animation 2\"");
  expectNear(Vec3d(second.instances[1].worldFromInstance[3]), {2, 10, 0}, "the second animation");
  expectNear(Vec3d(second.instances[0].worldFromInstance[3]), {9, 19, 9}, "not moved by it");
  const SceneDescription first = pose("\"string animation\" \"wave\"");
  expectNear(Vec3d(first.instances[0].worldFromInstance[3]), {0, 10, 0}, "the time is 0");
  ASSERT_EQ(first.importNotes.size(), 1u);
  EXPECT_NE(first.importNotes[0].find("animation \"wave\" at 0 s; left out: 1 animation"), std::string::npos)
      << first.importNotes[0];
}

TEST_F(MeshPose, WithoutTimeTheFilesNodesAndVerticesStay) {
  write("m.gltf", movingTriangle());
  const SceneDescription still = pose("");
  expectNear(Vec3d(still.instances[0].worldFromInstance[3]), {9, 19, 9}, "the node's own translation");
  EXPECT_NE(still.importNotes[0].find("left out: 2 animations"), std::string::npos) << still.importNotes[0];
  write("m.gltf", bendingStrip());
  const SceneDescription strip = pose("");
  EXPECT_NE(strip.importNotes[0].find("left out: 1 animation, 1 mesh's bones"), std::string::npos);
  EXPECT_EQ(meshOf(strip.shapes.at(0)).positions.size(), 11u) << "equal vertices are one";
  expectNear(vertices(strip.shapes.at(0)).at(5), {101, 2, 0}, "the bones do not move it");
  write("m.gltf", morphingTriangle(true));
  EXPECT_EQ(pose("").objects.size(), 1u);
  expectNear(meshOf(pose("").objects.begin()->second.shapes.at(0)).positions, TRIANGLE, "no morph target");
}

TEST_F(MeshPose, BonesBendAStripByARightAngle) {
  for (const char* upperBone : {R"("name":"upper")", R"("extras":{})"}) { // bones need no names
    write("m.gltf", bendingStrip(upperBone));
    for (const double time : {0.0, 0.3, 0.5, 1.0, 3.0}) {
      const SceneDescription scene = poseAt(time);
      EXPECT_EQ(messages, "");
      ASSERT_EQ(scene.shapes.size(), 1u);
      const double angle = RIGHT_ANGLE * std::min(time, 1.0);
      const auto upper = [angle](const Vec3d& p) {
        return turnedAboutX(p - Vec3d(0, 1, 0), angle) + Vec3d(0, 1, 0);
      };
      expectNear(vertices(scene.shapes[0]),
                 {{0, 0, 0},
                  {1, 0, 0},
                  {0, 1, 0},
                  {1, 1, 0},
                  upper({0, 2, 0}),
                  upper({1, 2, 0}),
                  {3, 1, 0},
                  {4, 0, 0},
                  {3, 0, 0},
                  {3, 1, 0},
                  upper({4, 2, 0}),
                  upper({3, 2, 0})},
                 "time " + recurse::sceneText(time));
      // The mean of the identity and a rotation turns normals by half the angle.
      const std::vector<Vec3d> normals = meshOf(scene.shapes[0]).normals;
      ASSERT_EQ(normals.size(), 12u);
      for (size_t i = 0; i < 6; ++i)
        expectNear(normals[i], turnedAboutX({0, 0, 1}, angle * double(i / 2) / 2), "normal");
    }
  }
}

TEST_F(MeshPose, WeightsBlendPositionsAndNormalsByTheInverseTranspose) {
  // One triangle; the bone of weight .25 is stretched along y by 5 and moved along z by 8, the other is
  // fixed: the mean stretches by 2 and moves by 2. Weights need not add up to 1.
  GltfFile f;
  const int positions = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0}),
            normals = f.floats("VEC3", {0, 0.6f, 0.8f, 0, 1, 0, 0, 0, -1}),
            joints = f.bytes("VEC4", {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}),
            weights = f.floats("VEC4", {1.5f, 0.5f, 0, 0, 1.5f, 0.5f, 0, 0, 0, 0, 0, 0}),
            inverseBinds = f.floats("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                             1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  write("m.gltf",
        f.text(R"("scenes":[{"nodes":[0,1,2]}],"nodes":[{"mesh":0,"skin":0,"translation":[0,50,0]},)"
               R"({"name":"fixed"},{"name":"moved","translation":[0,0,8],"scale":[1,5,1]}],)"
               R"("meshes":[{"primitives":[{"attributes":{"POSITION":)" +
               indexText(positions) + R"(,"NORMAL":)" + indexText(normals) + R"(,"JOINTS_0":)" +
               indexText(joints) + R"(,"WEIGHTS_0":)" + indexText(weights) +
               R"(}}]}],"skins":[{"joints":[1,2],"inverseBindMatrices":)" + indexText(inverseBinds) + "}]"));
  const SceneDescription scene = poseAt(0);
  EXPECT_NE(messages.find("m.gltf has no animation"), std::string::npos) << messages;
  ASSERT_EQ(scene.shapes.size(), 1u);
  expectNear(vertices(scene.shapes[0]), {{0, 0, 2}, {1, 0, 2}, {0, 51, 0}}, "no bone holds the last one");
  const std::vector<Vec3d> bent = meshOf(scene.shapes[0]).normals;
  expectNear(bent, {glm::normalize(Vec3d(0, 0.6 / 2, 0.8)), {0, 1, 0}, {0, 0, -1}}, "normals");
}

TEST_F(MeshPose, MorphTargetsAddUpByTheirWeights) {
  for (const std::string interpolation : {"LINEAR", "CUBICSPLINE"}) {
    write("m.gltf", morphingTriangle(true, interpolation));
    for (const double time : {-3.0, 0.0, 0.5, 1.0, 2.0, 4.0}) {
      const SceneDescription scene = poseAt(time);
      const std::string where = interpolation + ", time " + recurse::sceneText(time);
      ASSERT_EQ(scene.shapes.size(), 2u) << where;
      EXPECT_EQ(messages.find("CUBICSPLINE keyframes are interpolated linearly") != std::string::npos,
                interpolation == "CUBICSPLINE");
      const double weight = std::clamp(time / 2, 0.0, 1.0);
      expectNear(vertices(scene.shapes[0]), morphedTriangle(weight, 1 - weight), where);
      const std::vector<Vec3d> normals = meshOf(scene.shapes[0]).normals;
      expectNear(
          normals,
          {glm::normalize(Vec3d(weight, 0, 1 - weight)), {0, 0, 1}, glm::normalize(Vec3d(0, weight, 1))},
          where + ", normals");
      std::vector<Vec3d> other = morphedTriangle(0.5, 0);
      for (Vec3d& p : other) p.y += 9;
      expectNear(vertices(scene.shapes[1]), other, "the node that no channel moves has the static weights");
    }
  }
}

TEST_F(MeshPose, StaticWeightsNeedNoAnimation) {
  write("m.gltf", morphingTriangle(false));
  const SceneDescription scene = poseAt(7);
  EXPECT_NE(messages.find("test.pbrt:2:54: warning: "), std::string::npos) << messages;
  EXPECT_NE(messages.find("m.gltf has no animation; its pose is the same at all times"), std::string::npos);
  ASSERT_EQ(scene.shapes.size(), 2u);
  expectNear(vertices(scene.shapes[0]), morphedTriangle(0.5, 0), "half of the first target");
}

TEST_F(MeshPose, StepsStayUntilTheNextKeyframe) {
  write("m.gltf", movingTriangle("STEP"));
  const auto corner = [this](double time) {
    return transformPoint(poseAt(time).instances.at(0).worldFromInstance, {1, 1, 0});
  };
  expectNear(corner(0.9), {1, 11, 0}, "the first keyframes");
  expectNear(corner(1.9), {-1, 11, 0}, "turned");
  expectNear(corner(2), {1, 11, 0}, "moved and stretched");
  write("m.gltf", morphingTriangle(true, "STEP"));
  expectNear(vertices(poseAt(1.9).shapes.at(0)), morphedTriangle(0, 1), "the first weights");
  expectNear(vertices(poseAt(2).shapes.at(0)), morphedTriangle(1, 0), "the last weights");
}

TEST_F(MeshPose, BinaryFilesHaveTheSamePose) {
  write("m.glb", movingTriangle("STEP", true));
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.glb\" \"float time\" 1.9");
  expectNear(transformPoint(scene.instances.at(0).worldFromInstance, {1, 1, 0}), {-1, 11, 0}, "turned");
}

TEST_F(MeshPose, WeightsOfANodeReplaceThoseOfItsMesh) {
  std::string text = morphingTriangle(false);
  text.replace(text.find(R"({"name":"b",)"), 1, R"({"weights":[0.25,2],)");
  write("m.gltf", text);
  const SceneDescription scene = poseAt(0);
  expectNear(vertices(scene.shapes.at(0)), morphedTriangle(0.5, 0), "those of the mesh");
  std::vector<Vec3d> expected = morphedTriangle(0.25, 2);
  for (Vec3d& p : expected) p.y += 9;
  expectNear(vertices(scene.shapes.at(1)), expected, "those of the node");
}

TEST_F(MeshPose, IntegersThatAssimpMisreadsAreErrors) {
  write("m.gltf", skinnedTriangle(2, "", "", true));
  poseAt(0, "", true);
  EXPECT_NE(
      messages.find("m.gltf: cannot be used: meshes[0].primitives[0].attributes.WEIGHTS_1 has integers"),
      std::string::npos)
      << messages;
  EXPECT_EQ(messages.find("accepted:"), std::string::npos) << messages;
  pose(""); // without a pose they do not matter
  EXPECT_EQ(messages, "");
  std::string text = bendingStrip();
  const std::string weights = R"({"bufferView":4,"componentType":5126)";
  ASSERT_NE(text.find(weights), std::string::npos);
  write("m.gltf",
        text.replace(text.find(weights), weights.size(), R"({"bufferView":4,"componentType":5121)"));
  poseAt(0, "", true);
  EXPECT_NE(messages.find("meshes[0].primitives[0].attributes.WEIGHTS_0 has integers"), std::string::npos)
      << messages;
}

TEST_F(MeshPose, OnlyTheAnimationThatIsPlayedIsJudged) {
  GltfFile f;
  const int times = f.floats("SCALAR", {0, 1}), places = f.floats("VEC3", {0, 0, 0, 4, 0, 0}),
            integers = f.bytes("VEC4", {0, 0, 0, 127, 0, 0, 127, 0}),
            tangents = f.floats("VEC3", {0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 6, 0, 0, 0, 0, 0});
  write("m.gltf",
        triangleInNode(f, "",
                       R"({"name":"plain",)" + channelMembers(0, "translation", times, places) +
                           R"(},{"name":"packed",)" + channelMembers(0, "rotation", times, integers) +
                           R"(},{"name":"curved",)" +
                           channelMembers(0, "translation", times, tangents, "CUBICSPLINE") + "}"));
  const auto cornerOf = [&](const char* name) {
    return vertices(poseAt(0.5, std::string("\"string animation\" \"") + name + "\"").shapes.at(0)).at(0);
  };
  expectNear(cornerOf("plain"), {2, 0, 0}, "the mean of 0 and 4");
  EXPECT_EQ(messages, "");
  expectNear(cornerOf("curved"), {4, 0, 0}, "the mean of 2 and 6");
  EXPECT_NE(messages.find("animation \"curved\": its CUBICSPLINE keyframes are interpolated linearly"),
            std::string::npos)
      << messages;
  poseAt(0.5, "\"string animation\" \"packed\"", true);
  EXPECT_NE(messages.find("cannot be used: animation \"packed\": animations[1].samplers[0] has integers"),
            std::string::npos)
      << messages;
}

TEST_F(MeshPose, MirroredNodesStayMirrored) {
  GltfFile f;
  const int times = f.floats("SCALAR", {0, 1}), places = f.floats("VEC3", {0, 0, 0, 4, 0, 0});
  const std::string slide = "{" + channelMembers(0, "translation", times, places) + "}";
  write("m.gltf", triangleInNode(f, R"(,"scale":[-1,1,1])", slide));
  expectNear(vertices(poseAt(0.5).shapes.at(0)), {{2, 0, 0}, {1, 0, 0}, {2, 1, 0}}, "no rotation");
  write("m.gltf", triangleInNode(f, R"(,"scale":[-1,1,1],"rotation":[0,0,0.70710678,0.70710678])", slide));
  expectNear(vertices(poseAt(0.5).shapes.at(0)), {{2, 0, 0}, {2, -1, 0}, {1, 0, 0}}, "turned by 90 degrees");
}

TEST_F(MeshPose, FramesAtTimesOfStepsShowThem) {
  GltfFile f;
  std::vector<float> times, places;
  for (int k = 0; k < 49; ++k) {
    times.push_back(static_cast<float>(k / 24.0));
    places.insert(places.end(), {static_cast<float>(k), 0, 0});
  }
  const int timesAt = f.floats("SCALAR", times), placesAt = f.floats("VEC3", places);
  write("m.gltf",
        triangleInNode(f, "", "{" + channelMembers(0, "translation", timesAt, placesAt, "STEP") + "}"));
  for (int k = 0; k < 49; ++k) EXPECT_EQ(vertices(poseAt(k / 24.0).shapes.at(0)).at(0).x, k) << "frame " << k;
}

TEST_F(MeshPose, RotationsTakeTheShortestWay) {
  GltfFile f;
  const int times = f.floats("SCALAR", {0, 1}), // the second keyframe is the negative of a turn by 90 degrees
      turns = f.floats("VEC4", {0, 0, 0, 1, 0, 0, -HALF_SQRT2, -HALF_SQRT2});
  write("m.gltf", triangleInNode(f, "", "{" + channelMembers(0, "rotation", times, turns) + "}"));
  for (const double time : {0.25, 0.5, 1.0})
    expectNear(vertices(poseAt(time).shapes.at(0)).at(1), turnedAboutZ({1, 0, 0}, RIGHT_ANGLE * time),
               "time " + recurse::sceneText(time));
}

TEST_F(MeshPose, MirroringBonesKeepTheFrontOfTriangles) {
  for (const double side : {1.0, -1.0}) {
    write("m.gltf", skinnedTriangle(2, R"(,"scale":[)" + recurse::sceneText(2 * side) + ",1,1]"));
    const SceneDescription scene = poseAt(0);
    const MeshData mesh = meshOf(scene.shapes.at(0));
    expectNear(mesh.positions, {{0, 0, 0}, {2 * side, 0, 0}, {0, 1, 0}}, "positions");
    // The inverse transpose divides x by 2 and -2.
    ASSERT_EQ(mesh.normals.size(), 3U);
    for (const Vec3d& n : mesh.normals) expectNear(n, glm::normalize(Vec3d(0.3 * side, 0, 0.8)), "normal");
    const glm::uvec3 t = mesh.triangles.at(0);
    const Vec3d front =
        glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    expectNear(front, {0, 0, 2}, "front");
  }
}

TEST_F(MeshPose, SkinsNeedAnInverseBindMatrixForEachJoint) {
  for (const int matrices : {0, 1}) {
    write("m.gltf", skinnedTriangle(matrices));
    for (const char* parameters : {"", "\"float time\" 1"}) {
      pose(parameters, true);
      EXPECT_NE(messages.find("m.gltf: cannot be used: skins[0] has no inverse bind matrix for each joint"),
                std::string::npos)
          << messages;
    }
  }
  write("m.gltf", skinnedTriangle(2));
  pose("");
  EXPECT_EQ(messages, "");
}

TEST_F(MeshPose, SplinesNeedThreeValuesForEachKeyframe) {
  GltfFile f;
  const int times = f.floats("SCALAR", {0, 1, 2}), places = f.floats("VEC3", std::vector<float>(8 * 3, 1));
  write("m.gltf",
        triangleInNode(f, "", "{" + channelMembers(0, "translation", times, places, "CUBICSPLINE") + "}"));
  for (const char* parameters : {"", "\"float time\" 1"}) {
    pose(parameters, true);
    EXPECT_NE(messages.find("m.gltf: cannot be used: animations[0].samplers[0] has fewer"), std::string::npos)
        << messages;
  }
}

TEST_F(MeshPose, NodesThatShareAMeshWithDifferentSkinsAreAWarning) {
  const std::string expected = "nodes show the mesh \"flag\" with different skins or without";
  for (const char* other : {R"(,"mesh":0,"skin":1)", R"(,"mesh":0)"}) {
    write("m.gltf", skinnedTriangle(2, "", other));
    poseAt(0);
    EXPECT_NE(messages.find(expected), std::string::npos) << messages;
    pose("");
    EXPECT_EQ(messages, "");
  }
  write("m.gltf", skinnedTriangle(2, "", R"(,"mesh":0,"skin":0)"));
  poseAt(0);
  EXPECT_EQ(messages.find(expected), std::string::npos) << messages;
}

TEST_F(MeshPose, ExtensionsOfFilesHaveAnyCase) {
  write("m.GLTF", movingTriangle("STEP"));
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.GLTF\" \"float time\" 0.9");
  expectNear(transformPoint(scene.instances.at(0).worldFromInstance, {1, 1, 0}), {1, 11, 0},
             "the first keyframe");
}

TEST_F(MeshPose, ChannelsWithoutANodeMoveNothing) {
  GltfFile f;
  const int times = f.floats("SCALAR", {0, 1}), places = f.floats("VEC3", {1, 1, 1, 7, 2, 1});
  const std::string samplers = R"("samplers":[{"input":)" + indexText(times) + R"(,"output":)" +
                               indexText(places) + "}]",
                    pointer =
                        R"({"sampler":0,"target":{"path":"pointer","extensions":{"KHR_animation_pointer":)"
                        R"({"pointer":"/materials/0/emissiveFactor"}}}})",
                    growth = R"({"sampler":0,"target":{"node":0,"path":"scale"}})",
                    slide = R"({"sampler":0,"target":{"node":0,"path":"translation"}})";
  const int positions = f.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const auto writeChannels = [&](const std::string& channels) {
    write("m.gltf", f.text(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[3,0,0]}],)"
                           R"("meshes":[{"primitives":[{"attributes":{"POSITION":)" +
                           indexText(positions) + R"(}}]}],"animations":[{"channels":[)" + channels + "]," +
                           samplers + "}]"));
  };
  writeChannels(pointer);
  expectNear(vertices(poseAt(1).shapes.at(0)), {{3, 0, 0}, {4, 0, 0}, {3, 1, 0}}, "the file's translation");
  writeChannels(growth + "," + pointer);
  expectNear(vertices(poseAt(1).shapes.at(0)), {{3, 0, 0}, {10, 0, 0}, {3, 2, 0}}, "only larger");
  writeChannels(pointer + "," + slide);
  expectNear(vertices(poseAt(1).shapes.at(0)).at(0), {7, 2, 1}, "the last channel counts");
  writeChannels(slide + "," + pointer);
  poseAt(1, "", true);
  EXPECT_NE(messages.find("animations[0].channels[1] has no node or an unknown property"), std::string::npos)
      << messages;
}

TEST_F(MeshPose, JsonThatIsNotValidIsAnErrorOfPoses) {
  write("m.gltf", "{\"asset\":{\"version\":\"2.0\"},\n \"nodes\":[,]}");
  poseAt(1, "", true);
  EXPECT_TRUE(messages.starts_with("test.pbrt:2:")) << messages;
  EXPECT_NE(messages.find("m.gltf: cannot be used: its JSON is not valid: parse error at line 2, column 11"),
            std::string::npos)
      << messages;
  std::string text = movingTriangle(); // a name in Latin 1, which Assimp accepts
  text.replace(text.find("\"arm\""), 5, "\"arm\xe9\"");
  write("m.gltf", text);
  poseAt(1, "", true);
  EXPECT_NE(messages.find("its JSON is not valid"), std::string::npos) << messages;
  EXPECT_EQ(pose("").instances.size(), 2U);
}

TEST_F(MeshPose, SkeletonsAloneAreNoMesh) {
  write("m.dae", R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset><up_axis>Y_UP</up_axis></asset><library_visual_scenes><visual_scene id="vs">
<node id="low" sid="low" name="low" type="JOINT"><node id="up" sid="up" name="up" type="JOINT">
<translate sid="t">0 1 0</translate></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene></COLLADA>)");
  load("Shape \"mesh\" \"string filename\" \"m.dae\"", true);
  EXPECT_NE(messages.find("m.dae: cannot be used: it has no faces"), std::string::npos) << messages;
}

TEST_F(MeshPose, TicksOfTheFileAreItsUnitOfTime) {
  const auto model = [](const std::string& rate) {
    return "xof 0303txt 0032\n" + rate +
           "Frame arm { FrameTransformMatrix { 1.,0.,0.,0., 0.,1.,0.,0., 0.,0.,1.,0., 0.,0.,0.,1.;; }\n"
           "Mesh { 3; 0;0;0;, 1;0;0;, 0;1;0;; 1; 3;0,1,2;; } }\nAnimationSet slide { Animation { {arm}\n"
           "AnimationKey { 2; 2; 0;3;0.,0.,0.;;, 50;3;4.,0.,0.;;; } } }\n";
  };
  const auto placeAt = [this](const char* time) {
    const SceneDescription scene =
        load(std::string("Shape \"mesh\" \"string filename\" \"m.x\" \"float time\" ") + time);
    return vertices(scene.shapes.at(0)).at(0).x;
  };
  write("m.x", model("AnimTicksPerSecond { 100; }\n"));
  EXPECT_NEAR(placeAt("0.125"), 1, TOLERANCE);
  EXPECT_NEAR(placeAt("0.6"), 4, TOLERANCE);
  write("m.x", model("")); // 25 per second
  EXPECT_NEAR(placeAt("0.5"), 1, TOLERANCE);
}

TEST_F(MeshPose, UnknownAnimationsAreErrorsThatNameTheKnownOnes) {
  write("m.gltf", movingTriangle());
  pose("\"string animation\" \"walk\"", true);
  EXPECT_NE(messages.find("test.pbrt:2:60: error: "), std::string::npos) << messages;
  EXPECT_NE(messages.find("m.gltf has no animation \"walk\""), std::string::npos) << messages;
  EXPECT_NE(messages.find("\"wave\", \"animation 2\""), std::string::npos) << messages;
  write("m.gltf", morphingTriangle(false));
  pose("\"string animation\" \"walk\" \"float time\" 1", true);
  EXPECT_NE(messages.find("m.gltf has no animation \"walk\": it has none at all"), std::string::npos)
      << messages;
  EXPECT_EQ(messages.find("accepted:"), std::string::npos) << messages;
  write("m.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                 "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                 "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  load("Shape \"mesh\" \"string filename\" \"m.ply\" \"float time\" 1");
  EXPECT_NE(messages.find("m.ply has no animation;"), std::string::npos) << messages;
  load("Shape \"mesh\" \"string filename\" \"m.ply\" \"string animation\" \"walk\"", true);
  EXPECT_NE(messages.find("m.ply has no animation \"walk\""), std::string::npos) << messages;
}

TEST_F(MeshPose, NodesOfOneNameAreAWarningWhereTheyMove) {
  std::string text = movingTriangle();
  text.replace(text.find(R"({"mesh":0,"translation":[0,0,7]})"), 2, R"({"name":"arm",")");
  write("m.gltf", text);
  poseAt(1);
  EXPECT_NE(messages.find("several nodes that the pose needs are called \"arm\""), std::string::npos)
      << messages;
  pose("\"string animation\" \"wave\"");
  EXPECT_TRUE(messages.starts_with("test.pbrt:2:")) << messages;
  pose("");
  EXPECT_EQ(messages, "");
}
