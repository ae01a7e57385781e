/** @file
 * Expansion of imports: the pieces that importers make join the scene.
 */
#include "recurse/model/scene/importExpansion.h"

#include <algorithm>
#include <map>
#include <set>

#include "recurse/model/scene/keptParts.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/scene/directives/loader.h"

namespace recurse {

void addImportParameters(PlugIns& plugIns) {
  plugIns.imports.addToAll(
      {stringParameter(
          "camera", "",
          "name of a camera of the file; the scene's camera gets its position, if it has no name")},
      [](SceneImport& import, const Parameters& p, const ImportContext&) {
        if (!p.has("camera")) return;
        std::string names;
        for (size_t i = 0; i < import.cameras.size(); ++i) {
          const std::string& name = import.cameras[i].name;
          if (name == p.string("camera")) {
            import.chosen = i;
            return;
          }
          names += (names.empty() ? "\"" : ", \"") + name + "\"";
        }
        p.fail("camera", "the file has no camera \"" + p.string("camera") + "\"",
               names.empty() ? "no camera at all" : names);
      });
}

namespace {

/** Calls visit(directive) for each directive that a plug-in is made from. */
template <class Visit> void forEachDirective(SceneDescription& scene, const Visit& visit) {
  for (ParsedDirective* d :
       {&scene.film, &scene.camera, &scene.filter, &scene.sampler, &scene.integrator, &scene.accelerator})
    visit(*d);
  for (CameraDescription& other : scene.otherCameras) visit(other.camera);
  for (auto* list : {&scene.materials, &scene.areaLights})
    for (ParsedDirective& d : *list) visit(d);
  for (auto* map : {&scene.namedMaterials, &scene.media})
    for (auto& [name, d] : *map) visit(d);
  for (TextureDescription& t : scene.textures) visit(t.texture);
  for (ShapeDescription& s : scene.shapes) visit(s.shape);
  for (auto& [name, object] : scene.objects)
    for (ShapeDescription& s : object.shapes) visit(s.shape);
  for (LightDescription& l : scene.lights) visit(l.light);
}

class ImportExpander {
 public:
  ImportExpander(SceneDescription& scene, Diagnostics& diagnostics, bool lenient, KeptParts* kept)
      : scene(scene), diagnostics(diagnostics), lenient(lenient), kept(kept) {}

  void expand() {
    expand(scene.shapes, nullptr);
    for (auto& [name, object] : scene.objects) expand(object.shapes, &object);
    scene.objects.merge(newObjects);
    if (kept) kept->models.replace(std::move(models));
  }

 private:
  void expand(std::vector<ShapeDescription>& shapes, const ObjectDescription* object) {
    const PlugIns& all = plugIns();
    if (std::none_of(shapes.begin(), shapes.end(),
                     [&](const ShapeDescription& s) { return all.imports.find(s.shape.type); }))
      return;
    std::vector<ShapeDescription> before = std::move(shapes);
    shapes.clear();
    for (ShapeDescription& s : before) {
      if (!all.imports.find(s.shape.type)) {
        shapes.push_back(std::move(s));
        continue;
      }
      const ImportContext context{"import" + std::to_string(++count) + ":", folderOf(s.shape)};
      const std::string key = kept ? keyOf(s.shape) + context.prefix : "";
      std::shared_ptr<SceneImport> import = kept ? kept->models.take(key) : nullptr;
      if (kept) ++(import ? kept->models.kept : kept->models.made);
      if (!import) import = all.imports.make(s.shape, context, diagnostics, lenient);
      if (!import) continue;
      place(*import, s, object, shapes);
      if (kept) models.emplace(key, std::move(import));
    }
  }

  void place(const SceneImport& import, const ShapeDescription& at, const ObjectDescription* object,
             std::vector<ShapeDescription>& shapes) {
    SceneDescription piece =
        parseScene("WorldBegin\n" + import.text, at.shape.type + ", as imported", "", diagnostics);
    relocate(piece, at.shape.location);
    attachFiles(piece, std::make_shared<const MemoryFiles>(import.files));
    scene.sources.insert(scene.sources.end(), piece.sources.begin(), piece.sources.end());
    materialOffset =
        static_cast<int>(scene.materials.size()) - 1; // the piece's material 0 is the outer material
    areaLightOffset = static_cast<int>(scene.areaLights.size());
    scene.materials.insert(scene.materials.end(), piece.materials.begin() + 1, piece.materials.end());
    scene.areaLights.insert(scene.areaLights.end(), piece.areaLights.begin(), piece.areaLights.end());
    scene.textures.insert(scene.textures.end(), piece.textures.begin(), piece.textures.end());
    scene.namedMaterials.merge(piece.namedMaterials);
    for (ShapeDescription& s : piece.shapes) {
      adopt(s, at);
      move(s, at.worldFromObject, at.worldFromObjectLast);
      shapes.push_back(std::move(s));
    }
    for (auto& [name, o] : piece.objects)
      for (ShapeDescription& s : o.shapes) adopt(s, at);
    for (InstanceDescription& i : piece.instances) {
      if (object) { // the parser has flattened nested objects
        for (ShapeDescription s : piece.objects.at(i.object).shapes) {
          move(s, i.worldFromInstance, std::nullopt);
          move(s, at.worldFromObject, at.worldFromObjectLast);
          shapes.push_back(std::move(s));
        }
        continue;
      }
      if (at.worldFromObjectLast) i.worldFromInstanceLast = *at.worldFromObjectLast * i.worldFromInstance;
      i.worldFromInstance = at.worldFromObject * i.worldFromInstance;
      i.location = at.shape.location;
      scene.instances.push_back(std::move(i));
    }
    if (!object) newObjects.merge(piece.objects);
    placeLights(piece.lights, at, object != nullptr);
    if (const ImportedCamera* camera = import.chosenCamera()) placeCamera(*camera, at);
    scene.importedFiles.insert(scene.importedFiles.end(), import.filesRead.begin(), import.filesRead.end());
    noteContents(import, at);
  }

