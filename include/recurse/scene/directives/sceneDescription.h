/** @file
 * Scene as written in its file: directives with their parameters and transforms, in double precision, before
 * any plug-in has checked them.
 */
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Material of a shape: an index into `materials`, a name in `namedMaterials`, where there may be none, or no
 * material (interface). */
struct MaterialReference {
  enum class Kind { INDEX, NAME, NONE } kind = Kind::INDEX;
  int index = 0;
  std::string name;
  SourceLocation location;
};

/** Media on both sides of a shape. */
struct MediumReference {
  std::string inside, outside; ///< names in `media`, where there may be none; empty: vacuum
};

/** Shape directive with its graphics state. */
struct ShapeDescription {
  ParsedDirective shape;
  Mat4d worldFromObject{1};                 ///< inside an object definition: instance space from object
  std::optional<Mat4d> worldFromObjectLast; ///< at EndTime, where it differs
  bool reverseOrientation = false;
  MaterialReference material;
  int areaLight = -1; ///< into areaLights; -1: does not emit
  MediumReference medium;
};

/** LightSource directive. */
struct LightDescription {
  ParsedDirective light;
  Mat4d worldFromLight{1};
  std::string medium; ///< medium around the light; empty: vacuum
};

/** Object definition, from ObjectBegin to ObjectEnd. */
struct ObjectDescription {
  std::string name; ///< as the scene file gives it
  SourceLocation location;
  std::vector<ShapeDescription> shapes;
};

/** Instance of an object in the world. The reader expands instances within objects. */
struct InstanceDescription {
  std::string object; ///< name in `objects`, where there may be none
  Mat4d worldFromInstance{1};
  std::optional<Mat4d> worldFromInstanceLast; ///< at EndTime, where it differs
  SourceLocation location;
};

struct TextureDescription {
  std::string name;
  bool spectrum = false; ///< true: a spectrum texture; false: a float texture
  ParsedDirective texture;
  Mat4d worldFromTexture{1};
};

/** LightScale directive. */
struct LightScaleDescription {
  std::string lamp; ///< see Lamp::name
  SourceLocation location;
  Rgbd scale{1};
};

/** Description of an Animate directive. */
struct TrackDescription {
  std::string name;
  SourceLocation location;
  double firstTime = 0, lastTime = 0; ///< times of the first and the last keyframe [frames]
};

/** Camera directive. A file may have several with different names. */
struct CameraDescription {
  ParsedDirective camera;
  std::string cameraName; ///< parameter "name"; empty: none
  Mat4d worldFromCamera{1};
  std::optional<Mat4d> worldFromCameraLast; ///< at EndTime, where it differs
  std::string cameraMedium;                 ///< medium around the camera; empty: vacuum
};

/** Whole scene, with the camera that renders. */
struct SceneDescription : CameraDescription {
  std::string fileName;
  double frame = 0; ///< frame at which the tracks are evaluated
  std::vector<TrackDescription> tracks;
  /** Texts of the scene file, of its includes, and of the tracks at this frame. */
  std::vector<std::shared_ptr<const SourceText>> sources;
  ParsedDirective film, filter, sampler, integrator, accelerator;
  std::vector<CameraDescription> otherCameras;    ///< in the order of the file
  double startTime = 0, endTime = 1;              ///< times of the transforms of StartTime and EndTime
  std::map<std::string, ParsedParameter> options; ///< by their names in optionSpecs()
  std::vector<ParsedDirective> materials;         ///< [0] is the default material, diffuse
  std::map<std::string, ParsedDirective> namedMaterials;
  std::vector<TextureDescription> textures; ///< in the order of the file
  std::vector<ParsedDirective> areaLights;
  std::map<std::string, ParsedDirective> media;
  std::map<std::string, Mat4d> worldFromMedium; ///< for every medium
  std::vector<ShapeDescription> shapes;
  std::map<std::string, ObjectDescription> objects;
  std::vector<InstanceDescription> instances;
  std::vector<LightDescription> lights;
  std::vector<LightScaleDescription> lightScales;
  std::vector<std::string> importNotes;   ///< features that importers imported or skipped
  std::vector<std::string> importedFiles; ///< paths of all files that importers read
};

} // namespace recurse
