/** @file
 * Directives that only set parameters: Film and Accelerator.
 */
#include <cmath>

#include "recurse/model/scene/plugIns.h"
#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

namespace {

/** Sensor names of pbrt-v4. */
const std::vector<std::string>& sensorNames() {
  static const std::vector<std::string> NAMES = {
      "cie1931",       "canon_eos_100d",     "canon_eos_1dx_mkii", "canon_eos_200d",    "canon_eos_200d_mkii",
      "canon_eos_5d",  "canon_eos_5d_mkii",  "canon_eos_5d_mkiii", "canon_eos_5d_mkiv", "canon_eos_5ds",
      "canon_eos_m",   "hasselblad_l1d_20c", "nikon_d810",         "nikon_d850",        "sony_ilce_6400",
      "sony_ilce_7m3", "sony_ilce_7rm3",     "sony_ilce_9"};
  return NAMES;
}

void setColours(const Parameters& p, FilmSettings& film) {
  double white = p.real("whitebalance");
  constexpr double COOLEST = 1000; // cooler bodies have no colour in these primaries
  if (white > 0 && white < COOLEST)
    p.fail("whitebalance", "white is not defined for " + std::to_string(white) + " K",
           "0, or 1000 to 1000000");
  if (p.string("sensor") != "cie1931") {
    p.warn("sensor", "the spectral response of \"" + p.string("sensor") +
                         "\" is not available: the CIE 1931 matching functions are used");
    if (white == 0) white = 6500; // pbrt's default for camera sensors
  }
  if (white > 0) film.whiteBalance = Mat3f(whiteBalance(white));
  if (p.has("maxcomponentvalue")) {
    film.maxComponent = static_cast<float>(p.real("maxcomponentvalue"));
    p.warn("maxcomponentvalue",
           "samples brighter than this are clamped: the picture is darker than the light in the scene");
  }
}

} // namespace

void registerRgbFilm(PlugIns& plugIns) {
  plugIns.films.add(
      {{.name = "rgb",
        .summary = "Linear Rec. 709 pixels.",
        .parameters =
            {integerParameter("xresolution", "1280", "width [pixels]").range(1, 65536),
             integerParameter("yresolution", "720", "height [pixels]").range(1, 65536),
             arrayParameter(ParameterType::REAL, "cropwindow", 4, "",
                            "x0 x1 y0 y1: the part to render, as fractions of width and height")
                 .range(0, 1),
             arrayParameter(ParameterType::INTEGER, "pixelbounds", 4, "",
                            "x0 x1 y0 y1: the part to render [pixels]"),
             stringParameter("filename", "recurse.exr", "picture file, if the command line names none"),
             realParameter("iso", "100", "sensitivity; the picture is multiplied by exposuretime iso / 100")
                 .positive(),
             realParameter("exposuretime", "1", "[s]").positive(),
             realParameter("diagonal", "35", "diagonal of the film, for the camera \"realistic\" [mm]")
                 .positive(),
             ignoredParameter(ParameterType::BOOLEAN, "savefp16",
                              "pictures are always written in single precision"),
             realParameter(
                 "whitebalance", "0",
                 "colour temperature that becomes white [K]; 0: no change, or 6500 with a camera's sensor")
                 .range(0, 1e6),
             stringParameter("sensor", "cie1931",
                             "spectral response; the CIE matching functions replace those of cameras")
                 .oneOf(sensorNames()),
             realParameter("maxcomponentvalue", "",
                           "maximum X, Y or Z of a sample after exposure; brighter samples are clamped, "
                           "which darkens the picture")
                 .positive()},
        .examples = {"\"integer xresolution\" 64 \"integer yresolution\" 48",
                     "\"float whitebalance\" 4000 \"float maxcomponentvalue\" 10"}},
       [](const Parameters& p, const NoContext&) {
         auto film = std::make_unique<FilmSettings>();
         setColours(p, *film);
         film->width = p.integer("xresolution");
         film->height = p.integer("yresolution");
         film->crop = film->whole();
         if (p.has("pixelbounds")) {
           const std::vector<int> b = p.integers("pixelbounds");
           film->crop = {b[0], b[2], b[1], b[3]};
           if (b[0] < 0 || b[2] < 0 || b[1] > film->width || b[3] > film->height || b[0] >= b[1] ||
               b[2] >= b[3])
             p.fail("pixelbounds", "the part is empty or not inside of the film",
                    "0 <= x0 < x1 <= " + std::to_string(film->width) +
                        " and 0 <= y0 < y1 <= " + std::to_string(film->height));
         }
         if (p.has("cropwindow")) {
           if (p.has("pixelbounds"))
             p.fail("cropwindow", "both \"cropwindow\" and \"pixelbounds\" are given", "one of them");
           const std::vector<double> w = p.reals("cropwindow");
           film->crop = cropOf(*film, w[0], w[1], w[2], w[3]);
           if (film->crop.x0 >= film->crop.x1 || film->crop.y0 >= film->crop.y1)
             p.fail("cropwindow", "the window contains no pixel");
         }
         film->fileName = p.string("filename");
         film->diagonal = p.real("diagonal") / 1000;
         film->imagingRatio = static_cast<float>(p.real("exposuretime") * p.real("iso") / 100);
         if (!std::isnormal(film->imagingRatio))
           p.fail("iso", "exposuretime iso / 100 is too large or too small for single precision",
                  "a product from 1e-37 to 1e38");
         return film;
       }});
  PlugIn<FilmSettings, NoContext> layered = *plugIns.films.find("rgb");
  layered.name = "gbuffer";
  layered.summary =
      "As rgb; .exr files also get the layers albedo, normal, geonormal, depth and position of --layers.";
  layered.parameters.push_back(
      ignoredParameter(ParameterType::STRING, "coordinatesystem", "the layers are always in world space"));
  layered.make = [make = layered.make](const Parameters& p, const NoContext& none) {
    p.warn("", "the layers of a \"gbuffer\" film have the names of --layers, and are in world space");
    auto film = make(p, none);
    if (film) film->layered = true;
    return film;
  };
  plugIns.films.add(layered);
}

void registerAccelerators(PlugIns& plugIns) {
  const auto add = [&](const char* name, const std::vector<ParameterSpec>& parameters) {
    plugIns.accelerators.add(
        {{.name = name,
          .summary = "Ignored: Embree builds the acceleration structure.",
          .parameters = parameters,
          .examples = {""}},
         [](const Parameters&, const NoContext&) { return std::make_unique<AcceleratorSettings>(); }});
  };
  const std::string why = "Embree builds the acceleration structure";
  add("bvh", {ignoredParameter(ParameterType::INTEGER, "maxnodeprims", why),
              ignoredParameter(ParameterType::STRING, "splitmethod", why)});
  add("kdtree", {ignoredParameter(ParameterType::INTEGER, "intersectcost", why),
                 ignoredParameter(ParameterType::INTEGER, "traversalcost", why),
                 ignoredParameter(ParameterType::REAL, "emptybonus", why),
                 ignoredParameter(ParameterType::INTEGER, "maxprims", why),
                 ignoredParameter(ParameterType::INTEGER, "maxdepth", why)});
}

} // namespace recurse
