/** @file
 * Writes test files of measured BRDFs in the adaptive parameterization from BRDFs in closed form, and damaged
 * files.
 */
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bsdfs/measured/parametricWarp.h"
#include "bsdfs/microfacet/microfacet.h"

namespace recurse::testing {

/** Field of a tensor file. */
struct TensorField {
  uint8_t type = 10; ///< float32
  std::vector<uint64_t> shape;
  std::string bytes;
  static TensorField floats(std::vector<uint64_t> shape, const std::vector<float>& values) {
    return {10, std::move(shape),
            std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float))};
  }
};
using TensorFields = std::map<std::string, TensorField>;

inline std::string tensorFile(const TensorFields& fields) {
  std::string table("tensor_file\0\1\0", 14), data;
  const auto put = [](std::string& to, const auto& x) {
    to.append(reinterpret_cast<const char*>(&x), sizeof x);
  };
  put(table, static_cast<uint32_t>(fields.size()));
  size_t length = table.size();
  for (const auto& [name, field] : fields) length += 13 + name.size() + 8 * field.shape.size();
  for (const auto& [name, field] : fields) {
    put(table, static_cast<uint16_t>(name.size()));
    table += name;
    put(table, static_cast<uint16_t>(field.shape.size()));
    put(table, field.type);
    put(table, uint64_t(length + data.size()));
    for (const uint64_t extent : field.shape) put(table, extent);
    data += field.bytes;
  }
  return table + data;
}

/** BRDF to be tabulated, with the resolution of the tables. */
struct Tabulation {
  std::function<double(const Vec3f& a, const Vec3f& b)> brdf;
  Microfacets facets{MicrofacetKind::TROWBRIDGE_REITZ, Vec2f(0.3f)}; ///< distribution of the half vectors
  std::vector<float> thetas;
  std::vector<float> phis = {0};
  std::vector<float> wavelengths = {400, 700};
  std::function<double(double wavelength)> colour = [](double) { return 1; }; ///< factor of the BRDF
  size_t resolution = 32;                                                     ///< resolution of all tables
  bool relative = true;                                                       ///< relative to the facets

  static std::vector<float> nodes(float from, float to, size_t count) {
    std::vector<float> n;
    for (size_t i = 0; i < count; ++i)
      n.push_back(from + (to - from) * static_cast<float>(i) / static_cast<float>(count - 1));
    return n;
  }
};

/** Makes the tables of a Tabulation. */
class Tabulator {
 public:
  explicit Tabulator(const Tabulation& what) : what(what), n(what.resolution) {}

  TensorFields fields() {
    tabulateFacets();
    for (uint32_t slice = 0; slice < what.phis.size() * what.thetas.size(); ++slice) tabulateVisible(slice);
    const ParametricWarp warp(n, n, vndf);
    for (uint32_t slice = 0; slice < what.phis.size() * what.thetas.size(); ++slice)
      tabulateColours(warp, slice);
    const uint64_t p = what.phis.size(), t = what.thetas.size(), w = what.wavelengths.size();
    using F = TensorField;
    return {{"theta_i", F::floats({t}, what.thetas)},
            {"phi_i", F::floats({p}, what.phis)},
            {"wavelengths", F::floats({w}, what.wavelengths)},
            {"ndf", F::floats({n, n}, ndf)},
            {"sigma", F::floats({n, n}, sigma)},
            {"vndf", F::floats({p, t, n, n}, vndf)},
            {"luminance", F::floats({p, t, n, n}, luminance)},
            {"spectra", F::floats({p, t, w, n, n}, spectra)},
            {"description", {1, {4}, "test"}},
            {"jacobian", {1, {1}, std::string(1, what.relative ? '\1' : '\0')}}};
  }

 private:
  /** The azimuth of half vectors in isotropic tables starts at the plane of incidence. */
  Vec3f incidence(uint32_t slice) const {
    const float theta = std::min(what.thetas[slice % what.thetas.size()], 1.5697f);
    const float phi = what.phis.size() > 2 ? what.phis[slice / what.thetas.size()] : 0;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
  }
  static Vec3f direction(const Vec2d& square) {
    const double theta = square.x * square.x * M_PI / 2, phi = (2 * square.y - 1) * M_PI;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
  }
  template <class F> void forNodes(const F& use) const {
    for (size_t y = 0; y < n; ++y)
      for (size_t x = 0; x < n; ++x) use(Vec2d(double(x), double(y)) / double(n - 1));
  }
  void tabulateFacets() {
    forNodes([&](const Vec2d& u) {
      ndf.push_back(what.facets.density(direction(u)));
      sigma.push_back(what.facets.shadowed(direction(u)));
    });
  }
  void tabulateVisible(uint32_t slice) {
    const Vec3f w = incidence(slice);
    forNodes([&](const Vec2d& u) {
      const Vec3f m = direction(u);
      const double jacobian = 2 * M_PI * M_PI * u.x * std::sin(u.x * u.x * M_PI / 2);
      vndf.push_back(static_cast<float>(
          double(what.facets.density(m) * std::max(glm::dot(w, m), 0.0f) / what.facets.shadowed(w)) *
          jacobian));
    });
  }
  void tabulateColours(const ParametricWarp& warp, uint32_t slice) {
    const Vec3f w = incidence(slice);
    std::vector<double> relative;
    forNodes([&](const Vec2d& u) {
      const Vec3f m = direction(warp.sample({{slice}, {1}, 1}, glm::min(u, Vec2d(1 - 1e-9))).at);
      const Vec3f q = mirrored(w, m);
      const double cosine = std::max(double(q.z), 0.0);
      relative.push_back(
          cosine > 0
              ? what.brdf(w, glm::normalize(q)) * cosine *
                    (what.relative ? double(4 * what.facets.shadowed(w) / what.facets.density(m)) : 1.0)
              : 0);
      luminance.push_back(static_cast<float>(relative.back()));
    });
    for (const float wavelength : what.wavelengths)
      for (const double r : relative)
        spectra.push_back(static_cast<float>(r * what.colour(double(wavelength))));
  }

  const Tabulation& what;
  const uint64_t n;
  std::vector<float> ndf, sigma, vndf, luminance, spectra;
};

inline std::string adaptiveFile(const Tabulation& what) { return tensorFile(Tabulator(what).fields()); }

/** Content of scenes/materials/copper.bsdf: synthetic rough copper, as a small file of the format. */
inline Tabulation copper() {
  Tabulation t;
  t.facets = {MicrofacetKind::TROWBRIDGE_REITZ, Vec2f(0.25f)};
  t.brdf = [facets = t.facets](const Vec3f& a, const Vec3f& b) {
    return double(facets.reflection(a, b, halfVector(a, b)));
  };
  t.thetas = Tabulation::nodes(0, PI / 2, 9);
  t.wavelengths = {400, 480, 540, 580, 620, 700};
  t.colour = [](double w) { return 0.4 + 0.5 * std::clamp((w - 520) / 90, 0.0, 1.0); };
  t.resolution = 16;
  return t;
}

} // namespace recurse::testing
