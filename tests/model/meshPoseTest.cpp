/** @file
 * Models at a time of their animation: node keyframes, skeletons and morph targets against closed forms.
 */
#include "model/meshPoseTesting.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

using MeshPose = MeshPoseTest;

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
  // One triangle; the bone of weight .25 is stretched along y by 5 and moved along z by 8, the second bone is
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
  const int times =
                f.floats("SCALAR",
                         {0, 1}), // the second keyframe is the negated quaternion of a rotation by 90 degrees
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
