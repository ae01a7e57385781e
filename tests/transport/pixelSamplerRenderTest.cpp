/** @file
 * Renders by every registered sampler: the same bits for any number of threads, crop and division of the
 * samples, and the same picture.
 */
#include "transport/rendering.h"

#include <cstring>

using namespace recurse;
using namespace recurse::testing;

namespace {

std::string cornerSampledBy(const std::string& sampler, const std::string& film = "") {
  std::string text = litCorner(24);
  const std::string resolution = "\"integer xresolution\" 24";
  text.insert(text.find(resolution), film + " ");
  return "Sampler \"" + sampler + "\"\n" + text;
}

bool sameBits(Film& a, Film& b) {
  const auto s = a.state(), t = b.state();
  for (size_t i = 0; i < s.size(); ++i)
    if (s[i].size() != t[i].size() || std::memcmp(s[i].data(), t[i].data(), s[i].size()) != 0) return false;
  return s.size() == t.size();
}

Film samplesFromTo(const Scene& scene, int64_t first, int64_t end) {
  const auto integrator = integratorFrom("path", "");
  Film film(scene.film().crop, 1);
  RenderSettings settings;
  settings.samplesPerPixel = 16;
  settings.seed = 1;
  settings.firstSample = first;
  settings.endSample = end;
  const std::atomic<bool> stop{false};
  render(scene, *integrator, PathClasses(), settings, film, stop, nullptr, nullptr);
  return film;
}

} // namespace

TEST(PixelSamplerRenders, HaveTheSameBitsForThreadsCropsAndParts) {
  for (const std::string& name : plugIns().samplers.names()) {
    const auto scene = sceneFrom(cornerSampledBy(name));
    Rendered one = renderScene(*scene, "path", "", 16, 1, 1),
             three = renderScene(*scene, "path", "", 16, 1, 3);
    EXPECT_TRUE(sameBits(one.film, three.film)) << name;
    Film parts = samplesFromTo(*scene, 0, 5);
    parts.add(samplesFromTo(*scene, 5, 16));
    EXPECT_TRUE(sameBits(one.film, parts)) << name;
    const auto crop = sceneFrom(cornerSampledBy(name, "\"integer pixelbounds\" [ 7 19 5 16 ]"));
    const Rendered part = renderScene(*crop, "path", "", 16, 1, 2);
    for (int y = 5; y < 16; ++y)
      for (int x = 7; x < 19; ++x)
        ASSERT_EQ(part.value(size_t(y - 5) * 12 + size_t(x - 7)), one.value(size_t(y) * 24 + size_t(x)))
            << name;
  }
}

TEST(PixelSamplerRenders, AgreeAndDiffer) {
  const Rendered truth = renderScene(*sceneFrom(litCorner(24)), "path", "", samples(1024), 7);
  std::vector<std::string> distinct;
  std::vector<Rgb> first;
  for (const std::string& name : plugIns().samplers.names()) {
    const Rendered r = renderScene(*sceneFrom(cornerSampledBy(name)), "path", "", 64);
    EXPECT_NEAR(r.mean(), truth.mean(), 5 * std::hypot(r.standardError(), truth.standardError())) << name;
    if (std::find(first.begin(), first.end(), r.value(300)) != first.end()) continue;
    first.push_back(r.value(300));
    distinct.push_back(name);
  }
  EXPECT_EQ(distinct, (std::vector<std::string>{"independent", "stratified", "halton", "sobol", "zsobol"}));
}
