/** @file
 * Animated models that cannot be used, or only in part: errors and warnings.
 */
#include "model/meshPoseTesting.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

using MeshPoseFaults = MeshPoseTest;

} // namespace

TEST_F(MeshPoseFaults, IntegersThatAssimpMisreadsAreErrors) {
  write("m.gltf", skinnedTriangle(2, "", "", true));
  poseAt(0, "", true);
  EXPECT_NE(
      messages.find("m.gltf: cannot be used: meshes[0].primitives[0].attributes.WEIGHTS_1 has integers"),
      std::string::npos)
      << messages;
  EXPECT_EQ(messages.find("accepted:"), std::string::npos) << messages;
  pose(""); // they have no effect without a pose
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

TEST_F(MeshPoseFaults, OnlyTheAnimationThatIsPlayedIsJudged) {
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

TEST_F(MeshPoseFaults, SkinsNeedAnInverseBindMatrixForEachJoint) {
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

TEST_F(MeshPoseFaults, SplinesNeedThreeValuesForEachKeyframe) {
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

TEST_F(MeshPoseFaults, NodesThatShareAMeshWithDifferentSkinsAreAWarning) {
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

TEST_F(MeshPoseFaults, ExtensionsOfFilesHaveAnyCase) {
  write("m.GLTF", movingTriangle("STEP"));
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.GLTF\" \"float time\" 0.9");
  expectNear(transformPoint(scene.instances.at(0).worldFromInstance, {1, 1, 0}), {1, 11, 0},
             "the first keyframe");
}

TEST_F(MeshPoseFaults, ChannelsWithoutANodeMoveNothing) {
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

TEST_F(MeshPoseFaults, JsonThatIsNotValidIsAnErrorOfPoses) {
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

TEST_F(MeshPoseFaults, SkeletonsAloneAreNoMesh) {
  write("m.dae", R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset><up_axis>Y_UP</up_axis></asset><library_visual_scenes><visual_scene id="vs">
<node id="low" sid="low" name="low" type="JOINT"><node id="up" sid="up" name="up" type="JOINT">
<translate sid="t">0 1 0</translate></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene></COLLADA>)");
  load("Shape \"mesh\" \"string filename\" \"m.dae\"", true);
  EXPECT_NE(messages.find("m.dae: cannot be used: it has no faces"), std::string::npos) << messages;
}

TEST_F(MeshPoseFaults, UnknownAnimationsAreErrorsThatNameTheKnownOnes) {
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

TEST_F(MeshPoseFaults, NodesOfOneNameAreAWarningWhereTheyMove) {
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
