/** @file
 * Units of work add up to the same bits if several renderers render them in any order, with interruptions and
 * reassignment.
 */
#include "transport/rendering.h"

#include <cstring>
#include <random>
#include <thread>

#include "render/unitRenderer.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

const std::string BOX =
    "LookAt 0 1 3  0 0.5 0  0 1 0\nCamera \"perspective\" \"float fov\" 50\n"
    "Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 24\nWorldBegin\n"
    "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 4 4 4 ]\n"
    "Shape \"sphere\" \"float radius\" .3\nAttributeEnd\n"
    "Material \"diffuse\"\nShape \"bilinearmesh\" \"point3 P\" [ -2 -1 -2  2 -1 -2  -2 -1 2  2 -1 2 ]\n";

/** Whether the films have the same bits except for the numbers that only one process needs. */
bool sameSamples(Film& a, Film& b) {
  const auto s = a.state(), t = b.state();
  for (size_t i = 0; i < std::max<size_t>(2, s.size() - 1); ++i)
    if (s[i].size() != t[i].size() || std::memcmp(s[i].data(), t[i].data(), s[i].size()) != 0) return false;
  return s.size() == t.size();
}

} // namespace

TEST(UnitRenderer, AnySharesAddUpToTheSameBits) {
  const auto scene = sceneFrom(BOX);
  const int samplesPerPixel = recurse::testing::samples(64);
  for (const auto& [name, parameters] : std::vector<std::pair<std::string, std::string>>{
           {"path", ""}, {"sppm", "\"integer photonsperiteration\" 500"}, {"bdpt", ""}}) {
    Rendered truth = renderScene(*scene, name, parameters, samplesPerPixel);
    const PathClasses classes;
    RenderSettings settings;
    settings.samplesPerPixel = samplesPerPixel;
    settings.seed = 1;
    const ThreadPool pool(0);
    Film sum(scene->film().crop, 1);
    std::mt19937 random(4);
    std::optional<WorkQueue> queue;
    // Each renderer is stopped after a while, and others continue its units.
    for (bool last = false; !last;) {
      std::vector<std::unique_ptr<Integrator>> integrators;
      std::vector<std::unique_ptr<UnitRenderer>> renderers;
      for (int i = 0; i < 2; ++i) {
        integrators.push_back(integratorFrom(name, parameters));
        renderers.push_back(
            std::make_unique<UnitRenderer>(*scene, *integrators.back(), classes, settings, nullptr));
      }
      const SampleRenderer& whole = renderers[0]->samples();
      if (!queue) queue.emplace(whole.samples(), int64_t(whole.tiles()), whole.passes());
      const int units = int(random() % 12) + 4;
      for (int i = 0; i < units; ++i)
        if (const auto unit = queue->take(double(random() % 40), 2)) renderers[random() % 2]->add(i, *unit);
      last = queue->empty();
      if (!last) std::this_thread::sleep_for(std::chrono::microseconds(random() % 20000));
      for (const auto& r : renderers) {
        if (!last) r->stop();
        Film part = r->emptyFilm();
        if (part.splats()) sum.enableSplats(part.splats()->unit());
        r->takeFilm(part);
        while (!r->idle()) std::this_thread::yield();
        const UnitRenderer::Events events = r->events();
        ASSERT_TRUE(events.filmTaken && !events.failure);
        for (const UnitRenderer::Done& d : events.done)
          for (const WorkUnit& left : d.left) queue->giveBack(left);
        sum.add(part);
      }
    }
    EXPECT_TRUE(sameSamples(sum, truth.film)) << name;
  }
}
