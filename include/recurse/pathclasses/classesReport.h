/** @file
 * What `recurse classes` tells about path expressions: what each stands for, and how they relate.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/pathclasses/pathExpression.h"

namespace recurse {

struct ClassesReport {
  struct Entry {
    PathClass pathClass;
    PathAutomaton automaton;
    std::vector<std::string> examples; ///< shortest first
  };
  std::vector<Entry> entries;
  std::vector<PathOverlap> overlaps; ///< all pairs of entries that share paths
  PathAutomaton leftOver;            ///< the paths in no entry
  std::string renderable; ///< the size of the joint automata, or why they cannot be rendered at once

  std::string text() const;
};

/** Compiles and compares the classes. Throws Error for what does not compile; a class without paths is
 * reported. */
ClassesReport analyseClasses(const std::vector<PathClass>& classes, size_t maxEvents = 4,
                             size_t mostPerLength = 4);

/** The named classes as a table for a terminal: name, expression, meaning. */
std::string namedClassesText();

} // namespace recurse
