/** @file
 * Quake II models (MD2, version 8): triangle meshes with keyframes. Positions are stored as bytes, relative
 * to the box of their keyframe.
 */
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recurse/core/io/byteReader.h"
#include "recurse/model/mesh/triangleMesh.h"

namespace recurse {

/** Model in memory. All reads are checked, and throw Error with the offset. +z is up, and the model faces
 * +x. */
class Md2Model {
 public:
  /** The bytes must outlive the model; `name` is for messages. */
  Md2Model(const std::string& name, std::string_view bytes);

  uint64_t frames() const { return frameCount; }
  /** Names of the pictures of skins. */
  std::vector<std::string> skins() const;
  /** Names of animations: "stand, run, death" for frames named stand01, stand02 and so on. */
  std::string animations() const;
  /** The pose at a frame from 0 to frames() - 1; between two of them positions are interpolated. */
  MeshData pose(double frame) const;

 private:
  uint64_t frameAt(uint64_t frame) const { return framesAt + frame * frameSize; }
  std::vector<Vec3d> positions(uint64_t frame) const;
  uint32_t indexAt(uint64_t offset, const char* what, uint64_t count) const;
  Vec2d texCoord(uint32_t index) const;

  ByteReader file;
  uint64_t skinWidth, skinHeight, frameSize, skinCount, vertices, texCoords, triangles, frameCount;
  uint64_t skinsAt, texCoordsAt, trianglesAt, framesAt;
};

} // namespace recurse
