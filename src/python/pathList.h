/** @file
 * Camera paths of a pixel as lists.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "recurse/render/recordPixels.h"

namespace recurse::python {

/** Capacity of a record for the letters of a path. */
constexpr size_t MAX_PATH_LETTERS = 17;

/** Vertex at which a camera path scatters. */
struct PathVertexRecord {
  int32_t sample;                  ///< number of the sample in the pixel
  int32_t previous;                ///< index of the previous vertex; -1: the camera
  std::array<char, 1> event;       ///< at `previous`: S, D or V; E: the camera
  std::array<double, 3> position;  ///< in world space
  std::array<float, 3> normal;     ///< geometric, unit, on the side of the path; 0 in a medium
  std::array<float, 3> throughput; ///< throughput of the camera path at the vertex
  float pdf, pdfReverse; ///< of the direction from `previous`, and of the reverse walk [1/sr]; 0: delta
};

/** Radiance that reaches the pixel by one technique. */
struct PathContributionRecord {
  int32_t sample;    ///< number of the sample in the pixel
  int32_t vertex;    ///< index of the last vertex from the camera; -1: the camera sees the light
  int32_t technique; ///< PathTechnique
  std::array<char, MAX_PATH_LETTERS> path; ///< events from `vertex` to the camera, then E; truncated
  float weight;                            ///< MIS weight
  float pdf, otherPdf;           ///< density of this and the competing technique [1/sr]; 0: delta or unknown
  std::array<float, 3> radiance; ///< weight and throughput included
  int32_t pathClass;             ///< index of the first class of the path; -1: none
};

struct PathLists {
  std::vector<PathVertexRecord> vertices;
  std::vector<PathContributionRecord> contributions;
  Rgb value{0}; ///< value of the pixel, see RecordedPixel
};

/** Lists the record of a pixel. Layer 0 of its classes must have all paths; later ones count from 0. */
PathLists listPaths(const Scene& scene, const RecordedPixel& pixel);

} // namespace recurse::python
