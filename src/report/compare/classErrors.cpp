/** @file
 * Error of each class of paths.
 */
#include <algorithm>
#include <optional>

#include "recurse/report/compare/compare.h"
#include "recurse/report/stills/stills.h"

namespace recurse {

namespace {

/** Index of the layer with this name; -1: none. */
int layerNumber(const Stills& stills, const std::string& name) {
  const auto found = std::find_if(stills.layers.begin(), stills.layers.end(),
                                  [&](const StillLayer& layer) { return layer.name == name; });
  return found == stills.layers.end() ? -1 : static_cast<int>(found - stills.layers.begin());
}

/** Reason why the layer cannot be compared with a reference's layer; empty where it can. */
std::string mismatch(const StillLayer& layer, const Stills& reference) {
  const int number = layerNumber(reference, layer.name);
  if (number < 0) return layer.name + ": a reference has none";
  const std::string& expression = reference.layers[size_t(number)].expression;
  if (expression == layer.expression) return {};
  return layer.name + ": it is " + layer.expression + ", in a reference " + expression;
}

Image layerOf(const Stills& stills, const std::string& name) {
  return stills.layerImage(size_t(layerNumber(stills, name)));
}

} // namespace

void addClasses(Comparison& comparison, const Image& x, const Image& a, const Image* b,
                const Image* reference) {
  const Stills picture = stillsOf(x, "the picture");
  if (picture.layers.size() < 2) return;
  const Stills first = stillsOf(a, "the reference");
  std::optional<Stills> second, mean;
  if (b) second = stillsOf(*b, "the second reference");
  if (reference) mean = stillsOf(*reference, "the reference");
  const Stills& truth = mean ? *mean : first;
  for (size_t i = 0; i < picture.layers.size(); ++i) {
    const StillLayer& layer = picture.layers[i];
    std::string why = mismatch(layer, first);
    if (why.empty() && second) why = mismatch(layer, *second);
    if (why.empty() && mean) why = mismatch(layer, *mean);
    if (!why.empty()) {
      comparison.classesLeftOut.push_back(why);
      continue;
    }
    const Image own = picture.layerImage(i), one = layerOf(first, layer.name);
    Image r = layerOf(truth, layer.name);
    ClassError error{layer.name, layer.expression,
                     truth.layers[size_t(layerNumber(truth, layer.name))].share};
    if (second) {
      const Image other = layerOf(*second, layer.name);
      if (!mean) r = meanImage(one, other);
      error.relMseNoiseFreeByScale = errorByScale(own, one, other, r);
    }
    error.relMseByScale = errorByScale(own, r, r, r);
    comparison.classes.push_back(std::move(error));
  }
}

} // namespace recurse
