/** @file
 * Makes the registries from the list.
 */
#include "recurse/model/plugIns.h"
#include "recurse/model/surfaceDetail.h"
#include "recurse/transport/integrator.h"

namespace recurse {

#define RECURSE_PLUG_IN(Name) void register##Name(PlugIns&);
#include "plugins/list.h"
#undef RECURSE_PLUG_IN

const PlugIns& plugIns() {
  static const PlugIns ALL = [] {
    PlugIns all;
#define RECURSE_PLUG_IN(Name) register##Name(all);
#include "plugins/list.h"
#undef RECURSE_PLUG_IN
    addSurfaceParameters(all);
    addImportParameters(all);
    return all;
  }();
  return ALL;
}

} // namespace recurse
