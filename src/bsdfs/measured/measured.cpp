/** @file
 * Measured BRDFs: isotropic ones from MERL binary files (Matusik, Pfister, Brand, McMillan 2003, "A
 * Data-Driven Reflectance Model"), a table over Rusinkiewicz' half and difference angles, sampled by a fitted
 * lobe; and any from the tensor files of EPFL's material database, as in pbrt-v4.
 */
#include <cstring>
#include <fstream>

#include "bsdfs/measured/adaptiveBrdf.h"
#include "bsdfs/measured/tensorFile.h"
#include "bsdfs/microfacet/microfacet.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/scene/sceneImport.h"

namespace recurse {

namespace {

/**
 * Table of a MERL file, scaled to 1/sr. Its indices, as in the format: half angle (finer towards 0, by its
 * square root), difference angle, azimuth of the difference from 0 to π (reciprocity gives the rest).
 */
class MerlTable {
 public:
  /** Throws std::runtime_error with a description of the fault. */
  explicit MerlTable(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot be opened");
    int32_t sizes[3];
    file.read(reinterpret_cast<char*>(sizes), sizeof sizes);
    if (file.gcount() != sizeof sizes) throw std::runtime_error("is shorter than the header of a MERL file");
    for (const int32_t s : sizes)
      if (s < 2 || s > 1024)
        throw std::runtime_error("is no MERL file: its header has " + std::to_string(sizes[0]) + " x " +
                                 std::to_string(sizes[1]) + " x " + std::to_string(sizes[2]) +
                                 " entries; usual are 90 x 90 x 180, and each may be 2 to 1024");
    halfCount = sizes[0];
    differenceCount = sizes[1];
    azimuthCount = sizes[2];
    const size_t count = size_t(halfCount) * size_t(differenceCount) * size_t(azimuthCount);
    std::vector<double> raw(3 * count);
    const auto bytes = static_cast<std::streamsize>(raw.size() * sizeof(double));
    file.read(reinterpret_cast<char*>(raw.data()), bytes);
    if (file.gcount() != bytes)
      throw std::runtime_error("ends after " + std::to_string(file.gcount() + 12) + " of " +
                               std::to_string(bytes + 12) + " bytes");
    if (file.peek() != std::char_traits<char>::eof())
      throw std::runtime_error("has more data after the " + std::to_string(bytes + 12) +
                               " bytes of its table");
    // Scales of the channels, from the reference reader of the format.
    constexpr double SCALE[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
    values.resize(count);
    for (size_t c = 0; c < 3; ++c)
      for (size_t i = 0; i < count; ++i) {
        const double v = raw[c * count + i];
        if (!std::isfinite(v) || std::abs(v) > 1e30)
          throw std::runtime_error("has an invalid reflectance at byte " +
                                   std::to_string(12 + 8 * (c * count + i)));
        // Negative values mark entries that could not be measured, near grazing.
        values[i][int(c)] = static_cast<float>(std::max(v, 0.0) * SCALE[c]);
      }
    fit();
  }

  /** BRDF [1/sr], linearly interpolated between the entries; both directions up. */
  Rgb at(const Vec3f& a, const Vec3f& b) const {
    const Vec3f h = halfVector(a, b);
    const float cosD = std::min(glm::dot(a, h), 1.0f);
    const float thetaH = std::atan2(std::hypot(h.x, h.y), h.z);
    const float thetaD = std::acos(std::max(cosD, 0.0f));
    // Difference vector: `a` in the frame of h whose x axis is in the plane of h and the normal.
    const float sineH = std::hypot(h.x, h.y);
    const Vec3f bent = sineH > 0 ? Vec3f(h.x * h.z / sineH, h.y * h.z / sineH, -sineH) : Vec3f(1, 0, 0);
    const Vec3f across = glm::cross(h, bent);
    float phi = std::atan2(glm::dot(a, across), glm::dot(a, bent));
    if (phi < 0) phi += PI; // by reciprocity, the azimuth of b has the same value

    const float x = std::sqrt(thetaH / (PI / 2)) * static_cast<float>(halfCount);
    const float y = thetaD / (PI / 2) * static_cast<float>(differenceCount);
    const float z = phi / PI * static_cast<float>(azimuthCount);
    const auto split = [](float v, int count, int& i, float& f) {
      i = std::clamp(static_cast<int>(v), 0, count - 1);
      f = std::clamp(v - static_cast<float>(i), 0.0f, 1.0f);
    };
    int i, j, k;
    float fx, fy, fz;
    split(x, halfCount, i, fx);
    split(y, differenceCount, j, fy);
    split(z, azimuthCount, k, fz);
    const int i1 = std::min(i + 1, halfCount - 1), j1 = std::min(j + 1, differenceCount - 1),
              k1 = (k + 1) % azimuthCount; // azimuth π is azimuth 0
    const auto along = [&](int ii, int jj) { return entry(ii, jj, k) * (1 - fz) + entry(ii, jj, k1) * fz; };
    return (along(i, j) * (1 - fy) + along(i, j1) * fy) * (1 - fx) +
           (along(i1, j) * (1 - fy) + along(i1, j1) * fy) * fx;
  }

  /** Sampling density: a diffuse part, and a microfacet lobe for the remainder. */
  float diffuseShare = 0.5f;
  Microfacets facets;

  /** Reflectance at normal incidence. */
  Rgb reflectance{0};

 private:
  const Rgb& entry(int i, int j, int k) const {
    return values[(size_t(i) * size_t(differenceCount) + size_t(j)) * size_t(azimuthCount) + size_t(k)];
  }

  /** Fits the sampling density to the BRDF at normal incidence, where θd = θh. */
  void fit() {
    constexpr int N = 512;
    const auto at2 = [&](float theta) { // light from the normal, seen at 2 theta
      const float t = 2 * theta;
      return at({0, 0, 1}, {std::sin(t), 0, std::cos(t)});
    };
    float floor = INFINITE;
    for (int i = 0; i < N; ++i)
      floor = std::min(floor, maxComponent(at2(PI / 4 * (static_cast<float>(i) + 0.5f) / N * 0.9f)));
    double total = 0, gloss = 0;
    std::vector<double> sums;
    for (int i = 0; i < N; ++i) {
      // Quadratic steps of the angle, because the peak may be narrow.
      const float s = (static_cast<float>(i) + 0.5f) / N, theta = PI / 4 * square(s);
      const double solid = 2 * M_PI * std::sin(2.0 * double(theta)) * 2 * double(PI / 4 * 2 * s) / N;
      const Rgb f = at2(theta);
      const double weighted = std::cos(2.0 * double(theta)) * solid;
      reflectance += f * static_cast<float>(weighted);
      total += double(maxComponent(f)) * weighted;
      gloss += double(std::max(maxComponent(f) - floor, 0.0f)) * weighted;
      sums.push_back(gloss);
    }
    diffuseShare = total > 0 ? static_cast<float>(std::clamp(1 - gloss / total, 0.15, 1.0)) : 1;
    // Half of a Trowbridge-Reitz lobe's facets are tilted by less than atan alpha.
    float alpha = 0.5f;
    for (int i = 0; i < N; ++i)
      if (sums[size_t(i)] >= 0.5 * gloss) {
        alpha = std::tan(PI / 4 * square((static_cast<float>(i) + 0.5f) / N));
        break;
      }
    facets = {MicrofacetKind::TROWBRIDGE_REITZ, Vec2f(std::clamp(alpha, 2e-3f, 1.0f))};
  }

  int halfCount = 0, differenceCount = 0, azimuthCount = 0;
  std::vector<Rgb> values;
};

class MeasuredBsdf final : public Bsdf {
 public:
  explicit MeasuredBsdf(const MerlTable& table) : table(&table) {}
  LobeSet lobes() const override { return REFLECTION; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return BLACK;
    Vec3f a = up(wi), b = up(wo);
    // A fixed order of both directions makes rounding reciprocal.
    if (b.z < a.z) std::swap(a, b);
    return table->at(a, b);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return 0;
    const Vec3f a = up(wi), b = up(wo);
    const float d = table->diffuseShare;
    return d * b.z * INV_PI + (1 - d) * table->facets.reflectionPdf(a, halfVector(a, b));
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    const Vec3f a = up(wi);
    const Vec3f wo =
        pick < table->diffuseShare ? cosineHemisphere(u) : mirrored(a, table->facets.sampleVisible(a, u));
    if (!(wo.z > 0)) return {};
    const Vec3f unit = glm::normalize(wo);
    return wi.z < 0 ? Vec3f(unit.x, unit.y, -unit.z) : unit;
  }
  Rgb albedo(const Vec3f&) const override { return min(table->reflectance, Rgb(1)); }

