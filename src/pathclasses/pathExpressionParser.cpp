/** @file
 * Parser of path expressions. It builds no syntax tree: every part is compiled to its automaton as soon as it
 * is parsed.
 */
#include "recurse/pathclasses/pathExpression.h"

#include <algorithm>
#include <optional>

#include "pathclasses/pathExpressionDfa.h"

namespace recurse {

namespace {

constexpr size_t MAX_LENGTH = 4096, MAX_DEPTH = 100, MAX_REPEAT = 1000;

/** Index of a letter without a name; nothing for another character. */
std::optional<size_t> baseLetter(char c) {
  const size_t at = std::string_view("SDVLE").find(c);
  if (at == std::string_view::npos) return std::nullopt;
  return at;
}

std::string quotedNames(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + quotedName(name);
  return out;
}

bool isLower(char c) { return c >= 'a' && c <= 'z'; }
bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

std::string namesOfClasses() {
  std::string out;
  for (const NamedPathClass& c : namedPathClasses()) out += (out.empty() ? "" : ", ") + c.name;
  return out;
}

class Parser {
 public:
  Parser(const std::string& text, PathAutomaton::Empty empty, const PathAlphabet& alphabet)
      : text(text), empty(empty), alphabet(alphabet) {}

  Dfa parse() {
    if (text.size() > MAX_LENGTH)
      fail(MAX_LENGTH, "an expression has at most " + std::to_string(MAX_LENGTH) + " characters", "");
    try {
      Part whole = alternatives();
      skipSpaces();
      if (!atEnd()) unexpected();
      whole.dfa = combination(whole.dfa, allPaths(alphabet), SetOperation::AND, effort);
      if (empty == PathAutomaton::Empty::REFUSED) refuseEmpty(whole);
      return std::move(whole.dfa);
    } catch (const AutomatonTooLarge& e) {
      fail(operationAt, std::string("this ") + e.what(), "smaller repetitions, or fewer nested ones");
    }
  }

 private:
  struct Part {
    Dfa dfa;
    size_t at = 0;
    /** True for a part that matches whole paths: a named class, a complement. */
    bool whole = false;
  };

  [[noreturn]] void fail(size_t at, const std::string& message, const std::string& accepted) const {
    // The caret position counts characters, not bytes; tabs and line ends in the expression are replaced.
    std::string shown, indent;
    for (size_t i = 0; i < std::min(text.size(), MAX_LENGTH); ++i) shown += isSpace(text[i]) ? ' ' : text[i];
    size_t column = 1;
    for (size_t i = 0; i < at && i < text.size(); ++i)
      if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) ++column;
    indent.append(column - 1, ' ');
    throw Error("path expression, column " + std::to_string(column) + ": " + message + "\n  " + shown +
                    "\n  " + indent + "^" + (accepted.empty() ? "" : "\n  accepted: " + accepted),
                ExitStatus::BAD_USAGE);
  }

  [[noreturn]] void unexpected() const {
    if (atEnd())
      fail(position, "the expression ends too early",
           "a letter L S D V E, '.', '[', '(', '!' or a named class");
    // Takes a whole character, which may have several bytes.
    size_t end = position + 1;
    while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) ++end;
    const std::string character = text.substr(position, end - position);
    const char c = text[position];
    if (c == ')' || c == ']')
      fail(position, "'" + character + "' has no matching bracket, or an empty expression before it",
           "an expression before it");
    if (c == '*' || c == '+' || c == '?' || c == '{')
      fail(position, "'" + character + "' has nothing to repeat", "a letter, group or bracket before it");
    if (c == '!')
      fail(position, "'!' is the complement among whole paths and cannot be part of a path",
           "'!' before a whole class; [^S] for an event that is not S");
    if (c == '^' || c == '$')
      fail(position, "'" + character + "' is not needed: an expression always stands for whole paths",
           "[^S] for an event that is not S");
    if (c == '}') fail(position, "'}' without '{'", "A{2}, A{2,} or A{2,3}");
    if (c == '|' || c == '&' || c == '-')
      fail(position, "'" + character + "' has nothing on one side",
           "an expression on both sides; A? for nothing or A");
    if (c == '\'')
      fail(position, "a name has no letter before it",
           "L'lamp' for lights, D'floor' and S'glass' for surfaces");
    if (c >= 'A' && c <= 'Z')
      fail(position, "'" + character + "' is no path letter",
           "L light, S specular, D diffuse or glossy, V scattering in a medium, E camera (eye)");
    fail(
        position, "'" + character + "' has no meaning here",
        "letters L S D V E, '.', [SD], [^S], (A|B), [A|B], A? A* A+ A{2,3}, A & B, A - B, !A, named classes");
  }

