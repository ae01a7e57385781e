/** @file
 * The pictures of a Quake III map: found by the names of textures, kept for the scene, and averaged.
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
  /** Pictures that cannot be read are warned of at parameter "pak" of `p`, the archives' names. */
  Quake3Pictures(const Parameters& p, const GameFiles& game, SceneImport& import, ImportWriter& out)
      : p(p), game(game), import(import), out(out) {}

  /** The file of the scene with the picture of a texture name; empty where there is none. */
  std::string find(const std::string& name);
  /** As find() returned it. */
  const Image& image(const std::string& file) const { return decoded.at(file); }

  /** Mean of a picture as it is coded for displays, scaled so that its largest component is 1: so q3map
   * colours light. White where there is no picture. */
  Rgbd lightColour(const std::string& file) const;
  /** The largest component of the mean of its light. */
  double meanMaximum(const std::string& file) const;
  /** Of an additive surface: the mean of the picture's coded red, which its opacity is made of. */
  double meanOpacity(const std::string& file) const;

 private:
  const Parameters& p;
  const GameFiles& game;
  SceneImport& import;
  ImportWriter& out;
  std::map<std::string, std::string> files; ///< by texture names
  std::map<std::string, Image> decoded;     ///< by files of the scene
};

} // namespace recurse