 private:
  static Vec3f up(const Vec3f& w) { return {w.x, w.y, std::abs(w.z)}; }
  const MerlTable* table;
};

class Measured final : public Material {
 public:
  explicit Measured(const std::string& path) : table(path) {}
  const Bsdf* bsdfAt(const SurfacePoint&, BsdfArena& arena) const override {
    return arena.make<MeasuredBsdf>(table);
  }
  LobeSet lobes() const override { return REFLECTION; }

 private:
  MerlTable table;
};

/** Measured BSDF, equal on both sides: for light from below all directions are negated, as in pbrt-v4. */
class AdaptiveBsdf final : public Bsdf {
 public:
  explicit AdaptiveBsdf(const AdaptiveBrdf& brdf) : brdf(&brdf) {}
  LobeSet lobes() const override { return adaptiveLobes(*brdf); }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? brdf->value(up(wi, wi), up(wi, wo)) : BLACK;
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? brdf->pdf(up(wi, wi), up(wi, wo)) : 0;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    if (wi.z == 0) return {};
    const auto wo = brdf->sample(up(wi, wi), u, pick);
    return wo ? std::optional(up(wi, *wo)) : wo;
  }
  Rgb albedo(const Vec3f& wi) const override { return brdf->albedo(up(wi, wi)); }
  static LobeSet adaptiveLobes(const AdaptiveBrdf& brdf) {
    return static_cast<LobeSet>(REFLECTION | (brdf.isAnisotropic() ? ANISOTROPIC : NO_LOBE));
  }

