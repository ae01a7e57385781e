/** @file
 * A camera with a system of lenses, traced from the film to the scene (Kolb, Mitchell and Hanrahan 1995, "A
 * Realistic Camera Model for Computer Graphics").
 *
 * In lens space the film is the plane z = 0, and the scene is towards +z. Lengths are in metres, which are
 * the units of camera space.
 */
#include <charconv>
#include <fstream>
#include <sstream>

#include "cameras/frame/cameraFrame.h"
#include "cameras/realistic/lensSystem.h"
#include "recurse/core/image/image.h"
#include "recurse/core/io/text.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

constexpr size_t MAX_SURFACES = 1000;

std::vector<LensSurface> readLens(const Parameters& p) {
  const std::string path = p.filePath("lensfile");
  std::ifstream in(path);
  std::vector<LensSurface> surfaces;
  std::vector<double> numbers;
  std::string line;
  const auto fail = [&](int row, const std::string& what, const std::string& accepted) {
    p.fail("lensfile", "\"" + path + "\" line " + std::to_string(row) + ": " + what, accepted);
  };
  int begin = 0; // line of the surface's first number
  for (int row = 1; std::getline(in, line); ++row) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      double number = 0;
      const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (error != std::errc() || stop != word.data() + word.size() || !std::isfinite(number))
        fail(row, "\"" + word.substr(0, 40) + "\" is not a number", "numbers in millimetres");
      if (numbers.empty()) begin = row;
      numbers.push_back(number);
      if (numbers.size() < 4) continue;
      constexpr double MILLIMETRE = 0.001;
      const LensSurface s{numbers[0] * MILLIMETRE, numbers[1] * MILLIMETRE, numbers[2] == 0 ? 1 : numbers[2],
                          numbers[3] * MILLIMETRE / 2};
      numbers.clear();
      if (!(s.apertureRadius > 0)) fail(begin, "a lens without a diameter", "a diameter above 0");
      if (!(s.index >= 1 && s.index <= 5))
        fail(begin, "impossible glass", "an index from 1 to 5, or 0 for air");
      if (!(s.thickness >= 0))
        fail(begin, "surfaces in the wrong order", "a distance to the next surface of 0 or more");
      surfaces.push_back(s);
      if (surfaces.size() > MAX_SURFACES) fail(row, "there are too many surfaces", "at most 1000");
    }
  }
  if (!numbers.empty())
    fail(begin, "the last surface is incomplete",
         "four numbers for each: radius, distance to the next, index behind, diameter");
  if (surfaces.empty()) p.fail("lensfile", "\"" + path + "\" has no surfaces");
  return surfaces;
}

/** Whether a point is inside a polygon, by the parity of the sides that a ray from it crosses. */
bool isInside(const std::vector<Vec2d>& polygon, const Vec2d& p) {
  bool inside = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2d &a = polygon[i], &b = polygon[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) inside = !inside;
  }
  return inside;
}

/** Corners on two concentric circles, alternately. */
std::vector<Vec2d> corners(int count, double radius, double otherRadius, double turn) {
  std::vector<Vec2d> all;
  for (int i = 0; i < count; ++i) {
    const double angle = turn + 2 * M_PI * i / count;
    all.push_back(Vec2d(std::cos(angle), std::sin(angle)) * (i % 2 ? otherRadius : radius));
  }
  return all;
}

/** Mask scaled to the transmittance of a round stop for uniform light: mean π/4 over the enclosing square. */
LensSystem::Mask normalised(const LensSystem::Mask& mask) {
  constexpr int GRID = 512;
  double sum = 0;
  for (int i = 0; i < GRID * GRID; ++i) sum += mask((Vec2d(i % GRID, i / GRID) + 0.5) * (2.0 / GRID) - 1.0);
  const double factor = sum > 0 ? M_PI / 4 * GRID * GRID / sum : 0;
  return [=](const Vec2d& p) { return mask(p) * factor; };
}

