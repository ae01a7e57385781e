/** @file
 * Small random scenes with extreme parameters of scene files: every registered plug-in, lamps and photons at
 * one point, shapes without area, thin and nested layers, films of one pixel, tiny and huge scales. The text
 * for a seed does not depend on the compiler.
 */
#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <vector>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/scene/plugIns.h"
#include "sceneRendering.h"

namespace recurse::testing {

/** Scene file that names its integrator, with the settings of its render. */
struct RandomScene {
  std::string text;
  std::string integrator, parameters; ///< as in the text
  std::vector<PathClass> classes;     ///< none: one layer of all light
  int samplesPerPixel = 1;
  bool hasPencil = false; ///< light so narrow that all its photons may arrive at one point
};

/** Writer of one scene. */
class RandomSceneWriter {
 public:
  explicit RandomSceneWriter(uint64_t seed) : state(mixBits(seed)) {}

  RandomScene write() {
    RandomScene scene;
    const auto& integrator = anyOf(plugIns().integrators);
    scene.integrator = integrator.name;
    scene.parameters = integratorParameters(integrator);
    rendersMedia = supportsMedia(scene);
    scene.samplesPerPixel = 1 + below(2);
    if (chance(0.15)) scene.classes = {{"caustics", "LS+DE"}, {"all", "L(S|D|V)*E"}};
    if (chance(0.3)) size = powerOfTen(-6, 6);
    scene.text = "Integrator \"" + scene.integrator + "\" " + scene.parameters + "\n";
    scene.text += view();
    scene.text += "WorldBegin\n";
    if (chance(0.1)) scene.text += "Translate " + point(size * powerOfTen(0, 5)) + "\n";
    scene.text += "Scale " + same(size) + "\n";
    scene.text += definitions();
    scene.hasPencil = chance(0.25);
    if (scene.hasPencil) scene.text += pencil();
    if (chance(scene.hasPencil ? 0.5 : 0.1)) scene.text += farAway();
    for (int count = below(4); count > 0; --count) scene.text += repeated(lamp());
    for (int count = 1 + below(6); count > 0; --count) scene.text += repeated(piece());
    return scene;
  }

 private:
  // ------------------------------------------------------------------------------------- random numbers

  double uniform(double low = 0, double high = 1) {
    state = mixBits(state + 1);
    return low + (high - low) * (double(state >> 11) * 0x1p-53);
  }
  bool chance(double p) { return uniform() < p; }
  int below(size_t n) { return std::min(int(uniform() * double(n)), int(n) - 1); }
  template <class List> const typename List::value_type& anyOf(const List& list) {
    return list[size_t(below(list.size()))];
  }
  /** Power by products, because mathematical libraries differ. */
  double powerOfTen(int low, int high) {
    const int exponent = low + below(size_t(high - low + 1));
    double p = 1;
    for (int i = 0; i < std::abs(exponent); ++i) p *= 10;
    return exponent < 0 ? 1 / p : p;
  }

  // ----------------------------------------------------------------------------------------------- text

  /** Joins texts; braces evaluate their elements in order, unlike operands of +. */
  static std::string joined(std::initializer_list<std::string> parts) {
    std::string text;
    for (const std::string& part : parts) text += part;
    return text;
  }
  static std::string digits(double x) { return shown("%.9g", x); }
  static std::string same(double x) { return joined({digits(x), " ", digits(x), " ", digits(x)}); }
  std::string point(double extent) {
    std::string text;
    for (int i = 0; i < 3; ++i) text += (chance(0.2) ? "0" : digits(uniform(-extent, extent))) + " ";
    return text;
  }
  static std::string attribute(const std::string& inside) {
    return "AttributeBegin\n" + inside + "AttributeEnd\n";
  }
  /** Sometimes repeats the text, at exactly the same position. */
  std::string repeated(const std::string& text) { return chance(0.15) ? text + text + text : text; }

  // ----------------------------------------------------------------------------------------- parameters

  static bool gives(const std::string& parameters, const std::string& name) {
    return parameters.find(" " + name + "\"") != std::string::npos;
  }

