/** @file
 * Identity tone map.
 */
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class NoToneMap final : public ToneMap {
 public:
  void apply(Image&) const override {}
  bool isIdentity() const override { return true; }
};

} // namespace

void registerNoToneMap(PlugIns& plugIns) {
  plugIns.toneMaps.add({{.name = "none",
                         .summary = "Linear; values above white are clipped.",
                         .parameters = {},
                         .examples = {""}},
                        [](const Parameters&, const NoContext&) { return std::make_unique<NoToneMap>(); }});
}

} // namespace recurse
