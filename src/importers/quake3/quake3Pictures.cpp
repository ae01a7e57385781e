/** @file
 * Finding, decoding and averaging of pictures.
 */
#include "importers/quake3/quake3Pictures.h"

#include "importers/quake3/gameShader.h"

namespace recurse {

namespace {

template <class Coding> Rgbd sumOf(const Image& image, const Coding& code) {
  Rgbd sum(0);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) sum[c] += double(code(image.at(x, y)[c]));
  return sum;
}
Rgbd codedSum(const Image& image) {
  return sumOf(image, [](float x) { return srgbFromLinear(x); });
}

} // namespace

std::string Quake3Pictures::find(const std::string& name) {
  if (name.empty()) return {};
  const std::string key = gameShaderName(name);
  const auto known = files.find(key);
  if (known != files.end()) return known->second;
  for (const char* extension : {".tga", ".jpg", ".jpeg", ".png", ".pcx"})
    if (const std::string found = key + extension; game.has(found)) {
      const std::string file = out.addFile(found, game.read(found));
      try {
        decoded[file] = readImage({file, import.files.at(file)});
        return files[key] = file;
      } catch (const Error& e) {
        p.warn("pak", game.where(found) + ": " + e.what());
        import.files.erase(file);
      }
    }
  return files[key] = "";
}

Rgbd Quake3Pictures::lightColour(const std::string& file) const {
  const auto found = decoded.find(file);
  if (found == decoded.end()) return Rgbd(1);
  const Rgbd sum = codedSum(found->second);
  return maxComponent(sum) > 0 ? sum / double(maxComponent(sum)) : Rgbd(1);
}

double Quake3Pictures::meanMaximum(const std::string& file) const {
  const Image& picture = image(file);
  return double(maxComponent(sumOf(picture, [](float x) { return x; }))) /
         (double(picture.width) * picture.height);
}

double Quake3Pictures::meanOpacity(const std::string& file) const {
  const Image& picture = image(file);
  const double sum = codedSum(picture).r;
  return sum > 0 ? sum / (double(picture.width) * picture.height) : 1;
}

} // namespace recurse
