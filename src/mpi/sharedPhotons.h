/** @file
 * Photons that all ranks shoot together.
 */
#pragma once

#include <atomic>

#include "recurse/transport/integrator/integrator.h"

namespace recurse::apps {

/** Deals out the photons of a pass to all ranks, who must be in it at the same time: a tenth of them in equal
 * parts, the rest by how fast each rank was. */
class SharedPhotons final : public PhotonSharing {
 public:
  /** `stop`: of this rank; becomes true where it is true at any. */
  explicit SharedPhotons(std::atomic<bool>& stop) : stop(stop) {}
  bool share(size_t count, const std::function<void(size_t first, size_t end)>& shoot,
             const std::function<std::vector<std::byte>(size_t batch)>& shot,
             const std::function<void(size_t batch, std::span<const std::byte>)>& use) override;

 private:
  std::atomic<bool>& stop;
};

} // namespace recurse::apps
