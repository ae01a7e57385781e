/** @file
 * Options of tone mapping, for all commands that write pictures for a display, and the writer.
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
  /** Parsed settings. Throws Error (BAD_USAGE) that names the option. */
  DevelopSettings settings() const;
  /** Command-line options of these settings, with the exposure that was chosen [stops]. */
  std::string text(double stops) const;
};

/** Writes pictures of one render: linear or, by their extension, developed. */
class PictureWriter {
 public:
  explicit PictureWriter(const DevelopOptions& options) : options(options), settings(options.settings()) {}
  /** Writes a picture in the format of its extension. Throws Error. */
  void write(const std::string& fileName, const Image& image);
  /** The picture as it is written for a display, developed once. */
  const Image& developedPicture(const Image& image);
  /** Exposure of the pictures for a display [stops]; empty if none was written, and for a black one. */
  std::optional<double> stops() const;
  /** Line on how pictures for a display were developed; empty if none was written. `filmStops`: exposure of
   * films. */
  std::string remark(std::optional<double> filmStops = {}) const;

 private:
  DevelopOptions options;
  DevelopSettings settings;
  std::optional<Developed> developed; ///< of the picture written first
};

} // namespace recurse::apps
