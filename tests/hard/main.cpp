/** @file
 * Runs the hard cases and prints the table. Each case runs in a separate process, so that a crash or a hang
 * is reported as a row.
 */
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hardCase.h"
#include "knownFailures.h"

namespace recurse::hard {

namespace {

constexpr const char* GROUPS[] = {"scale and place",
                                  "grazing, large and small",
                                  "triangles without shape",
                                  "refraction",
                                  "lights, small, near and many",
                                  "furnaces of high albedo",
                                  "range of values",
                                  "photon map",
                                  "stretched spheres",
                                  "inputs at the edge",
                                  "media"};
constexpr int QUICK_SECONDS = 300, HEAVY_SECONDS = 1800;

void put(FILE* pipe, const Row& row) {
  const auto clean = [](std::string s) {
    for (char& c : s)
      if (c == '\t' || c == '\n') c = ' ';
    return s;
  };
  std::fprintf(pipe, "%s\t%s\t%s\t%s\t%d\t%s\n", clean(row.what).c_str(), clean(row.integrator).c_str(),
               clean(row.figure).c_str(), clean(row.bound).c_str(), row.passed, clean(row.reason).c_str());
  std::fflush(pipe);
}

Row taken(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == '\t')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  fields.resize(6);
  return {fields[0], fields[1], fields[2], fields[3], fields[4] == "1", fields[5]};
}

/** Runs the case in a child process; `take` gets its rows, and an additional one if it fails to end
 * properly. */
void runApart(const HardCase& hardCase, const std::function<void(const Row&)>& take) {
  int ends[2];
  if (pipe(ends) != 0) {
    std::perror("pipe");
    std::exit(1);
  }
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) {
    std::perror("fork");
    std::exit(1);
  }
  if (child == 0) {
    close(ends[0]);
    FILE* out = fdopen(ends[1], "w");
    const auto send = [&](const Row& row) { put(out, row); };
    int status = 0;
    try {
      hardCase.run(Report(hardCase.name, send));
    } catch (const std::exception& e) {
      send({hardCase.name, "-", "exception", "none", false, e.what()});
      status = 1;
    }
    std::fclose(out);
    std::fflush(nullptr);
    _exit(status);
  }
  close(ends[1]);
  FILE* in = fdopen(ends[0], "r");
  // The descriptor is polled and read directly: a buffered read could wait beyond the limit.
  const int limit = thorough ? HEAVY_SECONDS : QUICK_SECONDS;
  const time_t start = time(nullptr);
  std::string line;
  bool hung = false;
  for (;;) {
    const long left = limit - (time(nullptr) - start);
    pollfd p{ends[0], POLLIN, 0};
    if (left <= 0 || poll(&p, 1, static_cast<int>(left * 1000)) == 0) {
      hung = true;
      kill(child, SIGKILL);
      break;
    }
    char buffer[4096];
    const ssize_t n = read(ends[0], buffer, sizeof buffer);
    if (n <= 0) break;
    for (ssize_t i = 0; i < n; ++i) {
      if (buffer[i] != '\n') {
        line += buffer[i];
        continue;
      }
      take(taken(line));
      line.clear();
    }
  }
  std::fclose(in);
  int status = 0;
  waitpid(child, &status, 0);
  if (hung)
    take({hardCase.name, "-", "still running", shown("<= %.0f s", limit), false, "hangs"});
  else if (WIFSIGNALED(status))
    take({hardCase.name, "-", strsignal(WTERMSIG(status)), "none", false, "crashes"});
  else if (WEXITSTATUS(status) > 1)
    take({hardCase.name, "-", shown("exit status %.0f", WEXITSTATUS(status)), "0", false, "crashes"});
}

void usage() {
  std::puts(
      "Usage: hard_cases [--heavy] [--group N] [--case TEXT] [--list]\n\n"
      "Runs the quick cases, or with --heavy every case, or those of a group, or those whose names contain\n"
      "TEXT. The exit status is 0 when exactly the known failures fail.");
}

} // namespace

int runCases(int argc, char** argv) {
  bool heavy = false, list = false;
  int group = 0;
  std::string name;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    if (a == "--heavy") {
      heavy = thorough = true;
    } else if (a == "--list") {
      list = true;
    } else if (a == "--group" && i + 1 < argc) {
      group = std::atoi(argv[++i]);
    } else if (a == "--case" && i + 1 < argc) {
      name = argv[++i];
    } else {
      usage();
      return a == "--help" || a == "-h" ? 0 : 2;
    }
  }
  HardCases cases;
  addScaleCases(cases);
  addGrazingCases(cases);
  addMeshCases(cases);
  addGlassCases(cases);
  addLampCases(cases);
  addFurnaceCases(cases);
  addRangeCases(cases);
  addPhotonMapCases(cases);
  addEllipsoidCases(cases);
  addInputCases(cases);
  addMediumCases(cases);

  int passed = 0, failed = 0, surprises = 0, shownGroup = 0;
  for (const HardCase& c : cases) {
    if ((group > 0 && c.group != group) || (c.heavy && !heavy) || c.name.find(name) == std::string::npos)
      continue;
    if (c.group != shownGroup) {
      shownGroup = c.group;
      std::printf("%s%d. %s\n", shownGroup > 1 ? "\n" : "", c.group, GROUPS[c.group - 1]);
    }
    if (list) {
      std::printf("  %s%s\n", c.name.c_str(), c.heavy ? " (heavy)" : "");
      continue;
    }
    int rows = 0;
    runApart(c, [&](const Row& row) {
      ++rows;
      ++(row.passed ? passed : failed);
      const char* known = knownFailure(row);
      const bool surprise = SANITIZED ? !row.passed && !known : row.passed == (known != nullptr);
      surprises += surprise;
      std::printf("  %-66s  %-29s  %-24s  %-11s  %s", row.what.c_str(), row.integrator.c_str(),
                  row.figure.c_str(), row.bound.c_str(), row.passed ? "pass" : "FAIL");
      if (!row.passed)
        std::printf(": %s%s%s", row.reason.c_str(), known ? "; known: " : "", known ? known : "");
      if (row.passed && known && !SANITIZED)
        std::printf(" (listed as a known failure: take it off tests/hard/knownFailures.h)");
      std::printf("\n");
      std::fflush(stdout);
    });
    if (rows == 0) {
      std::printf("  %s: no row\n", c.name.c_str());
      ++failed;
      ++surprises;
    }
  }
  if (list) return 0;
  if (surprises > 0) std::printf("\n%d rows are not as tests/hard/knownFailures.h says\n", surprises);
  std::printf("\nhard cases: %d passed, %d failed\n", passed, failed);
  return surprises > 0 || passed + failed == 0 ? 1 : 0;
}

} // namespace recurse::hard

int main(int argc, char** argv) { return recurse::hard::runCases(argc, argv); }
