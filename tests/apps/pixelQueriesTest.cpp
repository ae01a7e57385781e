/** @file
 * Queries for pixels of a running render.
 */
#include <nlohmann/json.hpp>

#include "apps/view/pixelQueries.h"
#include "program.h"
#include "recurse/core/io/error.h"
#include "sceneRendering.h"

namespace {

using recurse::apps::PixelQueries;

/** RenderPause of a render whose integrator has shot its photons. */
class PauseOfPhotons : public recurse::RenderPause {
 public:
  PauseOfPhotons(const recurse::Scene& scene, const recurse::PathClasses& classes)
      : method(recurse::testing::integratorFrom("photonmap",
                                                "\"integer photons\" 1000 \"string direct\" \"photons\"")) {
    method->prepare(scene, classes);
    method->forward(scene, classes, {.seed = 1}, {});
  }
  const recurse::Integrator& integrator() const override { return *method; }
  void record(int, int, int64_t, recurse::PathRecorder&) const override { onRecord(); }

  std::function<void()> onRecord = [] {};

 private:
  std::unique_ptr<recurse::Integrator> method;
};

/** Queries for a floor under a lamp. */
class PixelQuestions : public ::testing::Test {
 protected:
  const std::shared_ptr<const recurse::Scene> scene = recurse::testing::sceneFrom(
      recurse::testing::view(8, 8, "0 0 5  0 0 0  0 1 0", recurse::testing::perspective(40)) +
      "LightSource \"point\" \"point3 from\" [ 0 0 1 ] \"rgb I\" [ 2 2 2 ]\nMaterial \"diffuse\"\n"
      "Shape \"bilinearmesh\" \"point3 P\" [ -2 -2 0  2 -2 0  -2 2 0  2 2 0 ]\n");
  const recurse::PathClasses classes{{{"all", "all"}}};
  PixelQueries queries{scene, classes, "floor", "photons", -1, 1};
  PauseOfPhotons pause{*scene, classes};
  const recurse::Vec3f below = recurse::Vec3f(0) - recurse::Vec3f(scene->origin()); ///< the lamp

  std::string reference() { return queries.reference(below, {0, 0, 1}); }
};

template <class Work> std::string errorOf(const Work& work) {
  try {
    work();
  } catch (const recurse::Error& error) {
    return error.what();
  }
  return "";
}

} // namespace

TEST_F(PixelQuestions, AFailureIsTheAnswer) {
  const recurse::Image picture(8, 8, {"R", "G", "B"});
  EXPECT_EQ(queries.page(picture), "");
  queries.ask(3, 4);
  pause.onRecord = [] { throw std::runtime_error("no memory for it"); };
  queries.answer(pause);
  EXPECT_TRUE(queries.question().isAnswered);
  EXPECT_FALSE(queries.isAsked());
  EXPECT_NE(errorOf([&] { queries.page(picture); }).find("no memory for it"), std::string::npos);
  queries.ask(3, 4);
  pause.onRecord = [] {};
  queries.answer(pause);
  EXPECT_GT(queries.page(picture).size(), 1000u);
}

TEST_F(PixelQuestions, TakeAFiftiethOfTheTime) {
  queries.ask(3, 4);
  EXPECT_TRUE(queries.isAsked());
  pause.onRecord = [] { programTesting::sleepSeconds(0.02); };
  queries.answer(pause);
  const auto end = std::chrono::steady_clock::now();
  queries.ask(4, 4);
  EXPECT_FALSE(queries.isAsked());
  double passed = 0;
  while (!queries.isAsked() && passed < 30) {
    programTesting::sleepSeconds(0.01);
    passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - end).count();
  }
  EXPECT_GE(passed, 0.9);
  EXPECT_LT(passed, 30);
}

TEST_F(PixelQuestions, ReferencesEndWithTheRender) {
  EXPECT_NE(errorOf([&] { reference(); }), ""); // no photons yet
  queries.ask(3, 4);
  queries.answer(pause);
  const nlohmann::json found = nlohmann::json::parse(reference());
  EXPECT_NEAR(found["irradiance"][1].get<double>(), 2, 0.01); // I / d²
  EXPECT_GT(found["samples"].get<int>(), 1);
  queries.stop();
  EXPECT_EQ(errorOf([&] { reference(); }), "the render has ended");
}
