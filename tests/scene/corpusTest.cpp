/** @file
 * The corpus of the fuzzer, whole and truncated at many positions, is read without a crash.
 */
#include "fuzz/sceneExercise.h"
#include "sceneTesting.h"

using namespace recurse;

TEST(Corpus, NothingCrashes) {
  const TemporaryDirectory empty;
  const auto folder = std::filesystem::path(RECURSE_SOURCE_DIR) / "tests" / "fuzz" / "corpus";
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    exerciseScene(text, empty.path());
    // About 40 truncations of each.
    const size_t step = text.size() / 40 + 1;
    for (size_t length = 0; length < text.size(); length += step) {
      Diagnostics diagnostics;
      parseScene(text.substr(0, length), "cut", empty.path(), diagnostics);
      diagnostics.format();
    }
    ++files;
  }
  EXPECT_GT(files, 0u);
}
