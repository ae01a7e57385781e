/** @file
 * Path expressions with names of lights and surfaces: their language against std::regex, walks cut at every
 * vertex, errors; and renders: sums over names, and the light of each lamp against a scene with this lamp
 * alone.
 */
#include "transport/classRendering.h"

#include <regex>
#include <set>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/stills/stills.h"
#include "recurse/scene/directives/loader.h"
#include "recurse/transport/integrator/sceneNames.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Lights: a, b, both names, none. Surfaces: objects floor, wall, none, by materials wood, none. */
const PathNames NAMES = {{{"a"}, {"b"}, {"a", "b"}, {}}, {{"floor"}, {"wall", "wall.2"}, {}}, {{"wood"}, {}}};

/** Event of a word: one letter for each pair of event and surface. */
struct Event {
  PathEvent event;
  size_t object, material;
};

char lightLetter(size_t light) { return char('0' + light); }
char eventLetter(const Event& e) {
  if (e.event == PathEvent::V) return 'v';
  return char((e.event == PathEvent::S ? 'A' : 'a') + 2 * e.object + e.material);
}

/** Expressions, with equivalent regular expressions over the letters above. */
const std::vector<std::pair<std::string, std::string>> EXPRESSIONS = {
    {"L'a'.*E", "[02][A-Fa-fv]*"},
    {"L'b'DE", "[12][a-f]"},
    {"[L'a'L'b']S*D'floor'E", "[012][A-F]*[ab]"},
    {"LD'wall'DE", "[0-3][cd][a-f]"},
    {"L.*D'wood'.*E", "[0-3][A-Fa-fv]*[ace][A-Fa-fv]*"},
    {"L[S'floor'D'wall.2']+E", "[0-3][ABcd]+"},
    {"L[^D'floor']*E", "[0-3][A-Fc-fv]*"},
    {"!L'a'.*E", "[13][A-Fa-fv]*"},
    {"direct & L'a'.*D'wood'E", "[02][ace]"},
    {"all - (L'a'.*E | L.*S'floor'.*E)", "[13][C-Fa-fv]*"},
    {"LS'wood'{2}VE", "[0-3][ACE]{2}v"},
};

const std::vector<Event>& allEvents() {
  static const std::vector<Event> events = [] {
    std::vector<Event> out = {{PathEvent::V, 0, 0}};
    for (const PathEvent e : {PathEvent::S, PathEvent::D})
      for (size_t object = 0; object < NAMES.objects.size(); ++object)
        for (size_t material = 0; material < NAMES.materials.size(); ++material)
          out.push_back({e, object, material});
    return out;
  }();
  return events;
}

/** Calls visit(events) for each word of up to `longest` events. */
template <class Visit> void forAllEvents(size_t longest, const Visit& visit) {
  std::vector<Event> events;
  const std::function<void()> extend = [&] {
    visit(events);
    if (events.size() == longest) return;
    for (const Event& e : allEvents()) {
      events.push_back(e);
      extend();
      events.pop_back();
    }
  };
  extend();
}

/** Disjoint classes, and `all`. */
std::vector<PathClass> withAll(std::vector<PathClass> classes) {
  classes.push_back({"total", "all"});
  return classes;
}

/** Expects that in every pixel all layers before the last add up to the last. */
void expectSums(const Film& film, const std::string& what) {
  const size_t total = film.layerCount() - 1;
  double light = 0;
  for (size_t p = 0; p < film.bounds().area(); ++p)
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (size_t layer = 0; layer < total; ++layer) sum += double(film.value(p, layer)[c]);
      const double whole = double(film.value(p, total)[c]);
      ASSERT_NEAR(sum, whole, 1e-5 * whole) << what << " pixel " << p;
      light += whole;
    }
  EXPECT_GT(light, 0) << what;
}

/** A room with a floor, a wall, a mirror, a pane of glass in front of a lamp, and lamps of all kinds, of
 * which `lamps` are switched on. */
