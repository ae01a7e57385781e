/** @file
 * Triangle meshes from PLY files.
 */
#include "model/plyFile.h"
#include "recurse/model/displacement.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

std::unique_ptr<Shape> makePlyMesh(const Parameters& p, const ShapeContext& context) {
  const FileReference file = p.file("filename");
  try {
    PlyFile ply = readPly(file);
    ply.forWarnings([&](const std::string& what) { p.warn("filename", file.path + ": " + what); });
    return makeDisplacedMesh(std::move(ply.mesh), p, context);
  } catch (const SceneError&) {
    throw;
  } catch (const Error& e) {
    const std::string what = e.what();
    p.fail("filename", what.rfind(file.path, 0) == 0 ? what : file.path + ": " + what);
  }
}

} // namespace

void registerPlyMesh(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "plymesh",
        .summary = "Triangles and polygons from a PLY file.",
        .parameters = withDisplacement(
            {stringParameter("filename", "",
                             "PLY file, text or binary, also compressed with gzip; vertices have x y z, "
                             "and may have nx ny nz, and u v, s t, texture_u texture_v or "
                             "texture_s texture_t")
                 .require()}),
        .examples = {}},
       makePlyMesh});
}

} // namespace recurse
