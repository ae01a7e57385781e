/** @file
 * Opening of picture files, for readers that keep the pixels in the type that the file has.
 */
#pragma once

#include <memory>
#include <string>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "recurse/core/fileReference.h"

namespace recurse::detail {

/** An open picture, with what its reader reads from where that is memory. */
struct OpenImage {
  std::shared_ptr<const std::string> content;
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
  std::unique_ptr<OIIO::ImageInput> input;
  OIIO::ImageInput* operator->() const { return input.get(); }
};

/** A picture of two dimensions at the start of its pixels. Throws Error naming the file and the reason. */
OpenImage openImage(const FileReference& file);
/** Why pixels could not be read, where not all formats say it. */
std::string readFailure(const OIIO::ImageInput& input);

} // namespace recurse::detail