std::string roomOfLamps(int size, const std::string& lamps = "kbsi") {
  const auto lamp = [&](char which, const std::string& text) {
    return lamps.find(which) == std::string::npos ? std::string() : text;
  };
  return view(size, "0 -5 1.6  0 0 .8  0 0 1", 45) +
         R"(
MakeNamedMaterial "oak" "string type" "diffuse" "rgb reflectance" [ .7 .5 .3 ]
NamedMaterial "oak"
Shape "bilinearmesh" "point3 P" [ -2 -2 0  2 -2 0  -2 2 0  2 2 0 ] "string name" "floor"
Material "diffuse" "rgb reflectance" [ .5 .6 .7 ]
Shape "bilinearmesh" "point3 P" [ -2 2 0  2 2 0  -2 2 3  2 2 3 ] "string name" "wall"
Material "conductor" "rgb reflectance" [ .9 .9 .9 ]
Shape "bilinearmesh" "point3 P" [ -2 -2 0  -2 2 0  -2 -2 3  -2 2 3 ] "string name" "mirror"
Material "thindielectric"
Shape "bilinearmesh" "point3 P" [ .3 -.8 2  1.5 -.8 2  .3 .8 2  1.5 .8 2 ] "string name" "pane"
AttributeBegin
NamedMaterial "oak"
ObjectBegin "ball"
Shape "sphere" "float radius" .3
ObjectEnd
Translate .3 .2 .3
ObjectInstance "ball"
Translate .9 .3 0
ObjectInstance "ball"
AttributeEnd
AttributeBegin
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
)" + lamp('k', R"(AreaLightSource "diffuse" "rgb L" [ 9 8 7 ] "string name" "key")") +
         R"(
Shape "bilinearmesh" "point3 P" [ .5 -.3 2.4  .5 .3 2.4  1.1 -.3 2.4  1.1 .3 2.4 ]
AttributeEnd
AttributeBegin
Material "diffuse" "rgb reflectance" [ .2 .2 .2 ]
Translate -1 0 .7
)" + lamp('b', R"(AreaLightSource "diffuse" "rgb L" [ 3 6 3 ])") +
         R"(
Shape "sphere" "float radius" .2 "string name" "bulb"
AttributeEnd
)" + lamp('s', R"(
LightSource "spot" "point3 from" [ 0 -1 2.6 ] "point3 to" [ 0 1 .5 ] "rgb I" [ 6 5 4 ] "float coneangle" 40
)") + lamp('i', R"(
LightSource "infinite" "rgb L" [ .2 .25 .4 ] "string name" "Sky's glow"
)");
}

/** Integrators that render all paths, each with few photons. */
const std::vector<Way>& completeWays() {
  static const std::vector<Way> ways = {
      {"photonmap", "\"integer photons\" 4000"},
      {"photonmap", "\"integer photons\" 4000 \"string direct\" \"photons\""},
      {"photonmap", "\"integer photons\" 4000 \"bool causticsonly\" true"},
      {"simplephotonmap", "\"integer photons\" 4000"},
      {"simplepath", ""},
      {"path", ""},
      {"bdpt", ""},
      {"vcm", ""}};
  return ways;
}

} // namespace

TEST(LightGroups, ExpressionsAgreeWithRegularExpressions) {
  std::vector<PathClass> classes;
  std::vector<std::regex> regexes;
  for (const auto& [expression, regex] : EXPRESSIONS) {
    classes.push_back({"c" + std::to_string(classes.size()), expression});
    regexes.emplace_back(regex);
  }
  const PathClasses compiled(classes, NAMES);
  size_t accepted = 0;
  forAllEvents(3, [&](const std::vector<Event>& events) {
    for (size_t light = 0; light < NAMES.lights.size(); ++light) {
      std::string word(1, lightLetter(light));
      for (const Event& e : events) word += eventLetter(e);
      LayerMask expected = 0;
      for (size_t i = 0; i < regexes.size(); ++i)
        if (std::regex_match(word, regexes[i])) expected |= LayerMask(1) << i;
      accepted += expected != 0;
      std::vector<LightState> states = {compiled.lightStart(light)};
      const auto kind = [&](const Event& e) { return compiled.surfaceKind(e.object, e.material); };
      for (const Event& e : events) states.push_back(compiled.step(states.back(), e.event, kind(e)));
      CameraState eye = compiled.cameraStart();
      for (size_t cut = events.size();; --cut) {
        ASSERT_EQ(compiled.join(states[cut], eye), expected) << word << " cut at " << cut;
        if (cut == 0) break;
        eye = compiled.step(eye, events[cut - 1].event, kind(events[cut - 1]));
      }
    }
  });
  EXPECT_GT(accepted, 1000u);
}

