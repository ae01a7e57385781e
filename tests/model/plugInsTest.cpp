/** @file
 * Properties of every registered plug-in of any kind; and pixel filters.
 */
#include "model/bsdfTesting.h"
#include "model/shapeTesting.h"
#include "recurse/scene/parameters/otherNames.h"

using namespace recurse;
using namespace recurse::testing;

TEST(PlugIns, EveryExampleCanBeMade) {
  const auto check = [](const auto& registry, const auto& context) {
    for (const auto& entry : registry.entries()) {
      EXPECT_FALSE(entry.summary.empty()) << entry.name;
      for (const ParameterSpec& p : entry.parameters)
        EXPECT_FALSE(p.description.empty()) << entry.name << " " << p.name;
      for (const std::string& example : entry.examples) {
        Diagnostics diagnostics;
        EXPECT_TRUE(registry.make(parseParameterText(entry.name, example), context, diagnostics))
            << registry.kind() << " " << entry.name << " " << example << "\n"
            << diagnostics.format();
      }
    }
  };
  const PlugIns& all = plugIns();
  const NamedMaterials named;
  check(all.materials, named.context());
  CameraContext camera;
  camera.width = camera.height = 16;
  check(all.shapes, ShapeContext{.shapes = testObjects()});
  check(all.lights, LightContext{});
  check(all.media, MediumContext{});
  check(all.phaseFunctions, NoContext{});
  check(all.cameras, camera);
  check(all.filters, NoContext{});
  check(all.films, NoContext{});
  check(all.samplers, NoContext{});
  check(all.accelerators, NoContext{});
  check(all.toneMaps, NoContext{});
  Diagnostics diagnostics;
  const auto sphere = all.shapes.make(parseParameterText("sphere", ""), {}, diagnostics);
  check(all.areaLights, AreaLightContext{*sphere});
}

TEST(OtherNames, MeanPlugInsThatExistAndAreNoNamesOfTheirKind) {
  const PlugIns& all = plugIns();
  const auto check = [](const auto& registry, size_t& meanings) {
    for (const OtherName& other : otherNames())
      for (const PlugInName& meant : other.meant) {
        if (meant.kind != registry.kind()) continue;
        ++meanings;
        EXPECT_TRUE(registry.find(meant.name)) << other.word << ": " << meant.kind << " " << meant.name;
        EXPECT_FALSE(registry.find(other.word)) << other.word;
        EXPECT_EQ(likelyNames(meant.kind, other.word, registry.names()).empty(), false) << other.word;
      }
  };
  size_t found = 0, listed = 0;
  check(all.films, found);
  check(all.cameras, found);
  check(all.filters, found);
  check(all.samplers, found);
  check(all.integrators, found);
  check(all.shapes, found);
  check(all.imports, found);
  check(all.materials, found);
  check(all.textures, found);
  check(all.lights, found);
  check(all.areaLights, found);
  check(all.media, found);
  check(all.phaseFunctions, found);
  std::string last;
  for (const OtherName& other : otherNames()) {
    listed += other.meant.size();
    EXPECT_LT(last, other.word) << "the table is sorted";
    last = other.word;
  }
  EXPECT_EQ(found, listed) << "a kind is misspelt";
}

TEST(OtherNames, ComeBeforeMisspellings) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(likelyNames("Material", "Matte", {"diffuse", "mate"}), (Names{"diffuse", "mate"}));
  EXPECT_EQ(likelyNames("Material", "difuse", {"diffuse"}), Names{"diffuse"});
  EXPECT_EQ(likelyNames("Shape", "matte", {"sphere"}), Names{});
}

TEST(Filters, SamplesHaveTheFiltersMoments) {
  // Weighted samples must have total weight 1, mean 0, and be within the radius.
  for (const auto& entry : plugIns().filters.entries()) {
    Diagnostics diagnostics;
    const auto filter = plugIns().filters.make(parseParameterText(entry.name, ""), {}, diagnostics);
    double weight = 0, x = 0, y = 0;
    constexpr uint32_t N = 1 << 16;
    for (uint32_t i = 0; i < N; ++i) {
      Sampler sampler(1, 1, i);
      const Filter::Sample s = filter->sample(sampler.next2D());
      weight += double(s.weight) / N;
      x += double(s.weight * s.offset.x) / N;
      y += double(s.weight * s.offset.y) / N;
      ASSERT_LE(std::abs(s.offset.x), filter->radius().x * 1.0001f) << entry.name;
    }
    EXPECT_NEAR(weight, 1, 2e-3) << entry.name;
    EXPECT_NEAR(x, 0, 2e-3) << entry.name;
    EXPECT_NEAR(y, 0, 2e-3) << entry.name;
  }
}
