/** @file
 * Shapes of a scene: the top level, and a group for each object definition and each shape that moves.
 */
#pragma once

#include <deque>

#include "model/builder/moving.h"
#include "model/builder/sceneMaterials.h"
#include "model/builder/sceneMedia.h"
#include "model/mesh/viewDicing.h"
#include "recurse/model/scene/keptParts.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

class ShapeGroups final : public ShapeLookup {
 public:
  /** A shape with its place in a group, before the lights are known. */
  struct Placed {
    const Shape* shape;
    const Material* material;
    const ShapeDescription* from;
    MediumInterface media;
    const InstanceDescription* partOf; ///< null: stands by itself
  };
  struct Group {
    Vec3d origin{0}; ///< taken off the object's positions
    std::vector<Placed> placed;
    std::string object;     ///< whose instances it stands for; empty: it stands where `start` says
    Mat4d start = Mat4d(1); ///< world from its space when the motion starts
  };
  /** A group in the scene: world from instance space, and that from the space of a shape that moves. */
  struct Instance {
    size_t group;
    AnimatedTransform instance, shape;
    const ShapeDescription* from;      ///< where it is a shape alone
    const InstanceDescription* partOf; ///< null: stands by itself
  };

  /** What is made is kept in `shapes`. Guesses the scene's origin. `kept` may be null. */
  ShapeGroups(BuildContext& context, SceneMaterials& materials, SceneMedia& media,
              std::vector<std::shared_ptr<Shape>>& shapes, KeptParts* kept);

  /** Makes all shapes, those that are displaced for pixels of a film, and corrects the scene's origin. False
   * after an error. */
  bool build(const FilmSettings& film);

  /** [0] is the top level; addresses stay. */
  const std::deque<Group>& groups() const { return all; }
  const std::vector<Instance>& instances() const { return placedInstances; }
  MatrixTrack sceneFromGroup(const Instance& i) const;
  /** Of all shapes, in the scene. */
  Bounds3d bounds() const;
  /** Of those that bound a medium. */
  Bounds3d boundsOfMedium(uint16_t medium) const;
  void count(SceneContents& contents) const;

  std::vector<ComponentShape> object(const Parameters& p, const std::string& parameter,
                                     const std::string& name, const ShapeContext& context) override;

 private:
  /** Of those shapes that are counted: of a group in its instances' space, or of all in the scene. */
  template <class Counts> static Bounds3d boundsOf(const Group& g, const Counts& counts);
  template <class Counts> Bounds3d boundsOfAll(const Counts& counts) const;
  /** A shape of the frame before where nothing has changed, else a new one. `key`: what it is kept by; empty
   * where it depends on more than its directive. */
  std::shared_ptr<Shape> makeShape(const ShapeDescription& s, const ShapeContext& context, std::string& key);
  /** A new one; null after an error, which has its place also where memory is short. */
  std::unique_ptr<Shape> newShape(const ShapeDescription& s, const ShapeContext& context);
  /** For a shape of the group, where it may be displaced; null: it is not. */
  std::unique_ptr<Dicing> dicingOf(const ShapeDescription& s, const Group& group);
  /** Solids that a shape is made of, and at how many levels; 1 and 0 for others than CSG. */
  struct SolidCount {
    double solids = 0;
    int levels = 0;
  };
  /** `level`: of shapes that are made of this one. */
  SolidCount solidsIn(const ShapeDescription& s, int level);
  /** False after an error: shapes are made of more solids than there may be, or at too many levels. */
  bool checkSolids();
  /** Leaves the shapes to the next frame. */
  void keepShapes();
  /** Makes a shape into `group`, unless it can neither be seen nor stop light. */
  void addShape(const ShapeDescription& s, const Mat4d& placement, Group& group,
                const InstanceDescription* partOf = nullptr);
  /** Fills a group; a second time, better centred, when the first guess of its place was bad. */
  template <class Fill> void fillGroup(Group& group, const Fill& fill);
  /** A moving shape as a group of its own, as it is at the start. */
  void addMoving(const ShapeDescription& s, const AnimatedTransform& instance, const SourceLocation& where,
                 const InstanceDescription* partOf);

  BuildContext& c;
  SceneMaterials& materials;
  SceneMedia& media;
  std::vector<std::shared_ptr<Shape>>& shapes;
  KeptParts* kept;
  std::vector<std::string> keys; ///< of `shapes`
  FilmSettings film;
  Vec3d guessedOrigin{0};
  std::unique_ptr<PixelWidths> pixels; ///< made when first wanted
  size_t objectsAsked = 0;             ///< how often shapes have asked for objects
  std::deque<Group> all;
  std::vector<Instance> placedInstances;
  std::vector<std::string> objectsUnderWay;   ///< whose shapes are being made into others
  std::map<std::string, SolidCount> solidsOf; ///< objects
};

} // namespace recurse
