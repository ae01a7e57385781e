/** @file
 * Animations in files.
 */
#include "recurse/core/image/animationFile.h"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse {

namespace {

namespace fs = std::filesystem;

std::string animationExtension(const std::string& fileName) {
  return lowerCase(fs::path(fileName).extension().string());
}

bool isVideo(const std::string& fileName) { return animationExtension(fileName) == ".mp4"; }

bool hasFfmpeg() {
  const char* const path = std::getenv("PATH");
  std::string folders = path ? path : "";
  for (size_t begin = 0; begin <= folders.size();) {
    const size_t end = std::min(folders.find(':', begin), folders.size());
    if (end > begin && ::access((folders.substr(begin, end - begin) + "/ffmpeg").c_str(), X_OK) == 0)
      return true;
    begin = end + 1;
  }
  return false;
}

/** Folder for the time of a conversion. */
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code failure;
    const fs::path parent = fs::temp_directory_path(failure);
    if (failure) throw Error("there is no folder for temporary files; is $TMPDIR one?");
    name = (parent / "recurse-film-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw Error("cannot make a folder in " + parent.string());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(name, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string file(const std::string& inside) const { return name + "/" + inside; }
  std::string name;
};

std::vector<unsigned char> contentOf(const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/** Runs ffmpeg in the folder; its messages go to ffmpeg.log there. Returns whether it succeeded. */
bool runFfmpeg(const TemporaryFolder& folder, const std::string& rate) {
  const pid_t child = ::fork();
  if (child < 0) throw Error("cannot start a process for ffmpeg");
  if (child == 0) {
    const int log =
        ::chdir(folder.name.c_str()) == 0 ? ::open("ffmpeg.log", O_WRONLY | O_CREAT | O_TRUNC, 0600) : -1;
    const int nothing = ::open("/dev/null", O_RDWR);
    if (log < 0 || nothing < 0 || ::dup2(nothing, STDIN_FILENO) < 0 || ::dup2(nothing, STDOUT_FILENO) < 0 ||
        ::dup2(log, STDERR_FILENO) < 0)
      ::_exit(1);
    // Most players need an even size, and colours with half the resolution.
    ::execlp("ffmpeg", "ffmpeg", "-v", "error", "-y", "-framerate", rate.c_str(), "-i", "%06d.png", "-vf",
             "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "film.mp4",
             nullptr);
    ::_exit(1);
  }
  int status = 0;
  pid_t ended;
  do ended = ::waitpid(child, &status, 0);
  while (ended < 0 && errno == EINTR);
  return ended == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/** MP4 file of PNG files. */
std::vector<unsigned char> encodeVideo(const std::string& fileName,
                                       const std::vector<std::vector<unsigned char>>& frames,
                                       double framesPerSecond) {
  const TemporaryFolder folder;
  for (size_t i = 0; i < frames.size(); ++i) {
    AtomicFile picture(folder.file(formatted("%06zu.png", i)));
    picture.write(frames[i].data(), frames[i].size());
    picture.commit();
  }
  const bool isDone = runFfmpeg(folder, formatted("%.9g", framesPerSecond));
  std::vector<unsigned char> film = contentOf(folder.file("film.mp4"));
  if (isDone && !film.empty()) return film;
  const std::vector<unsigned char> said = contentOf(folder.file("ffmpeg.log"));
  throw Error(fileName + ": ffmpeg failed: " + std::string(said.begin(), said.end()));
}

} // namespace

bool isAnimationFormat(const std::string& fileName) {
  return isVideo(fileName) || animationExtension(fileName) == ".apng";
}

void checkAnimationWritable(const std::string& fileName) {
  if (!isAnimationFormat(fileName) && animationExtension(fileName) != ".png")
    throw Error(fileName + ": cannot be written as a film; accepted: .png .apng .mp4", ExitStatus::BAD_USAGE);
  if (isVideo(fileName) && !hasFfmpeg())
    throw Error(fileName + ": needs the program ffmpeg, which is not in the PATH: install it (Debian: apt "
                           "install ffmpeg), or write an animated PNG (.apng)",
                ExitStatus::BAD_USAGE);
  checkFileWritable(fileName);
}

void AnimationFile::add(const Image& encoded) {
  if (frames.empty()) {
    width = encoded.width;
    height = encoded.height;
  } else if (encoded.width != width || encoded.height != height) {
    throw Error(fileName + ": the frames of a film have one size");
  }
  frames.push_back(encodedPng(encoded));
}

void AnimationFile::write() const {
  const std::vector<unsigned char> bytes = isVideo(fileName) ? encodeVideo(fileName, frames, framesPerSecond)
                                                             : animatedPng(frames, framesPerSecond);
  AtomicFile file(fileName);
  file.write(bytes.data(), bytes.size());
  file.commit();
}

} // namespace recurse
