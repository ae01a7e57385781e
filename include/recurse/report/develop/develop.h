/** @file
 * Development of a rendered picture, linear and unbounded, for a display. The steps in order: white balance,
 * exposure, bloom, tone operator with antialiased highlights, display encoding, dither.
 */
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "recurse/core/image/image.h"
#include "recurse/model/film/toneMap.h"

namespace recurse {

/** Exposure of the picture. */
struct Exposure {
  enum class Meter {
    NONE,
    LOG_AVERAGE, ///< exposure of meteredStops()
    PERCENTILE   ///< maps this percentile of the luminances above 0 to 1
  };
  Meter meter = Meter::LOG_AVERAGE;
  double percentile = 0; ///< in (0, 100]
  double stops = 0;      ///< powers of two in addition to the metered exposure
};

/**
 * Exposure of an automatic camera [stops]: maps the log average of the luminance to middle grey (GREY_CARD),
 * or up to a stop less or more where most of the picture is dark or bright (Reinhard 2002, "Parameter
 * Estimation for Photographic Tone Reproduction"). Black around the lit part is ignored; luminances beyond
 * the 5th and 95th percentile, such as lamps, count as these; luminances more than five stops below the 95th
 * percentile count as equally dark. Zero for a black picture.
 */
double meteredStops(const Image& picture);
/** Exposure of a picture by these settings [stops]. */
double stopsFor(const Exposure& exposure, const Image& picture);

/** Chromaticity of the white in the picture. */
struct WhiteBalance {
  bool automatic = false; ///< white is the mean of the picture without its darkest and brightest parts
  /** Colour temperature of daylight, below 4000 of a black body [K]; 0: no white balance. Has no effect if
   * `automatic`. */
  double kelvin = 0;

  static constexpr double MIN_KELVIN = 1667, MAX_KELVIN = 25000; ///< range in which the formulas hold [K]
};
/** Adapts the picture to the white of the display, D65 (Bradford's chromatic adaptation). Negative results
 * become 0. */
void applyWhiteBalance(Image& picture, const WhiteBalance& balance);

/** Display encoding by name: "srgb", "rec709", "gamma2.2", ...; "ocio", "ocio:DISPLAY" and
 * "ocio:DISPLAY/VIEW" refer to the OpenColorIO configuration named by $OCIO. */
class DisplayEncoding {
 public:
  /** Throws Error (BAD_USAGE), with all valid names, for an unknown one, and where $OCIO is no configuration
   * with this display and view. */
  explicit DisplayEncoding(const std::string& name = "srgb");
  /** Encodes linear values, clipped to [0, 1], for the display; OpenColorIO gets them unclipped. The results
   * are in [0, 1]. Throws Error where OpenColorIO fails. */
  void apply(Image& picture) const;
  /** All names, with a pattern for OpenColorIO. */
  static const std::vector<std::string>& names();

 private:
  std::string name;
};

/** Settings of all steps. */
struct DevelopSettings {
  Exposure exposure;
  WhiteBalance whiteBalance;
  double bloom = 0;         ///< amount of applyBloom(): fraction of the light, in [0, 1]; 0: none
  double bloomDegrees = 40; ///< visual angle of the picture's width [degrees], for applyBloom()
  std::shared_ptr<const ToneMap> toneMap; ///< null: none
  DisplayEncoding display;
  bool dither = false; ///< for 8 bits, to prevent banding in smooth gradients
};

/** Developed picture. */
struct Developed {
  Image picture;    ///< R, G, B, encoded for the display, to be written with ImageWriteOptions::encoded
  double stops = 0; ///< exposure applied, metered or given
};

/** Picture with its glare, and the part of it that is not glare, darker than before the bloom. Identical
 * without bloom. */
struct Glaring {
  Image light, direct;
};
/** Adds the glare of applyBloom() to a picture of R, G and B. */
Glaring withGlare(Image picture, double amount, double degrees);

/** Picture before exposure, linear and unbounded, with white balance and bloom. */
struct Unexposed {
  Glaring picture;
  double stops = 0; ///< exposure to be applied
};
/** First steps of develop(): white balance, metering and bloom. */
Unexposed beforeExposure(const Image& picture, const DevelopSettings& settings);

/** Self-contained page that exposes the picture and applies a tone operator according to its sliders.
 * `operatorName`: operator that is chosen at first, instead of settings.toneMap. Operators have their default
 * parameters. settings.display and settings.dither have no effect. */
std::string developPage(const Image& picture, const DevelopSettings& settings, const std::string& title,
                        const std::string& operatorName);

/** Antialiases edges of highlights above white in a picture `shown` by a tone operator: pixels on such an
 * edge become the mixture of its two sides, as shown, by their mixture in the exposed picture. Edges are
 * found in the direct light, since glare has none. */
void mixBrightEdges(const Glaring& exposed, Image& shown);

/** Develops a picture. Negative values count as 0, pixels that are not finite as black. */
Developed develop(const Image& picture, const DevelopSettings& settings);

/** Sheet of the picture by every tone operator with default parameters, each with its name, reduced to at
 * most 480 pixels a side; encoded like developed pictures. */
Developed operatorSheet(const Image& picture, const DevelopSettings& settings);

} // namespace recurse
