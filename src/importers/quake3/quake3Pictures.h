/** @file
 * Pictures of a Quake III map: found by the names of textures, stored for the scene, and averaged.
 */
#pragma once

#include <map>
#include <string>

#include "importers/quake3/gameFiles.h"
#include "recurse/core/image/image.h"
#include "recurse/core/io/zipArchive.h"
#include "recurse/model/scene/sceneImport.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

class Quake3Pictures {
 public:
  /** Warnings of unreadable pictures refer to the parameter "pak" of `p`, the names of the archives. */
  Quake3Pictures(const Parameters& p, const GameFiles& game, SceneImport& import, ImportWriter& out)
      : p(p), game(game), import(import), out(out) {}

  /** File of the scene with the picture of a texture name; empty where there is none. */
  std::string find(const std::string& name);
  /** Picture in a file that find() has returned. */
  const Image& image(const std::string& file) const { return decoded.at(file); }

  /** Mean of a picture in its display encoding, scaled so that its largest component is 1, as q3map
   * colours light. White where there is no picture. */
  Rgbd lightColour(const std::string& file) const;
  /** Largest component of the mean of the linear picture. */
  double meanMaximum(const std::string& file) const;
  /** Mean opacity of an additive surface: its opacity is the encoded red of the picture. */
  double meanOpacity(const std::string& file) const;

 private:
  const Parameters& p;
  const GameFiles& game;
  SceneImport& import;
  ImportWriter& out;
  std::map<std::string, std::string> files; ///< files of the scene by texture names
  std::map<std::string, Image> decoded;     ///< pictures by files of the scene
};

} // namespace recurse
