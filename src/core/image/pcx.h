/** @file
 * The ZSoft PCX picture format, which OpenImageIO has no reader for.
 */
#pragma once

#include <string>

namespace recurse::detail {

/** The same picture as an uncompressed TGA file. Takes PCX of eight bits with a palette, and of 24 bits.
 * Throws Error naming the file and the reason. */
std::string tgaOfPcx(const std::string& fileName, const std::string& pcx);

} // namespace recurse::detail
