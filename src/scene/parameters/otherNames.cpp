/** @file
 * Table of alternative names.
 */
#include "recurse/scene/parameters/otherNames.h"

#include <algorithm>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse {

namespace {

const PlugInName AREA_LIGHT{"AreaLightSource", "diffuse"};
const PlugInName DIFFUSE{"Material", "diffuse"};
const PlugInName CONDUCTOR{"Material", "conductor"};
const PlugInName DIELECTRIC{"Material", "dielectric"};
const PlugInName THIN_DIELECTRIC{"Material", "thindielectric"};
const PlugInName COATED_DIFFUSE{"Material", "coateddiffuse"};
const PlugInName COATED_CONDUCTOR{"Material", "coatedconductor"};
const PlugInName BLINN_PHONG{"Material", "blinnphong"};
const PlugInName PLASTIC{"Material", "plastic"};
const PlugInName SUBSURFACE{"Material", "subsurface"};
const PlugInName MEASURED{"Material", "measured"};
const PlugInName INFINITE_LIGHT{"LightSource", "infinite"};
const PlugInName DISTANT{"LightSource", "distant"};
const PlugInName SKY{"LightSource", "sky"};
const PlugInName GONIOMETRIC{"LightSource", "goniometric"};
const PlugInName HOMOGENEOUS{"MakeNamedMedium", "homogeneous"};
const PlugInName UNIFORM_GRID{"MakeNamedMedium", "uniformgrid"};
const PlugInName NANOVDB{"MakeNamedMedium", "nanovdb"};
const PlugInName MODEL_FILE{"Shape (files)", "mesh"};
const PlugInName BILINEAR_MESH{"Shape", "bilinearmesh"};
const PlugInName TRIANGLE_MESH{"Shape", "trianglemesh"};
const PlugInName BOX{"Shape", "box"};
const PlugInName PHOTON_MAP{"Integrator", "photonmap"};
const PlugInName PATH{"Integrator", "path"};
const PlugInName RAYCAST{"Integrator", "raycast"};
const PlugInName PERSPECTIVE{"Camera", "perspective"};
const PlugInName SPHERICAL{"Camera", "spherical"};

} // namespace

const std::vector<OtherName>& otherNames() {
  static const std::vector<OtherName> NAMES = {
      {"ambient", {INFINITE_LIGHT}},
      {"ao", {{"Integrator", "ambientocclusion"}}},
      {"area", {AREA_LIGHT}},
      {"cube", {BOX}},
      {"directional", {DISTANT}},
      {"directlighting", {RAYCAST}},
      {"disney", {COATED_DIFFUSE, COATED_CONDUCTOR}},
      {"donut", {{"Shape", "torus"}}},
      {"emission", {AREA_LIGHT}},
      {"emissive", {AREA_LIGHT}},
      {"emitter", {AREA_LIGHT}},
      {"env", {INFINITE_LIGHT}},
      {"environment", {INFINITE_LIGHT, SPHERICAL}},
      {"envmap", {INFINITE_LIGHT}},
      {"exinfinite", {INFINITE_LIGHT}},
      {"exphotonmap", {PHOTON_MAP}},
      {"fbx", {MODEL_FILE}},
      {"fog", {HOMOGENEOUS, UNIFORM_GRID}},
      {"fourier", {MEASURED}},
      {"ggx", {CONDUCTOR, DIELECTRIC}},
      {"glass", {DIELECTRIC, THIN_DIELECTRIC}},
      {"gltf", {MODEL_FILE}},
      {"gold", {CONDUCTOR}},
      {"grass", {{"Shape", "curve"}}},
      {"haze", {HOMOGENEOUS}},
      {"hdri", {INFINITE_LIGHT}},
      {"henyeygreenstein", {{"phase", "hg"}}},
      {"heterogeneous", {UNIFORM_GRID, NANOVDB}},
      {"ies", {GONIOMETRIC}},
      {"kdsubsurface", {SUBSURFACE}},
      {"lambert", {DIFFUSE}},
      {"lambertian", {DIFFUSE}},
      {"lamp", {AREA_LIGHT}},
      {"lens", {PERSPECTIVE, {"Camera", "realistic"}}},
      {"light", {AREA_LIGHT, {"LightSource", "point"}}},
      {"lowdiscrepancy", {{"Sampler", "sobol"}}},
      {"matt", {DIFFUSE}},
      {"matte", {DIFFUSE}},
      {"merl", {MEASURED}},
      {"mesh", {AREA_LIGHT}},
      {"metal", {CONDUCTOR}},
      {"microfacet", {CONDUCTOR, DIELECTRIC}},
      {"milk", {SUBSURFACE, HOMOGENEOUS}},
      {"mirror", {CONDUCTOR}},
      {"nurbs", {{"Shape", "bezierpatch"}}},
      {"obj", {MODEL_FILE}},
      {"openvdb", {NANOVDB}},
      {"panorama", {SPHERICAL}},
      {"pathtracer", {PATH}},
      {"pathtracing", {PATH}},
      {"phong", {BLINN_PHONG, {"Material", "ashikhminshirley"}}},
      {"photons", {PHOTON_MAP}},
      {"pinhole", {PERSPECTIVE}},
      {"plane", {BILINEAR_MESH}},
      {"ply", {{"Shape", "plymesh"}}},
      {"principled", {COATED_DIFFUSE, COATED_CONDUCTOR}},
      {"pt", {PATH}},
      {"quad", {BILINEAR_MESH}},
      {"random", {{"Sampler", "independent"}}},
      {"rectangle", {BILINEAR_MESH}},
      {"skin", {SUBSURFACE}},
      {"smoke", {UNIFORM_GRID, NANOVDB}},
      {"specular", {CONDUCTOR, DIELECTRIC}},
      {"sss", {SUBSURFACE}},
      {"stl", {MODEL_FILE}},
      {"substrate", {COATED_DIFFUSE}},
      {"sun", {DISTANT, SKY}},
      {"translucent", {{"Material", "diffusetransmission"}, SUBSURFACE}},
      {"triangle", {TRIANGLE_MESH}},
      {"uber", {COATED_DIFFUSE, PLASTIC}},
      {"vdb", {NANOVDB}},
      {"volume", {HOMOGENEOUS, UNIFORM_GRID}},
      {"water", {DIELECTRIC}},
      {"wax", {SUBSURFACE}},
      {"window", {THIN_DIELECTRIC}},
  };
  return NAMES;
}

std::vector<PlugInName> plugInsMeantBy(const std::string& word) {
  const std::string lower = lowerCase(word);
  for (const OtherName& other : otherNames())
    if (other.word == lower) return other.meant;
  return {};
}

std::vector<std::string> likelyNames(const std::string& kind, const std::string& wrong,
                                     const std::vector<std::string>& names) {
  std::vector<std::string> likely;
  const auto add = [&](const std::string& name) {
    if (std::find(likely.begin(), likely.end(), name) == likely.end()) likely.push_back(name);
  };
  for (const PlugInName& meant : plugInsMeantBy(wrong))
    if (meant.kind == kind && std::find(names.begin(), names.end(), meant.name) != names.end())
      add(meant.name);
  for (const std::string& name : nearestNames(wrong, names)) add(name);
  return likely;
}

} // namespace recurse
