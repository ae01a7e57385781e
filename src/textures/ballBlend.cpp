/** @file
 * Values of balls, blended by the fields of metaballs.
 */
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/shape/ballField.h"
#include "recurse/model/shape/boxTree.h"
#include "recurse/model/texture/textureMapping.h"

namespace recurse {

namespace {

/** Mean of the balls' values, weighted by their fields at the point. */
class BallBlend final : public Texture {
 public:
  BallBlend(const Parameters& p, const TextureContext& c) : space(c), field(ballField(p.string("field"))) {
    const std::vector<Vec3d> centers = p.vector3s("P");
    const std::vector<double> radii = numbersOfBalls(p, "radius", centers.size()),
                              strengths = numbersOfBalls(p, "strength", centers.size());
    const std::vector<Rgbd> values = p.spectra("values");
    requireEach(p, "values", values.size(), centers.size());
    for (const Rgbd& v : values)
      if (!c.spectrum && v != Rgbd(v.r))
        p.fail("values", "a float texture cannot have colours", "\"float values\"");
    std::vector<Bounds3d> boxes;
    for (size_t i = 0; i < centers.size(); ++i) {
      if (!(strengths[i] > 0)) continue; // a ball that subtracts has no value
      balls.push_back({centers[i], radii[i], strengths[i], values[i]});
      boxes.push_back({centers[i] - radii[i], centers[i] + radii[i]});
    }
    if (balls.empty()) p.fail("strength", "no ball has a positive strength");
    tree = BoxTree(boxes);
  }

  Rgb value(const SurfacePoint& point) const override {
    const Vec3d p = space.at(point).p;
    Rgbd sum(0);
    double weights = 0;
    tree.visit(p, {1, 0, 0}, 0, 0, [&](uint32_t i) {
      const Ball& b = balls[i];
      const double q = b.squaredDistance(p);
      if (q >= 1) return;
      const double weight = b.strength * field(q);
      sum += b.value * weight;
      weights += weight;
    });
    if (weights > 0) return Rgb(sum / weights);
    const auto nearest = std::min_element(balls.begin(), balls.end(), [&](const Ball& a, const Ball& b) {
      return a.squaredDistance(p) < b.squaredDistance(p);
    });
    return Rgb(nearest->value);
  }

 private:
  struct Ball {
    Vec3d center;
    double radius, strength;
    Rgbd value;
    double squaredDistance(const Vec3d& p) const {
      const Vec3d away = (p - center) / radius;
      return glm::dot(away, away);
    }
  };

  TextureSpace space;
  BallField field;
  std::vector<Ball> balls;
  BoxTree tree;
};

} // namespace

void registerBallBlend(PlugIns& plugIns) {
  ParameterSpec radius =
      arrayParameter(ParameterType::REAL, "radius", 0, "1", "radius of the balls; one for all or one each");
  ParameterSpec values = textureValue("values", "", "value of each ball");
  values.textured = false;
  values.count = 0;
  plugIns.textures.add(
      {{.name = "metaballs",
        .summary = "Values blended by the fields of balls. With the balls of a shape \"metaballs\" in the "
                   "same space, colours and other parameters blend like its surface.",
        .parameters = {arrayParameter(ParameterType::POINT3, "P", 0, "", "centers of the balls").require(),
                       radius.positive(),
                       arrayParameter(ParameterType::REAL, "strength", 0, "1",
                                      "weight at the center of each ball; balls with weight 0 or less are "
                                      "ignored; one for all or one each"),
                       values.require(),
                       stringParameter("field", "quartic", "falloff of the field, as for the shape")
                           .oneOf({"quartic", "sextic", "wyvill", "blinn"})},
        .examples = {"\"point3 P\" [-.5 0 0  .5 .1 0] \"float values\" [.2 .8]",
                     "\"point3 P\" [0 0 0  1 0 0] \"float radius\" [1 2] \"float strength\" [1 -1] "
                     "\"float values\" [.3 .4] \"string field\" \"blinn\""}},
       [](const Parameters& p, const TextureContext& c) { return std::make_unique<BallBlend>(p, c); }});
}

} // namespace recurse
