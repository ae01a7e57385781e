/** @file
 * Parameter lists in files, their errors, and continuation after errors.
 */
#include "sceneTesting.h"

using namespace recurse;

namespace {

ParsedParameter only(const std::string& parameter) {
  const ParsedDirective d = parseParameterText("x", parameter);
  EXPECT_EQ(d.parameters.size(), 1u);
  return d.parameters.at(0);
}

std::string errorOf(const std::string& parameters) {
  try {
    parseParameterText("x", parameters);
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

} // namespace

TEST(Syntax, Values) {
  EXPECT_EQ(only("\"float a\" 2").numbers, std::vector<double>{2});
  EXPECT_EQ(only("\"float a\" [2]").numbers, std::vector<double>{2});
  EXPECT_EQ(only("\"float a\"[2 3]").numbers, (std::vector<double>{2, 3}));
  EXPECT_EQ(only("\"float a\" []").numbers.size(), 0u);
  EXPECT_EQ(only("\"string a\" \"b c\"").strings.at(0), "b c");
  EXPECT_EQ(only("\"string a\" [\"b\" \"c\"]").strings.size(), 2u);
  EXPECT_EQ(only("\"bool a\" [true false \"true\" \"false\"]").booleans,
            (std::vector<bool>{true, false, true, false}));
  EXPECT_TRUE(only("\"bool a\" true").booleans.at(0));
  EXPECT_EQ(only("\"spectrum a\" [400 1 700 2]").numbers.size(), 4u);
  EXPECT_EQ(only("\"spectrum a\" \"metal-Cu-eta\"").strings.at(0), "metal-Cu-eta");
  EXPECT_EQ(only("\"texture a\" \"t\"").strings.at(0), "t");
  EXPECT_EQ(only("\"rgb a\" [ .1 +.2 3e-1 ] # c").numbers, (std::vector<double>{.1, .2, .3}));
}

TEST(Syntax, Declarations) {
  for (const char* text :
       {"\"float radius\" 1", "\" float radius\" 1", "\"float   radius \" 1", "\"\tfloat\tradius\" 1"}) {
    EXPECT_EQ(only(text).type, "float") << text;
    EXPECT_EQ(only(text).name, "radius") << text;
  }
  EXPECT_CONTAINS(errorOf("\"radius\" 1"), "expected the type and name");
  EXPECT_CONTAINS(errorOf("\"\" 1"), "expected the type and name");
  EXPECT_CONTAINS(errorOf("\"flaot radius\" 1"), "did you mean 'float'?");
}

TEST(Syntax, ValueErrors) {
  EXPECT_CONTAINS(errorOf("\"float a\" \"b\""), "expected a number, found \"b\"");
  EXPECT_CONTAINS(errorOf("\"float a\" [1 2 x 4]"), ":1:16: error: expected a number, found 'x'");
  EXPECT_CONTAINS(errorOf("\"float a\" nan"), "not finite");
  EXPECT_CONTAINS(errorOf("\"float a\" [1 1e999]"), "not finite");
  EXPECT_CONTAINS(errorOf("\"string a\" 5"), "expected a string in quotes");
  EXPECT_CONTAINS(errorOf("\"bool a\" 1"), "expected true or false");
  EXPECT_CONTAINS(errorOf("\"bool a\" \"yes\""), "expected true or false");
  EXPECT_CONTAINS(errorOf("\"float a\""), "has no value");
  EXPECT_CONTAINS(errorOf("\"float a\" \"float b\" 1"), "\"a\" has no value");
  EXPECT_CONTAINS(errorOf("\"rgb a\" 1 2 3"), "need brackets");
  EXPECT_CONTAINS(errorOf("\"float a\" [1 2"), "not closed");
  EXPECT_CONTAINS(errorOf("\"float a\" [1 2 \"float b\" 3"), "not closed");
  EXPECT_CONTAINS(errorOf("\"spectrum a\" [400 \"x\"]"), "expected numbers");
  EXPECT_CONTAINS(errorOf("\"float a\" 1 ]"), "expected a parameter");
  EXPECT_CONTAINS(errorOf("\"string a\" \"C:\\dir\""), "unknown escape");
}

TEST(Syntax, SeveralErrorsInOneRun) {
  Diagnostics diagnostics;
  const SceneDescription s = parse("Cammera \"perspective\" \"float fov\" 45\n"
                                   "WorldBegin\n"
                                   "Shape \"a\" \"flaot r\" 1 \"float s\" [ x y ]\n"
                                   "Translate 1 2\n"
                                   "Shape 5\n"
                                   "Shape \"broken\n"
                                   "Shape \"good\" \"float r\" 1\n",
                                   diagnostics);
  const std::string text = diagnostics.format();
  EXPECT_EQ(errorCount(diagnostics), 6u) << text;
  EXPECT_CONTAINS(text, "test.pbrt:1:1: error: unknown directive 'Cammera'; did you mean Camera?");
  EXPECT_CONTAINS(text, "    Cammera \"perspective\" \"float fov\" 45\n    ^\n");
  EXPECT_CONTAINS(text, "test.pbrt:3:11: error: unknown parameter type 'flaot'");
  EXPECT_CONTAINS(text, "test.pbrt:3:35: error: expected a number, found 'x'");
  EXPECT_CONTAINS(text, "test.pbrt:5:1: error: Translate needs");
  EXPECT_CONTAINS(text, "test.pbrt:5:7: error: Shape needs a name");
  EXPECT_CONTAINS(text, "test.pbrt:6:7: error: this string has no closing quote");
  EXPECT_EQ(s.shapes.back().shape.type, "good");
}

TEST(Syntax, ErrorsAreLimited) {
  Diagnostics diagnostics;
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 1000; ++i) text += "AttributeEnd\n";
  parse(text, diagnostics);
  EXPECT_EQ(errorCount(diagnostics), 50u);
  EXPECT_CONTAINS(diagnostics.format(), "further errors are not shown");
}

TEST(Syntax, NotASceneAtAll) {
  EXPECT_CONTAINS(messages(std::string("\x89PNG\r\n\x1a\n\0\0\0", 11)), "unknown directive");
  EXPECT_CONTAINS(messages("\xff\xfeW"), "UTF-16");
  EXPECT_CONTAINS(messages("12 13"), "expected a directive, found '12'");
  EXPECT_CONTAINS(messages("\"a\""), "expected a directive");
  // Control characters do not reach the terminal.
  EXPECT_EQ(messages("WorldBegin \x1b[31m").find('\x1b'), std::string::npos);
}

TEST(Syntax, NoNewlineAtTheEnd) {
  EXPECT_EQ(parseGood("WorldBegin Shape \"a\" \"float r\" 1").shapes.at(0).shape.parameters.size(), 1u);
  EXPECT_EQ(parseGood("WorldBegin\r\nShape \"a\"\r\n").shapes.size(), 1u);
  EXPECT_EQ(parseGood("WorldBegin # comment").shapes.size(), 0u);
}
