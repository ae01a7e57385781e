/** @file
 * Models of every kind that Assimp reads. PLY files are read by the reader of our own, which names the place
 * of what is wrong with them.
 */
#include <array>
#include <csignal>
#include <filesystem>
#include <unistd.h>

#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "model/assimpScene.h"
#include "model/plyFile.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

/** Notes which files are read. */
class NotingIoSystem : public Assimp::DefaultIOSystem {
 public:
  explicit NotingIoSystem(std::vector<std::string>& read) : read(read) {}

  Assimp::IOStream* Open(const char* file, const char* mode) override {
    Assimp::IOStream* stream = DefaultIOSystem::Open(file, mode);
    if (stream) read.emplace_back(file);
    return stream;
  }

 private:
  std::vector<std::string>& read;
};

/**
 * Assimp has faults that damaged files reach. While this lives, one ends the program with an error that names
 * the file. The handler has a stack of its own, because recursion without end is among them.
 */
class FaultReport {
 public:
  explicit FaultReport(const std::string& path)
      : message("error: " + path + ": cannot be used: it is damaged, and Assimp fails on it\n"),
        stack(STACK_BYTES) {
    current = this;
    stack_t own{};
    own.ss_sp = stack.data();
    own.ss_size = stack.size();
    ::sigaltstack(&own, &stackBefore);
    struct sigaction action {};
    action.sa_handler = [](int) {
      const ssize_t written = ::write(STDERR_FILENO, current->message.data(), current->message.size());
      ::_exit(written < 0 ? 1 : static_cast<int>(ExitStatus::BAD_SCENE));
    };
    action.sa_flags = SA_ONSTACK;
    for (size_t i = 0; i < SIGNALS.size(); ++i) ::sigaction(SIGNALS[i], &action, &before[i]);
  }
  ~FaultReport() {
    for (size_t i = 0; i < SIGNALS.size(); ++i) ::sigaction(SIGNALS[i], &before[i], nullptr);
    ::sigaltstack(&stackBefore, nullptr);
  }
  FaultReport(const FaultReport&) = delete;
  FaultReport& operator=(const FaultReport&) = delete;

 private:
  static constexpr std::array SIGNALS = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
  static constexpr size_t STACK_BYTES = 1 << 16;
  static inline const FaultReport* current = nullptr;
  std::string message;
  std::vector<char> stack;
  stack_t stackBefore{};
  std::array<struct sigaction, SIGNALS.size()> before{};
};

void importPly(const std::string& path, const Parameters& p, const ImportContext& context,
               SceneImport& import) {
  try {
    const PlyFile ply = readPly(path);
    ply.forWarnings([&](const std::string& what) { p.warn("filename", path + ": " + what); });
    ImportWriter out(import, context);
    out.line(out.meshShape(std::filesystem::path(path).stem().string(), ply.mesh, Mat4d(1)));
    import.filesRead = {path};
    import.taken = {std::to_string(ply.mesh.triangles.size()) + " triangles"};
  } catch (const Error& e) {
    p.fail("filename", e.what());
  }
}

void importMeshFile(const Parameters& p, const ImportContext& context, SceneImport& import) {
  const std::string path = p.filePath("filename");
  if (path.ends_with(".ply") || path.ends_with(".PLY")) return importPly(path, p, context, import);
  Assimp::Importer importer;
  // Lines and points have no surface.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_LINE | aiPrimitiveType_POINT);
  importer.SetIOHandler(new NotingIoSystem(import.filesRead)); // the importer's own from here
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  const aiScene* scene = [&] {
    const FaultReport report(path);
    return importer.ReadFile(path, aiProcess_Triangulate | aiProcess_SortByPType |
                                       aiProcess_JoinIdenticalVertices | aiProcess_ValidateDataStructure);
  }();
  if (!scene || !scene->mRootNode) {
    const std::string why = importer.GetErrorString();
    p.fail("filename", path + ": cannot be used: " + (why.empty() ? "it is damaged" : why));
  }
  importAssimpScene(*scene, path, p, context, import);
}

} // namespace

void registerMeshFile(PlugIns& plugIns) {
  plugIns.imports.add(
      {{.name = "mesh",
        .summary =
            "A model of a kind that Assimp reads (glTF, OBJ with MTL, COLLADA, FBX, 3DS, STL and more), with "
            "its materials, pictures, lights and cameras.",
        .parameters = {stringParameter("filename", "", "the model").require(),
                       booleanParameter(
                           "materials", "true",
                           "take the file's materials; false: the one that the Shape stands under"),
                       booleanParameter("lights", "true", "take the file's lights and emitting materials")},
        .examples = {}},
       [](const Parameters& p, const ImportContext& context) {
         auto import = std::make_unique<SceneImport>();
         importMeshFile(p, context, *import);
         return import;
       }});
}

} // namespace recurse
