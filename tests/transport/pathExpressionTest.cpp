/** @file
 * Path expressions against std::regex and against a direct evaluation of random expressions; walks and joins
 * of path classes on every word and every cut; errors; domains and reports.
 */
#include <functional>
#include <memory>
#include <random>
#include <regex>

#include <gtest/gtest.h>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/pathclasses/classesReport.h"
#include "recurse/pathclasses/pathClasses.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/transport/integrator/estimatorDomains.h"
#include "sanitized.h"

namespace recurse {
namespace {

constexpr std::string_view EVENTS = "SDV";

/** Calls `visit` with the events of every path of up to `longest` events. */
void forAllWords(size_t longest, const std::function<void(const std::string&)>& visit) {
  std::string word;
  const std::function<void()> extend = [&] {
    visit(word);
    if (word.size() == longest) return;
    for (const char c : EVENTS) {
      word.push_back(c);
      extend();
      word.pop_back();
    }
  };
  extend();
}

PathEvent eventOf(char c) { return static_cast<PathEvent>(EVENTS.find(c)); }

/** Cuts the path at every vertex and joins the halves; returns whether all joins give `expected`. A walk that
 * could still be completed must not be dead. */
bool joinsGive(const PathClasses& classes, const std::string& events, LayerMask expected) {
  std::vector<LightState> light = {classes.lightStart()};
  for (const char c : events) light.push_back(classes.step(light.back(), eventOf(c)));
  CameraState eye = classes.cameraStart();
  for (size_t cut = events.size();; --cut) {
    if (classes.join(light[cut], eye) != expected) return false;
    if (expected != 0 && (classes.dead(light[cut]) || classes.dead(eye))) return false;
    if (cut == 0) return true;
    eye = classes.step(eye, eventOf(events[cut - 1]));
  }
}

PathClasses onlyClass(const std::string& expression) {
  return PathClasses(std::vector<PathClass>{{"only", expression}});
}

// --- Membership, against std::regex
// ------------------------------------------------------------------------------

struct RegexCase {
  std::string ours, regex;
};

void PrintTo(const RegexCase& c, std::ostream* out) { *out << c.ours; }

class AgainstStdRegex : public ::testing::TestWithParam<RegexCase> {};

TEST_P(AgainstStdRegex, AllWordsUpToTenEventsAndAllTheirCuts) {
  constexpr size_t LONGEST = recurse::testing::SANITIZED ? 8 : 10;
  const std::string ours = GetParam().ours, regexText = GetParam().regex;
  const PathAutomaton automaton = PathAutomaton::compile(ours);
  const PathClasses classes = onlyClass(ours);
  const std::regex regex(regexText, std::regex::ECMAScript | std::regex::optimize | std::regex::nosubs);
  size_t words = 0, members = 0;
  forAllWords(LONGEST, [&](const std::string& events) {
    const std::string word = "L" + events + "E";
    const bool expected = std::regex_match(word, regex);
    ++words;
    members += expected;
    if (automaton.accepts(word) != expected) ADD_FAILURE() << ours << " on " << word << ": not " << expected;
    if (!joinsGive(classes, events, expected)) ADD_FAILURE() << ours << " joined on " << word;
  });
  EXPECT_EQ(words, recurse::testing::SANITIZED ? 9841u : 88573u); // (3^(n+1) - 1) / 2
  EXPECT_GT(members, 0u);
  const std::string expression = automaton.toExpression(300);
  if (!expression.empty()) {
    EXPECT_TRUE(PathAutomaton::compile(expression).equivalent(automaton)) << expression;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Expressions, AgainstStdRegex,
    ::testing::Values(
        RegexCase{"LE", "LE"}, RegexCase{"L.*E", "L[SDV]*E"}, RegexCase{"L(S|D)*DS+E", "L(S|D)*DS+E"},
        RegexCase{"LS+DE", "LS+DE"}, RegexCase{"L[SD]{2,3}E", "L[SD]{2,3}E"}, RegexCase{"L[S|D]E", "L[SD]E"},
        RegexCase{"L[S|D]*E", "L[SD]*E"}, RegexCase{"L[S+|D]DE", "L(S+|D)DE"},
        RegexCase{"[LS|LD]S*E", "L(S|D)S*E"}, RegexCase{"L[^S]*E", "L[DV]*E"}, RegexCase{"L[^SD]+E", "LV+E"},
        RegexCase{"L(SD)*E", "L(SD)*E"}, RegexCase{"L(SD?)+E", "L(SD?)+E"}, RegexCase{"L.{3}E", "L[SDV]{3}E"},
        RegexCase{"L.{4,}E", "L[SDV]{4,}E"}, RegexCase{"L(D{2}|S{3}){1,2}E", "L(D{2}|S{3}){1,2}E"},
        RegexCase{"L.*SDS.*E", "L[SDV]*SDS[SDV]*E"}, RegexCase{"L.*D.{3}E", "L[SDV]*D[SDV]{3}E"},
        RegexCase{"L.{3}D.*E", "L[SDV]{3}D[SDV]*E"}, RegexCase{"L S* ( D | V ) S* E", "LS*[DV]S*E"},
        RegexCase{"L(S|D)*(S|D)DS*E", "L[SD]*[SD]DS*E"}, RegexCase{"LD{0}SE", "LSE"},
        RegexCase{"L(D{1,2}S){2,}E", "L(D{1,2}S){2,}E"}, RegexCase{"LE|LDE|LS+E", "L(D|S+)?E"},
        RegexCase{"L((S|D)(S|D))*E", "L([SD][SD])*E"}, RegexCase{"L[[S|D]V|V[S|D]]+E", "L([SD]V|V[SD])+E"},
        RegexCase{".?LS?D?V?E", "LS?D?V?E"}, RegexCase{"[SDVLE]{2,5}", "L[SDV]{0,3}E"},
        RegexCase{"(L|D)(D|S)+E?", "(?!x)L[DS]+E"}, RegexCase{"L(DD|SS|DV?S)*E", "L(DD|SS|DV?S)*E"},
        RegexCase{"all - L.*S.*E", "L[DV]*E"},
        RegexCase{"L.*S.*E & L.*D.*E", "L(?=[SDV]*S)(?=[SDV]*D)[SDV]*E"},
        RegexCase{"!L.*SS.*E", "L(?![SDV]*SS)[SDV]*E"}, RegexCase{"!!LDE", "LDE"},
        RegexCase{"surface & !caustic - emitted", "(?!LS+DS*E)(?!LE)L[SD]*E"},
        RegexCase{"L((.* - S*) & [DS]*)E", "L[SD]*D[SD]*E"}, RegexCase{"L([SD]+ - S+)E", "L(?!S+E)[SD]+E"},
        RegexCase{"L(.{2} & (D.|.D) - DD)E", "L(D[SV]|[SV]D)E"}));

TEST(PathExpression, NamedClassesMeanWhatTheirTableSays) {
  for (const NamedPathClass& c : namedPathClasses()) {
    EXPECT_TRUE(PathAutomaton::compile(c.name).equivalent(PathAutomaton::compile(c.expression))) << c.name;
    EXPECT_EQ(c.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz"), std::string::npos) << c.name;
    EXPECT_FALSE(c.meaning.empty());
    EXPECT_NE(namedClassesText().find(c.name + " "), std::string::npos);
  }
  const PathAutomaton surface = PathAutomaton::compile("surface"), all = PathAutomaton::compile("all");
  EXPECT_TRUE(surface.unite(PathAutomaton::compile("medium")).equivalent(all));
  EXPECT_TRUE(PathAutomaton::compile("emitted | direct | indirect | LVE").equivalent(all));
}

TEST(PathExpression, WordsThatAreNoPathsAreInNoClass) {
  const PathAutomaton all = PathAutomaton::compile("[SDVLE]*");
  EXPECT_TRUE(all.equivalent(PathAutomaton::compile("all")));
  for (const char* word : {"", "L", "E", "LS", "SE", "LLE", "LEE", "LSLE", "ELDE", "LxE", "lde"})
    EXPECT_FALSE(all.accepts(word)) << word;
}

// --- Random expressions, against a direct evaluation
// -------------------------------------------------------------

/** Model of a random expression without automata: the set of words of up to 7 events as bits. Fragments are
 * relations: for each word, the substrings [i, j) that they match. */
struct Tree {
  enum Kind { LETTERS, SEQUENCE, ALTERNATIVES, REPEAT } kind = LETTERS;
  std::string letters; ///< LETTERS: the alternatives
  std::vector<Tree> parts;
  int least = 0, most = 0; ///< REPEAT; most -1 for unbounded

  std::string text() const {
    std::string out;
    switch (kind) {
    case LETTERS:
      return letters.size() == 1 ? letters : letters.size() == 3 ? "." : "[" + letters + "]";
    case SEQUENCE:
      for (const Tree& p : parts) out += p.text();
      return out.size() > 1 ? "(" + out + ")" : out;
    case ALTERNATIVES: {
      for (const Tree& p : parts) out += (out.empty() ? "" : "|") + p.text();
      return out.size() % 2 ? "(" + out + ")" : "[" + out + "]";
    }
    case REPEAT:
      out = "(" + parts[0].text() + ")";
      if (most < 0) return out + (least == 0 ? "*" : least == 1 ? "+" : "{" + std::to_string(least) + ",}");
      if (least == 0 && most == 1) return out + "?";
      return out + "{" + std::to_string(least) + "," + std::to_string(most) + "}";
    }
    return out;
  }

  using Ends = uint32_t; ///< bit j: a match may end before letter j
  /** Ends of all matches that begin at the `begins`. */
  Ends match(const std::string& word, Ends begins) const {
    Ends ends = 0;
    switch (kind) {
    case LETTERS:
      for (size_t i = 0; i < word.size(); ++i)
        if ((begins >> i & 1u) && letters.find(word[i]) != std::string::npos) ends |= 2u << i;
      return ends;
    case SEQUENCE:
      for (const Tree& p : parts) begins = p.match(word, begins);
      return begins;
    case ALTERNATIVES:
      for (const Tree& p : parts) ends |= p.match(word, begins);
      return ends;
    case REPEAT:
      if (least == 0) ends = begins;
      for (int n = 1; n <= (most < 0 ? least + 12 : most); ++n) {
        begins = parts[0].match(word, begins);
        if (n >= least) ends |= begins;
      }
      return ends;
    }
    return ends;
  }
};

/** Set operations over the interiors of paths. */
struct ClassTree {
  enum Kind { PATHS, NOT, AND, MINUS, OR } kind = PATHS;
  Tree interior;
  std::vector<ClassTree> parts;

  std::string text() const {
    switch (kind) {
    case PATHS:
      return "L" + interior.text() + "E";
    case NOT:
      return "!(" + parts[0].text() + ")";
    case AND:
      return "(" + parts[0].text() + ") & (" + parts[1].text() + ")";
    case MINUS:
      return "(" + parts[0].text() + ")-(" + parts[1].text() + ")";
    case OR:
      return "[(" + parts[0].text() + ") | (" + parts[1].text() + ")]";
    }
    return {};
  }
  bool contains(const std::string& events) const {
    switch (kind) {
    case PATHS:
      return interior.match(events, 1u) >> events.size() & 1u;
    case NOT:
      return !parts[0].contains(events);
    case AND:
      return parts[0].contains(events) && parts[1].contains(events);
    case MINUS:
      return parts[0].contains(events) && !parts[1].contains(events);
    case OR:
      return parts[0].contains(events) || parts[1].contains(events);
    }
    return false;
  }
};

class Grower {
 public:
  explicit Grower(uint32_t seed) : random(seed) {}
  size_t below(size_t n) { return random() % n; }

  Tree tree(size_t depth) {
    static const std::vector<std::string> SETS = {"S", "D", "V", "SD", "DV", "SV", "SDV"};
    Tree t;
    t.kind = depth == 0 ? Tree::LETTERS : static_cast<Tree::Kind>(below(4));
    if (t.kind == Tree::LETTERS) {
      t.letters = SETS[below(SETS.size())];
      return t;
    }
    const size_t count = t.kind == Tree::REPEAT ? 1 : 2 + below(2);
    for (size_t i = 0; i < count; ++i) t.parts.push_back(tree(depth - 1));
    t.least = static_cast<int>(below(3));
    t.most = below(2) ? -1 : t.least + static_cast<int>(below(3));
    return t;
  }
  ClassTree classTree(size_t depth) {
    ClassTree t;
    t.kind = depth == 0 ? ClassTree::PATHS : static_cast<ClassTree::Kind>(below(5));
    if (t.kind == ClassTree::PATHS) {
      t.interior = tree(3);
      return t;
    }
    for (size_t i = 0; i < (t.kind == ClassTree::NOT ? 1u : 2u); ++i) t.parts.push_back(classTree(depth - 1));
    return t;
  }

 private:
  std::mt19937 random;
};

TEST(PathExpression, RandomExpressionsMeanWhatTheirTreesMean) {
  size_t joinedClasses = 0;
  for (uint32_t seed = 0; seed < 400; ++seed) {
    const ClassTree tree = Grower(seed).classTree(3);
    const std::string text = tree.text();
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + text);
    const PathAutomaton automaton = PathAutomaton::compile(text, PathAutomaton::Empty::ALLOWED);
    std::unique_ptr<PathClasses> classes;
    try {
      classes =
          std::make_unique<PathClasses>(std::vector<PathClass>{{"tree", text}, {"other", "!(" + text + ")"}});
      ++joinedClasses;
    } catch (const Error&) {
      // no path, every path, or too large: all of these are valid results
    }
    size_t wrong = 0;
    forAllWords(7, [&](const std::string& events) {
      const bool expected = tree.contains(events);
      wrong += automaton.accepts("L" + events + "E") != expected;
      if (classes) wrong += !joinsGive(*classes, events, expected ? 1 : 2);
    });
    EXPECT_EQ(wrong, 0u);
    const std::string expression = automaton.toExpression(300);
    if (!expression.empty()) {
      EXPECT_TRUE(PathAutomaton::compile(expression).equivalent(automaton)) << expression;
    }
  }
  EXPECT_GT(joinedClasses, 200u);
}

// --- The algebra
// -------------------------------------------------------------------------------------------------

TEST(PathAutomaton, SetsObeyTheLawsOfSets) {
  const auto same = [](const PathAutomaton& a, const PathAutomaton& b) { return a.equivalent(b); };
  for (uint32_t seed = 0; seed < 60; ++seed) {
    Grower grower(seed + 1000);
    const auto random = [&] {
      return PathAutomaton::compile(grower.classTree(1).text(), PathAutomaton::Empty::ALLOWED);
    };
    const PathAutomaton a = random(), b = random(), c = random();
    SCOPED_TRACE(seed);
    EXPECT_TRUE(same(a.complement().complement(), a));
    EXPECT_TRUE(same(a.unite(b).complement(), a.complement().intersect(b.complement())));
    EXPECT_TRUE(same(a.difference(b), a.intersect(b.complement())));
    EXPECT_TRUE(same(a.intersect(b.unite(c)), a.intersect(b).unite(a.intersect(c))));
    EXPECT_TRUE(a.intersect(b).subsetOf(a));
    EXPECT_TRUE(a.difference(a).isEmpty());
    EXPECT_EQ(a.subsetOf(b) && b.subsetOf(a), same(a, b));
    EXPECT_EQ(a.shortestWord().empty(), a.isEmpty());
    EXPECT_EQ(a.accepts(a.shortestWord()), !a.isEmpty());
    for (const std::string& word : a.exampleWords(5, 3)) EXPECT_TRUE(a.accepts(word)) << word;
  }
}

TEST(PathAutomaton, IsTheSmallest) {
  EXPECT_EQ(PathAutomaton::compile("all").stateCount(), 4u);   // start, interior, end, dead
  EXPECT_EQ(PathAutomaton::compile("LS+DE").stateCount(), 6u); // start, L, S, D, end, dead
  EXPECT_TRUE(PathAutomaton::compile("L(S|D)*DS+E").equivalent(PathAutomaton::compile("LS*D([SD]*D)?S+E")));
  EXPECT_TRUE(PathAutomaton::compile("L(S*D*)*E").equivalent(PathAutomaton::compile("surface")));
  EXPECT_FALSE(PathAutomaton::compile("LS+E").equivalent(PathAutomaton::compile("LS*E")));
}

TEST(PathAutomaton, SetsWithNamesCompiledApartAreNotCompared) {
  const PathAutomaton a = PathAutomaton::compile("L'a'.*E"), b = PathAutomaton::compile("L'b'.*E");
  EXPECT_THROW(a.equivalent(b), std::logic_error);
  EXPECT_THROW(a.subsetOf(b), std::logic_error);
  EXPECT_THROW(a.unite(b), std::logic_error);
  EXPECT_TRUE(a.equivalent(a));
  EXPECT_FALSE(a.equivalent(PathAutomaton::compile("all")));
  EXPECT_TRUE(a.unite(a.complement()).equivalent(PathAutomaton::compile("all")));
  const std::vector<PathAutomaton> together = PathAutomaton::compileAll({{"a", "L'a'.*E"}, {"b", "L'b'.*E"}});
  EXPECT_FALSE(together[0].equivalent(together[1]));
}

TEST(PathAutomaton, ExamplesOfEachLengthPutPathsWithoutMediaFirst) {
  EXPECT_EQ(PathAutomaton::compile("all").exampleWords(2, 5),
            (std::vector<std::string>{"LE", "LSE", "LDE", "LVE", "LSSE", "LSDE", "LDSE", "LDDE", "LSVE"}));
  EXPECT_EQ(PathAutomaton::compile("LS{300}E").shortestWord(), "L" + std::string(300, 'S') + "E");
}

TEST(PathAutomaton, ReadsInWords) {
  EXPECT_EQ(PathAutomaton::compile("LS+DE").describe(), "  start: L to 2\n"
                                                        "  state 2: S to 3\n"
                                                        "  state 3: S stays; D to 4\n"
                                                        "  state 4: E ends the path\n");
  EXPECT_EQ(PathAutomaton::compile("LDE & LSE", PathAutomaton::Empty::ALLOWED).describe(), "  no path\n");
  EXPECT_LT(PathAutomaton::compile("LS{1000}E").describe().size(), 2000u);
  EXPECT_EQ(PathAutomaton::compile("L(D|S)DS{2}S*E").toExpression(), "L[SD]DSS+E");
  EXPECT_EQ(PathAutomaton::compile("emitted").toExpression(), "LE");
}

// --- Precedence and errors
// ---------------------------------------------------------------------------------------

TEST(PathExpression, Precedence) {
  const auto same = [](const char* a, const char* b) {
    return PathAutomaton::compile(a).equivalent(PathAutomaton::compile(b));
  };
  EXPECT_TRUE(same("LSE|LDE & L.E", "(LSE) | (LDE & L.E)"));
  EXPECT_TRUE(same("!LSE & surface", "(!LSE) & surface"));
  EXPECT_TRUE(same("!LSE | LSE", "all"));
  EXPECT_TRUE(same("all - emitted - direct", "(all - emitted) - direct"));
  EXPECT_TRUE(same("all - surface & indirect", "(all - surface) & indirect"));
  EXPECT_TRUE(same("LSD*E", "LS(D*)E"));
}

struct ErrorCase {
  std::string expression;
  size_t column;
  std::string says;
};

void PrintTo(const ErrorCase& c, std::ostream* out) { *out << c.expression; }

class PathExpressionError : public ::testing::TestWithParam<ErrorCase> {};

TEST_P(PathExpressionError, PointsAtTheColumn) {
  const auto& [expression, column, says] = GetParam();
  try {
    PathAutomaton::compile(expression);
    FAIL() << expression << " compiles";
  } catch (const Error& e) {
    const std::string what = e.what();
    EXPECT_EQ(e.status(), ExitStatus::BAD_USAGE);
    EXPECT_NE(what.find("column " + std::to_string(column) + ": "), std::string::npos) << what;
    EXPECT_NE(what.find("\n  " + std::string(column - 1, ' ') + "^"), std::string::npos) << what;
    EXPECT_NE(what.find(says), std::string::npos) << what;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Errors, PathExpressionError,
    ::testing::Values(
        ErrorCase{"", 1, "ends too early"}, ErrorCase{"LDE|", 5, "ends too early"},
        ErrorCase{"LDE - ", 7, "ends too early"}, ErrorCase{"L(SDE", 2, "no matching ')'"},
        ErrorCase{"L[S|DE", 2, "no matching ']'"}, ErrorCase{"L[^SDE", 2, "no matching ']'"},
        ErrorCase{"LDE)", 4, "has no matching bracket"},
        ErrorCase{"L()E", 3, "an empty expression before it"},
        ErrorCase{"L(S]E", 4, "has no matching bracket"}, ErrorCase{"L[]E", 2, "no letter"},
        ErrorCase{"L[^]E", 2, "no letter"}, ErrorCase{"L[^SDV]E", 2, "none of S, D and V"},
        ErrorCase{"L[SD+]E", 2, "alternatives with a bar"}, ErrorCase{"L[^S|D]E", 5, "only letters"},
        ErrorCase{"LE|*E", 4, "nothing to repeat"}, ErrorCase{"+", 1, "nothing to repeat"},
        ErrorCase{"LS+?E", 4, "needs parentheses"}, ErrorCase{"LS{2E", 5, "not closed"},
        ErrorCase{"LS{}E", 4, "number is missing"}, ErrorCase{"LS{,2}E", 4, "number is missing"},
        ErrorCase{"LS{3,2}E", 3, "below"}, ErrorCase{"LS}E", 3, "without '{'"},
        ErrorCase{"LS{99999999999999999999}E", 4, "at most 1000"}, ErrorCase{"L!SE", 2, "whole"},
        ErrorCase{"^LE$", 1, "not needed"}, ErrorCase{"LXE", 2, "no path letter"},
        ErrorCase{"lde", 1, "upper case"}, ErrorCase{"LE | coustic", 6, "is it 'caustic'?"},
        ErrorCase{"L direct", 3, "cannot be part"}, ErrorCase{"direct+", 1, "cannot be repeated"},
        ErrorCase{"L(!LE)E", 2, "cannot be part"}, ErrorCase{"L#E", 2, "'#' has no meaning"},
        ErrorCase{"LS\xE2\x88\xAA"
                  "DE",
                  3, "'\xE2\x88\xAA'"},
        ErrorCase{"(LDE|LSE)\t& L\xC3\xA9", 14, "'\xC3\xA9'"}, ErrorCase{"|LE", 1, "nothing on one side"},
        ErrorCase{"LDE & & LSE", 7, "nothing on one side"}, ErrorCase{"LDS", 1, "no path matches"},
        ErrorCase{"DSE", 1, "no path matches"}, ErrorCase{"LDE & LSE", 1, "no path matches"},
        ErrorCase{"!all", 1, "no path matches"}, ErrorCase{"LDE | LS", 7, "no path matches"},
        ErrorCase{"all - DS", 7, "no path matches"}, ErrorCase{"all - LDE | LSE", 11, "two ways"},
        ErrorCase{"LE | all - LDE", 4, "two ways"}, ErrorCase{"L(S{1000}){1000}E", 2, "states"},
        ErrorCase{"L((S?){1000}){50}E", 2, "work"}, ErrorCase{"L.*S.{16}E", 1, "states"}));

TEST(PathExpression, NothingHangsOrOverflows) {
  const double started = processorSeconds();
  const auto fails = [](const std::string& expression) {
    EXPECT_THROW(PathAutomaton::compile(expression), Error) << expression.substr(0, 40);
  };
  fails(std::string(1'000'000, '('));
  fails(std::string(4000, '('));
  fails(std::string(4000, '['));
  fails("L" + std::string(101, '(') + "S" + std::string(101, ')') + "E");
  fails(std::string(4001, '!') + "all");
  fails(std::string("L\0E", 3));
  std::string nested = "S?";
  for (int i = 0; i < 20; ++i) nested = "(" + nested + "){0,30}";
  fails("L" + nested + "E");

  EXPECT_NO_THROW(PathAutomaton::compile("L" + std::string(100, '(') + "S" + std::string(100, ')') + "E"));
  EXPECT_NO_THROW(PathAutomaton::compile(std::string(4000, '!') + "all"));
  EXPECT_NO_THROW(PathAutomaton::compile("L" + std::string(4000, 'S') + "E"));
  EXPECT_NO_THROW(PathAutomaton::compile("LS{1000}D{0,1000}E"));
  nested = "S*";
  for (int i = 0; i < 20; ++i) nested = "(" + nested + "){1000}";
  EXPECT_NO_THROW(PathAutomaton::compile("L" + nested + "E"));
  EXPECT_LT(processorSeconds() - started, 60); // sanitizers included
}

TEST(PathExpression, AnyTextEitherCompilesOrIsAnError) {
  constexpr std::string_view ALPHABET = "LSDVELSDVE.?*+{}()[]|&-!^,0123 all";
  std::mt19937 random(7);
  size_t compiled = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text;
    for (size_t n = random() % 12; n > 0; --n) text += ALPHABET[random() % ALPHABET.size()];
    try {
      PathAutomaton::compile(text, PathAutomaton::Empty::ALLOWED);
      ++compiled;
    } catch (const Error& e) {
      EXPECT_EQ(e.status(), ExitStatus::BAD_USAGE);
    }
  }
  EXPECT_GT(compiled, 100u);
}

// --- Several classes
// ---------------------------------------------------------------------------------------------

/** For every word up to 8 events and every cut, the join gives exactly the classes whose own automata accept
 * the word. */
void expectJoins(const std::vector<PathClass>& list) {
  const PathClasses classes(list);
  std::vector<PathAutomaton> automata;
  for (const PathClass& c : list) automata.push_back(PathAutomaton::compile(c.expression));
  size_t wrong = 0;
  forAllWords(8, [&](const std::string& events) {
    LayerMask expected = 0;
    for (size_t c = 0; c < automata.size(); ++c)
      if (automata[c].accepts("L" + events + "E")) expected |= LayerMask(1) << c;
    wrong += !joinsGive(classes, events, expected);
  });
  EXPECT_EQ(wrong, 0u);
}

TEST(PathClasses, ManyAtOnce) {
  expectJoins(defaultStillClasses());
  expectJoins(defaultStillClasses(true));
  std::vector<PathClass> named;
  for (const NamedPathClass& c : namedPathClasses()) named.push_back({c.name, c.name});
  expectJoins(named);
  std::vector<PathClass> lengths;
  for (int n = 0; n < 64; ++n) {
    const std::string count = std::to_string(n);
    lengths.push_back({count, std::string("L.{") + count + "}E"});
  }
  expectJoins(lengths);
  expectJoins({{"a", "L.*S.{3}E"}, {"b", "L.{3}S.*E"}, {"c", "L.*VD+E"}});
}

TEST(PathClasses, TheDefaultIsEveryPathInOneState) {
  const PathClasses all;
  ASSERT_EQ(all.layerCount(), 1u);
  EXPECT_EQ(all.classes()[0].name, "all");
  EXPECT_EQ(all.lightStateCount(), 1u);
  EXPECT_EQ(all.cameraStateCount(), 1u);
  EXPECT_FALSE(all.dead(all.lightStart()));
  EXPECT_FALSE(all.dead(all.cameraStart()));
  forAllWords(4, [&](const std::string& events) { EXPECT_TRUE(joinsGive(all, events, 1)) << events; });
}

TEST(PathClasses, WalksThatCannotCompleteAreDead) {
  const PathClasses classes = onlyClass("LS+DE");
  const LightState s = classes.step(classes.lightStart(), PathEvent::S);
  const LightState sd = classes.step(s, PathEvent::D);
  EXPECT_FALSE(classes.dead(sd));
  EXPECT_TRUE(classes.dead(classes.step(sd, PathEvent::D)));
  EXPECT_TRUE(classes.dead(classes.step(classes.lightStart(), PathEvent::D)));
  EXPECT_TRUE(classes.dead(classes.step(classes.cameraStart(), PathEvent::S)));
  const CameraState d = classes.step(classes.cameraStart(), PathEvent::D);
  EXPECT_FALSE(classes.dead(d));
  EXPECT_TRUE(classes.dead(classes.step(d, PathEvent::V)));
  EXPECT_EQ(classes.join(s, d), 1u);
  EXPECT_EQ(classes.join(sd, d), 0u);
}

TEST(PathClasses, EquivalentStatesAreMerged) {
  // Each class alone needs to count; their union does not.
  EXPECT_EQ(onlyClass("L.{0,30}E | L.{31,}E").lightStateCount(), 1u);
  EXPECT_EQ(onlyClass("L(.{3})*E").lightStateCount(), 3u);
  EXPECT_EQ(onlyClass("L(.{3})*E").cameraStateCount(), 3u);
}

TEST(PathClasses, LimitsAreErrorsThatSayWhatToDo) {
  const auto says = [](std::vector<PathClass> classes, const std::string& expected) {
    try {
      PathClasses compiled(std::move(classes));
      ADD_FAILURE() << "no error: " << expected;
    } catch (const Error& e) {
      EXPECT_EQ(e.status(), ExitStatus::BAD_USAGE);
      EXPECT_NE(std::string(e.what()).find(expected), std::string::npos) << e.what();
    }
  };
  says({}, "no path class");
  says({{"a", "LE"}, {"a", "LDE"}}, "two path classes are called 'a'");
  says({{"", "LE"}}, "no name");
  says({{"good", "LE"}, {"bad", "LD"}}, "class 'bad': path expression, column 1");
  says({{"few", "LE"}, {"long", "LS{300}E"}}, "more than 255 states");
  says({{"few", "LE"}, {"long", "LS{300}E"}}, "the largest is 'long'");
  says({{"a", "L.{17}S.*E"}}, "more than 65535 states on the side of the camera");
  says(std::vector<PathClass>(65, {"a", "LE"}), "at most 64");
}

TEST(PathClasses, DefaultStillsAreDisjointAndComplete) {
  for (const bool media : {false, true}) {
    const ClassesReport report = analyseClasses(defaultStillClasses(media));
    EXPECT_TRUE(report.overlaps.empty());
    EXPECT_TRUE(report.leftOver.isEmpty());
    for (const auto& e : report.entries) EXPECT_FALSE(e.examples.empty()) << e.pathClass.name;
    const PathClasses classes(defaultStillClasses(media));
    forAllWords(6, [&](const std::string& events) {
      LightState s = classes.lightStart();
      for (const char c : events) s = classes.step(s, eventOf(c));
      const LayerMask mask = classes.join(s, classes.cameraStart());
      EXPECT_TRUE(mask != 0 && (mask & (mask - 1)) == 0) << events;
    });
  }
}

TEST(PathClasses, StillsOfMediaLeaveNothingOfThemOver) {
  // The layers of surfaces are the same, and the remainder has no V.
  const std::vector<PathClass> surfaces = defaultStillClasses(), media = defaultStillClasses(true);
  for (size_t i = 0; i + 1 < surfaces.size(); ++i) EXPECT_EQ(media[i].expression, surfaces[i].expression);
  EXPECT_TRUE(PathAutomaton::compile(media.back().expression).subsetOf(PathAutomaton::compile("surface")));
}

// --- Domains and reports
// -----------------------------------------------------------------------------------------

TEST(EstimatorDomains, TheExampleOfTheDesignIsSound) {
  const std::vector<EstimatorDomain> domains = {{"emission", "LS*E", "a look-up", ""},
                                                {"shadow rays", "LDS*E", "a ray for each hit", ""},
                                                {"photons", "L(S|D)*(S|D)DS*E", "a gather for each hit", ""}};
  const DomainReport report = checkDomains(domains, "surface");
  EXPECT_TRUE(report.sound()) << report.text();
  EXPECT_EQ(report.text(), "");
  EXPECT_NE(formatDomains(domains).find("shadow rays  LDS*E"), std::string::npos);
}

TEST(EstimatorDomains, FindsOverlapsUnlessSharedAndWhatIsLeftOut) {
  std::vector<EstimatorDomain> domains = {
      {"emission", "LS*E", "", ""}, {"shadow rays", "LDS*E", "", ""}, {"hits", "L[SD]S*E", "", ""}};
  DomainReport report = checkDomains(domains, "surface");
  ASSERT_EQ(report.overlaps.size(), 2u);
  EXPECT_EQ(report.overlaps[0].example, "LSE");
  EXPECT_EQ(report.overlaps[1].first, "shadow rays");
  EXPECT_EQ(report.overlaps[1].second, "hits");
  EXPECT_EQ(report.overlaps[1].example, "LDE");
  EXPECT_EQ(report.uncovered.front(), "LSDE");
  EXPECT_NE(report.text().find("no estimator computes LSDE"), std::string::npos);
  EXPECT_TRUE(PathAutomaton::compile(report.uncoveredExpression)
                  .equivalent(PathAutomaton::compile("surface - L[SD]?S*E")));

  domains[1].sharedGroup = domains[2].sharedGroup = "direct light";
  report = checkDomains(domains, "L[SD]?S*E");
  ASSERT_EQ(report.overlaps.size(), 1u);
  EXPECT_EQ(report.overlaps[0].first, "emission");
  EXPECT_TRUE(report.uncovered.empty());
  EXPECT_FALSE(checkDomains({{"long", "L.{0,9}E", "", ""}}).sound());

  try {
    checkDomains({{"hits", "L(", "", ""}});
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("domain of hits"), std::string::npos);
  }
}

TEST(ClassesReport, TellsOverlapsAndWhatIsLeftOver) {
  const std::string text =
      analyseClasses({{"emitted", "emitted"}, {"mirror", "LS*E"}, {"LDE & LSE", "LDE & LSE"}}).text();
  for (const char* expected :
       {"emitted: LE, lights seen directly\n", "mirror = LS*E\n", "  0 events: LE\n", "  1 event:  LSE\n",
        "LDE & LSE\n  no path matches this\n", "not disjoint: LE is in emitted and in mirror\n",
        "not complete: missing are LS*[DV].*E\n  1 event:  LDE LVE\n",
        "not to be rendered: class 'LDE & LSE'"})
    EXPECT_NE(text.find(expected), std::string::npos) << expected << "\nnot in\n" << text;
  const std::string both = analyseClasses({{"a", "surface"}, {"b", "medium"}}).text();
  EXPECT_NE(
      both.find("disjoint: no path is in two of these\ncomplete: every path is in one of these\n"
                "rendered at once with 2 states on the side of the light and 2 on the side of the camera\n"),
      std::string::npos)
      << both;
}

} // namespace
} // namespace recurse
