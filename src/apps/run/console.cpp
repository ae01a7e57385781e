/** @file
 * Standard output and standard error.
 */
#include "apps/run/console.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "recurse/core/io/error.h"
#include "recurse/core/io/terminalText.h"

namespace recurse::apps {

void print(const std::string& text) {
  const std::string shown = terminalText(text);
  if (std::fwrite(shown.data(), 1, shown.size(), stdout) != shown.size() || std::fflush(stdout) != 0)
    throw Error(std::string("standard output: ") + std::strerror(errno));
}

namespace {

std::function<void(const std::string&)> listenerOfAll;

} // namespace

void say(const std::string& text) {
  if (listenerOfAll)
    listenerOfAll(text);
  else
    std::fputs(terminalText(text).c_str(), stderr);
}

Listening::Listening(const std::function<void(const std::string&)>& listener) { listenerOfAll = listener; }
Listening::~Listening() { listenerOfAll = nullptr; }

} // namespace recurse::apps
