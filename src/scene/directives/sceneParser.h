/** @file
 * Parser of scenes: executes the directives of a file in order on a graphics state, and records the results
 * in a SceneDescription.
 */
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "recurse/scene/directives/directiveInfo.h"
#include "recurse/scene/directives/sceneDescription.h"
#include "scene/directives/nestedObjects.h"
#include "scene/text/tokenStream.h"

namespace recurse::sceneFile {

/** Current transform at the start and at the end of the motion. */
struct Transforms {
  std::array<Mat4d, 2> at{Mat4d(1), Mat4d(1)};
  /** Reason why the transform is unusable, and the directive that caused it; null where it is usable. */
  std::array<std::shared_ptr<const Diagnostic>, 2> fault;
  bool moving() const { return at[0] != at[1]; }
};

/** Kinds of directives for which an Attribute directive sets defaults. */
enum class AttributeTarget { SHAPE, LIGHT, MATERIAL, MEDIUM, TEXTURE };
constexpr size_t ATTRIBUTE_TARGETS = 5;

/** State that AttributeBegin saves and AttributeEnd restores. */
struct GraphicsState {
  Transforms transforms;
  std::array<bool, 2> active{true, true};
  bool reverseOrientation = false;
  MaterialReference material;
  int areaLight = -1;
  MediumReference medium;
  std::string colorSpace; ///< colour space of rgb values that follow; empty: linear Rec. 709
  /** Shared pointers, because states are copied far more often than they change. */
  std::array<std::shared_ptr<const std::vector<ParsedParameter>>, ATTRIBUTE_TARGETS> attributes;
};

class SceneParser {
 public:
  /** `requestedCamera`: name of the camera that renders; the first of the file if it has none of this name.
   */
  SceneParser(SceneDescription& scene, SourceFiles& files, Diagnostics& diagnostics,
              std::string requestedCamera);

  /** Parses a whole scene. */
  void parse(const Source& top);

  struct Directive {
    const char* name;
    const char* arguments;
    DirectiveScope place;
    const char* summary;
    void (SceneParser::*carryOut)(const Token& directive);
  };
  /** Table of all directives, in alphabetical order. */
  static const std::vector<Directive>& directives();
  static const Directive* findDirective(std::string_view name);

 private:
  // sceneParser.cpp
  void parseTokens(const Source& source);
  void carryOut(const Directive& directive, const Token& token);
  void unknownDirective(const Token& token);
  void resynchronise();
  void warnOfPbrt3(const SourceLocation& where);
  void checkForPbrt3PlugIn(const char* directive, const ParsedDirective& d);
  Token takeString(const Token& directive, const char* what);
  /** Parameters of a directive; rgb values are converted to linear Rec. 709 from the current colour
   * space. */
  std::vector<ParsedParameter> takeParameters(const std::string& directory, SpectrumKind kind);
  ParsedDirective takePlugIn(const Token& directive);
  ParsedDirective takePlugIn(const Token& directive, AttributeTarget target);
  void moveTypeOut(ParsedDirective& d, const std::string& what);
  void doNothing(const Token&) {}

  // transformDirectives.cpp
  std::vector<double> takeNumbers(const Token& directive, size_t count, const char* what);
  Mat4d takeMatrix(const Token& directive);
  void concatenate(const Mat4d& m, const SourceLocation& where);
  void setTransform(size_t i, const Mat4d& m, const SourceLocation& where);
  /** Current transform at the start of the motion; the identity, with an error, where it is unusable. */
  Mat4d firstTransform(const SourceLocation& where);
  /** Current transform for an item that cannot move, with a warning where it does. */
  Mat4d restingTransform(const SourceLocation& where, const char* what);
  /** Current transform at the end of the motion, where it differs from the start. */
  std::optional<Mat4d> lastTransform() const {
    const bool usable = state.transforms.moving() && !state.transforms.fault[1];
    return usable ? std::optional(state.transforms.at[1]) : std::nullopt;
  }
  void reportFault(const std::shared_ptr<const Diagnostic>& fault, const SourceLocation& usedAt);
  void identity(const Token&);
  void translate(const Token&);
  void scale(const Token&);
  void rotate(const Token&);
  void lookAt(const Token&);
  void transform(const Token&);
  void concatTransform(const Token&);
  void coordinateSystem(const Token&);
  void coordSysTransform(const Token&);
  void activeTransform(const Token&);
  void transformTimes(const Token&);

  // optionDirectives.cpp
  void takeSetting(const Token& directive, ParsedDirective& slot);
  void film(const Token& t) { takeSetting(t, scene.film); }
  void pixelFilter(const Token& t) { takeSetting(t, scene.filter); }
  void sampler(const Token& t) { takeSetting(t, scene.sampler); }
  void integrator(const Token& t) { takeSetting(t, scene.integrator); }
  void accelerator(const Token& t) { takeSetting(t, scene.accelerator); }
  struct ReadCamera {
    CameraDescription description;
    Transforms coordinates; ///< coordinate system "camera"
  };
  void camera(const Token&);
  std::vector<ReadCamera>::iterator findCamera(const std::string& name);
  /** Makes the requested camera, or else the first, the camera of the scene. */
  void chooseCamera();
  void colorSpace(const Token&);
  void option(const Token&);
  void lightScale(const Token&);
  void worldBegin(const Token&);

  // track.cpp
  void animate(const Token&);
  void reportUnusedTracks();

  // worldDirectives.cpp
  struct OpenBlock {
    enum class Kind { ATTRIBUTE, OBJECT } kind;
    SourceLocation location;
    GraphicsState saved;
  };
  void openBlock(OpenBlock::Kind kind, const Token& directive);
  void closeBlock();
  void reportOpenBlocks();
  void attributeBegin(const Token&);
  void attributeEnd(const Token&);
  void attribute(const Token&);
  void reverseOrientation(const Token&);
  void material(const Token&);
  void makeNamedMaterial(const Token&);
  void namedMaterial(const Token&);
  void texture(const Token&);
  void shape(const Token&);
  void lightSource(const Token&);
  void areaLightSource(const Token&);
  void reportUnusedLamps();
  void mediumInterface(const Token&);
  void makeNamedMedium(const Token&);
  void objectBegin(const Token&);
  void objectEnd(const Token&);
  void objectInstance(const Token&);
  void import(const Token&);

  SceneDescription& scene;
  SourceFiles& files;
  ErrorLog log;
  std::string requestedCamera;
  std::vector<ReadCamera> cameras; ///< before the choice, in the order of the file, each with another name
  IncludeCount includes;
  TokenStream* tokens = nullptr; ///< of the file that is being read or imported
  GraphicsState state;
  std::vector<OpenBlock> blocks;
  size_t firstBlock = 0; ///< earlier blocks belong to the importing file
  std::map<std::string, Transforms> coordinateSystems;
  std::set<std::shared_ptr<const Diagnostic>> faultsReported;
  std::set<int> lampsWithShape; ///< into SceneDescription::areaLights
  std::map<std::pair<bool, std::string>, SourceLocation> textureNames;
  ObjectDescription* object = nullptr; ///< object being defined
  ObjectDescription discarded;         ///< replaces an object that cannot be defined
  NestedObjects nested;
  bool inWorld = false, assumedWorld = false, hasWarnedOfPbrt3 = false;
};

} // namespace recurse::sceneFile
