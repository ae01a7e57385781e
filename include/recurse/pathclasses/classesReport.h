/** @file
 * Report of `recurse classes` on path expressions: the paths of each, and the relations between them.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/pathclasses/pathExpression.h"

namespace recurse {

/** Comparison of path classes. */
struct ClassesReport {
  struct Entry {
    PathClass pathClass;
    PathAutomaton automaton;
    std::vector<std::string>
        examples; ///< example paths, e.g. LDE, shortest first; none only for a class without paths
  };
  std::vector<Entry> entries;
  std::vector<PathOverlap> overlaps; ///< all pairs of entries that share paths
  PathAutomaton leftOver;            ///< paths in none of the entries
  /** Size of the joint automata, or the reason why they cannot be rendered at once. */
  std::string renderingNote;

  /** Report for a terminal, with a line end after each line. */
  std::string text() const;
};

/** Compiles and compares the classes, with examples of up to `maxEvents` events, `mostPerLength` of each
 * number of events. Throws Error for an expression that does not compile; an empty class is allowed and
 * reported. */
ClassesReport analyseClasses(const std::vector<PathClass>& classes, size_t maxEvents = 4,
                             size_t mostPerLength = 4);

/** Table of the named classes for a terminal: name, expression, meaning. */
std::string namedClassesText();

} // namespace recurse
