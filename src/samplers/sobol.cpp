/** @file
 * Owen-scrambled Sobol' points, padded: a sequence of its own for each pair of dimensions and each pixel.
 */
#include "recurse/model/camera/pixelSampler.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class SobolSampler final : public PixelSampler {
 public:
  SobolSampler() : PixelSampler(false) {}
  uint32_t strata(uint32_t, uint32_t samples) const override { return largestPowerDividing(samples, 2); }
};

const char* const SUMMARY = "Owen-scrambled Sobol' points: each pixel and each pair of dimensions has a "
                            "(0,2)-sequence of its own (Burley 2020).";

} // namespace

void registerSobolSampler(PlugIns& plugIns) {
  const auto add = [&](const char* name, const std::string& summary, const char* warning,
                       std::vector<ParameterSpec> more) {
    plugIns.samplers.add({{.name = name,
                           .summary = summary,
                           .parameters = pixelSamplerParameters(std::move(more)),
                           .examples = {""}},
                          [warning](const Parameters& p, const NoContext&) {
                            if (warning) p.warn("", warning);
                            return withPixelSamples(std::make_unique<SobolSampler>(), p);
                          }});
  };
  const ParameterSpec randomization =
      ignoredParameter(ParameterType::STRING, "randomization", "always Owen scrambling");
  add("sobol", std::string(SUMMARY) + " The default.", nullptr, {randomization});
  add("paddedsobol", "The same as sobol.", nullptr, {randomization});
  add("pmj02bn", "The same as sobol, with a warning.",
      "\"pmj02bn\" is not available: samples are Owen-scrambled Sobol' points, as with \"sobol\"", {});
}

} // namespace recurse
