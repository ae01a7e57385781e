/** @file
 * Directives and their parameters as a scene file has them, before any plug-in has checked them.
 */
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "recurse/core/io/error.h"
#include "recurse/core/io/fileReference.h"

namespace recurse {

/** What a value of a parameter is. */
enum class ParameterType {
  BOOLEAN,
  INTEGER,
  REAL,
  POINT2,
  VECTOR2,
  POINT3,
  VECTOR3,
  NORMAL,
  STRING,
  SPECTRUM
};

/** One parameter as the file has it: `"rgb reflectance" [.2 .5 .8]`. */
struct ParsedParameter {
  std::string type; ///< the word before the name: float integer bool string point3 rgb blackbody texture ...
  std::string name;
  std::vector<double> numbers;      ///< values of numeric types, flat
  std::vector<std::string> strings; ///< values of string types (string, texture, spectrum name or file)
  std::vector<bool> booleans;
  SourceLocation location;      ///< of the quoted declaration
  SourceLocation valueLocation; ///< of the first value
  /** That file names in it are relative to, where an Include makes that another one than the directive's. */
  std::string directory;
};

/** A use of a plug-in: `Shape "sphere" "float radius" 2`. */
struct ParsedDirective {
  std::string type; ///< the plug-in's name; empty where the file has no such directive
  std::vector<ParsedParameter> parameters;
  /** What Attribute directives set for this kind: counts where `parameters` has no such name. May be null. */
  std::shared_ptr<const std::vector<ParsedParameter>> attributes;
  SourceLocation location;  ///< of the plug-in's name
  std::string directory;    ///< that file names inside it are relative to
  std::string topDirectory; ///< of the top scene file, tried second
  /** Files in memory that names inside it may stand for, tried before all others. May be null. */
  std::shared_ptr<const MemoryFiles> files;
  bool given() const { return !type.empty(); }
};

/** What a spectrum is used for; decides its scale when it is turned into RGB. */
enum class SpectrumKind {
  ALBEDO,     ///< reflectance, in [0, 1]
  UNBOUNDED,  ///< eta, k, absorption: >= 0
  SIGNED,     ///< the value of a texture, which may stand for anything
  ILLUMINANT, ///< emission: blackbody and sampled spectra are scaled to luminance 1, as pbrt does
};

} // namespace recurse
