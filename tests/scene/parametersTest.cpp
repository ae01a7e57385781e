/** @file
 * Binding of parameters to declarations, and reading them.
 */
#include "recurse/scene/parameters/registry.h"
#include "sceneTesting.h"

using namespace recurse;

namespace {

struct Bound {
  Diagnostics diagnostics;
  Parameters parameters;
};

Bound bindText(const std::string& text, const std::vector<ParameterSpec>& specs, bool lenient = false) {
  Bound b;
  b.parameters = bindParameters(parseParameterText("thing", text), specs, b.diagnostics, lenient);
  return b;
}

Parameters good(const std::string& text, const std::vector<ParameterSpec>& specs) {
  Bound b = bindText(text, specs);
  EXPECT_EQ(b.diagnostics.all().size(), 0u) << b.diagnostics.format();
  return b.parameters;
}

std::string errorOf(const std::string& text, const ParameterSpec& spec) {
  const Bound b = bindText(text, {spec});
  return b.diagnostics.hasErrors() ? b.diagnostics.format() : "no error";
}

} // namespace

TEST(Parameters, GivenValues) {
  const Parameters p = good(
      R"("float r" 2 "integer n" [3] "bool b" true "string s" "x" "point3 p" [1 2 3] "point q" [4 5 6]
         "vector3 v" [1 0 0] "normal N" [0 0 1 0 1 0] "point2 uv" [0 1 2 3] "integer i" [0 1 2] "float f" [.5 1]
         "string ss" ["a" "b"] "rgb c" [.1 .2 .3])",
      {realParameter("r", "", ""), integerParameter("n", "", ""), booleanParameter("b", "", ""),
       stringParameter("s", "", ""), arrayParameter(ParameterType::POINT3, "p", 1, "", ""),
       arrayParameter(ParameterType::POINT3, "q", 1, "", ""),
       arrayParameter(ParameterType::VECTOR3, "v", 1, "", ""),
       arrayParameter(ParameterType::NORMAL, "N", 0, "", ""),
       arrayParameter(ParameterType::POINT2, "uv", 0, "", ""),
       arrayParameter(ParameterType::INTEGER, "i", 0, "", ""),
       arrayParameter(ParameterType::REAL, "f", 2, "", ""),
       arrayParameter(ParameterType::STRING, "ss", 0, "", ""),
       spectrumParameter("c", "", SpectrumKind::ALBEDO, "")});
  EXPECT_EQ(p.real("r"), 2);
  EXPECT_EQ(p.integer("n"), 3);
  EXPECT_EQ(p.real("n"), 3);
  EXPECT_TRUE(p.boolean("b"));
  EXPECT_EQ(p.string("s"), "x");
  EXPECT_EQ(p.vector3("p"), Vec3d(1, 2, 3));
  EXPECT_EQ(p.vector3("q"), Vec3d(4, 5, 6));
  EXPECT_EQ(p.vector3("v"), Vec3d(1, 0, 0));
  EXPECT_EQ(p.vector3s("N").at(1), Vec3d(0, 1, 0));
  EXPECT_EQ(p.vector2s("uv").at(1), Vec2d(2, 3));
  EXPECT_EQ(p.integers("i"), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(p.reals("f"), (std::vector<double>{.5, 1}));
  EXPECT_EQ(p.strings("ss"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(p.spectrum("c"), Rgbd(.1, .2, .3));
  EXPECT_TRUE(p.has("r"));
  EXPECT_TRUE(p.hasValue("r"));
  EXPECT_EQ(p.plugInName(), "thing");
}

TEST(Parameters, Defaults) {
  const Parameters p = good("", {realParameter("r", "1.5", ""), integerParameter("n", "-2", ""),
                                 booleanParameter("b", "true", ""), stringParameter("s", "a b.exr", ""),
                                 stringParameter("q", "\"quoted\"", ""), realParameter("none", "", ""),
                                 arrayParameter(ParameterType::POINT3, "p", 1, "0 0 1", ""),
                                 arrayParameter(ParameterType::REAL, "f", 4, "[ 0 1 0 1 ]", ""),
                                 spectrumParameter("grey", "0.5", SpectrumKind::ALBEDO, ""),
                                 spectrumParameter("rgb", "1 0.5 0", SpectrumKind::ALBEDO, ""),
                                 spectrumParameter("named", "metal-Cu-eta", SpectrumKind::UNBOUNDED, ""),
                                 spectrumParameter("quoted", "\"metal-Cu-eta\"", SpectrumKind::UNBOUNDED, ""),
                                 spectrumParameter("hot", "blackbody 6500", SpectrumKind::ILLUMINANT, "")});
  EXPECT_EQ(p.real("r"), 1.5);
  EXPECT_EQ(p.integer("n"), -2);
  EXPECT_TRUE(p.boolean("b"));
  EXPECT_EQ(p.string("s"), "a b.exr");
  EXPECT_EQ(p.string("q"), "quoted");
  EXPECT_EQ(p.vector3("p"), Vec3d(0, 0, 1));
  EXPECT_EQ(p.reals("f").size(), 4u);
  EXPECT_EQ(p.spectrum("grey"), Rgbd(.5));
  EXPECT_EQ(p.spectrum("rgb"), Rgbd(1, .5, 0));
  EXPECT_EQ(p.spectrum("named"), p.spectrum("quoted"));
  EXPECT_GT(p.spectrum("hot").r, 0);
  EXPECT_FALSE(p.has("r"));
  EXPECT_TRUE(p.hasValue("r"));
  EXPECT_FALSE(p.hasValue("none"));
  EXPECT_THROW(p.real("none"), SceneError);
  EXPECT_THROW(p.real("undeclared"), std::logic_error);
  EXPECT_THROW(p.string("r"), std::logic_error);
  EXPECT_THROW(bindText("", {realParameter("r", "abc", "")}), std::logic_error);
  EXPECT_THROW(bindText("", {realParameter("r", "2", "").range(0, 1)}), std::logic_error);
}

TEST(Parameters, UnknownNames) {
  const std::vector<ParameterSpec> specs = {realParameter("radius", "1", ""), realParameter("zmin", "1", "")};
  const Bound b = bindText("\"float raduis\" 2", specs);
  EXPECT_TRUE(b.diagnostics.hasErrors());
  EXPECT_CONTAINS(b.diagnostics.format(), "\"thing\" has no parameter \"raduis\"; did you mean \"radius\"?");
  EXPECT_CONTAINS(b.diagnostics.format(), "accepted: \"float radius\", \"float zmin\"");
  EXPECT_EQ(b.parameters.real("radius"), 1);
  const Bound lenient = bindText("\"float raduis\" 2", specs, true);
  EXPECT_FALSE(lenient.diagnostics.hasErrors());
  EXPECT_EQ(lenient.diagnostics.all().size(), 1u);
}

TEST(Parameters, Types) {
  EXPECT_CONTAINS(errorOf("\"integer r\" 2", realParameter("r", "", "")), "accepted: \"float r\"");
  EXPECT_CONTAINS(errorOf("\"float n\" 2", integerParameter("n", "", "")), "accepted: \"integer n\"");
  EXPECT_CONTAINS(errorOf("\"texture r\" \"t\"", realParameter("r", "", "")), "cannot be of type 'texture'");
  EXPECT_CONTAINS(
      errorOf("\"string c\" \"t\"", spectrumParameter("c", "", SpectrumKind::ALBEDO, "").withTexture()),
      "\"rgb|spectrum|blackbody|float|texture c\"");
  EXPECT_CONTAINS(errorOf("\"point2 p\" [1 2]", arrayParameter(ParameterType::POINT3, "p", 1, "", "")),
                  "point3 p");
  const Parameters p = good("\"texture r\" \"t\"", {realParameter("r", "1", "").withTexture()});
  EXPECT_EQ(p.texture("r"), "t");
  EXPECT_THROW(p.real("r"), SceneError);
  EXPECT_EQ(good("", {realParameter("r", "1", "").withTexture()}).texture("r"), "");
}

TEST(Parameters, NumbersAndRanges) {
  EXPECT_CONTAINS(errorOf("\"integer n\" 2.5", integerParameter("n", "", "")), "whole number");
  EXPECT_CONTAINS(errorOf("\"integer n\" 3e9", integerParameter("n", "", "")), "32 bits");
  EXPECT_EQ(good("\"integer n\" 1e3", {integerParameter("n", "", "")}).integer("n"), 1000);
  EXPECT_EQ(good("\"integer n\" -2147483648", {integerParameter("n", "", "")}).integer("n"), -2147483647 - 1);
  EXPECT_CONTAINS(errorOf("\"float r\" -1", realParameter("r", "", "").positive()), "accepted: more than 0");
  EXPECT_CONTAINS(errorOf("\"float r\" 0", realParameter("r", "", "").positive()), "out of range");
  EXPECT_CONTAINS(errorOf("\"float r\" 2", realParameter("r", "", "").range(0, 1)), "accepted: 0 to 1");
  EXPECT_EQ(errorOf("\"float r\" 1", realParameter("r", "", "").range(0, 1)), "no error");
  ParsedDirective handmade = parseParameterText("thing", "\"float r\" 1");
  handmade.parameters[0].numbers[0] = std::numeric_limits<double>::quiet_NaN();
  Diagnostics diagnostics;
  bindParameters(handmade, {realParameter("r", "", "")}, diagnostics, false);
  EXPECT_CONTAINS(diagnostics.format(), "not finite");
}

TEST(Parameters, ValuesThatCannotBeReadAreOneError) {
  for (const char* values : {"nan", "\"x\"", "[ 1 nan ]", "[ inf 1 2 ]"}) {
    Diagnostics diagnostics;
    const SceneDescription scene = parseScene(std::string("WorldBegin Shape \"s\" \"float r\" ") + values,
                                              "test.pbrt", ".", diagnostics);
    ASSERT_EQ(scene.shapes.size(), 1u);
    bindParameters(scene.shapes[0].shape, {realParameter("r", "", "")}, diagnostics, false);
    EXPECT_EQ(diagnostics.all().size(), 1u) << diagnostics.format();
  }
}

TEST(Parameters, PlaceOfTheWrongNumber) {
  const Bound b = bindText("\"integer i\" [ 1 2\n 3 -4 5 ]",
                           {arrayParameter(ParameterType::INTEGER, "i", 0, "", "").range(0, 9)});
  ASSERT_EQ(b.diagnostics.all().size(), 1u);
  EXPECT_EQ(b.diagnostics.all()[0].location.line, 2);
  EXPECT_EQ(b.diagnostics.all()[0].location.column, 4);
}

TEST(Parameters, Counts) {
  EXPECT_CONTAINS(errorOf("\"float r\" [1 2]", realParameter("r", "", "")), "2 values instead of 1");
  EXPECT_CONTAINS(errorOf("\"float r\" []", realParameter("r", "", "")), "0 values instead of 1");
  EXPECT_CONTAINS(errorOf("\"float f\" []", arrayParameter(ParameterType::REAL, "f", 0, "", "")),
                  "at least one");
  EXPECT_CONTAINS(errorOf("\"point3 p\" [1 2]", arrayParameter(ParameterType::POINT3, "p", 1, "", "")),
                  "multiple of 3");
  EXPECT_CONTAINS(
      errorOf("\"point3 p\" [1 2 3 4 5 6]", arrayParameter(ParameterType::POINT3, "p", 1, "", "")),
      "2 values instead of 1");
  EXPECT_CONTAINS(errorOf("\"string s\" [\"a\" \"b\"]", stringParameter("s", "", "")), "2 values");
  EXPECT_CONTAINS(errorOf("\"bool b\" []", booleanParameter("b", "", "")), "0 values");
  EXPECT_CONTAINS(errorOf("\"rgb c\" [1 1]", spectrumParameter("c", "", SpectrumKind::ALBEDO, "")),
                  "2 numbers");
  EXPECT_CONTAINS(errorOf("\"texture r\" [\"a\" \"b\"]", realParameter("r", "", "").withTexture()),
                  "2 values");
}

TEST(Parameters, ChoicesAndRequired) {
  const ParameterSpec choice = stringParameter("mode", "one", "").oneOf({"one", "two"});
  EXPECT_CONTAINS(errorOf("\"string mode\" \"tow\"", choice), "did you mean \"two\"?");
  EXPECT_CONTAINS(errorOf("\"string mode\" \"three\"", choice), "accepted: \"one\" \"two\"");
  EXPECT_CONTAINS(errorOf("", realParameter("r", "", "").require()), "needs the parameter \"r\"");
  EXPECT_EQ(errorOf("\"float r\" 1", realParameter("r", "", "").require()), "no error");
}

TEST(Parameters, IgnoredOnesAreTaken) {
  EXPECT_EQ(errorOf("\"bool a\" true", ignoredParameter(ParameterType::BOOLEAN, "a", "why")), "no error");
  EXPECT_EQ(errorOf("\"float a\" [1 2 3]", ignoredParameter(ParameterType::REAL, "a", "why")), "no error");
}

TEST(Parameters, OfDuplicatesTheLastCounts) {
  const Bound b = bindText("\"float r\" 1 \"float r\" 2", {realParameter("r", "", "")});
  EXPECT_FALSE(b.diagnostics.hasErrors());
  EXPECT_CONTAINS(b.diagnostics.format(), "given twice");
  EXPECT_EQ(b.parameters.real("r"), 2);
}

TEST(Parameters, Colours) {
  const ParameterSpec albedo = spectrumParameter("c", "", SpectrumKind::ALBEDO, "");
  const ParameterSpec free = spectrumParameter("c", "", SpectrumKind::UNBOUNDED, "");
  EXPECT_CONTAINS(errorOf("\"rgb c\" [1.5 0 0]", albedo), "accepted: 0 to 1");
  EXPECT_CONTAINS(errorOf("\"rgb c\" [-1 0 0]", free), "accepted: at least 0");
  EXPECT_EQ(errorOf("\"rgb c\" [3 0 0]", free), "no error");
  EXPECT_EQ(good("\"float c\" 1.5", {free}).spectrum("c"), Rgbd(1.5));
  EXPECT_CONTAINS(errorOf("\"float c\" 1.5", albedo), "out of range");
  EXPECT_CONTAINS(errorOf("\"spectrum c\" [400 1 500 2]", albedo), "out of range");
  EXPECT_THROW(good("\"spectrum c\" \"metal-Ag-k\"", {albedo}).spectrum("c"), SceneError);
  EXPECT_GT(good("\"spectrum c\" \"metal-Ag-k\"", {free}).spectrum("c").r, 1);
  EXPECT_CONTAINS(errorOf("\"spectrum c\" [400 1 500]", albedo), "a value is missing");
  EXPECT_CONTAINS(errorOf("\"spectrum c\" [500 1 400 1]", albedo), "must increase");
  EXPECT_CONTAINS(errorOf("\"spectrum c\" []", albedo), "0 values");
  EXPECT_CONTAINS(errorOf("\"blackbody c\" [5500 -2]", free), "must not be negative");
  EXPECT_CONTAINS(errorOf("\"blackbody c\" -5", free), "must be positive");
  EXPECT_EQ(good("\"spectrum c\" [400 .25 700 .25]", {albedo}).spectrum("c"), Rgbd(.25));
  try {
    good("\"spectrum c\" \"metal-Au-eeta\"", {free}).spectrum("c");
    FAIL();
  } catch (const SceneError& e) {
    EXPECT_CONTAINS(std::string(e.what()), "did you mean \"metal-Au-eta\"?");
    EXPECT_CONTAINS(std::string(e.what()), "glass-BK7");
  }
}

TEST(Parameters, BlackbodiesOfOldFilesHaveAScale) {
  const ParameterSpec spec = spectrumParameter("c", "", SpectrumKind::ILLUMINANT, "");
  const Bound scaled = bindText("\"blackbody c\" [5500 2]", {spec});
  EXPECT_FALSE(scaled.diagnostics.hasErrors()) << scaled.diagnostics.format();
  EXPECT_CONTAINS(scaled.diagnostics.format(), "a temperature and a scale, as in pbrt-v3");
  EXPECT_EQ(scaled.parameters.spectrum("c"), 2.0 * good("\"blackbody c\" 5500", {spec}).spectrum("c"));
}

TEST(Parameters, ColourArrays) {
  const ParameterSpec many = [] {
    ParameterSpec s = spectrumParameter("c", "", SpectrumKind::UNBOUNDED, "");
    s.count = 0;
    return s;
  }();
  EXPECT_EQ(good("\"rgb c\" [1 2 3 4 5 6]", {many}).spectra("c").at(1), Rgbd(4, 5, 6));
  EXPECT_EQ(good("\"spectrum c\" [\"metal-Cu-eta\" \"metal-Cu-k\"]", {many}).spectra("c").size(), 2u);
}

TEST(Parameters, SpectrumFiles) {
  const TemporaryDirectory d;
  d.write("grey.spd", "# wavelength value\n400 .5\n500 .5\n");
  d.write("bad.spd", "400 x\n");
  d.write("bright.spd", "400 .5\n500 1.5\n");
  const auto spectrumOf = [&](const std::string& name, SpectrumKind kind) {
    ParsedDirective directive = parseParameterText("thing", "\"spectrum c\" \"" + name + "\"");
    directive.directory = d.path();
    Diagnostics diagnostics;
    return bindParameters(directive, {spectrumParameter("c", "", kind, "")}, diagnostics, false)
        .spectrum("c");
  };
  EXPECT_EQ(spectrumOf("grey.spd", SpectrumKind::ALBEDO), Rgbd(.5));
  EXPECT_THROW(spectrumOf("bad.spd", SpectrumKind::ALBEDO), SceneError);
  EXPECT_THROW(spectrumOf("none.spd", SpectrumKind::ALBEDO), SceneError);
  EXPECT_THROW(spectrumOf("bright.spd", SpectrumKind::ALBEDO), SceneError);
  EXPECT_NO_THROW(spectrumOf("bright.spd", SpectrumKind::UNBOUNDED));
}

TEST(Parameters, FailPointsAtTheParameter) {
  const Parameters p = good("\"float r\" 2", {realParameter("r", "", ""), realParameter("s", "1", "")});
  try {
    p.fail("r", "too round", "edges");
  } catch (const SceneError& e) {
    EXPECT_EQ(e.diagnostics().at(0).location.column, 11);
    EXPECT_EQ(e.diagnostics().at(0).accepted, "edges");
  }
  EXPECT_EQ(p.location("s").column, p.location().column);
}

TEST(Registry, MakesOrReports) {
  struct Thing {
    double r;
  };
  Registry<Thing, int> registry("Shape");
  registry.add({{"sphere", "Round.", {realParameter("radius", "1", "").positive()}, {}},
                [](const Parameters& p, const int& factor) {
                  if (p.real("radius") > 100) p.fail("radius", "too large for this test");
                  return std::make_unique<Thing>(Thing{p.real("radius") * factor});
                }});
  Diagnostics diagnostics;
  EXPECT_EQ(registry.make(parseParameterText("sphere", "\"float radius\" 2"), 3, diagnostics)->r, 6);
  EXPECT_FALSE(diagnostics.hasErrors());
  EXPECT_EQ(registry.make(parseParameterText("sphere", "\"float radius\" 200"), 3, diagnostics), nullptr);
  EXPECT_EQ(registry.make(parseParameterText("sphere", "\"float radius\" 0"), 3, diagnostics), nullptr);
  EXPECT_EQ(registry.make(parseParameterText("shpere", ""), 3, diagnostics), nullptr);
  EXPECT_EQ(registry.make(parseParameterText("nurbs", ""), 3, diagnostics), nullptr);
  const std::string text = diagnostics.format();
  EXPECT_CONTAINS(text, "too large for this test");
  EXPECT_CONTAINS(text, "out of range");
  EXPECT_CONTAINS(text, "unknown Shape \"shpere\"; did you mean \"sphere\"?");
  EXPECT_CONTAINS(text, "pbrt-v3 had it");
}

TEST(Registry, WarningsOfAMakerThatFailsAreReportedBeforeItsError) {
  struct Thing {};
  Registry<Thing, int> registry("Shape");
  registry.add({{"sphere", "Round.", {realParameter("radius", "1", "")}, {}},
                [](const Parameters& p, const int&) -> std::unique_ptr<Thing> {
                  p.warn("radius", "unusual for this test");
                  p.fail("radius", "too large for this test");
                }});
  Diagnostics diagnostics;
  EXPECT_EQ(registry.make(parseParameterText("sphere", "\"float radius\" 2"), 0, diagnostics), nullptr);
  ASSERT_EQ(diagnostics.all().size(), 2u) << diagnostics.format();
  EXPECT_EQ(diagnostics.all()[0].severity, Severity::WARNING);
  EXPECT_EQ(diagnostics.all()[0].message, "unusual for this test");
  EXPECT_EQ(diagnostics.all()[1].severity, Severity::ERROR);
}
