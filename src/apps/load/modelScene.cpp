/** @file
 * Camera and light for a model.
 */
#include "apps/load/modelScene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "apps/options/optionText.h"
#include "recurse/core/io/text.h"
#include "recurse/core/io/zipArchive.h"
#include "recurse/model/scene/importExpansion.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/scene/directives/loader.h"

namespace recurse::apps {

namespace {

std::string loweredExtension(const std::string& fileName) {
  return lowerCase(std::filesystem::path(fileName).extension().string());
}

/** Name of the importer of a file; null for an unknown extension. */
const char* importerOf(const std::string& fileName) {
  const std::string extension = loweredExtension(fileName);
  if (extension == ".md2") return "md2";
  if (extension == ".pk3" || extension == ".bsp") return "quake3map";
  for (const char* known :
       {".obj", ".gltf", ".glb", ".dae", ".fbx", ".stl", ".3ds",  ".ply", ".off",   ".x3d",
        ".x",   ".lwo",  ".dxf", ".ase", ".ac",  ".b3d", ".ms3d", ".md3", ".blend", ".3mf"})
    if (extension == known) return "mesh";
  return nullptr;
}

/** True if the centre of the model is in front of a camera, within its view. */
bool seesTheModel(const ImportedCamera& camera, const Bounds3d& bounds) {
  const Vec3d p = transformPoint(glm::inverse(camera.worldFromCamera), bounds.center());
  const double extent = p.z * std::tan(glm::radians(camera.fov / 2));
  return p.z > 0 && std::abs(p.x) < extent && std::abs(p.y) < extent;
}

/** Archives of the game that a file belongs to, in the order of the game, the file itself last. */
std::vector<std::string> gamePaths(const std::string& fileName) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::absolute(fileName).parent_path();
  const bool isMap = loweredExtension(fileName) == ".bsp";
  if (isMap && folder.filename() != "maps") return {fileName};
  std::vector<std::string> paths;
  std::error_code failure;
  for (fs::directory_iterator i(isMap ? folder.parent_path() : folder, failure), end; !failure && i != end;
       i.increment(failure)) {
    const std::string path = i->path().string();
    std::error_code other;
    if (loweredExtension(path) != ".pk3" || fs::equivalent(path, fileName, other)) continue;
    try {
      const ZipArchive archive(path);
      paths.push_back(path);
    } catch (const Error&) {
      // Unreadable archives are skipped.
    }
  }
  std::sort(paths.begin(), paths.end());
  paths.push_back(fileName);
  return paths;
}

[[noreturn]] void refuseCamera(const std::string& name, const std::string& list) {
  badUsage("--camera: there is no camera '" + name + "'; there " +
           (list.empty() ? "is none with a name" : "are: " + list));
}

/** Requested camera; else the first camera of the file that sees the model, if any does. */
const ImportedCamera* chosenCamera(const SceneImport& import, const std::string& name) {
  std::string list;
  for (const ImportedCamera& camera : import.cameras) {
    std::string spelling = camera.name;
    std::replace(spelling.begin(), spelling.end(), ' ', ':');
    if (name.empty() ? import.isInterior || seesTheModel(camera, import.bounds)
                     : name == camera.name || name == spelling)
      return &camera;
    list += (list.empty() ? "" : ", ") + spelling;
  }
  if (!name.empty()) refuseCamera(name, list);
  return nullptr;
}

/** A camera of the file, or one that sees all of the model from above and to the right of its front. */
std::string cameraText(const SceneImport& import, const std::string& name) {
  constexpr double FOV = 40;
  if (const ImportedCamera* found = chosenCamera(import, name)) {
    const ImportedCamera& camera = *found;
    return "Transform " + sceneText(glm::inverse(camera.worldFromCamera)) +
           "\nCamera \"perspective\" \"float fov\" " + sceneText(camera.fov) + "\n";
  }
  const Vec3d right = glm::cross(import.up, import.front), center = import.bounds.center();
  const Vec3d towards = glm::normalize(import.front + 0.5 * right + 0.4 * import.up);
  const double radius = std::max(0.5 * glm::length(import.bounds.diagonal()), 1e-30);
  const Vec3d eye = center + towards * (radius / std::sin(glm::radians(FOV / 2)));
  // Models are right-handed, and cameras are not: without the scale the picture would be a mirror image.
  return "Scale -1 1 1\nLookAt " + sceneText(eye) + "  " + sceneText(center) + "  " + sceneText(import.up) +
         "\nCamera \"perspective\" \"float fov\" " + sceneText(FOV) + "\n";
}

/** An even sky and a sun from the left of the camera, which together show a white surface as white. */
std::string lightText(const SceneImport& import) {
  if (import.hasLights) return {};
  const Vec3d right = glm::cross(import.up, import.front);
  const Vec3d from = 0.6 * import.front - 0.5 * right + import.up;
  return "LightSource \"infinite\" \"rgb L\" [ .5 .5 .5 ]\n"
         "LightSource \"distant\" \"rgb L\" [ 2 2 2 ] \"point3 from\" [ " +
         sceneText(from) + " ] \"point3 to\" [ 0 0 0 ]\n";
}

} // namespace

