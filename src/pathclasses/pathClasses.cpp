/** @file
 * Tables of several path classes. A camera state is a row: for every light state, the classes that accept the
 * path if the light has read up to this state and the camera the remainder. Words with equal rows are
 * equivalent, so that the rows are the states of the minimal reverse automaton, and also the join table.
 */
#include "recurse/pathclasses/pathClasses.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "pathclasses/pathExpressionDfa.h"
#include "recurse/core/io/error.h"
#include "recurse/pathclasses/pathExpression.h"

namespace recurse {

namespace {

constexpr size_t MAX_CLASSES = 64, MAX_PRODUCT_STATES = 100'000, MAX_LIGHT_STATES = 255,
                 MAX_EYE_STATES = 65'535;

using Row = std::vector<LayerMask>;

struct HashRow {
  size_t operator()(const Row& row) const {
    uint64_t h = 0xcbf29ce484222325u;
    for (const LayerMask m : row) h = (h ^ m ^ (m >> 29)) * 0x9e3779b97f4a7c15u;
    return h ^ (h >> 32);
  }
};

std::vector<PathAutomaton> compileAll(const std::vector<PathClass>& classes, const PathNames* names) {
  if (classes.empty()) throw Error("no path class is given", ExitStatus::BAD_USAGE);
  if (classes.size() > MAX_CLASSES)
    throw Error(std::to_string(classes.size()) + " path classes: at most " + std::to_string(MAX_CLASSES) +
                    " can be rendered at once",
                ExitStatus::BAD_USAGE);
  std::set<std::string> known;
  for (const PathClass& c : classes) {
    if (c.name.empty()) throw Error("the path class " + c.expression + " has no name", ExitStatus::BAD_USAGE);
    if (!known.insert(c.name).second)
      throw Error("two path classes are called '" + c.name + "'", ExitStatus::BAD_USAGE);
  }
  try {
    return PathAutomaton::compileAll(classes, PathAutomaton::Empty::REFUSED, names);
  } catch (const Error&) {
    for (const PathClass& c : classes) try {
        PathAutomaton::compile(c.expression, PathAutomaton::Empty::REFUSED, names);
      } catch (const Error& e) {
        throw Error("class '" + c.name + "': " + e.what(), e.status());
      }
    throw;
  }
}

/** Throws Error that names the class with most states, which a person can omit. */
[[noreturn]] void tooLarge(const std::string& what, const std::vector<PathClass>& classes,
                           const std::vector<PathAutomaton>& automata) {
  size_t largest = 0;
  for (size_t i = 1; i < automata.size(); ++i)
    if (automata[i].stateCount() > automata[largest].stateCount()) largest = i;
  throw Error("the path classes together need more than " + what + "; the largest is '" +
                  classes[largest].name + "' with " + std::to_string(automata[largest].stateCount()) +
                  " states: give fewer classes at once, or smaller repetitions",
              ExitStatus::BAD_USAGE);
}

/** Product automaton of all classes after L, not minimised. Its first states are those after L, one for each
 * kind of light or fewer. */
struct Product {
  size_t events;                 ///< letters of an event: PATH_EVENTS for each kind of surface
  std::vector<uint32_t> starts;  ///< state after L of each kind of light
  std::vector<uint32_t> next;    ///< `events` entries for each state
  std::vector<LayerMask> output; ///< classes that accept if E is next
};

Product multiply(const std::vector<PathClass>& classes, const std::vector<PathAutomaton>& automata,
                 const PathAlphabet& alphabet) {
  Product product;
  product.events = PATH_EVENTS * alphabet.surfaceKinds().size();
  std::map<std::vector<uint32_t>, uint32_t> number;
  std::vector<const std::vector<uint32_t>*> tuples;
  const auto visit = [&](const std::vector<uint32_t>& tuple) {
    const auto [at, fresh] = number.try_emplace(tuple, static_cast<uint32_t>(tuples.size()));
    if (fresh) {
      if (tuples.size() >= MAX_PRODUCT_STATES)
        tooLarge(std::to_string(MAX_PRODUCT_STATES) + " states before they are merged", classes, automata);
      tuples.push_back(&at->first);
      LayerMask output = 0;
      for (size_t c = 0; c < automata.size(); ++c)
        if (automata[c].accepting(automata[c].next(tuple[c], PathLetter::E))) output |= LayerMask(1) << c;
      product.output.push_back(output);
    }
    return at->second;
  };
  std::vector<uint32_t> tuple(automata.size());
  for (size_t kind = 0; kind < alphabet.lightKinds().size(); ++kind) {
    for (size_t c = 0; c < automata.size(); ++c)
      tuple[c] = automata[c].next(automata[c].start(), alphabet.light(kind));
    product.starts.push_back(visit(tuple));
  }
  for (size_t s = 0; s < tuples.size(); ++s)
    for (size_t e = 0; e < product.events; ++e) {
      const size_t letter = alphabet.event(e % PATH_EVENTS, e / PATH_EVENTS);
      for (size_t c = 0; c < automata.size(); ++c) tuple[c] = automata[c].next((*tuples[s])[c], letter);
      product.next.push_back(visit(tuple));
    }
  return product;
}

} // namespace

PathClasses::PathClasses() : PathClasses(std::vector<PathClass>{{"all", "all"}}) {}

void PathClasses::addFrames(const TransientFrames& frames) {
  transient = frames;
  firstFrameLayer = list.size();
  const std::string expression = list.front().expression;
  for (size_t i = 0; i < frames.layerCount(); ++i) list.push_back({frames.layerName(i), expression});
}

PathClasses::PathClasses(std::vector<PathClass> classes, const PathNames* names) : list(std::move(classes)) {
  const std::vector<PathAutomaton> automata = compileAll(list, names);
  const PathAlphabet& alphabet = *automata.front().alphabet;
  if (alphabet.hasNames() && !names)
    throw Error("the path classes name lights or surfaces, such as " + quotedName(namesIn(list).front()) +
                    ", which this command does not support",
                ExitStatus::BAD_USAGE);
  const Product product = multiply(list, automata, alphabet);
  events = product.events;

  // Light side: states that are equivalent for all classes are merged.
  const std::vector<uint32_t> block = coarsestPartition(product.next, events, product.output);
  lightStates = *std::max_element(block.begin(), block.end()) + 1;
  if (lightStates > MAX_LIGHT_STATES)
    tooLarge(std::to_string(MAX_LIGHT_STATES) + " states, which is what a photon has room for", list,
             automata);
  std::vector<LightState> starts; // by kind of light
  for (const uint32_t s : product.starts) starts.emplace_back(static_cast<uint8_t>(block[s]));
  lightStartState = starts.front();
  if (starts.size() > 1)
    for (const uint8_t kind : alphabet.lightKindOf) startOfLight.push_back(starts[kind]);
  if (alphabet.surfaceKinds().size() > 1) {
    kindOfObject = alphabet.objectKindOf;
    kindOfMaterial = alphabet.materialKindOf;
    kindOfSurface = alphabet.surfaceKindOf;
    materialKinds = alphabet.materialKinds;
  }
  lightNext.resize(lightStates * events);
  Row outputs(lightStates);
  for (size_t s = 0; s < block.size(); ++s) {
    outputs[block[s]] = product.output[s];
    for (size_t e = 0; e < events; ++e)
      lightNext[block[s] * events + e] = static_cast<uint8_t>(block[product.next[s * events + e]]);
  }

  makeCameraSide(outputs, automata);
  findLit(starts);
}

void PathClasses::makeCameraSide(const std::vector<LayerMask>& outputs,
                                 const std::vector<PathAutomaton>& automata) {
  std::unordered_map<Row, uint32_t, HashRow> number;
  std::vector<const Row*> rows;
  const auto visit = [&](Row row) {
    const auto [at, fresh] = number.try_emplace(std::move(row), static_cast<uint32_t>(rows.size()));
    if (fresh) {
      if (rows.size() >= MAX_EYE_STATES)
        tooLarge(std::to_string(MAX_EYE_STATES) + " states on the side of the camera", list, automata);
      rows.push_back(&at->first);
    }
    return static_cast<uint16_t>(at->second);
  };
  cameraStartState = CameraState(visit(outputs));
  for (size_t w = 0; w < rows.size(); ++w)
    for (size_t e = 0; e < events; ++e) {
      Row row(lightStates);
      for (size_t q = 0; q < lightStates; ++q) row[q] = (*rows[w])[lightNext[q * events + e]];
      cameraNext.push_back(visit(std::move(row)));
    }

  // The rows contain the result of every pair, and thus the dead states.
  lightDead.assign(lightStates, 1);
  for (const Row* row : rows) {
    joined.insert(joined.end(), row->begin(), row->end());
    bool cameraIsDead = true;
    for (size_t q = 0; q < lightStates; ++q)
      if ((*row)[q] != 0) {
        cameraIsDead = false;
        lightDead[q] = 0;
      }
    cameraDead.push_back(cameraIsDead);
  }
}

void PathClasses::check(const std::vector<PathClass>& classes) {
  PathClasses(classes, anyNames(namesIn(classes)));
}

void PathClasses::findLit(const std::vector<LightState>& starts) {
  // States that S events lead to from those after L.
  std::vector<LightState> reached = starts;
  std::vector<uint8_t> seen(lightStates);
  for (const LightState s : starts) seen[s.byte] = 1;
  for (size_t i = 0; i < reached.size(); ++i)
    for (size_t kind = 0; kind < events / PATH_EVENTS; ++kind) {
      const LightState after = step(reached[i], PathEvent::S, SurfaceKind(static_cast<uint8_t>(kind)));
      if (std::exchange(seen[after.byte], uint8_t(1)) == 0) reached.push_back(after);
    }
  const auto joins = [this](const std::vector<LightState>& light, CameraState eye) {
    return std::any_of(light.begin(), light.end(), [&](LightState s) { return join(s, eye) != 0; });
  };
  for (size_t i = 0; i < cameraDead.size(); ++i) {
    const CameraState eye(static_cast<uint16_t>(i));
    cameraLit.push_back(
        static_cast<uint8_t>((joins(starts, eye) ? LIT : 0) | (joins(reached, eye) ? LIT_THROUGH_PANES : 0)));
  }
}

} // namespace recurse
