/** @file
 * Entry point of the program `recurse-mpi`: `recurse render` by many processes.
 */
#include <cstdio>
#include <string>
#include <string_view>

#include <unistd.h>

#include "apps/program.h"
#include "apps/run/console.h"
#include "mpi/mpiCluster.h"

namespace {

/** Captures the output of a rank until it has joined, because all ranks would print the same. */
class QuietUntilJoined {
 public:
  explicit QuietUntilJoined(bool leads) {
    if (leads || !std::freopen("/dev/null", "w", stdout)) return;
    kept = std::tmpfile();
    if (!kept) return;
    own = ::dup(STDERR_FILENO);
    ::dup2(::fileno(kept), STDERR_FILENO);
  }
  /** Ends the capture and returns the text. */
  std::string release() {
    std::string text;
    if (!kept) return text;
    std::fflush(stderr);
    ::dup2(own, STDERR_FILENO);
    ::close(own);
    std::rewind(kept);
    for (int c = 0; (c = std::fgetc(kept)) != EOF;) text += static_cast<char>(c);
    std::fclose(kept);
    kept = nullptr;
    return text;
  }

 private:
  int own = -1;
  std::FILE* kept = nullptr;
};

} // namespace

int main(int argc, char** argv) {
  using namespace recurse::apps;
  MpiCluster mpi(argc, argv);
  QuietUntilJoined quiet(mpi.leads());
  mpi.onJoined = [&] { quiet.release(); };
  if (argc > 1 && std::string_view(argv[1]) != "render" && argv[1][0] != '-') {
    if (mpi.leads()) say(std::string("recurse-mpi: only renders; for '") + argv[1] + "' use recurse\n");
    return 2;
  }
  setCluster(&mpi);
  const int status = program(argc, argv);
  if (!mpi.joined())
    mpi.fail(quiet.release());
  else if (mpi.isRendering())
    mpi.abort(status);
  return status;
}
