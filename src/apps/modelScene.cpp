/** @file
 * Camera and light for a model.
 */
#include "apps/modelScene.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "recurse/model/plugIns.h"
#include "recurse/scene/loader.h"

namespace recurse::apps {

namespace {

std::string loweredExtension(const std::string& fileName) {
  std::string extension = std::filesystem::path(fileName).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

/** The importer of a file; null for what is not known as a model. */
const char* importerOf(const std::string& fileName) {
  const std::string extension = loweredExtension(fileName);
  if (extension == ".md2") return "md2";
  if (extension == ".pk3") return "quake3map";
  for (const char* known :
       {".obj", ".gltf", ".glb", ".dae", ".fbx", ".stl", ".3ds",  ".ply", ".off",   ".x3d",
        ".x",   ".lwo",  ".dxf", ".ase", ".ac",  ".b3d", ".ms3d", ".md3", ".blend", ".3mf"})
    if (extension == known) return "mesh";
  return nullptr;
}

/** True where the middle of everything lies in front of a camera, within its view. */
bool seesTheModel(const ImportedCamera& camera, const Bounds3d& bounds) {
  const Vec3d p = transformPoint(glm::inverse(camera.worldFromCamera), bounds.center());
  const double extent = p.z * std::tan(glm::radians(camera.fov / 2));
  return p.z > 0 && std::abs(p.x) < extent && std::abs(p.y) < extent;
}

/** The first camera of the file that sees the model, or one that sees all of it from above and to the right
 * of its front. */
std::string cameraText(const SceneImport& import) {
  constexpr double FOV = 40;
  for (const ImportedCamera& camera : import.cameras) {
    if (!import.isInterior && !seesTheModel(camera, import.bounds)) continue;
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

std::unique_ptr<ModelScene> modelScene(const std::string& fileName, const std::string& folder,
                                       Diagnostics& diagnostics) {
  ParsedDirective shape;
  shape.type = importerOf(fileName);
  ParsedParameter file;
  file.type = "string";
  file.name = shape.type == "quake3map" ? "pak" : "filename";
  file.strings = {fileName};
  shape.parameters.push_back(file);
  const auto import = plugIns().imports.make(shape, {"", folder}, diagnostics);
  if (!import) return nullptr;
  auto scene = std::make_unique<ModelScene>();
  scene->text = "# Made of " + std::filesystem::path(fileName).filename().string() +
                "\nFilm \"rgb\" \"integer xresolution\" 800 \"integer yresolution\" 600\n" +
                cameraText(*import) + "\nWorldBegin\n" + lightText(*import) + import->text;
  scene->files = std::make_shared<const MemoryFiles>(std::move(import->files));
  scene->filesRead = std::move(import->filesRead);
  for (const std::string& s : import->taken) scene->note += (scene->note.empty() ? "" : ", ") + s;
  for (size_t i = 0; i < import->leftOut.size(); ++i)
    scene->note += (i == 0 ? "; left out: " : ", ") + import->leftOut[i];
  return scene;
}

SceneDescription loadSceneOrModel(const std::string& fileName, Diagnostics& diagnostics, double frame) {
  if (!isModelFile(fileName)) return loadScene(fileName, diagnostics, frame);
  const std::unique_ptr<ModelScene> model = modelScene(fileName, "", diagnostics);
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
