/** @file
 * Tracks, and the directive that makes them. Where `$name` stands in a scene, the text of the track's numbers
 * is read instead, so that a frame is the scene with these numbers written into it.
 */
#include "recurse/scene/track.h"

#include <algorithm>
#include <cmath>

#include "scene/sceneParser.h"

namespace recurse {

Track::Track(std::vector<double> times, std::vector<double> values, Interpolation interpolation, bool repeats)
    : times(std::move(times)), values(std::move(values)),
      components(this->values.size() / this->times.size()), interpolation(interpolation), repeats(repeats) {}

double Track::slope(size_t i, size_t component) const {
  const size_t last = times.size() - 1;
  const auto along = [&](size_t a, size_t b) {
    return (key(b, component) - key(a, component)) / (times[b] - times[a]);
  };
  if (i > 0 && i < last) return along(i - 1, i + 1);
  if (!repeats) return i == 0 ? along(0, 1) : along(last - 1, last);
  const double rise = key(1, component) - key(0, component) + key(last, component) - key(last - 1, component);
  return rise / (times[1] - times[0] + times[last] - times[last - 1]);
}

std::vector<double> Track::at(double frame) const {
  const double period = times.back() - times.front();
  if (repeats && period > 0) {
    frame = times.front() + std::fmod(frame - times.front(), period);
    if (frame < times.front()) frame += period;
  }
  const size_t next =
      static_cast<size_t>(std::upper_bound(times.begin(), times.end(), frame) - times.begin());
  const size_t i = next > 0 ? next - 1 : 0;
  std::vector<double> out(components);
  for (size_t c = 0; c < components; ++c) {
    out[c] = key(i, c);
    if (next == 0 || next == times.size() || frame == times[i] || interpolation == Interpolation::STEP)
      continue;
    const double length = times[next] - times[i], u = (frame - times[i]) / length;
    if (interpolation == Interpolation::LINEAR) {
      out[c] = (1 - u) * key(i, c) + u * key(next, c);
      continue;
    }
    // Hermite's cubic with the slopes of Catmull and Rom.
    const double w = u * u * (3 - 2 * u);
    out[c] = (1 - w) * key(i, c) + w * key(next, c) +
             length * u * (1 - u) * ((1 - u) * slope(i, c) - u * slope(next, c));
  }
  return out;
}

const std::vector<ParameterSpec>& trackSpecs() {
  static const std::vector<ParameterSpec> SPECS = {
      arrayParameter(ParameterType::REAL, "times", 0, "", "frames of the keyframes, rising").require(),
      arrayParameter(ParameterType::REAL, "values", 0, "",
                     "the numbers at each keyframe, one after the other: 1 to 16 for each")
          .require(),
      stringParameter("interpolation", "linear",
                      "between keyframes: straight, smooth by Catmull's and Rom's slopes, or those of the "
                      "keyframe before")
          .oneOf({"linear", "smooth", "step"}),
      booleanParameter("repeat", "false", "begin anew after the last keyframe, which stands for the first"),
  };
  return SPECS;
}

namespace sceneFile {

namespace {

/** Tracks are spliced into the text as often as it names them; a matrix is the most that is of use. */
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
  // Known from here on even where it is wrong, so that nothing is said about its uses.
  TrackDescription& known = scene.tracks.emplace_back(TrackDescription{d.type, nameToken.location(), 0, 0});
  std::vector<double> times{0}, values{1};
  Track::Interpolation interpolation = Track::Interpolation::LINEAR;
  bool repeats = false;
  if (!found.hasErrors()) {
    if (files.tracks.contains(d.type))
      log.error(nameToken.location(), "track " + nameToken.shown() + " is defined already");
    const std::vector<double> givenTimes = p.reals("times"), givenValues = p.reals("values");
    const size_t perTime = givenValues.size() / givenTimes.size();
    if (std::adjacent_find(givenTimes.begin(), givenTimes.end(), std::greater_equal<>()) != givenTimes.end())
      log.error(p.location("times"), "the times do not rise");
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
  for (const double value : track.at(scene.frame)) {
    char number[40];
    std::snprintf(number, sizeof number, " %.17g", value);
    text += number;
  }
  char frame[40];
  std::snprintf(frame, sizeof frame, "%.6g", scene.frame);
  files.tracks[d.type] = {&files.addText(text, "$" + d.type + " at frame " + frame, ""), 0};
}

void SceneParser::reportUnusedTracks() {
  for (const TrackDescription& track : scene.tracks)
    if (files.tracks[track.name].uses == 0)
      log.warning(track.location, "nothing uses the track \"" + track.name + "\"",
                  "$" + track.name + " in the place of numbers");
}

} // namespace sceneFile

} // namespace recurse