  bool atEnd() const { return position >= text.size(); }
  char peek() {
    skipSpaces();
    return atEnd() ? '\0' : text[position];
  }
  void skipSpaces() {
    while (!atEnd() && isSpace(text[position])) ++position;
  }
  bool take(char c) {
    if (peek() != c || atEnd()) return false;
    ++position;
    return true;
  }

  void refuseEmpty(const Part& part) const {
    if (!part.dfa.dead(0)) return;
    fail(part.at, "no path matches this",
         "words that begin with L, end with E and have S, D or V between, such as L(S|D)*E");
  }

  /** An operand of a set operation outside of all parentheses is a class, so it must have paths. */
  Part operand(Part part) {
    if (depth == 0 && empty == PathAutomaton::Empty::REFUSED)
      refuseEmpty(
          {combination(part.dfa, allPaths(alphabet), SetOperation::AND, effort), part.at, part.whole});
    return part;
  }

  Part alternatives(bool* hasBar = nullptr) {
    bool subtracts = false;
    std::vector<Part> parts;
    parts.push_back(intersections(subtracts));
    const size_t at = parts.front().at;
    bool whole = parts.front().whole;
    while (peek() == '|') {
      const size_t bar = position++;
      if (parts.size() == 1) parts.front() = operand(std::move(parts.front()));
      parts.push_back(operand(intersections(subtracts)));
      whole = whole || parts.back().whole;
      if (subtracts)
        fail(bar, "'-' and '|' side by side can be read in two ways", "(A - B) | C or A - (B | C)");
    }
    if (hasBar) *hasBar = parts.size() > 1;
    if (parts.size() == 1) return std::move(parts.front());
    std::vector<Dfa> dfas;
    for (Part& part : parts) dfas.push_back(std::move(part.dfa));
    operationAt = at;
    return {alternation(dfas, effort), at, whole};
  }

  Part intersections(bool& subtracts) {
    Part left = complement();
    for (char c = peek(); c == '&' || c == '-'; c = peek()) {
      ++position;
      subtracts = subtracts || c == '-';
      left = operand(std::move(left));
      const Part right = operand(complement());
      operationAt = left.at;
      left.dfa =
          combination(left.dfa, right.dfa, c == '&' ? SetOperation::AND : SetOperation::AND_NOT, effort);
      left.whole = left.whole || right.whole;
    }
    return left;
  }

  Part complement() {
    const size_t at = (skipSpaces(), position);
    bool complemented = false, odd = false;
    while (take('!')) {
      complemented = true;
      odd = !odd;
    }
    Part part = sequence();
    if (!complemented) return part;
    operationAt = at;
    part.dfa =
        combination(allPaths(alphabet), part.dfa, odd ? SetOperation::AND_NOT : SetOperation::AND, effort);
    return {std::move(part.dfa), at, true};
  }

  Part sequence() {
    std::vector<Part> parts;
    for (char c = peek(); c != '\0' && c != '|' && c != '&' && c != '-' && c != ')' && c != ']'; c = peek()) {
      parts.push_back(repeated());
      if (parts.size() == 1) continue;
      for (const Part& part : parts)
        if (part.whole)
          fail(part.at, "this stands for whole paths, from L to E, and cannot be part of a longer one",
               "classes joined by |, & or -");
    }
    if (parts.empty()) unexpected();
    if (parts.size() == 1) return std::move(parts.front());
    std::vector<Dfa> dfas;
    for (Part& part : parts) dfas.push_back(std::move(part.dfa));
    operationAt = parts.front().at;
    return {concatenation(dfas, effort), parts.front().at, false};
  }

  Part repeated() {
    Part part = atom();
    size_t least = 0, most = UNBOUNDED;
    const char c = peek();
    const size_t at = position;
    if (c != '?' && c != '*' && c != '+' && c != '{') return part;
    ++position;
    if (part.whole)
      fail(part.at, "this stands for whole paths, from L to E, and cannot be repeated",
           "classes joined by |, & or -");
    if (c == '?') most = 1;
    if (c == '+') least = 1;
    if (c == '{') {
      least = most = number();
      if (take(',')) most = peek() == '}' ? UNBOUNDED : number();
      if (!take('}')) fail(position, "'{' is not closed here", "A{2}, A{2,} or A{2,3}");
      if (most < least) fail(at, "the upper bound is below the lower one", "A{2}, A{2,} or A{2,3}");
    }
    if (const char again = peek(); again == '?' || again == '*' || again == '+' || again == '{')
      fail(position, "a repetition of a repetition needs parentheses", "(A" + std::string(1, c) + ")...");
    operationAt = part.at;
    part.dfa = repetition(part.dfa, least, most, effort);
    return part;
  }

