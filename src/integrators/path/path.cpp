/** @file
 * Parameters of `path`, and of integrators in pbrt files that `path` renders.
 */
#include "integrators/path/pathTracing.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/integrator/maxDepthParameter.h"

namespace recurse {

void registerPath(PlugIns& plugIns) {
  static const std::string SAME_PICTURE =
      "the picture converges to the same; effects that are hard to sample converge at another rate";
  const auto add = [&](const char* name, const char* summary, std::vector<ParameterSpec> more) {
    more.insert(
        more.begin(),
        {maxDepthParameter(),
         integerParameter("lightsamples", "1", "shadow rays at each diffuse vertex").range(1, 1e6),
         booleanParameter(
             "guided", "false",
             "path guiding: learn the directions of incident light, on surfaces and in media, and sample "
             "them as well; helps where light enters through small openings")});
    plugIns.integrators.add(
        {{.name = name,
          .summary = summary,
          .parameters = std::move(more),
          .examples = std::string(name) == "path" ? std::vector<std::string>{"", "\"bool guided\" true"}
                                                  : std::vector<std::string>{""}},
         [isOther = std::string(name) != "path"](const Parameters& p, const NoContext&) {
           if (isOther) p.warn("", "\"" + p.plugInName() + "\" is rendered by \"path\": " + SAME_PICTURE);
           return makePathTracing({p.integer("maxdepth"), p.integer("lightsamples")}, nullptr,
                                  p.boolean("guided"));
         }});
  };
  const char* other = "another name of path: the same picture by another estimator";
  const auto real = [](const char* n) {
    return ignoredParameter(ParameterType::REAL, n, "path does not need it");
  };
  const auto integer = [](const char* n) {
    return ignoredParameter(ParameterType::INTEGER, n, "path does not need it");
  };
  const auto boolean = [](const char* n) {
    return ignoredParameter(ParameterType::BOOLEAN, n, "path does not need it");
  };
  const ParameterSpec lights = ignoredParameter(ParameterType::STRING, "lightsampler",
                                                "photons always train the choice of lights by position");
  add("path", "Unbiased path tracing with shadow rays and multiple importance sampling.",
      {real("rrthreshold"), boolean("regularize"), lights});
  add("volpath", other, {real("rrthreshold"), boolean("regularize"), lights});
  add("randomwalk", other, {});
  add("simplevolpath", other, {});
  add("mlt", other,
      {integer("bootstrapsamples"), integer("chains"), integer("mutationsperpixel"),
       real("largestepprobability"), real("sigma"), boolean("regularize")});
}

} // namespace recurse
