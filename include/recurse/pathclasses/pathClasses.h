/** @file
 * Path classes at run time: the film layers of a light path. A path is a word over L, S, D, V and E (Heckbert
 * 1990), a class a regular language of such words. The light side carries the state of a DFA of all classes;
 * the camera side carries the state of the reverse automaton: a set of light states for each class. Joining
 * the two is one look-up. Lights and surfaces with names that the expressions use have events of their own.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recurse/pathclasses/pathEvent.h"
#include "recurse/pathclasses/pathNames.h"
#include "recurse/pathclasses/transientFrames.h"

namespace recurse {

class PathAutomaton;

/** Set of path classes, bit i for classes()[i]: at most 64. The layers of addFrames() have no bits. */
using LayerMask = uint64_t;

/** State of a light-side walk that has read "L" and the events since: 0 to lightStateCount() - 1. */
class LightState {
 public:
  explicit constexpr LightState(uint8_t byte = 0) : byte(byte) {} ///< as stored in a photon
  uint8_t byte;
};

/** State of a camera-side walk that has read the path from E backwards: 0 to cameraStateCount() - 1. */
class CameraState {
 public:
  explicit constexpr CameraState(uint16_t index = 0) : index(index) {}
  uint16_t index;
};

/** Kind of a surface: which of the names in the expressions it has. Only PathClasses makes it. */
class SurfaceKind {
 public:
  explicit constexpr SurfaceKind(uint8_t index = 0) : index(index) {}
  uint8_t index;
};

/**
 * Several path expressions compiled together. The default is the single class of all paths, whose walks take
 * negligible time.
 */
class PathClasses {
 public:
  /** One class, "all": every path. */
  PathClasses();
  /** Compiles 1 to 64 expressions with different names. Throws Error (BAD_USAGE) for another number, equal or
   * empty names, with the column for a syntax error, for a class without paths, for too many states, and for
   * expressions that name lights or surfaces. */
  explicit PathClasses(std::vector<PathClass> classes) : PathClasses(std::move(classes), nullptr) {}
  /** Compiles expressions that may name lights and surfaces of the scene in which the walks are. Throws Error
   * like the constructor above, and for a name that the scene does not have. */
  PathClasses(std::vector<PathClass> classes, const PathNames& names)
      : PathClasses(std::move(classes), &names) {}

  /** Throws Error where the expressions do not compile, whatever names a scene has. */
  static void check(const std::vector<PathClass>& classes);

  /** Adds a film layer for each layer of the frames, after the layer of the class, which must be the only
   * one: its light by the lengths of its paths. Called once at most. */
  void addFrames(const TransientFrames& frames);
  /** Frames of a transient render; empty: lengths of paths are not used. */
  const TransientFrames& frames() const { return transient; }
  bool isTransient() const { return !transient.empty(); }
  /** Film layer of light by the optical length of its path [scene units]; only for a transient render. */
  size_t layerOfLength(float length) const { return firstFrameLayer + transient.layerOf(length); }

  /** The film's layers: the classes, and those of addFrames(). */
  const std::vector<PathClass>& classes() const { return list; }
  size_t layerCount() const { return list.size(); }
  /** Number of states of each side. */
  size_t lightStateCount() const { return lightStates; }
  size_t cameraStateCount() const { return cameraDead.size(); }

  /** State after reading L, of a light that no expression names, such as an ambient term; of one of the
   * lights if all of PathNames are named. */
  LightState lightStart() const { return lightStartState; }
  /** State after reading L, of a light by its index in PathNames. */
  LightState lightStart(size_t light) const {
    return startOfLight.empty() ? lightStartState : startOfLight[light];
  }
  /** State after reading E, from the end of the word. */
  CameraState cameraStart() const { return cameraStartState; }
  /** Whether events depend on the surface: SurfaceKinds other than the default exist. */
  bool distinguishesSurfaces() const { return !kindOfSurface.empty(); }
  /** Number of SurfaceKinds, at least 1: their indices count from 0. */
  size_t surfaceKindCount() const { return events / 3; }
  /** Kind of a surface by the index of its object and the number of its material in PathNames. */
  SurfaceKind surfaceKind(size_t object, size_t material) const {
    if (kindOfSurface.empty()) return SurfaceKind();
    return SurfaceKind(kindOfSurface[kindOfObject[object] * materialKinds + kindOfMaterial[material]]);
  }
  /** State after one more event of the walk. `kind`: of the surface of an S or D event. */
  LightState step(LightState s, PathEvent e, SurfaceKind kind = SurfaceKind()) const {
    return LightState(lightNext[size_t(s.byte) * events + column(e, kind)]);
  }
  CameraState step(CameraState s, PathEvent e, SurfaceKind kind = SurfaceKind()) const {
    return CameraState(cameraNext[size_t(s.index) * events + column(e, kind)]);
  }
  /** True when no continuation of the light walk is in any class: the photon may be dropped. */
  bool dead(LightState s) const { return lightDead[s.byte] != 0; }
  /** True when no light path completes the word of the camera walk: the camera path may end. */
  bool dead(CameraState s) const { return cameraDead[s.index] != 0; }
  /** True if a class contains the path from a light straight to the last vertex of the camera walk, or with
   * `throughPanes` through any number of S events. */
  bool isLit(CameraState s, bool throughPanes) const {
    return (cameraLit[s.index] & (throughPanes ? LIT_THROUGH_PANES : LIT)) != 0;
  }
  /** Classes of the path that consists of both halves. Exactly one of them has read the event at the vertex
   * where they are joined. */
  LayerMask join(LightState light, CameraState eye) const {
    return joined[size_t(eye.index) * lightStates + light.byte];
  }

 private:
  static constexpr uint8_t LIT = 1, LIT_THROUGH_PANES = 2;

  PathClasses(std::vector<PathClass> classes, const PathNames* names);
  static size_t column(PathEvent e, SurfaceKind kind) { return size_t(kind.index) * 3 + size_t(e); }
  /** Makes the automaton that reads from "E" backwards. `outputs`: classes that accept E after a light state.
   */
  void makeCameraSide(const std::vector<LayerMask>& outputs, const std::vector<PathAutomaton>& automata);
  void findLit(const std::vector<LightState>& starts);

  std::vector<PathClass> list;
  TransientFrames transient;
  size_t firstFrameLayer = 0;
  size_t lightStates = 1, events = 3;
  LightState lightStartState;
  CameraState cameraStartState;
  std::vector<LightState> startOfLight;                             ///< empty without names
  std::vector<uint8_t> kindOfObject, kindOfMaterial, kindOfSurface; ///< empty without names
  size_t materialKinds = 1;
  std::vector<uint8_t> lightNext, lightDead, cameraDead, cameraLit;
  std::vector<uint16_t> cameraNext;
  std::vector<LayerMask> joined;
};

} // namespace recurse
