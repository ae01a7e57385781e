/** @file
 * Textures made of solid noise: fbm, wrinkled, windy, marble.
 */
#include "recurse/model/texture/noise.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Fbm final : public Texture {
 public:
  Fbm(const TextureSpace& space, const NoiseSum& noise) : space(space), noise(noise) {}
  Rgb value(const SurfacePoint& point) const override {
    return Rgb(static_cast<float>(noise.fractal(space.at(point))));
  }

 private:
  TextureSpace space;
  NoiseSum noise;
};

class Wrinkled final : public Texture {
 public:
  Wrinkled(const TextureSpace& space, const NoiseSum& noise) : space(space), noise(noise) {}
  Rgb value(const SurfacePoint& point) const override {
    return Rgb(static_cast<float>(noise.turbulence(space.at(point))));
  }

 private:
  TextureSpace space;
  NoiseSum noise;
};

MappedPoint scaled(MappedPoint m, double factor) {
  m.p *= factor;
  m.alongX *= factor;
  m.alongY *= factor;
  return m;
}

/** Waves whose height follows a wind that changes ten times as slowly. */
class Windy final : public Texture {
 public:
  explicit Windy(const TextureSpace& space) : space(space) {}
  Rgb value(const SurfacePoint& point) const override {
    const MappedPoint m = space.at(point);
    const double wind = NoiseSum{3, 0.5}.fractal(scaled(m, 0.1)), wave = NoiseSum{6, 0.5}.fractal(m);
    return Rgb(static_cast<float>(std::abs(wind) * wave));
  }

 private:
  TextureSpace space;
};

/** Layers across y, disturbed by noise, in the colours of pbrt's marble. */
class Marble final : public Texture {
 public:
  Marble(const TextureSpace& space, const NoiseSum& noise, double scale, double variation)
      : space(space), noise(noise), scale(scale), variation(variation) {}

  Rgb value(const SurfacePoint& point) const override {
    const MappedPoint m = scaled(space.at(point), scale);
    const double layer = 0.5 + 0.5 * std::sin(m.p.y + variation * noise.fractal(m));
    // Bézier curves over four control points each; the next one starts a point further.
    constexpr int SEGMENTS = 6;
    const double along = layer * SEGMENTS;
    const int first = std::min(static_cast<int>(along), SEGMENTS - 1);
    const double t = along - first, u = 1 - t;
    const double weights[4] = {u * u * u, 3 * t * u * u, 3 * t * t * u, t * t * t};
    Rgbd colour(0);
    for (int i = 0; i < 4; ++i) colour += weights[i] * COLOURS[first + i];
    return Rgb(colour * 1.5);
  }

 private:
  static constexpr Rgbd PALE{.58, .58, .6};
  static constexpr Rgbd COLOURS[9] = {PALE, PALE, PALE,          {.5, .5, .5}, {.6, .59, .58},
                                      PALE, PALE, {.2, .2, .33}, PALE};

  TextureSpace space;
  NoiseSum noise;
  double scale, variation;
};

} // namespace

void registerNoiseTextures(PlugIns& plugIns) {
  plugIns.textures.add({{.name = "fbm",
                         .summary = "Fractal noise in texture space; a float texture.",
                         .parameters = noiseParameters(),
                         .examples = {"", "\"integer octaves\" 4 \"float roughness\" .7"}},
                        [](const Parameters& p, const TextureContext& c) {
                          c.requireKind(p, false);
                          return std::make_unique<Fbm>(TextureSpace(c), noiseSum(p));
                        }});
  plugIns.textures.add(
      {{.name = "wrinkled",
        .summary = "Turbulence: fractal noise with creases in texture space; a float texture.",
        .parameters = noiseParameters(),
        .examples = {"", "\"integer octaves\" 4 \"float roughness\" .7"}},
       [](const Parameters& p, const TextureContext& c) {
         c.requireKind(p, false);
         return std::make_unique<Wrinkled>(TextureSpace(c), noiseSum(p));
       }});
  plugIns.textures.add({{.name = "windy",
                         .summary = "Waves like those of wind on water; a float texture.",
                         .parameters = {},
                         .examples = {""}},
                        [](const Parameters& p, const TextureContext& c) {
                          c.requireKind(p, false);
                          return std::make_unique<Windy>(TextureSpace(c));
                        }});
  std::vector<ParameterSpec> marble = noiseParameters();
  marble.push_back(realParameter("scale", "1", "factor on the coordinates"));
  marble.push_back(realParameter("variation", "0.2", "amplitude of the noise that displaces the layers"));
  plugIns.textures.add({{.name = "marble",
                         .summary = "Marble with layers along y; a spectrum texture.",
                         .parameters = marble,
                         .examples = {"", "\"float scale\" 3 \"float variation\" 2"}},
                        [](const Parameters& p, const TextureContext& c) {
                          c.requireKind(p, true);
                          return std::make_unique<Marble>(TextureSpace(c), noiseSum(p), p.real("scale"),
                                                          p.real("variation"));
                        }});
}

} // namespace recurse
