/** @file
 * Parameters of a scene-file directive: as written (ParsedDirective), as declared by a plug-in
 * (ParameterSpec), and the checked combination of both (Parameters), which is all that a plug-in sees.
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

/** Declaration of one parameter. Made by the functions below. */
struct ParameterSpec {
  ParameterType type = ParameterType::REAL;
  std::string name;
  /** The values of the default as written in a scene file; empty: none. A spectrum of one number is of type
   * float, of three rgb, else spectrum, unless it begins with one of the words float, rgb, blackbody,
   * spectrum. */
  std::string defaultText;
  std::string description; ///< one line, with the unit
  /** Bounds of every number as written in the scene file. An infinite minimum is 0 for a spectrum that is not
   * SIGNED, and an infinite maximum is 1 for an ALBEDO. */
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimumExcluded = false;
  int count = 1;         ///< number of values (points, colours) required; 0: any number above 0
  bool required = false; ///< an error when absent
  bool textured = false; ///< true: a texture may replace the value
  bool ignored = false;  ///< true: accepted without effect; the description explains why
  SpectrumKind spectrumKind = SpectrumKind::ALBEDO;
  std::vector<std::string> choices; ///< permitted values of a string; empty: any

  /** Permits numbers from `low` to `high`, both included. */
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

/** Declaration of a parameter in scene-file syntax: `"float radius"`. */
std::string declarationText(const ParameterSpec& spec);
/** Accepted values: range, choices, count; empty where all values are accepted. */
std::string rangeText(const ParameterSpec& spec);

// Declarations of parameters with one value; an empty `defaultText`: no default.

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
/** Declares a parameter of any type, including arrays; `count`: see ParameterSpec. */
ParameterSpec arrayParameter(ParameterType type, const std::string& name, int count,
                             const std::string& defaultText, const std::string& description);
/** Declares a parameter that is accepted for compatibility, without effect on the picture. */
ParameterSpec ignoredParameter(ParameterType type, const std::string& name, const std::string& why);

/**
 * Checked parameters of one use of a plug-in. All numbers are finite, also as floats. Reading an undeclared
 * name, or a value as another type than declared, is a programming error and throws std::logic_error. Getters
 * throw SceneError with the location for a parameter without a value or with a texture, and for errors that
 * can only be found when the value is used, such as missing files. `fail` is for the plug-in's own checks.
 */
class Parameters {
 public:
  Parameters() = default;

  /** True when the scene file sets the parameter (defaults do not count). */
  bool has(const std::string& name) const;
  /** True when the parameter has a value: from the file, or a default. */
  bool hasValue(const std::string& name) const;

  bool boolean(const std::string& name) const;
  int integer(const std::string& name) const;
  double real(const std::string& name) const;
  std::string string(const std::string& name) const;
  /** Colour in linear Rec. 709 of a number (grey), rgb, blackbody, named or sampled spectrum. Blackbody and
   * sampled spectra are converted by the declared kind; their colours may leave the declared range. */
  Rgbd spectrum(const std::string& name) const;
  /** Spectrum by wavelength [nm], where it was given so: samples, a file of samples, or a named glass.
   * Otherwise it has no samples. */
  SampledSpectrum sampledSpectrum(const std::string& name) const;
  Vec3d vector3(const std::string& name) const; ///< point3, vector3, normal

  std::vector<int> integers(const std::string& name) const;
  std::vector<double> reals(const std::string& name) const;
  std::vector<Vec2d> vector2s(const std::string& name) const;
  std::vector<Vec3d> vector3s(const std::string& name) const;
  std::vector<std::string> strings(const std::string& name) const;
  std::vector<Rgbd> spectra(const std::string& name) const; ///< for an array of colours

  /** Name of the texture that replaces the value; empty when there is none. */
  std::string texture(const std::string& name) const;
  /** Declared range of every number of a parameter that has a value; the caller must clamp texture values to
   * it. */
  std::pair<double, double> range(const std::string& name) const;
  /** Path of an existing regular file. A relative name in the value is searched in the directory of the file
   * that contains it, then in that of the top file. */
  std::string filePath(const std::string& name) const;
  /** Like filePath(), for readers that accept files in memory as well. */
  FileReference file(const std::string& name) const;
  /** Directory of the naming file, for paths that need not exist. */
  const std::string& directory() const { return baseDirectory; }

  const std::string& plugInName() const { return name; }
  const SourceLocation& location() const { return place; }
  /** Location of a parameter's value; for a default, that of the plug-in's name. */
  SourceLocation location(const std::string& name) const;
  /** Throws SceneError at a parameter; at the plug-in for an empty name. */
  [[noreturn]] void fail(const std::string& name, const std::string& message,
                         const std::string& accepted = {}) const;
  /** Reports a warning about a parameter, which does not prevent the construction of the plug-in. */
  void warn(const std::string& name, const std::string& message, const std::string& accepted = {}) const;
  /** Warnings reported by warn(). */
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
 * Checks a directive of a file against the declarations of a plug-in. Reports unknown names (with the nearest
 * declared ones), missing parameters, wrong types, counts, ranges and non-finite numbers; unknown names are
 * warnings when `lenient`. Of a parameter given twice the last one is used, as in pbrt-v4, with a warning.
 * Parameters of the directive take precedence over an Attribute directive, whose parameters may remain
 * unused.
 */
Parameters bindParameters(const ParsedDirective& directive, const std::vector<ParameterSpec>& specs,
                          Diagnostics& diagnostics, bool lenient);

/** Parses a bare list `"float radius" 2 "rgb L" [1 1 1]`: of examples, tests, options. Throws SceneError. */
ParsedDirective parseParameterText(const std::string& plugIn, const std::string& text);

} // namespace recurse
