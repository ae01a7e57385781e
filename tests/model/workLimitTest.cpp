/** @file
 * Predicted work of a scene, which is refused at the directive with too much.
 */
#include "model/importTesting.h"
#include "model/shapeTesting.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/scene/plugIns.h"

using namespace recurse;

namespace {

/** Limits the work during its lifetime. */
class LimitedWork {
 public:
  explicit LimitedWork(double seconds) { setWorkLimit(seconds); }
  ~LimitedWork() { setWorkLimit(INFINITY); }
  LimitedWork(const LimitedWork&) = delete;
  LimitedWork& operator=(const LimitedWork&) = delete;
};

/** Messages about a scene whose shapes begin in line 3. */
std::string messagesOf(const std::string& shapes, int width = 8) {
  Diagnostics diagnostics;
  const std::string text = "Film \"rgb\" \"integer xresolution\" " + std::to_string(width) +
                           " \"integer yresolution\" 8\nWorldBegin Material \"diffuse\"\n" + shapes;
  buildScene(parseScene(text, "test.pbrt", ".", diagnostics), {}, diagnostics);
  return diagnostics.hasErrors() ? diagnostics.format() : "";
}

void expectRefused(const std::string& messages, int line) {
  EXPECT_EQ(messages.find("test.pbrt:" + std::to_string(line) + ":"), 0u) << messages;
  EXPECT_NE(messages.find(" of one core"), std::string::npos) << messages;
  EXPECT_NE(messages.find("(--work)"), std::string::npos) << messages;
}

std::string repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

const std::string SQUARE_MESH = "\"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] ";

} // namespace

TEST(WorkLimit, AddsUpWhileThereIsASum) {
  const LimitedWork limit(1);
  requireWork("a part", 0.9);
  requireWork("another", 0.9);
  EXPECT_THROW(requireWork("too much", 1.1), Error);
  const WorkSum whole;
  requireWork("a part", 0.7);
  {
    const WorkSum other;
    requireWork("of something else", 0.7);
  }
  try {
    requireWork("a second part", 0.4);
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "a second part takes about 0.4 s of one core after 0.7 s for other parts of the "
                           "scene, and 1 s are allowed (--work)");
  }
  requireWork("a smaller one", 0.2);
}

TEST(WorkLimit, IsOfSurfacesThatAreDivided) {
  const std::string mesh = SQUARE_MESH + "\"integer indices\" [0 1 2 0 2 3] ";
  const std::string points = "\"point3 P\" [" + repeated("0 0 0 ", 15) + "1 1 1] ";
  for (const std::string& shape :
       {"Shape \"loopsubdiv\" \"integer levels\" 6 " + mesh,
        "Shape \"catmullclark\" \"integer levels\" 6 " + SQUARE_MESH + "\"integer indices\" [0 1 2 3]",
        "Shape \"bezierpatch\" \"integer steps\" 64 " + points,
        "Shape \"trianglemesh\" " + mesh + "\"float displacement\" .1 \"float edgelength\" .01"}) {
    EXPECT_EQ(messagesOf("\n" + shape), "") << shape;
    const LimitedWork limit(1e-3);
    expectRefused(messagesOf("\n" + shape), 4);
  }
}

TEST(WorkLimit, IsOfTheWholeScene) {
  const std::string shape =
      "Shape \"loopsubdiv\" \"integer levels\" 4 " + SQUARE_MESH + "\"integer indices\" [0 1 2 0 2 3]\n";
  const LimitedWork limit(2.5 * 5e-6 * 512);
  EXPECT_EQ(messagesOf(repeated(shape, 2)), "");
  expectRefused(messagesOf(repeated(shape, 3)), 5);
}

TEST(WorkLimit, IsOfSurfacesThatARayMeetsAtOnePlace) {
  const std::string ball = "Shape \"sphere\"\n", other = "Shape \"sphere\" \"float radius\" 2\n";
  const std::string lamp = "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd\n";
  const std::string object = "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd ";
  const std::string instance = "ObjectInstance \"o\"\n";
  const std::string positions = "\"point3 P\" [" + repeated("0 0 0  ", 40) + "] \"float radius\" 9";
  for (const std::string& shapes :
       {repeated(ball, 40), repeated(lamp, 40), object + repeated(instance, 40), other + repeated(ball, 40),
        "Shape \"metaballs\" " + positions, "Shape \"points\" " + positions,
        "ObjectBegin \"o\" Shape \"metaballs\" " + positions +
            " ObjectEnd Shape \"csg\" \"string operation\" \"union\" \"string operands\" [ \"o\" \"o\" ]"}) {
    EXPECT_EQ(messagesOf(shapes), "") << shapes;
    const LimitedWork limit(30 * 64 * 1e-7);
    expectRefused(messagesOf(shapes), shapes.starts_with(other) ? 4 : 3);
    EXPECT_EQ(messagesOf(shapes, 4), "") << shapes; // a picture with half of the pixels
  }
  const LimitedWork limit(30 * 64 * 1e-7);
  EXPECT_EQ(messagesOf(repeated(ball + other, 20)), "");
  EXPECT_EQ(messagesOf(object + repeated("Translate 1 0 0 " + instance, 40)), "");
}
