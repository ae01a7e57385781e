/** @file
 * A scene as Python sees it: loaded once, rendered as often as one likes.
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

/** A render beside its options for the command line. */
struct RenderRequest {
  std::vector<std::string> options; ///< as `recurse render` takes them
  std::vector<PathClass> classes;   ///< a layer each, beside that of all paths
  apps::ExtraLayers extra;
  std::vector<std::string> features; ///< names of FeatureLayers
};

struct RenderResult {
  std::shared_ptr<Image> image; ///< R, G and B of all paths, then the other layers
  std::string statistics;       ///< JSON
};

/** Its functions run one at a time, and take as long as it takes; they know nothing of Python. What they
 * throw is an Error, with the place in the scene where that is known. */
class PythonScene {
 public:
  /** `text`: null: the file is read. */
  PythonScene(const std::string& fileName, const std::shared_ptr<const std::string>& text,
              const std::string& directory, bool lenient);

  RenderResult render(const RenderRequest& request,
                      const std::function<void(const RenderProgress&)>& progress);
  std::vector<PhotonRecord> photons(const PhotonRequest& request) const;
  /** The first `samples` camera paths of a pixel, as render() with the same request walks them. */
  PathLists paths(const RenderRequest& request, int x, int y, int64_t samples);
  /** What `--check` prints. */
  std::string report() const;
  /** Makes a render() under way end early. */
  static void stop();
  /** Warnings since the last call, in the order of their coming. */
  std::vector<std::string> takeWarnings();

 private:
  /** Loads the scene again unless it is there with these overrides. */
  void require(const apps::LoadOverrides& overrides);

  std::string fileName;
  std::shared_ptr<const std::string> text;
  std::string directory;
  apps::LoadOverrides built;
  apps::LoadedScene loaded;
  std::vector<std::string> warnings;
};

} // namespace recurse::python