  void placeLights(std::vector<LightDescription>& lights, const ShapeDescription& at, bool inObject) {
    if (lights.empty()) return;
    if (inObject) {
      diagnostics.warning(at.shape.location, "lights of the file are left out: objects cannot contain lights",
                          "the Shape outside of ObjectBegin");
      return;
    }
    if (at.worldFromObjectLast)
      diagnostics.warning(at.shape.location,
                          "lights of the file do not move: they use the StartTime transform only");
    for (LightDescription& l : lights) {
      l.worldFromLight = at.worldFromObject * l.worldFromLight;
      scene.lights.push_back(std::move(l));
    }
  }

  void placeCamera(const ImportedCamera& camera, const ShapeDescription& at) {
    if (!scene.cameraName.empty()) {
      diagnostics.warning(at.shape.location,
                          "the camera \"" + scene.cameraName + "\" of the scene stays where it is",
                          "a scene whose camera has no \"name\" gets the position of the file's camera");
      return;
    }
    scene.worldFromCamera = at.worldFromObject * camera.worldFromCamera;
    scene.worldFromCameraLast.reset();
    if (at.worldFromObjectLast) scene.worldFromCameraLast = *at.worldFromObjectLast * camera.worldFromCamera;
  }

  /** Prefix of the files that a model becomes: its name, for messages. */
  static std::string folderOf(const ParsedDirective& shape) {
    std::string name = shape.type;
    for (const ParsedParameter& p : shape.parameters)
      if ((p.name == "filename" || p.name == "pak") && !p.strings.empty()) name = p.strings.front();
    const std::string quoted = sceneText(name);
    return quoted.substr(1, quoted.size() - 2) + "/";
  }

  /** Sets the locations in a piece to the Shape directive that imports it, for messages. */
  static void relocate(SceneDescription& piece, const SourceLocation& where) {
    forEachDirective(piece, [&where](ParsedDirective& d) {
      d.location = where;
      for (ParsedParameter& p : d.parameters) p.location = p.valueLocation = where;
    });
    const auto relocateShapes = [&where](std::vector<ShapeDescription>& shapes) {
      for (ShapeDescription& s : shapes) s.material.location = where;
    };
    relocateShapes(piece.shapes);
    for (auto& [name, object] : piece.objects) {
      object.location = where;
      relocateShapes(object.shapes);
    }
  }

  /** Gives a shape of a piece the graphics state of the Shape directive that imports it. */
  void adopt(ShapeDescription& s, const ShapeDescription& at) const {
    if (s.material.kind == MaterialReference::Kind::INDEX) {
      if (s.material.index == 0)
        s.material = at.material;
      else
        s.material.index += materialOffset;
    }
    s.areaLight = s.areaLight >= 0 ? s.areaLight + areaLightOffset : at.areaLight;
    s.medium = at.medium;
    s.reverseOrientation = s.reverseOrientation != at.reverseOrientation;
  }

  static void move(ShapeDescription& s, const Mat4d& by, const std::optional<Mat4d>& byLast) {
    if (byLast) s.worldFromObjectLast = *byLast * s.worldFromObject;
    s.worldFromObject = by * s.worldFromObject;
  }

  void noteContents(const SceneImport& import, const ShapeDescription& at) {
    const auto joined = [](const std::vector<std::string>& list) {
      std::string out;
      for (const std::string& s : list) out += (out.empty() ? "" : ", ") + s;
      return out;
    };
    scene.importNotes.push_back(at.shape.type + ": " + joined(import.taken) +
                                (import.leftOut.empty() ? "" : "; left out: " + joined(import.leftOut)));
  }

  SceneDescription& scene;
  Diagnostics& diagnostics;
  bool lenient;
  KeptParts* kept; ///< null: nothing is kept
  std::multimap<std::string, std::shared_ptr<SceneImport>> models;
  int count = 0, materialOffset = 0, areaLightOffset = 0;
  std::map<std::string, ObjectDescription> newObjects;
};

} // namespace

void attachFiles(SceneDescription& scene, const std::shared_ptr<const MemoryFiles>& files) {
  forEachDirective(scene, [&files](ParsedDirective& d) { d.files = files; });
}

bool hasImports(const SceneDescription& scene) {
  const auto anyImport = [](const std::vector<ShapeDescription>& shapes) {
    return std::any_of(shapes.begin(), shapes.end(), [](const ShapeDescription& s) {
      return plugIns().imports.find(s.shape.type) != nullptr;
    });
  };
  return anyImport(scene.shapes) || std::any_of(scene.objects.begin(), scene.objects.end(),
                                                [&](const auto& o) { return anyImport(o.second.shapes); });
}

void expandImports(SceneDescription& scene, Diagnostics& diagnostics, bool lenient, KeptParts* kept) {
  if (kept) kept->models.kept = kept->models.made = 0;
  ImportExpander(scene, diagnostics, lenient, kept).expand();
}

} // namespace recurse
