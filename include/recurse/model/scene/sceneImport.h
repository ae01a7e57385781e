/** @file
 * Importers: plug-ins named by a Shape directive, which convert a file of a foreign format (a model, a game
 * map) to a part of a scene. The part consists of a text of directives, parsed in place of the Shape, and the
 * files named in this text: meshes as PLY, and pictures unchanged. `recurse convert` therefore only writes
 * both to disk, and an importer can use all features of scene files.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

/** View proposed by the imported file. */
struct ImportedCamera {
  std::string name;
  Mat4d worldFromCamera{1}; ///< to the space of SceneImport::text; pbrt's camera: x right, y up, z forward
  double fov = 45;          ///< along the shorter axis of the film [degrees]
};

/** Result of an importer. */
struct SceneImport {
  std::string text;                   ///< directives, valid after WorldBegin
  MemoryFiles files;                  ///< by their names in the text
  std::vector<std::string> filesRead; ///< paths of all sources: the model, and files beside it
  std::vector<ImportedCamera> cameras;
  std::optional<size_t> chosen;            ///< index in `cameras`, by the parameter "camera"
  Bounds3d bounds;                         ///< of all shapes, in the space of `text`
  Vec3d up{0, 1, 0}, front{0, 0, 1};       ///< directions that the model's top and front face, unit
  bool isInterior = false;                 ///< true: the model is viewed from inside
  bool hasLights = false;                  ///< false: a sky and a sun are added where the model is the scene
  std::vector<std::string> taken, leftOut; ///< lists for messages: "3 materials", "2 animations"

  /** Camera chosen by the parameter "camera"; null: none. */
  const ImportedCamera* chosenCamera() const { return chosen ? &cameras[*chosen] : nullptr; }
};

/** Arguments of importers besides parameters. */
struct ImportContext {
  std::string prefix; ///< of names of materials, textures and objects, so that imports do not clash
  std::string folder; ///< prefix of the names of files
};

/** Builder of a SceneImport. `import` and `context` must outlive it. */
class ImportWriter {
 public:
  ImportWriter(SceneImport& import, const ImportContext& context) : import(import), context(context) {}

  void line(const std::string& directives) { import.text += directives + "\n"; }
  /** New unique name for a material, texture or object of this import: the prefix, the first 64 bytes of
   * `hint` with all but letters, digits, '.' and '-' as '_', and a number where it is repeated. */
  std::string uniqueName(const std::string& hint);
  /** Adds a file; returns its unique name for the text, derived from `hint` with its extension. */
  std::string addFile(const std::string& hint, std::string content);
  /** addFile() of a file on the disk, whose path is added to SceneImport::filesRead. Throws Error where it
   * cannot be read. */
  std::string copyFile(const std::string& path);
  /** Adds a file with the mesh; returns the directive `Shape "plymesh"` that names it, with `parameters`, for
   * line(). The mesh transformed by `placement` extends the bounds; the caller writes the Transform. No
   * placement: an object; the caller extends the bounds by each instance. */
  std::string meshShape(const std::string& hint, const MeshData& mesh, const std::optional<Mat4d>& placement,
                        const std::string& parameters = {});
  /** Defines a texture of a kind ("spectrum" or "float") with a picture that addFile() returned; returns its
   * name. */
  std::string imageTexture(const char* kind, const std::string& file, const std::string& parameters = {});
  /** Defines a conspicuous spectrum texture in place of a missing picture; returns its name. */
  std::string missingTexture();

 private:
  SceneImport& import;
  const ImportContext& context;
  std::map<std::string, int> used; ///< names, with the number of the last repetition
};

/** Scene-file text of a value. Numbers have as many digits as identify them. Names are in quotes, with
 * quotes, backslashes and control characters as '_'. */
std::string sceneText(double number);
std::string sceneText(const Vec3d& v);
std::string sceneText(const Mat4d& m); ///< column by column, in brackets
std::string sceneText(const std::string& name);

/** Bytes of a binary PLY file, in single precision; tangents are omitted. */
std::string plyBytes(const MeshData& mesh);

/** Bytes of a file. Throws Error with the reason. */
std::string readFileBytes(const std::string& path);
/** Path of the file that a model refers to as `name`: at this path from `directory`, else in the path's
 * folder or in `directory` by the last component, whose case is ignored. Percent escapes are decoded where
 * the name itself is not found. Empty where there is none. */
std::string findModelFile(const std::string& directory, const std::string& name);

} // namespace recurse
