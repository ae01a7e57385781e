/** @file
 * Image textures.
 */
#include <optional>

#include "recurse/core/image/imageTexture.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/texture/textureMapping.h"

namespace recurse {

namespace {

class ImageMap final : public Texture {
 public:
  ImageMap(const TextureMapping& mapping, ImageTexture image, float scale, bool invert, bool spectrum,
           std::optional<float> threshold)
      : mapping(mapping), image(std::move(image)), scale(scale), invert(invert), spectrum(spectrum),
        threshold(threshold) {}

  Rgb value(const SurfacePoint& point) const override {
    const MappedCoordinates m = mapping.at(point);
    // The texture's t goes up from the lower edge of the picture.
    Rgb v = scale * image.at({m.st.x, 1 - m.st.y}, {m.alongX.x, -m.alongX.y}, {m.alongY.x, -m.alongY.y});
    if (!spectrum) v = Rgb(v.r);
    if (invert) v = max(1 - v, 0);
    return threshold ? Rgb(v.r >= *threshold, v.g >= *threshold, v.b >= *threshold) : v;
  }

 private:
  TextureMapping mapping;
  ImageTexture image;
  float scale;
  bool invert, spectrum;
  std::optional<float> threshold; ///< values of at least this become 1, lower ones 0
};

ImageEncoding encodingOf(const Parameters& p) {
  const std::string text = p.hasValue("encoding") ? p.string("encoding") : "sRGB";
  if (text == "sRGB") return {ImageEncoding::Kind::SRGB, 1};
  if (text == "linear") return {ImageEncoding::Kind::LINEAR, 1};
  constexpr const char* ACCEPTED = "\"sRGB\" \"linear\" \"gamma 2.2\" with a positive number";
  if (text.starts_with("gamma ")) {
    char* end = nullptr;
    const float gamma = std::strtof(text.c_str() + 6, &end);
    if (*end == '\0' && gamma > 0 && std::isfinite(gamma)) return {ImageEncoding::Kind::GAMMA, gamma};
  }
  p.fail("encoding", "parameter \"encoding\" cannot be \"" + text + "\"", ACCEPTED);
}

std::unique_ptr<Texture> makeImageMap(const Parameters& p, const TextureContext& c) {
  ImageTextureSettings s;
  const std::string filter = p.string("filter"), wrap = p.string("wrap");
  s.filter = filter == "point"       ? ImageTextureSettings::Filter::POINT
             : filter == "bilinear"  ? ImageTextureSettings::Filter::BILINEAR
             : filter == "trilinear" ? ImageTextureSettings::Filter::TRILINEAR
                                     : ImageTextureSettings::Filter::EWA;
  s.wrap = wrap == "repeat"  ? ImageTextureSettings::Wrap::REPEAT
           : wrap == "black" ? ImageTextureSettings::Wrap::BLACK
           : wrap == "clamp" ? ImageTextureSettings::Wrap::CLAMP
                             : ImageTextureSettings::Wrap::OCTAHEDRAL;
  s.maxAnisotropy = static_cast<float>(p.real("maxanisotropy"));
  const ImageEncoding encoding = encodingOf(p);
  const std::string channel = p.string("channel");
  s.channels = channel == "red"     ? ImageChannels::RED
               : channel == "green" ? ImageChannels::GREEN
               : channel == "blue"  ? ImageChannels::BLUE
               : channel == "alpha" ? ImageChannels::ALPHA
                                    : ImageChannels::COLOURS;
  std::optional<float> threshold;
  if (p.has("threshold")) threshold = static_cast<float>(p.real("threshold"));
  const TextureMapping mapping(p, c);
  const FileReference file = p.file("filename");
  try {
    return std::make_unique<ImageMap>(mapping, ImageTexture(file, encoding, s),
                                      static_cast<float>(p.real("scale")), p.boolean("invert"), c.spectrum,
                                      threshold);
  } catch (const Error& e) {
    p.fail("filename", e.what());
  }
}

} // namespace

void registerImageMap(PlugIns& plugIns) {
  plugIns.textures.add(
      {{.name = "imagemap",
        .summary =
            "A picture; its lower left corner is at (s, t) = (0, 0). A float texture uses its first channel.",
        .parameters = withMapping(
            {stringParameter("filename", "", "picture in any format that OpenImageIO reads").require(),
             stringParameter("filter", "bilinear",
                             "filter if a pixel of the film covers many texels: one mipmap level (point, "
                             "bilinear), two levels (trilinear), or an ellipse (EWA)")
                 .oneOf({"point", "bilinear", "trilinear", "EWA", "ewa"}),
             realParameter("maxanisotropy", "8", "maximum ratio of the axes of the ellipse of EWA")
                 .range(1, 64),
             stringParameter("wrap", "repeat", "lookup outside of the picture")
                 .oneOf({"repeat", "black", "clamp", "octahedralsphere"}),
             realParameter("scale", "1", "factor on the values"),
             booleanParameter("invert", "false", "use 1 - value, at least 0, after scale"),
             stringParameter("channel", "colours", "use this channel of the picture only")
                 .oneOf({"colours", "red", "green", "blue", "alpha"}),
             realParameter("threshold", "", "values from this on become 1, others 0; for cut-outs"),
             stringParameter(
                 "encoding", "",
                 "encoding of colours of integer formats: \"sRGB\" (default), \"linear\", or "
                 "\"gamma 2.2\" with any exponent. Alpha and floating-point formats are linear")}),
        .examples = {}},
       makeImageMap});
}

} // namespace recurse
