/** @file
 * Loading with diagnostics, and the report of --check.
 */
#include "apps/load/loadedScene.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "apps/load/modelScene.h"
#include "apps/options/optionText.h"
#include "apps/run/console.h"
#include "recurse/core/image/imageTexture.h"
#include "recurse/core/math/hash.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/film/film.h"
#include "recurse/model/scene/importExpansion.h"
#include "recurse/model/scene/sceneImport.h"

namespace recurse::apps {

namespace {

std::string counted(size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string lobeNames(LobeSet lobes) {
  std::string out;
  const auto add = [&out](const char* name) { out += (out.empty() ? "" : ", ") + std::string(name); };
  if (lobes & REFLECTION) add("diffuse or glossy reflection");
  if (lobes & TRANSMISSION) add("diffuse or glossy transmission");
  if (lobes & MIRROR) add("mirror");
  if (lobes & REFRACTION) add("refraction");
  return out.empty() ? "none" : out;
}

std::string typeOf(const ParsedDirective& directive, const char* otherwise) {
  return directive.given() ? directive.type : otherwise;
}

/** Overrides for the same part of the picture with 1 / `reduction` of the pixels each way. */
SceneOverrides reduced(SceneOverrides overrides, const SceneDescription& description, int reduction) {
  if (reduction <= 1) return overrides;
  Diagnostics told; // reported again when the scene is built
  ParsedDirective directive = description.film;
  if (!directive.given()) directive.type = "rgb";
  const auto film = plugIns().films.make(directive, {}, told, true);
  if (!film) return overrides;
  if (overrides.width == 0 && overrides.cropWindow[0] == overrides.cropWindow[1]) {
    const auto part = [](int x, int size) { return double(x) / double(size); };
    overrides.cropWindow = {part(film->crop.x0, film->width), part(film->crop.x1, film->width),
                            part(film->crop.y0, film->height), part(film->crop.y1, film->height)};
  }
  overrides.width = std::max(1, (overrides.width > 0 ? overrides.width : film->width) / reduction);
  overrides.height = std::max(1, (overrides.height > 0 ? overrides.height : film->height) / reduction);
  return overrides;
}

/** Integrator of the file. A limit of depth is removed if a material is rendered as its medium: it would cut
 * off multiple scattering inside, which other renderers count as one event. */
ParsedDirective integratorOf(const SceneDescription& description, Diagnostics& diagnostics) {
  ParsedDirective integrator = description.integrator;
  const auto isMedium = [](const ParsedDirective& material) { return material.type == "subsurface"; };
  const auto isNamedMedium = [&](const auto& named) { return isMedium(named.second); };
  if (std::none_of(description.materials.begin(), description.materials.end(), isMedium) &&
      std::none_of(description.namedMaterials.begin(), description.namedMaterials.end(), isNamedMedium))
    return integrator;
  std::erase_if(integrator.parameters, [&](const ParsedParameter& p) {
    const bool limits = p.name == "maxdepth" && p.numbers != std::vector<double>{-1};
    if (limits)
      diagnostics.warning(
          p.location,
          "\"maxdepth\" is ignored: paths in \"subsurface\" materials have many scattering events",
          "--maxdepth N, to limit the length of paths anyway");
    return limits;
  });
  return integrator;
}

/** Makes the integrator of file and options anew. */
void makeIntegratorOf(LoadedScene& loaded, const IntegratorOptions& options, bool lenient,
                      Diagnostics& diagnostics) {
  loaded.integratorDirective = options.directive(integratorOf(loaded.description, diagnostics));
  loaded.integrator = makeIntegrator(loaded.integratorDirective, lenient, diagnostics);
}

} // namespace

LoadedScene loadAndBuild(const std::string& fileName, const LoadOverrides& overrides,
                         const IntegratorOptions& options, int reduction, AnimationFrame* frame) {
  const auto read = [&](Diagnostics& diagnostics) {
    return loadSceneOrModel(fileName, overrides.model, diagnostics, frame ? frame->number : 0);
  };
  return loadAndBuild(fileName, read, overrides, options, reduction, frame);
}

LoadedScene loadAndBuild(const std::string& name, const std::function<SceneDescription(Diagnostics&)>& read,
                         const LoadOverrides& overrides, const IntegratorOptions& options, int reduction,
                         AnimationFrame* frame) {
  const MemoryCap memory(availableMemory());
  LoadedScene out;
  out.fileName = name;
  Diagnostics diagnostics;
  const auto loadStart = std::chrono::steady_clock::now();
  KeptParts* kept = frame ? &frame->kept : nullptr;
  out.description = read(diagnostics);
  expandImports(out.description, diagnostics, overrides.lenient, kept);
  out.files = filesOf(out.description);
  out.loadSeconds = secondsSince(loadStart);
  const auto buildStart = std::chrono::steady_clock::now();
  makeIntegratorOf(out, options, overrides.lenient, diagnostics);
  // A description with errors is built, too, so that one run reports all errors.
  out.scene = buildScene(out.description, reduced(overrides, out.description, reduction), diagnostics, kept);
  out.buildSeconds = secondsSince(buildStart);
  renderByPathIfNeeded(out, diagnostics);
  diagnostics.throwIfErrors();
  out.warnings = diagnostics.all().size();
  const std::string warnings = diagnostics.format();
  if (!frame || frame->warnings != warnings) say(warnings);
  if (frame) frame->warnings = warnings;
  return out;
}

void replaceIntegrator(LoadedScene& loaded, const IntegratorOptions& options, bool lenient, bool warns) {
  Diagnostics diagnostics;
  makeIntegratorOf(loaded, options, lenient, diagnostics);
  renderByPathIfNeeded(loaded, diagnostics);
  diagnostics.throwIfErrors();
  if (warns) say(diagnostics.format());
}

void renderByPathIfNeeded(LoadedScene& loaded, Diagnostics& diagnostics) {
  if (!loaded.scene || !loaded.integrator) return;
  const std::string unsupported = unsupportedPart(*loaded.integrator, *loaded.scene);
  if (unsupported.empty()) return;
  diagnostics.warning(loaded.integratorDirective.location, "\"" + loaded.integratorDirective.type +
                                                               "\" cannot render " + unsupported +
                                                               ": \"path\" renders the scene instead");
  ParsedDirective path;
  path.type = "path";
  path.location = loaded.integratorDirective.location;
  for (const ParsedParameter& p : loaded.integratorDirective.parameters)
    if (p.name == "maxdepth") path.parameters.push_back(p);
  loaded.integratorDirective = path;
  loaded.integrator = makeIntegrator(path, false, diagnostics);
}

namespace {

/** Calls inMemory(content) for each file in memory that the description names, and onDisk(path) for each
 * other string that names an existing file: mesh, texture, spectrum. */
template <class InMemory, class OnDisk>
void forEachFile(const SceneDescription& d, const InMemory& inMemory, const OnDisk& onDisk) {
  const auto exists = [](const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(path, ignored);
  };
  const auto add = [&](const ParsedDirective& directive) {
    const auto addParameters = [&](const std::vector<ParsedParameter>& parameters) {
      for (const ParsedParameter& p : parameters)
        for (const std::string& name : p.strings) {
          if (directive.files)
            if (const auto found = directive.files->find(name); found != directive.files->end()) {
              inMemory(*found->second);
              continue;
            }
          if (name.empty()) continue;
          for (const std::string& directory :
               {p.directory.empty() ? directive.directory : p.directory, directive.topDirectory})
            if (const auto path = std::filesystem::path(directory) / name; exists(path)) {
              onDisk(path);
              break;
            }
        }
    };
    addParameters(directive.parameters);
    if (directive.attributes) addParameters(*directive.attributes);
  };
  for (const CameraDescription& other : d.otherCameras) add(other.camera);
  for (const ParsedDirective* one : // the film's file is written, not read
       {&d.camera, &d.filter, &d.sampler, &d.integrator, &d.accelerator})
    add(*one);
  for (const ParsedDirective& material : d.materials) add(material);
  for (const auto& [name, material] : d.namedMaterials) add(material);
  for (const TextureDescription& texture : d.textures) add(texture.texture);
  for (const ParsedDirective& light : d.areaLights) add(light);
  for (const auto& [name, medium] : d.media) add(medium);
  for (const ShapeDescription& shape : d.shapes) add(shape.shape);
  for (const auto& [name, object] : d.objects)
    for (const ShapeDescription& shape : object.shapes) add(shape.shape);
  for (const LightDescription& light : d.lights) add(light.light);
}

} // namespace

std::vector<std::string> filesOf(const SceneDescription& description) {
  std::set<std::string> files(description.importedFiles.begin(), description.importedFiles.end());
  std::error_code ignored;
  for (const auto& source : description.sources)
    if (std::filesystem::is_regular_file(source->name, ignored)) files.insert(source->name);
  forEachFile(
      description, [](const auto&) {},
      [&](const std::filesystem::path& path) { files.insert(path.string()); });
  return {files.begin(), files.end()};
}

std::string contentHash(const SceneDescription& description) {
  Hash hash;
  // Sorted texts do not depend on the locations of the files.
  std::set<std::string_view> texts;
  for (const auto& source : description.sources) texts.insert(source->text);
  for (const std::string_view text : texts) hash.add(std::string(text));
  forEachFile(
      description, [&](const auto& content) { hash.add(content); },
      [&](const std::filesystem::path& path) {
        std::ifstream in(path, std::ios::binary);
        hash.add(std::string(std::istreambuf_iterator<char>(in), {}));
      });
  return hash.text();
}

namespace {

/** List with commas between its items. */
class CommaList {
 public:
  void add(const std::string& item) { text += (text.empty() ? "" : ", ") + item; }
  void addCount(size_t count, const std::string& what) {
    if (count > 0) add(std::to_string(count) + " " + what);
  }
  std::string text;
};

std::string filmText(const FilmSettings& film) {
  std::string size = std::to_string(film.width) + "x" + std::to_string(film.height) + " pixels";
  if (film.crop.width() != film.width || film.crop.height() != film.height)
    size += ", of them " + std::to_string(film.crop.width()) + "x" + std::to_string(film.crop.height()) +
            " from column " + std::to_string(film.crop.x0) + ", row " + std::to_string(film.crop.y0);
  if (film.imagingRatio != 1) size += ", scaled by " + formatted("%.6g", double(film.imagingRatio));
  return size + ", file " + film.fileName;
}

/** Frame and keyframes of the animation; empty if nothing is animated. */
std::string animationText(const SceneDescription& description) {
  CommaList names;
  double first = 0, last = 0;
  for (const TrackDescription& track : description.tracks) {
    first = names.text.empty() ? track.firstTime : std::min(first, track.firstTime);
    last = names.text.empty() ? track.lastTime : std::max(last, track.lastTime);
    names.add(track.name);
  }
  if (names.text.empty()) return "";
  return "frame " + formatted("%.6g", description.frame) + "; keyframes from " + formatted("%.6g", first) +
         " to " + formatted("%.6g", last) + " of " + names.text;
}

/** Kind and name of the camera, and the names of others. */
std::string cameraText(const SceneDescription& description) {
  const auto nameOf = [](const CameraDescription& c) {
    return c.cameraName.empty() ? "without a name" : "\"" + c.cameraName + "\"";
  };
  CommaList others;
  for (const CameraDescription& other : description.otherCameras) others.add(nameOf(other));
  std::string out = typeOf(description.camera, "perspective");
  if (!description.cameraName.empty()) out += " " + nameOf(description);
  return out + (others.text.empty() ? "" : " (others: " + others.text + ")");
}

std::string shapesText(const SceneContents& c) {
  CommaList out;
  out.add(counted(c.shapes, "shape", "shapes"));
  if (c.triangles > 0) out.add(counted(c.triangles, "triangle", "triangles"));
  if (c.otherPrimitives > 0) out.add(counted(c.otherPrimitives, "other primitive", "other primitives"));
  if (c.instances > 0) out.add(counted(c.instances, "instance", "instances"));
  return out.text;
}

std::string lightsText(const SceneContents& c) {
  CommaList out;
  out.addCount(c.areaLights, "on surfaces");
  out.addCount(c.deltaLights, "at points or in one direction");
  out.addCount(c.environmentLights, "infinite");
  return out.text.empty() ? "none: the picture will be black" : out.text;
}

std::string memoryText(const LoadedScene& loaded, size_t layers) {
  const Scene& scene = *loaded.scene;
  CommaList out;
  out.add("geometry " + bytesText(double(scene.memoryBytes())));
  if (const auto [inMemory, inFiles] = textureMemory(); inMemory + inFiles > 0)
    out.add("textures " + bytesText(double(inMemory)) +
            (inFiles > 0 ? " and " + bytesText(double(inFiles)) + " in files" : "") +
            ", and the cache of pictures in use");
  out.add("film " + bytesText(Film::bytes(double(scene.film().crop.area()), double(layers))));
  if (const uint64_t emitted = loaded.integrator->photonsEmitted(scene); emitted > 0)
    out.add(formatted("photon map about %s, if each of %.3g emitted photons is stored once",
                      bytesText(photonMapBytes(double(emitted))).c_str(), double(emitted)));
  return out.text;
}

} // namespace

std::string sceneReport(const LoadedScene& loaded, size_t layers) {
  const Scene& scene = *loaded.scene;
  const SceneContents& c = scene.contents();
  const SceneDescription& d = loaded.description;
  std::string out = loaded.fileName + "\n";
  const auto line = [&out](const std::string& title, const std::string& text) {
    out += "  " + title + std::string(title.size() < 12 ? 12 - title.size() : 1, ' ') + text + "\n";
  };
  line("film", filmText(scene.film()));
  if (const std::string animation = animationText(d); !animation.empty()) line("animation", animation);
  line("camera", cameraText(d) + ", filter " + typeOf(d.filter, "as default"));
  line("samples", std::to_string(scene.sampler().pixelSamples) + " per pixel, seed " +
                      std::to_string(scene.sampler().seed));
  line("shapes", shapesText(c));
  for (const std::string& note : d.importNotes) line("from files", note);
  line("materials", std::to_string(c.materials));
  if (c.media > 0) line("media", std::to_string(c.media));
  line("lights", lightsText(c));
  line("scattering", lobeNames(c.lobes));
  line("integrator", integratorText(loaded.integratorDirective));
  line("memory", memoryText(loaded, layers));
  line("time",
       "read in " + durationText(loaded.loadSeconds) + ", built in " + durationText(loaded.buildSeconds));
  line("in short", loaded.warnings == 0
                       ? std::string("rendered as the file says")
                       : "rendered, except for " + counted(loaded.warnings, "thing in the warning above",
                                                           "things in the warnings above"));
  return out;
}

} // namespace recurse::apps
