/** @file
 * Conversion of the materials of models that Assimp has read.
 */
#include "importers/assimp/assimpMaterials.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>

#include "importers/files/outsideFiles.h"
#include "recurse/core/image/image.h"

namespace recurse {

namespace {

double clamp01(double x) { return x > 0 ? std::min(x, 1.0) : 0; } // 0 for NaN

template <class T> bool get(const aiMaterial& m, const char* key, unsigned type, unsigned i, T& value) {
  return m.Get(key, type, i, value) == AI_SUCCESS;
}

double number(const aiMaterial& m, const char* key, unsigned type, unsigned i, double otherwise) {
  float value = 0;
  return get(m, key, type, i, value) && std::isfinite(value) ? double(value) : otherwise;
}

/** Parameters of an imagemap for the placement of a picture on the surface. */
std::string layout(const aiMaterial& m, aiTextureType type) {
  std::string text;
  aiUVTransform transform;
  if (get(m, AI_MATKEY_UVTRANSFORM(type, 0), transform)) {
    const auto add = [&text](const char* name, float value, float usual) {
      if (value != usual && std::isfinite(value))
        text += std::string(" \"float ") + name + "\" " + sceneText(double(value));
    };
    add("uscale", transform.mScaling.x, 1);
    add("vscale", transform.mScaling.y, 1);
    add("udelta", transform.mTranslation.x, 0);
    add("vdelta", transform.mTranslation.y, 0);
  }
  int wrap = aiTextureMapMode_Wrap;
  if (get(m, AI_MATKEY_MAPPINGMODE_U(type, 0), wrap) && wrap == aiTextureMapMode_Clamp)
    text += " \"string wrap\" \"clamp\"";
  return text.empty() ? text : text.substr(1);
}

std::string spectrumParameter(const char* name, const AssimpValue& v) {
  if (!v.texture.empty()) return std::string("\"texture ") + name + "\" " + sceneText(v.texture);
  return std::string("\"rgb ") + name + "\" [ " +
         sceneText(Vec3d(clamp01(v.factor.r), clamp01(v.factor.g), clamp01(v.factor.b))) + " ]";
}

std::string floatParameter(const char* name, const AssimpValue& v) {
  if (!v.texture.empty()) return std::string("\"texture ") + name + "\" " + sceneText(v.texture);
  return std::string("\"float ") + name + "\" " + sceneText(v.factor.r);
}

static constexpr const char* REMAP_OFF = " \"bool remaproughness\" false";

std::string glass(const aiMaterial& m, double eta, const std::string& bumps) {
  const bool solid = number(m, AI_MATKEY_VOLUME_THICKNESS_FACTOR, 0) > 0;
  const double rough = number(m, AI_MATKEY_ROUGHNESS_FACTOR, 0);
  return std::string("Material \"") + (solid ? "dielectric" : "thindielectric") + "\" \"float eta\" " +
         sceneText(eta) +
         (solid ? " \"float roughness\" " + sceneText(clamp01(rough * rough)) + REMAP_OFF : "") + bumps;
}

} // namespace

Rgbd colourOf(const aiColor3D& c) {
  const auto component = [](float x) { return std::isfinite(x) ? double(x) : 0; };
  return {component(c.r), component(c.g), component(c.b)};
}

AssimpMaterials::AssimpMaterials(const aiScene& scene, const std::string& path, const Parameters& p,
                                 SceneImport& import, ImportWriter& out)
    : scene(scene), p(p), import(import), out(out), path(path),
      directory(std::filesystem::path(path).parent_path().string()), lightsWanted(p.boolean("lights")),
      materials(scene.mNumMaterials) {}

const AssimpMaterials::Made& AssimpMaterials::at(unsigned index) {
  Made& m = materials.at(index);
  if (!m.made) {
    m.made = true;
    make(*scene.mMaterials[index], m);
  }
  return m;
}

/** File of a material's picture, stored for the scene; empty where there is none. `wanted` becomes true
 * where the material names a picture, found or not. */
std::string AssimpMaterials::picture(const aiMaterial& m, aiTextureType type, bool& wanted) {
  aiString name;
  if (m.GetTexture(type, 0, &name) != AI_SUCCESS || name.length == 0) return {};
  wanted = true;
  const std::string key = name.C_Str();
  const auto known = pictures.find(key);
  if (known != pictures.end()) return known->second;
  return pictures[key] = loadPicture(key);
}

std::string AssimpMaterials::loadPicture(const std::string& name) {
  if (const aiTexture* inside = scene.GetEmbeddedTexture(name.c_str())) return embedded(*inside);
  const std::string file = findModelFile(directory, name);
  if (!file.empty() && !mayRead(file, path, p)) return {};
  if (!file.empty()) {
    try {
      return out.copyFile(file);
    } catch (const Error& e) {
      p.warn("filename", e.what());
      return {};
    }
  }
  p.warn("filename", path + ": there is no picture \"" + name + "\"; a checkerboard replaces it");
  return {};
}

std::string AssimpMaterials::embedded(const aiTexture& texture) {
  const char* bytes = reinterpret_cast<const char*>(texture.pcData);
  if (texture.mHeight == 0) {
    std::string extension = texture.achFormatHint;
    return out.addFile("picture." + (extension.empty() ? "png" : extension),
                       std::string(bytes, texture.mWidth));
  }
  if (texture.mWidth > 0xffff || texture.mHeight > 0xffff) return {};
  std::string tga(18, '\0'); // the texels are BGRA, as in TGA
  tga[2] = 2;
  tga[12] = static_cast<char>(texture.mWidth & 255);
  tga[13] = static_cast<char>(texture.mWidth >> 8);
  tga[14] = static_cast<char>(texture.mHeight & 255);
  tga[15] = static_cast<char>(texture.mHeight >> 8);
  tga[16] = 32;
  tga[17] = 0x28;
  tga.append(bytes, size_t(4) * texture.mWidth * texture.mHeight);
  return out.addFile("picture.tga", tga);
}

/** Colour value: `factor` times a picture. */
AssimpValue AssimpMaterials::spectrumValue(const aiMaterial& m, aiTextureType type, const Rgbd& factor) {
  bool wanted = false;
  const std::string file = picture(m, type, wanted);
  AssimpValue v{factor, ""};
  if (!wanted) return v;
  if (file.empty()) return {Rgbd(1), out.missingTexture()};
  v.texture = out.imageTexture("spectrum", file, layout(m, type));
  // Exporters that mean the picture alone write a black factor.
  if (factor != Rgbd(1) && factor != Rgbd(0)) {
    const std::string scaled = out.uniqueName(v.texture + "_scaled");
    out.line("Texture " + sceneText(scaled) + " \"spectrum\" \"scale\" \"texture tex\" " +
             sceneText(v.texture) + " \"rgb tint\" [ " + sceneText(Vec3d(factor)) + " ]");
    v.texture = scaled;
  }
  return v;
}

/** Float value: one channel of a picture times a number. */
AssimpValue AssimpMaterials::channelValue(const aiMaterial& m, aiTextureType type, const char* channel,
                                          double factor) {
  bool wanted = false;
  const std::string file = picture(m, type, wanted);
  AssimpValue v{Rgbd(factor), ""};
  if (file.empty()) return v;
  std::string more = layout(m, type);
  more += (more.empty() ? "" : " ") + std::string("\"string encoding\" \"linear\" \"string channel\" \"") +
          channel + "\" \"float scale\" " + sceneText(factor);
  v.texture = out.imageTexture("float", file, more);
  return v;
}

/** Roughness of glTF is the square root of alpha; pbrt's roughness, without remapping, is its square. */
std::string AssimpMaterials::roughness(const aiMaterial& m, double factor) {
  AssimpValue v = channelValue(m, aiTextureType_DIFFUSE_ROUGHNESS, "green", clamp01(factor));
  if (v.texture.empty()) return "\"float roughness\" " + sceneText(v.factor.r * v.factor.r) + REMAP_OFF;
  const std::string squared = out.uniqueName(v.texture + "_squared");
  out.line("Texture " + sceneText(squared) + " \"float\" \"scale\" \"texture tex\" " + sceneText(v.texture) +
           " \"texture scale\" " + sceneText(v.texture));
  return "\"texture roughness\" " + sceneText(squared) + REMAP_OFF;
}

/** Warns of numbers that are no colours or not finite: other values replace them. */
void AssimpMaterials::warnOfNumbers(const aiMaterial& m) {
  for (unsigned i = 0; i < m.mNumProperties; ++i) {
    const aiMaterialProperty& property = *m.mProperties[i];
    if (property.mType != aiPTI_Float) continue;
    const std::string key = property.mKey.C_Str();
    std::vector<float> numbers(property.mDataLength / sizeof(float));
    std::memcpy(numbers.data(), property.mData, numbers.size() * sizeof(float));
    if (std::ranges::any_of(
            numbers, [&](float x) { return !std::isfinite(x) || (x < 0 && key.starts_with("$clr.")); }))
      p.warn("filename", path + ": material \"" + m.GetName().C_Str() + "\": " + key +
                             " has a number that is negative or not finite; another replaces it");
  }
}

void AssimpMaterials::make(const aiMaterial& m, Made& made) {
  warnOfNumbers(m);
  aiColor4D base4(1, 1, 1, 1);
  const bool isPhysical = m.GetTextureCount(aiTextureType_BASE_COLOR) > 0 ||
                          get(m, AI_MATKEY_BASE_COLOR, base4) || get(m, AI_MATKEY_ROUGHNESS_FACTOR, base4.r);
  const std::string name = m.GetName().C_Str();
  const std::string bumps = normalMap(m);
  const double transmission = number(m, AI_MATKEY_TRANSMISSION_FACTOR, 0);
  const aiTextureType colourType =
      m.GetTextureCount(aiTextureType_BASE_COLOR) > 0 ? aiTextureType_BASE_COLOR : aiTextureType_DIFFUSE;
  int uvSource = 0;
  if (get(m, AI_MATKEY_UVWSRC(colourType, 0), uvSource) && uvSource > 0)
    made.uvChannel = static_cast<unsigned>(uvSource);
  const double index = number(m, AI_MATKEY_REFRACTI, 1.5);
  const double eta = index > 1.01 && index < 10 ? index : 1.5;
  if (transmission > 0.5) {
    made.directive = glass(m, eta, bumps);
  } else if (isPhysical) {
    made.directive = metalAndRoughness(m, name, colourType, eta, bumps);
  } else {
    made.directive = classic(m, colourType, eta, bumps, made);
  }
  readAlpha(m, colourType, made);
  readEmission(m, made);
  ++materialCount;
}

std::string AssimpMaterials::normalMap(const aiMaterial& m) {
  bool wanted = false;
  // Assimp reports "bump" of MTL as a height map, which is not a normal map.
  const std::string file = picture(m, aiTextureType_NORMALS, wanted);
  return file.empty() ? "" : " \"string normalmap\" " + sceneText(file);
}

std::string AssimpMaterials::metalAndRoughness(const aiMaterial& m, const std::string& name,
                                               aiTextureType colourType, double eta,
                                               const std::string& bumps) {
  aiColor4D base(1, 1, 1, 1);
  if (!get(m, AI_MATKEY_BASE_COLOR, base)) get(m, AI_MATKEY_COLOR_DIFFUSE, base);
  const AssimpValue colour = spectrumValue(m, colourType, colourOf({base.r, base.g, base.b}));
  const std::string reflectance = spectrumParameter("reflectance", colour);
  const std::string rough = " " + roughness(m, number(m, AI_MATKEY_ROUGHNESS_FACTOR, 1));
  const AssimpValue metal =
      channelValue(m, aiTextureType_METALNESS, "blue", clamp01(number(m, AI_MATKEY_METALLIC_FACTOR, 1)));
  const std::string coat = "\"plastic\" \"float eta\" " + sceneText(eta) + " " + reflectance + rough;
  const std::string conductor = "\"conductor\" " + reflectance + rough;
  if (metal.texture.empty() && metal.factor.r <= 0) return "Material " + coat + bumps;
  if (metal.texture.empty() && metal.factor.r >= 1) return "Material " + conductor + bumps;
  const std::string first = out.uniqueName(name + "_coat"), second = out.uniqueName(name + "_metal");
  out.line("MakeNamedMaterial " + sceneText(first) + " \"string type\" " + coat);
  out.line("MakeNamedMaterial " + sceneText(second) + " \"string type\" " + conductor);
  return "Material \"mix\" \"string materials\" [ " + sceneText(first) + " " + sceneText(second) + " ] " +
         floatParameter("amount", metal) + bumps;
}

/** Material of Phong's model or one of its relatives. */
std::string AssimpMaterials::classic(const aiMaterial& m, aiTextureType colourType, double eta,
                                     const std::string& bumps, Made& made) {
  aiColor3D diffuse(0.6f, 0.6f, 0.6f), specular(0, 0, 0);
  get(m, AI_MATKEY_COLOR_DIFFUSE, diffuse);
  get(m, AI_MATKEY_COLOR_SPECULAR, specular);
  const double exponent = number(m, AI_MATKEY_SHININESS, 0);
  int illumination = 2;
  get(m, AI_MATKEY_OBJ_ILLUM, illumination);
  const double opacity = clamp01(number(m, AI_MATKEY_OPACITY, 1));
  const double shine = maxComponent(colourOf(specular)), body = maxComponent(colourOf(diffuse));
  // Alpha of a microfacet lobe as wide as the Phong lobe; exponents from 1000 on mean a mirror in MTL.
  const double alpha = exponent >= 999 ? 0 : std::sqrt(2 / (std::max(exponent, 0.0) + 2));
  const std::string rough = " \"float roughness\" " + sceneText(clamp01(alpha)) + REMAP_OFF;
  const bool refracts = illumination == 4 || illumination == 6 || illumination == 7 || illumination == 9;
  const bool hasIndex = number(m, AI_MATKEY_REFRACTI, 1) > 1.01;
  if (refracts || (opacity < 0.5 && hasIndex)) {
    made.shapeParameters.clear();
    return "Material \"dielectric\" \"float eta\" " + sceneText(eta) + bumps;
  }
  if ((illumination == 3 || illumination == 5 || illumination == 8) && shine > 0.3 && body < 0.3 * shine)
    return "Material \"conductor\" " + spectrumParameter("reflectance", {colourOf(specular), ""}) + rough +
           bumps;
  const std::string reflectance =
      spectrumParameter("reflectance", spectrumValue(m, colourType, colourOf(diffuse)));
  if (illumination < 2 || shine < 0.02 || exponent <= 1) return "Material \"diffuse\" " + reflectance + bumps;
  return "Material \"plastic\" \"float eta\" " + sceneText(eta) + " " + reflectance + rough + bumps;
}

void AssimpMaterials::readAlpha(const aiMaterial& m, aiTextureType colourType, Made& made) {
  if (made.directive.find("dielectric\"") != std::string::npos) return;
  double opacity = clamp01(number(m, AI_MATKEY_OPACITY, 1));
  if (opacity == 0) opacity = 1; // exporters disagree on its sense; nobody intends an invisible model
  aiString mode;
  const bool hasMode = get(m, AI_MATKEY_GLTF_ALPHAMODE, mode);
  bool wanted = false;
  if (hasMode && std::string(mode.C_Str()) == "OPAQUE") return;
  const aiTextureType type =
      m.GetTextureCount(aiTextureType_OPACITY) > 0 ? aiTextureType_OPACITY : colourType;
  if (type == aiTextureType_OPACITY || hasMode) {
    if (const std::string file = picture(m, type, wanted); !file.empty()) {
      std::string more =
          layout(m, type) + " \"string encoding\" \"linear\" \"float scale\" " + sceneText(opacity);
      if (hasMode) more += " \"string channel\" \"alpha\"";
      if (std::string(mode.C_Str()) == "MASK")
        more += " \"float threshold\" " + sceneText(number(m, AI_MATKEY_GLTF_ALPHACUTOFF, 0.5));
      if (hasMode && !hasAlpha(file)) return;
      made.shapeParameters = "\"texture alpha\" " + sceneText(out.imageTexture("float", file, more));
      return;
    }
  }
  if (opacity < 1) made.shapeParameters = "\"float alpha\" " + sceneText(opacity);
}

/** Whether a picture has an alpha channel; without one it is opaque. */
bool AssimpMaterials::hasAlpha(const std::string& file) const {
  try {
    return readImage({file, import.files.at(file)}).channel("A") >= 0;
  } catch (const Error&) {
    return false; // the error is reported where it is used as a colour
  }
}

void AssimpMaterials::readEmission(const aiMaterial& m, Made& made) {
  aiColor3D colour(0, 0, 0);
  get(m, AI_MATKEY_COLOR_EMISSIVE, colour);
  double strength = number(m, AI_MATKEY_EMISSIVE_INTENSITY, 1);
  if (!(strength > 0)) strength = 1;
  Rgbd light = colourOf(colour) * strength;
  bool wanted = false;
  const std::string file = picture(m, aiTextureType_EMISSIVE, wanted);
  if (!file.empty() && !(maxComponent(light) > 0)) light = Rgbd(1);
  if (!lightsWanted || !(maxComponent(light) > 0) || !std::isfinite(maxComponent(light))) return;
  int twoSided = 0;
  get(m, AI_MATKEY_TWOSIDED, twoSided);
  made.areaLight = "AreaLightSource \"diffuse\" " +
                   (file.empty() ? "\"rgb L\" [ " + sceneText(Vec3d(light)) + " ]"
                                 : "\"string filename\" " + sceneText(file) + " \"float scale\" " +
                                       sceneText(luminance(light))) +
                   (twoSided ? " \"bool twosided\" true" : "") + "\n";
  import.hasLights = true;
  ++emitters;
}

} // namespace recurse
