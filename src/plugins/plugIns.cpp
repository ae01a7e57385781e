/** @file
 * Registries of plug-ins: filled from the list, and from a second one that RECURSE_MORE_PLUG_INS may name, of
 * plug-ins that are compiled with a program and not with the library.
 */
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/scene/importExpansion.h"
#include "recurse/model/scene/surfaceParameters.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

#define RECURSE_PLUG_IN(Name) void register##Name(PlugIns&);
#include "plugins/list.h"
#ifdef RECURSE_MORE_PLUG_INS
#include RECURSE_MORE_PLUG_INS
#endif
#undef RECURSE_PLUG_IN

const PlugIns& plugIns() {
  static const PlugIns ALL = [] {
    PlugIns all;
#define RECURSE_PLUG_IN(Name) register##Name(all);
#include "plugins/list.h"
#ifdef RECURSE_MORE_PLUG_INS
#include RECURSE_MORE_PLUG_INS
#endif
#undef RECURSE_PLUG_IN
    addSurfaceParameters(all);
    addImportParameters(all);
    return all;
  }();
  return ALL;
}

} // namespace recurse
