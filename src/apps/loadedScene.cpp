/** @file
 * Loading with diagnostics, and the report of --check.
 */
#include "apps/loadedScene.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/modelScene.h"
#include "apps/optionText.h"
#include "recurse/core/hash.h"
#include "recurse/core/imageTexture.h"
#include "recurse/model/film.h"
#include "recurse/model/sceneImport.h"

namespace recurse::apps {

namespace {

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

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

} // namespace

LoadedScene loadAndBuild(const std::string& fileName, const SceneOverrides& overrides,
                         const IntegratorOptions& options) {
  LoadedScene out;
  out.fileName = fileName;
  Diagnostics diagnostics;
  const auto loadStart = std::chrono::steady_clock::now();
  out.description = loadSceneOrModel(fileName, diagnostics);
  expandImports(out.description, diagnostics, overrides.lenient);
  out.loadSeconds = secondsSince(loadStart);
  const auto buildStart = std::chrono::steady_clock::now();
  out.integratorDirective = options.directive(out.description.integrator);
  out.integrator = makeIntegrator(out.integratorDirective, overrides.lenient, diagnostics);
  // A description with errors is built as well, as far as that goes: one run tells all that is wrong.
  out.scene = buildScene(out.description, overrides, diagnostics);
  out.buildSeconds = secondsSince(buildStart);
  renderMediaByPath(out, diagnostics);
  diagnostics.throwIfErrors();
  out.warnings = diagnostics.all().size();
  std::fputs(diagnostics.format().c_str(), stderr);
  return out;
}

void renderMediaByPath(LoadedScene& loaded, Diagnostics& diagnostics) {
  if (!loaded.scene || !loaded.scene->hasMedia() || !loaded.integrator ||
      loaded.integrator->supportsMedia(*loaded.scene))
    return;
  diagnostics.warning(loaded.integratorDirective.location,
                      "\"" + loaded.integratorDirective.type +
                          "\" does not render media such as those of the scene: it is rendered by \"path\"");
  ParsedDirective path;
  path.type = "path";
  path.location = loaded.integratorDirective.location;
  for (const ParsedParameter& p : loaded.integratorDirective.parameters)
    if (p.name == "maxdepth") path.parameters.push_back(p);
  loaded.integratorDirective = path;
  loaded.integrator = makeIntegrator(path, false, diagnostics);
}

std::string contentHash(const SceneDescription& description) {
  Hash hash;
  const auto addFile = [&hash](const std::string& directory, const std::string& name) {
    const std::filesystem::path path = std::filesystem::path(directory) / name;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;
    std::ifstream in(path, std::ios::binary);
    hash.add(std::string(std::istreambuf_iterator<char>(in), {}));
    return true;
  };
  const auto add = [&](const ParsedDirective& directive) {
    const auto addParameters = [&](const std::vector<ParsedParameter>& parameters) {
      for (const ParsedParameter& p : parameters)
        for (const std::string& name : p.strings) // may be that of a file: mesh, texture, spectrum
          if (const auto inMemory =
                  directive.files ? directive.files->find(name) : MemoryFiles::const_iterator();
              directive.files && inMemory != directive.files->end())
            hash.add(*inMemory->second);
          else if (!name.empty() && !addFile(p.directory.empty() ? directive.directory : p.directory, name))
            addFile(directive.topDirectory, name);
    };
    addParameters(directive.parameters);
    if (directive.attributes) addParameters(*directive.attributes);
  };
  const SceneDescription& d = description;
  for (const auto& source : d.sources) hash.add(source->text);
  for (const ParsedDirective* one :
       {&d.film, &d.camera, &d.filter, &d.sampler, &d.integrator, &d.accelerator})
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
  return hash.text();
}

std::string sceneReport(const LoadedScene& loaded, size_t layers) {
  const Scene& scene = *loaded.scene;
  const SceneContents& c = scene.contents();
  const FilmSettings& film = scene.film();
  std::string out = loaded.fileName + "\n";
  const auto line = [&out](const std::string& title, const std::string& text) {
    out += "  " + title + std::string(title.size() < 12 ? 12 - title.size() : 1, ' ') + text + "\n";
  };
  std::string size = std::to_string(film.width) + "x" + std::to_string(film.height) + " pixels";
  if (film.crop.width() != film.width || film.crop.height() != film.height)
    size += ", of them " + std::to_string(film.crop.width()) + "x" + std::to_string(film.crop.height()) +
            " from column " + std::to_string(film.crop.x0) + ", row " + std::to_string(film.crop.y0);
  if (film.imagingRatio != 1) size += ", scaled by " + formatted("%.6g", double(film.imagingRatio));
  line("film", size + ", file " + film.fileName);
  line("camera", typeOf(loaded.description.camera, "perspective") + ", filter " +
                     typeOf(loaded.description.filter, "as default"));
  line("samples", std::to_string(scene.sampler().pixelSamples) + " per pixel, seed " +
                      std::to_string(scene.sampler().seed));
  std::string shapes = counted(c.shapes, "shape", "shapes");
  if (c.triangles > 0) shapes += ", " + counted(c.triangles, "triangle", "triangles");
  if (c.otherPrimitives > 0)
    shapes += ", " + counted(c.otherPrimitives, "other primitive", "other primitives");
  if (c.instances > 0) shapes += ", " + counted(c.instances, "instance", "instances");
  line("shapes", shapes);
  for (const std::string& note : loaded.description.importNotes) line("from files", note);
  line("materials", std::to_string(c.materials));
  std::string lights;
  const auto addLights = [&lights](size_t count, const char* where) {
    if (count > 0) lights += (lights.empty() ? "" : ", ") + std::to_string(count) + where;
  };
  addLights(c.areaLights, " on surfaces");
  addLights(c.deltaLights, " at a point or in one direction");
  addLights(c.environmentLights, " all around");
  if (c.media > 0) line("media", std::to_string(c.media));
  line("lights", lights.empty() ? "none: the picture will be black" : lights);
  line("scattering", lobeNames(c.lobes));
  std::string settings;
  for (const std::string& setting : settingsOf(loaded.integratorDirective))
    settings += (settings.empty() ? ": " : ", ") + setting;
  line("integrator", loaded.integratorDirective.type + settings);
  const double filmBytes = Film::bytes(double(film.crop.area()), double(layers));
  const auto [inMemory, inFiles] = textureMemory();
  std::string textures;
  if (inMemory + inFiles > 0)
    textures = ", textures " + bytesText(double(inMemory)) +
               (inFiles > 0 ? " and " + bytesText(double(inFiles)) + " in files" : "") +
               " besides the cache of those in use";
  line("memory",
       "geometry " + bytesText(double(scene.memoryBytes())) + textures + ", film " + bytesText(filmBytes));
  line("time",
       "read in " + durationText(loaded.loadSeconds) + ", built in " + durationText(loaded.buildSeconds));
  line("in short", loaded.warnings == 0 ? std::string("rendered as the file says")
                                        : "rendered, but for " +
                                              counted(loaded.warnings, "thing that a warning above tells of",
                                                      "things that warnings above tell of"));
  return out;
}

} // namespace recurse::apps
