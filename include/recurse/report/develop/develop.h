/** @file
 * Developing: from a rendered picture, linear and without bounds, to one for a display. In this order: white
 * balance, exposure, bloom, tone operator, display encoding, dither.
 */
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "recurse/core/image/image.h"
#include "recurse/model/film/toneMap.h"

namespace recurse {

/** How bright the picture becomes. */
struct Exposure {
  enum class Meter {
    NONE,
    LOG_AVERAGE, ///< what meteredStops() says
    PERCENTILE   ///< this percentile of the luminance becomes 1
  };
  Meter meter = Meter::LOG_AVERAGE;
  double percentile = 0; ///< in (0, 100]
  double stops = 0;      ///< powers of two on top of what is metered
};

/**
 * The exposure in stops that a camera would choose: the log average of the luminance becomes middle grey, a
 * little less or more where most of the picture is dark or bright (Reinhard 2002, "Parameter Estimation for
 * Photographic Tone Reproduction"). Black pixels, the darkest and the brightest, such as lamps, do not count.
 * Zero for a black picture.
 */
double meteredStops(const Image& picture);
/** The exposure of a picture in stops. */
double stopsFor(const Exposure& exposure, const Image& picture);

/** The chromaticity of white in the picture. */
struct WhiteBalance {
  bool automatic = false; ///< the mean of the picture, without its darkest and brightest parts, is white
  double kelvin = 0;      ///< of daylight, below 4000 of a black body; 0: no white balance

  static constexpr double MIN_KELVIN = 1667, MAX_KELVIN = 25000;
};
/** Adapts the picture's colours to the white of the display, D65 (Bradford's chromatic adaptation). */
void applyWhiteBalance(Image& picture, const WhiteBalance& balance);

/** Encodings of displays by name: "srgb", "rec709", "gamma2.2", ...; "ocio", "ocio:DISPLAY" and
 * "ocio:DISPLAY/VIEW" are those of the OpenColorIO configuration that $OCIO names. */
class DisplayEncoding {
 public:
  /** Throws Error (BAD_USAGE) for a name that does not exist, with those that do. */
  explicit DisplayEncoding(const std::string& name = "srgb");
  /** Linear [0, 1] to what the display is sent; more and less is cut. */
  void apply(Image& picture) const;
  static const std::vector<std::string>& names();

 private:
  std::string name;
};

struct DevelopSettings {
  Exposure exposure;
  WhiteBalance whiteBalance;
  double bloom = 0;                       ///< see applyBloom(): part of the light
  double bloomDegrees = 40;               ///< and how wide the picture is before the eye
  std::shared_ptr<const ToneMap> toneMap; ///< null: none
  DisplayEncoding display;
  bool dither = false; ///< to 8 bits, where smooth shades would show steps
};

struct Developed {
  Image picture; ///< R, G, B, encoded for the display, to be written with ImageWriteOptions::encoded
  double stops = 0;
};

/** A picture with its glare, and the light in it that is none: the same pixels where there is no bloom. */
struct Glaring {
  Image light, direct;
};
/** Adds the glare of applyBloom() to a picture of R, G and B. */
Glaring withGlare(Image picture, double amount, double degrees);

/** The picture as it is before exposure, linear and without bounds, with white balance and bloom. */
struct Unexposed {
  Glaring picture;
  double stops = 0; ///< to expose it by
};
Unexposed beforeExposure(const Image& picture, const DevelopSettings& settings);

/** A page that exposes the picture and shows it by an operator as its sliders say; all of it in one file.
 * Operators have their defaults. */
std::string developPage(const Image& picture, const DevelopSettings& settings, const std::string& title,
                        const std::string& operatorName);

/** Makes edges of what is brighter than white smooth in a picture `shown` by a tone operator: pixels on such
 * an edge become the mixture of its two sides, as shown, that they are in the exposed picture. Edges are
 * those of the direct light, for glare has none. */
void mixBrightEdges(const Glaring& exposed, Image& shown);

/** Values that are not finite or negative count as black. */
Developed develop(const Image& picture, const DevelopSettings& settings);

/** The picture by every tone operator with its defaults, each under its name; encoded as developed pictures
 * are. */
Developed operatorSheet(const Image& picture, const DevelopSettings& settings);

} // namespace recurse
