/** @file
 * What the program tells its user.
 */
#pragma once

#include <functional>
#include <string>

namespace recurse::apps {

/** Writes to standard output, as terminalText(); Error when that fails, as on a full disk. */
void print(const std::string& text);

/** Writes to standard error, as terminalText(). */
void say(const std::string& text);

/** While one lives, say() calls a function instead, from any thread. One at a time. */
class Listening {
 public:
  explicit Listening(const std::function<void(const std::string& text)>& listener);
  ~Listening();
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;
};

} // namespace recurse::apps