TEST(LightGroups, LitVerticesAreThoseThatSomeLightReaches) {
  const PathClasses classes({{"c", "L'a'S'floor'DE"}, {"d", "L'b'DDE"}}, NAMES);
  const SurfaceKind any = classes.surfaceKind(2, 1);
  const CameraState once = classes.step(classes.cameraStart(), PathEvent::D, any);
  EXPECT_FALSE(classes.isLit(once, false));
  EXPECT_TRUE(classes.isLit(once, true));
  EXPECT_TRUE(classes.isLit(classes.step(once, PathEvent::D, any), false));
}

TEST(LightGroups, NamesThatTheSceneLacksAreErrorsWithSuggestions) {
  const auto message = [](const std::string& expression) {
    try {
      PathAutomaton::compile(expression, PathAutomaton::Empty::REFUSED, &NAMES);
    } catch (const Error& e) {
      EXPECT_EQ(e.status(), ExitStatus::BAD_USAGE);
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(message("LSD'flor'E"), "path expression, column 4: the scene has no surface named 'flor'\n"
                                   "  LSD'flor'E\n     ^\n  accepted: 'floor', ...");
  EXPECT_NE(message("L'floor'E").find("no light named 'floor': it is a surface"), std::string::npos);
  EXPECT_NE(message("LS'a'E").find("no surface named 'a': it is a light"), std::string::npos);
  EXPECT_NE(message("L'c'E").find("accepted: 'a', 'b'"), std::string::npos) << message("L'c'E");
  EXPECT_NE(message("LV'a'E").find("column 3: V and E have no names"), std::string::npos);
  EXPECT_NE(message("LD'floorE").find("column 3: this name has no end"), std::string::npos);
  EXPECT_NE(message("L('a')E").find("column 3: a name has no letter before it"), std::string::npos);
  EXPECT_THROW(PathClasses(std::vector<PathClass>{{"c", "L'a'E"}}), Error) << "names without a scene";
}

TEST(LightGroups, SetsKnowNamesInTheirAlgebra) {
  const std::vector<PathAutomaton> sets =
      PathAutomaton::compileAll({{"a", "L'a'.*E"}, {"b", "L'b'.*E"}, {"none", "all - [L'a'L'b'].*E"}},
                                PathAutomaton::Empty::REFUSED, &NAMES);
  ASSERT_EQ(findOverlaps(sets).size(), 1u);
  EXPECT_EQ(findOverlaps(sets).front().example, "L'a+b'E");
  EXPECT_TRUE(leftOver(PathAutomaton::compile("all"), sets).isEmpty());
  EXPECT_TRUE(sets[0].accepts("L'a'DE"));
  EXPECT_FALSE(sets[0].accepts("L'b'DE"));
  EXPECT_TRUE(sets[2].accepts("LDE"));
  EXPECT_EQ(sets[0].exampleWords(1, 2), (std::vector<std::string>{"L'a'E", "L'a+b'E", "L'a'SE", "L'a'DE"}));
}

TEST(LightGroups, LampsHaveNamesOrNumbers) {
  const auto scene = sceneFrom(roomOfLamps(8));
  std::vector<std::string> names;
  for (const LampGroup& lamp : lampGroups(*scene)) names.push_back(lamp.name);
  EXPECT_EQ(names, (std::vector<std::string>{"key", "bulb", "light-3", "Sky's glow"}));
  const std::vector<PathClass> classes = classesByLight(lampGroups(*scene));
  ASSERT_EQ(classes.size(), 4u);
  EXPECT_EQ(classes[3].name, "Sky-s-glow");
  EXPECT_EQ(classes[3].expression, "L'Sky''s glow'.*E");
  const PathNames all = pathNames(*scene);
  const StillsPlan plan = planStills(classes, &all);
  EXPECT_TRUE(plan.remarks.empty());
  EXPECT_EQ(plan.classes.size(), 4u);
}

TEST(LightGroups, LampsOfOneNameOrOneShapeAreOne) {
  const auto scene = sceneFrom(view(8, "0 0 5  0 0 0  0 1 0", 40) + R"(
LightSource "point" "string name" "chain"
LightSource "point" "point3 from" [ 1 0 0 ] "string name" "chain"
ObjectBegin "lamp"
AreaLightSource "diffuse"
Shape "sphere"
ObjectEnd
ObjectInstance "lamp"
Translate 3 0 0
ObjectInstance "lamp"
)");
  EXPECT_EQ(scene->lights().size(), 4u);
  const std::vector<LampGroup> lamps = lampGroups(*scene);
  ASSERT_EQ(lamps.size(), 2u);
  EXPECT_EQ(lamps[0].name, "light-1");
  EXPECT_EQ(lamps[1].name, "chain");
}

TEST(LightGroups, WeakestOfManyLampsShareALayer) {
  std::vector<LampGroup> lamps;
  for (int i = 0; i < 100; ++i) lamps.push_back({"lamp" + std::to_string(i), "", double(i)});
  const std::vector<PathClass> classes = classesByLight(lamps);
  EXPECT_LE(classes.size(), 62u);
  EXPECT_GE(classes.size(), 60u);
  EXPECT_EQ(classes.front().name, "lamp" + std::to_string(100 - int(classes.size()) + 1));
  EXPECT_EQ(classes.back().name, "other-lights");
  PathNames names{{}, {{}}, {{}}};
  for (const LampGroup& lamp : lamps) names.lights.push_back({lamp.name});
  const StillsPlan plan = planStills(classes, &names);
  EXPECT_EQ(plan.classes.size(), classes.size());
  EXPECT_NO_THROW(PathClasses(plan.classes, names));
}

TEST(LightGroups, EqualLampsAndManyMediaGetLayersToo) {
  std::vector<LampGroup> bulbs, media;
  for (int i = 0; i < 100; ++i) {
    bulbs.push_back({"bulb" + std::to_string(i), "", 1});
    media.push_back({"fire" + std::to_string(i), "", 0, true});
  }
  for (const std::vector<LampGroup>& lamps : {bulbs, media}) {
    const std::vector<PathClass> classes = classesByLight(lamps);
    EXPECT_LE(classes.size(), 62u);
    EXPECT_GE(classes.size(), 60u);
    EXPECT_EQ(classes.front().name, lamps.front().name);
    EXPECT_EQ(classes.back().name, "other-lights");
  }
}

TEST(LightGroups, LayersOfClassesAndLampsHaveDistinctNames) {
  const std::vector<PathClass> classes =
      classesByLight({{"hall", "", 1}, {"hall-Low", "", 1}, {"hall*low", "", 1}},
                     {{"low-direct", "LDE"}, {"direct", "LD+E"}, {"Low-direct2", "LE"}});
  ASSERT_EQ(classes.size(), 9u);
  std::set<std::string> names;
  for (const PathClass& c : classes) EXPECT_TRUE(names.insert(lowerCase(c.name)).second) << c.name;
  EXPECT_EQ(classes[0].name, "hall-low-direct");
}

TEST(LightGroups, NameOfALampGoesBeforeThatOfItsShape) {
  const auto scene = sceneFrom(R"(
Camera "perspective" WorldBegin
LightSource "point" "string name" "bulb"
AreaLightSource "diffuse" "string name" "key"
Shape "sphere" "string name" "bulb")");
  const PathNames names = pathNames(*scene);
  ASSERT_EQ(names.lights.size(), 2u);
  for (const PathNames::List& light : names.lights) EXPECT_EQ(light.size(), 1u);
  EXPECT_EQ(lampGroups(*scene).size(), 2u);
}

/** Ways with a shadow ray to the lamp through the pane, with photons, connections and merges. */
TEST(LightGroups, LayersByLightAddUpToThePicture) {
  const ThreadPool pool;
  const auto scene = sceneFrom(roomOfLamps(24));
  const PathClasses classes = sceneClasses(withAll(classesByLight(lampGroups(*scene))), *scene);
  for (const Way& way : completeWays()) {
    const Rendered rendered = renderClasses(*scene, way, classes, 2, 1);
    expectSums(rendered.film, way.integrator + " " + way.parameters);
    const std::vector<double> means = rendered.layerMeans();
    for (size_t i = 0; i < means.size(); ++i) EXPECT_GT(means[i], 0) << way.integrator << " layer " << i / 3;
  }
}

TEST(LightGroups, ClassesBySurfaceAddUpToTheClass) {
  const ThreadPool pool;
  const auto scene = sceneFrom(roomOfLamps(24));
  const PathClasses classes =
      sceneClasses(withAll({{"floor", "L.*D'floor'E"},
                            {"wall", "L.*D'wall'E"},
                            {"balls", "L.*D'ball'E"},
                            {"mirror", "L.*S'mirror'E"},
                            {"pane", "L.*S'pane'E"},
                            {"bulb", "L.*D'bulb'E"},
                            {"others", "LE | L.*[^D'floor'D'wall'D'ball'S'mirror'S'pane'D'bulb']E"}}),
                   *scene);
  const PathClasses inside =
      sceneClasses(withAll({{"floor", "LS*D'floor'.*E"}, {"others", "all - LS*D'floor'.*E"}}), *scene);
  const PathClasses panes =
      sceneClasses({{"pane", "LS'pane'DE"}, {"mirror", "LS'mirror'DE"}, {"total", "LSDE"}}, *scene);
  for (const Way& way : completeWays()) {
    const std::string what = way.integrator + " " + way.parameters;
    expectSums(renderClasses(*scene, way, classes, 2, 1).film, what + ", by the last surface");
    expectSums(renderClasses(*scene, way, inside, 2, 2).film, what + ", by the first");
    const Rendered rendered = renderClasses(*scene, way, panes, 4, 3);
    expectSums(rendered.film, what + ", by the mirror and the pane");
    EXPECT_GT(rendered.layerMeans()[0], 0) << what;
    EXPECT_GT(rendered.layerMeans()[3], 0) << what;
  }
}

/** A material has the light of all of its surfaces. */
TEST(LightGroups, MaterialsAndObjectsNameTheirSurfaces) {
  const ThreadPool pool;
  const auto scene = sceneFrom(roomOfLamps(24));
  const PathClasses classes = sceneClasses({{"floor", "LD'floor'E"},
                                            {"first", "LD'ball'E - LD'ball.2'E"},
                                            {"second", "LD'ball.2'E"},
                                            {"oak", "LD'oak'E"}},
                                           *scene);
  const Rendered rendered = renderClasses(*scene, {"path", ""}, classes, 4, 1);
  expectSums(rendered.film, "oak");
  for (const double mean : rendered.layerMeans()) EXPECT_GT(mean, 0);
}

/** Largest relative standard error with which a comparison of means is meaningful. */
constexpr double VAGUE = SANITIZED ? 0.4 : 0.1; // sanitizers have an eighth of the samples

TEST(LightGroups, LayersAreTheLightOfALampAlone) {
  const ThreadPool pool;
  const auto scene = sceneFrom(roomOfLamps(16));
  const PathClasses classes = sceneClasses(classesByLight(lampGroups(*scene)), *scene);
  const std::string lamps = "kbsi";
  constexpr int SEEDS = 10;
  const auto meansAlone = [&](const Way& way) {
    std::vector<BatchMeans> alone;
    for (const char lamp : lamps)
      alone.push_back(classMeans(*sceneFrom(roomOfLamps(16, std::string(1, lamp))), way, PathClasses(),
                                 samples(12), SEEDS));
    return alone;
  };
  const std::vector<BatchMeans> byConnections = meansAlone({"bdpt", ""}), byMerges = meansAlone({"vcm", ""});
  for (const Way& way :
       {Way{"path", ""}, Way{"photonmap", "\"integer photons\" 20000"}, Way{"bdpt", ""}, Way{"vcm", ""}}) {
    const BatchMeans means = classMeans(*scene, way, classes, samples(12), SEEDS);
    const bool merges = way.integrator == "vcm";
    for (size_t i = 0; i < lamps.size(); ++i)
      for (size_t c = 0; c < 3; ++c) {
        if (way.integrator == "path" && lamps[i] == 's')
          continue; // path does not find its light by the mirror
        const BatchMeans& alone = (merges ? byMerges : byConnections)[i];
        const double error = std::hypot(alone.standardError(c), means.standardError(3 * i + c));
        const double bias = way.integrator == "photonmap" ? 0.03 : 0;
        EXPECT_NEAR(means.mean(3 * i + c), alone.mean(c), 5 * error + bias * alone.mean(c))
            << way.integrator << " " << lamps[i];
        EXPECT_LT(error, VAGUE * alone.mean(c)) << way.integrator << " " << lamps[i] << ": too vague to tell";
      }
  }
}

/** Area, point and environment lights, one by the name of its shape, one by its number. */
TEST(LightGroups, AWrongLightScaleListsTheLamps) {
  const std::string text = view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) +
                           "LightSource \"point\" \"string name\" \"key\"\n"
                           "LightSource \"point\" \"string name\" \"bulb\"\n"
                           "LightScale \"nosuch\" \"rgb scale\" [ 1 1 1 ]\n";
  try {
    sceneFrom(text);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("accepted: \"bulb\", \"key\""), std::string::npos)
        << error.what();
  }
}

