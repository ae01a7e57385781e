/** @file
 * Classes of stills by light.
 */
#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <set>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/stills/stills.h"

namespace recurse {

namespace {

/** Layers of a film, less those that planStills() may add. */
constexpr size_t MAX_LAYERS = 62;

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
  if (name.empty()) name = "light";
  std::string unique = name;
  for (int i = 2; !taken.insert(lowerCase(unique)).second; ++i) unique = name + "-" + std::to_string(i);
  return unique;
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
  for (const LampGroup& lamp : lamps) {
    const auto own = std::find_if(stills.layers.begin() + 1, stills.layers.end(),
                                  [&](const StillLayer& layer) { return layer.expression == lightOf(lamp); });
    if (lamp.isMedium) continue; // has no LightScale
    if (own != stills.layers.end())
      own->lamps = {lamp.name};
    else
      others.push_back(lamp.name);
  }
  if (!others.empty()) stills.layers.back().lamps = others;
}

std::vector<PathClass> classesByLight(const std::vector<LampGroup>& lamps,
                                      const std::vector<PathClass>& classes) {
  if (lamps.empty()) throw Error("--by light: the scene has no lamps", ExitStatus::BAD_USAGE);
  const size_t each = std::max<size_t>(classes.size(), 1), most = MAX_LAYERS / each;
  if (most == 0 || (most == 1 && lamps.size() > 1))
    throw Error("--by light: " + std::to_string(classes.size()) +
                    " classes are too many to be divided by light",
                ExitStatus::BAD_USAGE);
  double leastPower = -1;
  if (lamps.size() > most) {
    std::vector<double> powers;
    for (const LampGroup& lamp : lamps) powers.push_back(lamp.isMedium ? INFINITY : lamp.power);
    std::sort(powers.begin(), powers.end(), std::greater<>());
    leastPower = powers[most - 1]; // as strong as the first that gets no layer
  }
  std::set<std::string> taken = {"beauty", "rest", "all"};
  std::vector<PathClass> byLamp;
  std::string own;
  for (const LampGroup& lamp : lamps) {
    if (lamp.power <= leastPower && !lamp.isMedium) continue;
    byLamp.push_back({layerName(lamp.name, taken), lightOf(lamp)});
    own += lightLetter(lamp.name);
  }
  if (byLamp.size() < lamps.size())
    byLamp.push_back({layerName("other-lights", taken), own.empty() ? "all" : "all - [" + own + "].*E"});
  if (classes.empty()) return byLamp;
  std::vector<PathClass> out;
  for (const PathClass& lamp : byLamp)
    for (const PathClass& c : classes)
      out.push_back({lamp.name + "-" + c.name, "(" + lamp.expression + ") & (" + c.expression + ")"});
  return out;
}

} // namespace recurse
