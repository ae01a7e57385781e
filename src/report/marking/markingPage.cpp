/** @file
 * Page of marks: mistakes, and their positions in the picture.
 */
#include "recurse/report/marking/marking.h"

#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;

/** Picture with black where it has no value. */
Image withoutNan(Image image) {
  for (float& value : image.pixels)
    if (!std::isfinite(value)) value = 0;
  return image;
}

} // namespace

std::string markingPage(const Marking& marking, const Stills& reference, const std::string& title) {
  Json data = Json::parse(markingJson(marking));
  data["title"] = title;
  data["label"] = "marked by " + reference.title + ", " + reference.label;
  data["width"] = reference.image.width;
  data["height"] = reference.image.height;
  data["exposure_of_display"] = reference.commonExposure();
  const std::vector<MarkingStatement> statements = markingStatements(marking);
  for (size_t i = 0; i < statements.size(); ++i) data["statements"][i]["class"] = statements[i].shownClass;
  Json pictures = Json::array();
  const auto add = [&](const std::string& name, const Image& image) {
    Json one = {{"name", name}};
    addPixels(one, image);
    pictures.push_back(std::move(one));
  };
  add("picture", withoutNan(marking.picture));
  for (size_t i = 0; i < reference.layers.size(); ++i) add(reference.layers[i].name, reference.layerImage(i));
  data["pictures"] = std::move(pictures);
  return htmlPage({page::MARKING_HTML,
                   title + " · marks",
                   {page::PAGE_CSS, page::MARKING_CSS},
                   {},
                   {page::PIXELS_JS, page::MARKING_JS}},
                  data);
}

} // namespace recurse
