/** @file
 * Reads and evaluates measured BRDFs whose parameterization adapts to the material.
 */
#include "bsdfs/measured/adaptiveBrdf.h"

#include <utility>

#include "bsdfs/measured/tensorFile.h"
#include "bsdfs/microfacet/microfacet.h"
#include "recurse/scene/parameters/reflectanceWeights.h"

namespace recurse {

namespace {

/** Fraction of cosine-distributed samples, because f may be above 0 where only the table of wo is. */
constexpr float COSINE_SHARE = 0.1f;

/** Jacobian [sr per area of the square] of half vectors that floats cannot separate from the normal. */
constexpr double LEAST_JACOBIAN = 6e-10; // 2π² u sin θ at θ = 2^-23

/** Cosine below which a direction is in the plane of the surface, at float precision. */
constexpr float GRAZING = 1e-6f;

double squareOfTheta(double theta) { return std::sqrt(theta * (2 / M_PI)); }
double polarAngle(const Vec3f& w) { return std::atan2(std::hypot(double(w.x), double(w.y)), double(w.z)); }
/** Coordinate in [0, 1] of the azimuth of (x, y), a vector of any length. */
double squareOfPhi(double x, double y) { return std::atan2(y, x) / (2 * M_PI) + 0.5; }

std::vector<float> increasing(const TensorFile& file, const std::string& name) {
  std::vector<float> nodes = file.floats(name, {TensorFile::ANY}).values();
  for (size_t i = 1; i < nodes.size(); ++i)
    if (!(nodes[i] > nodes[i - 1])) file.fail(name, "does not increase");
  return nodes;
}

std::vector<float> notNegative(const TensorFile& file, const std::string& name, const FloatTensor& tensor) {
  std::vector<float> values = tensor.values();
  for (const float v : values)
    if (v < 0) file.fail(name, "has a value below 0");
  return values;
}

ParametricWarp readWarp(const TensorFile& file, const std::string& name, const FloatTensor& tensor,
                        std::vector<float> values) {
  if (tensor.shape(2) < 2 || tensor.shape(3) < 2) file.fail(name, "needs 2 x 2 nodes or more for a density");
  return {tensor.shape(3), tensor.shape(2), std::move(values)};
}

} // namespace

AdaptiveBrdf::AdaptiveBrdf(const std::string& name, std::string_view bytes) {
  const TensorFile file(name, bytes);
  readIncidence(file);
  readFacets(file);
  readColours(file);
  findAlbedos();
}

void AdaptiveBrdf::readIncidence(const TensorFile& file) {
  phis = increasing(file, "phi_i");
  thetas = increasing(file, "theta_i");
  constexpr float ROUNDING = 1e-3f; // radians
  if (thetas.front() < -ROUNDING || thetas.back() > PI / 2 + ROUNDING)
    file.fail("theta_i", "is not between 0 and a right angle [radians]");
  isotropic = phis.size() <= 2;
  if (!isotropic) {
    const float span = phis.back() - phis.front();
    symmetry = static_cast<int>(std::lround(2 * PI / span));
    const bool standard = std::abs(phis.front() + PI) < ROUNDING;
    if (symmetry != 1 && !((symmetry == 2 || symmetry == 4) && standard))
      file.fail("phi_i", "goes from " + std::to_string(phis.front()) + " to " + std::to_string(phis.back()) +
                             "; the file must cover a full turn, or half or a quarter of one from -pi");
  }
  grid = ParameterGrid(phis, thetas);
}

void AdaptiveBrdf::readFacets(const TensorFile& file) {
  const auto plane = [&](const std::string& name) {
    const FloatTensor t = file.floats(name, {TensorFile::ANY, TensorFile::ANY});
    return SliceTable<float>(t.shape(1), t.shape(0), notNegative(file, name, t));
  };
  facets = plane("ndf");
  sigma = plane("sigma");
  const std::vector<uint64_t> shape = {phis.size(), thetas.size(), TensorFile::ANY, TensorFile::ANY};
  const FloatTensor v = file.floats("vndf", shape), l = file.floats("luminance", shape);
  visible = readWarp(file, "vndf", v, notNegative(file, "vndf", v));
  // Luminance only guides the samples: clamping it adds no bias.
  std::vector<float> brightness = l.values();
  for (float& x : brightness) x = std::max(x, 0.0f);
  luminance = readWarp(file, "luminance", l, std::move(brightness));
  relative = file.byte("jacobian") != 0;
}

void AdaptiveBrdf::readColours(const TensorFile& file) {
  // Contribution of each spectral sample to the colour; RGB tables hold the components themselves.
  const bool isRgb = !file.has("spectra") && file.has("rgb");
  std::vector<Rgbd> parts = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (!isRgb) {
    const std::vector<float> wavelengths = increasing(file, "wavelengths");
    parts = reflectanceWeights({wavelengths.begin(), wavelengths.end()});
  }
  const std::string name = isRgb ? "rgb" : "spectra";
  const FloatTensor t =
      file.floats(name, {phis.size(), thetas.size(), parts.size(), TensorFile::ANY, TensorFile::ANY});
  const size_t nodes = t.shape(3) * t.shape(4);
  std::vector<Rgb> table(grid.slices() * nodes);
  for (size_t slice = 0; slice < grid.slices(); ++slice)
    for (size_t i = 0; i < nodes; ++i) {
      Rgbd sum(0);
      for (size_t p = 0; p < parts.size(); ++p)
        sum += parts[p] * double(t[(slice * parts.size() + p) * nodes + i]);
      table[slice * nodes + i] = Rgb(intoGamut(sum)); // noise of a dark sample may be below 0
    }
  colours = SliceTable<Rgb>(t.shape(4), t.shape(3), std::move(table));
}

void AdaptiveBrdf::findAlbedos() {
  constexpr int N = 16; // squared samples; they only guide the choice among lobes
  albedos.assign(grid.slices(), Rgb(0));
  size_t slice = 0;
  for (const float phi : phis)
    for (const float theta : thetas) {
      const float t = std::clamp(theta, 0.0f, 1.57f); // not in the plane of the surface
      const Vec3f w(std::sin(t) * std::cos(phi), std::sin(t) * std::sin(phi), std::cos(t));
      Rgb sum(0);
      for (int i = 0; i < N * N; ++i) {
        const Vec2f u((static_cast<float>(i % N) + 0.5f) / N,
                      (static_cast<float>(i / N) + 0.5f) / N); // NOLINT
        const auto wo = sample(w, u, i % 10 == 0 ? 0 : COSINE_SHARE);
        const float density = wo ? pdf(w, *wo) : 0;
        if (density > 0) sum += value(w, *wo) * (wo->z / density);
      }
      albedos[slice++] = min(sum / static_cast<float>(N * N), Rgb(1));
    }
}

AdaptiveBrdf::Incidence AdaptiveBrdf::incidence(const Vec3f& w) const {
  Incidence p;
  p.direction = w;
  if (symmetry == 2 && w.y > 0) p.flip = Vec2f(-1);
  if (symmetry == 4) p.flip = {w.x > 0 ? -1.0f : 1.0f, w.y > 0 ? -1.0f : 1.0f};
  const float x = w.x * p.flip.x, y = w.y * p.flip.y, sine = std::hypot(x, y);
  float phi = std::atan2(y, x);
  if (isotropic && sine > 0) p.azimuth = Vec2f(x, y) / sine;
  if (!isotropic && phi < phis.front()) phi += 2 * PI;
  const double theta = polarAngle(w);
  p.square = {squareOfTheta(theta), squareOfPhi(x, y)};
  p.blend = grid.at(phi, static_cast<float>(theta));
  return p;
}

AdaptiveBrdf::HalfPoint AdaptiveBrdf::halfPoint(const Incidence& p, const Vec3f& m) const {
  const Vec2d w(m.x * p.flip.x, m.y * p.flip.y), a(p.azimuth);
  const double theta = polarAngle(m), u = squareOfTheta(theta);
  return {{u, squareOfPhi(w.x * a.x + w.y * a.y, w.y * a.x - w.x * a.y)},
          std::max(2 * square(M_PI) * u * std::sin(theta), LEAST_JACOBIAN)};
}

Vec3f AdaptiveBrdf::halfVectorAt(const Incidence& p, const Vec2d& at) const {
  const double theta = square(at.x) * (M_PI / 2), phi = (2 * at.y - 1) * M_PI;
  const Vec2d w = Vec2d(std::cos(phi), std::sin(phi)) * std::sin(theta), a(p.azimuth), flip(p.flip);
  return {(w.x * a.x - w.y * a.y) * flip.x, (w.x * a.y + w.y * a.x) * flip.y, std::cos(theta)};
}

Rgb AdaptiveBrdf::valueTimesCosine(const Incidence& p, const Vec3f& m) const {
  const HalfPoint h = halfPoint(p, m);
  const Rgb c = colours.at(p.blend, visible.invert(p.blend, h.square).at);
  if (!relative) return c;
  const float area = sigma.at(p.square);
  return area > 0 ? c * (facets.at(h.square) / (4 * area)) : BLACK;
}

Rgb AdaptiveBrdf::value(const Vec3f& a, const Vec3f& b) const {
  if (!(a.z + b.z > GRAZING)) return BLACK;
  const Vec3f m = halfVector(a, b);
  return (valueTimesCosine(incidence(a), m) + valueTimesCosine(incidence(b), m)) / (a.z + b.z);
}

float AdaptiveBrdf::pdf(const Vec3f& wi, const Vec3f& wo) const {
  const Vec3f m = halfVector(wi, wo);
  const float cosine = COSINE_SHARE * wo.z * INV_PI, d = glm::dot(wi, m);
  if (!(d > GRAZING)) return cosine;
  const Incidence p = incidence(wi);
  const HalfPoint h = halfPoint(p, m);
  const ParametricWarp::Point seen = visible.invert(p.blend, h.square);
  const double density = seen.pdf * luminance.pdf(p.blend, seen.at) / (4 * double(d) * h.jacobian);
  return cosine + (1 - COSINE_SHARE) * static_cast<float>(density);
}

std::optional<Vec3f> AdaptiveBrdf::sample(const Vec3f& wi, const Vec2f& u, float pick) const {
  Vec3f wo = cosineHemisphere(u);
  if (pick >= COSINE_SHARE) {
    const Incidence p = incidence(wi);
    const Vec2d bright = luminance.sample(p.blend, Vec2d(u)).at;
    wo = mirrored(wi, halfVectorAt(p, visible.sample(p.blend, bright).at));
  }
  if (!(wo.z > 0)) return {};
  return glm::normalize(wo);
}

Rgb AdaptiveBrdf::albedo(const Vec3f& wi) const {
  const SliceBlend blend = incidence(wi).blend;
  Rgb sum(0);
  for (uint32_t i = 0; i < blend.count; ++i) sum += albedos[blend.slices[i]] * blend.weights[i];
  return sum;
}

} // namespace recurse
