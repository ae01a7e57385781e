/** @file
 * What the fuzzers of files share. Whatever the bytes are, nothing may crash, hang, or throw anything but
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

/** A name for the file that this process writes over and over. */
inline std::string scratchFile(const std::string& extension) {
  return (std::filesystem::temp_directory_path() / ("recurse-fuzz-" + std::to_string(::getpid()))).string() +
         extension;
}

template <class Read> void readAnything(const Read& read) {
  try {
    read();
  } catch (const Error&) {
    // promised
  }
}

struct SceneImport;

/** Aborts where what an importer wrote is no scene. */
void checkImport(const SceneImport& import);

/** Writes a file, imports it by the importer of that name, and checks that it has become a scene or that an
 * error says why not. `more`: further parameters. */
void importAnything(const char* importer, const char* parameter, const std::string& extension,
                    const std::string& bytes, const std::string& more = {});

} // namespace recurse
