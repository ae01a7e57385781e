/** @file
 * FLIP. All filters are sums of products of a filter in x and a filter in y, and are applied separably (as in
 * the authors' note on separated convolutions).
 */
#include "recurse/report/compare/flip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"
#include "report/compare/comparable.h"
#include "report/compare/falseColour.h"

namespace recurse {

namespace {

constexpr double PI_SQUARED = 3.14159265358979323846 * 3.14159265358979323846;

// Contrast sensitivity (2020, table 1): a sum of Gaussians a·sqrt(π/b)·exp(−π²r²/b), r in degrees.
struct SensitivityTerm {
  double a, b;
};
constexpr SensitivityTerm ACHROMATIC{1, 0.0047}, RED_GREEN{1, 0.0053},
    BLUE_YELLOW[2] = {{34.1, 0.04}, {13.5, 0.025}};
constexpr double COLOUR_EXPONENT = 0.7, COLOUR_KNEE = 0.4, COLOUR_KNEE_VALUE = 0.95; // q_c, p_c, p_t
constexpr double FEATURE_EXPONENT = 0.5;                                             // q_f
constexpr double FEATURE_WIDTH = 0.082; // peak to trough of the edge detector [degrees]

// sRGB primaries with illuminant D65.
constexpr double TO_XYZ[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                 {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                 {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

/** XYZ relative to white, so that white is (1, 1, 1). */
struct ColourSpace {
  glm::mat3 toXyz{1}, fromXyz{1};
  ColourSpace() {
    glm::dmat3 m(1); // columns first
    for (int row = 0; row < 3; ++row) {
      const double white = TO_XYZ[row][0] + TO_XYZ[row][1] + TO_XYZ[row][2];
      for (int column = 0; column < 3; ++column) m[column][row] = TO_XYZ[row][column] / white;
    }
    toXyz = glm::mat3(m);
    fromXyz = glm::mat3(glm::inverse(m));
  }
};

const ColourSpace& space() {
  static const ColourSpace SPACE;
  return SPACE;
}

/** Linear RGB to YyCxCz. */
Vec3f opponent(const Rgb& rgb) {
  const Vec3f xyz = space().toXyz * Vec3f(rgb.r, rgb.g, rgb.b);
  return {116 * xyz.y - 16, 500 * (xyz.x - xyz.y), 200 * (xyz.y - xyz.z)};
}

Vec3f linearOf(const Vec3f& opponent) {
  const float y = (opponent.x + 16) / 116;
  return space().fromXyz * Vec3f(y + opponent.y / 500, y, y - opponent.z / 200);
}

/** Linear RGB to L*a*b* with the Hunt effect: chroma decreases with lightness. */
Vec3f huntLab(const Vec3f& rgb) {
  constexpr float DELTA = 6.0f / 29;
  const auto f = [](float t) {
    return t > DELTA * DELTA * DELTA ? std::cbrt(t) : t / (3 * DELTA * DELTA) + 4.0f / 29;
  };
  const Vec3f xyz = space().toXyz * rgb;
  const float fx = f(xyz.x), fy = f(xyz.y), fz = f(xyz.z), lightness = 116 * fy - 16;
  return {lightness, 0.01f * lightness * 500 * (fx - fy), 0.01f * lightness * 200 * (fy - fz)};
}

/** HyAB distance, for large colour differences (Abasi et al. 2020). */
float hyab(const Vec3f& a, const Vec3f& b) {
  return std::abs(a.x - b.x) + std::sqrt((a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z));
}

/** One dimension of a filter, from −radius to radius. */
using Kernel = std::vector<float>;

template <typename Weight> Kernel kernelOf(int radius, Weight weight) {
  std::vector<double> w;
  double positive = 0, negative = 0;
  for (int i = -radius; i <= radius; ++i) {
    w.push_back(weight(double(i)));
    (w.back() > 0 ? positive : negative) += w.back();
  }
  // Positive weights add up to 1, and negative ones to −1.
  Kernel out;
  for (double value : w)
    out.push_back(static_cast<float>(value > 0 ? value / positive : value < 0 ? value / -negative : 0));
  return out;
}

struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;
  Plane(int width, int height) : width(width), height(height), values(size_t(width) * size_t(height)) {}
  float* row(int y) { return &values[size_t(y) * size_t(width)]; }
  const float* row(int y) const { return &values[size_t(y) * size_t(width)]; }
};

/** Convolution along x; beyond the border the last pixel is repeated. */
Plane alongX(const Plane& in, const Kernel& kernel) {
  Plane out(in.width, in.height);
  const int radius = static_cast<int>(kernel.size() / 2);
  parallelFor(size_t(in.height), [&](size_t y) {
    const float* row = in.row(static_cast<int>(y));
    std::vector<float> padded(size_t(in.width + 2 * radius));
    for (int x = -radius; x < in.width + radius; ++x)
      padded[size_t(x + radius)] = row[std::clamp(x, 0, in.width - 1)];
    float* to = out.row(static_cast<int>(y));
    for (size_t i = 0; i < kernel.size(); ++i)
      for (size_t x = 0; x < size_t(in.width); ++x) to[x] += kernel[i] * padded[x + i];
  });
  return out;
}

Plane alongY(const Plane& in, const Kernel& kernel) {
  Plane out(in.width, in.height);
  const int radius = static_cast<int>(kernel.size() / 2);
  parallelFor(size_t(in.height), [&](size_t y) {
    float* to = out.row(static_cast<int>(y));
    for (int i = -radius; i <= radius; ++i) {
      const float* row = in.row(std::clamp(static_cast<int>(y) + i, 0, in.height - 1));
      const float weight = kernel[size_t(i + radius)];
      for (size_t x = 0; x < size_t(in.width); ++x) to[x] += weight * row[x];
    }
  });
  return out;
}

Plane smoothed(const Plane& in, const Kernel& kernel) { return alongY(alongX(in, kernel), kernel); }

/** All filters for one distance from the display. */
struct Filters {
  Kernel achromatic, redGreen, blueYellow[2];
  float blueYellowShare[2] = {0, 0};
  Kernel gauss, edge, point;

  explicit Filters(double pixelsPerDegree) {
    const int radius =
        static_cast<int>(std::ceil(3 * std::sqrt(BLUE_YELLOW[0].b / (2 * PI_SQUARED)) * pixelsPerDegree));
    const auto gaussian = [&](const SensitivityTerm& term) {
      return [scale = PI_SQUARED / (term.b * pixelsPerDegree * pixelsPerDegree)](double x) {
        return std::exp(-scale * x * x);
      };
    };
    achromatic = kernelOf(radius, gaussian(ACHROMATIC));
    redGreen = kernelOf(radius, gaussian(RED_GREEN));
    double shares[2], total = 0;
    for (size_t i = 0; i < 2; ++i) {
      const auto weight = gaussian(BLUE_YELLOW[i]);
      blueYellow[i] = kernelOf(radius, weight);
      double sum = 0;
      for (int x = -radius; x <= radius; ++x) sum += weight(x);
      shares[i] = BLUE_YELLOW[i].a / std::sqrt(BLUE_YELLOW[i].b) * sum * sum;
      total += shares[i];
    }
    for (size_t i = 0; i < 2; ++i) blueYellowShare[i] = static_cast<float>(shares[i] / total);

    const double deviation = 0.5 * FEATURE_WIDTH * pixelsPerDegree;
    const int reach = static_cast<int>(std::ceil(3 * deviation));
    const auto g = [&](double x) { return std::exp(-x * x / (2 * deviation * deviation)); };
    gauss = kernelOf(reach, g);
    edge = kernelOf(reach, [&](double x) { return -x * g(x); });
    point = kernelOf(reach, [&](double x) { return (x * x / (deviation * deviation) - 1) * g(x); });
  }
};

/** Features of a picture that FLIP compares. */
struct Seen {
  std::vector<Vec3f> colours;       ///< L*a*b* with the Hunt effect, after the contrast sensitivity filters
  std::vector<float> edges, points; ///< strengths
};

Seen see(const std::vector<Rgb>& linear, int width, int height, const Filters& filters) {
  Plane y(width, height), cx(width, height), cz(width, height);
  const size_t count = linear.size();
  for (size_t i = 0; i < count; ++i) {
    const Vec3f o = opponent(linear[i]);
    y.values[i] = o.x;
    cx.values[i] = o.y;
    cz.values[i] = o.z;
  }
  const Plane ys = smoothed(y, filters.achromatic), cxs = smoothed(cx, filters.redGreen),
              cz0 = smoothed(cz, filters.blueYellow[0]), cz1 = smoothed(cz, filters.blueYellow[1]);
  Seen out;
  out.colours.resize(count);
  parallelFor(size_t(height), [&](size_t row) {
    for (size_t i = row * size_t(width); i < (row + 1) * size_t(width); ++i) {
      const float blueYellow =
          filters.blueYellowShare[0] * cz0.values[i] + filters.blueYellowShare[1] * cz1.values[i];
      const Vec3f rgb = linearOf({ys.values[i], cxs.values[i], blueYellow});
      out.colours[i] = huntLab(glm::clamp(rgb, 0.0f, 1.0f));
    }
  });
  for (float& value : y.values) value = (value + 16) / 116;
  const Plane gaussX = alongX(y, filters.gauss);
  const auto strength = [&](const Kernel& detector) {
    const Plane dx = alongY(alongX(y, detector), filters.gauss), dy = alongY(gaussX, detector);
    std::vector<float> length(count);
    for (size_t i = 0; i < count; ++i)
      length[i] = std::sqrt(dx.values[i] * dx.values[i] + dy.values[i] * dy.values[i]);
    return length;
  };
  out.edges = strength(filters.edge);
  out.points = strength(filters.point);
  return out;
}

/** Largest possible colour difference, between green and blue. */
float largestColourError() {
  static const float LARGEST =
      std::pow(hyab(huntLab({0, 1, 0}), huntLab({0, 0, 1})), static_cast<float>(COLOUR_EXPONENT));
  return LARGEST;
}

/** Adds errors of linear pictures in [0, 1]: `errors` keeps the larger of its value and the new error. */
void addErrors(const std::vector<Rgb>& image, const std::vector<Rgb>& reference, const Filters& filters,
               Flip& out) {
  const Seen a = see(image, out.width, out.height, filters),
             b = see(reference, out.width, out.height, filters);
  const float largest = largestColourError(), knee = float(COLOUR_KNEE) * largest;
  parallelFor(size_t(out.height), [&](size_t row) {
    for (size_t i = row * size_t(out.width); i < (row + 1) * size_t(out.width); ++i) {
      const float difference = std::pow(hyab(a.colours[i], b.colours[i]), float(COLOUR_EXPONENT));
      constexpr float AT_KNEE = static_cast<float>(COLOUR_KNEE_VALUE);
      const float colour = difference < knee
                               ? difference * (AT_KNEE / knee)
                               : AT_KNEE + (difference - knee) / (largest - knee) * (1 - AT_KNEE);
      const float features = std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
      const float feature = std::pow(features * 0.70710678f, float(FEATURE_EXPONENT));
      out.errors[i] = std::max(out.errors[i], std::pow(colour, 1 - feature));
    }
  });
}

bool allFinite(const Image& image) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (!isFinite(image.rgb(x, y))) return false;
  return true;
}

std::vector<Rgb> colours(const Image& image) {
  std::vector<Rgb> out;
  out.reserve(size_t(image.width) * size_t(image.height));
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) out.push_back(image.rgb(x, y));
  return out;
}

/** Prepares a comparison. Throws where the pictures do not fit; no errors where a pixel is not finite. */
Flip begin(const Image& image, const Image& reference) {
  requireComparable(image, reference, "reference has");
  Flip out;
  out.width = image.width;
  out.height = image.height;
  out.mean = std::numeric_limits<double>::quiet_NaN();
  if (allFinite(image) && allFinite(reference)) out.errors.resize(size_t(image.width) * size_t(image.height));
  return out;
}

void takeMean(Flip& flip) {
  flip.mean = std::accumulate(flip.errors.begin(), flip.errors.end(), 0.0) / double(flip.errors.size());
}

// The ACES curve (Narkowicz 2016) with its exposure of 0.6 taken out: (k0 x² + k1 x) / (k3 x² + k4 x + k5).
constexpr double K0 = 0.36 * 2.51, K1 = 0.6 * 0.03, K3 = 0.36 * 2.43, K4 = 0.6 * 0.59, K5 = 0.14;

Rgb toneMapped(const Rgb& colour, double scale) {
  Rgb out;
  for (int c = 0; c < 3; ++c) {
    const double x = std::max(0.0, double(colour[c]) * scale);
    out[c] = static_cast<float>(std::clamp(x * (K0 * x + K1) / (x * (K3 * x + K4) + K5), 0.0, 1.0));
  }
  return out;
}

/** Value that the curve maps to 0.85. */
double valueShownBright() {
  constexpr double T = 0.85;
  const double p = (K1 - K4 * T) / (K0 - K3 * T), q = -K5 * T / (K0 - K3 * T);
  return -p / 2 + std::sqrt(p * p / 4 - q);
}

double medianOf(std::vector<double> values) { // needs at least one value
  const size_t half = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(half), values.end());
  const double upper = values[half];
  if (values.size() % 2 == 1) return upper;
  return (*std::max_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(half)) + upper) / 2;
}

