/** @file
 * Gradient noise and sums of its octaves.
 */
#include "recurse/model/texture/noise.h"

#include <array>

namespace recurse {

namespace {

/** Permutation of the reference implementation of "Improving Noise"; pbrt has the same. */
constexpr std::array<uint8_t, 256> PERMUTATION = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,
    69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,
    94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136,
    171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122,
    60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161,
    1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,
    164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126,
    255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213,
    119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253,
    19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,  242, 193,
    238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,
    222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

/** Directions to the edges of a cube; four of them occur twice, for 16 in all, as in pbrt. */
constexpr int8_t GRADIENTS[16][3] = {
    {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
    {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1}, {1, 1, 0}, {-1, 1, 0}, {0, 1, -1}, {0, -1, -1}};

constexpr double PERIOD = 256;

double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

double smoothStep(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

} // namespace

double perlinNoise(const Vec3d& p) {
  const Vec3d corner = glm::floor(p), d = p - corner;
  uint32_t lattice[3];
  for (int i = 0; i < 3; ++i) // exact for any magnitude of p
    lattice[i] = static_cast<uint32_t>(corner[i] - PERIOD * std::floor(corner[i] / PERIOD));
  const auto hash = [](uint32_t i, uint32_t before) { return uint32_t(PERMUTATION[(before + i) & 255]); };
  double sum = 0;
  const Vec3d w(fade(d.x), fade(d.y), fade(d.z));
  for (uint32_t k = 0; k < 8; ++k) {
    const uint32_t o[3] = {k & 1, (k >> 1) & 1, k >> 2};
    const uint32_t h = hash(lattice[2] + o[2], hash(lattice[1] + o[1], hash(lattice[0] + o[0], 0)));
    const int8_t* g = GRADIENTS[h & 15];
    double weight = 1, slope = 0;
    for (int i = 0; i < 3; ++i) {
      weight *= o[i] ? w[i] : 1 - w[i];
      slope += g[i] * (d[i] - double(o[i]));
    }
    sum += weight * slope;
  }
  return sum;
}

template <class Term, class Rest>
double NoiseSum::sum(const MappedPoint& m, const Term& term, const Rest& rest) const {
  constexpr double LACUNARITY = 1.99; // not 2, so that the zeros of the lattices do not coincide
  const double length2 = double(std::max(lengthSquared(m.alongX), lengthSquared(m.alongY)));
  // Octave i has a wavelength of about 2^-i. Octaves finer than twice the footprint are left out.
  const double seen =
      length2 > 0 ? std::clamp(-1 - 0.5 * std::log2(length2), 0.0, double(octaves)) : double(octaves);
  const int whole = static_cast<int>(seen);
  double total = 0, frequency = 1, height = 1;
  for (int i = 0; i < whole; ++i) {
    total += height * term(perlinNoise(frequency * m.p));
    frequency *= LACUNARITY;
    height *= roughness;
  }
  const double part = smoothStep(0.3, 0.7, seen - whole);
  if (part > 0) total += height * part * term(perlinNoise(frequency * m.p));
  return total + rest(whole, part, height);
}

double NoiseSum::fractal(const MappedPoint& m) const {
  return sum(
      m, [](double n) { return n; }, [](int, double, double) { return 0.0; });
}

double NoiseSum::turbulence(const MappedPoint& m) const {
  // Octaves too fine to be resolved contribute their mean.
  constexpr double MEAN = 0.2;
  return sum(
      m, [](double n) { return std::abs(n); },
      [this](int whole, double part, double height) {
        double total = height * (1 - part) * MEAN;
        for (int i = whole; i < octaves; ++i) {
          total += height * MEAN;
          height *= roughness;
        }
        return total;
      });
}

std::vector<ParameterSpec> noiseParameters() {
  return {integerParameter("octaves", "8", "number of octaves; each has 1.99 times the frequency of the last")
              .range(1, 64),
          realParameter("roughness", "0.5", "amplitude of an octave relative to the last").range(0, 1)};
}

NoiseSum noiseSum(const Parameters& p) { return {p.integer("octaves"), p.real("roughness")}; }

} // namespace recurse
