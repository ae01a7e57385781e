/** @file
 * Recorded paths of a pixel, and classes of paths, as the page of light in a scene reads them.
 */
#pragma once

#include <map>

#include <nlohmann/json.hpp>

#include "recurse/report/inspect/inspect.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse {

using Json = nlohmann::ordered_json;

inline constexpr uint8_t NO_CLASS = 127, CAUSTIC = 128;
inline constexpr uint8_t UNCLASSIFIED = 126; ///< the page finds the class of a path

/** Number rounded to six digits; null if it is not finite. */
Json shortened(double x);
Json numbers(const Vec3f& v);
Json numbers(const Rgb& c);

/** Number of classes, without the layers of frames. */
size_t classCount(const PathClasses& classes);

/** Reads the class, the lamp and the depth of a path from its mask. */
class MaskReader {
 public:
  MaskReader(const PathClasses& classes, const Inspection& inspection);

  /** False if there is one class only, which all paths have. */
  bool hasClasses() const { return shown > 1; }
  size_t shownClasses() const { return shown; }
  /** The first class of a path that is not the class of all paths. */
  uint8_t classOf(LayerMask mask) const;
  /** Index of the lamp; -1: not known. */
  int lampOf(LayerMask mask) const;
  /** Number of events on a photon's path, with the one where it is; 0: not known. */
  uint8_t depthOf(LayerMask mask) const;

 private:
  size_t shown, lamps, depths, lampClasses;
  LayerMask telling = 0; ///< shown classes that do not have all paths
};

/** Table of names that many entries share. */
class NameTable {
 public:
  size_t index(const std::string& name) {
    const auto [found, isNew] = known.try_emplace(name, names.size());
    if (isNew) names.push_back(name);
    return found->second;
  }
  std::vector<std::string> names;

 private:
  std::map<std::string, size_t> known;
};

/** Record of one pixel. Indices refer to entries of the same pixel. Each kind of entry is a list of lists,
 * whose columns pathView.js defines. */
class PixelJson {
 public:
  PixelJson(const Scene& scene, const PathNames& names, const MaskReader& reader, NameTable& table)
      : scene(scene), names(names), reader(reader), table(table) {}

  Json of(const RecordedPixel& pixel);

 private:
  static Json sample(const RecordedSample& s, size_t end);
  Json vertex(const RecordedVertex& v);
  /** Names by which expressions know the surface. */
  Json surfaceNames(uint32_t object, const Material* material);
  /** Names of the vertex of a light path; null where there is no event. */
  Json namesOf(const RecordedLightVertex& v);
  std::string objectOf(const RecordedLightVertex& v) const;
  Json lightVertex(const RecordedLightVertex& v);
  /** Weights of all techniques: a list of technique, number of camera vertices, weight. */
  Json weights(const PathRecorder& record, const RecordedSource& s);
  Json contribution(const PathRecorder& record, const RecordedContribution& c);

  const Scene& scene;
  const PathNames& names;
  const MaskReader& reader;
  NameTable& table;
};

} // namespace recurse
