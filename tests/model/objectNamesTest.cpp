/** @file
 * Names of objects: unique, and equal to the names in the scene file.
 */
#include <gtest/gtest.h>

#include "recurse/model/scene/scene.h"
#include "recurse/scene/directives/loader.h"

using namespace recurse;

namespace {

std::vector<std::string> uniqueNames(const std::vector<std::string>& given) {
  ObjectNames names;
  for (const std::string& name : given) names.add(name);
  std::vector<std::string> out;
  for (uint32_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(names.common(i), given[i]);
    out.push_back(names[i]);
  }
  return out;
}

using Names = std::vector<std::string>;

Names namesIn(const std::string& world) {
  Diagnostics diagnostics;
  const auto d = parseScene("Camera \"perspective\"\nWorldBegin\n" + world, "test.pbrt", ".", diagnostics);
  const std::unique_ptr<Scene> scene = buildScene(d, {}, diagnostics);
  EXPECT_TRUE(scene) << diagnostics.format();
  Names names;
  for (uint32_t i = 0; scene && i < scene->objects().size(); ++i) names.push_back(scene->objectName(i));
  return names;
}

} // namespace

TEST(ObjectNames, AreNumberedFromTheSecond) {
  EXPECT_EQ(uniqueNames({"tree", "ball", "tree", "tree", "ball"}),
            (Names{"tree", "ball", "tree.2", "tree.3", "ball.2"}));
}

TEST(ObjectNames, CopiesLeaveOutNumbersOfOtherNames) {
  EXPECT_EQ(uniqueNames({"tree", "tree", "tree.2"}), (Names{"tree", "tree.3", "tree.2"}));
  EXPECT_EQ(uniqueNames({"tree.4", "tree.2", "tree", "tree", "tree", "tree.2", "tree"}),
            (Names{"tree.4", "tree.2", "tree", "tree.3", "tree.5", "tree.2.2", "tree.6"}));
  EXPECT_EQ(uniqueNames({"a", "a", "a.02", "a.1", "a.x", "a.", "a.99999999999", "a.2x"}),
            (Names{"a", "a.2", "a.02", "a.1", "a.x", "a.", "a.99999999999", "a.2x"}));
}

TEST(ObjectNames, InstancesAreNamedAfterTheirObject) {
  const std::string objects = "ObjectBegin \"inner\" Shape \"sphere\" ObjectEnd "
                              "ObjectBegin \"outer\" Shape \"disk\" ObjectInstance \"inner\" ObjectEnd\n";
  EXPECT_EQ(namesIn(objects + "ObjectInstance \"outer\""), (Names{"inner", "outer"}));
  const std::string moving = "AttributeBegin ActiveTransform EndTime Translate 1 0 0 ActiveTransform All "
                             "ObjectInstance \"outer\" AttributeEnd\n";
  EXPECT_EQ(namesIn(objects + moving + moving), (Names{"outer", "outer.2"}));
}
