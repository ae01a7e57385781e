/** @file
 * Markdown text of the reference page.
 */
#include "recurse/scene/directives/reference.h"

#include "scene/directives/sceneParser.h"
#include "scene/directives/track.h"

namespace recurse {

using sceneFile::SceneParser;

namespace {

/** Text of a table cell, with bars escaped. */
std::string cell(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '|') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

std::string code(const std::string& text) { return text.empty() ? "" : "`" + cell(text) + "`"; }

const char* placeText(DirectiveScope place) {
  switch (place) {
  case DirectiveScope::BEFORE_WORLD:
    return "before WorldBegin";
  case DirectiveScope::IN_WORLD:
    return "after WorldBegin";
  case DirectiveScope::ANYWHERE:
    break;
  }
  return "anywhere";
}

std::string parameterTable(const std::vector<ParameterSpec>& specs) {
  std::string out = "| parameter | default | values | meaning |\n| --- | --- | --- | --- |\n";
  for (const ParameterSpec& s : specs) {
    std::string meaning = s.description;
    if (s.ignored) meaning = "Accepted without effect: " + meaning;
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

std::string directiveReference() {
  std::string out = "| directive | arguments | place | meaning |\n| --- | --- | --- | --- |\n";
  for (const DirectiveInfo& d : directiveInfos())
    out += "| " + code(d.name) + " | " + code(d.arguments) + " | " + placeText(d.place) + " | " +
           cell(d.summary) + " |\n";
  out += "\n`Option` sets:\n\n" + parameterTable(optionSpecs());
  return out +
         "\n"
         "`Animate \"name\"` takes the following. `recurse render --frames FIRST:LAST` renders frames; "
         "without it, the scene is that of frame 0. In a frame, the track's numbers replace its "
         "name:\n"
         "`Animate \"ball\" \"float times\" [ 0 24 ] \"float values\" [ 0 0 1  0 0 5 ]` and `Translate "
         "$ball`. In a string a track of one number is written as a whole number: `\"cloth$n.ply\"`, "
         "with zeros up to a width `\"cloth$n%04d.ply\"`, and with braces before letters, or if the "
         "name has other characters than letters, digits and '_', `\"cloth${n}b.ply\"`. Other texts "
         "after `$` do not change.\n\n" +
         parameterTable(trackSpecs()) + "\n`LightScale \"lamp\"` takes:\n\n" +
         parameterTable(lightScaleSpecs());
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
