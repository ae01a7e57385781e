/** @file
 * Identity and kind of the file behind a name, before it is read or written.
 */
#pragma once

#include <string>

namespace recurse {

/** True where both names refer to the same file or folder, through symbolic or hard links, or would once they
 * are written. False for devices and pipes, which keep no data. */
bool isSameFile(const std::string& a, const std::string& b);

/** True where the name, of a file or folder that need not exist, is below the folder, links followed. Empty
 * folder: the current one. */
bool isInside(const std::string& name, const std::string& folder);

/** True for a pipe, terminal, socket or device that this process has open, such as /dev/stdout. */
bool isOpenStream(const std::string& name);

/** Kind of a special file: "a folder", "a named pipe" and so on; empty for a regular or missing file. */
std::string specialKind(const std::string& name);

/** Throws Error unless the name refers to a regular file, since reading of special files may never end. Open
 * streams and names without a file pass. */
void requireReadable(const std::string& name);

} // namespace recurse
