/** @file
 * libFuzzer target: any text at all as a scene file, and then as parameters of plug-ins. Nothing may crash,
 * hang, or throw anything but the errors that the interfaces promise.
 */
#include <cstdlib>
#include <string>
#include <unistd.h>

#include "fuzz/sceneExercise.h"

namespace {

/** A directory of its own without any files, so that a name in the input finds nothing by chance. */
struct EmptyDirectory {
  EmptyDirectory() {
    char name[] = "/tmp/recurse-fuzz-XXXXXX";
    if (!mkdtemp(name)) std::abort();
    path = name;
  }
  ~EmptyDirectory() { rmdir(path.c_str()); }
  std::string path;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const EmptyDirectory DIRECTORY;
  recurse::exerciseScene(std::string(reinterpret_cast<const char*>(data), size), DIRECTORY.path);
  return 0;
}
