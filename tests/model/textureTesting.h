/** @file
 * Textures from scene-file text, and small picture files for them.
 */
#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <unistd.h>

#include "recurse/core/image/image.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/texture/textureMapping.h"

namespace recurse::testing {

/** Lookup of textures that a test has made; "name" gives the same texture for float and spectrum. */
class Textures final : public TextureLookup {
 public:
  TexturedRgb rgb(const Parameters& p, const std::string& n) const override {
    return find(p, n, [&] { return Rgb(p.spectrum(n)); });
  }
  TexturedRgb real(const Parameters& p, const std::string& n) const override {
    return find(p, n, [&] { return Rgb(static_cast<float>(p.real(n))); });
  }
  std::map<std::string, const Texture*> named;

 private:
  template <class F> TexturedRgb find(const Parameters& p, const std::string& n, const F& constant) const {
    if (p.texture(n).empty()) return {constant()};
    return {BLACK, named.at(p.texture(n)), float(p.range(n).first), float(p.range(n).second)};
  }
};

/** Null, and diagnostics, in case of an error. */
inline std::unique_ptr<Texture> tryTexture(const std::string& name, const std::string& parameters,
                                           const TextureContext& context, Diagnostics& diagnostics) {
  return plugIns().textures.make(parseParameterText(name, parameters), context, diagnostics);
}

inline std::unique_ptr<Texture> makeTexture(const std::string& name, const std::string& parameters,
                                            bool spectrum = true, const Mat4d& worldFromTexture = Mat4d(1),
                                            const Textures& textures = {}) {
  Diagnostics diagnostics;
  auto made = tryTexture(name, parameters, {textures, spectrum, worldFromTexture, nullptr}, diagnostics);
  EXPECT_TRUE(made) << name << " " << parameters << "\n" << diagnostics.format();
  return made;
}

/** Point of the plane z = 0 with u = x, v = y. */
inline SurfacePoint flatPoint(double u, double v) {
  SurfacePoint p{};
  p.uv = Vec2f(Vec2d(u, v));
  p.position = Vec3f(p.uv, 0);
  p.geometricNormal = p.shadingNormal = {0, 0, 1};
  p.dpdu = {1, 0, 0};
  p.dpdv = {0, 1, 0};
  return p;
}
inline SurfacePoint pointAt(const Vec3f& position) {
  SurfacePoint p = flatPoint(0, 0);
  p.position = position;
  return p;
}
/** Point with a footprint as seen from above. */
inline SurfacePoint seen(SurfacePoint p, float width) {
  p.footprint = {{0, 0, -1}, width};
  return p;
}

/** A folder for the files of a test, removed at the end. */
class Folder {
 public:
  Folder()
      : path(std::filesystem::temp_directory_path() / ("recurse-textures-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string file(const std::string& name) const { return (path / name).string(); }
  /** Writes f(x, y) for each pixel, row 0 at the top. */
  template <class F> std::string picture(const std::string& name, int width, int height, const F& f) const {
    Image image(width, height, {"R", "G", "B"});
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const Rgb c = f(x, y);
        for (int k = 0; k < 3; ++k) image.at(x, y)[k] = c[k];
      }
    writeImage(file(name), image);
    return file(name);
  }

 private:
  std::filesystem::path path;
};

inline void expectNear(const Rgb& found, const Rgb& wanted, double tolerance, const std::string& what = "") {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], wanted[k], tolerance) << what << " channel " << k;
}

} // namespace recurse::testing
