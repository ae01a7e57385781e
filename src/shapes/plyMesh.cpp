/** @file
 * The shape of a PLY file.
 */
#include "model/plyFile.h"
#include "recurse/model/displacement.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

std::unique_ptr<Shape> makePlyMesh(const Parameters& p, const ShapeContext& context) {
  const FileReference file = p.file("filename");
  const std::string& path = file.path;
  try {
    PlyMesh read = readPlyMesh(file);
    if (read.normalsLeftOut > 0)
      p.warn("filename", path + ": " + std::to_string(read.normalsLeftOut) +
                             " vertices have normals that are not finite; faces are shaded without them");
    if (read.brokenVertices > 0)
      p.warn("filename", path + ": " + std::to_string(read.brokenVertices) +
                             " vertices are not finite; no face uses them");
    return makeDisplacedMesh(std::move(read.mesh), p, context);
  } catch (const SceneError&) {
    throw;
  } catch (const Error& e) {
    const std::string what = e.what();
    p.fail("filename", what.rfind(path, 0) == 0 ? what : path + ": " + what);
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
