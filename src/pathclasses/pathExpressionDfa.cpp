/** @file
 * Algebra of finite automata. Every operation makes a small non-deterministic or product automaton,
 * determinises it and minimises it at once, so that sizes are bounded by the languages.
 */
#include "pathclasses/pathExpressionDfa.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace recurse {

namespace {

constexpr size_t MAX_STATES = 20'000;

struct HashStates {
  size_t operator()(const std::vector<uint32_t>& states) const {
    uint64_t h = 0xcbf29ce484222325u;
    for (const uint32_t s : states) h = (h ^ s) * 0x100000001b3u;
    return h ^ (h >> 32);
  }
};

/** Minimal automaton of a deterministic, complete and reachable one. */
Dfa minimised(const Dfa& dfa) {
  const std::vector<uint64_t> colours(dfa.accepting.begin(), dfa.accepting.end());
  const std::vector<uint32_t> block = coarsestPartition(dfa.next, dfa.letters, colours);

  // Breadth-first order makes the numbering depend only on the language.
  std::vector<uint32_t> number(dfa.size(), UINT32_MAX);
  std::vector<uint32_t> order;
  const auto visit = [&](uint32_t state) {
    uint32_t& n = number[block[state]];
    if (n == UINT32_MAX) {
      n = static_cast<uint32_t>(order.size());
      order.push_back(state);
    }
    return n;
  };
  visit(0);
  Dfa out;
  out.letters = dfa.letters;
  for (size_t i = 0; i < order.size(); ++i) {
    const uint32_t state = order[i];
    out.accepting.push_back(dfa.accepting[state]);
    for (size_t a = 0; a < dfa.letters; ++a) out.next.push_back(visit(dfa.target(state, a)));
  }
  return out;
}

/** Non-deterministic automaton made of deterministic pieces: from each accepting state of a piece, its
 * followers may begin. */
struct Piece {
  const Dfa* dfa;
  bool initial;
  bool mayEnd;
  std::vector<uint32_t> followers;
};

/** Subset construction: states are sets of states of all pieces, which are numbered piece after piece. */
class SubsetConstruction {
 public:
  SubsetConstruction(const std::vector<Piece>& pieces, size_t letters, Effort& effort)
      : pieces(pieces), effort(effort) {
    for (uint32_t p = 0; p < pieces.size(); ++p) {
      offset.push_back(static_cast<uint32_t>(pieceOf.size()));
      effort.spend(pieces[p].dfa->size());
      pieceOf.insert(pieceOf.end(), pieces[p].dfa->size(), p);
    }
    seenIn.resize(pieceOf.size(), 0);
    out.letters = letters;
  }

  /** `acceptsEmpty` adds the empty word. */
  Dfa run(bool acceptsEmpty) {
    // The start is a separate state, since its subset may occur later without the empty word.
    begin();
    for (uint32_t p = 0; p < pieces.size(); ++p)
      if (pieces[p].initial) add(offset[p]);
    std::sort(subset.begin(), subset.end());
    const std::vector<uint32_t> start = subset;
    subsets.push_back(&start);
    out.accepting.push_back(accepting || acceptsEmpty);

    for (size_t s = 0; s < subsets.size(); ++s) {
      const std::vector<uint32_t>& from = *subsets[s];
      for (size_t a = 0; a < out.letters; ++a) {
        effort.spend(from.size() + 1);
        begin();
        for (const uint32_t g : from) {
          const uint32_t base = offset[pieceOf[g]];
          add(base + pieces[pieceOf[g]].dfa->target(g - base, a));
        }
        out.next.push_back(finish());
      }
    }
    return std::move(out);
  }

 private:
  void begin() {
    ++round;
    subset.clear();
    accepting = false;
  }
  /** Adds a state, and if its piece may end there, the initial states of the followers. */
  void add(uint32_t global) {
    pending.push_back(global);
    while (!pending.empty()) {
      const uint32_t g = pending.back();
      pending.pop_back();
      const Piece& piece = pieces[pieceOf[g]];
      const uint32_t local = g - offset[pieceOf[g]];
      if (seenIn[g] == round || piece.dfa->dead(local)) continue;
      seenIn[g] = round;
      subset.push_back(g);
      if (!piece.dfa->accepting[local]) continue;
      accepting = accepting || piece.mayEnd;
      effort.spend(piece.followers.size());
      for (const uint32_t f : piece.followers) pending.push_back(offset[f]);
    }
  }
  /** Index of the subset. */
  uint32_t finish() {
    std::sort(subset.begin(), subset.end());
    const auto [at, fresh] = number.try_emplace(subset, static_cast<uint32_t>(subsets.size()));
    if (fresh) {
      if (subsets.size() >= MAX_STATES)
        throw AutomatonTooLarge("needs more than " + std::to_string(MAX_STATES) + " states");
      subsets.push_back(&at->first); // address is stable: the map never moves its elements
      out.accepting.push_back(accepting);
    }
    return at->second;
  }