/** Mask of the stop from "aperture": a shape of pbrt-v4, or a picture. */
LensSystem::Mask maskOf(const Parameters& p) {
  const std::string name = p.hasValue("aperture") ? p.string("aperture") : "";
  const auto polygon = [](const std::vector<Vec2d>& c) {
    return normalised([c](const Vec2d& q) { return isInside(c, q) ? 1.0 : 0.0; });
  };
  if (name.empty()) return {};
  if (name == "gaussian")
    return normalised(
        [](const Vec2d& q) { return std::max(0.0, std::exp(-glm::dot(q, q)) - std::exp(-1.0)); });
  if (name == "square") return polygon(corners(4, std::sqrt(0.5), std::sqrt(0.5), M_PI / 4));
  if (name == "pentagon") return polygon(corners(5, 0.8, 0.8, M_PI / 2));
  if (name == "star") return polygon(corners(10, std::cos(0.4 * M_PI) / std::cos(0.2 * M_PI), 1, 0));
  const std::string path = p.filePath("aperture");
  auto picture = std::make_shared<Image>();
  try {
    *picture = readImage(path);
  } catch (const Error& e) {
    p.fail("aperture", e.what());
  }
  const auto mask = [picture](const Vec2d& q) {
    const int x = std::clamp(static_cast<int>((q.x + 1) / 2 * picture->width), 0, picture->width - 1);
    const int y = std::clamp(static_cast<int>((1 - q.y) / 2 * picture->height), 0, picture->height - 1);
    return std::max(0.0, double(channelSum(picture->rgb(x, y))) / 3);
  };
  return normalised(mask);
}

class Realistic final : public Camera {
 public:
  Realistic(const Parameters& p, const CameraContext& c)
      : Camera(p, c), track(c.sceneFromCamera), lens(lensOf(p)), size(c.width, c.height),
        film(Vec2d(c.width, c.height) * (c.diagonal / std::hypot(double(c.width), double(c.height)))),
        diagonal(c.diagonal), spread(film.x / size.x / lens.focalLength()) {
    findExitPupils();
  }

  bool usesLens() const override { return true; }
  bool usesTime() const override { return track.moves(); }

  /** Radiance through the lens to a film point, weighted to be the irradiance there over solid angle one:
   * cos⁴ / distance² · sampled area, as in pbrt-v4. */
  std::optional<CameraRay> sampleRay(const CameraSample& sample) const override {
    // The lens inverts the image.
    const Vec2d onFilm((0.5 - double(sample.film.x) / size.x) * film.x,
                       (double(sample.film.y) / size.y - 0.5) * film.y);
    double area = 0;
    const Vec3d from(onFilm, 0), to = pupilPoint(onFilm, sample.lens, area);
    const std::optional<LensRay> out = lens.trace({from, glm::normalize(to - from)});
    if (!out) return {};
    const double cosine = glm::normalize(to - from).z;
    CameraRay r;
    r.time = sample.time;
    r.weight = static_cast<float>(out->weight * square(square(cosine)) * area / square(to.z));
    r.spread = static_cast<float>(spread);
    track.at(sample.time, [&](const CameraFrame& frame) {
      r.origin = Vec3f(frame.pointToScene(out->origin));
      r.direction = Vec3f(glm::normalize(frame.vectorToScene(out->direction)));
    });
    return r;
  }

 private:
  static LensSystem lensOf(const Parameters& p) {
    std::vector<LensSurface> surfaces = readLens(p);
    if (p.has("aperturediameter"))
      for (LensSurface& s : surfaces)
        if (s.isStop()) s.apertureRadius = std::min(s.apertureRadius, p.real("aperturediameter") / 2000);
    const double distance = p.real("focusdistance");
    try {
      return LensSystem(std::move(surfaces), distance, maskOf(p));
    } catch (const LensSystem::CannotFocus& e) {
      p.fail(e.nearest > 0 ? "focusdistance" : "lensfile", e.what(),
             e.nearest > 0 ? formatted("a distance from the film above %.4g", e.nearest)
                           : "a converging lens");
    }
  }

