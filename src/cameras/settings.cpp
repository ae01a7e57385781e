/** @file
 * The directives that only set numbers: Film, Sampler and Accelerator.
 */
#include "recurse/model/plugIns.h"

namespace recurse {

void registerRgbFilm(PlugIns& plugIns) {
  plugIns.films.add(
      {{.name = "rgb",
        .summary = "Linear Rec. 709 pixels.",
        .parameters =
            {integerParameter("xresolution", "1280", "width [pixels]").range(1, 65536),
             integerParameter("yresolution", "720", "height [pixels]").range(1, 65536),
             arrayParameter(ParameterType::REAL, "cropwindow", 4, "",
                            "x0 x1 y0 y1: the part that is rendered, of the whole")
                 .range(0, 1),
             arrayParameter(ParameterType::INTEGER, "pixelbounds", 4, "",
                            "x0 x1 y0 y1: the part that is rendered [pixels]"),
             stringParameter("filename", "recurse.exr",
                             "the picture's file, unless the command line names one"),
             realParameter("iso", "100", "sensitivity; the picture is scaled by exposuretime iso / 100")
                 .positive(),
             realParameter("exposuretime", "1", "[s]").positive(),
             ignoredParameter(ParameterType::REAL, "diagonal",
                              "only lens simulations need the size of the film"),
             ignoredParameter(ParameterType::BOOLEAN, "savefp16", "pictures are written with full floats"),
             realParameter("whitebalance", "0", "colour temperature to adapt to; only 0, none, is taken")
                 .range(0, 0),
             stringParameter("sensor", "cie1931", "response; the matching functions only").oneOf({"cie1931"}),
             realParameter("maxcomponentvalue", "", "not taken: it would clamp radiance")},
        .examples = {"\"integer xresolution\" 64 \"integer yresolution\" 48"}},
       [](const Parameters& p, const NoContext&) {
         if (p.has("maxcomponentvalue"))
           p.fail("maxcomponentvalue", "clamping is not supported: it would darken the picture");
         auto film = std::make_unique<FilmSettings>();
         film->width = p.integer("xresolution");
         film->height = p.integer("yresolution");
         film->crop = {0, 0, film->width, film->height};
         if (p.has("pixelbounds")) {
           const std::vector<int> b = p.integers("pixelbounds");
           film->crop = {b[0], b[2], b[1], b[3]};
           if (b[0] < 0 || b[2] < 0 || b[1] > film->width || b[3] > film->height || b[0] >= b[1] ||
               b[2] >= b[3])
             p.fail("pixelbounds", "the part is empty or not inside the film",
                    "0 <= x0 < x1 <= " + std::to_string(film->width) +
                        " and 0 <= y0 < y1 <= " + std::to_string(film->height));
         }
         if (p.has("cropwindow")) {
           if (p.has("pixelbounds"))
             p.fail("cropwindow", "both \"cropwindow\" and \"pixelbounds\" are given", "either of the two");
           const std::vector<double> w = p.reals("cropwindow");
           film->crop = cropOf(*film, w[0], w[1], w[2], w[3]);
           if (film->crop.x0 >= film->crop.x1 || film->crop.y0 >= film->crop.y1)
             p.fail("cropwindow", "no pixel lies in the window");
         }
         film->fileName = p.string("filename");
         film->imagingRatio = static_cast<float>(p.real("exposuretime") * p.real("iso") / 100);
         return film;
       }});
}

void registerSamplers(PlugIns& plugIns) {
  const auto add = [&](const char* name, std::vector<ParameterSpec> more) {
    const bool grid = std::string(name) == "stratified";
    if (!grid) more.push_back(integerParameter("pixelsamples", "16", "samples a pixel").range(1, 1 << 30));
    more.push_back(integerParameter("seed", "0", "another seed gives another, independent picture")
                       .range(0, 2147483647));
    plugIns.samplers.add(
        {{.name = name,
          .summary =
              "Sets the number of samples and the seed; Recurse always draws Owen-scrambled Sobol' points.",
          .parameters = std::move(more),
          .examples = {""}},
         [grid](const Parameters& p, const NoContext&) {
           auto s = std::make_unique<SamplerSettings>();
           const int64_t n =
               grid ? int64_t(p.integer("xsamples")) * p.integer("ysamples") : p.integer("pixelsamples");
           if (n > (1 << 30)) p.fail("xsamples", "too many samples a pixel");
           s->pixelSamples = static_cast<int>(n);
           s->seed = static_cast<uint64_t>(p.integer("seed"));
           return s;
         }});
  };
  for (const char* name : {"sobol", "paddedsobol", "zsobol", "halton"})
    add(name, {ignoredParameter(ParameterType::STRING, "randomization", "always Owen scrambling")});
  for (const char* name : {"independent", "pmj02bn"}) add(name, {});
  add("stratified", {integerParameter("xsamples", "4", "samples along x").range(1, 32768),
                     integerParameter("ysamples", "4", "samples along y").range(1, 32768),
                     ignoredParameter(ParameterType::BOOLEAN, "jitter", "always jittered")});
}

void registerAccelerators(PlugIns& plugIns) {
  const auto add = [&](const char* name, const std::vector<ParameterSpec>& parameters) {
    plugIns.accelerators.add(
        {{.name = name,
          .summary = "Without effect: Embree builds the tree.",
          .parameters = parameters,
          .examples = {""}},
         [](const Parameters&, const NoContext&) { return std::make_unique<AcceleratorSettings>(); }});
  };
  const std::string why = "Embree builds the tree";
  add("bvh", {ignoredParameter(ParameterType::INTEGER, "maxnodeprims", why),
              ignoredParameter(ParameterType::STRING, "splitmethod", why)});
  add("kdtree", {ignoredParameter(ParameterType::INTEGER, "intersectcost", why),
                 ignoredParameter(ParameterType::INTEGER, "traversalcost", why),
                 ignoredParameter(ParameterType::REAL, "emptybonus", why),
                 ignoredParameter(ParameterType::INTEGER, "maxprims", why),
                 ignoredParameter(ParameterType::INTEGER, "maxdepth", why)});
}

} // namespace recurse
