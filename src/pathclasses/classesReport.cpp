/** @file
 * Report on path classes for a terminal.
 */
#include "recurse/pathclasses/classesReport.h"

#include <algorithm>

#include "pathclasses/pathAlphabet.h"
#include "recurse/core/io/error.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse {

namespace {

/** Words in one line for each length of path. */
std::string byLength(const std::vector<std::string>& words) {
  std::string out;
  size_t listed = SIZE_MAX;
  for (const std::string& word : words) {
    if (const size_t events = eventCount(word); events != listed) {
      listed = events;
      out += std::string(out.empty() ? "" : "\n") + "  " + std::to_string(events) +
             (events == 1 ? " event: " : " events:");
    }
    out += " " + word;
  }
  return out.empty() ? out : out + "\n";
}

std::string padded(const std::string& text, size_t width) {
  return text + std::string(width - text.size(), ' ');
}

} // namespace

ClassesReport analyseClasses(const std::vector<PathClass>& classes, size_t maxEvents, size_t mostPerLength) {
  const std::vector<PathAutomaton> automata =
      PathAutomaton::compileAll(classes, PathAutomaton::Empty::ALLOWED);
  std::vector<ClassesReport::Entry> entries;
  for (size_t i = 0; i < classes.size(); ++i) {
    std::vector<std::string> examples = automata[i].exampleWords(maxEvents, mostPerLength);
    if (examples.empty() && !automata[i].isEmpty()) examples = {automata[i].shortestWord()};
    entries.push_back({classes[i], automata[i], std::move(examples)});
  }
  std::string renderingNote;
  try {
    const PathClasses joint(classes, anyNames(namesIn(classes)));
    renderingNote = "rendered at once with " + std::to_string(joint.lightStateCount()) +
                    " states on the side of the light and " + std::to_string(joint.cameraStateCount()) +
                    " on the side of the camera";
  } catch (const Error& e) {
    renderingNote = std::string("not to be rendered: ") + e.what();
  }
  return {std::move(entries), findOverlaps(automata), leftOver(PathAutomaton::compile("all"), automata),
          std::move(renderingNote)};
}

std::string ClassesReport::text() const {
  std::string out;
  for (const Entry& e : entries) {
    const std::string& expression = e.pathClass.expression;
    out += e.pathClass.name == expression ? expression : e.pathClass.name + " = " + expression;
    for (const NamedPathClass& named : namedPathClasses())
      if (e.automaton.equivalent(PathAutomaton::compile(named.expression))) {
        out += named.name == expression ? ": " + named.expression + ", " : ": " + named.name + ", ";
        out += named.meaning;
      }
    out += "\n";
    out += e.automaton.isEmpty() ? "  no path matches this\n" : e.automaton.describe() + byLength(e.examples);
  }
  out += "\n";
  if (entries.size() > 1 && overlaps.empty()) out += "disjoint: no path is in two of these\n";
  for (const PathOverlap& o : overlaps)
    out += "not disjoint: " + o.example + " is in " + entries[o.first].pathClass.name + " and in " +
           entries[o.second].pathClass.name + "\n";
  if (leftOver.isEmpty()) {
    out += "complete: every path is in " + std::string(entries.size() == 1 ? "it" : "one of these") + "\n";
  } else {
    out += "not complete: missing are";
    if (const std::string expression = leftOver.toExpression(); !expression.empty()) out += " " + expression;
    std::vector<std::string> words = leftOver.exampleWords(4, 4);
    if (words.empty()) words = {leftOver.shortestWord()};
    out += "\n";
    out += byLength(words);
  }
  return out + renderingNote + "\n";
}

std::string namedClassesText() {
  size_t nameWidth = 0, expressionWidth = 0;
  for (const NamedPathClass& c : namedPathClasses()) {
    nameWidth = std::max(nameWidth, c.name.size());
    expressionWidth = std::max(expressionWidth, c.expression.size());
  }
  std::string out;
  for (const NamedPathClass& c : namedPathClasses())
    out += padded(c.name, nameWidth + 2) + padded(c.expression, expressionWidth + 2) + c.meaning + "\n";
  return out;
}

} // namespace recurse
