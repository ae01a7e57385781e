/** @file
 * Directives and their parameters as written in a scene file, before any plug-in has checked them.
 */
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "recurse/core/io/error.h"
#include "recurse/core/io/fileReference.h"

namespace recurse {

/** Type of a parameter's values. */
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

/** Parameter as written in the file: `"rgb reflectance" [.2 .5 .8]`, except that rgb values are converted
 * from the current ColorSpace to linear Rec. 709. */
struct ParsedParameter {
  std::string type; ///< the word before the name: float integer bool string point3 rgb blackbody texture ...
  std::string name;
  std::vector<double> numbers;      ///< values of numeric types, flat
  std::vector<std::string> strings; ///< values of string types (string, texture, spectrum name or file)
  std::vector<bool> booleans;
  bool isBad = false;           ///< an error in its values has been reported, once for a list
  SourceLocation location;      ///< location of the quoted declaration
  SourceLocation valueLocation; ///< location of the first value
  /** Base of relative file names in the value, where an Include makes it differ from the directive's. */
  std::string directory;
};

/** Use of a plug-in: `Shape "sphere" "float radius" 2`. */
struct ParsedDirective {
  std::string type; ///< the plug-in's name; empty where the file has no such directive
  std::vector<ParsedParameter> parameters;
  /** Parameters of Attribute directives for this kind, used for names not in `parameters`. May be null. */
  std::shared_ptr<const std::vector<ParsedParameter>> attributes;
  SourceLocation location;  ///< location of the plug-in's name
  std::string directory;    ///< base of relative file names in the directive
  std::string topDirectory; ///< directory of the top scene file, tried second
  /** Files in memory, tried before all others for file names in the directive. May be null. */
  std::shared_ptr<const MemoryFiles> files;
  bool given() const { return !type.empty(); }
};

/** Use of a spectrum, which determines its scale in the conversion to RGB. */
enum class SpectrumKind {
  ALBEDO,     ///< reflectance, in [0, 1]
  UNBOUNDED,  ///< eta, k, absorption: >= 0
  SIGNED,     ///< value of a texture, of any meaning
  ILLUMINANT, ///< emission: blackbody and sampled spectra are scaled to luminance 1, as in pbrt
};

} // namespace recurse
