/** @file
 * Path classes at run time: which film layers a light path belongs to. A path is a word over L, S, D, V and E
 * (Heckbert 1990), a class a regular language of words. The light side carries the state of a DFA that all
 * classes share, the camera side that of the reverse automaton: a set of light states for each class. Joining
 * the two is one look-up.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recurse/pathclasses/pathEvent.h"

namespace recurse {

/** A set of film layers, one bit each: at most 64 classes at once. */
using LayerMask = uint64_t;

/** What a light-side walk has read: "L" and the events since. Made by PathClasses only. */
class LightState {
 public:
  explicit constexpr LightState(uint8_t byte = 0) : byte(byte) {} ///< as a photon stores it
  uint8_t byte;
};

/** What a camera side walk has read, from E backwards. Made by PathClasses only. */
class CameraState {
 public:
  explicit constexpr CameraState(uint16_t index = 0) : index(index) {}
  uint16_t index;
};

/**
 * Several path expressions compiled together. The default stands for the single class of all paths, and its
 * walks cost nothing worth measuring.
 */
class PathClasses {
 public:
  /** One class, "all": every path. */
  PathClasses();
  /** Compiles the expressions; throws Error with the column for a bad one, or when there are too many states.
   */
  explicit PathClasses(std::vector<PathClass> classes);

  const std::vector<PathClass>& classes() const { return list; }
  size_t layerCount() const { return list.size(); }
  /** How many states each side has; for reports. */
  size_t lightStateCount() const { return lightStates; }
  size_t cameraStateCount() const { return cameraDead.size(); }

  /** After reading L. */
  LightState lightStart() const { return lightStartState; }
  /** After reading E, from the other end. */
  CameraState cameraStart() const { return cameraStartState; }
  LightState step(LightState s, PathEvent e) const {
    return LightState(lightNext[size_t(s.byte) * 3 + static_cast<size_t>(e)]);
  }
  CameraState step(CameraState s, PathEvent e) const {
    return CameraState(cameraNext[size_t(s.index) * 3 + static_cast<size_t>(e)]);
  }
  /** True when no continuation of the light walk is ever accepted by any class: the photon may be dropped. */
  bool dead(LightState s) const { return lightDead[s.byte] != 0; }
  /** True when no light path completes what the camera walk has read: the camera path may end. */
  bool dead(CameraState s) const { return cameraDead[s.index] != 0; }
  /** The classes of the path made of the two halves. The event at the vertex where they meet has been read by
   *  exactly one of them. */
  LayerMask join(LightState light, CameraState eye) const {
    return joined[size_t(eye.index) * lightStates + light.byte];
  }

 private:
  std::vector<PathClass> list;
  size_t lightStates = 1;
  LightState lightStartState;
  CameraState cameraStartState;
  std::vector<uint8_t> lightNext, lightDead, cameraDead;
  std::vector<uint16_t> cameraNext;
  std::vector<LayerMask> joined;
};

} // namespace recurse
