/** @file
 * Path expressions: which light paths a person means, as a minimised automaton. A path is a word: L, then its
 * scattering events in the order the light meets them (S, D, V), then E. The notation is that of
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

/** The letters of a path word; the first three are the PathEvents. */
enum class PathLetter : uint8_t { S, D, V, L, E };

struct Dfa;

/** A set of paths, as the one smallest deterministic automaton that accepts it. Cheap to copy. */
class PathAutomaton {
 public:
  enum class Empty { REFUSED, ALLOWED };

  /** Throws Error (BAD_USAGE) which points at the column. A class that no path can be in is refused unless
   * `empty` says otherwise. */
  static PathAutomaton compile(const std::string& expression, Empty empty = Empty::REFUSED);

  /** Whether the word, such as "LSDE", is in the set; false for what is no word at all. */
  bool accepts(std::string_view word) const;

  PathAutomaton unite(const PathAutomaton& other) const;
  PathAutomaton intersect(const PathAutomaton& other) const;
  PathAutomaton difference(const PathAutomaton& other) const;
  /** All other paths L(S|D|V)*E. */
  PathAutomaton complement() const;

  bool isEmpty() const;
  bool equivalent(const PathAutomaton& other) const;
  bool subsetOf(const PathAutomaton& other) const;

  /** Words of the set with up to `maxEvents` events between L and E, the shorter first, at most
   * `mostPerLength` of each length, those without V first. */
  std::vector<std::string> exampleWords(size_t maxEvents, size_t mostPerLength) const;
  /** One of the shortest words; empty when the set is. */
  std::string shortestWord() const;
  /** The automaton in words, a line for each state from which a path can still be completed, cut off
   *  when there are very many. */
  std::string describe() const;
  /** An expression of the set, free of set operations; empty when none of up to `longest` characters was
   * found. */
  std::string toExpression(size_t longest = 100) const;

  // The automaton itself. States are numbered in the order of first visit from `start()`, which is 0.
  size_t stateCount() const;
  uint32_t start() const { return 0; }
  uint32_t next(uint32_t state, PathLetter letter) const;
  bool accepting(uint32_t state) const;

 private:
  explicit PathAutomaton(Dfa dfa);
  std::shared_ptr<const Dfa> dfa;
};

/** Two sets that share paths: their places in the list, and the shortest path of both. */
struct PathOverlap {
  size_t first, second;
  std::string example;
};
std::vector<PathOverlap> findOverlaps(const std::vector<PathAutomaton>& sets);

/** What of `whole` none of the sets has. */
PathAutomaton leftOver(const PathAutomaton& whole, const std::vector<PathAutomaton>& sets);

/** A class that expressions can refer to by its name. */
struct NamedPathClass {
  std::string name; ///< lower-case letters only, so that it is never taken for path letters
  std::string expression;
  std::string meaning; ///< in one line
};

/** All named classes, the simple ones first. */
const std::vector<NamedPathClass>& namedPathClasses();

/** The classes of `recurse stills` unless others are asked for: disjoint, and together every path.
 * `withMedia`: paths that media scatter are told apart too. */
std::vector<PathClass> defaultStillClasses(bool withMedia = false);

} // namespace recurse
