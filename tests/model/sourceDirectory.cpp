/** @file
 * Runs the tests of the model in the project's folder, because examples of plug-ins name files relative to
 * it.
 */
#include <gtest/gtest.h>

#include <filesystem>

namespace {

class SourceDirectory final : public ::testing::Environment {
  void SetUp() override { std::filesystem::current_path(RECURSE_SOURCE_DIR); }
};

[[maybe_unused]] const ::testing::Environment* const REGISTERED =
    ::testing::AddGlobalTestEnvironment(new SourceDirectory);

} // namespace
