/** @file
 * Importers: plug-ins that a Shape directive names, and that turn a file of another kind (a model, a game
 * map) into a piece of a scene. The piece is a text of directives, which is read where the Shape stands, and
 * files that this text names: meshes as PLY, pictures as they were found. So `recurse convert` has only to
 * write both down, and everything that scene files can say is open to an importer.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

/** A view that the file proposes. */
struct ImportedCamera {
  std::string name;
  Mat4d worldFromCamera{1}; ///< pbrt's camera space: x right, y up, z forward
  double fov = 45;          ///< along the shorter axis of the film [degrees]
};

/** What an importer made. */
struct SceneImport {
  std::string text;                   ///< directives, as they stand after WorldBegin
  MemoryFiles files;                  ///< by the names that the text calls them
  std::vector<std::string> filesRead; ///< paths of what it was made of: the model, and what lies beside it
  std::vector<ImportedCamera> cameras;
  const ImportedCamera* chosen = nullptr; ///< of them, by the parameter "camera"
  Bounds3d bounds;                        ///< of all shapes
  Vec3d up{0, 1, 0}, front{0, 0, 1};      ///< of what the file shows
  bool isInterior = false;                ///< it is looked at from inside
  bool hasLights = false;
  std::vector<std::string> taken, leftOut; ///< for people: "3 materials", "2 animations"
};

struct ImportContext {
  std::string prefix; ///< of names of materials, textures and objects, so that two imports do not clash
  std::string folder; ///< prefix of the names of files
};

/** Puts a SceneImport together. */
class ImportWriter {
 public:
  ImportWriter(SceneImport& import, const ImportContext& context) : import(import), context(context) {}

  void line(const std::string& directives) { import.text += directives + "\n"; }
  /** A name that is new for materials, textures and objects of this scene, and looks like `hint`. */
  std::string uniqueName(const std::string& hint);
  /** Keeps a file; returns the name for the text. */
  std::string addFile(const std::string& hint, std::string content);
  /** The same with a file as it is. Throws Error where it cannot be read. */
  std::string copyFile(const std::string& path);
  /** `Shape "plymesh"` of the mesh, with the parameters given; `placement` is only for the bounds. */
  std::string meshShape(const std::string& hint, const MeshData& mesh, const Mat4d& placement,
                        const std::string& parameters = {});
  /** Defines a texture ("spectrum" or "float") from a picture that addFile returned. */
  std::string imageTexture(const char* kind, const std::string& file, const std::string& parameters = {});
  /** Defines a texture that nobody overlooks, for a picture that is missing. */
  std::string missingTexture();

 private:
  SceneImport& import;
  const ImportContext& context;
  std::map<std::string, int> used;
};

/** Text of values in scene files: with all digits, in quotes (what cannot stand there becomes '_'). */
std::string sceneText(double number);
std::string sceneText(const Vec3d& v);
std::string sceneText(const Mat4d& m); ///< column by column, in brackets
std::string sceneText(const std::string& name);

/** The bytes of a binary PLY file. */
std::string plyBytes(const MeshData& mesh);

/** A file's bytes. Throws Error with the reason. */
std::string readFileBytes(const std::string& path);
/** The file that a model calls `name`: beside it, by the last part of the name, whatever the case. Empty
 * where there is none. */
std::string findModelFile(const std::string& directory, const std::string& name);

} // namespace recurse
