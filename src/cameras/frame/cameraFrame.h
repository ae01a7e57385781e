/** @file
 * Frame of a camera in the scene, and its effect on densities.
 */
#pragma once

#include "recurse/core/math/animatedTransform.h"

namespace recurse {

struct CameraFrame {
  explicit CameraFrame(const Mat4d& sceneFromCamera)
      : sceneFromCamera(sceneFromCamera), cameraFromScene(glm::inverse(sceneFromCamera)) {
    const Vec3d across = glm::cross(Vec3d(sceneFromCamera[0]), Vec3d(sceneFromCamera[1]));
    areaScale = glm::length(across);
    axis = across * (std::copysign(1.0, glm::dot(across, Vec3d(sceneFromCamera[2]))) / areaScale);
    volumeScale = std::abs(glm::determinant(Mat3d(sceneFromCamera)));
  }

  Vec3d pointToScene(const Vec3d& p) const { return transformPoint(sceneFromCamera, p); }
  Vec3d vectorToScene(const Vec3d& v) const { return transformVector(sceneFromCamera, v); }
  Vec3d pointToCamera(const Vec3d& p) const { return transformPoint(cameraFromScene, p); }
  Vec3d vectorToCamera(const Vec3d& v) const { return transformVector(cameraFromScene, v); }

  /** Solid angle in camera space over solid angle in the scene, at a unit direction of camera space. */
  double solidAngleRatio(const Vec3d& direction) const {
    const double length = glm::length(vectorToScene(direction));
    return length * length * length / volumeScale;
  }

  Mat4d sceneFromCamera, cameraFromScene;
  Vec3d axis;       ///< unit normal of the lens in the scene, forward
  double areaScale; ///< area in the scene over area in the plane of the lens in camera space

 private:
  double volumeScale;
};

/** Frame of a camera that may move. */
class CameraTrack {
 public:
  explicit CameraTrack(const AnimatedTransform& sceneFromCamera)
      : motion(sceneFromCamera), first(sceneFromCamera.start()) {}
  bool moves() const { return motion.moves(); }
  /** Calls use(frame) for the frame at a time. */
  template <class Use> auto at(float time, const Use& use) const {
    return moves() ? use(CameraFrame(motion.at(double(time)))) : use(first);
  }
  const CameraFrame& start() const { return first; }

 private:
  AnimatedTransform motion;
  CameraFrame first;
};

} // namespace recurse
