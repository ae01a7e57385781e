/** @file
 * `--camera` for a scene file with several cameras.
 */
#include "program.h"

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::readImage;

namespace {

/** A room with a red light on the left and a green one on the right, and two cameras that see one of them
 * each. */
std::string twoCameras(const std::string& more = "") {
  return "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
         "LookAt 0 0 0  -1 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 40 \"string name\" \"left\"\n"
         "Identity LookAt 0 0 0  1 0 0  0 0 1\n"
         "Camera \"orthographic\" \"string name\" \"right\"" +
         more +
         "\nWorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\n"
         "AreaLightSource \"diffuse\" \"bool twosided\" true \"rgb L\" [ 1 0 0 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -5 -9 -9  -5 -9 9  -5 9 -9  -5 9 9 ]\n"
         "AreaLightSource \"diffuse\" \"bool twosided\" true \"rgb L\" [ 0 1 0 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ 5 -9 -9  5 9 -9  5 -9 9  5 9 9 ]\n";
}

class CameraChoice : public Program {
 protected:
  Outcome render(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"render",       "rooms.pbrt", "-o",    "a.exr",
                                          "--integrator", "path",       "--spp", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  recurse::Rgb colour(const std::vector<std::string>& more) {
    const Outcome o = render(more);
    EXPECT_EQ(o.status, 0) << o.err;
    return readImage(file("a.exr")).rgb(4, 4);
  }
};

const recurse::Rgb RED(1, 0, 0), GREEN(0, 1, 0);

} // namespace

TEST_F(CameraChoice, TheFirstCameraRendersUnlessAnotherIsNamed) {
  write("rooms.pbrt", twoCameras());
  EXPECT_EQ(colour({}), RED);
  EXPECT_EQ(colour({"--camera", "left"}), RED);
  EXPECT_EQ(colour({"--camera", "right"}), GREEN);
}

TEST_F(CameraChoice, AnUnknownNameIsAnErrorThatListsTheNames) {
  write("rooms.pbrt", twoCameras());
  const Outcome o = render({"--camera", "attic"});
  EXPECT_EQ(o.status, 2);
  EXPECT_TRUE(has(o.err, "there is no camera 'attic'; there are: left, right")) << o.err;
  const Outcome none = run({"render", "scene.pbrt", "-o", "a.exr", "--camera", "left"});
  EXPECT_EQ(none.status, 2);
  EXPECT_TRUE(has(none.err, "there is none with a name")) << none.err;
}

TEST_F(CameraChoice, TheReportNamesTheCameras) {
  write("rooms.pbrt", twoCameras());
  const Outcome first = run({"info", "rooms.pbrt"});
  EXPECT_TRUE(has(first.out, "perspective \"left\" (others: \"right\"), filter")) << first.out << first.err;
  const Outcome second = run({"info", "rooms.pbrt", "--camera", "right"});
  EXPECT_TRUE(has(second.out, "orthographic \"right\" (others: \"left\"), filter"))
      << second.out << second.err;
}

TEST_F(CameraChoice, ErrorsOfEveryCameraAreReported) {
  write("rooms.pbrt", twoCameras(" \"float fov\" 40"));
  const Outcome o = render({});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "\"fov\"")) << o.err;
}

TEST_F(CameraChoice, ARenderIsNotContinuedWithAnotherCamera) {
  write("rooms.pbrt", twoCameras());
  EXPECT_EQ(render({"--checkpoint", "c.rck"}).status, 0);
  const Outcome o = render({"--checkpoint", "c.rck", "--resume", "--camera", "right"});
  EXPECT_NE(o.status, 0);
  EXPECT_TRUE(has(o.err, "camera: left in the checkpoint, right here")) << o.err;
}
