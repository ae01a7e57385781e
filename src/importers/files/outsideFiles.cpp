/** @file
 * Rule for files outside of a model's folder. A model that is passed on as a scene shall not contain files
 * that its author made it fetch from the disk of the person who converts it.
 */
#include "importers/files/outsideFiles.h"

#include <filesystem>

#include "recurse/core/io/files.h"

namespace recurse {

ParameterSpec outsideParameter() {
  return stringParameter("outside", "read",
                         "files that the model names outside of its own folder: \"read\"; \"warn\": read "
                         "with a warning; \"refuse\": treated as missing")
      .oneOf({"read", "warn", "refuse"});
}

bool mayRead(const std::string& file, const std::string& path, const Parameters& p) {
  const std::string rule = p.string("outside");
  if (rule == "read" || isInside(file, std::filesystem::path(path).parent_path().string())) return true;
  const bool isRefused = rule == "refuse";
  p.warn("outside", path + ": " + file + " is outside of the model's folder, and is " +
                        (isRefused ? "left out; 'recurse convert --allow-outside' copies it" : "copied"));
  return !isRefused;
}

} // namespace recurse
