/** @file
 * Interpolation of matrices.
 */
#include "recurse/core/math/animatedTransform.h"

namespace recurse {

AnimatedTransform::AnimatedTransform(const Mat4d& start, const Mat4d& end)
    : first(start), last(end), animated(start != end) {
  if (!animated) return;
  parts[0] = takeApart(start);
  parts[1] = takeApart(end);
  // q and -q are the same rotation; the nearer one gives the shortest path.
  if (glm::dot(parts[0].rotation, parts[1].rotation) < 0) parts[1].rotation = -parts[1].rotation;
}

AnimatedTransform::Parts AnimatedTransform::takeApart(const Mat4d& m) {
  const Mat3d linear(m);
  // Polar decomposition by Newton's iteration (Higham 1986), of the matrix scaled to determinant 1.
  const double determinant = glm::determinant(linear);
  Mat3d rotation = linear * (1 / std::cbrt(determinant)); // keeps a mirror in the stretch
  constexpr int MAX_STEPS = 60; // one for every factor of 4 between scales, and a few more
  for (int i = 0; i < MAX_STEPS; ++i) {
    const Mat3d next = (rotation + glm::transpose(glm::inverse(rotation))) * 0.5;
    double change = 0;
    for (int c = 0; c < 3; ++c) change = std::max(change, glm::length(next[c] - rotation[c]));
    rotation = next;
    if (change < 1e-15) break;
  }
  return {Vec3d(m[3]), glm::normalize(glm::quat_cast(rotation)), glm::transpose(rotation) * linear};
}

Mat4d AnimatedTransform::at(double time) const {
  if (!animated || time <= 0) return first;
  if (time >= 1) return last;
  const Parts &a = parts[0], &b = parts[1];
  const Mat3d rest = a.rest * (1 - time) + b.rest * time;
  Mat4d m(glm::mat3_cast(glm::slerp(a.rotation, b.rotation, time)) * rest);
  m[3] = Vec4d(glm::mix(a.translation, b.translation, time), 1);
  return m;
}

int AnimatedTransform::linearParts() const {
  if (!animated) return 1;
  const double half = std::acos(std::min(1.0, glm::dot(parts[0].rotation, parts[1].rotation)));
  // A chord of angle a stays within a²/8 of its arc. A stretch that changes with time is not covered.
  constexpr double PART = 0.025; // [rad]
  return 1 + static_cast<int>(2 * half / PART);
}

MatrixTrack::MatrixTrack(const std::vector<Mat4d>& steps) : start(steps.front()), matrices(steps) {
  if (moves())
    for (Mat4d& m : matrices) m = Mat4d(glm::mat4(m));
}

Mat4d MatrixTrack::at(float time) const {
  const auto parts = static_cast<int>(matrices.size()) - 1;
  if (parts == 0) return start;
  const float place = time * static_cast<float>(parts);
  const int part = std::clamp(static_cast<int>(std::floor(place)), 0, parts - 1);
  const double within = double(place - static_cast<float>(part));
  return matrices[size_t(part)] * (1 - within) + matrices[size_t(part) + 1] * within;
}

} // namespace recurse
