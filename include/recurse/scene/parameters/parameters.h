/** @file
 * Parameters of a scene-file directive: as written (ParsedDirective), as a plug-in declares them
 * (ParameterSpec), and the checked meeting of the two (Parameters), which is all that a plug-in sees.
 *
 * A plug-in declares each parameter once, with type, default, range and description. The declaration checks
 * scene files (unknown names, wrong types, ranges, counts), supplies defaults, and is printed in the
 * reference page, so that none of these can drift apart.
 */
#pragma once

#include <initializer_list>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/scene/parameters/parsedDirective.h"

namespace recurse {

struct SampledSpectrum; // spectrum.h

/** The declaration of one parameter. Make them with the functions below. */
struct ParameterSpec {
  ParameterType type = ParameterType::REAL;
  std::string name;
  std::string defaultText; ///< the values of the default as written in a scene file; empty: none
  std::string description; ///< one line, with the unit
  double minimum = -std::numeric_limits<double>::infinity(); ///< of every number
  double maximum = std::numeric_limits<double>::infinity();
  bool minimumExcluded = false;
  int count = 1;         ///< values (points, colours) wanted; 0: any number
  bool required = false; ///< an error when absent
  bool textured = false; ///< a texture may stand for the value
  bool ignored = false;  ///< taken and without effect; the description says why
  SpectrumKind spectrumKind = SpectrumKind::ALBEDO;
  std::vector<std::string> choices; ///< of a string; empty: any

  ParameterSpec& range(double low, double high) {
    minimum = low;
    maximum = high;
    return *this;
  }
  ParameterSpec& positive() {
    minimum = 0;
    minimumExcluded = true;
    return *this;
  }
  ParameterSpec& require() {
    required = true;
    return *this;
  }
  ParameterSpec& withTexture() {
    textured = true;
    return *this;
  }
  ParameterSpec& oneOf(std::vector<std::string> names) {
    choices = std::move(names);
    return *this;
  }
};

/** How a parameter is declared in a scene file: `"float radius"`. */
std::string declarationText(const ParameterSpec& spec);
/** What values it takes: range, choices, count; empty where anything goes. */
std::string rangeText(const ParameterSpec& spec);

ParameterSpec realParameter(const std::string& name, const std::string& defaultText,
                            const std::string& description);
ParameterSpec integerParameter(const std::string& name, const std::string& defaultText,
                               const std::string& description);
ParameterSpec booleanParameter(const std::string& name, const std::string& defaultText,
                               const std::string& description);
ParameterSpec stringParameter(const std::string& name, const std::string& defaultText,
                              const std::string& description);
ParameterSpec spectrumParameter(const std::string& name, const std::string& defaultText, SpectrumKind kind,
                                const std::string& description);
/** Any other type, and arrays (count 0: any number of values). */
ParameterSpec arrayParameter(ParameterType type, const std::string& name, int count,
                             const std::string& defaultText, const std::string& description);
/** Accepted for compatibility, without effect on the picture. */
ParameterSpec ignoredParameter(ParameterType type, const std::string& name, const std::string& why);

/**
 * The checked parameters of one plug-in use. Reading a name that was not declared is a programming error and
 * throws std::logic_error. All numbers are finite. Every getter throws SceneError, with its place, for what
 * only the plug-in can find wrong; `fail` is for the plug-in's own checks.
 */
class Parameters {
 public:
  Parameters() = default;

  /** True when the file gave the parameter (defaults do not count). */
  bool has(const std::string& name) const;
  /** True when the value is there: given, or with a default. */
  bool hasValue(const std::string& name) const;

  bool boolean(const std::string& name) const;
  int integer(const std::string& name) const;
  double real(const std::string& name) const;
  std::string string(const std::string& name) const;
  /** A colour, converted by the declared kind: rgb, blackbody, named or sampled spectrum. */
  Rgbd spectrum(const std::string& name) const;
  /** The same by wavelength [nm], where it was given so: samples, a file of them, or a named glass. No
   * samples otherwise. */
  SampledSpectrum sampledSpectrum(const std::string& name) const;
  Vec3d vector3(const std::string& name) const; ///< point3, vector3, normal

  std::vector<int> integers(const std::string& name) const;
  std::vector<double> reals(const std::string& name) const;
  std::vector<Vec2d> vector2s(const std::string& name) const;
  std::vector<Vec3d> vector3s(const std::string& name) const;
  std::vector<std::string> strings(const std::string& name) const;
  std::vector<Rgbd> spectra(const std::string& name) const; ///< of an array of colours

  /** The name of the texture that stands for the value; empty when there is none. */
  std::string texture(const std::string& name) const;
  /** The declared range of every number; what a texture gives has to be held to it. */
  std::pair<double, double> range(const std::string& name) const;
  /** The value as a path to an existing readable file: beside the file that names it, else beside the top
   * file. */
  std::string filePath(const std::string& name) const;
  /** The same for readers that take files in memory as well. */
  FileReference file(const std::string& name) const;
  /** A path in the directory of the naming file, which need not exist. */
  const std::string& directory() const { return baseDirectory; }

  const std::string& plugInName() const { return name; }
  const SourceLocation& location() const { return place; }
  SourceLocation location(const std::string& name) const;
  [[noreturn]] void fail(const std::string& name, const std::string& message,
                         const std::string& accepted = {}) const;
  /** Tells something about a parameter that does not keep the plug-in from being made. */
  void warn(const std::string& name, const std::string& message, const std::string& accepted = {}) const;
  /** What was told so. */
  const Diagnostics& warnings() const { return *told; }

 private:
  friend Parameters bindParameters(const ParsedDirective&, const std::vector<ParameterSpec>&, Diagnostics&,
                                   bool);
  struct Bound {
    std::string name;
    ParameterType type = ParameterType::REAL;
    SpectrumKind kind = SpectrumKind::ALBEDO;
    double minimum = 0, maximum = 0; ///< of every number
    ParsedParameter value;
    bool given = false, present = false;
  };
  const Bound& find(const std::string& name) const;
  const Bound& valueOf(const std::string& name, std::initializer_list<ParameterType> types) const;
  const Bound& oneValueOf(const std::string& name, std::initializer_list<ParameterType> types) const;
  Rgbd spectrumOf(const Bound& b, const ParsedParameter& value) const;

  std::vector<Bound> bound;
  std::string name, baseDirectory, topDirectory;
  std::shared_ptr<const MemoryFiles> files;
  SourceLocation place;
  std::shared_ptr<Diagnostics> told = std::make_shared<Diagnostics>();
};

/**
 * Meets what a file wrote with what a plug-in declares. Reports unknown names (with the nearest declared
 * ones), wrong types, counts, ranges and non-finite numbers; unknown names are warnings when `lenient`.
 * Of a parameter given twice the last counts, as in pbrt-v4, with a warning; what the directive itself gives
 * goes before what an Attribute directive gave, which may also go unused.
 */
Parameters bindParameters(const ParsedDirective& directive, const std::vector<ParameterSpec>& specs,
                          Diagnostics& diagnostics, bool lenient);

/** Parses `"float radius" 2 "rgb L" [1 1 1]` alone, for examples, tests and options. Throws SceneError. */
ParsedDirective parseParameterText(const std::string& plugIn, const std::string& text);

} // namespace recurse