bool isModelFile(const std::string& fileName) { return importerOf(fileName) != nullptr; }

bool isSceneFile(const std::string& fileName) {
  return fileName.ends_with(".pbrt") || fileName.ends_with(".pbrt.gz");
}

void ModelChoice::addTo(CLI::App& command) {
  command.add_option("--map", map, "For a .pk3 with several maps: the name of one")->type_name("NAME");
  command
      .add_option("--camera", camera,
                  "Name of a camera of the scene or model, such as spawn:1 in a map of Quake III (default: "
                  "the first)")
      ->type_name("NAME");
}

std::string ModelChoice::text() const {
  return (map.empty() ? "" : " --map " + shellQuoted(map)) +
         (camera.empty() ? "" : " --camera " + shellQuoted(camera));
}

std::unique_ptr<ModelScene> modelScene(const std::string& fileName, const ModelChoice& choice,
                                       const std::string& folder, const std::string& outside,
                                       Diagnostics& diagnostics) {
  if (std::error_code error; !std::filesystem::exists(fileName, error))
    throw Error("cannot read " + fileName + ": " + (error ? error.message() : "no such file"));
  ParsedDirective shape;
  shape.type = importerOf(fileName);
  ParsedParameter file;
  file.type = "string";
  const bool isMap = shape.type == "quake3map";
  file.name = isMap ? "pak" : "filename";
  file.strings = isMap ? gamePaths(fileName) : std::vector<std::string>{fileName};
  shape.parameters.push_back(file);
  if (!isMap) { // an archive has all of its files inside
    ParsedParameter rule;
    rule.type = "string";
    rule.name = "outside";
    rule.strings = {outside};
    shape.parameters.push_back(rule);
  }
  if (!choice.map.empty()) {
    if (!isMap) badUsage("--map: is for maps of Quake III, .pk3 and .bsp, not for " + fileName);
    file.name = "map";
    file.strings = {choice.map};
    shape.parameters.push_back(file);
  }
  const auto import = plugIns().imports.make(shape, {"", folder}, diagnostics);
  if (!import) return nullptr;
  auto scene = std::make_unique<ModelScene>();
  scene->text = "# Made of " + std::filesystem::path(fileName).filename().string() +
                "\nFilm \"rgb\" \"integer xresolution\" 800 \"integer yresolution\" 600\n" +
                cameraText(*import, choice.camera) + "\nWorldBegin\n" + lightText(*import) + import->text;
  scene->files = std::make_shared<const MemoryFiles>(std::move(import->files));
  scene->filesRead = std::move(import->filesRead);
  for (const std::string& s : import->taken) scene->note += (scene->note.empty() ? "" : ", ") + s;
  for (size_t i = 0; i < import->leftOut.size(); ++i)
    scene->note += (i == 0 ? "; left out: " : ", ") + import->leftOut[i];
  return scene;
}

void requireCamera(const SceneDescription& scene, const std::string& name) {
  if (name.empty() || name == scene.cameraName) return;
  std::string list = scene.cameraName;
  for (const CameraDescription& other : scene.otherCameras)
    if (!other.cameraName.empty()) list += (list.empty() ? "" : ", ") + other.cameraName;
  refuseCamera(name, list);
}

SceneDescription loadSceneOrModel(const std::string& fileName, const ModelChoice& choice,
                                  Diagnostics& diagnostics, double frame) {
  if (!isModelFile(fileName)) {
    if (!choice.map.empty()) badUsage("--map is for models; " + fileName + " is a scene file");
    SceneDescription scene = loadScene(fileName, diagnostics, frame, choice.camera);
    if (!diagnostics.hasErrors()) requireCamera(scene, choice.camera);
    return scene;
  }
  const std::unique_ptr<ModelScene> model = modelScene(fileName, choice, "", "read", diagnostics);
  if (!model) {
    diagnostics.throwIfErrors();
    throw Error(fileName + ": cannot be used", ExitStatus::BAD_SCENE);
  }
  SceneDescription scene = parseScene(model->text, fileName + " as a scene", "", diagnostics);
  attachFiles(scene, model->files);
  scene.importNotes.push_back(model->note);
  scene.importedFiles = model->filesRead;
  return scene;
}

} // namespace recurse::apps
