/** @file
 * Models of Quake II and their skins.
 */
#include <filesystem>

#include "importers/files/outsideFiles.h"
#include "importers/md2/md2Model.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Md2Import {
 public:
  Md2Import(const Parameters& p, const ImportContext& context, SceneImport& import)
      : p(p), import(import), out(import, context), path(p.filePath("filename")), bytes(readFileBytes(path)),
        model(path, bytes) {}

  void run() {
    import.filesRead = {path};
    import.up = {0, 0, 1};
    import.front = {1, 0, 0};
    const double frame = p.real("frame");
    if (frame < 0 || frame > double(model.frames() - 1))
      p.fail("frame", path + " has no frame " + sceneText(frame),
             "0 to " + std::to_string(model.frames() - 1));
    const MeshData mesh = model.pose(frame);
    std::string before;
    if (p.boolean("materials")) {
      const std::string skin = skinTexture();
      before = "Material \"diffuse\" \"texture reflectance\" " + sceneText(skin) + "\n";
    }
    const std::string shape = out.meshShape(std::filesystem::path(path).stem().string(), mesh, Mat4d(1));
    out.line("AttributeBegin\n" + before + shape + "\nAttributeEnd");
    import.taken = {std::to_string(mesh.triangles.size()) + " triangles",
                    "frame " + sceneText(frame) + " of " + std::to_string(model.frames()) + " (" +
                        model.animations() + ")"};
  }

 private:
  // ---- the skin

  std::string skinTexture() {
    if (p.has("skin")) {
      const std::string skin = p.filePath("skin");
      return out.imageTexture("spectrum", out.copyFile(skin));
    }
    std::vector<std::string> names = model.skins();
    names.push_back(
        std::filesystem::path(path).stem().string()); // many have an unlisted picture of their name
    const std::string directory = std::filesystem::path(path).parent_path().string();
    const auto isThere = [&](const std::string& file) { return !file.empty() && mayRead(file, path, p); };
    for (const std::string& name : names) {
      if (std::string found = findModelFile(directory, name); found != path && isThere(found))
        return out.imageTexture("spectrum", out.copyFile(found));
      for (const char* extension : {".pcx", ".png", ".jpg", ".tga", ".bmp"}) {
        const std::string found =
            findModelFile(directory, std::filesystem::path(name).replace_extension(extension).string());
        if (isThere(found)) return out.imageTexture("spectrum", out.copyFile(found));
      }
    }
    p.warn("filename",
           path + ": its skin \"" + names.front() + "\" does not exist; a checkerboard replaces it",
           "\"string skin\" with the picture's file");
    return out.missingTexture();
  }

  const Parameters& p;
  SceneImport& import;
  ImportWriter out;
  std::string path, bytes;
  Md2Model model;
};

} // namespace

void registerMd2(PlugIns& plugIns) {
  plugIns.imports.add(
      {{.name = "md2",
        .summary =
            "A model of Quake II, with the pose between two keyframes; +z is up, and it looks along +x.",
        .parameters =
            {stringParameter("filename", "", "the model").require(),
             realParameter("frame", "0",
                           "keyframe, from 0; fractions interpolate the positions between two keyframes"),
             stringParameter("skin", "",
                             "picture of the surface (also PCX); by default the one that the model names, or "
                             "with the name of the model"),
             booleanParameter("materials", "true", "use the skin; false: the current material of the scene"),
             outsideParameter()},
        .examples = {}},
       [](const Parameters& p, const ImportContext& context) {
         auto import = std::make_unique<SceneImport>();
         try {
           Md2Import(p, context, *import).run();
         } catch (const SceneError&) {
           throw;
         } catch (const Error& e) {
           p.fail("filename", e.what());
         }
         return import;
       }});
}

} // namespace recurse
