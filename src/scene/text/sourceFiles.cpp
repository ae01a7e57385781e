/** @file
 * Reading of scene files.
 */
#include "scene/text/sourceFiles.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <zlib.h>

namespace recurse::sceneFile {

namespace fs = std::filesystem;

namespace {

/** Limit of the text after decompression, beyond which it is an accident or an attack. */
constexpr size_t MAX_TEXT_BYTES = size_t(4) << 30;
/** Text compresses to about a tenth; ratios near the limit of deflate, a thousandth, are an attack. */
constexpr size_t LARGE_TEXT_BYTES = size_t(256) << 20, MAX_COMPRESSION = 200;

std::string systemReason(int error) { return error ? std::strerror(error) : "it cannot be read"; }

/** std::filesystem::path and the system calls read a name only up to its first zero byte. */
bool isUsableName(const std::string& name) { return !name.empty() && name.find('\0') == std::string::npos; }

} // namespace

std::string joinPath(const std::string& directory, const std::string& name) {
  if (directory.empty() || directory == "." || fs::path(name).is_absolute()) return name;
  return (fs::path(directory) / name).string();
}

std::string directoryOf(const std::string& path) { return fs::path(path).parent_path().string(); }

bool isRegularFile(const std::string& path) {
  std::error_code error;
  return isUsableName(path) && fs::is_regular_file(path, error);
}

std::string findFile(const std::string& name, const std::string& directory, const std::string& topDirectory,
                     std::string& tried) {
  tried.clear();
  if (!isUsableName(name)) {
    tried = "(an empty name)";
    return {};
  }
  std::string previous;
  for (const std::string& base : {directory, topDirectory}) {
    const std::string path = joinPath(base, name);
    if (path == previous) continue;
    if (isRegularFile(path)) return path;
    tried += (tried.empty() ? "" : ", ") + path;
    std::error_code error;
    if (fs::exists(path, error)) tried += " (not a regular file)";
    previous = path;
  }
  return {};
}

std::string readTextFile(const std::string& path) {
  std::error_code error;
  if (!isUsableName(path)) throw Error("cannot read a file without a name");
  const fs::file_status status = fs::status(path, error);
  if (error || !fs::exists(status))
    throw Error("cannot read " + path + ": " + (error ? error.message() : "no such file"));
  if (!fs::is_regular_file(status)) throw Error("cannot read " + path + ": it is not a regular file");
  const auto fileBytes = fs::file_size(path, error);
  if (error) throw Error("cannot read " + path + ": " + error.message());
  // Files of the kernel report a size of zero, and some never end.
  if (fileBytes == 0) return {};
  if (fileBytes > MAX_TEXT_BYTES) throw Error("cannot read " + path + ": it is larger than 4 GiB");
  errno = 0;
  gzFile file = gzopen(path.c_str(), "rb");
  if (!file) throw Error("cannot read " + path + ": " + systemReason(errno));
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> closer(file, gzclose);
  gzbuffer(file, 1 << 18);
  std::string text;
  text.reserve(fileBytes + 1);
  constexpr unsigned CHUNK = 1 << 20;
  std::vector<char> chunk(CHUNK);
  for (;;) {
    const int got = gzread(file, chunk.data(), CHUNK);
    if (got < 0) {
      int code = 0;
      const std::string reason = gzerror(file, &code);
      throw Error("cannot read " + path + ": " + (code == Z_ERRNO ? systemReason(errno) : reason));
    }
    if (got == 0) break;
    if (text.size() + static_cast<size_t>(got) > MAX_TEXT_BYTES)
      throw Error("cannot read " + path + ": it is larger than 4 GiB after decompression");
    if (text.size() > LARGE_TEXT_BYTES && text.size() / fileBytes > MAX_COMPRESSION)
      throw Error("cannot read " + path + ": its compression ratio is too high for a scene");
    text.append(chunk.data(), static_cast<size_t>(got));
  }
  // At the end of truncated compressed data, gzread reports no error, but gzerror does.
  int code = 0;
  const std::string reason = gzerror(file, &code);
  if (code == Z_BUF_ERROR) throw Error("cannot read " + path + ": the compressed data is cut off");
  if (code != Z_OK && code != Z_STREAM_END) throw Error("cannot read " + path + ": " + reason);
  return text;
}

const Source& SourceFiles::open(const std::string& path) {
  std::error_code error;
  std::string canonical = fs::weakly_canonical(path, error).string();
  if (error) canonical = path;
  if (const auto known = files.find(canonical); known != files.end()) return *known->second;
  auto source = std::make_unique<Source>();
  source->text = std::make_shared<const SourceText>(SourceText{path, readTextFile(path)});
  source->directory = directoryOf(path);
  source->canonical = canonical;
  return *(files[canonical] = std::move(source));
}

const Source& SourceFiles::addText(std::string text, const std::string& name, const std::string& directory) {
  auto source = std::make_unique<Source>();
  source->text = std::make_shared<const SourceText>(SourceText{name, std::move(text)});
  source->directory = directory;
  texts.push_back(std::move(source));
  return *texts.back();
}

std::vector<std::shared_ptr<const SourceText>> SourceFiles::all() const {
  std::vector<std::shared_ptr<const SourceText>> out;
  for (const auto& [path, source] : files) out.push_back(source->text);
  for (const auto& source : texts) out.push_back(source->text);
  return out;
}

} // namespace recurse::sceneFile