  /** Finds bounds of the exit pupil in the plane of the rearmost surface, for film points along +x, by
   * their distance from the middle. */
  void findExitPupils() {
    pupils.resize(PUPILS);
    parallelFor(PUPILS, [&](size_t i) {
      const double width = diagonal / 2 / PUPILS;
      const double margin = 1.5 * lens.rearRadius();
      Bounds<Vec2d> all{Vec2d(-margin), Vec2d(margin)};
      // A coarse search over the surface and a margin, a fine one where that fails, then one in the result.
      Bounds<Vec2d> found = pupilWithin(all, double(i) * width, width, COARSE);
      if (found.lower.x > found.upper.x) found = pupilWithin(all, double(i) * width, width, FINE);
      if (found.lower.x <= found.upper.x) all = pupilWithin(found, double(i) * width, width, COARSE);
      pupils[i] = all;
    });
  }
  /** Bounds of the cells of a grid over a box that pass light to film points from x to x + width, extended
   * by one cell. */
  Bounds<Vec2d> pupilWithin(const Bounds<Vec2d>& box, double x, double width, int grid) const {
    const Vec2d cell = box.diagonal() / double(grid);
    Bounds<Vec2d> found;
    for (const double at : {x, x + width / 2, x + width})
      for (int k = 0; k < grid * grid; ++k) {
        const Vec2d p = box.lower + (Vec2d(k % grid, k / grid) + 0.5) * cell;
        const bool known =
            glm::all(glm::lessThanEqual(found.lower, p)) && glm::all(glm::lessThanEqual(p, found.upper));
        const Vec3d from(at, 0, 0), to(p, lens.rearZ());
        if (!known && lens.trace({from, glm::normalize(to - from)})) found.add(p);
      }
    if (found.lower.x > found.upper.x) return found;
    return {found.lower - cell, found.upper + cell};
  }
  Vec3d pupilPoint(const Vec2d& onFilm, const Vec2f& u, double& area) const {
    const double radius = glm::length(onFilm);
    const auto i = std::min(size_t(radius / (diagonal / 2) * PUPILS), size_t(PUPILS - 1));
    const Bounds<Vec2d>& b = pupils[i];
    area = b.diagonal().x * b.diagonal().y;
    const Vec2d p = b.lower + b.diagonal() * Vec2d(u);
    const Vec2d turn = radius > 0 ? onFilm / radius : Vec2d(1, 0);
    return {turn.x * p.x - turn.y * p.y, turn.y * p.x + turn.x * p.y, lens.rearZ()};
  }

  static constexpr int PUPILS = 64, COARSE = 48, FINE = 256;
  CameraTrack track;
  LensSystem lens;
  Vec2d size;      ///< size of the film [pixels]
  Vec2d film;      ///< size of the film [m]
  double diagonal; ///< diagonal of the film [m]
  double spread;   ///< angle of a pixel near the axis [rad]
  std::vector<Bounds<Vec2d>> pupils;
};

} // namespace

void registerRealistic(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = cameraParameters();
  for (const ParameterSpec& p :
       {stringParameter(
            "lensfile", "",
            "lens table: for each surface, from the scene to the film, radius of curvature (0: the aperture "
            "stop), distance to the next surface, refractive index behind it and diameter [mm]")
            .require(),
        realParameter("aperturediameter", "1",
                      "diameter of the aperture stop, limited by that of the file [mm]")
            .positive(),
        realParameter("focusdistance", "10", "distance from the film to the plane in focus [m]").positive(),
        stringParameter("aperture", "",
                        "shape of the aperture: \"gaussian\", \"square\", \"pentagon\", \"star\" or a "
                        "picture's file; by default round")})
    parameters.push_back(p);
  plugIns.cameras.add(
      {{.name = "realistic",
        .summary = "A system of lenses in front of a film of the size \"diagonal\" of Film; a scene unit is "
                   "a metre. Pixels have the exposure of the film.",
        .parameters = parameters,
        .examples = {"\"string lensfile\" \"scenes/lenses/double-gauss.dat\" \"float aperturediameter\" 15 "
                     "\"float focusdistance\" 1.7"}},
       [](const Parameters& p, const CameraContext& c) { return std::make_unique<Realistic>(p, c); }});
}

} // namespace recurse
