/** @file
 * Algebra of finite automata, private to path expressions and path classes: these automata accept arbitrary
 * words over an alphabet, of which paths are a subset.
 */
#pragma once

#include <cstdint>
#include <vector>

#include "pathclasses/pathAlphabet.h"
#include "recurse/core/io/error.h"

namespace recurse {

/** Minimal, complete automaton; states in breadth-first order from 0. Equal languages have equal Dfas. */
struct Dfa {
  size_t letters = PATH_LETTERS;
  std::vector<uint32_t> next; ///< `letters` entries for each state
  std::vector<uint8_t> accepting;

  size_t size() const { return accepting.size(); }
  uint32_t target(size_t state, size_t letter) const { return next[state * letters + letter]; }
  /** True where no word completes from this state. */
  bool dead(uint32_t state) const;
  bool operator==(const Dfa&) const = default;
};

/** Thrown when an automaton exceeds the maximum size. */
class AutomatonTooLarge : public Error {
 public:
  explicit AutomatonTooLarge(const std::string& message) : Error(message, ExitStatus::BAD_USAGE) {}
};

/** Limit of the total work of a compilation, so that no expression, however nested, takes seconds. */
class Effort {
 public:
  void spend(size_t steps);

 private:
  size_t left = 20'000'000;
};

constexpr size_t UNBOUNDED = static_cast<size_t>(-1);

/** Words of one letter out of a set, in an alphabet of `size` letters. */
Dfa oneLetter(const LetterSet& letters, size_t size);
/** `parts` must not be empty, here and in alternation(). */
Dfa concatenation(const std::vector<Dfa>& parts, Effort& effort);
Dfa alternation(const std::vector<Dfa>& parts, Effort& effort);
Dfa repetition(const Dfa& part, size_t least, size_t most, Effort& effort);

enum class SetOperation { AND, OR, AND_NOT };
Dfa combination(const Dfa& a, const Dfa& b, SetOperation operation, Effort& effort);

/** All words L(S|D|V)*E. */
Dfa allPaths(const PathAlphabet& alphabet);
/** The same words where lights and surfaces have names, of an automaton for the five letters alone. */
Dfa withNames(const Dfa& dfa, const PathAlphabet& alphabet);

/**
 * Coarsest partition of the states of a complete automaton that is consistent with `colours` and all
 * transitions (Hopcroft 1971): the block of each state. `next` has `letters` entries for each state.
 */
std::vector<uint32_t> coarsestPartition(const std::vector<uint32_t>& next, size_t letters,
                                        const std::vector<uint64_t>& colours);

} // namespace recurse
