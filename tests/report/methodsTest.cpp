/** @file
 * Methods side by side: classes as fine as the claims of the methods, and figures against known pictures.
 */
#include "recurse/report/methods/methods.h"

#include <gtest/gtest.h>

#include "recurse/pathclasses/pathExpression.h"

using namespace recurse;

namespace {

Stills stillsOf(const std::vector<PathClass>& classes, const std::vector<float>& lights) {
  const StillsPlan plan = planStills(classes);
  Film film({0, 0, 4, 4}, plan.classes.size());
  std::vector<Rgb> values(plan.classes.size(), BLACK);
  for (size_t i = 0; i < lights.size(); ++i) values[i] = Rgb(lights[i]);
  for (size_t p = 0; p < 16; ++p) film.add(p, 0, 1, values.data(), BLACK);
  return makeStills(film, plan, 1);
}

} // namespace

TEST(MethodsReport, ClassesAreAsFineAsTheClaims) {
  const std::vector<std::string> claims = {"LD?E", "LD?S*E", "L(S|D)*DE", "LD?S*E | L(S|D)*DDS*E"};
  const std::vector<PathClass> fine = refineClasses(defaultStillClasses(), claims);
  EXPECT_GT(fine.size(), defaultStillClasses().size());
  std::vector<PathAutomaton> parts;
  for (const PathClass& c : fine) parts.push_back(PathAutomaton::compile(c.expression));
  EXPECT_TRUE(findOverlaps(parts).empty());
  EXPECT_TRUE(leftOver(PathAutomaton::compile("all"), parts).isEmpty());
  for (const std::string& claim : claims)
    for (size_t i = 0; i < fine.size(); ++i) {
      const PathAutomaton all = PathAutomaton::compile(claim);
      EXPECT_TRUE(parts[i].subsetOf(all) || parts[i].intersect(all).isEmpty()) << claim << fine[i].expression;
    }
  EXPECT_NO_THROW(planStills(fine));
}

TEST(MethodsReport, ManyPartsOfAClassHaveNamesForLayers) {
  std::vector<std::string> claims;
  for (int events = 1; events <= 60; ++events) claims.push_back("LD{" + std::to_string(events) + "}E");
  const std::vector<PathClass> fine = refineClasses({{"all", "all"}}, claims);
  ASSERT_EQ(fine.size(), 61u);
  EXPECT_EQ(fine[0].name, "all-a");
  EXPECT_EQ(fine[25].name, "all-z");
  EXPECT_EQ(fine[26].name, "all-aa");
  EXPECT_EQ(fine[52].name, "all-ba");
  EXPECT_NO_THROW(planStills(fine));
}

TEST(MethodsReport, ErrorOfItsOwnPathsAndWhatIsLeftOut) {
  MethodsReport report;
  report.classes = {{"direct", "LDE"}, {"two", "LDDE"}, {"rest", "all - (LDE|LDDE)"}};
  report.referenceA = stillsOf(report.classes, {3, 1, 4});
  report.referenceB = stillsOf(report.classes, {3, 1, 4});
  prepareReferences(report);
  MethodResult m;
  m.name = "m";
  m.claims = "LDE|LDDE";
  m.stills = stillsOf(report.classes, {3, 1.5f, 0});
  measureMethod(m, report);
  EXPECT_EQ(m.classIsClaimed, (std::vector<bool>{true, true, false}));
  EXPECT_NEAR(m.missing, 0.5, 1e-6);
  EXPECT_NEAR(m.own.meanRatio[ALL_CHANNELS], 4.5 / 4, 1e-6);
  EXPECT_NEAR(m.own.relMseNoiseFree[ALL_CHANNELS], 0.25 / 16.01, 1e-6);
  EXPECT_NEAR(m.whole.relMseNoiseFree[ALL_CHANNELS], 3.5 * 3.5 / 64.01, 1e-6);
  EXPECT_NEAR(m.classMeans[1], 1.5, 1e-6);
  MethodResult broken;
  broken.name = "broken";
  broken.claims = "LDE";
  broken.failure = "no light";
  measureMethod(broken, report);
  EXPECT_NEAR(broken.missing, 0.625, 1e-6);
  report.methods = {m, broken};
  EXPECT_NE(methodsTable(report).find("no picture: no light"), std::string::npos);
  EXPECT_NE(methodsPage(report).find("LDE|LDDE"), std::string::npos);
  EXPECT_GT(methodsSheet(report).width, 300);
}
