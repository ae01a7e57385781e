/** @file
 * Layouts of light probes: detection, and resampling into the equal-area square where a layout is not sampled
 * directly. The formulas follow the documentation of P. Debevec and of HDRShop.
 */
#include "lights/maps/lightProbe.h"

#include <array>
#include <filesystem>
#include <numbers>
#include <optional>

#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

using std::numbers::pi;

enum class Layout { EQUAL_AREA, LATITUDE_LONGITUDE, ANGULAR, MIRROR_BALL, VERTICAL_CROSS, HORIZONTAL_CROSS };

struct NamedLayout {
  Layout layout;
  const char* name;
  const char* shape;
};
constexpr std::array<NamedLayout, 6> LAYOUTS{{
    {Layout::EQUAL_AREA, "equalarea", "a square"},
    {Layout::LATITUDE_LONGITUDE, "latlong", "twice as wide as high"},
    {Layout::ANGULAR, "angular", "a square"},
    {Layout::MIRROR_BALL, "mirrorball", "a square"},
    {Layout::VERTICAL_CROSS, "verticalcross", "3 squares wide and 4 high"},
    {Layout::HORIZONTAL_CROSS, "horizontalcross", "4 squares wide and 3 high"},
}};

bool isCross(Layout l) { return l == Layout::VERTICAL_CROSS || l == Layout::HORIZONTAL_CROSS; }

/** A face of a cross: its cell, and the directions to its right edge, its upper edge, and its middle. The
 * viewer looks along -z, with +x to the right and +y up. */
