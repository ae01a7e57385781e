/** @file
 * Classes of stills by light.
 */
#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <set>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/stills/stills.h"

namespace recurse {

namespace {

/** Layers of a film, less those that planStills() may add. */
constexpr size_t MAX_LAYERS = 62;

/** Name that differs from those taken, also in lower case; a number is appended where needed. */
std::string uniqueName(const std::string& name, std::set<std::string>& taken) {
  std::string unique = name;
  for (int i = 2; !taken.insert(lowerCase(unique)).second; ++i) unique = name + "-" + std::to_string(i);
  return unique;
}

/** Name of a lamp as the name of a layer: other characters become '-'. */
std::string layerName(const std::string& lamp, std::set<std::string>& taken) {
  constexpr size_t MAX_LENGTH = 40;
  std::string name;
  for (const char c : lamp.substr(0, MAX_LENGTH)) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
    if (plain || !(name.empty() || name.back() == '-')) name += plain ? c : '-';
  }
  while (!name.empty() && !std::isalnum(static_cast<unsigned char>(name.front()))) name.erase(0, 1);
  while (!name.empty() && name.back() == '-') name.pop_back();
  return uniqueName(name.empty() ? "light" : name, taken);
}

/** A lamp as the beginning of an expression. */
std::string lightLetter(const std::string& name) {
  std::string out = "L'";
  for (const char c : name) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

std::string lightOf(const LampGroup& lamp) { return lightLetter(lamp.name) + ".*E"; }

} // namespace

void noteLamps(Stills& stills, const std::vector<LampGroup>& lamps) {
  std::vector<std::string> others;
  bool isMediumAmongOthers = false;
  for (const LampGroup& lamp : lamps) {
    const auto own = std::find_if(stills.layers.begin() + 1, stills.layers.end(),
                                  [&](const StillLayer& layer) { return layer.expression == lightOf(lamp); });
    if (own == stills.layers.end()) {
      others.push_back(lamp.name);
      isMediumAmongOthers = isMediumAmongOthers || lamp.isMedium;
    } else if (!lamp.isMedium) { // a medium has no LightScale
      own->lamps = {lamp.name};
    }
  }
  if (!others.empty() && !isMediumAmongOthers) stills.layers.back().lamps = others;
}

std::vector<PathClass> classesByLight(const std::vector<LampGroup>& lamps,
                                      const std::vector<PathClass>& classes) {
  if (lamps.empty()) throw Error("--by light: the scene has no lamps", ExitStatus::BAD_USAGE);
  const size_t each = std::max<size_t>(classes.size(), 1), most = MAX_LAYERS / each;
  if (most == 0 || (most == 1 && lamps.size() > 1))
    throw Error("--by light: " + std::to_string(classes.size()) +
                    " classes are too many to be divided by light",
                ExitStatus::BAD_USAGE);
  std::vector<size_t> byPower(lamps.size());
  std::iota(byPower.begin(), byPower.end(), size_t{0});
  const auto powerOf = [](const LampGroup& lamp) { return lamp.isMedium ? double(INFINITY) : lamp.power; };
  std::stable_sort(byPower.begin(), byPower.end(),
                   [&](size_t i, size_t j) { return powerOf(lamps[i]) > powerOf(lamps[j]); });
  std::vector<bool> isShown(lamps.size(), lamps.size() <= most);
  for (size_t k = 0; k + 1 < most && k < lamps.size(); ++k) isShown[byPower[k]] = true;
  std::set<std::string> taken = {"beauty", "rest", "all"};
  std::vector<PathClass> byLamp;
  std::string own;
  for (size_t i = 0; i < lamps.size(); ++i) {
    if (!isShown[i]) continue;
    byLamp.push_back({layerName(lamps[i].name, taken), lightOf(lamps[i])});
    own += lightLetter(lamps[i].name);
  }
  if (byLamp.size() < lamps.size())
    byLamp.push_back({layerName("other-lights", taken), own.empty() ? "all" : "all - [" + own + "].*E"});
  if (classes.empty()) return byLamp;
  std::vector<PathClass> out;
  std::set<std::string> takenByClasses;
  for (const PathClass& lamp : byLamp)
    for (const PathClass& c : classes)
      out.push_back({uniqueName(lamp.name + "-" + c.name, takenByClasses),
                     "(" + lamp.expression + ") & (" + c.expression + ")"});
  return out;
}

} // namespace recurse
