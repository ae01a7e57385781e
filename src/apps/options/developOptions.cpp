/** @file
 * Options of tone mapping: declaration, parsing, application.
 */
#include "apps/options/developOptions.h"

#include <algorithm>

#include "apps/options/optionText.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse::apps {

namespace {

std::string listed(const std::vector<std::string>& names, const std::string& separator = " ") {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : separator) + name;
  return out;
}

/** Parses "auto", "p98", "1.5", and the first two with stops: "auto+1", "p98-0.5". */
Exposure parseExposure(const std::string& text) {
  Exposure out;
  std::string rest = text;
  const size_t sign = text.find_first_of("+-", 1);
  const bool isMetered = text.starts_with("auto") || text.starts_with("p");
  const std::string meter = isMetered ? text.substr(0, sign) : "";
  if (meter == "auto") {
    out.meter = Exposure::Meter::LOG_AVERAGE;
  } else if (isMetered && meter.starts_with("p") && meter.size() > 1) {
    out.meter = Exposure::Meter::PERCENTILE;
    out.percentile = parseReal("--exposure", meter.substr(1));
    if (!(out.percentile > 0 && out.percentile <= 100))
      badUsage("--exposure: '" + text + "': a percentile is more than 0 and at most 100, such as p98");
  } else if (isMetered) {
    badUsage("--exposure: '" + text +
             "' is not a number of stops, auto, a percentile such as p98, or one of "
             "these with stops, such as auto+1");
  } else {
    out.meter = Exposure::Meter::NONE;
  }
  if (isMetered) rest = sign == std::string::npos ? "0" : text.substr(sign);
  out.stops = parseReal("--exposure", rest);
  if (std::abs(out.stops) > 100) badUsage("--exposure: '" + text + "' is not from -100 to 100 stops");
  return out;
}

WhiteBalance parseWhiteBalance(const std::string& text) {
  if (text == "auto") return {true, 0};
  const double kelvin = parseReal("--white-balance", text);
  if (!(kelvin >= WhiteBalance::MIN_KELVIN && kelvin <= WhiteBalance::MAX_KELVIN))
    badUsage("--white-balance: '" + text + "' is neither auto nor a temperature from " +
             formatted("%g to %g", WhiteBalance::MIN_KELVIN, WhiteBalance::MAX_KELVIN) + " K");
  return {false, kelvin};
}

/** Parses `NAME`, or a name and parameters as in a scene file: `drago "float bias" 0.7`. */
std::shared_ptr<const ToneMap> parseToneMap(const std::string& text) {
  const auto& registry = plugIns().toneMaps;
  const size_t blank = text.find(' ');
  const std::string name = text.substr(0, blank);
  if (!registry.find(name)) {
    const std::vector<std::string> nearest = nearestNames(name, registry.names());
    badUsage("--tonemap: there is no operator '" + name + "'" +
             (nearest.empty() ? "" : "; did you mean " + listed(nearest, " or ") + "?") +
             "; there are: " + listed(registry.names()));
  }
  Diagnostics diagnostics;
  try {
    const ParsedDirective directive =
        parseParameterText(name, blank == std::string::npos ? "" : text.substr(blank));
    if (std::shared_ptr<const ToneMap> made = registry.make(directive, NoContext{}, diagnostics)) return made;
  } catch (const SceneError& error) {
    badUsage(std::string("--tonemap:\n") + error.what());
  }
  badUsage("--tonemap:\n" + diagnostics.format());
}

} // namespace

