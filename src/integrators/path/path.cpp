/** @file
 * Parameters of `path`, and of integrators in pbrt files that `path` renders.
 */
#include "integrators/path/pathTracing.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

void registerPath(PlugIns& plugIns) {
  static const std::string SAME_PICTURE = "the picture is the same in the end, what is hard to find is not";
  const auto add = [&](const char* name, const char* summary, std::vector<ParameterSpec> more) {
    more.insert(
        more.begin(),
        {integerParameter("maxdepth", "-1", "most scattering events of a path; -1: no limit").range(-1, 1e9),
         integerParameter("lightsamples", "1", "shadow rays at each diffuse vertex").range(1, 1e6),
         booleanParameter("guided", "false",
                          "learn from which directions light arrives, and send paths there, too: gains where "
                          "light comes by small openings")});
    plugIns.integrators.add(
        {{.name = name,
          .summary = summary,
          .parameters = std::move(more),
          .examples = std::string(name) == "path" ? std::vector<std::string>{"", "\"bool guided\" true"}
                                                  : std::vector<std::string>{""}},
         [isOther = std::string(name) != "path"](const Parameters& p, const NoContext&) {
           if (isOther) p.warn("", "\"" + p.plugInName() + "\" is rendered by \"path\": " + SAME_PICTURE);
           return makePathTracing({p.integer("maxdepth"), p.integer("lightsamples")}, nullptr, nullptr,
                                  p.boolean("guided"));
         }});
  };
  const char* other = "another name of path: the picture is the same, the way there is not";
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
                                                "lights are chosen by what photons tell of each place");
  add("path", "The unbiased path tracer with shadow rays and multiple importance sampling.",
      {real("rrthreshold"), boolean("regularize"), lights});
  add("volpath", other, {real("rrthreshold"), boolean("regularize"), lights});
  add("randomwalk", other, {});
  add("simplevolpath", other, {});
  add("mlt", other,
      {integer("bootstrapsamples"), integer("chains"), integer("mutationsperpixel"),
       real("largestepprobability"), real("sigma"), boolean("regularize")});
}

} // namespace recurse
