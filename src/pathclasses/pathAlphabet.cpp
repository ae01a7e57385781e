/** @file
 * Kinds of lights and surfaces by their names, and their letters.
 */
#include "pathclasses/pathAlphabet.h"

#include <algorithm>
#include <set>

#include "recurse/core/io/error.h"

namespace recurse {

namespace {

constexpr std::string_view BASES = "SDVLE"; // in the order of PathLetter
constexpr size_t BASE_L = 3;

/** The names of a list that expressions use, sorted. */
PathAlphabet::Kind usedNames(const PathNames::List& names, const std::vector<std::string>& used) {
  PathAlphabet::Kind kind;
  for (const std::string& name : names)
    if (std::find(used.begin(), used.end(), name) != used.end()) kind.push_back(name);
  std::sort(kind.begin(), kind.end());
  kind.erase(std::unique(kind.begin(), kind.end()), kind.end());
  return kind;
}

/** Kinds of the lists of names, the empty one first if it occurs; `kindOf` gets the index of each list's. */
std::vector<PathAlphabet::Kind> kindsOf(const std::vector<PathNames::List>& lists,
                                        const std::vector<std::string>& used, std::vector<uint8_t>& kindOf) {
  std::vector<PathAlphabet::Kind> ofLists;
  for (const PathNames::List& list : lists) ofLists.push_back(usedNames(list, used));
  std::set<PathAlphabet::Kind> sorted(ofLists.begin(), ofLists.end());
  if (sorted.empty()) sorted.insert(PathAlphabet::Kind());
  const std::vector<PathAlphabet::Kind> kinds(sorted.begin(), sorted.end());
  if (kinds.size() > MAX_LETTERS / 4)
    throw Error("the path expressions name too many different lights or surfaces: at most " +
                    std::to_string(MAX_LETTERS / 4 - 1),
                ExitStatus::BAD_USAGE);
  for (const PathAlphabet::Kind& kind : ofLists)
    kindOf.push_back(uint8_t(std::lower_bound(kinds.begin(), kinds.end(), kind) - kinds.begin()));
  return kinds;
}

std::vector<std::string> allNames(const std::vector<PathNames::List>& first,
                                  const std::vector<PathNames::List>& second = {}) {
  std::set<std::string> names;
  for (const auto* lists : {&first, &second})
    for (const PathNames::List& list : *lists) names.insert(list.begin(), list.end());
  return {names.begin(), names.end()};
}

} // namespace

bool readQuoted(std::string_view text, size_t& position, std::string& name) {
  name.clear();
  for (size_t i = position + 1; i < text.size(); ++i) {
    if (text[i] != '\'') {
      name += text[i];
    } else if (i + 1 < text.size() && text[i + 1] == '\'') {
      name += text[i++];
    } else {
      position = i + 1;
      return true;
    }
  }
  return false;
}

std::vector<std::string> namesIn(std::string_view expression) {
  std::vector<std::string> names;
  std::string name;
  for (size_t i = 0; i < expression.size();) {
    if (expression[i] != '\'')
      ++i;
    else if (readQuoted(expression, i, name))
      names.push_back(name);
    else
      break;
  }
  return names;
}

std::vector<std::string> namesIn(const std::vector<PathClass>& classes) {
  std::vector<std::string> names;
  for (const PathClass& c : classes)
    for (std::string& name : namesIn(c.expression)) names.push_back(std::move(name));
  return names;
}

std::string quotedName(const std::string& name) {
  std::string out = "'";
  for (const char c : name) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

PathNames anyNames(const std::vector<std::string>& used) {
  PathNames names{{{}}, {{}}, {{}}};
  for (const std::string& name : used) {
    names.lights.push_back({name});
    names.objects.push_back({name});
  }
  return names;
}

PathAlphabet::PathAlphabet(const std::vector<std::string>& expressions, const PathNames* names) {
  std::vector<std::string> used;
  for (const std::string& e : expressions)
    for (std::string& name : namesIn(e)) used.push_back(std::move(name));
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  if (names) {
    addScene(*names, used);
  } else if (!used.empty()) {
    addScene(anyNames(used), used);
  }
  addTexts();
}

void PathAlphabet::addScene(const PathNames& names, const std::vector<std::string>& used) {
  if (used.empty()) return;
  allLights = allNames(names.lights);
  allSurfaces = allNames(names.objects, names.materials);
  lights = kindsOf(names.lights, used, lightKindOf);
  const std::vector<Kind> objects = kindsOf(names.objects, used, objectKindOf);
  const std::vector<Kind> materials = kindsOf(names.materials, used, materialKindOf);
  materialKinds = materials.size();
  std::vector<PathNames::List> pairs;
  for (const Kind& object : objects)
    for (const Kind& material : materials) {
      pairs.push_back(object);
      pairs.back().insert(pairs.back().end(), material.begin(), material.end());
    }
  surfaces = kindsOf(pairs, used, surfaceKindOf);
}

void PathAlphabet::addTexts() {
  texts.resize(PATH_LETTERS + 2 * (surfaces.size() - 1) + lights.size() - 1);
  const auto textOf = [](size_t base, const Kind& kind) {
    std::string joined;
    for (const std::string& name : kind) joined += (joined.empty() ? "" : "+") + name;
    return BASES[base] + (kind.empty() ? std::string() : quotedName(joined));
  };
  for (size_t base = 0; base < PATH_LETTERS; ++base) texts[base] = textOf(base, {});
  for (size_t kind = 0; kind < surfaces.size(); ++kind)
    for (size_t e = 0; e < 2; ++e) texts[event(e, kind)] = textOf(e, surfaces[kind]);
  for (size_t kind = 0; kind < lights.size(); ++kind) texts[light(kind)] = textOf(BASE_L, lights[kind]);
}

size_t PathAlphabet::base(size_t letter) const {
  if (letter < PATH_LETTERS) return letter;
  const size_t further = letter - PATH_LETTERS;
  return further < 2 * (surfaces.size() - 1) ? further % 2 : BASE_L;
}

LetterSet PathAlphabet::lettersOf(size_t base) const {
  LetterSet set;
  for (size_t letter = 0; letter < size(); ++letter)
    if (this->base(letter) == base) set.set(letter);
  return set;
}

LetterSet PathAlphabet::named(size_t base, const std::string& name) const {
  LetterSet set;
  const std::vector<Kind>& kinds = base == BASE_L ? lights : surfaces;
  for (size_t kind = 0; kind < kinds.size(); ++kind)
    if (std::find(kinds[kind].begin(), kinds[kind].end(), name) != kinds[kind].end())
      set.set(base == BASE_L ? light(kind) : event(base, kind));
  return set;
}

size_t PathAlphabet::take(std::string_view& word) const {
  size_t position = 1;
  std::string name;
  if (word.size() > 1 && word[1] == '\'' && !readQuoted(word, position, name)) return size();
  const auto found = std::find(texts.begin(), texts.end(), word.substr(0, position));
  if (word.empty() || found == texts.end()) return size();
  word.remove_prefix(position);
  return size_t(found - texts.begin());
}

} // namespace recurse
