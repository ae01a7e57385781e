/** @file
 * Pictures as textures, through OpenImageIO's texture system: levels of detail, filtering over a footprint,
 * and a cache of tiles that bounds what filtered pictures take in memory.
 */
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "recurse/core/io/fileReference.h"
#include "recurse/core/math/rgb.h"

namespace recurse {

/** How the numbers of integer formats stand for light; floating-point formats are linear. */
struct ImageEncoding {
  enum class Kind { SRGB, LINEAR, GAMMA } kind = Kind::SRGB;
  float gamma = 1; ///< of GAMMA: light = value^gamma
};

/** What of a file is looked at: its colours, or one channel alone. */
enum class ImageChannels { COLOURS, RED, GREEN, BLUE, ALPHA };

struct ImageTextureSettings {
  enum class Filter {
    POINT,     ///< the nearest pixel of one level of detail
    BILINEAR,  ///< between four pixels of one level
    TRILINEAR, ///< and between two levels
    EWA,       ///< along the longer axis of the footprint, at the level of the shorter one
  };
  enum class Wrap { REPEAT, BLACK, CLAMP, OCTAHEDRAL };
  Filter filter = Filter::BILINEAR;
  Wrap wrap = Wrap::REPEAT;
  float mostAnisotropy = 8; ///< longer over shorter axis, for EWA
  ImageChannels channels = ImageChannels::COLOURS;
  bool levels = true; ///< false: the finest level, whatever the footprint
};

/** What textures may take in memory [bytes], before the first is read: half of it for pixels as they are in
 * the files, the rest of which lies in a temporary file, and half for those in use, decoded. Without a call
 * as much as they need, and 1 GiB. */
void setTextureMemory(double bytes);

/** What the pixels of all textures have now, in memory and in temporary files [bytes]. */
std::pair<size_t, size_t> textureMemory();

/** Pixels of a file, decoded to linear light when they are used. Those of one file are shared. */
class ImageTexture {
 public:
  /** Reads the whole file. Throws Error naming the file and the reason: missing, broken, not finite, no
   * colours. */
  ImageTexture(const FileReference& file, const ImageEncoding& encoding,
               const ImageTextureSettings& settings);
  ~ImageTexture();

  /**
   * Linear values at s from the left and t from the top, in parts of the whole; a single channel stands for
   * all three. alongX and alongY are the changes of (s, t) along the axes of the footprint; zero for a point.
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
