/** @file
 * Ids of the surfaces that camera rays hit, with their coverage of each pixel.
 */
#include "render/cryptomatte.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <map>
#include <set>

#include "recurse/core/threads/parallel.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

/** Samples of a pixel: the resolution of coverage is about 1 / SAMPLES. */
constexpr int SAMPLES = 64;
/** Ids of a pixel with the largest coverage that are kept, two in each RGBA layer. */
constexpr size_t RANKS = 6;
/** Longest chain of mirrors and glass that a sample is followed through [vertices]. */
constexpr int MAX_SEEN_THROUGH = 16;

/** Object and material that one sample sees. */
struct SeenObject {
  bool something = false;
  uint32_t object = 0;
  const Material* material = nullptr;
};

class IdWalk {
 public:
  IdWalk(const Scene& scene, bool throughSpecular)
      : scene(scene), throughSpecular(throughSpecular), walker(scene, classes, counts, -1, InMedia::IGNORE) {}

  SeenObject see(const CameraRay& ray, Sampler& sampler) {
    CameraSubpath path = startCameraSubpath(scene, classes, ray, counts);
    CameraVertex vertex;
    SeenObject out;
    const auto take = [&](const Hit& hit) {
      if (!out.something) out = {true, hit.object, hit.material};
    };
    const auto onEmission = [&](const Hit* hit) {
      if (hit) take(*hit);
    };
    for (int i = 0; walker.next(path, vertex, sampler, onEmission); ++i) {
      if (out.something) break;
      const bool isSpecular = (vertex.scattering->lobes() & NON_DELTA_LOBES) == 0;
      if (!throughSpecular || !isSpecular || i >= MAX_SEEN_THROUGH) take(vertex.hit);
      if (out.something || !walker.scatter(path, vertex, sampler)) break;
    }
    return out;
  }

 private:
  const Scene& scene;
  const bool throughSpecular;
  PathClasses classes;
  TransportCounts counts;
  CameraWalker walker;
};

/** Ids of a pixel with their weights, in a list: few pixels show more than a handful. */
class Coverage {
 public:
  void add(uint32_t id, float weight) {
    const auto same = std::find_if(parts.begin(), parts.end(), [&](const auto& p) { return p.id == id; });
    if (same == parts.end())
      parts.push_back({id, weight});
    else
      same->weight += weight;
  }
  /** Writes the id and the fraction of `total` of the RANKS largest weights, and clears the list. */
  void write(float total, float* channels) {
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
      return a.weight != b.weight ? a.weight > b.weight : a.id < b.id;
    });
    for (size_t i = 0; i < std::min(parts.size(), RANKS) && parts[i].weight > 0; ++i) {
      channels[2 * i] = std::bit_cast<float>(parts[i].id);
      channels[2 * i + 1] = parts[i].weight / total;
    }
    parts.clear();
  }

 private:
  struct Part {
    uint32_t id;
    float weight;
  };
  std::vector<Part> parts;
};

std::string hexadecimal(uint32_t id) {
  char text[9];
  std::snprintf(text, sizeof text, "%08x", id);
  return text;
}

std::string jsonString(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < ' ')
      out += "\\u00" + hexadecimal(static_cast<unsigned char>(c)).substr(6);
    else
      out += c;
  }
  return out + '"';
}

/** Adds the channel names and the metadata of one matte. */
void describe(const std::string& name, const std::set<std::string>& names, Image& image) {
  for (size_t layer = 0; layer < RANKS / 2; ++layer)
    for (const char letter : {'R', 'G', 'B', 'A'})
      image.channels.push_back(name + "0" + std::to_string(layer) + "." + letter);
  std::string manifest;
  for (const std::string& n : names)
    manifest += (manifest.empty() ? "" : ",") + jsonString(n) + ":\"" + hexadecimal(cryptomatteId(n)) + "\"";
  const std::string key = "cryptomatte/" + hexadecimal(cryptomatteId(name)).substr(0, 7) + "/";
  image.metadata[key + "name"] = name;
  image.metadata[key + "hash"] = "MurmurHash3_32";
  image.metadata[key + "conversion"] = "uint32_to_float32";
  image.metadata[key + "manifest"] = "{" + manifest + "}";
}

} // namespace

