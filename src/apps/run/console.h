/** @file
 * Output of the program for its user.
 */
#pragma once

#include <functional>
#include <string>

namespace recurse::apps {

/** Writes terminalText() to standard output. Throws Error when that fails, as on a full disk. */
void print(const std::string& text);

/** Writes terminalText() to standard error. */
void say(const std::string& text);

/** Redirects say() to a function during its lifetime, from any thread. One at a time. */
class Listening {
 public:
  explicit Listening(const std::function<void(const std::string& text)>& listener);
  ~Listening();
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;
};

} // namespace recurse::apps