  /** A value that the declaration allows; empty if no value of the type is always valid. */
  std::string value(const ParameterSpec& spec) {
    const std::string name = " " + spec.name + "\" ";
    if (spec.count != 1 || spec.ignored) return {};
    const bool isReal = spec.type == ParameterType::REAL;
    if (spec.textured && chance(0.5)) return " \"texture" + name + (isReal ? "\"grey\"" : "\"colour\"");
    if (spec.type == ParameterType::BOOLEAN) return " \"bool" + name + (chance(0.5) ? "true" : "false");
    if (!spec.choices.empty()) return " \"string" + name + "\"" + anyOf(spec.choices) + "\"";
    if (!isReal || spec.minimum < 0) return {};
    constexpr double LARGE = 1000; // larger ranges do not show which values are common
    const double low = spec.minimum + (spec.minimumExcluded ? 1e-3 : 0);
    if (spec.maximum > LARGE) return " \"float" + name + digits(low + powerOfTen(-4, 1));
    if (chance(0.5)) return " \"float" + name + digits(uniform(low, spec.maximum));
    return " \"float" + name + digits(chance(0.5) ? low : spec.maximum);
  }

  /** Parameters of one of the plug-in's examples, and further declared ones. Shapes have no displacement,
   * whose work is inversely proportional to the size of pixels. */
  std::string parametersOf(const PlugInInfo& plugIn, double more = 0.07) {
    const auto& specs = plugIn.parameters;
    const bool isShape = std::any_of(specs.begin(), specs.end(),
                                     [](const ParameterSpec& s) { return s.name == "edgelength"; });
    std::string text = anyOf(plugIn.examples);
    if (gives(text, "filename") && chance(0.8)) text = anyOf(plugIn.examples); // reading pictures takes long
    for (const ParameterSpec& spec : specs)
      if (!(isShape && (spec.name == "displacement" || spec.name == "edgelength")) && chance(more) &&
          !gives(text, spec.name))
        text += value(spec);
    return text;
  }
  /** Any plug-in that has examples: all others need a file. */
  template <class I, class C> const PlugIn<I, C>& anyOf(const Registry<I, C>& registry) {
    for (;;) {
      const PlugIn<I, C>& entry = anyOf(registry.entries());
      if (!entry.examples.empty() && !(isSlowToMake(entry.name) && chance(0.8))) return entry;
    }
  }
  /** Whether making the plug-in takes as long as a hundred small renders, because of its tables. */
  static bool isSlowToMake(const std::string& name) {
    return name == "realistic" || name == "sky" || name == "goniometric";
  }
  template <class I, class C> std::string use(const Registry<I, C>& registry) {
    const PlugIn<I, C>& entry = anyOf(registry);
    return joined({registry.kind(), " \"", entry.name, "\" ", parametersOf(entry), "\n"});
  }

  /** Parameters of an integrator; integers set the amount of work, which must be small. */
  std::string integratorParameters(const PlugInInfo& plugIn) {
    std::string text = parametersOf(plugIn, 0.15);
    for (const ParameterSpec& spec : plugIn.parameters) {
      if (spec.type != ParameterType::INTEGER || spec.ignored || gives(text, spec.name)) continue;
      const bool isMuch = spec.defaultText.empty() || std::stod(spec.defaultText) > 100;
      if (!isMuch && !chance(0.2)) continue;
      text += " \"integer " + spec.name + "\" ";
      text += digits(spec.minimum + (chance(0.3) ? below(4) : 1 << below(8)));
    }
    return text;
  }

  // ------------------------------------------------------------------------------------------- the scene

  static bool supportsMedia(const RandomScene& scene) {
    try {
      static const std::unique_ptr<Scene> empty = sceneFrom("WorldBegin\n");
      return integratorFrom(scene.integrator, scene.parameters)->supportsMedia(*empty);
    } catch (const Error&) { // parameters that are refused
      return false;
    }
  }

  std::string view() {
    const auto pixels = [&] { return std::to_string(chance(0.3) ? 1 : 1 + below(8)); };
    const double away = size * (chance(0.5) ? 4 : uniform(0.1, 3));
    std::string target;
    for (int i = 0; i < 3; ++i) {
      seen[size_t(i)] = chance(0.2) ? 0 : uniform(-1, 1);
      target += digits(size * seen[size_t(i)]) + " ";
    }
    return joined({"Film \"rgb\" \"integer xresolution\" ", pixels(), " \"integer yresolution\" ", pixels(),
                   "\n", use(plugIns().filters), "LookAt ", point(away), target,
                   chance(0.5) ? "0.1 1 0.05\n" : "0 0 1\n", use(plugIns().cameras)});
  }

