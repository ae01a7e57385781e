/** @file
 * Markdown of the reference page.
 */
#include "recurse/scene/reference.h"

#include <cmath>
#include <sstream>

#include "recurse/scene/track.h"
#include "scene/parameterTypes.h"
#include "scene/sceneParser.h"

namespace recurse {

using sceneFile::SceneParser;
using sceneFile::traitsOf;

namespace {

/** A table cell: a bar would end it. */
std::string cell(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '|') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

std::string code(const std::string& text) { return text.empty() ? "" : "`" + cell(text) + "`"; }

std::string number(double x) {
  std::ostringstream out;
  out.precision(10);
  out << x;
  return out.str();
}

const char* placeText(DirectivePlace place) {
  switch (place) {
  case DirectivePlace::BEFORE_WORLD:
    return "before WorldBegin";
  case DirectivePlace::IN_WORLD:
    return "after WorldBegin";
  case DirectivePlace::ANYWHERE:
    break;
  }
  return "anywhere";
}

std::string parameterTable(const std::vector<ParameterSpec>& specs) {
  std::string out = "| parameter | default | values | meaning |\n| --- | --- | --- | --- |\n";
  for (const ParameterSpec& s : specs) {
    std::string meaning = s.description;
    if (s.ignored) meaning = "Taken, without effect: " + meaning;
    out += "| " + code(declarationText(s)) + " | " + (s.required ? "required" : code(s.defaultText)) + " | " +
           cell(rangeText(s)) + " | " + cell(meaning) + " |\n";
  }
  return out;
}

std::string section(const PlugInInfo& p) {
  std::string out = "### `" + (p.name.empty() ? std::string("\"\"") : p.name) + "`\n\n" + p.summary + "\n\n";
  out += p.parameters.empty() ? std::string("No parameters.\n") : parameterTable(p.parameters);
  return out + "\n";
}

} // namespace

std::vector<DirectiveInfo> directiveInfos() {
  std::vector<DirectiveInfo> list;
  for (const SceneParser::Directive& d : SceneParser::directives())
    list.push_back({d.name, d.arguments, d.place, d.summary});
  return list;
}

std::string declarationText(const ParameterSpec& spec) {
  std::string words =
      spec.type == ParameterType::SPECTRUM ? "rgb|spectrum|blackbody|float" : traitsOf(spec.type).word;
  if (spec.textured) words += "|texture";
  return "\"" + words + " " + spec.name + "\"";
}

std::string rangeText(const ParameterSpec& spec) {
  std::string out;
  const auto add = [&](const std::string& text) { out += (out.empty() ? "" : ", ") + text; };
  if (!spec.choices.empty()) {
    std::string choices;
    for (const std::string& c : spec.choices) choices += (choices.empty() ? "\"" : " \"") + c + "\"";
    add(choices);
  }
  double low = spec.minimum, high = spec.maximum;
  if (spec.type == ParameterType::SPECTRUM) {
    if (!std::isfinite(low) && spec.spectrumKind != SpectrumKind::SIGNED) low = 0;
    if (spec.spectrumKind == SpectrumKind::ALBEDO && !std::isfinite(high)) high = 1;
  }
  if (std::isfinite(low) && std::isfinite(high))
    add((spec.minimumExcluded ? "more than " : "") + number(low) + " to " + number(high));
  else if (std::isfinite(low))
    add((spec.minimumExcluded ? "more than " : "at least ") + number(low));
  else if (std::isfinite(high))
    add("at most " + number(high));
  if (spec.ignored) return out;
  if (spec.count == 0) add("any number of values");
  if (spec.count > 1) add(std::to_string(spec.count) + " values");
  return out;
}

std::string directiveReference() {
  std::string out = "| directive | arguments | place | meaning |\n| --- | --- | --- | --- |\n";
  for (const DirectiveInfo& d : directiveInfos())
    out += "| " + code(d.name) + " | " + code(d.arguments) + " | " + placeText(d.place) + " | " +
           cell(d.summary) + " |\n";
  out += "\n`Option` sets:\n\n" + parameterTable(optionSpecs());
  return out +
         "\n`Animate \"name\"` takes the following. `recurse render --frames FIRST:LAST` renders frames; "
         "without "
         "it, the scene is that of frame 0. A frame is the scene with the track's numbers written out:\n"
         "`Animate \"ball\" \"float times\" [ 0 24 ] \"float values\" [ 0 0 1  0 0 5 ]` and "
         "`Translate $ball`.\n\n" +
         parameterTable(trackSpecs());
}

std::string plugInReference(const std::vector<const PlugInInfo*>& plugIns) {
  std::string out;
  for (const PlugInInfo* p : plugIns) out += section(*p);
  return out;
}

std::string plugInReference(const std::vector<PlugInInfo>& plugIns) {
  std::string out;
  for (const PlugInInfo& p : plugIns) out += section(p);
  return out;
}

} // namespace recurse
