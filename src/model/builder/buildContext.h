/** @file
 * Context and helpers shared by the parts of the scene builder.
 */
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "recurse/core/math/animatedTransform.h"
#include "recurse/core/math/vector.h"
#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

class Camera;
struct FilmSettings;

struct BuildContext {
  const SceneDescription& description;
  bool lenient; ///< unknown parameters are warnings
  Diagnostics& diagnostics;
  Vec3d& sceneOrigin; ///< subtracted from world coordinates
  bool saidEnough = false;

  /** True after MAX_ERRORS errors, so that the first ones stay visible; warns once. */
  bool enoughErrors() {
    constexpr size_t MAX_ERRORS = 50;
    if (diagnostics.errors() < MAX_ERRORS) return false;
    if (!saidEnough) diagnostics.warning({}, "further errors are not shown");
    saidEnough = true;
    return true;
  }
};

/** One of the cameras of a scene, for a film, in the space with its origin at the world point `origin`. Null
 * after an error. */
std::unique_ptr<Camera> makeCamera(const CameraDescription& camera, const SceneDescription& description,
                                   const FilmSettings& film, const Vec3d& origin, Diagnostics& diagnostics,
                                   bool lenient);

/** True where squares of the coordinates fit single precision. False for NaN. */
inline bool representable(const Vec3f& p) {
  constexpr float LARGEST_COORDINATE = 1e18f;
  return glm::all(glm::lessThanEqual(glm::abs(p), Vec3f(LARGEST_COORDINATE)));
}

inline Mat4d translation(const Vec3d& by) {
  Mat4d m(1);
  m[3] = Vec4d(by, 1);
  return m;
}

/** Transform to the space with its origin at the world point `origin`. */
inline Mat4d recentred(const Mat4d& worldFromObject, const Vec3d& origin) {
  Mat4d m = worldFromObject;
  m[3] -= Vec4d(origin, 0);
  return m;
}

/** Names in quotes, for messages: "a", "b". */
inline std::string quotedList(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& n : names) list += (list.empty() ? "\"" : ", \"") + n + "\"";
  return list;
}

/** The keys of a map of the description. */
template <class Map> std::vector<std::string> namesOf(const Map& map) {
  std::vector<std::string> names;
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

} // namespace recurse