  /** Textures, media, materials and objects with the names that other parts and examples use. */
  std::string definitions() {
    std::string text;
    for (const auto& [name, type] : {std::pair("grey", "float"), {"colour", "spectrum"}}) {
      const auto& entry = anyOf(plugIns().textures);
      text += joined({"Texture \"", name, "\" \"", type, "\" "});
      text += chance(0.5) ? "\"constant\"\n" : joined({"\"", entry.name, "\" ", parametersOf(entry), "\n"});
    }
    const bool hasMedia = chance(rendersMedia ? 0.4 : 0.03);
    for (const char* name : {"mist", "smoke"}) {
      if (!hasMedia) break;
      const auto& entry = anyOf(plugIns().media);
      text += joined({"MakeNamedMedium \"", name, "\" \"string type\" \"", entry.name, "\" ",
                      parametersOf(entry), "\n"});
      media.push_back(name);
    }
    const auto material = [&](const std::string& name, const std::string& type,
                              const std::string& parameters) {
      text += joined({"MakeNamedMaterial \"", name, "\" \"string type\" \"", type, "\" ", parameters, "\n"});
      materials.push_back(name);
    };
    material("red", "diffuse", "\"rgb reflectance\" [.9 .3 .1]");
    material("gold", "conductor", "\"rgb reflectance\" [.9 .8 .4]");
    material("glass", "dielectric", "\"float eta\" 1.5");
    material("brushed", "conductor", "\"rgb reflectance\" [.9 .8 .4] \"float roughness\" .1");
    material("frosted", "dielectric", "\"float eta\" 1.5 \"float roughness\" .1");
    material("pane", "thindielectric", "");
    material("nothing", "interface", "");
    for (const char* name : {"a", "b", "c"}) {
      const auto& entry = anyOf(plugIns().materials);
      material(name, entry.name, parametersOf(entry));
    }
    text += "ObjectBegin \"ball\"\nShape \"sphere\" \"float radius\" 1.2\nObjectEnd\n"
            "ObjectBegin \"block\"\nShape \"box\" \"point3 p1\" [-1 -.9 -.8] \"point3 p2\" [1.1 1 .7]\n"
            "ObjectEnd\n";
    text += joined(
        {"ObjectBegin \"some\"\n", anyMaterial(), anyShape(), anyMaterial(), anyShape(), "ObjectEnd\n"});
    return text;
  }

  std::string anyMaterial() {
    return chance(0.4) ? "Material \"diffuse\"\n" : "NamedMaterial \"" + anyOf(materials) + "\"\n";
  }
  std::string anyMedia() {
    if (media.empty() || !chance(0.3)) return {};
    const auto side = [&] { return chance(0.3) ? std::string() : anyOf(media); };
    return joined({"MediumInterface \"", side(), "\" \"", chance(0.8) ? std::string() : side(), "\"\n"});
  }
  enum Stretch { STRETCHED, ALIKE };
  /** Translates, rotates and scales, sometimes to nearly nothing. */
  std::string placed(Stretch stretch = STRETCHED) {
    std::string text = "Translate " + point(1) + "\n";
    if (chance(0.5))
      text += joined({"Rotate ", digits(uniform(0, 360)), " ", digits(uniform(-1, 1)), " ",
                      digits(uniform(-1, 1)), " 1\n"});
    const auto factor = [&] { return chance(0.2) ? powerOfTen(-9, 1) : uniform(0.1, 1); };
    if (chance(0.4)) text += "Scale " + same(factor()) + "\n";
    if (stretch == STRETCHED && chance(0.2))
      text += joined({"Scale ", digits(factor()), " ", digits(-factor()), " ", digits(factor()), "\n"});
    if (chance(0.05)) text += "ActiveTransform EndTime\nTranslate 0 0.3 0\nActiveTransform All\n";
    return text;
  }

  /** Two triangles whose corners may be on one line or at one point. */
  std::string roughTriangles() {
    const double extent = chance(0.2) ? powerOfTen(-12, 3) : 1;
    std::vector<std::string> corners;
    for (int i = 0; i < 4; ++i)
      corners.push_back(i > 0 && chance(0.4) ? corners[size_t(below(size_t(i)))] : point(extent));
    return joined({"Shape \"trianglemesh\" \"integer indices\" [ 0 1 2  0 2 3  1 1 1 ] \"point3 P\" [ ",
                   corners[0], corners[1], corners[2], corners[3], "]\n"});
  }
  /** Parallel to the xy plane. */
  static std::string square(double halfSide, double z) {
    const std::string a = digits(-halfSide) + " ", b = digits(halfSide) + " ", c = digits(z) + " ";
    return "Shape \"bilinearmesh\" \"point3 P\" [ " + a + a + c + b + a + c + a + b + c + b + b + c + "]\n";
  }
  std::string anyShape() {
    if (chance(0.25)) return roughTriangles();
    if (chance(0.25)) {
      const double halfSide = chance(0.3) ? powerOfTen(-9, 4) : uniform(0.1, 2);
      return square(halfSide, chance(0.5) ? 0 : uniform(-1, 1));
    }
    return use(plugIns().shapes);
  }

