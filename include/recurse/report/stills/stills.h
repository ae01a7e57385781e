/** @file
 * Comparison stills: one render separated by path class, as a picture with layers, as PNGs, as a labelled
 * contact sheet and as a page for a browser.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/model/film/film.h"
#include "recurse/pathclasses/pathClasses.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse {

/** Classes to render, from which the whole picture can be derived. */
struct StillsPlan {
  /** The classes given; then `rest` where they do not cover all paths; then `all` where they overlap and none
   * of them has all paths, as their sum is not the picture then. */
  std::vector<PathClass> classes;
  size_t shown = 0;                 ///< number of classes to display: all but an added `all`
  int beauty = -1;                  ///< the class of all paths; -1: the picture is the sum of the classes
  std::vector<std::string> remarks; ///< overlaps and uncovered paths; empty for a disjoint cover
  bool additive() const { return beauty < 0; }
};

/** Plans the classes. Throws Error (BAD_USAGE) without classes, for equal names and names that are invalid
 * for layers and files, and for expressions that do not compile; PathClasses throws for too many. `names`: of
 * the scene; null: any name is allowed. */
StillsPlan planStills(const std::vector<PathClass>& asked, const PathNames* names = nullptr);

/** Classes by light, in the order of `lamps`: for each lamp the paths from it; with `classes`, for each lamp
 * its paths in each class. The lamps of least power share the layer `other-lights` where there would be too
 * many; media count as more powerful than all lamps. Throws Error (BAD_USAGE) for a scene without lamps, or
 * too many classes. */
std::vector<PathClass> classesByLight(const std::vector<LampGroup>& lamps,
                                      const std::vector<PathClass>& classes = {});

struct Stills;
/** Sets the lamps of layers that are classesByLight(lamps); layers with light of a medium get none. */
void noteLamps(Stills& stills, const std::vector<LampGroup>& lamps);

/** One layer of the stills. */
struct StillLayer {
  std::string name, expression;
  Rgb mean{0};        ///< over the picture
  double share = 0;   ///< fraction of the whole picture's mean luminance
  float exposure = 0; ///< of this layer [stops]: shows the 98th percentile of its luminance as 0.9
  std::vector<std::string> lamps{}; ///< names of the lamps whose light it is, in stills by light alone
};

/** Display value to which automaticExposure() maps the 98th percentile of the luminance. */
constexpr float STILLS_DISPLAY_WHITE = 0.9f;

/** A picture and its classes. */
struct Stills {
  std::vector<StillLayer> layers; ///< the first is the whole picture, named "beauty"
  Image image;                    ///< R, G, B, then NAME.R, NAME.G, NAME.B for each class; metadata
  bool additive = false;          ///< the classes add up to the picture
  std::vector<std::string> remarks;
  std::string title, label; ///< scene, and settings of the render: for headings
  std::string scene;        ///< file of the scene, without its folder; empty if unknown

  /** Layer as a separate picture. */
  Image layerImage(size_t layer) const;
  /** Common exposure for the comparison of layers: the exposure of the whole picture [stops]. */
  float commonExposure() const { return layers.front().exposure; }
};

/** Stills of the film of the plan's classes. `scale` is the imaging ratio. */
Stills makeStills(const Film& film, const StillsPlan& plan, float scale);

/** Sets the metadata by which readStills() recognises the classes; call after title and label are set. */
void describeStills(Stills& stills);

/** Path of the layered picture in a folder filled by writeStills(); a file's name is returned unchanged. */
std::string stillsFile(const std::string& folderOrFile);
/** Stills from the layers of a picture that was read from the file. Throws Error naming the file where a
 * layer lacks a channel. */
Stills stillsOf(const Image& picture, const std::string& fileName);
/** Reads stills from a folder that writeStills() filled, or from any picture with layers. Throws Error naming
 * the file. */
Stills readStills(const std::string& folderOrFile);

/** Exposure that maps the 98th percentile of the luminance, over all pixels that are not black, to the linear
 * value that a display shows as 0.9 of its white [stops]; zero for a black picture. */
float automaticExposure(const Image& image);

/** Layout of a contact sheet [pixels]. */
struct SheetLayout {
  int columns = 0, rows = 0;
  int cellWidth = 0, cellHeight = 0, headHeight = 0, margin = 0;
  int pictureWidth = 0, pictureHeight = 0;
  int shrink = 1, enlarge = 1; ///< factors of the picture's size; at least one of the two is 1
  int width() const { return margin + columns * (cellWidth + margin); }
  int height() const { return headHeight + rows * (cellHeight + margin); }
};
/** Layout with a cell for each layer, of an aspect ratio of about 3:2. */
SheetLayout sheetLayout(int pictureWidth, int pictureHeight, size_t layers);

/** Contact sheet: every layer twice, at the common and at its own exposure, with name, expression, share and
 * mean; linear, to be written without exposure. */
Image contactSheet(const Stills& stills);

/** Self-contained page. With `other`, it also compares the layers of both stills; throws Error where the
 * sizes differ. */
std::string stillsPage(const Stills& stills, const Stills* other = nullptr);

/** Table for a terminal: name, expression, mean and share of each layer, and the remarks. */
std::string stillsTable(const Stills& stills);

/** Throws Error when stills could not be written to the folder, which is created if it does not exist. */
void checkStillsWritable(const std::string& folder);

/** Writes stills.exr, common/NAME.png, own/NAME.png, sheet.png and index.html; each file appears only when it
 * is complete. `other`: see stillsPage(). Returns the paths of the files. Throws Error. */
std::vector<std::string> writeStills(const std::string& folder, const Stills& stills,
                                     const Stills* other = nullptr);

} // namespace recurse