TEST(LightGroups, LightScaleMultipliesTheLightOfALamp) {
  const ThreadPool pool;
  const std::string scales = R"(
LightScale "key" "rgb scale" [ .5 1 2 ]
LightScale "bulb" "rgb scale" [ 4 4 4 ]
LightScale "light-3" "rgb scale" [ 0 0 0 ]
LightScale "Sky's glow" "rgb scale" [ 3 2 1 ]
LightScale "Sky's glow" "rgb scale" [ .5 .5 .5 ]
)";
  const double factors[4][3] = {{.5, 1, 2}, {4, 4, 4}, {0, 0, 0}, {1.5, 1, .5}};
  const auto scene = sceneFrom(roomOfLamps(16)), scaled = sceneFrom(scales + roomOfLamps(16));
  const PathClasses classes = sceneClasses(classesByLight(lampGroups(*scene)), *scene);
  for (const Way& way :
       {Way{"path", ""}, Way{"bdpt", ""}, Way{"simplephotonmap", "\"integer photons\" 20000"}}) {
    const double bias = way.integrator == "simplephotonmap" ? 0.03 : 0; // photons are distributed by power
    const BatchMeans before = classMeans(*scene, way, classes, samples(12), 8),
                     after =
                         classMeans(*scaled, way, sceneClasses(classes.classes(), *scaled), samples(12), 8);
    for (size_t i = 0; i < 4; ++i)
      for (size_t c = 0; c < 3; ++c) {
        const double expected = factors[i][c] * before.mean(3 * i + c);
        const double error =
            std::hypot(factors[i][c] * before.standardError(3 * i + c), after.standardError(3 * i + c));
        EXPECT_NEAR(after.mean(3 * i + c), expected, 5 * error + bias * expected)
            << way.integrator << " lamp " << i;
        EXPECT_LE(error, VAGUE * expected) << way.integrator << " lamp " << i << ": too vague to tell";
      }
  }
}

