/** @file
 * Encoding of linear values for a display: published transfer functions, and OpenColorIO.
 */
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <OpenImageIO/color.h>
#include <OpenImageIO/imagebufalgo.h>

#include "recurse/core/io/error.h"
#include "recurse/report/develop/develop.h"

namespace recurse {

namespace {

struct Encoding {
  const char* name;
  float (*encoded)(float);
};

template <int TENTHS> float gammaEncoded(float x) { return std::pow(x, 10.0f / float(TENTHS)); }

/** Transfer function of ITU-R BT.709-6, item 1.2. */
float rec709Encoded(float x) { return x < 0.018f ? 4.5f * x : 1.099f * std::pow(x, 0.45f) - 0.099f; }

constexpr Encoding ENCODINGS[] = {{"srgb", srgbFromLinear},       {"rec709", rec709Encoded},
                                  {"rec1886", gammaEncoded<24>},  {"gamma1.8", gammaEncoded<18>},
                                  {"gamma2.2", gammaEncoded<22>}, {"gamma2.4", gammaEncoded<24>},
                                  {"gamma2.6", gammaEncoded<26>}, {"linear", [](float x) { return x; }}};

const std::string OCIO = "ocio";

bool isOcio(const std::string& name) { return name == OCIO || name.starts_with(OCIO + ":"); }

/** Display and view of "ocio:DISPLAY/VIEW"; empty ones are the configuration's defaults. */
std::pair<std::string, std::string> displayAndView(const std::string& name) {
  const std::string both = name.size() > OCIO.size() ? name.substr(OCIO.size() + 1) : "";
  const size_t slash = both.find('/');
  return {both.substr(0, slash), slash == std::string::npos ? "" : both.substr(slash + 1)};
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += " " + name;
  return out;
}

OIIO::ColorConfig& ocioConfiguration() {
  static OIIO::ColorConfig CONFIG; // configuration of $OCIO
  return CONFIG;
}

void checkOcio(const std::string& name) {
  const char* variable = std::getenv("OCIO");
  if (!variable || !*variable)
    throw Error("--display: '" + name +
                    "' needs the environment variable OCIO, the file name of an "
                    "OpenColorIO configuration",
                ExitStatus::BAD_USAGE);
  OIIO::ColorConfig& config = ocioConfiguration();
  const std::vector<std::string> displays = config.getDisplayNames();
  if (config.has_error() || displays.empty())
    throw Error(std::string(variable) + ": not an OpenColorIO configuration with a display" +
                    (config.has_error() ? ": " + config.geterror() : ""),
                ExitStatus::BAD_USAGE);
  const auto [display, view] = displayAndView(name);
  if (!display.empty() && std::find(displays.begin(), displays.end(), display) == displays.end())
    throw Error("--display: " + std::string(variable) + " has no display '" + display +
                    "'; it has:" + listed(displays),
                ExitStatus::BAD_USAGE);
  const std::vector<std::string> views =
      config.getViewNames(display.empty() ? config.getDefaultDisplayName() : display);
  if (!view.empty() && std::find(views.begin(), views.end(), view) == views.end())
    throw Error("--display: '" + display + "' has no view '" + view + "'; it has:" + listed(views),
                ExitStatus::BAD_USAGE);
}

void applyOcio(Image& picture, const std::string& name) {
  const OIIO::ImageSpec spec(picture.width, picture.height, int(picture.channels.size()),
                             OIIO::TypeDesc::FLOAT);
  OIIO::ImageBuf pixels(spec, picture.pixels.data());
  const auto [display, view] = displayAndView(name);
  OIIO::ColorConfig& config = ocioConfiguration();
  const std::string shown = display.empty() ? config.getDefaultDisplayName() : display;
  if (!OIIO::ImageBufAlgo::ociodisplay(pixels, pixels, shown,
                                       view.empty() ? config.getDefaultViewName(shown) : view, "scene_linear",
                                       "", false, "", "", &config))
    throw Error("--display: " + name + ": " + pixels.geterror());
}

} // namespace

const std::vector<std::string>& DisplayEncoding::names() {
  static const std::vector<std::string> NAMES = [] {
    std::vector<std::string> names;
    for (const Encoding& e : ENCODINGS) names.emplace_back(e.name);
    names.push_back(OCIO + "[:DISPLAY[/VIEW]]");
    return names;
  }();
  return NAMES;
}

DisplayEncoding::DisplayEncoding(const std::string& name) : name(name) {
  const bool isKnown = std::any_of(std::begin(ENCODINGS), std::end(ENCODINGS),
                                   [&](const Encoding& e) { return name == e.name; });
  if (isOcio(name))
    checkOcio(name);
  else if (!isKnown)
    throw Error("--display: there is no '" + name + "'; there are:" + listed(names()), ExitStatus::BAD_USAGE);
}

void DisplayEncoding::apply(Image& picture) const {
  if (isOcio(name)) applyOcio(picture, name);
  for (const Encoding& e : ENCODINGS)
    if (name == e.name)
      for (float& value : picture.pixels) value = e.encoded(std::clamp(value, 0.0f, 1.0f));
  for (float& value : picture.pixels) value = std::clamp(value, 0.0f, 1.0f);
}

} // namespace recurse
