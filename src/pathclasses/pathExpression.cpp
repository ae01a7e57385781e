/** @file
 * Sets of paths: their algebra, examples of their words, and their expressions.
 */
#include "recurse/pathclasses/pathExpression.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "pathclasses/pathExpressionDfa.h"

namespace recurse {

namespace {

constexpr std::string_view LETTERS = "SDVLE"; // in the order of PathLetter

Dfa combinedSets(const Dfa& a, const Dfa& b, SetOperation operation) {
  Effort effort;
  return combination(a, b, operation, effort);
}

/** Letters of an alphabet in the order of LETTERS, each followed by its letters with names. */
std::vector<size_t> sortedLetters(const PathAlphabet& alphabet, const std::vector<size_t>& bases) {
  std::vector<size_t> out;
  for (const size_t base : bases)
    for (size_t letter = 0; letter < alphabet.size(); ++letter)
      if (alphabet.base(letter) == base) out.push_back(letter);
  return out;
}

/** Appends up to `most` words with `events` events between L and E, in the order of the letters. */
class WordLister {
 public:
  WordLister(const Dfa& dfa, const PathAlphabet& alphabet, size_t maxEvents)
      : dfa(dfa), alphabet(alphabet), events(sortedLetters(alphabet, {0, 1, 2})),
        lights(sortedLetters(alphabet, {3})) {
    // completes[n][s]: some word of n events and E leads from s to acceptance.
    completes.emplace_back(dfa.size());
    for (uint32_t s = 0; s < dfa.size(); ++s)
      completes[0][s] = dfa.accepting[dfa.target(s, size_t(PathLetter::E))];
    for (size_t n = 1; n <= maxEvents; ++n) {
      completes.emplace_back(dfa.size());
      for (uint32_t s = 0; s < dfa.size(); ++s)
        for (const size_t e : events) completes[n][s] = completes[n][s] || completes[n - 1][dfa.target(s, e)];
    }
  }

  void list(size_t count, size_t most, std::vector<std::string>& out) {
    wanted = out.size() + most;
    for (const size_t light : lights) {
      word = alphabet.text(light);
      extend(dfa.target(0, light), count, out);
    }
  }

 private:
  void extend(uint32_t state, size_t left, std::vector<std::string>& out) {
    if (out.size() >= wanted || !completes[left][state]) return;
    if (left == 0) {
      out.push_back(word + "E");
      return;
    }
    for (const size_t e : events) {
      const size_t length = word.size();
      word += alphabet.text(e);
      extend(dfa.target(state, e), left - 1, out);
      word.resize(length);
    }
  }