struct Face {
  int column, row;
  Vec3d right, up, middle;
};
using Faces = std::array<Face, 6>;
const Faces& facesOf(Layout layout) {
  static const Faces VERTICAL{{{1, 0, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                               {0, 1, {0, 0, -1}, {0, 1, 0}, {-1, 0, 0}},
                               {1, 1, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
                               {2, 1, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}},
                               {1, 2, {1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                               {1, 3, {1, 0, 0}, {0, -1, 0}, {0, 0, 1}}}};
  static const Faces HORIZONTAL = [] {
    Faces f = VERTICAL;
    f[5] = {3, 1, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return f;
  }();
  return layout == Layout::VERTICAL_CROSS ? VERTICAL : HORIZONTAL;
}

/** A picture in one of the layouts that are resampled. */
class ProbePicture {
 public:
  ProbePicture(Image source, Layout layout)
      : image(std::move(source)), layout(layout),
        cell(isCross(layout) ? image.width / columns() : image.width) {
    if (!isCross(layout)) fillCorners();
  }

  int resolution() const { return isCross(layout) ? 2 * cell : cell; }

  Rgbd value(const Vec3d& d) const {
    if (isCross(layout)) {
      for (const Face& f : facesOf(layout)) {
        const double depth = glm::dot(d, f.middle), s = glm::dot(d, f.right), t = glm::dot(d, f.up);
        if (depth >= std::abs(s) && depth >= std::abs(t))
          return at({(s / depth + 1) / 2 + f.column, (1 - t / depth) / 2 + f.row}, f.column, f.row);
      }
      return Rgbd(0);
    }
    const double across = std::hypot(d.x, d.y);
    // Distance from the middle: angle to the front over π; in a mirror, sine of half the angle to the back.
    const double r =
        layout == Layout::ANGULAR ? std::atan2(across, -d.z) / pi : std::sqrt(std::max(0.0, (1 - d.z) / 2));
    const Vec2d way = across > 0 ? Vec2d(d.x, d.y) * (std::min(r, 1.0) / across) : Vec2d(std::min(r, 1.0), 0);
    return at({(way.x + 1) / 2, (1 - way.y) / 2}, 0, 0);
  }

  /** Integral of the picture over all directions, with subsamples of each pixel. */
  Rgbd integral() const {
    constexpr int PARTS = 4;
    Rgbd sum(0);
    double total = 0;
    const auto addCell = [&](int column, int row) {
      for (int y = 0; y < PARTS * cell; ++y)
        for (int x = 0; x < PARTS * cell; ++x) {
          const Vec2d place((x + 0.5) / (PARTS * cell), (y + 0.5) / (PARTS * cell));
          const double w = solidAngle(place);
          if (!(w > 0)) continue;
          sum += at(place + Vec2d(column, row), column, row) * w;
          total += w;
        }
    };
    if (isCross(layout))
      for (const Face& f : facesOf(layout)) addCell(f.column, f.row);
    else
      addCell(0, 0);
    return sum * (4 * pi / total);
  }

 private:
  int columns() const { return layout == Layout::VERTICAL_CROSS ? 3 : 4; }

  /** Solid angle per area of a cell, up to a factor. */
  double solidAngle(const Vec2d& place) const {
    const Vec2d p = place * 2.0 - 1.0;
    const double r2 = glm::dot(p, p), r = std::sqrt(r2);
    if (isCross(layout)) return std::pow(1 + r2, -1.5);
    if (r > 1) return 0;
    if (layout == Layout::MIRROR_BALL) return 1;
    return r > 0 ? std::sin(pi * r) / (pi * r) : 1;
  }

  /** Bilinear interpolation between pixels of one cell; `place` is in cells. */
  Rgbd at(const Vec2d& place, int column, int row) const {
    const double x = place.x * cell - 0.5, y = place.y * cell - 0.5;
    const double left = std::floor(x), top = std::floor(y), s = x - left, t = y - top;
    const auto pixel = [&](int dx, int dy) {
      const int px = std::clamp(static_cast<int>(left) + dx, column * cell, (column + 1) * cell - 1);
      const int py = std::clamp(static_cast<int>(top) + dy, row * cell, (row + 1) * cell - 1);
      return Rgbd(image.rgb(px, py));
    };
    return (pixel(0, 0) * (1 - s) + pixel(1, 0) * s) * (1 - t) +
           (pixel(0, 1) * (1 - s) + pixel(1, 1) * s) * t;
  }

  /** Extends the nearest pixels inside the circle into the corners, for the interpolation at its rim. */
  void fillCorners() {
    const Image original = image;
    const auto centre = [&](int i) { return (i + 0.5) * 2 / cell - 1; };
    for (int y = 0; y < cell; ++y)
      for (int x = 0; x < cell; ++x) {
        const Vec2d p(centre(x), centre(y));
        const double r = glm::length(p);
        if (r <= 1) continue;
        const Vec2d inside = (p * ((1 - 1.5 / cell) / r) + 1.0) * (cell / 2.0);
        const float* from = original.at(std::clamp(static_cast<int>(inside.x), 0, cell - 1),
                                        std::clamp(static_cast<int>(inside.y), 0, cell - 1));
        std::copy_n(from, original.channels.size(), image.at(x, y));
      }
  }

  Image image;
  Layout layout;
  int cell; ///< pixels along a side
};

/** Probe in the equal-area square, scaled to the integral of the picture. */
EnvironmentMap resampled(const ProbePicture& probe) {
  constexpr int PARTS = 4; // subsamples of a pixel along each side
  const int n = probe.resolution();
  Image square(n, n, {"R", "G", "B"});
  parallelFor(size_t(n), [&](size_t y) {
    for (int x = 0; x < n; ++x) {
      Rgbd sum(0);
      for (int k = 0; k < PARTS * PARTS; ++k) {
        const Vec2d place(x + (k % PARTS + 0.5) / PARTS, double(y) + (k / PARTS + 0.5) / PARTS);
        const Vec3d d = directionOfPlace(EnvironmentMapping::EQUAL_AREA, place / double(n));
        sum += probe.value({-d.y, d.z, d.x});
      }
      for (int c = 0; c < 3; ++c)
        square.at(x, static_cast<int>(y))[c] = static_cast<float>(sum[c] / (PARTS * PARTS));
    }
  });
  const Rgbd wanted = probe.integral(),
             is = EnvironmentMap(square, EnvironmentMapping::EQUAL_AREA).integral();
  for (size_t i = 0; i < square.pixels.size(); ++i)
    if (is[int(i % 3)] > 0) square.pixels[i] *= static_cast<float>(wanted[int(i % 3)] / is[int(i % 3)]);
  return EnvironmentMap(square, EnvironmentMapping::EQUAL_AREA);
}

/** Whether the pixels that `choose` takes are all of one colour; true for none. */
template <class Choose> bool isOneColour(const Image& image, const Choose& choose) {
  std::optional<Rgb> first;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (!choose(x, y)) continue;
      if (!first) first = image.rgb(x, y);
      if (image.rgb(x, y) != *first) return false;
    }
  return true;
}

bool hasEmptyCells(const Image& image, Layout layout) {
  const int size = image.width / (layout == Layout::VERTICAL_CROSS ? 3 : 4);
  return isOneColour(image, [&](int x, int y) {
    return std::none_of(facesOf(layout).begin(), facesOf(layout).end(),
                        [&](const Face& f) { return x / size == f.column && y / size == f.row; });
  });
}

/** Whether the area outside the circle is of one colour. */
bool hasEmptyCorners(const Image& image) {
  const double rim = square(1 + 2.0 / image.width);
  return isOneColour(image, [&](int x, int y) {
    const Vec2d p(2 * (x + 0.5) / image.width - 1, 2 * (y + 0.5) / image.width - 1);
    return glm::dot(p, p) > rim;
  });
}

bool fits(const Image& image, Layout layout) {
  const int w = image.width, h = image.height;
  if (layout == Layout::LATITUDE_LONGITUDE) return true;
  if (layout == Layout::VERTICAL_CROSS) return w % 3 == 0 && h == w / 3 * 4;
  if (layout == Layout::HORIZONTAL_CROSS) return w % 4 == 0 && h == w / 4 * 3;
  return w == h;
}

/** Layout by shape and file name. A square is an equal-area map as in pbrt, unless it has empty corners
 * and a name that ends in _probe, like Debevec's. */
std::optional<Layout> guess(const Image& image, const std::string& fileName) {
  for (const Layout cross : {Layout::VERTICAL_CROSS, Layout::HORIZONTAL_CROSS})
    if (fits(image, cross) && hasEmptyCells(image, cross)) return cross;
  if (image.width == 2 * image.height) return Layout::LATITUDE_LONGITUDE;
  if (image.width != image.height) return {};
  const bool calledProbe = std::filesystem::path(fileName).stem().string().ends_with("_probe");
  return calledProbe && hasEmptyCorners(image) ? Layout::ANGULAR : Layout::EQUAL_AREA;
}

Layout layoutOf(const Parameters& p, const Image& image) {
  const std::string shape = std::to_string(image.width) + " by " + std::to_string(image.height) + " pixels";
  if (p.hasValue("mapping")) {
    for (const NamedLayout& l : LAYOUTS) {
      if (p.string("mapping") != l.name) continue;
      if (!fits(image, l.layout))
        p.fail("mapping", "a picture of " + shape + " cannot be \"" + l.name + "\"", l.shape);
      return l.layout;
    }
  }
  const std::optional<Layout> guessed = guess(image, p.string("filename"));
  if (!guessed) {
    std::string accepted;
    for (const NamedLayout& l : LAYOUTS)
      accepted += (accepted.empty() ? "" : "; ") + std::string(l.shape) + " (\"" + l.name + "\")";
    p.fail("filename", "a picture of " + shape + " is not a known mapping of all directions",
           accepted + "; or \"mapping\" \"latlong\" for any size");
  }
  if (*guessed != Layout::EQUAL_AREA)
    for (const NamedLayout& l : LAYOUTS)
      if (l.layout == *guessed)
        p.warn("filename",
               "the mapping of the picture is assumed to be \"" + std::string(l.name) + "\", by its " +
                   (*guessed == Layout::ANGULAR ? "name and its black corners" : "shape"),
               "\"string mapping\" to set it");
  return *guessed;
}

} // namespace

const std::vector<std::string>& probeLayouts() {
  static const std::vector<std::string> NAMES = [] {
    std::vector<std::string> names;
    for (const NamedLayout& l : LAYOUTS) names.emplace_back(l.name);
    return names;
  }();
  return NAMES;
}

Image readLightPicture(const Parameters& p) {
  const FileReference file = p.file("filename");
  const std::string& path = file.path;
  Image image;
  try {
    image = readImage(file);
  } catch (const Error& e) {
    p.fail("filename", e.what());
  }
  if (image.width < 1 || image.height < 1) p.fail("filename", path + ": has no pixels");
  size_t negative = 0;
  bool dark = true;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (size_t c = 0; c < std::min<size_t>(3, image.channels.size()); ++c) {
        float& v = image.at(x, y)[c];
        if (!std::isfinite(v))
          p.fail("filename",
                 path + ": pixel " + std::to_string(x) + ", " + std::to_string(y) +
                     " (from the top left) is " + (std::isnan(v) ? "no number" : "infinite"),
                 "a picture whose values are all finite");
        negative += v < 0;
        v = std::max(v, 0.0f);
        dark = dark && v == 0;
      }
  if (negative > 0)
    p.warn("filename", path + ": " + std::to_string(negative) +
                           (negative == 1 ? " value is" : " values are") + " negative, and replaced by 0");
  if (dark) p.warn("filename", path + ": is black everywhere: the light emits nothing");
  return image;
}

EnvironmentMap readLightProbe(const Parameters& p) {
  Image image = readLightPicture(p);
  const Layout layout = layoutOf(p, image);
  if (layout == Layout::EQUAL_AREA) return {image, EnvironmentMapping::EQUAL_AREA};
  if (layout == Layout::LATITUDE_LONGITUDE) return {image, EnvironmentMapping::LATITUDE_LONGITUDE};
  return resampled(ProbePicture(std::move(image), layout));
}

} // namespace recurse
