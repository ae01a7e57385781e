/** @file
 * Directives of the current transform, composed in double precision, each by multiplication from the right.
 */
#include <cmath>

#include <glm/gtc/matrix_access.hpp>

#include "recurse/core/math/affine.h"
#include "scene/directives/sceneParser.h"

namespace recurse::sceneFile {

namespace {

/** True for a matrix that is not affine. A tolerance allows for the rounding errors of exporters in the last
 * row. */
bool isProjection(const Mat4d& m) {
  if (glm::row(m, 3) == Vec4d(0, 0, 0, 1)) return false;
  double largest = 0;
  for (int i = 0; i < 16; ++i) largest = std::max(largest, std::abs(m[i / 4][i % 4]));
  const double rounding = 1e-6 * largest;
  return std::abs(m[0][3]) > rounding || std::abs(m[1][3]) > rounding || std::abs(m[2][3]) > rounding ||
         !(std::abs(m[3][3]) > rounding);
}

/** Affine matrix, without rounding errors in the last row. */
Mat4d withoutProjection(Mat4d m) {
  m /= m[3][3];
  m[0][3] = m[1][3] = m[2][3] = 0;
  m[3][3] = 1;
  return m;
}

/** Reason why a transform is unusable; empty where it is usable. */
Diagnostic faultOf(const Mat4d& m, const SourceLocation& where) {
  Diagnostic fault{Severity::ERROR, where, {}, {}};
  if (!isFinite(m)) {
    fault.message = "the current transform overflows single precision";
  } else if (isProjection(m)) {
    fault.message = "the current transform becomes a projection, which cannot place objects";
    fault.accepted = "numbers 4, 8 and 12 zero, and number 16 not: matrices are written column by column";
  } else if (!isInvertible(m)) {
    fault.message = "the current transform becomes singular: it cannot be inverted";
  }
  return fault;
}

Mat4d translation(const Vec3d& by) {
  Mat4d m(1);
  m[3] = Vec4d(by, 1);
  return m;
}

/** Rodrigues' rotation by an angle [degrees]. */
Mat4d rotation(double degrees, const Vec3d& axis) {
  // Quarter turns are exact, so that axis-aligned objects remain so.
  const double turn = std::remainder(degrees, 360);
  double s = std::sin(turn * (M_PI / 180)), c = std::cos(turn * (M_PI / 180));
  if (std::abs(turn) == 90) c = 0;
  if (std::abs(turn) == 180) s = 0;
  const Vec3d a = axis / glm::length(axis);
  Mat4d m(1);
  for (int i = 0; i < 3; ++i) {
    Vec3d e(0);
    e[i] = 1;
    m[i] = Vec4d(a * (a[i] * (1 - c)) + e * c + glm::cross(a, e) * s, 0);
  }
  return m;
}

} // namespace

std::vector<double> SceneParser::takeNumbers(const Token& directive, size_t count, const char* what) {
  std::vector<double> values;
  const bool bracket = tokens->peek().kind == TokenKind::OPEN;
  if (bracket) tokens->take();
  while (values.size() < count) {
    const Token token = tokens->peek();
    if (!looksLikeNumber(token))
      throw SceneError(token.kind == TokenKind::END ? directive.location() : token.location(),
                       std::string(directive.text) + " needs " + what + ": " + std::to_string(count) +
                           " numbers, found " + token.shown() + " after " + std::to_string(values.size()));
    values.push_back(numberValue(tokens->take()));
  }
  const Token token = tokens->peek();
  if (looksLikeNumber(token) || (bracket && token.kind != TokenKind::CLOSE))
    throw SceneError(token.location(), std::string(directive.text) + " takes " + std::to_string(count) +
                                           " numbers, found " + token.shown() + " after them");
  if (bracket) tokens->take();
  return values;
}

Mat4d SceneParser::takeMatrix(const Token& directive) {
  const std::vector<double> v = takeNumbers(directive, 16, "a matrix column by column");
  Mat4d m;
  for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = v[static_cast<size_t>(i)];
  return isFinite(m) && !isProjection(m) ? withoutProjection(m) : m;
}

void SceneParser::setTransform(size_t i, const Mat4d& m, const SourceLocation& where) {
  Diagnostic fault = faultOf(m, where);
  std::shared_ptr<const Diagnostic>& now = state.transforms.fault[i];
  state.transforms.at[i] = fault.message.empty() ? withoutProjection(m) : m;
  if (fault.message.empty())
    now = nullptr;
  else if (!now) // the first faulty directive is kept
    now = std::make_shared<const Diagnostic>(std::move(fault));
}

void SceneParser::reportFault(const std::shared_ptr<const Diagnostic>& fault, const SourceLocation& usedAt) {
  if (!fault || !faultsReported.insert(fault).second) return;
  log.error(fault->location, fault->message + "; used at " + placeName(usedAt), fault->accepted);
}

void SceneParser::concatenate(const Mat4d& m, const SourceLocation& where) {
  for (size_t i = 0; i < 2; ++i)
    if (state.active[i]) setTransform(i, state.transforms.at[i] * m, where);
}

Mat4d SceneParser::restingTransform(const SourceLocation& where, const char* what) {
  if (state.transforms.moving())
    log.warning(where, std::string(what) + " does not move: it uses the StartTime transform only");
  return firstTransform(where);
}

Mat4d SceneParser::firstTransform(const SourceLocation& where) {
  for (const auto& fault : state.transforms.fault) reportFault(fault, where);
  return state.transforms.fault[0] ? Mat4d(1) : state.transforms.at[0];
}

void SceneParser::identity(const Token&) {
  for (size_t i = 0; i < 2; ++i)
    if (state.active[i]) setTransform(i, Mat4d(1), {});
}

void SceneParser::translate(const Token& t) {
  const auto v = takeNumbers(t, 3, "a vector");
  concatenate(translation({v[0], v[1], v[2]}), t.location());
}

void SceneParser::scale(const Token& t) {
  const auto v = takeNumbers(t, 3, "three factors");
  Mat4d m(1);
  for (int i = 0; i < 3; ++i) m[i][i] = v[static_cast<size_t>(i)];
  concatenate(m, t.location());
}

void SceneParser::rotate(const Token& t) {
  const auto v = takeNumbers(t, 4, "an angle and an axis");
  const Vec3d axis(v[1], v[2], v[3]);
  const double size = std::max({std::abs(v[1]), std::abs(v[2]), std::abs(v[3])});
  if (size == 0) throw SceneError(t.location(), "Rotate needs an axis that is not zero");
  concatenate(rotation(v[0], axis / size), t.location());
}

void SceneParser::lookAt(const Token& t) {
  const auto v = takeNumbers(t, 9, "eye, target and up");
  const Vec3d eye(v[0], v[1], v[2]), target(v[3], v[4], v[5]), up(v[6], v[7], v[8]);
  const double distance = glm::length(target - eye), upLength = glm::length(up);
  if (!(distance > 0) || !(upLength > 0) || !std::isfinite(distance) || !std::isfinite(upLength))
    throw SceneError(t.location(),
                     "LookAt needs a target other than the eye, and an up vector that is not zero");
  const Vec3d forward = (target - eye) / distance;
  const Vec3d side = glm::cross(up / upLength, forward);
  if (!(glm::length(side) > 1e-12))
    throw SceneError(t.location(), "LookAt needs an up vector that is not along the viewing direction");
  // Camera space is left-handed: +z is the view direction, +y up, +x right; this is the inverse.
  const Vec3d right = glm::normalize(side), top = glm::cross(forward, right);
  const Mat4d turn =
      glm::transpose(Mat4d(Vec4d(right, 0), Vec4d(top, 0), Vec4d(forward, 0), Vec4d(0, 0, 0, 1)));
  concatenate(turn * translation(-eye), t.location());
}

void SceneParser::transform(const Token& t) {
  const Mat4d m = takeMatrix(t);
  for (size_t i = 0; i < 2; ++i) {
    if (!state.active[i]) continue;
    state.transforms.fault[i] = nullptr;
    setTransform(i, m, t.location());
  }
}

void SceneParser::concatTransform(const Token& t) { concatenate(takeMatrix(t), t.location()); }

void SceneParser::coordinateSystem(const Token& t) {
  coordinateSystems[takeString(t, "a name").value()] = state.transforms;
}

void SceneParser::coordSysTransform(const Token& t) {
  const Token name = takeString(t, "the name of a coordinate system");
  const auto found = coordinateSystems.find(name.value());
  if (found != coordinateSystems.end()) {
    state.transforms = found->second;
    return;
  }
  std::string known;
  for (const auto& [other, unused] : coordinateSystems)
    known += (known.empty() ? "\"" : " \"") + other + "\"";
  log.error(name.location(), "there is no coordinate system " + name.shown() + " yet", known);
}

void SceneParser::activeTransform(const Token& t) {
  const Token which = tokens->peek();
  if (which.isWord("All"))
    state.active = {true, true};
  else if (which.isWord("StartTime"))
    state.active = {true, false};
  else if (which.isWord("EndTime"))
    state.active = {false, true};
  else
    throw SceneError(which.kind == TokenKind::END ? t.location() : which.location(),
                     "ActiveTransform needs a transform, found " + which.shown(), "All StartTime EndTime");
  tokens->take();
}

void SceneParser::transformTimes(const Token& t) {
  const auto v = takeNumbers(t, 2, "start and end");
  if (!(v[0] < v[1])) throw SceneError(t.location(), "the motion ends before it begins", "start < end");
  scene.startTime = v[0];
  scene.endTime = v[1];
}

} // namespace recurse::sceneFile
