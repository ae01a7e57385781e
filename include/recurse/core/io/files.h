/** @file
 * What names of files stand for, before they are read or written.
 */
#pragma once

#include <string>

namespace recurse {

/** True where both names stand for the same file or folder, through links of either kind, or would once they
 * are written. Devices and pipes keep nothing, and are never the same. */
bool isSameFile(const std::string& a, const std::string& b);

/** True where the name stands for something in the folder, or in one below it, once links are followed. */
bool isInside(const std::string& name, const std::string& folder);

/** True for a pipe, terminal or socket that this process was started with, such as /dev/stdout. */
bool isOpenStream(const std::string& name);

/** "a folder", "a named pipe" and the like; empty for a regular file and where there is nothing. */
std::string specialKind(const std::string& name);

/** Throws Error for what is no regular file, because reading it may never end. Open streams pass, and names
 * that stand for nothing. */
void requireReadable(const std::string& name);

} // namespace recurse
