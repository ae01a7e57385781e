/** @file
 * Import of models in every format that Assimp reads. PLY files have a separate reader, which reports the
 * position of errors in the file.
 */
#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <new>
#include <optional>
#include <unistd.h>
#include <utility>

#include <assimp/DefaultIOSystem.h>
#include <assimp/IOStream.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "importers/assimp/assimpScene.h"
#include "importers/files/outsideFiles.h"
#include "recurse/core/io/files.h"
#include "recurse/core/io/terminalText.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/mesh/plyFile.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Memory limits for Assimp, because numbers in damaged files may request any size. A triangle has more
 * than 10 bytes of text, which may be compressed, and takes about 1 kB during import. */
constexpr double MODEL_BYTES = 0x1p30, BYTES_PER_BYTE = 1000;

/** Notes the files that are read, and raises the memory limit for each. Files that may not be read, pipes
 * and devices appear to be missing. */
class NotingIoSystem : public Assimp::DefaultIOSystem {
 public:
  using MayRead = std::function<bool(const std::string& file)>;

  NotingIoSystem(std::vector<std::string>& read, MemoryCap& memory, MayRead mayRead)
      : read(read), memory(memory), mayRead(std::move(mayRead)) {}

  bool Exists(const char* file) const override {
    std::error_code missing;
    return std::filesystem::exists(file, missing) && specialKind(file).empty();
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (!specialKind(file).empty() || !mayRead(file)) return nullptr;
    Assimp::IOStream* stream = DefaultIOSystem::Open(file, mode);
    if (!stream) return stream;
    if (std::find(read.begin(), read.end(), file) == read.end())
      memory.raise(BYTES_PER_BYTE * double(stream->FileSize()));
    read.emplace_back(file);
    return stream;
  }

 private:
  std::vector<std::string>& read;
  MemoryCap& memory;
  const MayRead mayRead;
};

/**
 * Ends the program with an error that names the file where a fault of Assimp is reached, as by damaged files.
 * The signal handler has a separate stack, because endless recursion is among these faults.
 */
class FaultReport {
 public:
  explicit FaultReport(const std::string& path)
      : message("error: " + terminalText(path) + ": cannot be used: it is damaged, and Assimp fails on it\n"),
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
    reportMissingAnimation(p, path, "");
    ply.forWarnings([&](const std::string& what) { p.warn("filename", path + ": " + what); });
    ImportWriter out(import, context);
    out.line(out.meshShape(std::filesystem::path(path).stem().string(), ply.mesh, Mat4d(1)));
    import.filesRead = {path};
    import.taken = {std::to_string(ply.mesh.triangles.size()) + " triangles"};
  } catch (const SceneError&) {
    throw;
  } catch (const Error& e) {
    p.fail("filename", e.what());
  }
}

/** Vertices that are equal may have different bones and morph targets: those of a pose are not joined. */
unsigned postProcessing(const Parameters& p) {
  const unsigned always = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_ValidateDataStructure;
  return wantsPose(p) ? always : always | aiProcess_JoinIdenticalVertices;
}

/** Details of a glTF file, which a pose needs. Without one, JSON that Assimp alone accepts is no error. */
std::optional<GltfDetails> gltfDetails(const std::string& path, const Parameters& p) {
  std::error_code missing;
  if (!isGltf(path) || !std::filesystem::is_regular_file(path, missing)) return std::nullopt;
  std::optional<GltfDetails> details;
  try {
    details = readGltfDetails(path, readFileBytes(path));
  } catch (const Error& e) {
    if (wantsPose(p)) p.fail("filename", path + ": cannot be used: " + e.what());
    return std::nullopt;
  }
  if (!details->fault.empty()) p.fail("filename", path + ": cannot be used: " + details->fault);
  return details;
}

void importMeshFile(const Parameters& p, const ImportContext& context, SceneImport& import) {
  const std::string path = p.filePath("filename");
  if (path.ends_with(".ply") || path.ends_with(".PLY")) return importPly(path, p, context, import);
  const std::optional<GltfDetails> gltf = gltfDetails(path, p);
  std::optional<MemoryCap> memory(MODEL_BYTES);
  Assimp::Importer importer;
  // Lines and points have no surface.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_LINE | aiPrimitiveType_POINT);
  std::map<std::string, bool> answers; // answers by file, so that each is reported once
  const auto isAllowed = [&](const std::string& file) {
    std::error_code missing;
    if (!std::filesystem::exists(file, missing)) return true;
    const auto [found, isNew] = answers.emplace(file, true);
    if (isNew) found->second = mayRead(file, path, p);
    return found->second;
  };
  // The importer takes ownership of the handler.
  importer.SetIOHandler(new NotingIoSystem(import.filesRead, *memory, isAllowed));
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  std::string why = "it is damaged";
  const aiScene* scene = nullptr;
  try {
    const FaultReport report(path);
    scene = importer.ReadFile(path, postProcessing(p));
    if (*importer.GetErrorString()) why = importer.GetErrorString();
  } catch (const std::bad_alloc& e) {
    why = e.what();
  }
  memory.reset();
  if (why == std::bad_alloc().what())
    why = "it needs more memory than a file of this size should: the file is damaged, or memory is short";
  if (!scene || !scene->mRootNode) p.fail("filename", path + ": cannot be used: " + why);
  importAssimpScene(*scene, path, p, context, gltf ? &*gltf : nullptr, import);
}

} // namespace

void registerMeshFile(PlugIns& plugIns) {
  plugIns.imports.add(
      {{.name = "mesh",
        .summary = "A model in a format that Assimp reads (glTF, OBJ with MTL, COLLADA, FBX, 3DS, STL and "
                   "more), with its materials, pictures, lights and cameras.",
        .parameters = {stringParameter("filename", "", "the model").require(),
                       booleanParameter("materials", "true",
                                        "use the file's materials; false: the current material of the scene"),
                       booleanParameter("lights", "true", "use the file's lights and emitting materials"),
                       realParameter("time", "",
                                     "time of the animation [seconds], limited to its keyframes; without "
                                     "time and animation, the pose in which the file stores its meshes"),
                       stringParameter("animation", "",
                                       "name of the animation; by default the first one. Those without a "
                                       "name are \"animation 1\", \"animation 2\" and so on"),
                       outsideParameter()},
        .examples = {}},
       [](const Parameters& p, const ImportContext& context) {
         auto import = std::make_unique<SceneImport>();
         importMeshFile(p, context, *import);
         return import;
       }});
}

} // namespace recurse
