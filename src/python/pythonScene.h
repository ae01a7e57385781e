/** @file
 * Scene of the Python module: loaded once, rendered any number of times.
 */
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/load/loadedScene.h"
#include "apps/options/renderOptions.h"
#include "python/pathList.h"
#include "python/photonList.h"
#include "recurse/core/image/image.h"

namespace recurse::python {

/** Arguments of a render. */
struct RenderRequest {
  std::vector<std::string> options; ///< options of `recurse render`
  std::vector<PathClass> classes;   ///< one layer each, after the layer of all paths
  apps::ExtraLayers extra;
  std::vector<std::string> features; ///< names of FeatureLayers
};

struct RenderResult {
  std::shared_ptr<Image> image; ///< R, G and B of all paths, then the layers of classes
  std::string statistics;       ///< JSON
};

/** Scene of the Python module. Its functions run one at a time, block until the work is done, and do not use
 * Python. They throw Error, with the location in the scene where it is known. */
class PythonScene {
 public:
  /** `text`: content of the scene file; null: the file is read. */
  PythonScene(std::string fileName, std::shared_ptr<const std::string> text, std::string directory,
              bool lenient);

  RenderResult render(const RenderRequest& request,
                      const std::function<void(const RenderProgress&)>& progress);
  std::vector<PhotonRecord> photons(const PhotonRequest& request) const;
  /** First `samples` camera paths of a pixel, identical to those in render() of the same request. */
  PathLists paths(const RenderRequest& request, int x, int y, int64_t samples);
  /** Report that `--check` prints. */
  std::string report() const;
  /** Ends a running render() early. */
  static void stop();
  /** Warnings since the last call, in chronological order. */
  std::vector<std::string> takeWarnings();

 private:
  /** Loads the scene, unless it is loaded with the same overrides. */
  void require(const apps::LoadOverrides& overrides);

  std::string fileName;
  std::shared_ptr<const std::string> text;
  std::string directory;
  apps::LoadOverrides built;
  apps::LoadedScene loaded;
  std::vector<std::string> warnings;
};

} // namespace recurse::python
