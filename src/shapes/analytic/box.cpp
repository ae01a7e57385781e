/** @file
 * Axis-aligned boxes; transforms make parallelepipeds of them.
 */
#include "recurse/model/scene/plugIns.h"
#include "shapes/analytic/mappedShape.h"

namespace recurse {

namespace {

class Box final : public MappedShape {
 public:
  Box(const Vec3d& lower, const Vec3d& upper, const ShapeContext& context) {
    const Vec3d size = upper - lower;
    const double largest = std::max(size.x, std::max(size.y, size.z));
    corner = size / largest;
    Mat4d m = context.sceneFromObject;
    for (int i = 0; i < 3; ++i) m[i] *= largest;
    m[3] = Vec4d(transformPoint(context.sceneFromObject, lower), 1);
    std::vector<double> areas;
    for (int face = 0; face < 6; ++face)
      areas.push_back(corner[(face / 2 + 1) % 3] * corner[(face / 2 + 2) % 3]);
    prepare(m, {Vec3d(0), corner}, areas, context.reverseOrientation);
  }

 protected:
  /** Faces are numbered by axis, the lower one first. */
  void intersectAll(const Line& line, LineHits& found) const override {
    double tIn = -std::numeric_limits<double>::infinity(), tOut = -tIn;
    uint32_t faceIn = 0, faceOut = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double o = line.origin[static_cast<int>(axis)], d = line.direction[static_cast<int>(axis)];
      const double far = corner[static_cast<int>(axis)];
      if (d == 0) {
        if (o < 0 || o > far) return;
        continue;
      }
      const double tLow = (0 - o) / d, tHigh = (far - o) / d;
      const uint32_t nearer = 2 * axis + (d < 0);
      if (std::min(tLow, tHigh) > tIn) {
        tIn = std::min(tLow, tHigh);
        faceIn = nearer;
      }
      if (std::max(tLow, tHigh) < tOut) {
        tOut = std::max(tLow, tHigh);
        faceOut = nearer ^ 1;
      }
    }
    if (!(tIn < tOut)) return;
    found.add({tIn, faceIn, true, line.at(tIn)});
    found.add({tOut, faceOut, false, line.at(tOut)});
  }

  OwnPoint ownPoint(uint32_t part, const Vec3d& near) const override {
    const auto axis = static_cast<int>(part / 2);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    OwnPoint s;
    s.position = glm::clamp(near, Vec3d(0), corner);
    s.position[axis] = part & 1 ? corner[axis] : 0;
    s.normal = s.dpdu = s.dpdv = Vec3d(0);
    s.normal[axis] = part & 1 ? 1 : -1;
    s.dpdu[a] = corner[a];
    s.dpdv[b] = corner[b];
    s.uv = {s.position[a] / corner[a], s.position[b] / corner[b]};
    return s;
  }

  std::optional<Vec3d> pointOfPart(uint32_t part, const Vec2d& uv) const override {
    return ownSample(part, uv);
  }

  Vec3d ownSample(uint32_t part, const Vec2d& u) const override {
    const auto axis = static_cast<int>(part / 2);
    Vec3d p;
    p[axis] = part & 1 ? corner[axis] : 0;
    p[(axis + 1) % 3] = u.x * corner[(axis + 1) % 3];
    p[(axis + 2) % 3] = u.y * corner[(axis + 2) % 3];
    return p;
  }

  std::string whyOpen() const override { return ""; }

 private:
  Vec3d corner; ///< opposite to the corner at the origin of own space
};

} // namespace

void registerBox(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "box",
        .summary = "A box with sides along the axes, between two opposite corners.",
        .parameters = {arrayParameter(ParameterType::POINT3, "p1", 1, "-1 -1 -1", "one corner"),
                       arrayParameter(ParameterType::POINT3, "p2", 1, "1 1 1", "the opposite corner")},
        .examples = {"", "\"point3 p1\" [0 2 3] \"point3 p2\" [1 1 3.5]"}},
       [](const Parameters& p, const ShapeContext& context) {
         const Vec3d p1 = p.vector3("p1"), p2 = p.vector3("p2");
         for (int i = 0; i < 3; ++i)
           if (p1[i] == p2[i])
             p.fail(p.has("p1") ? "p1" : "p2", "the box is flat", "corners that differ in each coordinate");
         return std::make_unique<Box>(glm::min(p1, p2), glm::max(p1, p2), context);
       }});
}

} // namespace recurse
