/** @file
 * Opening of image files, for readers that keep the pixels in the type of the file.
 */
#pragma once

#include <memory>
#include <string>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "recurse/core/io/error.h"
#include "recurse/core/io/fileReference.h"

namespace recurse::detail {

/** An open image, with its content and the reader of it where the image is in memory. */
struct OpenImage {
  std::shared_ptr<const std::string> content;
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
  std::unique_ptr<OIIO::ImageInput> input;
  OIIO::ImageInput* operator->() const { return input.get(); }
};

/** Opens a two-dimensional image, at the start of its pixels. Colours are as the file stores them: PNG and
 * the like are not multiplied by alpha, which would be wrong for encoded colours; WebP is, by its reader.
 * Throws Error naming the file and the reason. */
OpenImage openImage(const FileReference& file);
/** Index of the alpha channel; -1 without one. The reader of GIF states an index that is too large by one. */
inline int alphaChannel(const OIIO::ImageSpec& spec) {
  return spec.alpha_channel < spec.nchannels ? spec.alpha_channel : spec.nchannels - 1;
}
/** Error for std::bad_alloc while reading: headers of damaged images may ask for any size. */
Error lacksMemory(const FileReference& file);
/** Reason for a failure to read an image, from OpenImageIO's message, which may be empty. */
std::string readFailure(const std::string& said);

} // namespace recurse::detail
