/** @file
 * The options of tone mapping, which every command with pictures for a display has, and the writing of them.
 */
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "recurse/report/develop/develop.h"

namespace recurse::apps {

struct DevelopOptions {
  std::string exposure = "auto", toneMap = "filmic", display = "srgb";
  std::optional<std::string> whiteBalance, bloom, bloomAngle;
  bool dither = false;

  void addTo(CLI::App& command);
  /** Throws Error (BAD_USAGE) that names the option. */
  DevelopSettings settings() const;
  /** Options that do the same with the exposure that was chosen. */
  std::string text(double stops) const;
};

/** Writes pictures of one render: linear or, by their extension, developed. */
class PictureWriter {
 public:
  explicit PictureWriter(const DevelopOptions& options) : options(options), settings(options.settings()) {}
  /** Throws Error. */
  void write(const std::string& fileName, const Image& image);
  /** Exposure of the pictures for a display; empty where none was written, and of a black one. */
  std::optional<double> stops() const;
  /** How the pictures for a display were developed, as a line; empty where none was written. */
  std::string remark() const;

 private:
  DevelopOptions options;
  DevelopSettings settings;
  std::optional<Developed> developed; ///< of the picture that was written first
};

} // namespace recurse::apps
