/** @file
 * Features of the first surface that scatters on each camera path.
 */
#include "recurse/render/featureLayers.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"
#include "render/cryptomatte.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

enum Feature { ALBEDO, NORMAL, GEOMETRIC_NORMAL, DEPTH, POSITION, GUIDE, FEATURES };

/** Features that one sample sees. */
struct SeenFeatures {
  bool surface = false;
  std::array<Vec3f, FEATURES> values{};
};

/** Longest chain of mirrors and glass that a sample is followed through [vertices]. */
constexpr int MAX_SPECULAR = 16;

bool contains(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/** Albedo for light from `wi`, estimated from one sample of the BSDF. */
Rgb sampledAlbedo(const CameraVertex& vertex, Sampler& sampler) {
  // Flux has no factor 1/η² at refraction, unlike radiance.
  const auto s = vertex.scattering->scatter(vertex.wi, Transport::FLUX, sampler, ALL_LOBES);
  return s ? clamp(s->weight, 0, 1) : BLACK;
}

class FeatureWalk {
 public:
  FeatureWalk(const Scene& scene, const Integrator& integrator, const FeatureSettings& settings)
      : scene(scene), integrator(integrator), throughSpecular(settings.throughSpecular),
        needsGuide(contains(settings.layers, featureLayers()[GUIDE].name)),
        walker(scene, classes, counts, -1, InMedia::IGNORE) {}

  SeenFeatures see(const CameraRay& ray, Sampler& sampler) {
    CameraSubpath path = startCameraSubpath(scene, classes, ray, counts);
    CameraVertex vertex;
    SeenFeatures out;
    double depth = 0;
    for (int i = 0; walker.next(path, vertex, sampler); ++i) {
      const SurfacePoint& point = vertex.point();
      depth += double(length(point.position - path.from));
      const bool isSpecular = !vertex.scattering->hasNonDelta(), isFollowed = isSpecular && i < MAX_SPECULAR;
      if (!out.surface && !(throughSpecular && isFollowed)) {
        out.surface = true;
        out.values[ALBEDO] = Vec3f(sampledAlbedo(vertex, sampler));
        out.values[NORMAL] = facing(point.shadingNormal, vertex.wi);
        out.values[GEOMETRIC_NORMAL] = facing(point.geometricNormal, vertex.wi);
        out.values[DEPTH] = Vec3f(static_cast<float>(depth));
        out.values[POSITION] = Vec3f(Vec3d(point.position) + scene.origin());
      }
      if (needsGuide && !isSpecular) out.values[GUIDE] = Vec3f(isGuided(vertex));
      if (!(isFollowed && (needsGuide || !out.surface)) || !walker.scatter(path, vertex, sampler)) return out;
    }
    return out;
  }

 private:
  static Vec3f facing(const Vec3f& normal, const Vec3f& wi) { return dot(normal, wi) < 0 ? -normal : normal; }
  /** Whether a camera path samples the guide at a vertex. */
  bool isGuided(const CameraVertex& vertex) const {
    return vertex.scattering->isGuidable() && integrator.directionsAt(vertex.point(), vertex.wi).isSampled;
  }

  const Scene& scene;
  const Integrator& integrator;
  const bool throughSpecular, needsGuide;
  PathClasses classes;
  TransportCounts counts;
  CameraWalker walker;
};

} // namespace

const std::vector<FeatureLayer>& featureLayers() {
  static const std::vector<FeatureLayer> ALL = {
      {"albedo", "RGB", "albedo: the fraction of light towards the camera that the surface scatters"},
      {"normal", "XYZ", "shading normal, towards the camera, in world space"},
      {"geonormal", "XYZ", "geometric normal of the surface"},
      {"depth", "Z", "distance along the ray from the camera"},
      {"position", "XYZ", "position in world space"},
      {"guide", "Y",
       "fraction of the samples whose first non-delta surface, seen directly or by mirrors and glass, has a "
       "guide that camera paths sample",
       false},
      {"cryptoobject", "", "Cryptomatte by objects"},
      {"cryptomaterial", "", "Cryptomatte by materials"}};
  return ALL;
}

