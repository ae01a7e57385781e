/** @file
 * The page of a developed picture.
 */
#include "recurse/report/develop.h"
#include "report/htmlPage.h"
#include "report/page/embedded.h"

namespace recurse {

std::string developPage(const Image& picture, const DevelopSettings& settings, const std::string& title,
                        const std::string& operatorName) {
  const Developed light = beforeExposure(picture, settings);
  nlohmann::ordered_json pixels;
  addPixels(pixels, light.picture);
  pixels["name"] = title;
  const nlohmann::ordered_json data = {{"title", title},           {"width", picture.width},
                                       {"height", picture.height}, {"exposure", light.stops},
                                       {"operator", operatorName}, {"picture", std::move(pixels)}};
  return htmlPage({page::DEVELOP_HTML,
                   title,
                   {page::PAGE_CSS, page::STILLS_CSS},
                   {},
                   {page::PIXELS_JS, page::TONE_JS, page::LOCAL_TONE_JS, page::EDGES_JS, page::VIEW_JS,
                    page::DEVELOP_JS}},
                  data);
}

} // namespace recurse
