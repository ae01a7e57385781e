/** @file
 * Opacity, bumps and normal maps as parameters.
 */
#include "recurse/model/scene/surfaceParameters.h"

#include "recurse/model/bsdf/surfaceDetail.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

void readAlpha(Shape& shape, const Parameters& p, const ShapeContext& c) {
  const TexturedRgb alpha = realOrTexture(c.textures, p, "alpha");
  const bool isOpaque = !alpha.texture && alpha.constant.r >= 1;
  const Texture* opacity = c.material ? c.material->opacity.get() : nullptr;
  if (opacity && !isOpaque)
    p.fail("alpha", "the shape's material is a mix with \"interface\", which replaces \"alpha\"");
  if (opacity)
    shape.alpha = std::make_shared<const TexturedRgb>(TexturedRgb{BLACK, opacity, 0, 1});
  else if (!isOpaque)
    shape.alpha = std::make_shared<const TexturedRgb>(alpha);
}

void readDetail(Material& material, const Parameters& p, const MaterialContext& c) {
  const bool displaced = p.has("displacement"), mapped = p.has("normalmap");
  if (displaced && mapped)
    p.fail("normalmap", "both \"displacement\" and \"normalmap\" are given", "one of them");
  if (displaced) {
    if (p.texture("displacement").empty())
      p.fail("displacement", "a constant displacement has no effect",
             "\"texture displacement\" with the name of a float texture");
    material.detail = bumps(c.textures.real(p, "displacement"));
  }
  if (!mapped) return;
  const FileReference file = p.file("normalmap");
  try {
    material.detail = normalMap(file);
  } catch (const Error& e) {
    p.fail("normalmap", e.what());
  }
}

} // namespace

void addSurfaceParameters(PlugIns& plugIns) {
  const auto name = [](const std::string& meaning) {
    return std::vector<ParameterSpec>{stringParameter("name", "", meaning)};
  };
  plugIns.shapes.addToAll(
      name("name of the surface in path expressions and Cryptomattes, outside of ObjectBegin"),
      [](Shape&, const Parameters&, const ShapeContext&) {});
  plugIns.lights.addToAll(name("name of the lamp in path expressions"),
                          [](Light&, const Parameters&, const LightContext&) {});
  plugIns.areaLights.addToAll(name("name of the lamp in path expressions; by default that of its shape"),
                              [](AreaLight&, const Parameters&, const AreaLightContext&) {});
  plugIns.shapes.addToAll({realParameter("alpha", "1",
                                         "opacity: the probability that a ray hits the surface; other rays "
                                         "pass through. An area light with opacity 0 is invisible, but emits")
                               .withTexture()},
                          readAlpha);
  plugIns.materials.addToAll(
      {realParameter("displacement", "",
                     "height of bumps, which change only the shading normal [scene units]")
           .withTexture(),
       stringParameter("normalmap", "",
                       "normal map: red along u, green across, blue outwards; 0 to 1 is -1 to 1")},
      readDetail, {"interface"});
}

} // namespace recurse
