/** @file
 * Opening of picture files, for readers that keep the pixels in the type that the file has.
 */
#pragma once

#include <memory>
#include <string>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "recurse/core/io/error.h"
#include "recurse/core/io/fileReference.h"

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
/** For std::bad_alloc on the way: headers of damaged pictures ask for any size. */
Error lacksMemory(const FileReference& file);
/** Why a picture could not be read, by what OpenImageIO says of it, which may be nothing. */
std::string readFailure(const std::string& said);

} // namespace recurse::detail