  size_t number() {
    const size_t at = (skipSpaces(), position);
    size_t value = 0;
    for (; !atEnd() && isDigit(text[position]); ++position)
      value = std::min<size_t>(value * 10 + static_cast<size_t>(text[position] - '0'), MAX_REPEAT + 1);
    if (position == at) fail(at, "a number is missing", "A{2}, A{2,} or A{2,3}");
    if (value > MAX_REPEAT) fail(at, "a repetition count is at most " + std::to_string(MAX_REPEAT), "");
    return value;
  }

  Part atom() {
    const char c = peek();
    const size_t at = position;
    if (baseLetter(c)) return {oneLetter(letters(), alphabet.size()), at, false};
    if (isLower(c)) return namedClass();
    if (take('.')) return {oneLetter(alphabet.events(), alphabet.size()), at, false};
    if (take('(')) return group(at, ')');
    if (take('[')) {
      if (auto letters = letterSet(at)) return std::move(*letters);
      return group(at, ']');
    }
    unexpected();
  }

  /** Parses a letter, with a name or without. */
  LetterSet letters() {
    const size_t base = *baseLetter(text[position++]);
    if (peek() != '\'') return alphabet.lettersOf(base);
    const size_t at = position;
    std::string name;
    if (!readQuoted(text, position, name)) fail(at, "this name has no end", "L'lamp', with '' for a ' in it");
    if (base == size_t(PathLetter::V) || base == size_t(PathLetter::E))
      fail(at, "V and E have no names", "L'lamp' for lights, D'floor' and S'glass' for surfaces");
    const LetterSet set = alphabet.named(base, name);
    if (set.none()) unknownName(at, name, base == size_t(PathLetter::L));
    return set;
  }

  [[noreturn]] void unknownName(size_t at, const std::string& name, bool isLight) const {
    const std::vector<std::string>& known = isLight ? alphabet.knownLights() : alphabet.knownSurfaces();
    const std::vector<std::string>& others = isLight ? alphabet.knownSurfaces() : alphabet.knownLights();
    const bool isOther = std::find(others.begin(), others.end(), name) != others.end();
    constexpr size_t MOST = 8;
    std::vector<std::string> near = nearestNames(name, known);
    if (near.empty())
      near.assign(known.begin(), known.begin() + std::ptrdiff_t(std::min(MOST, known.size())));
    fail(at,
         std::string("the scene has no ") + (isLight ? "light" : "surface") + " named " + quotedName(name) +
             (isOther ? (isLight ? ": it is a surface" : ": it is a light") : ""),
         near.empty() ? std::string("no name: the scene has none for ") + (isLight ? "lights" : "surfaces")
                      : quotedNames(near) + (known.size() > near.size() ? ", ..." : ""));
  }

  Part group(size_t at, char close) {
    if (++depth > MAX_DEPTH)
      fail(at, "groups are nested more than " + std::to_string(MAX_DEPTH) + " deep", "");
    bool hasBar = false;
    Part part = alternatives(&hasBar);
    if (!take(close)) {
      if (!atEnd()) unexpected();
      fail(at, "this has no matching '" + std::string(1, close) + "'", "");
    }
    if (close == ']' && !hasBar)
      fail(at, "brackets hold letters only, or alternatives with a bar",
           "[SD], [^S], [LS+|LD] or parentheses");
    --depth;
    part.at = at;
    return part;
  }

  /** Parses `[SD]` and `[^S]` after the '['; for a group it returns nothing and leaves the position. */
  std::optional<Part> letterSet(size_t at) {
    const size_t begin = position;
    const bool negated = take('^');
    LetterSet set;
    while (baseLetter(peek())) set |= letters();
    if (peek() == ']' && !atEnd()) {
      if (set.none()) fail(at, "these brackets hold no letter", "[SD], [^S] or [A|B]");
      ++position;
      if (negated) set = alphabet.events() & ~set;
      if (set.none()) fail(at, "this leaves none of S, D and V", "[SD], [^S] or [A|B]");
      return Part{oneLetter(set, alphabet.size()), at, false};
    }
    if (negated) {
      if (atEnd()) fail(at, "this has no matching ']'", "");
      fail(position, "after [^ there are only letters", "[^S] or [^SD]");
    }
    position = begin;
    return std::nullopt;
  }

