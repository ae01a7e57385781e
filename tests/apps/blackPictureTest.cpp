/** @file
 * What is said of a picture that is black: at the end of its render, and by `--check`.
 */
#include "program.h"

using namespace programTesting;

namespace {

class BlackPicture : public Program {
 protected:
  static constexpr const char* FILM = "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\n";
  static std::string seenFrom(const std::string& lookAt, const std::string& world) {
    return FILM + ("LookAt " + lookAt) + "\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n" + world;
  }
  static constexpr const char* FLOOR =
      "Shape \"bilinearmesh\" \"point3 P\" [ -9 0 -9  9 0 -9  -9 0 9  9 0 9 ]\n";

  /** Both the render and --check say so. */
  void says(const std::string& text, const std::string& words, const std::vector<std::string>& more = {}) {
    write("dark.pbrt", text);
    std::vector<std::string> arguments = {"render", "dark.pbrt", "-q", "--spp", "1", "--integrator", "path"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome rendered = run([&] {
      std::vector<std::string> all = arguments;
      all.insert(all.end(), {"-o", "dark.exr"});
      return all;
    }());
    EXPECT_EQ(rendered.status, 0) << rendered.err;
    EXPECT_TRUE(has(rendered.err, "warning: the picture is black: ") && has(rendered.err, words))
        << words << "\n"
        << rendered.err;
    if (!more.empty()) return;
    arguments.emplace_back("--check");
    const Outcome checked = run(arguments);
    EXPECT_TRUE(has(checked.err, "warning: the picture will be black: ") && has(checked.err, words))
        << words << "\n"
        << checked.err;
  }
  void isSilentOf(const std::string& text, const std::string& resolution = "16x16") {
    write("lit.pbrt", text);
    for (const std::string last : {"-q", "--check"}) {
      const Outcome o = run({"render", "lit.pbrt", "--integrator", "path", "--spp", "4", "--resolution",
                             resolution, "-o", "lit.exr", last});
      EXPECT_EQ(o.status, 0) << o.err;
      EXPECT_FALSE(has(o.err, "black")) << text << o.err;
    }
  }
  static std::string lamp(const std::string& place, const std::string& more = {}) {
    return "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 9 9 9 ] " + more + "\n" + place +
           "\nShape \"disk\" \"float radius\" .3\nAttributeEnd\n";
  }
};

} // namespace

TEST_F(BlackPicture, HasNoLight) {
  says(seenFrom("0 0 -5  0 0 0  0 1 0", "Shape \"sphere\"\n"), "has no light");
  says(seenFrom("0 0 -5  0 0 0  0 1 0", "LightSource \"point\" \"rgb I\" [ 0 0 0 ]\nShape \"sphere\"\n"),
       "power of 0");
}

TEST_F(BlackPicture, HasALampThatFacesAway) {
  // The light leaves the scene, or falls on the other side of a wall behind the lamp.
  says(seenFrom("3 3 4  0 0 0  0 1 0", lamp("Translate 0 4 0 Rotate -90 1 0 0") + FLOOR), "turn it round");
  isSilentOf(seenFrom("3 3 4  0 0 0  0 1 0", lamp("Translate 0 4 0 Rotate 90 1 0 0") + FLOOR));
  isSilentOf(seenFrom("3 3 4  0 0 0  0 1 0",
                      lamp("Translate 0 4 0 Rotate -90 1 0 0", "\"bool twosided\" true") + FLOOR));
}

TEST_F(BlackPicture, IsOfTheInsideOfASolid) {
  says(std::string(FILM) + "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\nShape \"sphere\"\n",
       "inside of sphere");
}

TEST_F(BlackPicture, IsOfAClosedRoomWithTheLightOutside) {
  const std::string room = "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 -1  1 -1 -1  -1 -1 1  1 -1 1 ]\n"
                           "Shape \"bilinearmesh\" \"point3 P\" [ -1 1 -1  1 1 -1  -1 1 1  1 1 1 ]\n"
                           "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1 ]\n"
                           "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 1  1 -1 1  -1 1 1  1 1 1 ]\n"
                           "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 -1  -1 1 -1  -1 -1 1  -1 1 1 ]\n";
  const std::string wall = "Shape \"bilinearmesh\" \"point3 P\" [ 1 -1 -1  1 1 -1  1 -1 1  1 1 1 ]\n";
  const std::string sun = "LightSource \"distant\" \"point3 from\" [ 9 3 1 ]\n", eye = "0 0 0  0 0 1  0 1 0";
  says(seenFrom(eye, sun + room + wall), "a room that is closed on all sides");
  isSilentOf(seenFrom(eye, sun + room));
  isSilentOf(seenFrom(eye, sun + room + "Material \"dielectric\"\n" + wall));
}

TEST_F(BlackPicture, IsOfNothing) {
  const std::string world = "LightSource \"point\"\nTranslate 0 0 9\nShape \"sphere\"\n";
  says(seenFrom("0 0 0  0 0 -1  0 1 0", world), "lies behind the camera");
  says(seenFrom("0 0 0  5 0 1  0 1 0", world), "lies outside of the picture");
}

TEST_F(BlackPicture, HasAMediumInTheSpaceOfTheCamera) {
  const std::string medium = "MakeNamedMedium \"smoke\" \"string type\" \"uniformgrid\" \"integer nx\" 1 "
                             "\"integer ny\" 1 \"integer nz\" 1 \"float density\" [ 1 ] "
                             "\"point3 p0\" [ -1 -1 -1 ] \"point3 p1\" [ 1 1 1 ]\n";
  const std::string world = "LightSource \"point\" \"point3 from\" [ 0 9 0 ]\nMaterial \"interface\"\n"
                            "MediumInterface \"smoke\" \"\"\nShape \"sphere\"\n";
  const std::string eye = "0 0 -9  0 0 0  0 1 0\n";
  says(FILM + ("LookAt " + eye) + medium + "Camera \"perspective\" \"float fov\" 20\nWorldBegin\n" + world,
       "after LookAt");
  isSilentOf(seenFrom(eye, medium + world));
}

TEST_F(BlackPicture, LeavesOutThePathsOfTheLight) {
  const std::string lit = seenFrom("3 3 4  0 0 0  0 1 0", lamp("Translate 0 4 0 Rotate 90 1 0 0") + FLOOR);
  says(lit, "paths LS+DE of --paths", {"--paths", "LS+DE"});
  says(lit, "\"maxdepth\" 0", {"--maxdepth", "0"});
}

TEST_F(BlackPicture, IsNotOneWithASmallBrightThing) {
  isSilentOf(seenFrom("0 0 -120  0 0 0  0 1 0",
                      "AreaLightSource \"diffuse\" \"rgb L\" [ 9 9 9 ]\nShape \"sphere\"\n"),
             "64x64");
}
