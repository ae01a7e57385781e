/** @file
 * 10. Extreme inputs: an empty scene, no light, no camera, pictures of odd sizes, numbers that are infinite
 * or nearly so. Each results in the right picture or a clear error.
 */
#include "hardCase.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>

#include <unistd.h>

#include "recurse/core/threads/parallel.h"
#include "recurse/scene/directives/loader.h"

namespace recurse::hard {

namespace {

constexpr const char* SMALL = "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\n";
const std::string FLOOR =
    diffuse(0.5) + "Shape \"bilinearmesh\" \"point3 P\" [ -9 -9 3  9 -9 3  -9 9 3  9 9 3 ]\n";
constexpr const char* POINT = "LightSource \"point\" \"rgb I\" [ 1 1 1 ]\n";

/** Expects this radiance in every pixel, up to rounding and noise. */
void constant(const Report& report, const std::string& detail, const std::string& text, double expected,
              const Budget& budget = {}) {
  const auto scene = sceneFrom(text);
  for (const Way& way : allWays(budget.photons)) {
    const Rendered r = renderScene(*scene, way, budget);
    double worst = 0;
    for (size_t i = 0; i < r.pixels(); ++i) worst = std::max(worst, std::abs(r.luminanceAt(i) - expected));
    report.atMost(detail, way.label, "worst pixel off by", worst, budget.tolerance * expected, r.unsound());
  }
}

void nothing(const Report& report) {
  Budget b;
  b.samples = b.photonSamples = 4;
  b.photons = 100;
  b.tolerance = 1e-6;
  constant(report, "empty scene", SMALL + std::string("WorldBegin\n"), 0, b);
  constant(report, "no light", SMALL + std::string("WorldBegin\n") + FLOOR, 0, b);
  constant(report, "no shape, a point light", SMALL + std::string("WorldBegin\n") + POINT, 0, b);
  constant(report, "no shape, even light", SMALL + std::string("WorldBegin\n") + constantLight(0.25), 0.25,
           b);
  constant(report, "no camera: the eye at the origin",
           SMALL + std::string("WorldBegin\n") + FLOOR + "AreaLightSource \"diffuse\" \"rgb L\" [ 2 2 2 ]\n" +
               diffuse(0) + "Translate 0 0 1\nScale 9 9 1\nReverseOrientation\nShape \"disk\"\n",
           2, b);
  for (const char* light :
       {"LightSource \"point\" \"rgb I\" [ 0 0 0 ]", "LightSource \"infinite\" \"rgb L\" [ 0 0 0 ]",
        "LightSource \"distant\" \"rgb L\" [ 0 0 0 ]", "LightSource \"spot\" \"float scale\" 0",
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [ 0 0 0 ] Shape \"sphere\" "
        "\"float radius\" 1e-3 AttributeEnd"})
    constant(report, std::string("no power: ") + std::string(light, std::min<size_t>(std::strlen(light), 44)),
             SMALL + std::string("WorldBegin\n") + light + "\n" + FLOOR, 0, b);
  // One light without power beside a light with power.
  constant(report, "no power, beside even light",
           SMALL + std::string("WorldBegin\nLightSource \"point\" \"rgb I\" [ 0 0 0 ]\n") +
               constantLight(0.25),
           0.25, b);
  for (const char* text : {"", "WorldBegin"}) {
    std::string figure, problem;
    try {
      const auto scene = sceneFrom(text);
      figure = "a scene";
      if (scene->contents().shapes != 0) problem = "shapes from nowhere";
    } catch (const SceneError& e) {
      figure = "refused";
      if (std::string(e.what()).find("error:") == std::string::npos) problem = e.what();
    }
    report.holds(*text ? "file with nothing but WorldBegin" : "empty file", "-", figure, problem.empty(),
                 problem);
  }
}

void sizes(const Report& report) {
  Budget b;
  b.samples = b.photonSamples = 1;
  b.photons = 100;
  b.tolerance = 1e-6;
  const std::string rest =
      "PixelFilter \"box\"\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n" + constantLight(0.25);
  for (const auto& [w, h] : {std::pair{1, 1}, std::pair{16384, 1}, std::pair{1, 16384}, std::pair{7, 3}})
    constant(report, "picture of " + std::to_string(w) + "x" + std::to_string(h),
             "Film \"rgb\" \"integer xresolution\" " + std::to_string(w) + " \"integer yresolution\" " +
                 std::to_string(h) + "\n" + rest,
             0.25, b);
  const auto film = [](const std::string& more) {
    return "Film \"rgb\" \"integer xresolution\" 33 \"integer yresolution\" 17" + more +
           "\nCamera \"perspective\" \"float fov\" 90\nWorldBegin\n" + FLOOR + POINT + glass(1.5) +
           "Translate 0 0 1.5\nShape \"sphere\" \"float radius\" .5\n";
  };
  const auto whole = sceneFrom(film("")), part = sceneFrom(film(" \"integer pixelbounds\" [ 20 21 11 12 ]"));
  for (const Way& way : allWays(5000)) {
    const Rendered a = renderScene(*whole, way, 4), p = renderScene(*part, way, 4);
    const double there = a.luminanceAt(11 * 33 + 20);
    report.atMost("crop of one pixel", way.label, "relative difference",
                  p.pixels() == 1 ? std::abs(p.luminanceAt(0) - there) / std::max(there, 1e-30) : INFINITY, 0,
                  p.unsound());
  }
}

// ---- numbers that are infinite or nearly so, for every parameter of every plug-in

/** The parameter with `word` as one of its values, in each type that files may give it. */
std::vector<std::string> spelled(const ParameterSpec& p, const std::string& word) {
  const auto values = [&](int n) {
    std::string s = "[ ";
    for (int i = 0; i < n; ++i) s += i == n / 2 ? word + " " : "0.5 ";
    return s + "]";
  };
  const auto with = [&](const std::string& type, int n) {
    return "\"" + type + " " + p.name + "\" " + values(n);
  };
  const int count = std::max(p.count, 1);
  switch (p.type) {
  case ParameterType::INTEGER:
    return {"\"integer " + p.name + "\" [ " + word + " ]"};
  case ParameterType::REAL:
    return {with("float", count)};
  case ParameterType::POINT2:
    return {with("point2", 2 * count)};
  case ParameterType::VECTOR2:
    return {with("vector2", 2 * count)};
  case ParameterType::POINT3:
    return {with("point3", p.count == 0 ? 12 : 3 * count)};
  case ParameterType::VECTOR3:
    return {with("vector3", p.count == 0 ? 12 : 3 * count)};
  case ParameterType::NORMAL:
    return {with("normal", p.count == 0 ? 12 : 3 * count)};
  case ParameterType::SPECTRUM:
    return {with("rgb", 3), "\"blackbody " + p.name + "\" " + word, "\"float " + p.name + "\" " + word,
            "\"spectrum " + p.name + "\" [ 400 .5 500 " + word + " 600 .5 ]"};
  case ParameterType::BOOLEAN:
  case ParameterType::STRING:
    break;
  }
  return {};
}

/** A scene that contains this plug-in, in the view and lit. */
std::string sceneWith(const std::string& kind, const std::string& name, const std::string& parameters) {
  const std::string use = kind + " \"" + name + "\" " + parameters + "\n";
  const bool before = kind == "Camera" || kind == "PixelFilter" || kind == "Film" || kind == "Sampler" ||
                      kind == "Accelerator" || kind == "Integrator";
  std::string text = kind == "Film" ? "" : SMALL;
  if (before) text += use;
  text += "WorldBegin\n" + FLOOR + POINT + constantLight(0.1) + "AttributeBegin\nTranslate 0 0 2\n";
  if (kind == "Texture")
    text += "Texture \"t\" \"spectrum\" \"" + name + "\" " + parameters +
            "\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"\n";
  else if (kind == "Material" || kind == "AreaLightSource")
    text += "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\nMakeNamedMaterial \"b\" \"string type\" "
            "\"diffuse\"\n" +
            use + "Shape \"sphere\" \"float radius\" .5\n";
  else if (!before)
    text += use;
  return text + "AttributeEnd\n";
}

template <class F> void forEachNumber(const F& f) {
  const PlugIns& all = plugIns();
  const auto registry = [&](const auto& r) {
    for (const auto& entry : r.entries())
      for (const ParameterSpec& p : entry.parameters) {
        // The first example without the parameter provides the other required parameters.
        std::string base;
        for (const std::string& e : entry.examples)
          if (e.find(" " + p.name + "\"") == std::string::npos) {
            base = e;
            break;
          }
        f(r.kind(), entry.name, p, base);
      }
  };
  registry(all.shapes);
  registry(all.materials);
  registry(all.textures);
  registry(all.lights);
  registry(all.areaLights);
  registry(all.cameras);
  registry(all.filters);
  registry(all.films);
  registry(all.samplers);
  registry(all.accelerators);
  registry(all.integrators);
}

/** Whether a message contains the name of a parameter in the text. */
bool namesParameter(const std::string& message, const std::string& parameters) {
  static const std::regex NAME("\"\\w+ (\\w+)\"");
  for (std::sregex_iterator it(parameters.begin(), parameters.end(), NAME), end; it != end; ++it)
    if (message.find('"' + (*it)[1].str() + '"') != std::string::npos) return true;
  return false;
}

/** Problem with the messages of the parser and the builder, or with the picture; empty: none. */
std::string outcome(const std::string& text, const std::vector<Way>& ways, bool& refused) {
  Diagnostics diagnostics;
  std::unique_ptr<Scene> scene;
  refused = false;
  try {
    const SceneDescription description = parseScene(text, "hard.pbrt", ".", diagnostics);
    if (!diagnostics.hasErrors()) scene = buildScene(description, {}, diagnostics);
  } catch (const SceneError& e) {
    for (const Diagnostic& d : e.diagnostics()) diagnostics.error(d.location, d.message, d.accepted);
  } catch (const Error& e) {
    return std::string("an error without a place: ") + e.what();
  }
  if (diagnostics.hasErrors()) {
    refused = true;
    for (const Diagnostic& d : diagnostics.all())
      if (d.severity == Severity::ERROR && d.location.line < 1)
        return "an error without a place: " + d.message;
    return {};
  }
  if (!scene) return "no scene and no error";
  for (const Way& way : ways) try {
      const Rendered r = renderScene(*scene, way, 2);
      if (const std::string problem = r.unsound(); !problem.empty()) return way.label + ": " + problem;
    } catch (const SceneError&) {
      refused = true; // refused by the integrator
    } catch (const Error& e) {
      // An integrator refuses parameters that depend on the scene in prepare().
      if (!namesParameter(e.what(), way.parameters)) throw;
      refused = true;
    }
  return {};
}

void notFinite(const Report& report) {
  for (const char* word : {"nan", "inf", "-inf", "1e999", "-Infinity"}) {
    int tried = 0, taken = 0;
    std::string first;
    forEachNumber([&](const std::string& kind, const std::string& name, const ParameterSpec& p,
                      const std::string& base) {
      for (const std::string& text : spelled(p, word)) {
        ++tried;
        const std::string scene = sceneWith(kind, name, base + " " + text);
        Diagnostics diagnostics;
        const SceneDescription description = parseScene(scene, "hard.pbrt", ".", diagnostics);
        // The error points at exactly this word.
        const bool right =
            std::any_of(diagnostics.all().begin(), diagnostics.all().end(), [&](const Diagnostic& d) {
              return d.severity == Severity::ERROR && d.location.line > 0 &&
                     d.location.lineText().compare(static_cast<size_t>(d.location.column - 1),
                                                   std::strlen(word), word) == 0;
            });
        if (right) continue;
        ++taken;
        if (first.empty()) first = kind + " \"" + name + "\" " + text;
      }
    });
    report.holds(std::string(word) + " in every numeric parameter", "-",
                 std::to_string(tried - taken) + " of " + std::to_string(tried) + " refused",
                 taken == 0 && tried > 100, "taken: " + first);
  }
}

void hardlyFinite(const Report& report) {
  std::vector<Way> ways = allWays(500);
  // Only the first way with photons learns guided emission, which takes far more trials than there are
  // photons.
  for (size_t i = 0, photons = 0; i < ways.size(); ++i)
    if (ways[i].usesPhotons && photons++ > 0) ways[i].parameters += " \"bool guided\" false";
  size_t turn = 0;
  for (const char* word : {"1e308", "-1e308", "1e39", "3e38", "1e30", "-1e30", "1e-30", "1e-46", "1e-320"}) {
    int tried = 0, refusals = 0, wrong = 0;
    size_t next = turn++;
    std::string first;
    forEachNumber([&](const std::string& kind, const std::string& name, const ParameterSpec& p,
                      const std::string& base) {
      if (p.type == ParameterType::INTEGER || p.ignored) return;
      for (const std::string& text : spelled(p, word)) {
        ++tried;
        bool refused = false;
        const std::string scene = sceneWith(kind, name, base + " " + text);
        std::string problem;
        if (kind != "Integrator") {
          // Sanitizers have time for a single way at a time, which changes with each word.
          problem = outcome(scene, SANITIZED ? std::vector<Way>{ways[next++ % ways.size()]} : ways, refused);
        } else {
          problem = outcome(scene, {{name, base + " " + text, name, true, true}}, refused);
        }
        refusals += refused;
        if (problem.empty()) continue;
        ++wrong;
        if (first.empty()) first = kind + " \"" + name + "\" " + text + ": " + problem;
      }
    });
    report.holds(std::string(word) + " in every real parameter", "-",
                 std::to_string(tried - wrong) + " of " + std::to_string(tried) + " right, " +
                     std::to_string(refusals) + " refused",
                 wrong == 0, first);
  }
}

// ---- files

class Folder {
 public:
  Folder() : path(std::filesystem::temp_directory_path() / ("recurse-hard-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  void write(const std::string& name, const std::string& content) const {
    std::ofstream(path / name, std::ios::binary) << content;
  }
  const std::filesystem::path path;
};

void meshFiles(const Report& report) {
  const Folder folder;
  const std::string header =
      "ply\nformat %s 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto headed = [&](const std::string& format) {
    std::string h = header;
    return h.replace(h.find("%s"), 2, format);
  };
  for (const char* word : {"nan", "inf", "-inf", "1e39"}) {
    folder.write("a.ply", headed("ascii") + "0 0 0\n1 " + word + " 0\n0 1 0\n3 0 1 2\n");
    std::string binary = headed("binary_little_endian");
    const float v[9] = {0, 0, 0, 1, std::strtof(word, nullptr), 0, 0, 1, 0};
    const int32_t index[3] = {0, 1, 2};
    binary.append(reinterpret_cast<const char*>(v), sizeof v).push_back(3);
    binary.append(reinterpret_cast<const char*>(index), sizeof index);
    folder.write("b.ply", binary);
    for (const char* file : {"a.ply", "b.ply"}) {
      std::string said = "no error";
      try {
        sceneFrom(std::string(SMALL) + "WorldBegin\nShape \"plymesh\" \"string filename\" \"" + file + "\"\n",
                  folder.path.string());
      } catch (const SceneError& e) {
        said = e.what();
      }
      const bool clear = said.find(file) != std::string::npos && (said.find("finite") != std::string::npos ||
                                                                  said.find("large") != std::string::npos);
      report.holds(std::string(file[0] == 'a' ? "text" : "binary") + " PLY file with " + word, "-",
                   clear ? "refused with a reason" : "no clear error", clear, said);
    }
  }
}

/** Measured materials: a truncated file, and values that are NaN. */
void measuredFiles(const Report& report) {
  const Folder folder;
  std::ifstream in(RECURSE_SOURCE_DIR "/scenes/materials/copper.bsdf", std::ios::binary);
  const std::string good{std::istreambuf_iterator<char>(in), {}};
  const auto refused = [&](const std::string& detail, const std::string& bytes, const std::string& reason) {
    folder.write("a.bsdf", bytes);
    std::string said = "no error";
    try {
      sceneFrom(std::string(SMALL) + "WorldBegin\nMaterial \"measured\" \"string filename\" \"a.bsdf\"\n"
                                     "Shape \"sphere\"\n",
                folder.path.string());
    } catch (const SceneError& e) {
      said = e.what();
    }
    const bool clear = said.find("a.bsdf: ") != std::string::npos && said.find(reason) != std::string::npos;
    report.holds("measured material " + detail, "-", clear ? "refused with a reason" : "no clear error",
                 clear, said);
  };
  for (const size_t length : {size_t(12), size_t(100), good.size() / 2, good.size() - 1})
    refused("of " + std::to_string(length) + " of " + std::to_string(good.size()) + " bytes",
            good.substr(0, length), "has " + std::to_string(length));
  for (const float value : {NAN, INFINITY}) {
    std::string bytes = good;
    std::memcpy(&bytes[good.size() - sizeof value], &value, sizeof value);
    refused("that ends with " + std::to_string(value), bytes, "is not finite");
  }
}

/** Pictures as textures, with a pixel that is NaN or nearly infinite. */
void textureFiles(const Report& report) {
  const Folder folder;
  const std::vector<Way> ways = allWays(500);
  for (const char* word : {"nan", "inf", "-inf", "3e38", "-1e30", "1e-40"}) {
    Image image(4, 4, {"R", "G", "B"});
    std::fill(image.pixels.begin(), image.pixels.end(), 0.5f);
    image.pixels[25] = std::strtof(word, nullptr);
    writeImage((folder.path / "a.exr").string(), image);
    const bool finite = std::isfinite(image.pixels[25]);
    for (const char* use : {"\"spectrum\" \"imagemap\" \"string filename\" \"a.exr\"\nMaterial \"diffuse\" "
                            "\"texture reflectance\" \"t\"\n",
                            "\"float\" \"imagemap\" \"string filename\" \"a.exr\"\nMaterial \"diffuse\" "
                            "\"texture displacement\" \"t\"\n"}) {
      const std::string text = SMALL + std::string("WorldBegin\n") + POINT + "Texture \"t\" " + use +
                               "Translate 0 0 2\nShape \"sphere\"\n";
      std::string figure = "a picture", problem;
      try {
        const auto scene = sceneFrom(text, folder.path.string());
        for (const Way& way : ways) {
          const Rendered r = renderScene(*scene, way, 16);
          if (problem.empty()) problem = r.unsound();
        }
        if (!finite) problem = "taken";
      } catch (const SceneError& e) {
        figure = "refused with a reason";
        if (std::string(e.what()).find("a.exr") == std::string::npos) problem = e.what();
      }
      report.holds(std::string(word) + (std::strstr(use, "displacement") ? " as a height" : " as a colour"),
                   "-", figure, problem.empty(), problem);
    }
  }
}

/** With one error in each of very many shapes, the first errors must stay visible. */
void manyErrors(const Report& report) {
  constexpr int COUNT = 20000;
  for (const char* mistake :
       {"Shape \"sphere\" \"float radius\" -1\n", "Shape \"ball\"\n", "Shape \"sphere\" \"float radios\" 1\n",
        "Shape \"sphere\" \"float radius\" nan\n"}) {
    std::string text = std::string(SMALL) + "WorldBegin\n";
    for (int i = 0; i < COUNT; ++i) text += mistake;
    Diagnostics diagnostics;
    try {
      const SceneDescription description = parseScene(text, "hard.pbrt", ".", diagnostics);
      if (!diagnostics.hasErrors()) buildScene(description, {}, diagnostics);
    } catch (const SceneError& e) {
      for (const Diagnostic& d : e.diagnostics()) diagnostics.error(d.location, d.message, d.accepted);
    }
    const std::string shownText = std::string(mistake).substr(0, std::strlen(mistake) - 1);
    report.atMost(shown("%.0f times ", COUNT) + shownText, "-", "messages", double(diagnostics.all().size()),
                  60, diagnostics.hasErrors() ? "" : "no error");
  }
}

} // namespace

void addInputCases(HardCases& cases) {
  cases.push_back({10, "nothing there", false, nothing});
  cases.push_back({10, "sizes of the picture", false, sizes});
  cases.push_back({10, "not finite", false, notFinite});
  cases.push_back({10, "hardly finite", false, hardlyFinite});
  cases.push_back({10, "mesh files", false, meshFiles});
  cases.push_back({10, "measured files", false, measuredFiles});
  cases.push_back({10, "texture files", false, textureFiles});
  cases.push_back({10, "many errors", false, manyErrors});
}

} // namespace recurse::hard