  Part namedClass() {
    const size_t at = position;
    while (!atEnd() && isLower(text[position])) ++position;
    const std::string name = text.substr(at, position - at);
    std::vector<std::string> names;
    for (const NamedPathClass& c : namedPathClasses()) {
      // The expressions of named classes contain only letters, so the recursion ends here.
      if (c.name == name) return {Parser(c.expression, empty, alphabet).parse(), at, true};
      names.push_back(c.name);
    }
    const std::vector<std::string> near = nearestNames(name, names, 1);
    const bool letters = name.find_first_not_of("sdvle") == std::string::npos;
    fail(at,
         "there is no class '" + name + "'" +
             (letters        ? "; path letters are upper case"
              : near.empty() ? ""
                             : "; is it '" + near.front() + "'?"),
         "letters L S D V E, or " + namesOfClasses());
  }

  const std::string& text;
  PathAutomaton::Empty empty;
  const PathAlphabet& alphabet;
  Effort effort;
  size_t position = 0, depth = 0, operationAt = 0;
};

} // namespace

PathAutomaton PathAutomaton::compile(const std::string& expression, Empty empty, const PathNames* names) {
  return compileAll({{expression, expression}}, empty, names).front();
}

std::vector<PathAutomaton> PathAutomaton::compileAll(const std::vector<PathClass>& classes, Empty empty,
                                                     const PathNames* names) {
  static const auto WITHOUT_NAMES = std::make_shared<const PathAlphabet>();
  std::vector<std::string> expressions;
  bool named = false;
  for (const PathClass& c : classes) {
    expressions.push_back(c.expression);
    named = named || c.expression.find('\'') != std::string::npos;
  }
  const auto alphabet = named ? std::make_shared<const PathAlphabet>(expressions, names) : WITHOUT_NAMES;
  std::vector<PathAutomaton> automata;
  for (const std::string& e : expressions)
    automata.push_back(PathAutomaton(Parser(e, empty, *alphabet).parse(), alphabet));
  return automata;
}

const std::vector<NamedPathClass>& namedPathClasses() {
  static const std::vector<NamedPathClass> classes = {
      {"all", "L.*E", "every path"},
      {"emitted", "LE", "lights seen directly"},
      {"direct", "L[S|D]E", "light scattered once, at a surface"},
      {"indirect", "L.{2,}E", "light scattered at least twice"},
      {"surface", "L[SD]*E", "paths that no medium scatters"},
      {"medium", "L.*V.*E", "paths that a medium scatters at least once"},
      {"specular", "LS+E", "lights seen in mirrors and through glass"},
      {"diffuse", "LD+E", "light scattered by diffuse and glossy surfaces only"},
      {"interreflection", "LDD+E", "the same, at least twice"},
      {"caustic", "LS+DS*E",
       "light that mirrors or glass cast onto a surface, seen directly or through such"},
      {"reflected", "LD+S+E", "diffusely lit surfaces seen in mirrors and through glass"},
      {"sds", "L.*SDS.*E", "a surface lit through something specular and seen through something specular"},
  };
  return classes;
}

std::vector<PathClass> defaultStillClasses(bool withMedia) {
  std::vector<PathClass> classes = {
      {"emitted", "LE"},
      {"direct-diffuse", "LDE"},
      {"direct-specular", "LS+E"},
      {"caustic", "LS+DS*E"},
      {"interreflection-1", "LDDE"},
      {"interreflection-2", "LDDDE"},
      {"interreflection-3", "LDDDDE"},
      {"interreflection-more", "LD{5,}E"},
      {"specular-of-diffuse", "LD+S+E"},
  };
  if (withMedia) {
    // Every path with a V is in one of these classes.
    const std::vector<PathClass> media = {
        {"medium-direct", "LVE"},
        {"medium-caustic", "LS+VE"},
        {"medium-lit-by-surfaces", "LS*D[SD]*VE"},
        {"medium-multiple", "L.*V.*VE"},
        {"specular-of-medium", "L.*VS+E"},
        {"surface-lit-by-medium", "L.*V[SD]*DS*E"},
    };
    classes.insert(classes.end(), media.begin(), media.end());
  }
  std::string others;
  for (const PathClass& c : classes) others += (others.empty() ? "" : "|") + c.expression;
  classes.push_back({"remainder", "all - (" + others + ")"});
  return classes;
}

} // namespace recurse
