/** @file
 * Opening of picture files, for readers that keep the pixels in the type that the file has.
 */
#pragma once

#include <memory>
#include <string>

#include <OpenImageIO/imageio.h>

namespace recurse::detail {

/** A picture of two dimensions at the start of its pixels. Throws Error naming the file and the reason. */
std::unique_ptr<OIIO::ImageInput> openImage(const std::string& fileName);

} // namespace recurse::detail