  const std::vector<Piece>& pieces;
  Effort& effort;
  std::vector<uint32_t> offset, pieceOf; ///< first state of each piece; piece of each state
  std::vector<uint32_t> seenIn, pending, subset;
  uint32_t round = 0;
  bool accepting = false;
  std::unordered_map<std::vector<uint32_t>, uint32_t, HashStates> number;
  std::vector<const std::vector<uint32_t>*> subsets;
  Dfa out;
};

Dfa determinised(const std::vector<Piece>& pieces, bool acceptsEmpty, size_t letters, Effort& effort) {
  return minimised(SubsetConstruction(pieces, letters, effort).run(acceptsEmpty));
}

} // namespace

void Effort::spend(size_t steps) {
  if (steps > left) throw AutomatonTooLarge("takes too much work to compile");
  left -= steps;
}

bool Dfa::dead(uint32_t state) const {
  const auto first = next.begin() + std::ptrdiff_t(state * letters);
  return !accepting[state] && std::all_of(first, first + std::ptrdiff_t(letters),
                                          [state](uint32_t target) { return target == state; });
}

std::vector<uint32_t> coarsestPartition(const std::vector<uint32_t>& next, size_t letters,
                                        const std::vector<uint64_t>& colours) {
  const auto states = static_cast<uint32_t>(colours.size());
  // Predecessors of each state by each letter, in consecutive ranges.
  std::vector<uint32_t> sourcesBegin(letters * states + 1, 0), sources(letters * states);
  for (uint32_t s = 0; s < states; ++s)
    for (size_t a = 0; a < letters; ++a) ++sourcesBegin[a * states + next[s * letters + a] + 1];
  std::partial_sum(sourcesBegin.begin(), sourcesBegin.end(), sourcesBegin.begin());
  std::vector<uint32_t> fill(sourcesBegin.begin(), sourcesBegin.end() - 1);
  for (uint32_t s = 0; s < states; ++s)
    for (size_t a = 0; a < letters; ++a) sources[fill[a * states + next[s * letters + a]]++] = s;

  // Blocks are ranges of `members`; within each, marked states come first.
  struct Block {
    uint32_t begin, end, marked;
  };
  std::vector<uint32_t> members(states), place(states), blockOf(states);
  std::iota(members.begin(), members.end(), 0u);
  std::stable_sort(members.begin(), members.end(),
                   [&](uint32_t a, uint32_t b) { return colours[a] < colours[b]; });
  std::vector<Block> blocks;
  for (uint32_t i = 0; i < states; ++i) {
    if (i == 0 || colours[members[i]] != colours[members[i - 1]]) blocks.push_back({i, i, 0});
    ++blocks.back().end;
    place[members[i]] = i;
    blockOf[members[i]] = static_cast<uint32_t>(blocks.size()) - 1;
  }

  std::vector<uint32_t> splitters(blocks.size()), touched, splitter;
  std::iota(splitters.begin(), splitters.end(), 0u);
  while (!splitters.empty()) {
    const Block by = blocks[splitters.back()];
    splitters.pop_back();
    splitter.assign(members.begin() + by.begin, members.begin() + by.end); // may itself be split below
    for (size_t a = 0; a < letters; ++a) {
      for (const uint32_t target : splitter) {
        const size_t key = a * states + target;
        for (uint32_t i = sourcesBegin[key]; i < sourcesBegin[key + 1]; ++i) {
          const uint32_t s = sources[i];
          Block& block = blocks[blockOf[s]];
          if (block.marked == 0) touched.push_back(blockOf[s]);
          const uint32_t to = block.begin + block.marked++;
          const uint32_t other = members[to];
          std::swap(members[to], members[place[s]]);
          std::swap(place[other], place[s]);
        }
      }
      for (const uint32_t b : touched) {
        const uint32_t middle = blocks[b].begin + std::exchange(blocks[b].marked, 0u);
        if (middle == blocks[b].end) continue;
        // The smaller part becomes the new block and the new splitter; the larger part keeps its index.
        Block part = {blocks[b].begin, middle, 0};
        if (middle - blocks[b].begin <= blocks[b].end - middle) {
          blocks[b].begin = middle;
        } else {
          part = {middle, blocks[b].end, 0};
          blocks[b].end = middle;
        }
        for (uint32_t i = part.begin; i < part.end; ++i)
          blockOf[members[i]] = static_cast<uint32_t>(blocks.size());
        splitters.push_back(static_cast<uint32_t>(blocks.size()));
        blocks.push_back(part);
      }
      touched.clear();
    }
  }
  return blockOf;
}

