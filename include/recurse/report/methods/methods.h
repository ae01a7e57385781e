/** @file
 * Methods side by side: the same scene by each, with the paths that it computes, what it leaves out, and its
 * error. The report of it is JSON, a contact sheet and a page.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/report/converge/converge.h"
#include "recurse/report/stills/stills.h"

namespace recurse {

/** A method and what it made of the scene. */
struct MethodResult {
  std::string name, settings;
  std::string claims;       ///< expression of the paths that it computes
  std::string suppositions; ///< what it takes for granted of these paths, in words; empty: nothing
  std::string failure;      ///< why there is no picture, in words; empty: there is one
  double seconds = 0, samplesPerPixel = 0;
  Stills stills; ///< of the report's classes

  // Set by measureMethod():
  Image picture;
  Comparison whole;               ///< with all light
  Comparison own;                 ///< with the light of the paths that it computes
  double missing = 0;             ///< the part of all light that comes on other paths
  std::vector<double> classMeans; ///< luminance of each class
  std::vector<bool> classIsClaimed;
};

struct MethodsReport {
  std::string title, label, reference; ///< for a person
  std::vector<PathClass> classes;      ///< disjoint; each claim takes all of a class or nothing, see isExact
  bool isExact = true;                 ///< false: classes stand for nearly what a method computes
  std::vector<double> referenceMeans;  ///< luminance of each class
  Stills referenceA, referenceB;       ///< independent of each other
  References references;               ///< of all light
  std::vector<MethodResult> methods;
};

/** Splits the classes until every claim, an expression, takes all of a class or nothing. Disjoint if they
 * were. */
std::vector<PathClass> refineClasses(const std::vector<PathClass>& classes,
                                     const std::vector<std::string>& claims);

/** Sets references and their means from referenceA and referenceB. */
void prepareReferences(MethodsReport& report);
/** Compares a method's stills with the references. */
void measureMethod(MethodResult& method, const MethodsReport& report);

/** The reference and each method: its picture, and what of the reference is not in it. */
Image methodsSheet(const MethodsReport& report);
/** A page that needs nothing but itself. */
std::string methodsPage(const MethodsReport& report);
/** What a person reads on the terminal. */
std::string methodsTable(const MethodsReport& report);
/** All figures. */
std::string methodsJson(const MethodsReport& report);

} // namespace recurse
