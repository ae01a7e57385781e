/** @file
 * Full-text search over the registries and the directives.
 */
#include "apps/help/referenceSearch.h"

#include <algorithm>
#include <cctype>
#include <vector>

#include "apps/help/registries.h"
#include "recurse/core/io/text.h"
#include "recurse/scene/directives/reference.h"
#include "recurse/scene/parameters/otherNames.h"

namespace recurse::apps {

namespace {

/** A found text. Plug-ins of one kind that share a parameter are one match. */
struct Match {
  std::string kind;
  std::string plugIn;    ///< the first one; empty: a directive
  std::string parameter; ///< its declaration; empty: the plug-in itself
  std::string text;
  int others = 0; ///< plug-ins of the same kind with the same parameter, besides the first
};

/** True if `wanted`, in lower case, occurs in the text at the beginning of a word; if it has several words,
 * true if each of them does. */
bool hasWord(const std::string& text, const std::string& wanted) {
  if (const size_t blank = wanted.find(' '); blank != std::string::npos)
    return hasWord(text, wanted.substr(0, blank)) && hasWord(text, wanted.substr(blank + 1));
  const std::string lower = lowerCase(text);
  for (size_t at = lower.find(wanted); at != std::string::npos; at = lower.find(wanted, at + 1))
    if (at == 0 || std::isalnum(static_cast<unsigned char>(lower[at - 1])) == 0) return true;
  return false;
}

/** Collects matches; a parameter that several plug-ins of a kind share is one match. */
class Matches {
 public:
  explicit Matches(std::string wanted) : wanted(std::move(wanted)) {}

  void add(const Match& match) {
    const std::string& name = match.plugIn.empty() ? match.kind : match.plugIn;
    if (!hasWord(match.text, wanted) && !hasWord(match.parameter.empty() ? name : match.parameter, wanted))
      return;
    for (Match& known : list)
      if (!match.parameter.empty() && known.kind == match.kind && known.parameter == match.parameter &&
          known.text == match.text) {
        ++known.others;
        return;
      }
    list.push_back(match);
  }
  const std::vector<Match>& all() const { return list; }

 private:
  std::string wanted;
  std::vector<Match> list;
};

std::string labelOf(const Match& match) {
  std::string label = match.kind;
  if (!match.plugIn.empty()) label += " \"" + match.plugIn + "\"";
  if (match.others > 0) label += " and " + std::to_string(match.others) + " more:";
  if (!match.parameter.empty()) label += " " + match.parameter;
  return label;
}

/** The label, then the text in lines of at most 100 columns to its right. */
std::string entry(const std::string& label, const std::string& text) {
  constexpr size_t WIDTH = 100, COLUMN = 36;
  std::string out = "  " + label, line;
  out += out.size() + 2 > COLUMN ? "\n" + std::string(COLUMN, ' ') : std::string(COLUMN - out.size(), ' ');
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    begin = end + 1;
    if (!line.empty() && COLUMN + line.size() + 1 + word.size() > WIDTH) {
      out += line + "\n" + std::string(COLUMN, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return out + line + "\n";
}

/** The plug-ins that the word means. */
std::vector<Match> meantBy(const std::string& word) {
  std::vector<Match> out;
  for (const PlugInName& meant : plugInsMeantBy(word))
    forEachRegistry([&](const auto& registry) {
      if (registry.kind() != meant.kind) return;
      if (const auto* plugIn = registry.find(meant.name))
        out.push_back({meant.kind, meant.name, "", plugIn->summary});
    });
  return out;
}

/** Description, with the choices of the parameter that have the word. */
std::string textOf(const ParameterSpec& spec, const std::string& wanted) {
  std::string choices;
  for (const std::string& choice : spec.choices)
    if (hasWord(choice, wanted)) choices += (choices.empty() ? " (values: \"" : " \"") + choice + "\"";
  return spec.description + choices + (choices.empty() ? "" : ")");
}

std::vector<Match> textsWith(const std::string& wanted) {
  Matches matches(wanted);
  for (const DirectiveInfo& d : directiveInfos()) matches.add({d.name, "", "", d.summary});
  forEachRegistry([&](const auto& registry) {
    for (const auto& plugIn : registry.entries()) {
      matches.add({registry.kind(), plugIn.name, "", plugIn.summary});
      for (const ParameterSpec& spec : plugIn.parameters)
        matches.add({registry.kind(), plugIn.name, declarationText(spec), textOf(spec, wanted)});
    }
  });
  return matches.all();
}

} // namespace

std::string searchReference(const std::string& word) {
  std::string singular = lowerCase(word);
  if (singular.size() > 3 && singular.back() == 's' && singular[singular.size() - 2] != 's')
    singular.pop_back();
  if (singular.empty()) return {};
  std::vector<Match> meant = meantBy(word);
  if (meant.empty()) meant = meantBy(singular);
  std::string out;
  if (!meant.empty()) out += "'" + word + "' is probably:\n";
  for (const Match& match : meant) out += entry(labelOf(match), match.text);
  std::vector<Match> found = textsWith(singular);
  std::erase_if(found, [&](const Match& match) { // listed above
    return match.parameter.empty() && std::any_of(meant.begin(), meant.end(), [&](const Match& other) {
             return other.kind == match.kind && other.plugIn == match.plugIn;
           });
  });
  if (!found.empty()) out += (out.empty() ? "" : "\n") + ("Texts with '" + singular + "':\n");
  for (const Match& match : found) out += entry(labelOf(match), match.text);
  if (out.empty()) return out;
  const auto named = [](const Match& match) { return !match.plugIn.empty(); };
  const auto example = std::find_if(found.begin(), found.end(), named);
  const std::string name = !meant.empty()           ? meant.front().plugIn
                           : example != found.end() ? example->plugIn
                                                    : "photonmap";
  return out + "\nAll parameters of a plug-in: recurse reference " + name + "\n";
}

} // namespace recurse::apps
