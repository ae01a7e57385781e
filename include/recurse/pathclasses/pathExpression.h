/** @file
 * Path expressions: sets of light paths, compiled to minimal automata. A path is a word: L, then its
 * scattering events in the order of the light's propagation (S, D, V), then E. The notation is defined in
 * doc-files/notes/path-expressions.md.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recurse/pathclasses/pathEvent.h"

namespace recurse {

/** Letters of a path word; the first three are the PathEvents. */
enum class PathLetter : uint8_t { S, D, V, L, E };

struct Dfa;
class PathAlphabet;
struct PathNames;

/** Set of paths, as the unique minimal deterministic automaton that accepts it. Cheap to copy. */
class PathAutomaton {
 public:
  enum class Empty { REFUSED, ALLOWED };

  /** Compiles an expression. Throws Error (BAD_USAGE) with the column. A set without paths is refused unless
   * `empty` allows it. `names`: names of the scene, outside of which none is allowed; null: any name is. */
  static PathAutomaton compile(const std::string& expression, Empty empty = Empty::REFUSED,
                               const PathNames* names = nullptr);
  /** Compiles expressions to be combined: sets with names have letters for the names in all expressions that
   * were compiled with them. Sets without names may be combined with any; two sets with names that were
   * compiled apart throw std::logic_error. */
  static std::vector<PathAutomaton> compileAll(const std::vector<PathClass>& classes,
                                               Empty empty = Empty::REFUSED,
                                               const PathNames* names = nullptr);

  /** Whether the word, such as "LSDE" or "L'lamp'DE", is in the set; false for an invalid word. A letter has
   * the names of its light or surface out of those in the compiled expressions, several sorted by bytes and
   * joined by '+' as in "L'a+b'E"; other names make a word invalid. Words that this class returns have the
   * same form. */
  bool accepts(std::string_view word) const;

  // Set operations throw Error (BAD_USAGE) for a result with too many states.
  PathAutomaton unite(const PathAutomaton& other) const;
  PathAutomaton intersect(const PathAutomaton& other) const;
  PathAutomaton difference(const PathAutomaton& other) const;
  /** All paths L(S|D|V)*E that are not in the set. */
  PathAutomaton complement() const;

  bool isEmpty() const;
  bool equivalent(const PathAutomaton& other) const;
  bool subsetOf(const PathAutomaton& other) const;

  /** Words of the set with up to `maxEvents` events between L and E, shorter ones first; at most
   * `mostPerLength` of each length, words without V first. */
  std::vector<std::string> exampleWords(size_t maxEvents, size_t mostPerLength) const;
  /** One of the shortest words; empty for the empty set. */
  std::string shortestWord() const;
  /** The automaton in words: a line for each state from which a path can still be completed, cut off when
   * there are very many. */
  std::string describe() const;
  /** Equivalent regular expression without ! & -; empty if none of up to `longest` characters was found, or
   * if names occur. */
  std::string toExpression(size_t longest = 100) const;

  // The automaton itself: states are numbered in the order of first visit from `start()`, which is 0.
  size_t stateCount() const;
  uint32_t start() const { return 0; }
  uint32_t next(uint32_t state, PathLetter letter) const { return next(state, size_t(letter)); }
  uint32_t next(uint32_t state, size_t letter) const; ///< by its index in the alphabet
  bool accepting(uint32_t state) const;

 private:
  PathAutomaton(Dfa dfa, std::shared_ptr<const PathAlphabet> alphabet);
  /** Result of a set operation on two sets. */
  template <class Combine> PathAutomaton combined(const PathAutomaton& other, const Combine& combine) const;
  friend class PathClasses;
  std::shared_ptr<const Dfa> dfa;
  std::shared_ptr<const PathAlphabet> alphabet;
};

/** Number of scattering events in a word. */
size_t eventCount(std::string_view word);

/** Two sets with common paths: their indices in the list, and their shortest common path. */
struct PathOverlap {
  size_t first, second;
  std::string example;
};
/** All pairs of sets with common paths. */
std::vector<PathOverlap> findOverlaps(const std::vector<PathAutomaton>& sets);

/** Paths of `whole` that are in none of the sets. */
PathAutomaton leftOver(const PathAutomaton& whole, const std::vector<PathAutomaton>& sets);

/** Class to which expressions can refer by its name. */
struct NamedPathClass {
  std::string name; ///< lower-case letters only, which are never path letters
  std::string expression;
  std::string meaning; ///< one line
};

/** All named classes, the simple ones first. */
const std::vector<NamedPathClass>& namedPathClasses();

/** Default classes of `recurse stills`: disjoint, and together all paths. `withMedia`: paths with scattering
 * in media have classes of their own. */
std::vector<PathClass> defaultStillClasses(bool withMedia = false);

} // namespace recurse
