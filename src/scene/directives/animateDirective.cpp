/** @file
 * The Animate directive, which defines tracks. `$name` in a scene is replaced by the text of the track's
 * numbers, so that a frame is the scene with these numbers inserted.
 */
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <functional>

#include "scene/directives/sceneParser.h"
#include "scene/directives/track.h"

namespace recurse::sceneFile {

namespace {

/** Maximum of 16, a matrix, since a track is spliced into the text wherever the scene names it. */
constexpr size_t MAX_COMPONENTS = 16;

bool isTrackName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '-';
  });
}

} // namespace

void SceneParser::animate(const Token& t) {
  const Token nameToken = tokens->peek();
  const ParsedDirective d = takePlugIn(t);
  if (!isTrackName(d.type))
    throw SceneError(nameToken.location(), "a track cannot be called " + nameToken.shown(),
                     "letters, digits, '_', '.' and '-'");
  Diagnostics found;
  const Parameters p = bindParameters(d, trackSpecs(), found, false);
  for (const Diagnostic& one : found.all())
    one.severity == Severity::ERROR ? log.error(one.location, one.message, one.accepted)
                                    : log.warning(one.location, one.message, one.accepted);
  // Registered even if it is invalid, so that its uses cause no further errors.
  TrackDescription& known = scene.tracks.emplace_back(TrackDescription{d.type, nameToken.location(), 0, 0});
  std::vector<double> times{0}, values{1};
  Track::Interpolation interpolation = Track::Interpolation::LINEAR;
  bool repeats = false;
  if (!found.hasErrors()) {
    if (files.tracks.contains(d.type))
      log.error(nameToken.location(), "track " + nameToken.shown() + " is already defined");
    const std::vector<double> givenTimes = p.reals("times"), givenValues = p.reals("values");
    const size_t perTime = givenValues.size() / givenTimes.size();
    if (std::adjacent_find(givenTimes.begin(), givenTimes.end(), std::greater_equal<>()) != givenTimes.end())
      log.error(p.location("times"), "the times do not increase");
    else if (perTime == 0 || perTime > MAX_COMPONENTS || givenValues.size() % givenTimes.size() != 0)
      log.error(p.location("values"),
                std::to_string(givenValues.size()) + " values for " + std::to_string(givenTimes.size()) +
                    " times",
                "1 to " + std::to_string(MAX_COMPONENTS) + " for each");
    else {
      times = givenTimes;
      values = givenValues;
    }
    if (p.string("interpolation") == "step") interpolation = Track::Interpolation::STEP;
    if (p.string("interpolation") == "smooth") interpolation = Track::Interpolation::SMOOTH;
    repeats = p.boolean("repeat");
  }
  const Track track(std::move(times), std::move(values), interpolation, repeats);
  known.firstTime = track.firstTime();
  known.lastTime = track.lastTime();
  std::string text;
  std::vector<double> now = track.at(scene.frame);
  for (const double value : now) {
    char number[40];
    std::snprintf(number, sizeof number, " %.17g", value);
    text += number;
  }
  char frame[40];
  std::snprintf(frame, sizeof frame, "%.6g", scene.frame);
  files.tracks[d.type] = {&files.addText(text, "$" + d.type + " at frame " + frame, ""), std::move(now), 0};
}

void SceneParser::reportUnusedTracks() {
  for (const TrackDescription& track : scene.tracks)
    if (files.tracks[track.name].uses == 0)
      log.warning(track.location, "no parameter uses the track \"" + track.name + "\"",
                  "$" + track.name + " instead of numbers");
}

} // namespace recurse::sceneFile