void DevelopOptions::addTo(CLI::App& command) {
  const std::string group = "For .png .jpg .tif";
  command
      .add_option(
          "--exposure", exposure,
          "Exposure in stops (powers of two). auto: the log average becomes middle grey; p98: the 98th "
          "percentile becomes white; auto+1, p98-0.5: with a correction in stops (default: auto)")
      ->type_name("STOPS")
      ->group(group);
  command
      .add_option("--tonemap", toneMap,
                  "Tone operator: " + listed(plugIns().toneMaps.names()) +
                      "; with parameters as 'drago \"float bias\" 0.7', see 'recurse reference ToneMap' "
                      "(default: filmic)")
      ->type_name("NAME")
      ->group(group);
  command
      .add_option("--white-balance", whiteBalance,
                  "Colour temperature that becomes white, from 1667 to 25000; auto: from the mean of the "
                  "picture (default: no change; white is 6504)")
      ->type_name("KELVIN")
      ->group(group);
  command
      .add_option("--bloom", bloom,
                  "Fraction of the glare in a human eye around bright light (Spencer et al. 1995): from 0, "
                  "none, to 1, all")
      ->type_name("PART")
      ->group(group);
  command
      .add_option("--bloom-angle", bloomAngle,
                  "For --bloom: horizontal angle of view of the displayed picture (default: 40)")
      ->type_name("DEGREES")
      ->group(group);
  command
      .add_option("--display", display,
                  "Encoding: " + listed(DisplayEncoding::names()) +
                      "; ocio is the OpenColorIO configuration in $OCIO (default: srgb)")
      ->type_name("NAME")
      ->group(group);
  command
      .add_flag("--dither", dither, "Dither the rounding to 8 bits, so that smooth gradients show no bands")
      ->group(group);
}

DevelopSettings DevelopOptions::settings() const {
  DevelopSettings out;
  out.exposure = parseExposure(exposure);
  if (whiteBalance) out.whiteBalance = parseWhiteBalance(*whiteBalance);
  if (bloom) out.bloom = parseReal("--bloom", *bloom);
  if (!(out.bloom >= 0 && out.bloom <= 1)) badUsage("--bloom: '" + *bloom + "' is not from 0 to 1");
  if (bloomAngle && !bloom) badUsage("--bloom-angle: needs --bloom PART");
  if (bloomAngle) out.bloomDegrees = parseReal("--bloom-angle", *bloomAngle);
  if (!(out.bloomDegrees > 0 && out.bloomDegrees <= 180))
    badUsage("--bloom-angle: '" + *bloomAngle + "' is not more than 0 and at most 180 degrees");
  out.toneMap = parseToneMap(toneMap);
  out.display = DisplayEncoding(display);
  out.dither = dither;
  return out;
}

std::string DevelopOptions::text(double stops) const {
  return formatted("--exposure %.4g --tonemap ", stops) + shellQuoted(toneMap) +
         (whiteBalance ? " --white-balance " + *whiteBalance : "") + (bloom ? " --bloom " + *bloom : "") +
         (bloomAngle ? " --bloom-angle " + *bloomAngle : "") + " --display " + shellQuoted(display) +
         (dither ? " --dither" : "");
}

void PictureWriter::write(const std::string& fileName, const Image& image) {
  if (!isDisplayFormat(fileName)) return writeImage(fileName, image);
  writeImage(fileName, developedPicture(image), {.encoded = true});
}

const Image& PictureWriter::developedPicture(const Image& image) {
  if (!developed) {
    developed = develop(image, settings);
    developed->picture.metadata["recurse:developed"] = options.text(developed->stops);
  }
  return developed->picture;
}

std::optional<double> PictureWriter::stops() const {
  if (!developed) return {};
  const std::vector<float>& pixels = developed->picture.pixels;
  const bool isBlack = std::all_of(pixels.begin(), pixels.end(), [](float v) { return v == 0; });
  return isBlack ? std::optional<double>() : developed->stops;
}

std::string PictureWriter::remark(std::optional<double> filmStops) const {
  if (developed) filmStops = developed->stops;
  if (!filmStops) return "";
  return formatted("exposure %+.2f stops", *filmStops) + ", tone operator " + options.toneMap +
         "; for linear values: --exposure 0 --tonemap none\n";
}

} // namespace recurse::apps
