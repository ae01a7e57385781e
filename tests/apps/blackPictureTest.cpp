/** @file
 * Explanations of a black picture, at the end of its render and by `--check`.
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

  /** Expects the words from both the render and --check. */
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
  // The light leaves the scene, or hits the back of a wall behind the lamp.
  says(seenFrom("3 3 4  0 0 0  0 1 0", lamp("Translate 0 4 0 Rotate -90 1 0 0") + FLOOR), "reverse it");
  isSilentOf(seenFrom("3 3 4  0 0 0  0 1 0", lamp("Translate 0 4 0 Rotate 90 1 0 0") + FLOOR));
  isSilentOf(seenFrom("3 3 4  0 0 0  0 1 0",
                      lamp("Translate 0 4 0 Rotate -90 1 0 0", "\"bool twosided\" true") + FLOOR));
}

TEST_F(BlackPicture, ShowsOnlyGlassInFrontOfNothing) {
  // Few rays of a light this far away hit the ball, which it lights nevertheless.
  for (const std::string from : {"0 3 0", "0 100 0"}) {
    write("glass.pbrt",
          seenFrom("0 0 -5  0 0 0  0 1 0", "LightSource \"point\" \"rgb I\" [ 9 9 9 ] \"point3 from\" [ " +
                                               from + " ]\nMaterial \"dielectric\"\nShape \"sphere\"\n"));
    const Outcome o =
        run({"render", "glass.pbrt", "-q", "--spp", "1", "--integrator", "photonmap", "-o", "a.exr"});
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_TRUE(has(o.err, "warning: the picture is black: the camera sees only glass and mirrors")) << o.err;
    EXPECT_FALSE(has(o.err, "photon was stored") || has(o.err, "hits a surface")) << o.err;
  }
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
  says(seenFrom(eye, sun + room + wall), "in a closed room");
  isSilentOf(seenFrom(eye, sun + room));
  isSilentOf(seenFrom(eye, sun + room + "Material \"dielectric\"\n" + wall));
}

TEST_F(BlackPicture, IsOfNothing) {
  const std::string world = "LightSource \"point\"\nTranslate 0 0 9\nShape \"sphere\"\n";
  says(seenFrom("0 0 0  0 0 -1  0 1 0", world), "is behind the camera");
  says(seenFrom("0 0 0  5 0 1  0 1 0", world), "is outside of the picture");
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

TEST_F(BlackPicture, HasNamesWithoutTerminalEscapes) {
  const std::string name = "red\033[31m";
  says(std::string(FILM) + "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\nObjectBegin \"" +
           name + "\"\nShape \"sphere\"\nObjectEnd\nObjectInstance \"" + name + "\"\n",
       "inside of red\\x1b[31m, which");
  EXPECT_FALSE(has(contents(file(".stderr")), "\033"));
}

TEST_F(BlackPicture, HasLampsThatLightNothingUnderAFaintSky) {
  const auto sky = [](const std::string& radiance) {
    return "LightSource \"infinite\" \"rgb L\" [ " + radiance + " " + radiance + " " + radiance + " ]\n";
  };
  const std::string eye = "3 3 4  0 0 0  0 1 0", above = "AttributeBegin\nTranslate 0 4 0 ",
                    up = "Rotate -90 1 0 0", down = "Rotate 90 1 0 0",
                    wall = "Shape \"bilinearmesh\" \"point3 P\" [ -9 5 -9  9 5 -9  -9 5 9  9 5 9 ]\n",
                    black = "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\n";
  const auto warns = [&](const std::string& world) {
    write("dim.pbrt", seenFrom(eye, world));
    const Outcome o = run({"render", "dim.pbrt", "-q", "--spp", "4", "--integrator", "path", "-o", "dim.exr",
                           "--stats", "dim.json"});
    EXPECT_EQ(o.status, 0) << o.err;
    const bool isSaid = has(o.err, "the lamps illuminate no surface");
    EXPECT_EQ(has(contents(file("dim.json")), "the lamps illuminate no surface"), isSaid);
    EXPECT_EQ(has(o.err, "reverse it"), isSaid) << o.err;
    return isSaid;
  };
  const std::string faint = sky(".0002"), lampUp = lamp("Translate 0 4 0 " + up),
                    lampDown = lamp("Translate 0 4 0 " + down);
  EXPECT_TRUE(warns(faint + lampUp + FLOOR));
  EXPECT_TRUE(warns(faint + lampUp + FLOOR + black + wall)); // the light reaches an object
  EXPECT_FALSE(warns(faint + lampUp + FLOOR + wall));        // which reflects it to the camera
  EXPECT_FALSE(warns(faint + lampDown + FLOOR));
  EXPECT_FALSE(warns(sky(".2") + lampUp + FLOOR)); // the sky is not faint
  EXPECT_FALSE(warns(faint + FLOOR));
}

TEST_F(BlackPicture, IsWrittenBeforeItIsExplained) {
  // Each ray intersects thousands of surfaces: thousands of rays take minutes.
  std::string world = "LightSource \"point\"\nMakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb "
                      "sigma_a\" [ .001 .001 .001 ] \"rgb sigma_s\" [ 0 0 0 ]\n"
                      "Material \"interface\"\nMediumInterface \"m\" \"\"\n";
  for (int i = 0; i < 1500; ++i) world += "Shape \"sphere\" \"float radius\" 1.5\n";
  write("slow.pbrt", seenFrom("0 0 -5  0 0 0  0 1 0", world));
  const Outcome o = run({"render", "slow.pbrt", "--spp", "1", "--resolution", "1x1", "--integrator", "path",
                         "-o", "slow.exr", "--stats", "slow.json"},
                        [&](pid_t) {
                          for (int i = 0; i < 15000 && !exists("slow.exr"); ++i) sleepSeconds(0.01);
                          EXPECT_TRUE(exists("slow.exr") && !exists("slow.json"));
                        });
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_LT(o.seconds, 60);
}
