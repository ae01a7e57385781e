/** @file
 * The reference page in doc-files/ is equal to the current output of the program.
 */
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

TEST(ReferencePage, IsWhatTheProgramPrints) {
  FILE* pipe = popen(RECURSE_PROGRAM " reference --markdown", "r");
  ASSERT_NE(pipe, nullptr);
  std::string printed;
  char buffer[4096];
  for (size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) printed.append(buffer, n);
  EXPECT_EQ(pclose(pipe), 0);
  std::ifstream file(RECURSE_SOURCE_DIR "/doc-files/scene-format.md");
  std::stringstream kept;
  kept << file.rdbuf();
  EXPECT_EQ(kept.str(), printed) << "make it anew: recurse reference --markdown > doc-files/scene-format.md";
}
