/** @file
 * Algebra of finite automata, private to path expressions and path classes: these automata accept arbitrary
 * words over the five letters, of which paths are a subset.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "recurse/core/io/error.h"

namespace recurse {

constexpr size_t PATH_LETTERS = 5;
constexpr size_t PATH_EVENTS = 3;

/** Minimal, complete automaton; states in breadth-first order from 0. Equal languages have equal Dfas. */
struct Dfa {
  std::vector<std::array<uint32_t, PATH_LETTERS>> next;
  std::vector<uint8_t> accepting;

  size_t size() const { return accepting.size(); }
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

/** Words of one letter, any of the letters whose bits are set. */
Dfa oneLetter(uint32_t letters);
Dfa concatenation(const std::vector<Dfa>& parts, Effort& effort);
Dfa alternation(const std::vector<Dfa>& parts, Effort& effort);
Dfa repetition(const Dfa& part, size_t least, size_t most, Effort& effort);

enum class SetOperation { AND, OR, AND_NOT };
Dfa combination(const Dfa& a, const Dfa& b, SetOperation operation, Effort& effort);

/** All words L(S|D|V)*E. */
const Dfa& allPaths();

/**
 * Coarsest partition of the states of a complete automaton that is consistent with `colours` and all
 * transitions (Hopcroft 1971): the block of each state. `next` has `letters` entries for each state.
 */
std::vector<uint32_t> coarsestPartition(const std::vector<uint32_t>& next, size_t letters,
                                        const std::vector<uint64_t>& colours);

} // namespace recurse
