/** @file
 * Helpers for tests of scene files.
 */
#pragma once

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

#include "recurse/scene/directives/loader.h"

namespace recurse {

inline SceneDescription parse(const std::string& text, Diagnostics& diagnostics) {
  return parseScene(text, "test.pbrt", "", diagnostics);
}

/** Parses a text that must have no errors. */
inline SceneDescription parseGood(const std::string& text) {
  Diagnostics diagnostics;
  SceneDescription scene = parse(text, diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  return scene;
}

inline std::string messages(const std::string& text) {
  Diagnostics diagnostics;
  parse(text, diagnostics);
  return diagnostics.format();
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

#define EXPECT_CONTAINS(text, part) EXPECT_PRED2(::recurse::contains, text, part)

inline size_t errorCount(const Diagnostics& diagnostics) {
  size_t n = 0;
  for (const Diagnostic& d : diagnostics.all()) n += d.severity == Severity::ERROR;
  return n;
}

/** A temporary directory of a test. */
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "recurse-test-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary directory");
    root = name;
  }
  ~TemporaryDirectory() {
    std::error_code error;
    std::filesystem::remove_all(root, error);
  }
  std::string path(const std::string& name = "") const { return (root / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((root / name).parent_path());
    std::ofstream(root / name, std::ios::binary) << text;
  }

 private:
  std::filesystem::path root;
};

} // namespace recurse