  const Dfa& dfa;
  const PathAlphabet& alphabet;
  const std::vector<size_t> events, lights;
  std::vector<std::vector<uint8_t>> completes;
  std::string word;
  size_t wanted = 0;
};

/** Letters that lead from a state to another, in words. */
std::string lettersTo(const Dfa& dfa, const PathAlphabet& alphabet, uint32_t state, uint32_t target) {
  std::string out;
  const auto add = [&out](const std::string& text) { out += (out.empty() ? "" : " or ") + text; };
  for (const size_t base : {3, 0, 1, 2, 4}) {
    const std::vector<size_t> letters = sortedLetters(alphabet, {base});
    const auto leads = [&](size_t letter) { return dfa.target(state, letter) == target; };
    if (std::all_of(letters.begin(), letters.end(), leads)) {
      add(std::string(1, LETTERS[base]));
      continue;
    }
    for (const size_t letter : letters)
      if (leads(letter))
        add(alphabet.text(letter) + (alphabet.text(letter).size() == 1 ? " without these names" : ""));
  }
  return out;
}

/** Partial expression during state elimination; its kind determines the need for parentheses. */
struct Text {
  enum Kind { NOTHING, EMPTY_WORD, ALTERNATIVES, SEQUENCE, REPEATED, ATOM } kind = NOTHING;
  std::string text;
  uint32_t letters = 0; ///< set of letters, if it is a single letter or a choice of letters
};

Text letterText(uint32_t letters) {
  if (letters == 0) return {};
  if (letters == 0b111) return {Text::ATOM, ".", letters};
  std::string text;
  for (size_t a = 0; a < PATH_EVENTS; ++a)
    if (letters >> a & 1u) text += LETTERS[a];
  return {Text::ATOM, text.size() == 1 ? text : "[" + text + "]", letters};
}

bool dependsOnNames(const Dfa& dfa, const PathAlphabet& alphabet) {
  for (uint32_t state = 0; state < dfa.size(); ++state)
    for (size_t letter = 0; letter < dfa.letters; ++letter)
      if (dfa.target(state, letter) != dfa.target(state, alphabet.base(letter))) return true;
  return false;
}

std::string grouped(const Text& t, Text::Kind atLeast) {
  return t.kind < atLeast ? "(" + t.text + ")" : t.text;
}

Text repeat(const Text& t, char how) {
  if (t.kind <= Text::EMPTY_WORD) return how == '+' ? t : Text{Text::EMPTY_WORD, "", 0};
  if (t.kind == Text::REPEATED) { // (A+)* and (A?)* are A*; (A+)? is A*; (A*)? is A*
    const char has = t.text.back();
    return {Text::REPEATED, t.text.substr(0, t.text.size() - 1) + (has == how ? how : '*'), 0};
  }
  return {Text::REPEATED, grouped(t, Text::ATOM) + how, 0};
}

Text either(const Text& a, const Text& b) {
  if (a.kind == Text::NOTHING || (a.kind == b.kind && a.text == b.text)) return b;
  if (b.kind == Text::NOTHING) return a;
  if (a.kind == Text::EMPTY_WORD) return repeat(b, '?');
  if (b.kind == Text::EMPTY_WORD) return repeat(a, '?');
  if (a.letters && b.letters) return letterText(a.letters | b.letters);
  return {Text::ALTERNATIVES, a.text + "|" + b.text, 0};
}

Text then(const Text& a, const Text& b) {
  if (a.kind == Text::NOTHING || b.kind == Text::NOTHING) return {};
  if (a.kind == Text::EMPTY_WORD) return b;
  if (b.kind == Text::EMPTY_WORD) return a;
  // A A* and A* A are A+.
  const auto isStarOf = [](const Text& star, const Text& x) {
    return star.kind == Text::REPEATED && star.text == grouped(x, Text::ATOM) + "*";
  };
  if (isStarOf(b, a)) return repeat(a, '+');
  if (isStarOf(a, b)) return repeat(b, '+');
  return {Text::SEQUENCE, grouped(a, Text::SEQUENCE) + grouped(b, Text::SEQUENCE), 0};
}

} // namespace

PathAutomaton::PathAutomaton(Dfa dfa, std::shared_ptr<const PathAlphabet> alphabet)
    : dfa(std::make_shared<const Dfa>(std::move(dfa))), alphabet(std::move(alphabet)) {}

size_t PathAutomaton::stateCount() const { return dfa->size(); }
uint32_t PathAutomaton::next(uint32_t state, size_t letter) const { return dfa->target(state, letter); }
bool PathAutomaton::accepting(uint32_t state) const { return dfa->accepting[state]; }

bool PathAutomaton::accepts(std::string_view word) const {
  uint32_t state = start();
  while (!word.empty()) {
    const size_t letter = alphabet->take(word);
    if (letter == alphabet->size()) return false;
    state = dfa->target(state, letter);
  }
  return dfa->accepting[state];
}

template <class Combine>
PathAutomaton PathAutomaton::combined(const PathAutomaton& other, const Combine& combine) const {
  if (alphabet == other.alphabet) return PathAutomaton(combine(*dfa, *other.dfa), alphabet);
  const bool named = alphabet->hasNames(), otherNamed = other.alphabet->hasNames();
  if (named && otherNamed) throw std::logic_error("path expressions with names compiled apart");
  const auto& common = named ? alphabet : other.alphabet;
  return PathAutomaton(combine(named ? *dfa : withNames(*dfa, *common),
                               otherNamed ? *other.dfa : withNames(*other.dfa, *common)),
                       common);
}

PathAutomaton PathAutomaton::unite(const PathAutomaton& other) const {
  return combined(other, [](const Dfa& a, const Dfa& b) { return combinedSets(a, b, SetOperation::OR); });
}
PathAutomaton PathAutomaton::intersect(const PathAutomaton& other) const {
  return combined(other, [](const Dfa& a, const Dfa& b) { return combinedSets(a, b, SetOperation::AND); });
}
PathAutomaton PathAutomaton::difference(const PathAutomaton& other) const {
  return combined(other,
                  [](const Dfa& a, const Dfa& b) { return combinedSets(a, b, SetOperation::AND_NOT); });
}
PathAutomaton PathAutomaton::complement() const {
  return PathAutomaton(combinedSets(allPaths(*alphabet), *dfa, SetOperation::AND_NOT), alphabet);
}

bool PathAutomaton::isEmpty() const { return dfa->dead(0); }
bool PathAutomaton::equivalent(const PathAutomaton& other) const {
  if (alphabet == other.alphabet || (!alphabet->hasNames() && !other.alphabet->hasNames()))
    return *dfa == *other.dfa;
  return subsetOf(other) && other.subsetOf(*this);
}
bool PathAutomaton::subsetOf(const PathAutomaton& other) const { return difference(other).isEmpty(); }

std::vector<std::string> PathAutomaton::exampleWords(size_t maxEvents, size_t mostPerLength) const {
  // Scenes with media are rare: paths without V come first.
  const PathAutomaton surfaces = compile("L[SD]*E");
  const Dfa without = *intersect(surfaces).dfa, with = *difference(surfaces).dfa;
  WordLister first(without, *alphabet, maxEvents), second(with, *alphabet, maxEvents);
  std::vector<std::string> out;
  for (size_t events = 0; events <= maxEvents; ++events) {
    const size_t before = out.size();
    first.list(events, mostPerLength, out);
    second.list(events, mostPerLength - (out.size() - before), out);
  }
  return out;
}

std::string PathAutomaton::shortestWord() const {
  // Breadth-first search; `words` grows during the loop.
  std::vector<std::pair<uint32_t, std::string>> words = {{start(), ""}};
  std::vector<uint8_t> seen(dfa->size());
  const std::vector<size_t> letters = sortedLetters(*alphabet, {0, 1, 2, 3, 4});
  for (size_t i = 0; i < words.size(); ++i) {
    const auto [state, word] = words[i];
    if (dfa->accepting[state]) return word;
    for (const size_t a : letters)
      if (const uint32_t target = dfa->target(state, a);
          !dfa->dead(target) && !std::exchange(seen[target], uint8_t(1)))
        words.emplace_back(target, word + alphabet->text(a));
  }
  return {};
}

std::string PathAutomaton::describe() const {
  if (isEmpty()) return "  no path\n";
  constexpr uint32_t MAX_COUNT = 40;
  const std::vector<size_t> letters = sortedLetters(*alphabet, {3, 0, 1, 2, 4});
  std::string out;
  for (uint32_t s = 0; s < dfa->size(); ++s) {
    if (s >= MAX_COUNT) return out + "  ... (" + std::to_string(dfa->size()) + " states)\n";
    if (dfa->dead(s) || dfa->accepting[s]) continue; // an accepting state has no continuation: E ends a path
    // Letters with the same target are listed together, in the order of the letters.
    std::string line;
    std::vector<uint32_t> told;
    for (const size_t l : letters) {
      const uint32_t target = dfa->target(s, l);
      if (dfa->dead(target) || std::find(told.begin(), told.end(), target) != told.end()) continue;
      told.push_back(target);
      line += (line.empty() ? "" : "; ") + lettersTo(*dfa, *alphabet, s, target);
      line += dfa->accepting[target] ? " ends the path"
              : target == s          ? " stays"
                                     : " to " + std::to_string(target);
    }
    out += "  " + std::string(s == start() ? "start" : "state " + std::to_string(s)) + ": " + line + "\n";
  }
  return out;
}

std::string PathAutomaton::toExpression(size_t longest) const {
  if (isEmpty() || dependsOnNames(*dfa, *alphabet)) return {};
  // State elimination over the states between L and E. Two additional nodes represent "L was read" and "E is
  // next".
  std::vector<uint32_t> states;
  for (uint32_t s = 1; s < dfa->size(); ++s)
    if (!dfa->dead(s) && !dfa->accepting[s]) states.push_back(s);
  const size_t first = states.size(), last = first + 1;
  if (first > longest) return {}; // every state needs at least one character
  std::vector<std::vector<Text>> edge(last + 1, std::vector<Text>(last + 1));
  const Text emptyWord = {Text::EMPTY_WORD, "", 0};
  for (size_t i = 0; i < first; ++i) {
    if (next(start(), PathLetter::L) == states[i]) edge[first][i] = emptyWord;
    if (accepting(next(states[i], PathLetter::E))) edge[i][last] = emptyWord;
    for (size_t j = 0; j < first; ++j) {
      uint32_t letters = 0;
      for (uint32_t e = 0; e < PATH_EVENTS; ++e)
        if (dfa->target(states[i], e) == states[j]) letters |= 1u << e;
      edge[i][j] = letterText(letters);
    }
  }
  std::vector<size_t> left(first);
  for (size_t i = 0; i < first; ++i) left[i] = i;
  const auto weight = [&](size_t k) { // length of the text that the elimination of k adds
    size_t in = 0, out = 0, inText = 0, outText = 0;
    for (size_t i = 0; i <= last; ++i) {
      if (i == k) continue;
      if (edge[i][k].kind != Text::NOTHING) ++in, inText += edge[i][k].text.size();
      if (edge[k][i].kind != Text::NOTHING) ++out, outText += edge[k][i].text.size();
    }
    return in * outText + out * inText + in * out * (edge[k][k].text.size() + 1);
  };
  while (!left.empty()) {
    const auto at =
        std::min_element(left.begin(), left.end(), [&](size_t a, size_t b) { return weight(a) < weight(b); });
    const size_t k = *at;
    left.erase(at);
    const Text loop = repeat(edge[k][k], '*');
    for (size_t i = 0; i <= last; ++i) {
      if (i == k || edge[i][k].kind == Text::NOTHING) continue;
      for (size_t j = 0; j <= last; ++j) {
        if (j == k || edge[k][j].kind == Text::NOTHING) continue;
        const Text way = then(then(edge[i][k], loop), edge[k][j]);
        edge[i][j] = either(edge[i][j], way);
        if (edge[i][j].text.size() > 4 * longest) return {};
      }
    }
    for (size_t i = 0; i <= last; ++i) edge[i][k] = edge[k][i] = {};
  }
  const Text& inner = edge[first][last];
  std::string out(1, 'L');
  out += grouped(inner, inner.text.empty() ? Text::EMPTY_WORD : Text::SEQUENCE) + "E";
  return out.size() <= longest ? out : std::string();
}

size_t eventCount(std::string_view word) {
  size_t letters = 0;
  std::string name;
  for (size_t i = 0; i < word.size();)
    if (word[i] != '\'')
      ++letters, ++i;
    else if (!readQuoted(word, i, name))
      break;
  return letters < 2 ? 0 : letters - 2;
}

std::vector<PathOverlap> findOverlaps(const std::vector<PathAutomaton>& sets) {
  std::vector<PathOverlap> overlaps;
  for (size_t i = 0; i < sets.size(); ++i)
    for (size_t j = i + 1; j < sets.size(); ++j)
      if (const PathAutomaton both = sets[i].intersect(sets[j]); !both.isEmpty())
        overlaps.push_back({i, j, both.shortestWord()});
  return overlaps;
}

PathAutomaton leftOver(const PathAutomaton& whole, const std::vector<PathAutomaton>& sets) {
  PathAutomaton rest = whole;
  for (const PathAutomaton& set : sets) rest = rest.difference(set);
  return rest;
}

} // namespace recurse
