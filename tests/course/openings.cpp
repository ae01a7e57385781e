/** @file
 * Checks the solutions with openings. Each line of the input has a command, `check` or `mark`, an exercise,
 * and the numbers of the openings; the answer to each ends with a line of dashes.
 */
#include "openings.h"

#include <cstdio>
#include <iostream>
#include <sstream>

#include "checks/checks.h"

using namespace course;

int main() {
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string command, exercise;
    words >> command >> exercise;
    openings.reset();
    for (size_t number = 0; words >> number;) openings.set(number);
    const bool isPath = exercise == "path";
    if (command == "check") {
      checkGaps(isPath ? pathTracerGaps() : photonMapperGaps());
    } else {
      const std::unique_ptr<Tracer> tracer = isPath ? makePathTracer() : makePhotonMapper(100000, 30);
      markPicture(*tracer, "switched-" + exercise, 32);
    }
    std::printf("-----\n");
    std::fflush(stdout);
  }
}
