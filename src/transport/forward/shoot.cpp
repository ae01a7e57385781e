/** @file
 * Photon tracing in batches, and the exchange of photons between processes.
 */
#include "transport/forward/shoot.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <span>
#include <type_traits>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/resources.h"
#include "transport/forward/photonWalk.h"

namespace recurse {

namespace {

/** Sampler stream of photons, distinct from the streams of pixels. */
constexpr uint64_t PHOTON_STREAM = 0x50484f544f4e53ull;

template <class T> void appendBytes(const std::vector<T>& values, std::vector<std::byte>& out) {
  static_assert(std::is_trivially_copyable_v<T>);
  const uint64_t count = values.size();
  for (const auto& bytes : {std::as_bytes(std::span(&count, 1)), std::as_bytes(std::span(values))})
    out.insert(out.end(), bytes.begin(), bytes.end());
}

template <class T> void readBytes(std::span<const std::byte>& bytes, std::vector<T>& values) {
  uint64_t count = 0;
  std::memcpy(&count, bytes.data(), sizeof count);
  values.resize(count);
  const auto valueBytes = bytes.subspan(sizeof count, count * sizeof(T));
  if (!valueBytes.empty())
    std::memcpy(static_cast<void*>(values.data()), valueBytes.data(), valueBytes.size());
  bytes = bytes.subspan(sizeof count + valueBytes.size());
}

/** Serialises the photons of a batch for a different process. */
std::vector<std::byte> packed(StoredPhotons& stored) {
  std::vector<std::byte> out;
  std::apply([&](const auto&... lists) { (appendBytes(lists, out), ...); }, stored.lists());
  return out;
}

void unpack(std::span<const std::byte> bytes, StoredPhotons& stored) {
  std::apply([&](auto&... lists) { (readBytes(bytes, lists), ...); }, stored.lists());
}

/** Appends a batch, which becomes empty. */
void moveTo(StoredPhotons& all, StoredPhotons& batch) {
  const auto append = [](auto& list, const auto& more) { list.insert(list.end(), more.begin(), more.end()); };
  std::apply([&](auto&... to) { std::apply([&](auto&... from) { (append(to, from), ...); }, batch.lists()); },
             all.lists());
  batch = {};
}

/** Photons of a batch, and their counts. */
struct ShotBatch {
  StoredPhotons photons;
  TransportCounts counts;
  std::vector<RecordedLightVertex> record; ///< empty if nothing is recorded
};

/** Joins the batches of a pass in the order of emission. */
void join(std::vector<ShotBatch>& batches, LightPathRecorder* recorder, ShotPhotons& shot) {
  size_t total = 0;
  for (const ShotBatch& batch : batches) total += batch.photons.onSurfaces.size();
  shot.onSurfaces.reserve(total);
  for (ShotBatch& batch : batches) {
    if (recorder) recorder->append(batch.record);
    moveTo(shot, batch.photons);
    shot.counts.add(batch.counts);
  }
}

} // namespace

double photonMapBytes(double stored) { return 2 * sizeof(Photon) * stored; }

ShotPhotons shootPhotons(const Scene& scene, const PathClasses& classes, const Pass& pass,
                         const ShootSettings& settings, const ForwardControl& control) {
  ShotPhotons shot;
  const EmissiveMedia* media = settings.emission.media;
  const bool dark = scene.lights().size() == 0 && !(media && !media->empty());
  if (dark || settings.photons == 0) return shot;
  std::vector<ShotBatch> batches((settings.photons + PHOTON_BATCH - 1) / PHOTON_BATCH);
  LightPathRecorder* const recorder = settings.lightPaths;
  if (recorder) recorder->beginPass(settings.photons);
  const auto firstPhoton = [&](size_t batch) { return std::min(settings.photons, batch * PHOTON_BATCH); };
  std::atomic<size_t> done{0};
  std::mutex reporting;
  const auto shootBatch = [&](size_t b) {
    if (control.stopped()) return;
    PhotonWalk walk(scene, classes, settings, batches[b].counts, batches[b].photons);
    for (uint64_t i = firstPhoton(b); i < firstPhoton(b + 1); ++i) {
      walk.record = recorder && recorder->isRecorded(i) ? &batches[b].record : nullptr;
      walk.shoot(lightPathSampler(pass, i, PHOTON_STREAM), pass.time);
    }
    const size_t n = ++done;
    if (const std::unique_lock lock(reporting, std::try_to_lock); lock)
      control.progress(static_cast<double>(n) / static_cast<double>(batches.size()));
  };
  size_t onSurfaces = 0;
  const auto shootBatches = [&](size_t first, size_t end) {
    parallelFor(end - first, [&](size_t i) { shootBatch(first + i); });
    for (size_t b = first; b < end; ++b) {
      onSurfaces += batches[b].photons.onSurfaces.size();
      shot.storedHere += batches[b].photons.size();
    }
    shot.emittedHere += firstPhoton(end) - firstPhoton(first);
    const double expected = double(onSurfaces) * double(settings.photons) / double(shot.emittedHere);
    requireMemory(formatted("a map of %.3g photons", expected), photonMapBytes(expected));
  };
  if (control.sharing && batches.size() > FIRST_BATCHES) {
    const bool isComplete = control.sharing->share(
        batches.size(), shootBatches, [&](size_t b) { return packed(batches[b].photons); },
        [&](size_t b, std::span<const std::byte> bytes) { unpack(bytes, batches[b].photons); });
    if (!isComplete) return shot;
  } else {
    // The first batches predict the number of photons stored in total, which must fit into memory.
    const size_t first = std::min(batches.size(), FIRST_BATCHES);
    shootBatches(0, first);
    if (first < batches.size()) shootBatches(first, batches.size());
  }
  join(batches, recorder, shot);
  shot.emitted = settings.photons;
  return shot;
}

} // namespace recurse
