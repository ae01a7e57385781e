/** @file
 * Page of a developed picture.
 */
#include "recurse/report/develop/develop.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse {

std::string developPage(const Image& picture, const DevelopSettings& settings, const std::string& title,
                        const std::string& operatorName) {
  const Unexposed light = beforeExposure(picture, settings);
  nlohmann::ordered_json pixels, direct;
  addPixels(pixels, light.picture.light);
  pixels["name"] = title;
  if (settings.bloom > 0) addPixels(direct, light.picture.direct);
  const nlohmann::ordered_json data = {{"title", title},
                                       {"width", picture.width},
                                       {"height", picture.height},
                                       {"exposure", light.stops},
                                       {"operator", operatorName},
                                       {"picture", std::move(pixels)},
                                       {"direct", std::move(direct)}};
  return htmlPage({page::DEVELOP_HTML,
                   title,
                   {page::PAGE_CSS, page::STILLS_CSS},
                   {},
                   {page::PIXELS_JS, page::TONE_JS, page::LOCAL_TONE_JS, page::EDGES_JS, page::VIEW_JS,
                    page::DEVELOP_JS}},
                  data);
}

} // namespace recurse
