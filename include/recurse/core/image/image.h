/** @file
 * Images in memory and on disk (OpenImageIO): reading, and writing that leaves no incomplete file behind.
 */
#pragma once

#include <map>
#include <string>
#include <vector>

#include "recurse/core/io/fileReference.h"
#include "recurse/core/math/rgb.h"

namespace recurse {

/** Float pixels, row by row from the top, channels interleaved; linear light unless a function says that it
 * is encoded. Coordinates are from the upper left pixel, and not checked. */
struct Image {
  int width = 0, height = 0;
  std::vector<std::string> channels; ///< names: R, G, B, or with layers direct.R and so on
  std::vector<float> pixels;
  std::map<std::string, std::string> metadata;
  bool fromIntegers = false; ///< read from a file of integers, whose values are cut off at white

  Image() = default;
  Image(int width, int height, std::vector<std::string> channelNames)
      : width(width), height(height), channels(std::move(channelNames)),
        pixels(size_t(width) * size_t(height) * channels.size()) {}
  float* at(int x, int y) { return &pixels[(size_t(y) * size_t(width) + size_t(x)) * channels.size()]; }
  const float* at(int x, int y) const {
    return &pixels[(size_t(y) * size_t(width) + size_t(x)) * channels.size()];
  }
  /** Index of a channel; -1 when there is none of that name. */
  int channel(const std::string& name) const;
  /** Colour of a pixel: its first three channels, of at least three. */
  Rgb rgb(int x, int y) const {
    const float* p = at(x, y);
    return {p[0], p[1], p[2]};
  }
};

/** `picture`, followed by the channels of `more`, an image of the same size. Metadata of both are kept;
 * where names are equal, `picture` prevails. */
Image withChannels(const Image& picture, const Image& more);

/** Indices of the three colour channels, then of all other channels. Colour channels are R, G and B, in
 * either case; without them NAME.R, NAME.G and NAME.B of the first layer that has these; else the only
 * channel besides A, three times. Throws Error naming the file when there are none. */
std::vector<int> channelOrder(const std::string& fileName, const std::vector<std::string>& names);

/** Linear light of a value of the sRGB encoding (IEC 61966-2-1), in [0, 1]. */
float linearFromSrgb(float encoded);
/** sRGB encoding of linear light: the inverse of linearFromSrgb(). */
float srgbFromLinear(float linear);

/** Reads any format that OpenImageIO supports, and PCX. Channels are in channelOrder(), a grey one as R, G
 * and B. Integers are decoded from sRGB, except alpha and files declared linear. Colours are as the
 * file stores them: PNG stores them without alpha, EXR multiplied by it; the reader of WebP multiplies them.
 * Throws Error naming the file and the reason. */
Image readImage(const FileReference& file);

struct ImageWriteOptions {
  float exposure = 0;   ///< [stops], applied to display formats only, unless `encoded`
  bool encoded = false; ///< true: the values are display-encoded already, in [0, 1]; for display formats only
};

/** True for the 8-bit display formats: .png .jpg .jpeg .tif .tiff. Throws Error (BAD_USAGE) for a name with
 * an unknown extension or none. */
bool isDisplayFormat(const std::string& fileName);

/**
 * Writes by extension: .exr (float, all channels), .hdr .pfm (linear RGB), .png .jpg .jpeg .tif .tiff (8 bit
 * sRGB). RGB are the first three channels, or the only one three times. The file appears under its name only
 * when it is complete. Throws Error naming file and reason.
 */
void writeImage(const std::string& fileName, const Image& image, const ImageWriteOptions& options = {});

/** PNG file of a picture of R, G and B that is encoded for the display, in [0, 1]. Throws Error. */
std::vector<unsigned char> encodedPng(const Image& encoded);

/** Throws Error when a picture could not be written there: unknown extension, no such folder, not allowed.
 * Called before a long render. `others`: further extensions that the caller writes itself, for the message,
 * each after a space. */
void checkImageWritable(const std::string& fileName, const std::string& others = {});

/** Writes text to a file that appears under its name only when it is complete. Throws Error. */
void writeFileAtomically(const std::string& fileName, const std::string& text);

} // namespace recurse
