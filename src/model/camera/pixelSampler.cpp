/** @file
 * Parameters of samplers.
 */
#include "recurse/model/camera/pixelSampler.h"

namespace recurse {

ParameterSpec samplerSeedParameter() {
  return integerParameter("seed", "0",
                          "seed of the random numbers; another seed gives an independent picture")
      .range(0, 2147483647);
}

std::vector<ParameterSpec> pixelSamplerParameters(std::vector<ParameterSpec> more) {
  more.push_back(integerParameter("pixelsamples", "16", "samples a pixel").range(1, 1 << 30));
  more.push_back(samplerSeedParameter());
  return more;
}

std::unique_ptr<PixelSampler> withPixelSamples(std::unique_ptr<PixelSampler> sampler, const Parameters& p) {
  sampler->pixelSamples = p.integer("pixelsamples");
  sampler->seed = static_cast<uint64_t>(p.integer("seed"));
  return sampler;
}

} // namespace recurse
