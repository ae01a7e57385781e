/** @file
 * Media of a scene: numbered when they are first used, made once it is known where the scene is.
 */
#pragma once

#include <map>

#include "model/builder/buildContext.h"
#include "recurse/model/medium/medium.h"

namespace recurse {

class SceneMedia {
 public:
  explicit SceneMedia(BuildContext& context) : c(context) {}

  /** The number of a medium; 0 for vacuum, and for one that is not there. */
  uint16_t number(const std::string& name, const SourceLocation& usedAt);
  MediumInterface numbers(const MediumReference& names, const SourceLocation& usedAt) {
    return {number(names.inside, usedAt), number(names.outside, usedAt)};
  }
  /** The number of what a material fills its shapes with; the directive stays where it is. */
  uint16_t number(const ParsedDirective& filling);
  size_t count() const { return used.size(); }
  /** For messages. */
  std::string title(uint16_t number) const {
    if (!number) return "empty space";
    const std::string& name = used[number - 1u].name;
    return name.empty() ? "the medium of the material" : "medium \"" + name + "\"";
  }
  /** Medium `index` + 1 and its phase function, each with those of the directive's parameters that it
   * declares. Null after an error. */
  std::shared_ptr<Medium> make(size_t index, float maxExtinction) const;
  /** What tells whether it would be made the same. */
  std::string key(size_t index, float maxExtinction) const;

 private:
  struct Used {
    std::string name; ///< empty: of a material
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
