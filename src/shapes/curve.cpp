/** @file
 * Curves as in pbrt-v4: Bézier and B-spline, flat, cylinder and ribbon.
 */
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/shape/curveShape.h"

namespace recurse {

namespace {

using Segment = CurveShape::Segment;

/** A quadratic Bézier segment as a cubic one. */
Segment raised(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return {{a, a + (b - a) * (2 / 3.0), c + (b - c) * (2 / 3.0), c}, 0, 0};
}

Segment bezierSegment(const Vec3d* p, int degree) {
  return degree == 3 ? Segment{{p[0], p[1], p[2], p[3]}, 0, 0} : raised(p[0], p[1], p[2]);
}

/** A segment of a uniform B-spline as a Bézier one. */
Segment splineSegment(const Vec3d* p, int degree) {
  if (degree == 2) return raised(0.5 * (p[0] + p[1]), p[1], 0.5 * (p[1] + p[2]));
  return {{(p[0] + 4.0 * p[1] + p[2]) / 6.0, (2.0 * p[1] + p[2]) / 3.0, (p[1] + 2.0 * p[2]) / 3.0,
           (p[1] + 4.0 * p[2] + p[3]) / 6.0},
          0,
          0};
}

std::unique_ptr<Shape> makeCurve(const Parameters& p, const ShapeContext& context) {
  const std::vector<Vec3d> points = p.vector3s("P");
  const int degree = p.integer("degree");
  const auto order = static_cast<size_t>(degree);
  const bool spline = p.string("basis") == "bspline";
  if (points.size() < order + 1 || (!spline && (points.size() - 1) % order != 0))
    p.fail("P",
           std::to_string(points.size()) + " control points do not form " + p.string("basis") +
               " curves of degree " + std::to_string(degree),
           spline ? std::to_string(order + 1) + " or more"
                  : std::to_string(order + 1) + ", and " + std::to_string(order) +
                        " more for each further segment");
  const std::string word = p.string("type");
  const CurveShape::Kind kind = word == "flat"       ? CurveShape::Kind::FLAT
                                : word == "cylinder" ? CurveShape::Kind::CYLINDER
                                                     : CurveShape::Kind::RIBBON;
  const size_t count = spline ? points.size() - order : (points.size() - 1) / order;
  std::vector<Vec3d> normals;
  if (kind == CurveShape::Kind::RIBBON) {
    if (p.has("N")) normals = p.vector3s("N");
    if (normals.size() != count + 1)
      p.fail(p.has("N") ? "N" : "type", std::to_string(normals.size()) + " normals given for a ribbon",
             "\"normal N\" with " + std::to_string(count + 1) + ": one for each end of a segment");
    for (const Vec3d& n : normals)
      if (n == Vec3d(0)) p.fail("N", "a normal is zero");
  }
  const double width0 = p.has("width0") ? p.real("width0") : p.real("width"),
               width1 = p.has("width1") ? p.real("width1") : p.real("width");
  std::vector<Segment> segments;
  for (size_t i = 0; i < count; ++i) {
    segments.push_back(spline ? splineSegment(&points[i], degree)
                              : bezierSegment(&points[i * order], degree));
    Segment& s = segments.back();
    const double from = double(i) / double(count), to = double(i + 1) / double(count);
    s.width0 = width0 * (1 - from) + width1 * from;
    s.width1 = width0 * (1 - to) + width1 * to;
    if (!normals.empty()) {
      s.normal0 = normals[i];
      s.normal1 = normals[i + 1];
      if (glm::dot(s.normal0, s.normal1) < 0 && glm::length(glm::cross(s.normal0, s.normal1)) == 0)
        p.fail("N", "normals " + std::to_string(i) + " and " + std::to_string(i + 1) +
                        " are opposite: the normal between them is not defined");
    }
  }
  try {
    return std::make_unique<CurveShape>(segments, kind, context);
  } catch (const Error& e) {
    p.fail("P", e.what());
  }
}

} // namespace

void registerCurve(PlugIns& plugIns) {
  const auto width = [](const char* name, const char* standard, const char* what) {
    return realParameter(name, standard, what).range(0, std::numeric_limits<double>::infinity());
  };
  plugIns.shapes.add(
      {{.name = "curve",
        .summary = "A thin curve for hair, grass and threads: a ribbon of constant or varying width. It "
                   "cannot emit light; a transform that stretches it scales its width by the mean factor.",
        .parameters =
            {arrayParameter(ParameterType::POINT3, "P", 0, "", "control points").require(),
             integerParameter("degree", "3", "degree of the polynomials").range(2, 3),
             stringParameter("basis", "bezier", "basis of the control points").oneOf({"bezier", "bspline"}),
             stringParameter("type", "flat",
                             "\"flat\": faces the viewer; \"cylinder\": faces the viewer, with the shading "
                             "of a tube; \"ribbon\": oriented by N")
                 .oneOf({"flat", "cylinder", "ribbon"}),
             arrayParameter(ParameterType::NORMAL, "N", 0, "",
                            "normal of a ribbon at each end of a segment; other types do not use it"),
             width("width", "1", "width"), width("width0", "", "width at the beginning; by default width"),
             width("width1", "", "width at the end; by default width"),
             ignoredParameter(ParameterType::INTEGER, "splitdepth", "pbrt's number of subdivisions")},
        .examples =
            {"\"point3 P\" [0 0 0  .1 .4 0  .3 .7 .1  .2 1 .3] \"float width\" .05",
             "\"string type\" \"cylinder\" \"string basis\" \"bspline\" \"point3 P\" [0 0 0  .1 .4 0  "
             ".3 .7 .1  .2 1 .3  0 1.5 .2] \"float width0\" .1 \"float width1\" .02",
             "\"string type\" \"ribbon\" \"integer degree\" 2 \"point3 P\" [0 0 0  .5 .4 0  0 1 0] "
             "\"normal N\" [0 0 1  .6 0 .8]"}},
       makeCurve});
}

} // namespace recurse
