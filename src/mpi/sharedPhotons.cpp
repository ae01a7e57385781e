/** @file
 * Distribution of batches of photons to all ranks, and their exchange.
 */
#include "mpi/sharedPhotons.h"

#include <algorithm>
#include <chrono>

#include <mpi.h>

#include "recurse/core/threads/processorTime.h"

namespace recurse::apps {

namespace {

/** Reciprocal of the fraction of batches that measures the speed of ranks. */
constexpr size_t TRIAL_PART = 10;

/** First batch of each rank in [first, end), in proportion to `speeds`; `end` follows. */
std::vector<size_t> dealt(size_t first, size_t end, const std::vector<double>& speeds) {
  double all = 0, before = 0;
  for (const double s : speeds) all += s;
  std::vector<size_t> out{first};
  for (const double s : speeds) {
    before += s;
    out.push_back(std::clamp(first + size_t(double(end - first) * (before / all) + 0.5), out.back(), end));
  }
  out.back() = end;
  return out;
}

/** Sends bytes from rank `root` to all ranks. */
void broadcast(std::vector<std::byte>& bytes, int root) {
  constexpr size_t PIECE = size_t(1) << 30; // MPI counts have 31 bits
  for (size_t at = 0; at < bytes.size(); at += PIECE)
    MPI_Bcast(bytes.data() + at, static_cast<int>(std::min(PIECE, bytes.size() - at)), MPI_BYTE, root,
              MPI_COMM_WORLD);
}

} // namespace

bool SharedPhotons::share(size_t count, const std::function<void(size_t first, size_t end)>& shoot,
                          const std::function<std::vector<std::byte>(size_t batch)>& shot,
                          const std::function<void(size_t batch, std::span<const std::byte>)>& use) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const auto self = size_t(rank), all = size_t(ranks);
  const auto shootOwn = [&](const std::vector<size_t>& begins) {
    if (begins[self] < begins[self + 1]) shoot(begins[self], begins[self + 1]);
  };

  const auto start = std::chrono::steady_clock::now();
  const size_t trial = std::min(count, std::max(count / TRIAL_PART, all));
  const std::vector<size_t> firstPart = dealt(0, trial, std::vector<double>(all, 1));
  shootOwn(firstPart);
  const double seconds = secondsSince(start);
  const double speed = double(firstPart[self + 1] - firstPart[self]) / std::max(seconds, 1e-6);
  std::vector<double> speeds(all);
  MPI_Allgather(&speed, 1, MPI_DOUBLE, speeds.data(), 1, MPI_DOUBLE, MPI_COMM_WORLD);
  const std::vector<size_t> secondPart = dealt(trial, count, speeds);
  shootOwn(secondPart);

  int stopped = stop;
  MPI_Allreduce(MPI_IN_PLACE, &stopped, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (stopped) {
    stop = true;
    return false;
  }
  for (size_t root = 0; root < all; ++root)
    for (const std::vector<size_t>& part : {firstPart, secondPart}) {
      const size_t first = part[root], end = part[root + 1];
      std::vector<uint64_t> sizes(end - first);
      std::vector<std::byte> bytes;
      if (root == self)
        for (size_t b = first; b < end; ++b) {
          const std::vector<std::byte> batch = shot(b);
          sizes[b - first] = batch.size();
          bytes.insert(bytes.end(), batch.begin(), batch.end());
        }
      MPI_Bcast(sizes.data(), static_cast<int>(sizes.size()), MPI_UINT64_T, int(root), MPI_COMM_WORLD);
      size_t sum = 0;
      for (const uint64_t size : sizes) sum += size;
      bytes.resize(sum);
      broadcast(bytes, int(root));
      if (root == self) continue;
      size_t at = 0;
      for (size_t b = first; b < end; ++b) {
        use(b, std::span(bytes).subspan(at, sizes[b - first]));
        at += sizes[b - first];
      }
    }
  return true;
}

} // namespace recurse::apps