  /** A wall in the middle of the view, and light so narrow that its photons arrive at one point of it; often
   * through a glass bulb, by delta lobes. */
  std::string pencil() {
    const double distance = powerOfTen(-6, -2);
    std::string from, to;
    for (const double x : seen) {
      from += digits(x + distance * uniform(-1, 1)) + " ";
      to += digits(x) + " ";
    }
    const std::string lamp =
        joined({"LightSource \"spot\" \"rgb I\" [ ", same(powerOfTen(0, 6)), " ] \"point3 from\" [ ", from,
                "] \"point3 to\" [ ", to, "] \"float coneangle\" ", digits(powerOfTen(-3, -1)),
                " \"float conedeltaangle\" 0\n"});
    const std::string bulb =
        attribute(joined({"Translate ", from, "\n", chance(0.8) ? "NamedMaterial \"glass\"\n" : anyMaterial(),
                          "Shape \"sphere\" \"float radius\" ", digits(distance * uniform(0.1, 0.5)), "\n"}));
    const double halfSide = chance(0.2) ? powerOfTen(-9, -1) : uniform(0.1, 3);
    const std::string wall =
        attribute(joined({"Translate ", to, "\n", chance(0.8) ? "Material \"diffuse\"\n" : anyMaterial(),
                          square(halfSide, 0)}));
    return lamp + (chance(0.8) ? bulb : "") + wall;
  }
  /** A small object at a distance that makes the coordinates of all objects lose digits: positions coincide.
   */
  std::string farAway() {
    return attribute(joined({"Translate ", digits(powerOfTen(2, 6)), " 0 0\nShape \"sphere\"\n"}));
  }

  std::string lamp() {
    if (chance(0.5)) return attribute(joined({placed(ALIKE), use(plugIns().lights)}));
    const Stretch stretch = chance(0.1) ? STRETCHED : ALIKE; // sampling points on stretched lamps takes long
    return attribute(
        joined({placed(stretch), anyMedia(), anyMaterial(), use(plugIns().areaLights), anyShape()}));
  }

  std::string piece() {
    const double distance = powerOfTen(-9, 0);
    switch (below(9)) {
    case 0: // two layers, thin or coincident
      return attribute(joined({placed(), anyMedia(), anyMaterial(), square(1, 0), anyMaterial(),
                               square(1, chance(0.2) ? 0 : distance)}));
    case 1: // a wall with a small hole
      return attribute(
          joined({placed(), anyMaterial(), "Shape \"disk\" \"float radius\" 2 \"float innerradius\" ",
                  digits(distance), "\n"}));
    case 2: // a closed room
      return attribute(joined({anyMedia(), anyMaterial(),
                               "ReverseOrientation\nShape \"box\" \"point3 p1\" [ -3 -3 -3 ] \"point3 p2\" "
                               "[ 3 3 3 ]\n"}));
    case 3: {
      const std::string instance = "ObjectInstance \"some\"\n";
      return attribute(joined({placed(), instance, chance(0.5) ? placed() : "", instance}));
    }
    case 4: { // nested balls: glass, coats, media
      std::string balls;
      for (int i = 0; i < 2; ++i)
        balls += attribute(joined({anyMedia(), anyMaterial(), "Shape \"sphere\" \"float radius\" ",
                                   digits(i == 0 ? 1 : 1 - 0.9 * distance), "\n"}));
      return attribute(placed() + balls);
    }
    case 5: // an empty layer, or a layer with a medium
      return attribute(joined({placed(), anyMedia(), "Material \"interface\"\n", anyShape()}));
    default:
      return attribute(joined({placed(), anyMedia(), anyMaterial(), anyShape()}));
    }
  }

  uint64_t state;
  bool rendersMedia = false;    ///< whether the integrator of the scene supports media
  double size = 1;              ///< size of the scene
  std::array<double, 3> seen{}; ///< point in the middle of the view, in units of `size`
  std::vector<std::string> media, materials;
};

} // namespace recurse::testing
