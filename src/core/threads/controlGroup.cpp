/** @file
 * Memory limits of Linux control groups, versions 2 and 1.
 */
#include "core/threads/controlGroup.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

namespace recurse::detail {

namespace {

namespace fs = std::filesystem;

/** Names of files and of two lines in `memory.stat`. */
struct GroupFiles {
  const char *limit, *used, *inactive, *active;
};
constexpr GroupFiles VERSION_2 = {"memory.max", "memory.current", "inactive_file", "active_file"};
constexpr GroupFiles VERSION_1 = {"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file",
                                  "total_active_file"};

/** Number in a file; none where there is no file, or a word such as "max". */
std::optional<double> numberIn(const fs::path& file) {
  std::ifstream in(file);
  double number = 0;
  return in >> number ? std::optional(number) : std::nullopt;
}

double leftIn(const fs::path& group, const GroupFiles& files) {
  const std::optional<double> limit = numberIn(group / files.limit);
  if (!limit) return INFINITY;
  double cached = 0, number = 0;
  std::ifstream statistics(group / "memory.stat");
  for (std::string name; statistics >> name >> number;)
    if (name == files.inactive || name == files.active) cached += number;
  const double used = numberIn(group / files.used).value_or(0);
  return std::max(0.0, *limit - std::max(0.0, used - cached));
}

} // namespace

double memoryLeftByGroups(const std::string& groups, const std::string& mount) {
  double least = INFINITY;
  std::ifstream in(groups);
  for (std::string line; std::getline(in, line);) { // ID:CONTROLLERS:PATH
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool isVersion2 = controllers == ",,";
    if (!isVersion2 && controllers.find(",memory,") == std::string::npos) continue;
    const fs::path root = isVersion2 ? fs::path(mount) : fs::path(mount) / "memory";
    // In a container the path may be that of the host: then only the root exists.
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();; group = group.parent_path()) {
      least = std::min(least, leftIn(root / group, isVersion2 ? VERSION_2 : VERSION_1));
      if (group.empty()) break;
    }
  }
  return least;
}

} // namespace recurse::detail