uint32_t cryptomatteId(const std::string& name) {
  constexpr uint32_t C1 = 0xcc9e2d51, C2 = 0x1b873593;
  const auto scrambled = [](uint32_t k) { return std::rotl(k * C1, 15) * C2; };
  uint32_t h = 0;
  const size_t whole = name.size() / 4 * 4;
  const auto bytes = [&](size_t first, size_t last) {
    uint32_t k = 0;
    for (size_t i = last; i-- > first;) k = k << 8 | static_cast<unsigned char>(name[i]);
    return k;
  };
  for (size_t i = 0; i < whole; i += 4) h = std::rotl(h ^ scrambled(bytes(i, i + 4)), 13) * 5 + 0xe6546b64;
  h ^= scrambled(bytes(whole, name.size()));
  h ^= static_cast<uint32_t>(name.size());
  h = (h ^ h >> 16) * 0x85ebca6b;
  h = (h ^ h >> 13) * 0xc2b2ae35;
  h ^= h >> 16;
  const uint32_t exponent = h >> 23 & 255;
  return exponent == 0 || exponent == 255 ? h ^ 1u << 23 : h;
}

Image renderCryptomattes(const Scene& scene, const CryptomatteSettings& settings) {
  if (!settings.objects && !settings.materials) return {};
  const PixelBounds& crop = scene.film().crop;
  const size_t mattes = size_t(settings.objects) + size_t(settings.materials), stride = mattes * RANKS * 2;
  Image out;
  out.width = crop.width();
  out.height = crop.height();
  out.pixels.resize(crop.area() * stride);
  struct RowNames {
    std::set<uint32_t> objects;
    std::set<const Material*> materials;
  };
  std::vector<RowNames> seenInRows(static_cast<size_t>(out.height));
  parallelFor(size_t(out.height), [&](size_t row) {
    IdWalk walk(scene, settings.throughSpecular);
    Coverage objects, materials;
    std::map<uint32_t, uint32_t> objectIds;
    std::map<const Material*, uint32_t> materialIds;
    for (int x = 0; x < out.width; ++x) {
      const Vec2f centre(float(x + crop.x0) + 0.5f, float(int(row) + crop.y0) + 0.5f);
      const uint64_t stream = uint64_t(uint32_t(int(row) + crop.y0)) << 32 | uint32_t(x + crop.x0);
      float total = 0;
      for (int i = 0; i < SAMPLES; ++i) {
        Sampler sampler(settings.seed, stream, uint32_t(i));
        const Filter::Sample f = scene.filter().sample(sampler.next2D());
        const float weight = std::max(f.weight, 0.0f);
        CameraSample sample{centre + f.offset};
        sample.lens = sampler.next2D();
        sample.time = scene.camera().timeAt(sampler.next1D());
        const std::optional<CameraRay> ray = scene.camera().validRay(sample);
        total += weight;
        const SeenObject seen = ray ? walk.see(*ray, sampler) : SeenObject();
        if (!seen.something) continue;
        const auto [object, isNew] = objectIds.try_emplace(seen.object, 0u);
        if (isNew) object->second = cryptomatteId(scene.objectName(seen.object));
        objects.add(object->second, weight);
        const auto [material, isNewMaterial] = materialIds.try_emplace(seen.material, 0u);
        const std::string name = isNewMaterial ? scene.materialName(seen.material) : "";
        if (!name.empty()) material->second = cryptomatteId(name);
        if (material->second != 0) materials.add(material->second, weight);
      }
      float* channels = &out.pixels[(row * size_t(out.width) + size_t(x)) * stride];
      if (settings.objects) objects.write(total, channels);
      if (settings.materials) materials.write(total, channels + (settings.objects ? RANKS * 2 : 0));
    }
    for (const auto& o : objectIds) seenInRows[row].objects.insert(o.first);
    for (const auto& m : materialIds) seenInRows[row].materials.insert(m.first);
  });
  std::set<std::string> objectNames, materialNames;
  for (const RowNames& row : seenInRows) {
    for (const uint32_t o : row.objects) objectNames.insert(scene.objectName(o));
    for (const Material* m : row.materials)
      if (const std::string name = scene.materialName(m); !name.empty()) materialNames.insert(name);
  }
  if (settings.objects) describe("CryptoObject", objectNames, out);
  if (settings.materials) describe("CryptoMaterial", materialNames, out);
  return out;
}

} // namespace recurse
