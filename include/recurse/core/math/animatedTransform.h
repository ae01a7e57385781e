/** @file
 * Placements that change between two moments.
 */
#pragma once

#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "recurse/core/math/vector.h"

namespace recurse {

/**
 * An affine matrix at every time in [0, 1], from that of the start to that of the end. Each is taken apart
 * into a translation, a rotation and the rest (Shoemake and Duff 1992, "Matrix Animation and Polar
 * Decomposition"); rotations turn evenly on the shortest way, the other two change linearly.
 */
class AnimatedTransform {
 public:
  /** At rest. */
  AnimatedTransform(const Mat4d& fixed = Mat4d(1)) : first(fixed), last(fixed) {}
  AnimatedTransform(const Mat4d& start, const Mat4d& end);

  bool moves() const { return animated; }
  const Mat4d& start() const { return first; }
  const Mat4d& end() const { return last; }
  Mat4d at(double time) const;
  /** Into so many equal parts the time is to be cut for matrices to change linearly in each, to 1e-4 of the
   * size of what they place. */
  int linearParts() const;
  /** The same after another matrix. */
  AnimatedTransform after(const Mat4d& m) const {
    return animated ? AnimatedTransform(m * first, m * last) : m * first;
  }

 private:
  struct Parts {
    Vec3d translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    Mat3d rest{1};
  };
  static Parts takeApart(const Mat4d& m);

  Mat4d first{1}, last{1};
  bool animated = false;
  Parts parts[2];
};

/** Matrices at equal distances of time from 0 to 1, which change linearly in between, as Embree has them. */
class MatrixTrack {
 public:
  /** At rest. */
  MatrixTrack(const Mat4d& fixed) : start(fixed), matrices{fixed} {}
  explicit MatrixTrack(const std::vector<Mat4d>& steps);

  bool moves() const { return matrices.size() > 1; }
  const Mat4d& first() const { return start; }
  const std::vector<Mat4d>& steps() const { return matrices; }
  Mat4d at(float time) const;

 private:
  Mat4d start;
  std::vector<Mat4d> matrices; ///< of floats where there are several
};

} // namespace recurse
