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
/** Number of initial batches: enough to occupy all threads and to predict the number of stored photons. */
constexpr size_t FIRST_BATCHES = 64;

template <class T> void appendBytes(const std::vector<T>& values, std::vector<std::byte>& out) {
  static_assert(std::is_trivially_copyable_v<T>);
  const uint64_t count = values.size();
  for (const auto& part : {std::as_bytes(std::span(&count, 1)), std::as_bytes(std::span(values))})
    out.insert(out.end(), part.begin(), part.end());
}

template <class T> void readBytes(std::span<const std::byte>& bytes, std::vector<T>& values) {
  uint64_t count = 0;
  std::memcpy(&count, bytes.data(), sizeof count);
  values.resize(count);
  const auto own = bytes.subspan(sizeof count, count * sizeof(T));
  if (!own.empty()) std::memcpy(static_cast<void*>(values.data()), own.data(), own.size());
  bytes = bytes.subspan(sizeof count + own.size());
}

/** Serialises the photons of a batch for a different process. */
std::vector<std::byte> packed(const StoredPhotons& stored) {
  std::vector<std::byte> out;
  appendBytes(stored.onSurfaces, out);
  appendBytes(stored.inMedia, out);
  appendBytes(stored.beams, out);
  appendBytes(stored.lengths.onSurfaces, out);
  appendBytes(stored.lengths.inMedia, out);
  appendBytes(stored.lengths.beams, out);
  return out;
}

void unpack(std::span<const std::byte> bytes, StoredPhotons& stored) {
  readBytes(bytes, stored.onSurfaces);
  readBytes(bytes, stored.inMedia);
  readBytes(bytes, stored.beams);
  readBytes(bytes, stored.lengths.onSurfaces);
  readBytes(bytes, stored.lengths.inMedia);
  readBytes(bytes, stored.lengths.beams);
}

template <class T> void moveTo(std::vector<T>& all, std::vector<T>& part) {
  all.insert(all.end(), part.begin(), part.end());
  std::vector<T>().swap(part);
}

} // namespace

double photonMapBytes(double stored) { return 2 * sizeof(Photon) * stored; }

ShotPhotons shootPhotons(const Scene& scene, const PathClasses& classes, const Pass& pass,
                         const ShootSettings& settings, const ForwardControl& control) {
  ShotPhotons shot;
  const EmissiveMedia* media = settings.emission.media;
  const bool dark = scene.lights().size() == 0 && !(media && !media->empty());
  if (dark || settings.photons == 0) return shot;
  const size_t batches = (settings.photons + PHOTON_BATCH - 1) / PHOTON_BATCH;
  std::vector<StoredPhotons> stored(batches);
  std::vector<TransportCounts> counts(batches);
  LightPathRecorder* const recorder = settings.lightPaths;
  std::vector<std::vector<RecordedLightVertex>> records(recorder ? batches : 0);
  if (recorder) recorder->beginPass(settings.photons);
  std::atomic<size_t> done{0};
  std::mutex telling;
  const auto shootBatch = [&](size_t b) {
    if (control.stopped()) return;
    PhotonWalk walk(scene, classes, settings, counts[b], stored[b]);
    const uint64_t end = std::min(settings.photons, (b + 1) * PHOTON_BATCH);
    for (uint64_t i = b * PHOTON_BATCH; i < end; ++i) {
      walk.record = recorder && recorder->isRecorded(i) ? &records[b] : nullptr;
      walk.shoot(
          Sampler(hashCombine(pass.seed, pass.index), PHOTON_STREAM + (i >> 32), static_cast<uint32_t>(i)),
          pass.time);
    }
    const size_t n = ++done;
    if (telling.try_lock()) {
      control.progress(static_cast<double>(n) / static_cast<double>(batches));
      telling.unlock();
    }
  };
  size_t total = 0;
  const auto shootBatches = [&](size_t first, size_t end) {
    parallelFor(end - first, [&](size_t i) { shootBatch(first + i); });
    for (size_t b = first; b < end; ++b) {
      total += stored[b].onSurfaces.size();
      shot.storedHere += stored[b].size();
    }
    shot.emittedHere +=
        std::min(settings.photons, end * PHOTON_BATCH) - std::min(settings.photons, first * PHOTON_BATCH);
    const double expected = double(total) * double(settings.photons) / double(shot.emittedHere);
    requireMemory(formatted("a map of %.3g photons", expected), photonMapBytes(expected));
  };
  if (control.sharing && batches > FIRST_BATCHES) {
    const bool isComplete = control.sharing->share(
        batches, shootBatches, [&](size_t b) { return packed(stored[b]); },
        [&](size_t b, std::span<const std::byte> bytes) { unpack(bytes, stored[b]); });
    if (!isComplete) return shot;
  } else {
    // The first batches predict the number of photons stored in total, which must fit into memory.
    const size_t first = std::min(batches, FIRST_BATCHES);
    shootBatches(0, first);
    if (first < batches) shootBatches(first, batches);
  }
  for (const auto& record : records) recorder->append(record);
  total = 0;
  for (const StoredPhotons& s : stored) total += s.onSurfaces.size();
  shot.stored.reserve(total);
  for (StoredPhotons& s : stored) {
    moveTo(shot.stored, s.onSurfaces);
    moveTo(shot.inMedia, s.inMedia);
    moveTo(shot.beams, s.beams);
    moveTo(shot.lengths.onSurfaces, s.lengths.onSurfaces);
    moveTo(shot.lengths.inMedia, s.lengths.inMedia);
    moveTo(shot.lengths.beams, s.lengths.beams);
  }
  for (const TransportCounts& c : counts) shot.counts.add(c);
  shot.emitted = settings.photons;
  return shot;
}

} // namespace recurse
