/** @file
 * Parameters of textures.
 */
#include "recurse/model/texture/texture.h"

namespace recurse {

TexturedRgb realOrTexture(const TextureLookup* textures, const Parameters& p, const std::string& name) {
  if (p.texture(name).empty()) return {Rgb(static_cast<float>(p.real(name)))};
  if (!textures) p.fail(name, "textures are not supported here", "a number");
  return textures->real(p, name);
}

TexturedRgb TextureContext::value(const Parameters& p, const std::string& name) const {
  if (!p.texture(name).empty()) return spectrum ? textures.rgb(p, name) : textures.real(p, name);
  const Rgb constant(p.spectrum(name));
  if (!spectrum && (constant.r != constant.g || constant.g != constant.b))
    p.fail(name, "\"" + name + "\" of a float texture is a colour", "one number, or a float texture");
  if (spectrum && std::min(constant.r, std::min(constant.g, constant.b)) < 0)
    p.fail(name, "\"" + name + "\" of a spectrum texture is negative", "at least 0");
  return {constant};
}

void TextureContext::requireKind(const Parameters& p, bool wanted) const {
  if (spectrum != wanted)
    p.fail("", "\"" + p.plugInName() + "\" cannot be a " + (spectrum ? "spectrum" : "float") + " texture",
           wanted ? "\"spectrum\"" : "\"float\"");
}

ParameterSpec textureValue(const std::string& name, const std::string& defaultText,
                           const std::string& description) {
  return spectrumParameter(name, defaultText, SpectrumKind::SIGNED, description).withTexture();
}

} // namespace recurse
