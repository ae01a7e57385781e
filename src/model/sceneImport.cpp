/** @file
 * Writing pieces of scenes, and putting them in their place.
 */
#include "recurse/model/sceneImport.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "recurse/model/keptParts.h"
#include "recurse/model/plugIns.h"
#include "recurse/scene/loader.h"

namespace recurse {

namespace fs = std::filesystem;

std::string sceneText(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

std::string sceneText(const Vec3d& v) { return sceneText(v.x) + " " + sceneText(v.y) + " " + sceneText(v.z); }

std::string sceneText(const Mat4d& m) {
  std::string out = "[";
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) out += " " + sceneText(m[column][row]);
  return out + " ]";
}

std::string sceneText(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) out += c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20 ? '_' : c;
  return out + "\"";
}

std::string plyBytes(const MeshData& mesh) {
  std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                    std::to_string(mesh.positions.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!mesh.normals.empty()) out += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.uvs.empty()) out += "property float u\nproperty float v\n";
  out += "element face " + std::to_string(mesh.triangles.size()) +
         "\nproperty list uchar uint vertex_indices\nend_header\n";
  const auto put = [&out](auto value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  out.reserve(out.size() + 32 * mesh.positions.size() + 13 * mesh.triangles.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    put(Vec3f(mesh.positions[i]));
    if (!mesh.normals.empty()) put(Vec3f(mesh.normals[i]));
    if (!mesh.uvs.empty()) put(Vec2f(mesh.uvs[i]));
  }
  for (const glm::uvec3& t : mesh.triangles) {
    put(uint8_t{3});
    put(t);
  }
  return out;
}

