/** @file
 * Triangle meshes from PLY files.
 */
#include "recurse/model/mesh/displacement.h"
#include "recurse/model/mesh/plyFile.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

PlyFile readOrFail(const Parameters& p, const FileReference& file) {
  try {
    return readPly(file);
  } catch (const Error& e) {
    p.fail("filename", e.what());
  }
}

std::unique_ptr<Shape> makePlyMesh(const Parameters& p, const ShapeContext& context) {
  const FileReference file = p.file("filename");
  PlyFile ply = readOrFail(p, file);
  ply.forWarnings([&](const std::string& what) { p.warn("filename", file.path + ": " + what); });
  try {
    return makeDisplacedMesh(std::move(ply.mesh), p, context);
  } catch (const SceneError&) {
    throw;
  } catch (const Error& e) { // errors of the mesh do not name the file
    p.fail("filename", file.path + ": " + e.what());
  }
}

} // namespace

void registerPlyMesh(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "plymesh",
        .summary = "Triangles and polygons from a PLY file.",
        .parameters = withDisplacement(
            {stringParameter("filename", "",
                             "PLY file, text or binary, also compressed with gzip; vertices need x y z, and "
                             "may have nx ny nz, and u v, s t, texture_u texture_v or texture_s texture_t")
                 .require()}),
        .examples = {}},
       makePlyMesh});
}

} // namespace recurse
