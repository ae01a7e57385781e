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
  /** A shape of a group, with its material and media; lights are made later. */
  struct Placed {
    const Shape* shape;
    const Material* material;
    const ShapeDescription* from;
    MediumInterface media;
    const InstanceDescription* partOf; ///< null: not part of an instance
  };
  struct Group {
    Vec3d origin{0}; ///< subtracted from the object's positions
    std::vector<Placed> placed;
    std::string object;     ///< object whose instances place the group; empty: `start` places it
    Mat4d start = Mat4d(1); ///< world from group space at the start of the motion
  };
  /** A placed group: world from instance space, and instance space from a moving shape's space. */
  struct Instance {
    size_t group;
    AnimatedTransform instance, shape;
    const ShapeDescription* from;      ///< of a shape that moves alone; else null
    const InstanceDescription* partOf; ///< null: not part of an instance
  };

  /** `shapes` owns the made shapes. Guesses the scene's origin. `kept` may be null. */
  ShapeGroups(BuildContext& context, SceneMaterials& materials, SceneMedia& media,
              std::vector<std::shared_ptr<Shape>>& shapes, KeptParts* kept);

  /** Makes all shapes and corrects the scene's origin. Displaced shapes are diced for the pixels of `film`.
   * False after an error. */
  bool build(const FilmSettings& film);

  /** Groups; [0] is the top level. Addresses are stable. */
  const std::deque<Group>& groups() const { return all; }
  const std::vector<Instance>& instances() const { return placedInstances; }
  MatrixTrack sceneFromGroup(const Instance& i) const;
  /** Bounds of all shapes, in the scene. */
  Bounds3d bounds() const;
  /** Bounds of the shapes that bound a medium, in the scene. */
  Bounds3d boundsOfMedium(uint16_t medium) const;
  void count(SceneContents& contents) const;

  std::vector<ComponentShape> object(const Parameters& p, const std::string& parameter,
                                     const std::string& name, const ShapeContext& context) override;

 private:
  /** Bounds of the shapes that `counts` accepts: of a group in instance space, or of all in the scene. */
  template <class Counts> static Bounds3d boundsOf(const Group& g, const Counts& counts);
  template <class Counts> Bounds3d boundsOfAll(const Counts& counts) const;
  /** The previous frame's shape where nothing has changed, else a new one. `key`: its cache key; empty where
   * the shape depends on more than its directive. */
  std::shared_ptr<Shape> makeShape(const ShapeDescription& s, const ShapeContext& context, std::string& key);
  /** A new shape; null after an error, which has a location even where memory runs out. */
  std::unique_ptr<Shape> newShape(const ShapeDescription& s, const ShapeContext& context);
  /** Dicing for a shape of the group that may be displaced with edges as long as pixels, else null. */
  std::unique_ptr<Dicing> dicingOf(const ShapeDescription& s, const Group& group);
  /** Number of solids in a shape, and levels of CSG; 1 and 0 for a shape that is no CSG. */
  struct SolidCount {
    double solids = 0;
    int levels = 0;
  };
  /** Counts the solids in a shape. `level`: its depth in the CSG. */
  SolidCount solidsIn(const ShapeDescription& s, int level);
  /** False after an error: more than MAX_SOLIDS solids, or more than MAX_SOLID_LEVELS levels. */
  bool checkSolids();
  /** Keeps the shapes for the next frame. */
  void keepShapes();
  /** Makes a shape into `group`, unless it neither scatters, nor emits, nor bounds a medium. */
  void addShape(const ShapeDescription& s, const Mat4d& placement, Group& group,
                const InstanceDescription* partOf = nullptr);
  /** Fills a group; again with a better origin where the first guess was far off. */
  template <class Fill> void fillGroup(Group& group, const Fill& fill);
  /** Adds a moving shape as a group of its own, placed as at the start of the motion. */
  void addMoving(const ShapeDescription& s, const AnimatedTransform& instance, const SourceLocation& where,
                 const InstanceDescription* partOf);

  BuildContext& c;
  SceneMaterials& materials;
  SceneMedia& media;
  std::vector<std::shared_ptr<Shape>>& shapes;
  KeptParts* kept;
  std::vector<std::string> keys; ///< cache keys, parallel to `shapes`
  FilmSettings film;
  Vec3d guessedOrigin{0};
  std::unique_ptr<PixelWidths> pixels; ///< made at first use
  size_t objectsAsked = 0;             ///< number of calls of object()
  std::deque<Group> all;
  std::vector<Instance> placedInstances;
  std::vector<std::string> objectsUnderWay;   ///< objects whose shapes are being made into others
  std::map<std::string, SolidCount> solidsOf; ///< by name of the object
};

} // namespace recurse
