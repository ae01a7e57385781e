/** @file
 * Commands and reports as MPI messages.
 */
#include "mpi/messages.h"

#include <cstring>
#include <type_traits>

#include <mpi.h>

namespace recurse::apps {

namespace {

// Ranks, which all run the same program, exchange these as bytes.
static_assert(std::is_trivially_copyable_v<Command> && std::is_trivially_copyable_v<Report> &&
              std::is_trivially_copyable_v<WorkUnit>);

enum Tag { COMMAND = 1, REPORT = 2 };

template <class T> void append(std::vector<char>& bytes, const T* values, size_t count) {
  if (count == 0) return;
  const size_t at = bytes.size();
  bytes.resize(at + sizeof(T) * count);
  std::memcpy(&bytes[at], values, sizeof(T) * count);
}

/** Reads the next values of a message and moves `bytes` behind them. */
template <class T> void take(const char*& bytes, std::vector<T>& values, size_t count) {
  values.resize(count);
  if (count == 0) return;
  std::memcpy(values.data(), bytes, count * sizeof(T));
  bytes += count * sizeof(T);
}

} // namespace

void sendCommand(int rank, const Command& command) {
  MPI_Send(&command, sizeof command, MPI_BYTE, rank, COMMAND, MPI_COMM_WORLD);
}

std::optional<Command> receivedCommand() {
  int there = 0;
  MPI_Iprobe(LEADER, COMMAND, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
  if (!there) return {};
  Command command;
  MPI_Recv(&command, sizeof command, MPI_BYTE, LEADER, COMMAND, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return command;
}

void sendReport(const FullReport& report) {
  Report head = report;
  head.leftCount = report.left.size();
  head.pilotCount = report.pilots.size();
  head.failureBytes = report.failure.size();
  std::vector<char> bytes;
  append(bytes, &head, 1);
  append(bytes, report.left.data(), report.left.size());
  append(bytes, report.pilots.data(), report.pilots.size());
  append(bytes, report.failure.data(), report.failure.size());
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, LEADER, REPORT, MPI_COMM_WORLD);
}

std::optional<std::pair<int, FullReport>> receivedReport() {
  int there = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, REPORT, MPI_COMM_WORLD, &there, &status);
  if (!there) return {};
  int count = 0;
  MPI_Get_count(&status, MPI_BYTE, &count);
  std::vector<char> bytes(static_cast<size_t>(count));
  MPI_Recv(bytes.data(), count, MPI_BYTE, status.MPI_SOURCE, REPORT, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  FullReport out;
  Report& head = out;
  std::memcpy(static_cast<void*>(&head), bytes.data(), sizeof(Report));
  const char* rest = bytes.data() + sizeof(Report);
  take(rest, out.left, head.leftCount);
  take(rest, out.pilots, head.pilotCount);
  out.failure.assign(rest, head.failureBytes);
  return std::pair(status.MPI_SOURCE, std::move(out));
}

} // namespace recurse::apps
