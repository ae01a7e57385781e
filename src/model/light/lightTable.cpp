/** @file
 * Selection of lights in proportion to their power.
 */
#include <algorithm>

#include "recurse/model/scene/scene.h"

namespace recurse {

void LightTable::build(const std::vector<const Light*>& all) {
  std::vector<double> powers;
  for (const Light* light : all) powers.push_back(double(maxComponent(light->power())));
  build(all, powers);
}

void LightTable::build(const std::vector<const Light*>& all, const std::vector<double>& powers) {
  lights = all;
  probabilities.assign(all.size(), 0);
  cumulative.assign(all.size(), 0);
  double total = 0, sum = 0;
  for (const double power : powers) total += power;
  for (size_t i = 0; i < all.size(); ++i) {
    sum += powers[i];
    probabilities[i] = total > 0 ? static_cast<float>(powers[i] / total) : 0;
    cumulative[i] = total > 0 ? static_cast<float>(sum / total) : 0;
  }
}

size_t LightTable::chooseOfMany(float& u) const {
  const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, u);
  const auto i = static_cast<size_t>(found - cumulative.begin());
  const float below = i > 0 ? cumulative[i - 1] : 0;
  if (probabilities[i] > 0) u = std::clamp((u - below) / (cumulative[i] - below), 0.0f, ONE_MINUS_EPSILON);
  return i;
}

} // namespace recurse