void requireFeatureLayers(const std::vector<std::string>& names) {
  std::string there;
  for (const FeatureLayer& layer : featureLayers()) there.append(" ").append(layer.name);
  const auto refuseUnknown = [&](const std::string& name) {
    throw Error("--layers: there is no layer '" + name + "'; there are:" + there, ExitStatus::BAD_USAGE);
  };
  std::set<std::string> seen;
  for (const std::string& name : names) {
    const bool isKnown = std::any_of(featureLayers().begin(), featureLayers().end(),
                                     [&](const FeatureLayer& layer) { return name == layer.name; });
    if (!isKnown) refuseUnknown(name);
    if (!seen.insert(name).second)
      throw Error("--layers: '" + name + "' is given twice", ExitStatus::BAD_USAGE);
  }
}

void requireFeatureLayers(const std::vector<std::string>& names, const Integrator& integrator) {
  for (const FeatureLayer& layer : featureLayers())
    if (!layer.isOfScene && !integrator.learnsDirections() && contains(names, layer.name))
      throw Error(std::string("--layers: '") + layer.name +
                      "' is of path guiding; add --integrator path --set guided=true",
                  ExitStatus::BAD_USAGE);
}

Image renderFeatures(const Scene& scene, const Integrator& integrator, const FeatureSettings& settings) {
  requireFeatureLayers(settings.layers);
  requireFeatureLayers(settings.layers, integrator);
  const Image mattes = renderCryptomattes(scene, {contains(settings.layers, "cryptoobject"),
                                                  contains(settings.layers, "cryptomaterial"),
                                                  settings.throughSpecular, settings.seed});
  struct Channel {
    int feature, component;
  };
  std::vector<Channel> channels;
  std::vector<std::string> names;
  for (const std::string& name : settings.layers) {
    const auto& all = featureLayers();
    const auto layer = std::find_if(all.begin(), all.end(), [&](const auto& l) { return name == l.name; });
    for (int c = 0; layer->channels[c]; ++c) {
      channels.push_back({int(layer - all.begin()), c});
      names.push_back(name + "." + layer->channels[c]);
    }
  }
  if (names.empty()) return mattes;
  const PixelBounds& crop = scene.film().crop;
  Image out(crop.width(), crop.height(), names);
  parallelFor(size_t(out.height), [&](size_t row) {
    FeatureWalk walk(scene, integrator, settings);
    for (int x = 0; x < out.width; ++x) {
      const Vec2f corner(float(x + crop.x0), float(int(row) + crop.y0));
      const uint64_t stream = uint64_t(uint32_t(int(row) + crop.y0)) << 32 | uint32_t(x + crop.x0);
      std::array<Vec3d, FEATURES> sums{};
      int surfaces = 0;
      for (int i = 0; i < settings.samples; ++i) {
        Sampler sampler(settings.seed, stream, uint32_t(i));
        // Box filter over the pixel: negative lobes of a filter would falsify depths.
        CameraSample sample{corner + sampler.next2D()};
        sample.lens = sampler.next2D();
        sample.time = scene.camera().timeAt(sampler.next1D());
        const std::optional<CameraRay> ray = scene.camera().validRay(sample);
        const SeenFeatures seen = ray ? walk.see(*ray, sampler) : SeenFeatures();
        if (!seen.surface) continue;
        ++surfaces;
        for (size_t f = 0; f < FEATURES; ++f) sums[f] += Vec3d(seen.values[f]);
      }
      float* pixel = out.at(x, int(row));
      for (size_t c = 0; c < channels.size(); ++c) {
        const int count = channels[c].feature == ALBEDO ? settings.samples : std::max(surfaces, 1);
        pixel[c] = static_cast<float>(sums[size_t(channels[c].feature)][channels[c].component] / count);
      }
    }
  });
  return mattes.channels.empty() ? out : withChannels(out, mattes);
}

} // namespace recurse