std::vector<double> exposuresFor(const std::vector<Rgb>& reference) {
  std::vector<double> luminances;
  for (const Rgb& colour : reference) luminances.push_back(double(luminance(max(colour, 0))));
  const double largest = *std::max_element(luminances.begin(), luminances.end());
  if (largest <= 0) return {0}; // black at every exposure
  double median = medianOf(luminances);
  if (median <= 0) {
    std::erase_if(luminances, [](double y) { return y <= 0; });
    median = medianOf(luminances);
  }
  const double bright = valueShownBright(), start = std::log2(bright / largest),
               stop = std::log2(bright / median);
  const int count = std::max(2, static_cast<int>(std::ceil(stop - start)));
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(start + i * (stop - start) / (count - 1));
  return out;
}

} // namespace

Flip ldrFlip(const Image& image, const Image& reference, double pixelsPerDegree) {
  Flip out = begin(image, reference);
  if (out.errors.empty()) return out;
  const auto shown = [](const Image& linear) {
    std::vector<Rgb> values = colours(linear);
    for (Rgb& value : values) value = clamp(value, 0, 1);
    return values;
  };
  addErrors(shown(image), shown(reference), Filters(pixelsPerDegree), out);
  takeMean(out);
  return out;
}

Flip hdrFlip(const Image& image, const Image& reference, double pixelsPerDegree) {
  Flip out = begin(image, reference);
  if (out.errors.empty()) return out;
  const std::vector<Rgb> x = colours(image), r = colours(reference);
  const Filters filters(pixelsPerDegree);
  out.exposures = exposuresFor(r);
  for (double exposure : out.exposures) {
    const auto shown = [&](const std::vector<Rgb>& linear) {
      std::vector<Rgb> values(linear.size());
      for (size_t i = 0; i < linear.size(); ++i) values[i] = toneMapped(linear[i], std::exp2(exposure));
      return values;
    };
    addErrors(shown(x), shown(r), filters, out);
  }
  takeMean(out);
  return out;
}

Image flipMap(const Flip& flip) {
  if (flip.errors.empty()) throw Error("no FLIP map: the pictures have pixels that are not finite");
  Image map(flip.width, flip.height, {"R", "G", "B"});
  for (size_t i = 0; i < flip.errors.size(); ++i) {
    const Rgb colour = falseColour(flip.errors[i]);
    for (size_t c = 0; c < 3; ++c) map.pixels[3 * i + c] = colour[static_cast<int>(c)];
  }
  return map;
}

} // namespace recurse
