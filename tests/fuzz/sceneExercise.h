/** @file
 * Exercise of a text for the fuzzer and for the test of its corpus: reads it as a scene, and binds its
 * contents to parameter declarations of every type.
 */
#pragma once

#include <algorithm>
#include <string>

#include "recurse/scene/directives/loader.h"

namespace recurse {

inline const std::vector<ParameterSpec>& exerciseSpecs() {
  static const std::vector<ParameterSpec> SPECS = {
      realParameter("radius", "1", "").positive().withTexture(),
      realParameter("fov", "90", "").range(0, 180),
      integerParameter("xresolution", "640", "").range(1, 65536),
      booleanParameter("twosided", "false", ""),
      stringParameter("filename", "", ""),
      stringParameter("mode", "one", "").oneOf({"one", "two"}),
      arrayParameter(ParameterType::POINT3, "P", 0, "", ""),
      arrayParameter(ParameterType::NORMAL, "N", 0, "", ""),
      arrayParameter(ParameterType::POINT2, "uv", 0, "", ""),
      arrayParameter(ParameterType::INTEGER, "indices", 0, "", ""),
      arrayParameter(ParameterType::REAL, "cropwindow", 4, "", ""),
      arrayParameter(ParameterType::POINT3, "from", 1, "0 0 0", ""),
      arrayParameter(ParameterType::STRING, "materials", 2, "", ""),
      spectrumParameter("reflectance", "0.5", SpectrumKind::ALBEDO, "").withTexture(),
      spectrumParameter("eta", "1.5", SpectrumKind::UNBOUNDED, ""),
      spectrumParameter("L", "1 1 1", SpectrumKind::ILLUMINANT, ""),
      ignoredParameter(ParameterType::BOOLEAN, "alpha", ""),
  };
  return SPECS;
}

inline void exerciseDirective(const ParsedDirective& directive) {
  Diagnostics diagnostics;
  const Parameters p = bindParameters(directive, exerciseSpecs(), diagnostics, false);
  diagnostics.format();
  const auto attempt = [](auto&& read) {
    try {
      read();
    } catch (const SceneError&) {
      // expected result
    }
  };
  attempt([&] { p.texture("radius").empty() ? p.real("radius") : 0.0; });
  attempt([&] { p.integer("xresolution"); });
  attempt([&] { p.boolean("twosided"); });
  attempt([&] { p.filePath("filename"); });
  attempt([&] { p.string("mode"); });
  attempt([&] { p.vector3s("P"); });
  attempt([&] { p.vector2s("uv"); });
  attempt([&] { p.integers("indices"); });
  attempt([&] { p.reals("cropwindow"); });
  attempt([&] { p.vector3("from"); });
  attempt([&] { p.strings("materials"); });
  for (const char* name : {"reflectance", "eta", "L"}) attempt([&] { p.spectrum(name); });
}

inline void exerciseScene(const std::string& text, const std::string& directory) {
  Diagnostics diagnostics;
  const SceneDescription scene = parseScene(text, "input", directory, diagnostics);
  diagnostics.format();
  for (const ParsedDirective* d : {&scene.film, &scene.camera, &scene.integrator})
    if (d->given()) exerciseDirective(*d);
  // A few of each kind, because more would slow the fuzzer down.
  constexpr size_t MAX_COUNT = 4;
  for (size_t i = 0; i < std::min(MAX_COUNT, scene.shapes.size()); ++i)
    exerciseDirective(scene.shapes[i].shape);
  for (size_t i = 0; i < std::min(MAX_COUNT, scene.lights.size()); ++i)
    exerciseDirective(scene.lights[i].light);
  for (size_t i = 1; i < std::min(MAX_COUNT, scene.materials.size()); ++i)
    exerciseDirective(scene.materials[i]);
  for (size_t i = 0; i < std::min(MAX_COUNT, scene.areaLights.size()); ++i)
    exerciseDirective(scene.areaLights[i]);
}

} // namespace recurse