std::string readFileBytes(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw Error(path + ": cannot be read: it is no file");
  std::ifstream in(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (!in || in.bad()) throw Error(path + ": cannot be read");
  return bytes;
}

namespace {

std::string lowered(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/** "%20" and the like of glTF's addresses. */
std::string withoutEscapes(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    unsigned value = 0;
    const char* digits = text.data() + i + 1;
    if (text[i] == '%' && i + 2 < text.size() &&
        std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2) {
      out += static_cast<char>(value);
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

} // namespace

std::string findModelFile(const std::string& directory, const std::string& name) {
  if (name.find('\0') != std::string::npos || name.empty()) return {};
  std::string slashed = name;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  std::error_code error;
  const auto isFile = [&error](const fs::path& path) { return fs::is_regular_file(path, error); };
  const fs::path base = directory.empty() ? "." : directory;
  for (const std::string& spelling : {slashed, withoutEscapes(slashed)}) {
    const fs::path last = fs::path(spelling).filename();
    for (const fs::path& path : {base / spelling, base / last})
      if (isFile(path)) return path.string();
    const fs::path folder = (base / spelling).parent_path();
    for (const fs::path& where : {folder, base})
      for (fs::directory_iterator i(where, error), end; !error && i != end; i.increment(error))
        if (lowered(i->path().filename().string()) == lowered(last.string()) && isFile(i->path()))
          return i->path().string();
  }
  return {};
}

// ---- ImportWriter

std::string ImportWriter::uniqueName(const std::string& hint) {
  std::string clean;
  for (const char c : hint.substr(0, 64))
    clean += std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' ? c : '_';
  const int times = used[clean]++;
  if (times == 0) return context.prefix + clean;
  // A second one gets a number, which another name may end with by chance.
  return context.prefix + uniqueName(clean + "_" + std::to_string(times + 1)).substr(context.prefix.size());
}

std::string ImportWriter::addFile(const std::string& hint, std::string content) {
  const fs::path path(hint);
  std::string name;
  for (int i = 1; name.empty() || import.files.contains(name); ++i) {
    std::string clean;
    for (const char c : path.stem().string().substr(0, 64))
      clean += std::isalnum(static_cast<unsigned char>(c)) || c == '-' ? c : '_';
    name =
        context.folder + clean + (i > 1 ? "_" + std::to_string(i) : "") + lowered(path.extension().string());
  }
  import.files[name] = std::make_shared<const std::string>(std::move(content));
  return name;
}

std::string ImportWriter::copyFile(const std::string& path) {
  std::string content = readFileBytes(path);
  import.filesRead.push_back(path);
  return addFile(path, std::move(content));
}

std::string ImportWriter::meshShape(const std::string& hint, const MeshData& mesh, const Mat4d& placement,
                                    const std::string& parameters) {
  for (const Vec3d& p : mesh.positions) import.bounds.add(transformPoint(placement, p));
  return "Shape \"plymesh\" \"string filename\" " + sceneText(addFile(hint + ".ply", plyBytes(mesh))) +
         (parameters.empty() ? "" : " " + parameters);
}

std::string ImportWriter::imageTexture(const char* kind, const std::string& file,
                                       const std::string& parameters) {
  const std::string name = uniqueName(fs::path(file).stem().string());
  line("Texture " + sceneText(name) + " \"" + kind + "\" \"imagemap\" \"string filename\" " +
       sceneText(file) + (parameters.empty() ? "" : " " + parameters));
  return name;
}

std::string ImportWriter::missingTexture() {
  const std::string name = uniqueName("missing");
  line("Texture " + sceneText(name) +
       " \"spectrum\" \"checkerboard\" \"float uscale\" 8 \"float vscale\" 8 \"rgb tex1\" [ .8 0 .8 ] "
       "\"rgb tex2\" [ .05 .05 .05 ]");
  return name;
}

// ---- putting pieces in their place

void addImportParameters(PlugIns& plugIns) {
  plugIns.imports.addToAll(
      {stringParameter("camera", "",
                       "name of a view in the file, which the scene's camera takes its place from")},
      [](SceneImport& import, const Parameters& p, const ImportContext&) {
        if (!p.has("camera")) return;
        std::string names;
        for (const ImportedCamera& camera : import.cameras) {
          if (camera.name == p.string("camera")) {
            import.chosen = &camera;
            return;
          }
          names += (names.empty() ? "\"" : ", \"") + camera.name + "\"";
        }
        p.fail("camera", "the file has no camera \"" + p.string("camera") + "\"",
               names.empty() ? "no camera at all" : names);
      });
}

namespace {

/** Calls visit(directive) for everything that a plug-in is made from. */
template <class Visit> void forEachDirective(SceneDescription& scene, const Visit& visit) {
  for (ParsedDirective* d :
       {&scene.film, &scene.camera, &scene.filter, &scene.sampler, &scene.integrator, &scene.accelerator})
    visit(*d);
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
      const ImportContext context{"import" + std::to_string(++count) + ":",
                                  "import" + std::to_string(count) + "/"};
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
    attachFiles(piece, std::make_shared<const MemoryFiles>(import.files));
    scene.sources.insert(scene.sources.end(), piece.sources.begin(), piece.sources.end());
    materialOffset =
        static_cast<int>(scene.materials.size()) - 1; // the piece's first stands for the outer one
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
      if (object) { // the parser has dealt with objects in objects
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
    if (object && !piece.lights.empty())
      diagnostics.warning(at.shape.location, "lights of the file are left out: an object has none",
                          "the Shape outside of ObjectBegin");
    else
      for (LightDescription& l : piece.lights) {
        l.worldFromLight = at.worldFromObject * l.worldFromLight;
        scene.lights.push_back(std::move(l));
      }
    if (import.chosen) {
      scene.worldFromCamera = at.worldFromObject * import.chosen->worldFromCamera;
      scene.worldFromCameraLast.reset();
    }
    scene.importedFiles.insert(scene.importedFiles.end(), import.filesRead.begin(), import.filesRead.end());
    noteContents(import, at);
  }

  /** Gives a shape of a piece what the Shape directive of the whole stands under. */
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
  KeptParts* kept; ///< null: nothing is
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
