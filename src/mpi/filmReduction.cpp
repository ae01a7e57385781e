/** @file
 * Reduction of films by MPI.
 */
#include "mpi/filmReduction.h"

#include <algorithm>
#include <array>
#include <utility>

#include "mpi/messages.h"
#include "recurse/core/io/error.h"

namespace recurse::apps {

namespace {

/** Elements of a part in one message, so that received elements are added during the transfer of the next.
 * MPI counts have 31 bits. */
constexpr size_t CHUNK = 1 << 18;

// Functions by part, because MPI passes only the numbers to an operation.
constexpr size_t MAX_PARTS = 8;
std::array<Film::StatePart::Add, MAX_PARTS> adders{};
template <size_t PART> void addPart(void* from, void* into, int* count, MPI_Datatype*) {
  adders[PART](from, into, static_cast<size_t>(*count));
}
template <size_t... PARTS>
constexpr std::array<MPI_User_function*, MAX_PARTS> operationsOf(std::index_sequence<PARTS...>) {
  return {addPart<PARTS>...};
}

} // namespace

FilmReduction::FilmReduction(Film& shape) {
  const std::vector<Film::StatePart> parts = shape.stateParts();
  if (parts.size() > MAX_PARTS) throw Error("internal error: a film has too many parts");
  static const auto functions = operationsOf(std::make_index_sequence<MAX_PARTS>());
  for (size_t i = 0; i < parts.size(); ++i) {
    adders[i] = parts[i].add;
    MPI_Type_contiguous(static_cast<int>(parts[i].elementBytes), MPI_BYTE, &types.emplace_back());
    MPI_Type_commit(&types.back());
    MPI_Op_create(functions[i], 1, &operations.emplace_back());
  }
}

FilmReduction::~FilmReduction() {
  for (MPI_Datatype& t : types) MPI_Type_free(&t);
  for (MPI_Op& o : operations) MPI_Op_free(&o);
}

void FilmReduction::start(Film& own, Film* sum) {
  const std::vector<Film::StatePart> from = own.stateParts();
  const std::vector<Film::StatePart> into = sum ? sum->stateParts() : from;
  requests.clear();
  for (size_t i = 0; i < from.size(); ++i) {
    const size_t count = from[i].bytes.size() / from[i].elementBytes;
    for (size_t at = 0; at < count; at += CHUNK)
      MPI_Ireduce(from[i].bytes.data() + at * from[i].elementBytes,
                  sum ? into[i].bytes.data() + at * into[i].elementBytes : nullptr,
                  static_cast<int>(std::min(CHUNK, count - at)), types[i], operations[i], LEADER,
                  MPI_COMM_WORLD, &requests.emplace_back());
  }
  active = true;
}

bool FilmReduction::ended() {
  if (!active) return false;
  int done = 0;
  MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
  if (done) active = false;
  return done != 0;
}

} // namespace recurse::apps
