/** @file
 * Memory limits of Linux control groups.
 */
#pragma once

#include <string>

namespace recurse::detail {

/** Memory that control groups leave the process [bytes]: the least over its group and all that contain it;
 * infinite without a limit. Cached files that the system drops on demand do not count as used. `groups`: the
 * groups of the process, as in /proc/self/cgroup. `mount`: the folder with the hierarchies, of version 2
 * or 1. */
double memoryLeftByGroups(const std::string& groups = "/proc/self/cgroup",
                          const std::string& mount = "/sys/fs/cgroup");

} // namespace recurse::detail
