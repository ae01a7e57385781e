/** @file
 * Cache of the parts that successive frames of an animation have in common.
 */
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "recurse/model/medium/medium.h"
#include "recurse/model/scene/sceneImport.h"
#include "recurse/model/shape/shape.h"

namespace recurse {

class EmbreeDevice;
class GeometryGroup;

/** Parts of the last scene, by keys that identify all inputs of their construction. */
template <class Key, class Part> class KeptByKey {
 public:
  size_t kept = 0, made = 0; ///< numbers of parts reused and of parts made, for the last scene

  /** Removes and returns a part, null where there is none: each is used once in the next scene. */
  std::shared_ptr<Part> take(const Key& key) {
    const auto found = parts.find(key);
    if (found == parts.end()) return nullptr;
    std::shared_ptr<Part> part = std::move(found->second);
    parts.erase(found);
    return part;
  }
  /** Replaces all cached parts by parts of a new scene. */
  void replace(std::multimap<Key, std::shared_ptr<Part>> with) { parts = std::move(with); }

 private:
  std::multimap<Key, std::shared_ptr<Part>> parts;
};

/**
 * Parts kept from one frame to the next: media, models read from files, shapes (with meshes read, subdivided,
 * displaced) of equal parameters and transform, and trees of objects whose shapes are all kept. Shapes are
 * made anew if they use textures or objects (CSG), if their material has an opacity, or if they are diced to
 * the size of pixels. Only one scene at a time can be rendered with the kept parts. A scene must exist until
 * the next one is built, because keys of trees are addresses of shapes.
 */
class KeptParts {
 public:
  /** Key of a tree: each shape, and the mask of the rays that it is visible to. */
  using TreeKey = std::vector<std::pair<const Shape*, unsigned>>;

  std::shared_ptr<EmbreeDevice> device; ///< first, so that it is destroyed last
  KeptByKey<std::string, Shape> shapes;
  KeptByKey<TreeKey, GeometryGroup> trees;
  KeptByKey<std::string, Medium> media;
  KeptByKey<std::string, SceneImport> models;
};

/** Cache key of a plug-in: a hash of its whole directive and of the files in memory that it names. Files on
 * the disk are assumed not to change. */
std::string keyOf(const ParsedDirective& directive);
/** Cache key of a plug-in with its transform to the scene. */
std::string keyOf(const ParsedDirective& directive, const Mat4d& place);

} // namespace recurse
