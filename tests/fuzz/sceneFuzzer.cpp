/** @file
 * libFuzzer target: arbitrary text as a scene file, and then as parameters of plug-ins. Nothing may crash,
 * hang, or throw anything but the errors of the interfaces.
 */
#include <cstdlib>
#include <string>
#include <unistd.h>

#include "fuzz/sceneExercise.h"

namespace {

/** An empty working directory, so that names in the input do not match files. */
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