 private:
  static Vec3f up(const Vec3f& wi, const Vec3f& w) { return wi.z < 0 ? -w : w; }
  const AdaptiveBrdf* brdf;
};

class AdaptiveMeasured final : public Material {
 public:
  explicit AdaptiveMeasured(const std::string& path) : brdf(path, readFileBytes(path)) {}
  const Bsdf* bsdfAt(const SurfacePoint&, BsdfArena& arena) const override {
    return arena.make<AdaptiveBsdf>(brdf);
  }
  LobeSet lobes() const override { return AdaptiveBsdf::adaptiveLobes(brdf); }

 private:
  AdaptiveBrdf brdf;
};

bool isTensorFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string begin(12, ' ');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return TensorFile::isTensorFile(begin);
}

std::unique_ptr<Material> makeMeasured(const Parameters& p, const MaterialContext&) {
  const std::string path = p.filePath("filename");
  const char* const accepted = "a .binary file of the MERL database, or a .bsdf file of EPFL's database";
  if (isTensorFile(path)) {
    try {
      return std::make_unique<AdaptiveMeasured>(path);
    } catch (const Error& e) {
      p.fail("filename", e.what(), accepted);
    }
  }
  try {
    return std::make_unique<Measured>(path);
  } catch (const std::runtime_error& e) {
    p.fail("filename", "\"" + path + "\" " + e.what(), accepted);
  }
}

} // namespace

void registerMeasured(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "measured",
        .summary = "A measured BRDF from a file of the MERL database (isotropic) or of EPFL's database.",
        .parameters = {stringParameter("filename", "", "the .binary or .bsdf file").require()},
        .examples = {"\"string filename\" \"scenes/materials/satin.binary\"",
                     "\"string filename\" \"scenes/materials/copper.bsdf\""}},
       makeMeasured});
}

} // namespace recurse
