/** @file
 * Page of stills.
 */

#include "recurse/core/io/error.h"
#include "recurse/report/stills/stills.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse {

namespace {

nlohmann::ordered_json setJson(const Stills& stills) {
  const auto metadata = [&](const char* name) {
    const auto found = stills.image.metadata.find(name);
    return found == stills.image.metadata.end() ? std::string() : found->second;
  };
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    const StillLayer& layer = stills.layers[i];
    nlohmann::ordered_json json = {{"name", layer.name},
                                   {"expression", layer.expression},
                                   {"mean", {layer.mean.r, layer.mean.g, layer.mean.b}},
                                   {"share", layer.share},
                                   {"exposure", layer.exposure}};
    if (!layer.lamps.empty()) json["lamps"] = layer.lamps;
    // Where the classes add up to the whole picture, the page adds them.
    if (i > 0 || !stills.additive) addPixels(json, stills.layerImage(i));
    layers.push_back(std::move(json));
  }
  return {{"title", stills.title},
          {"label", stills.label},
          {"settings", metadata("recurse:settings")},
          {"software", metadata("Software")},
          {"additive", stills.additive},
          {"remarks", stills.remarks},
          {"scene", stills.scene},
          {"layers", std::move(layers)}};
}

} // namespace

std::string stillsPage(const Stills& stills, const Stills* other) {
  if (other && (other->image.width != stills.image.width || other->image.height != stills.image.height))
    throw Error("the stills to compare with have " + std::to_string(other->image.width) + "x" +
                std::to_string(other->image.height) + " pixels, but these have " +
                std::to_string(stills.image.width) + "x" + std::to_string(stills.image.height));
  nlohmann::ordered_json sets = nlohmann::ordered_json::array();
  sets.push_back(setJson(stills));
  if (other) sets.push_back(setJson(*other));
  const nlohmann::ordered_json data = {
      {"width", stills.image.width}, {"height", stills.image.height}, {"sets", std::move(sets)}};
  return htmlPage({page::STILLS_HTML,
                   stills.title + " · stills",
                   {page::PAGE_CSS, page::STILLS_CSS},
                   {},
                   {page::PIXELS_JS, page::TONE_JS, page::LOCAL_TONE_JS, page::EDGES_JS, page::STILLS_DATA_JS,
                    page::VIEW_JS, page::STILLS_JS}},
                  data);
}

} // namespace recurse
