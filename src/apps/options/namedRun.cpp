/** @file
 * Parsing of NAME=OPTIONS.
 */
#include "apps/options/namedRun.h"

#include <algorithm>
#include <cctype>

#include "apps/options/optionText.h"

namespace recurse::apps {

namespace {

bool isRunName(const std::string& text) {
  const auto letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  return !text.empty() && letter(text[0]) && std::all_of(text.begin(), text.end(), [&](char c) {
    return letter(c) || c == '-' || c == '_' || c == '.' || c == '+';
  });
}

} // namespace

Run parseRun(const std::string& option, const std::string& text, const RenderOptions& common,
             const std::vector<const char*>& refused) {
  const size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  if (equals == std::string::npos || !isRunName(name))
    badUsage(option + ": '" + text +
             "' is not NAME=\"OPTIONS\", such as pm=\"--integrator photonmap --radius 0.05\"; "
             "names have letters, digits and - _ . +");
  Run run{name, common, {}};
  CLI::App parser;
  parser.set_help_flag();
  run.options.addTo(parser);
  try {
    parser.parse(text.substr(equals + 1), false);
  } catch (const CLI::ParseError& error) {
    badUsage(option + " " + name + ": " + error.what());
  }
  for (const char* other : {"--seed", "--nthreads", "--resolution", "--cropwindow", "--stats", "--progress",
                            "--quiet", "--verbose", "--lenient"})
    if (parser.count(other) > 0)
      badUsage(option + " " + name + ": " + other + " is for all runs; write it beside " + option);
  for (const char* other : refused)
    if (parser.count(other) > 0)
      badUsage(option + " " + name + ": " + other +
               " is set by the budgets; use --times, --samples or --photons");
  return run;
}

} // namespace recurse::apps