Dfa oneLetter(const LetterSet& letters, size_t size) {
  Dfa dfa; // start, end, dead
  dfa.letters = size;
  dfa.accepting = {0, 1, 0};
  dfa.next.assign(3 * size, 2);
  for (size_t a = 0; a < size; ++a)
    if (letters[a]) dfa.next[a] = 1;
  return minimised(dfa);
}

Dfa concatenation(const std::vector<Dfa>& parts, Effort& effort) {
  std::vector<Piece> pieces;
  for (uint32_t p = 0; p < parts.size(); ++p) {
    const bool last = p + 1 == parts.size();
    pieces.push_back(
        {&parts[p], p == 0, last, last ? std::vector<uint32_t>{} : std::vector<uint32_t>{p + 1}});
  }
  return determinised(pieces, false, parts.front().letters, effort);
}

Dfa alternation(const std::vector<Dfa>& parts, Effort& effort) {
  std::vector<Piece> pieces;
  for (const Dfa& part : parts) pieces.push_back({&part, true, true, {}});
  return determinised(pieces, false, parts.front().letters, effort);
}

Dfa repetition(const Dfa& part, size_t least, size_t most, Effort& effort) {
  const bool bounded = most != UNBOUNDED;
  const size_t copies = bounded ? most : std::max<size_t>(least, 1);
  std::vector<Piece> pieces;
  for (uint32_t p = 0; p < copies; ++p) {
    Piece piece = {&part, p == 0, p + 1 >= least, {}};
    if (p + 1 < copies) piece.followers = {p + 1};
    if (p + 1 == copies && !bounded) piece.followers = {p};
    pieces.push_back(std::move(piece));
  }
  return determinised(pieces, least == 0, part.letters, effort);
}

Dfa combination(const Dfa& a, const Dfa& b, SetOperation operation, Effort& effort) {
  Dfa out;
  out.letters = a.letters;
  std::unordered_map<uint64_t, uint32_t> number;
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  const auto visit = [&](uint32_t s, uint32_t t) {
    const auto [at, fresh] = number.try_emplace(uint64_t(s) << 32 | t, static_cast<uint32_t>(pairs.size()));
    if (fresh) {
      if (pairs.size() >= MAX_STATES)
        throw AutomatonTooLarge("needs more than " + std::to_string(MAX_STATES) + " states");
      pairs.emplace_back(s, t);
      const bool inA = a.accepting[s], inB = b.accepting[t];
      out.accepting.push_back(operation == SetOperation::AND  ? inA && inB
                              : operation == SetOperation::OR ? inA || inB
                                                              : inA && !inB);
    }
    return at->second;
  };
  visit(0, 0);
  for (size_t i = 0; i < pairs.size(); ++i) {
    effort.spend(out.letters);
    const auto [s, t] = pairs[i];
    for (size_t l = 0; l < out.letters; ++l) out.next.push_back(visit(a.target(s, l), b.target(t, l)));
  }
  return minimised(out);
}

namespace {

Dfa newAllPaths(const PathAlphabet& alphabet) {
  Effort effort;
  const auto letters = [&](const LetterSet& set) { return oneLetter(set, alphabet.size()); };
  const Dfa event = letters(alphabet.events()), light = letters(alphabet.lettersOf(3)),
            eye = letters(alphabet.lettersOf(4));
  return concatenation({light, repetition(event, 0, UNBOUNDED, effort), eye}, effort);
}

} // namespace

Dfa allPaths(const PathAlphabet& alphabet) {
  static const Dfa withoutNames = newAllPaths(PathAlphabet());
  return alphabet.hasNames() ? newAllPaths(alphabet) : withoutNames;
}

Dfa withNames(const Dfa& dfa, const PathAlphabet& alphabet) {
  Dfa out;
  out.letters = alphabet.size();
  out.accepting = dfa.accepting;
  for (size_t state = 0; state < dfa.size(); ++state)
    for (size_t letter = 0; letter < out.letters; ++letter)
      out.next.push_back(dfa.target(state, alphabet.base(letter)));
  return out;
}

} // namespace recurse
