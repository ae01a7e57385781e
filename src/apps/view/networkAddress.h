/** @file
 * Addresses of programs on a network.
 */
#pragma once

#include <string>

namespace recurse::apps {

/** A host by its name or number, and a port. */
struct NetworkAddress {
  std::string host; ///< without brackets; may be empty
  int port = 0;     ///< 0: none was given

  /** Host as in URLs: IPv6 in brackets. */
  std::string hostText() const;
  std::string text() const { return hostText() + ":" + std::to_string(port); }
};

/** Parses HOST, HOST:PORT, :PORT, with IPv6 as [::1] or [::1]:PORT. Throws Error (BAD_USAGE) that names the
 * option and shows the example. */
NetworkAddress parseNetworkAddress(const std::string& option, const std::string& text,
                                   const std::string& example);

} // namespace recurse::apps
