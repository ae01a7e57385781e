/** @file
 * Comparison of methods: the same scene by each of them, with the paths that it computes, the paths that it
 * omits, and its error. It is reported as JSON, a contact sheet and a page.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/report/converge/converge.h"
#include "recurse/report/stills/stills.h"

namespace recurse {

/** A method with its result for the scene. */
struct MethodResult {
  std::string name, settings;
  std::string claims;                      ///< expression of the paths that the method computes; not empty
  std::string suppositions;                ///< assumptions about these paths, in words; empty: none
  std::string failure;                     ///< reason for a missing picture, in words; empty: there is one
  double seconds = 0, samplesPerPixel = 0; ///< seconds: time of the render [s]
  Stills stills;                           ///< layers of the report's classes

  // Set by measureMethod(); without a picture, only `missing` and `classIsClaimed`:
  Image picture;
  Comparison whole;                 ///< error with all light
  Comparison own;                   ///< error with the light of the paths that the method computes
  double missing = 0;               ///< fraction of all light on paths that the method does not compute
  std::vector<double> classMeans;   ///< mean luminance of each class
  std::vector<bool> classIsClaimed; ///< a part of the class suffices unless MethodsReport::isExact
};

/** Methods and their references. */
struct MethodsReport {
  std::string title, label, reference; ///< texts for people
  std::vector<PathClass> classes;      ///< disjoint; each claim contains all of a class or none, see isExact
  bool isExact = true;                 ///< false: classes approximate the paths that a method computes
  std::vector<double> referenceMeans;  ///< mean luminance of each class
  Stills referenceA, referenceB;       ///< independent
  References references;               ///< with all light
  std::vector<MethodResult> methods;
};

/** Splits the classes until every claim, an expression, contains all of a class or none of it. Disjointness
 * is preserved; parts of a class get the names NAME-a to NAME-z, NAME-aa, ... Throws Error for an expression
 * that does not compile. */
std::vector<PathClass> refineClasses(const std::vector<PathClass>& classes,
                                     const std::vector<std::string>& claims);

/** Sets the references and their means from referenceA and referenceB. */
void prepareReferences(MethodsReport& report);
/** Compares a method's stills with the references. */
void measureMethod(MethodResult& method, const MethodsReport& report);

/** Sheet of the reference and each method: its picture, and the missing part of the reference. */
Image methodsSheet(const MethodsReport& report);
/** Self-contained page. */
std::string methodsPage(const MethodsReport& report);
/** Table for the terminal. */
std::string methodsTable(const MethodsReport& report);
/** All figures as JSON. */
std::string methodsJson(const MethodsReport& report);

} // namespace recurse
