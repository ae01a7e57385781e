/** @file
 * Text and files of imported pieces of scenes.
 */
#include "recurse/model/scene/sceneImport.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "recurse/core/io/text.h"

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

std::string findModelFile(const std::string& directory, const std::string& name) {
  if (name.find('\0') != std::string::npos || name.empty()) return {};
  std::string slashed = name;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  std::error_code error;
  const auto isFile = [&error](const fs::path& path) { return fs::is_regular_file(path, error); };
  const fs::path base = directory.empty() ? "." : directory;
  for (const std::string& spelling : {slashed, percentDecoded(slashed)}) {
    const fs::path last = fs::path(spelling).filename();
    for (const fs::path& path : {base / spelling, base / last})
      if (isFile(path)) return path.string();
    const fs::path folder = (base / spelling).parent_path();
    for (const fs::path& where : {folder, base})
      for (fs::directory_iterator i(where, error), end; !error && i != end; i.increment(error))
        if (lowerCase(i->path().filename().string()) == lowerCase(last.string()) && isFile(i->path()))
          return i->path().string();
  }
  return {};
}

// ---- ImportWriter

namespace {

/** The first `limit` bytes of a name, with all but ASCII letters, digits and `allowed` as '_'. */
std::string cleaned(const std::string& name, size_t limit, std::string_view allowed) {
  std::string clean = name.substr(0, limit);
  for (char& c : clean)
    if (!std::isalnum(static_cast<unsigned char>(c)) && allowed.find(c) == std::string_view::npos) c = '_';
  return clean;
}

} // namespace

std::string ImportWriter::uniqueName(const std::string& hint) {
  const std::string clean = cleaned(hint, 64, ".-");
  std::string name = clean;
  while (used.contains(name)) name = clean + "_" + std::to_string(++used[clean]);
  used[name] = 1;
  return context.prefix + name;
}

std::string ImportWriter::addFile(const std::string& hint, std::string content) {
  const fs::path path(hint);
  const std::string stem = cleaned(path.stem().string(), 64, "-"),
                    extension = cleaned(lowerCase(path.extension().string()), 16, ".");
  std::string name;
  for (int i = 1; name.empty() || import.files.contains(name); ++i) {
    name = context.folder + stem;
    if (i > 1) name.append("_").append(std::to_string(i));
    name += extension;
  }
  import.files[name] = std::make_shared<const std::string>(std::move(content));
  return name;
}

std::string ImportWriter::copyFile(const std::string& path) {
  std::string content = readFileBytes(path);
  import.filesRead.push_back(path);
  return addFile(path, std::move(content));
}

std::string ImportWriter::meshShape(const std::string& hint, const MeshData& mesh,
                                    const std::optional<Mat4d>& placement, const std::string& parameters) {
  if (placement)
    for (const Vec3d& p : mesh.positions) import.bounds.add(transformPoint(*placement, p));
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

} // namespace recurse
