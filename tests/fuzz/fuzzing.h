/** @file
 * Shared functions of the fuzzers of files. For any bytes nothing may crash, hang, or throw anything but
 * Error.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <unistd.h>

#include "recurse/core/io/error.h"

namespace recurse {

inline std::string bytesOf(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/** Name of the file that this process overwrites repeatedly. */
inline std::string scratchFile(const std::string& extension) {
  return (std::filesystem::temp_directory_path() / ("recurse-fuzz-" + std::to_string(::getpid()))).string() +
         extension;
}

template <class Read> void readAnything(const Read& read) {
  try {
    read();
  } catch (const Error&) {
    // expected result
  }
}

struct SceneImport;

/** Aborts if the output of an importer is not a scene. */
void checkImport(const SceneImport& import);

/** Writes a file, imports it by the importer of that name, and checks that the result is a scene, or else
 * that an error gives the reason. `more`: further parameters. */
void importAnything(const char* importer, const char* parameter, const std::string& extension,
                    const std::string& bytes, const std::string& more = {});

} // namespace recurse
