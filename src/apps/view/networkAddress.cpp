/** @file
 * Parsing of HOST:PORT.
 */
#include "apps/view/networkAddress.h"

#include "apps/options/optionText.h"

namespace recurse::apps {

std::string NetworkAddress::hostText() const {
  return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

NetworkAddress parseNetworkAddress(const std::string& option, const std::string& text,
                                   const std::string& example) {
  const auto fail = [&] {
    badUsage(option + ": '" + text + "' is not HOST:PORT, such as " + example + "; IPv6 as [::1]:PORT");
  };
  NetworkAddress out;
  const bool hasBrackets = text.starts_with('[');
  const size_t hostEnd = hasBrackets ? text.find(']') : std::min(text.find(':'), text.size());
  if (hostEnd == std::string::npos) fail();
  out.host = hasBrackets ? text.substr(1, hostEnd - 1) : text.substr(0, hostEnd);
  const std::string rest = text.substr(hostEnd + (hasBrackets ? 1 : 0));
  if (rest.empty()) return out;
  if (!rest.starts_with(':') || rest.find(':', 1) != std::string::npos) fail();
  out.port = static_cast<int>(parseCount(option, rest.substr(1), 0, 65535));
  return out;
}

} // namespace recurse::apps
