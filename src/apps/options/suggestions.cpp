/** @file
 * Suggestions by spelling and by help texts.
 */
#include "apps/options/suggestions.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse::apps {

namespace {

/** Position of a whole word in a text; npos if there is none. */
size_t findWord(const std::string& text, const std::string& word) {
  const auto isLetter = [&](size_t i) {
    return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0;
  };
  size_t at = text.find(word);
  while (at != std::string::npos && ((at > 0 && isLetter(at - 1)) || isLetter(at + word.size())))
    at = text.find(word, at + 1);
  return at;
}

} // namespace

std::string suggestion(const std::string& wrong, const std::vector<Described>& accepted,
                       const std::string& prefix) {
  constexpr size_t LONGEST_WORD = 100, MOST = 3;
  if (wrong.empty() || wrong.size() > LONGEST_WORD) return {};
  std::vector<std::string> names;
  for (const Described& one : accepted) names.push_back(one.first);
  const std::string word = lowerCase(wrong);
  enum { MISSPELT, DESCRIBED_FIRST, CONTAINED, DESCRIBED };
  std::array<std::vector<std::string>, 4> ranks;
  for (const std::string& name : nearestNames(wrong, names, names.size()))
    ranks[lowerCase(name).find(word) == std::string::npos ? MISSPELT : CONTAINED].push_back(name);
  for (const auto& [name, description] : accepted)
    if (const size_t at = findWord(lowerCase(description), word); at != std::string::npos)
      ranks[at == 0 ? DESCRIBED_FIRST : DESCRIBED].push_back(name);
  std::vector<std::string> chosen;
  for (const std::vector<std::string>& rank : ranks)
    for (const std::string& name : rank)
      if (chosen.size() < MOST && std::find(chosen.begin(), chosen.end(), name) == chosen.end())
        chosen.push_back(name);
  std::string out;
  for (const std::string& name : chosen) out += (out.empty() ? "; did you mean " : " or ") + prefix + name;
  return out.empty() ? out : out + "?";
}

} // namespace recurse::apps
