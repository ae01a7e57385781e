/** @file
 * The reference page names all directives of the parser and all declarations.
 */
#include "recurse/scene/directives/reference.h"
#include "sceneTesting.h"

using namespace recurse;

TEST(Reference, EveryDirectiveOfTheFormat) {
  const std::string page = directiveReference();
  for (const char* name : {"Film",
                           "Camera",
                           "PixelFilter",
                           "Sampler",
                           "Integrator",
                           "Accelerator",
                           "Option",
                           "ColorSpace",
                           "LookAt",
                           "Translate",
                           "Scale",
                           "Rotate",
                           "Transform",
                           "ConcatTransform",
                           "Identity",
                           "CoordinateSystem",
                           "CoordSysTransform",
                           "ReverseOrientation",
                           "TransformBegin",
                           "TransformEnd",
                           "AttributeBegin",
                           "AttributeEnd",
                           "Attribute",
                           "WorldBegin",
                           "ObjectBegin",
                           "ObjectEnd",
                           "ObjectInstance",
                           "Include",
                           "Import",
                           "Material",
                           "MakeNamedMaterial",
                           "NamedMaterial",
                           "Texture",
                           "Shape",
                           "LightSource",
                           "AreaLightSource",
                           "MediumInterface",
                           "MakeNamedMedium",
                           "ActiveTransform",
                           "TransformTimes",
                           "Animate",
                           "LightScale"})
    EXPECT_CONTAINS(page, "| `" + std::string(name) + "` |");
  const auto infos = directiveInfos();
  EXPECT_EQ(infos.size(), 42u);
  for (size_t i = 1; i < infos.size(); ++i) EXPECT_LT(infos[i - 1].name, infos[i].name);
  for (const DirectiveInfo& d : infos) EXPECT_FALSE(d.summary.empty());
  EXPECT_CONTAINS(page, "\"integer seed\"");
}

TEST(Reference, PlugIns) {
  PlugInInfo sphere;
  sphere.name = "sphere";
  sphere.summary = "Round.";
  sphere.parameters = {realParameter("radius", "1", "its radius | size").positive(),
                       stringParameter("mode", "a", "how").oneOf({"a", "b"}),
                       realParameter("need", "", "must be").require(),
                       spectrumParameter("c", "0.5", SpectrumKind::ALBEDO, "colour").withTexture(),
                       ignoredParameter(ParameterType::BOOLEAN, "alpha", "no reason")};
  const std::string page = plugInReference(std::vector<PlugInInfo>{sphere});
  EXPECT_CONTAINS(page, "### `sphere`\n\nRound.\n");
  EXPECT_CONTAINS(page, "| `\"float radius\"` | `1` | more than 0 | its radius \\| size |");
  EXPECT_CONTAINS(page, "| `\"string mode\"` | `a` | \"a\" \"b\" | how |");
  EXPECT_CONTAINS(page, "| required |");
  EXPECT_CONTAINS(page, "`\"rgb\\|spectrum\\|blackbody\\|float\\|texture c\"` | `0.5` | 0 to 1 |");
  EXPECT_CONTAINS(page, "Accepted without effect: no reason");
}
