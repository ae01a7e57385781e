/** @file
 * Loads a scene with the installed library and looks along one ray.
 */
#include <cmath>
#include <cstdio>

#include <recurse/model/scene/scene.h>
#include <recurse/pathclasses/pathExpression.h>
#include <recurse/scene/directives/loader.h>

using namespace recurse;

int main() {
  Diagnostics diagnostics;
  const SceneDescription description = parseScene(R"(
    Camera "perspective"
    WorldBegin
    LightSource "point" "rgb I" [1 1 1]
    Material "diffuse" "rgb reflectance" [.2 .5 .8]
    Translate 0 0 5
    Shape "sphere" "float radius" 2
  )",
                                                  "inline", ".", diagnostics);
  const std::unique_ptr<Scene> scene = buildScene(description, {}, diagnostics);
  std::fputs(diagnostics.format().c_str(), stderr);
  if (!scene) return 1;

  Ray ray;
  ray.origin = Vec3f(Vec3d(0, 0, 0) - scene->origin());
  ray.direction = Vec3f(0, 0, 1);
  Hit hit;
  if (!scene->intersect(ray, hit)) return 1;
  std::printf("%zu integrators; the sphere is %g away\n", plugIns().integrators.entries().size(),
              double(hit.t));
  return std::abs(hit.t - 3) < 1e-4f && PathAutomaton::compile("LSDE").accepts("LSDE") ? 0 : 1;
}
