/** @file
 * Formatting of diagnostics.
 */
#include "recurse/core/io/error.h"

#include "recurse/core/io/terminalText.h"
#include "recurse/core/io/text.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <numeric>
#include <tuple>

namespace recurse {

std::string SourceLocation::lineText() const {
  if (!source || line < 1) return {};
  const std::string& text = source->text;
  size_t begin = 0;
  for (int i = 1; i < line; ++i) {
    begin = text.find('\n', begin);
    if (begin == std::string::npos) return {};
    ++begin;
  }
  size_t end = std::min(text.find('\n', begin), text.size());
  if (end > begin && text[end - 1] == '\r') --end;
  return text.substr(begin, end - begin);
}

namespace {

/** Maximum part of a long line that is shown, around the caret [characters]. */
constexpr size_t SHOWN_COLUMNS = 100;

std::string caretLines(const SourceLocation& where) {
  const std::string text = where.lineText();
  const size_t caretByte = where.column > 0 ? static_cast<size_t>(where.column - 1) : 0;
  if (text.empty() || caretByte > text.size()) return {};
  size_t count = 0, caret = 0; // [characters]
  for (size_t i = 0; i < text.size(); ++count) {
    i += characterAt(text, i).bytes;
    if (i <= caretByte) ++caret;
  }
  const size_t begin = count > SHOWN_COLUMNS && caret > SHOWN_COLUMNS / 2 ? caret - SHOWN_COLUMNS / 2 : 0;
  const std::string lead = begin > 0 ? "..." : "";
  std::string shown;
  for (size_t i = 0, column = 0; i < text.size() && column < begin + SHOWN_COLUMNS; ++column) {
    const TextCharacter c = characterAt(text, i);
    // What would garble a terminal, a tab too, becomes one blank, so that the caret stays in its column.
    if (column >= begin) shown += c.isPlain ? text.substr(i, c.bytes) : " ";
    i += c.bytes;
  }
  if (begin + SHOWN_COLUMNS < count) shown += "...";
  return "    " + lead + shown + "\n    " + std::string(lead.size() + caret - begin, ' ') + "^\n";
}

/** Edit distance: letters to insert, delete, replace, or exchange with their neighbour. */
size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1), last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

/** Limits of texts that a person reads, since names in a scene may be as long as the file [bytes]. */
constexpr size_t MAX_MESSAGE = 600, MAX_LIST = 4000;

/** Text without its middle where it is too long [bytes]: its ends contain the error and its location. */
std::string abbreviated(const std::string& text, size_t most) {
  if (text.size() <= most) return text;
  const auto cutsCharacter = [&](size_t i) { return (text[i] & 0xc0) == 0x80; };
  size_t head = most / 2, tail = text.size() - most / 2;
  constexpr int MORE_BYTES = 3; // of a character in UTF-8; longer runs are no characters
  for (int i = 0; i < MORE_BYTES && head > 0 && cutsCharacter(head); ++i) --head;
  for (int i = 0; i < MORE_BYTES && tail < text.size() && cutsCharacter(tail); ++i) ++tail;
  return text.substr(0, head) + "[...]" + text.substr(tail);
}

/** Locations of all but the first of some equal diagnostics, up to a readable number of them. */
std::string placesOf(const std::vector<const Diagnostic*>& same) {
  constexpr size_t MAX_COUNT = 8;
  std::string out;
  for (size_t i = 1; i < same.size() && i <= MAX_COUNT; ++i) {
    const SourceLocation& where = same[i]->location;
    if (where.source)
      out += (out.empty() ? "" : ", ") + where.source->name + ":" + std::to_string(where.line);
  }
  return out + (same.size() - 1 > MAX_COUNT ? ", ..." : "");
}

} // namespace

std::string Diagnostic::format() const {
  std::string out;
  if (location.source) {
    out += location.source->name + ":";
    if (location.line > 0)
      out += std::to_string(location.line) + ":" + std::to_string(std::max(1, location.column)) + ":";
    out += " ";
  }
  out += severity == Severity::ERROR ? "error: " : "warning: ";
  out += message + "\n" + caretLines(location);
  if (!accepted.empty()) out += "    accepted: " + accepted + "\n";
  return out;
}

void Diagnostics::error(const SourceLocation& where, const std::string& message,
                        const std::string& accepted) {
  list.push_back(
      {Severity::ERROR, where, abbreviated(message, MAX_MESSAGE), abbreviated(accepted, MAX_LIST)});
  ++errorCount;
}

void Diagnostics::warning(const SourceLocation& where, const std::string& message,
                          const std::string& accepted) {
  list.push_back(
      {Severity::WARNING, where, abbreviated(message, MAX_MESSAGE), abbreviated(accepted, MAX_LIST)});
}

std::string Diagnostics::format() const {
  std::map<std::tuple<Severity, std::string, std::string>, std::vector<const Diagnostic*>> same;
  for (const Diagnostic& d : list) same[{d.severity, d.message, d.accepted}].push_back(&d);
  std::string out;
  for (const Diagnostic& d : list) {
    const std::vector<const Diagnostic*>& all = same[{d.severity, d.message, d.accepted}];
    if (all.front() != &d) continue;
    out += d.format();
    if (all.size() > 1 && d.location.source)
      out += "    and " + std::to_string(all.size() - 1) + " more like it: " + placesOf(all) + "\n";
  }
  return out;
}

void Diagnostics::throwIfErrors() const {
  if (!hasErrors()) return;
  SceneError error(format());
  error.list = list;
  throw error;
}

SceneError::SceneError(const SourceLocation& where, const std::string& message, const std::string& accepted)
    : SceneError(Diagnostic{Severity::ERROR, where, message, accepted}.format()) {
  list.push_back({Severity::ERROR, where, message, accepted});
}

std::vector<std::string> nearestNames(const std::string& wrong, const std::vector<std::string>& names,
                                      size_t most) {
  std::vector<std::pair<size_t, std::string>> near;
  for (const std::string& name : names) {
    const auto [shorter, longer] = std::minmax({wrong.size(), name.size()});
    const size_t misspelt = std::max<size_t>(1, shorter / 3);
    // Skips names much shorter than a wrong one, which may be of any length: bounds the work.
    if (wrong.size() > name.size() + misspelt) continue;
    const std::string a = lowerCase(wrong), b = lowerCase(name);
    if (const size_t distance = longer - shorter > misspelt ? longer : editDistance(a, b);
        distance <= misspelt)
      near.emplace_back(distance, name);
    else if (wrong.size() > 1 && b.starts_with(a))
      near.emplace_back(longer, name);
    else if (wrong.size() > 3 && b.find(a) != std::string::npos)
      near.emplace_back(2 * longer, name);
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> out;
  for (size_t i = 0; i < near.size() && i < most; ++i) out.push_back(near[i].second);
  return out;
}

} // namespace recurse
