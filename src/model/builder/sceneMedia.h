/** @file
 * Media of a scene: numbered at their first use, made when the scene's origin is known.
 */
#pragma once

#include <map>

#include "model/builder/buildContext.h"
#include "recurse/model/medium/medium.h"

namespace recurse {

class SceneMedia {
 public:
  explicit SceneMedia(BuildContext& context) : c(context) {}

  /** The number of a medium; 0 for vacuum, and after an error. */
  uint16_t number(const std::string& name, const SourceLocation& usedAt);
  MediumInterface numbers(const MediumReference& names, const SourceLocation& usedAt) {
    return {number(names.inside, usedAt), number(names.outside, usedAt)};
  }
  /** The number of a material's filling. The directive must keep its address. */
  uint16_t number(const ParsedDirective& filling);
  size_t count() const { return used.size(); }
  /** The medium's name for messages. */
  std::string title(uint16_t number) const {
    if (!number) return "empty space";
    const std::string& name = used[number - 1u].name;
    return name.empty() ? "the medium of the material" : "medium \"" + name + "\"";
  }
  /** Name of medium `index` + 1; empty for the filling of a material. */
  const std::string& name(size_t index) const { return used[index].name; }
  /** Makes medium `index` + 1 and its phase function, each with the parameters of the directive that it
   * declares. Null after an error. */
  std::shared_ptr<Medium> make(size_t index, float maxExtinction) const;
  /** Warns of media of an unknown type that nothing uses. */
  void warnOfUnknownTypes() const;
  /** Cache key of medium `index` + 1: equal for media that are made alike. */
  std::string key(size_t index, float maxExtinction) const;

 private:
  struct Used {
    std::string name; ///< empty: filling of a material
    const ParsedDirective* directive;
    Mat4d worldFromMedium;
  };
  uint16_t add(const Used& medium);

  BuildContext& c;
  std::map<std::string, uint16_t> byName;
  std::map<const ParsedDirective*, uint16_t> byFilling;
  std::vector<Used> used; ///< by number - 1
};

} // namespace recurse
