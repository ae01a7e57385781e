/** @file
 * The ZSoft PCX image format, for which OpenImageIO has no reader.
 */
#pragma once

#include <string>

namespace recurse::detail {

/** Converts a PCX image, 8-bit with a palette or 24-bit, to an uncompressed TGA file in memory. Throws Error
 * naming the file and the reason. */
std::string tgaOfPcx(const std::string& fileName, const std::string& pcx);

} // namespace recurse::detail
