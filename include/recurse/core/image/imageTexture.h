/** @file
 * Image textures by OpenImageIO's texture system: levels of detail, filtering over a footprint, and a cache
 * of tiles that bounds the memory of filtered images.
 */
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "recurse/core/io/fileReference.h"
#include "recurse/core/math/rgb.h"

namespace recurse {

/** Encoding of the colours of integer formats; alpha and floating-point formats are linear. */
struct ImageEncoding {
  enum class Kind { SRGB, LINEAR, GAMMA } kind = Kind::SRGB;
  float gamma = 1; ///< for GAMMA: light = value^gamma
};

/** Channels of a file that a texture uses: its colours, or one channel alone. Colours are as the file stores
 * them, with or without alpha as a factor: see readImage(). */
enum class ImageChannels { COLOURS, RED, GREEN, BLUE, ALPHA };

struct ImageTextureSettings {
  enum class Filter {
    POINT,     ///< the nearest pixel of one level of detail
    BILINEAR,  ///< interpolated between four pixels of one level
    TRILINEAR, ///< bilinear, and interpolated between two levels
    EWA,       ///< samples along the longer axis of the footprint, at the level of the shorter one
  };
  /** Value outside of the image. */
  enum class Wrap {
    REPEAT,
    BLACK,
    CLAMP,      ///< value of the nearest pixel
    OCTAHEDRAL, ///< continued across the edges of an octahedral map of the sphere; see equalAreaSquare.h
  };
  Filter filter = Filter::BILINEAR;
  Wrap wrap = Wrap::REPEAT;
  float maxAnisotropy = 8; ///< maximum ratio of the longer to the shorter axis, for EWA; rounded down, >= 1
  ImageChannels channels = ImageChannels::COLOURS;
  bool levels = true; ///< false: always the finest level
};

/** Sets the memory of all textures [bytes]; to be called before the first is read. Half of it, at least
 * 16 MiB, holds decoded tiles in use; the rest holds the pixels of files and their coarser levels, and what
 * exceeds it goes to temporary files. Defaults: 1 GiB of tiles, and no limit for the pixels. */
void setTextureMemory(double bytes);

/** Memory that the pixels of all textures take now: in memory, and in temporary files [bytes]. */
std::pair<size_t, size_t> textureMemory();

/** Pixels of a file, decoded to linear light when they are used. Textures of equal file, channels and
 * encoding share them. */
class ImageTexture {
 public:
  /** Reads the whole file. Throws Error naming the file and the reason: missing, broken, not finite, no
   * colours, no alpha. */
  ImageTexture(const FileReference& file, const ImageEncoding& encoding,
               const ImageTextureSettings& settings);
  ~ImageTexture();

  /**
   * Linear value at `st`: s from the left, t from the top, fractions of the image; one channel gives grey.
   * alongX and alongY are the changes of (s, t) along the axes of the footprint, over their full lengths;
   * zero for a point. Throws Error where the texture system fails.
   */
  Rgb at(Vec2f st, const Vec2f& alongX, const Vec2f& alongY) const;

  int width() const;
  int height() const;

 private:
  struct Source;
  std::shared_ptr<const Source> source;
  ImageTextureSettings settings;
};

} // namespace recurse
