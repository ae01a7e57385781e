/** @file
 * Photons of a pass, shared by all ranks.
 */
#pragma once

#include <atomic>

#include "recurse/transport/integrator/integrator.h"

namespace recurse::apps {

/** Distributes the photons of a pass to all ranks, which must take part at the same time: a tenth in equal
 * numbers, the remaining ones in proportion to the ranks' speeds. */
class SharedPhotons final : public PhotonSharing {
 public:
  /** `stop`: stop flag of this rank; becomes true if it is true at any rank. */
  explicit SharedPhotons(std::atomic<bool>& stop) : stop(stop) {}
  bool share(size_t count, const std::function<void(size_t first, size_t end)>& shoot,
             const std::function<std::vector<std::byte>(size_t batch)>& shot,
             const std::function<void(size_t batch, std::span<const std::byte>)>& use) override;

 private:
  std::atomic<bool>& stop;
};

} // namespace recurse::apps
