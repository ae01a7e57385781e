/** @file
 * Names of a scene's lights and surfaces, to which path expressions refer.
 */
#pragma once

#include <string>
#include <vector>

namespace recurse {

/** Names of lights and surfaces by their indices; an empty list of names means no name. */
struct PathNames {
  using List = std::vector<std::string>;
  std::vector<List> lights;    ///< by index of the light; lists of the media follow
  std::vector<List> objects;   ///< by index of the object
  std::vector<List> materials; ///< by number of the material
};

} // namespace recurse