TEST(LightGroups, LightScaleOfAnUnknownLampIsAnError) {
  Diagnostics diagnostics;
  const SceneDescription description = parseScene(
      "LightScale \"kye\" \"rgb scale\" [ 2 2 2 ]\n" + roomOfLamps(8), "scene.pbrt", "", diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors());
  EXPECT_EQ(buildScene(description, {}, diagnostics), nullptr);
  ASSERT_EQ(diagnostics.all().size(), 1u);
  const Diagnostic& error = diagnostics.all().front();
  EXPECT_EQ(error.message, "there is no lamp named \"kye\"");
  EXPECT_EQ(error.accepted, "\"key\"");
  EXPECT_EQ(error.location.line, 1);
  EXPECT_EQ(error.location.column, 12);
}

TEST(LightGroups, EmissiveMediaAreLamps) {
  const ThreadPool pool;
  const auto scene = sceneFrom(view(12, "0 -5 1  0 0 .8  0 0 1", 45) + R"(
MakeNamedMedium "fire" "string type" "homogeneous" "rgb sigma_a" [ .5 .5 .5 ] "rgb sigma_s" [ .1 .1 .1 ]
  "rgb Le" [ 4 2 1 ]
LightSource "point" "point3 from" [ 1 -1 2 ] "rgb I" [ 2 2 4 ]
Shape "bilinearmesh" "point3 P" [ -2 -2 0  2 -2 0  -2 2 0  2 2 0 ] "string name" "floor"
AttributeBegin
Material "interface"
MediumInterface "fire" ""
Translate -.5 0 .6
Shape "sphere" "float radius" .4
AttributeEnd
)");
  const std::vector<LampGroup> lamps = lampGroups(*scene);
  ASSERT_EQ(lamps.size(), 2u);
  EXPECT_EQ(lamps[1].name, "fire");
  std::vector<PathClass> list = classesByLight(lamps);
  list.push_back({"total", "all"});
  const PathClasses classes = sceneClasses(list, *scene);
  for (const Way& way : {Way{"path", ""}, Way{"photonmap", "\"integer photons\" 4000"}}) {
    const Rendered rendered = renderClasses(*scene, way, classes, 4, 1);
    expectSums(rendered.film, way.integrator);
    const std::vector<double> means = rendered.layerMeans();
    EXPECT_GT(means[2], means[0]) << "the lamp is blue";
    EXPECT_GT(means[3], 2 * means[5]) << "the fire is red";
  }
}
