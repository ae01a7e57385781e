/** @file
 * Every registry of plug-ins in the order of the reference page.
 */
#pragma once

#include "recurse/model/scene/plugIns.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse::apps {

/** Calls visit(registry) for every registry, in the order of the reference page. */
template <class Visitor> void forEachRegistry(const Visitor& visit) {
  const PlugIns& all = plugIns();
  visit(all.films);
  visit(all.cameras);
  visit(all.filters);
  visit(all.samplers);
  visit(all.integrators);
  visit(all.accelerators);
  visit(all.shapes);
  visit(all.imports);
  visit(all.materials);
  visit(all.textures);
  visit(all.lights);
  visit(all.areaLights);
  visit(all.media);
  visit(all.phaseFunctions);
  visit(all.toneMaps);
}

} // namespace recurse::apps
