/** @file
 * Comparison stills: one render seen class by class, as a picture with layers, as PNGs, as a labelled contact
 * sheet and as a page to look at in a browser.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/model/film/film.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse {

/** The classes to render, so that the whole picture can be had from them. */
struct StillsPlan {
  /** As asked for; then `rest` where they leave paths over; then `all` where they overlap, as their sum is
   * not the picture then. */
  std::vector<PathClass> classes;
  size_t shown = 0;                 ///< how many are to be looked at: all but an `all` that was added
  int beauty = -1;                  ///< the class of all paths; -1: the picture is the sum of the classes
  std::vector<std::string> remarks; ///< what overlaps, what was left over; empty for a disjoint cover
  bool additive() const { return beauty < 0; }
};

/** Throws Error (BAD_USAGE) for names that cannot be those of layers and files, expressions that do not
 * compile, and too many classes. */
StillsPlan planStills(const std::vector<PathClass>& asked);

/** One layer of the stills. */
struct StillLayer {
  std::string name, expression;
  Rgb mean{0};        ///< over the picture
  double share = 0;   ///< of the whole picture's mean luminance
  float exposure = 0; ///< its own, in stops: the 98th percentile of its luminance is shown as 0.9
};

/** What a display shows of a layer whose luminance has its 98th percentile at one, with no exposure. */
constexpr float STILLS_DISPLAY_WHITE = 0.9f;

/** A picture and its classes. */
struct Stills {
  std::vector<StillLayer> layers; ///< the first is the whole picture, named "beauty"
  Image image;                    ///< R, G, B, then NAME.R, NAME.G, NAME.B of each class; metadata
  bool additive = false;          ///< the classes add up to the picture
  std::vector<std::string> remarks;
  std::string title, label; ///< of what, and rendered in which way: for the headings

  /** A layer's colours as a picture of their own. */
  Image layerImage(size_t layer) const;
  /** The one exposure at which layers can be compared: that of the whole picture. */
  float commonExposure() const { return layers.front().exposure; }
};

/** The film of the plan's classes as stills. `scale` is the imaging ratio. */
Stills makeStills(const Film& film, const StillsPlan& plan, float scale);

/** The metadata by which readStills() knows the classes again; call after title and label are set. */
void describeStills(Stills& stills);

/** The picture with layers in a folder that writeStills() filled; a file's own name. */
std::string stillsFile(const std::string& folderOrFile);
/** The layers of a picture that was read from the file. Throws Error naming the file where a layer lacks a
 * channel. */
Stills stillsOf(const Image& picture, const std::string& fileName);
/** Stills from a folder that writeStills() filled or from any picture with layers. Throws Error naming the
 * file. */
Stills readStills(const std::string& folderOrFile);

/** The stops that bring the 98th percentile of the luminance of all pixels that are not black to the linear
 * value that a display shows as 0.9 of its white; zero for a picture that is black. */
float automaticExposure(const Image& image);

/** Where everything is on a contact sheet, in pixels. */
struct SheetLayout {
  int columns = 0, rows = 0;
  int cellWidth = 0, cellHeight = 0, headHeight = 0, margin = 0;
  int pictureWidth = 0, pictureHeight = 0;
  int shrink = 1, enlarge = 1; ///< of the picture; one of the two is 1
  int width() const { return margin + columns * (cellWidth + margin); }
  int height() const { return headHeight + rows * (cellHeight + margin); }
};
SheetLayout sheetLayout(int pictureWidth, int pictureHeight, size_t layers);

/** Every layer twice, at the common and at its own exposure, with name, expression, share and mean; linear,
 * to be written without exposure. */
Image contactSheet(const Stills& stills);

/** A page that needs nothing but itself. With `other`, its layers are there to compare with; Error where the
 * sizes differ. */
std::string stillsPage(const Stills& stills, const Stills* other = nullptr);

/** Name, expression, mean and share of each layer, and the remarks, for a terminal. */
std::string stillsTable(const Stills& stills);

/** Throws Error when stills could not be written to the folder, which is made where it does not exist. */
void checkStillsWritable(const std::string& folder);

/** Writes stills.exr, common/NAME.png, own/NAME.png, sheet.png and index.html; each file appears only when it
 * is complete. Returns their names. */
std::vector<std::string> writeStills(const std::string& folder, const Stills& stills,
                                     const Stills* other = nullptr);

} // namespace recurse
