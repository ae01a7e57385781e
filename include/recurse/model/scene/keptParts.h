/** @file
 * What the scenes of an animation's frames have in common.
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

/** Parts of the scene built last, by keys that say all that they were made from. */
template <class Key, class Part> class KeptByKey {
 public:
  size_t kept = 0, made = 0; ///< of the scene built last

  /** Takes a part out, null where there is none: each stands in one place of the next scene. */
  std::shared_ptr<Part> take(const Key& key) {
    const auto found = parts.find(key);
    if (found == parts.end()) return nullptr;
    std::shared_ptr<Part> part = std::move(found->second);
    parts.erase(found);
    return part;
  }
  /** Keeps parts of a scene in the place of those before. */
  void replace(std::multimap<Key, std::shared_ptr<Part>> with) { parts = std::move(with); }

 private:
  std::multimap<Key, std::shared_ptr<Part>> parts;
};

/**
 * Kept from one frame to the next: shapes (with meshes read, subdivided, displaced) that have the same
 * parameters and place and name neither textures nor objects, trees of objects whose shapes are all kept,
 * media, and models that were read. Only one scene at a time can be rendered with what is kept.
 */
class KeptParts {
 public:
  /** Of a shape in a tree: the shape, and whether it scatters, by which rays see it. */
  using TreeKey = std::vector<std::pair<const Shape*, bool>>;

  std::shared_ptr<EmbreeDevice> device; ///< first, so that it goes last
  KeptByKey<std::string, Shape> shapes;
  KeptByKey<TreeKey, GeometryGroup> trees;
  KeptByKey<std::string, Medium> media;
  KeptByKey<std::string, SceneImport> models;
};

/** Tells whether a plug-in would be made the same: all that its directive says, and files in memory that it
 * names. Files on the disk are taken as unchanged. */
std::string keyOf(const ParsedDirective& directive);
/** The same with a place. */
std::string keyOf(const ParsedDirective& directive, const Mat4d& place);

} // namespace recurse
