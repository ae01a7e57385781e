/** @file
 * Transforms that change between two times.
 */
#pragma once

#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "recurse/core/math/vector.h"

namespace recurse {

/**
 * Affine matrix for every time in [0, 1], interpolated between a start and an end matrix; constant before and
 * after. Each of the two is decomposed into a translation, a rotation and a remaining stretch (Shoemake and
 * Duff 1992, "Matrix Animation and Polar Decomposition"). Rotations are slerped on the shortest path;
 * translation and stretch change linearly.
 */
class AnimatedTransform {
 public:
  /** A constant transform. */
  AnimatedTransform(const Mat4d& fixed = Mat4d(1)) : first(fixed), last(fixed) {}
  /** `start` and `end`, if they differ, must be invertible. */
  AnimatedTransform(const Mat4d& start, const Mat4d& end);

  bool moves() const { return animated; }
  const Mat4d& start() const { return first; }
  const Mat4d& end() const { return last; }
  Mat4d at(double time) const;
  /** Number of equal time intervals, 1 to 126, within which linear interpolation of matrices displaces a
   * point by at most 1e-4 of its distance from the image of the origin, if the stretch is constant. */
  int linearParts() const;
  /** The transform followed by a translation, rotation or uniform scaling m: m times this. */
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

/** Matrices at equally spaced times from 0 to 1, rounded to floats if there are several, and linearly
 * interpolated in between, as Embree does. Times are in [0, 1]. */
class MatrixTrack {
 public:
  /** A constant transform. */
  MatrixTrack(const Mat4d& fixed) : start(fixed), matrices{fixed} {}
  /** `steps` must not be empty. */
  explicit MatrixTrack(const std::vector<Mat4d>& steps);

  bool moves() const { return matrices.size() > 1; }
  const Mat4d& first() const { return start; } ///< matrix at time 0, not rounded
  const std::vector<Mat4d>& steps() const { return matrices; }
  Mat4d at(float time) const;

 private:
  Mat4d start;
  std::vector<Mat4d> matrices; ///< rounded to float precision where there are several
};

} // namespace recurse
