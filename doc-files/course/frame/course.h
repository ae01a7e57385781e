/** @file
 * What both exercises stand on: surfaces, points of lamps, visibility, and the integrator that calls the
 * tracers. All of it is given.
 */
#pragma once

#include <memory>
#include <optional>

#include <recurse/model/bsdf/scatteringPoint.h>
#include <recurse/model/scene/scene.h>
#include <recurse/transport/integrator/integrator.h>

namespace course {

using namespace recurse;

/** Surface where a ray hit it, seen from the origin of the ray. */
struct Surface {
  enum class Kind {
    BLACK,   ///< absorbs all light
    DIFFUSE, ///< Lambertian
    MIRROR,  ///< smooth conductor
    GLASS    ///< smooth dielectric
  };
  Kind kind = Kind::BLACK;
  SurfacePoint point;
  Frame frame;         ///< its z axis is the normal on the viewer's side
  Vec3f wo;            ///< unit direction to the viewer, in the frame: wo.z > 0
  Rgb colour{0};       ///< DIFFUSE: albedo; MIRROR: reflectance
  float eta = 1;       ///< GLASS: refractive index behind the surface over the index on the viewer's side
  DeltaScatters steps; ///< MIRROR, GLASS: directions of reflection and refraction, for specularStep()

  bool isLamp = false;
  Rgb lampRadiance{0};    ///< radiance on the front of the lamp
  float lampCosine = 0;   ///< cosine between the lamp's normal and the direction to the viewer; < 0: its back
  float lampPdfArea = 0;  ///< density of this point in sampleLamp() [1/length²]
  float distance2 = 0;    ///< squared distance to the viewer [length²]
  uint32_t lampIndex = 0; ///< in the scene's list of lights
};

/** Point on a lamp, by the density pdfArea. */
struct LampPoint {
  SurfacePoint point;
  Rgb radiance{0};   ///< on the front
  float pdfArea = 0; ///< [1/length²], with the probability of the lamp
};

/** Lamp point and a surface point that see each other. */
struct Connection {
  Vec3f direction;     ///< unit, from the surface to the lamp
  float cosSurface;    ///< cosine between the surface's normal and the direction
  float cosLamp;       ///< cosine between the lamp's normal and the opposite direction
  float distance2 = 0; ///< squared distance [length²]
};

/** Surface that a ray hits; empty where it hits none. */
std::optional<Surface> traceRay(const Scene& scene, const Ray& ray, TransportCounts& counts);

/** Point on a lamp: the lamp by its power, the point uniformly over its area. Empty in a scene without. */
std::optional<LampPoint> sampleLamp(const Scene& scene, Sampler& sampler);

/** Connection of a point with the front of a lamp; empty where they do not face or do not see each other. */
std::optional<Connection> connect(const Scene& scene, const Surface& surface, const LampPoint& lamp,
                                  TransportCounts& counts);

/** Density of a lamp point in sampleLamp() by solid angle, as the surface sees it [1/sr]. */
float pdfTowardsLamp(const LampPoint& lamp, const Connection& connection);

/** Ray that leaves a surface in a direction of its frame. */
Ray rayFrom(const Surface& surface, const Vec3f& local);

/** Direction after a mirror or glass, in the frame of the surface; at glass by the Fresnel reflectance. */
Vec3f specularStep(const Surface& surface, Sampler& sampler);

/** Result of tracing a ray through mirrors and glass. */
struct Seen {
  std::optional<Surface> surface; ///< the first diffuse surface; empty: none
  Rgb weight{1};                  ///< reflectance of the mirrors on the way
  Rgb emitted{0};                 ///< radiance of the lamps on the way, with their weights: LS*E
};
Seen seeThrough(const Scene& scene, Ray ray, Sampler& sampler, TransportCounts& counts);

/** Integrator of Recurse that calls a tracer of the course. It has one class of paths, "all". */
class Tracer : public Integrator {
 public:
  /** Radiance that arrives along a camera ray. */
  virtual Rgb radiance(const Scene& scene, const Ray& ray, Sampler& sampler,
                       TransportCounts& counts) const = 0;

  /** Throws Error where the scene has more than diffuse surfaces, smooth mirrors, glass, and lamps that shine
   * from the front of a surface. */
  TransportCounts prepare(const Scene& scene, const PathClasses& classes) override;
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler, PathRadiance& out) const override;
};

/** Maximum number of scattering events of a path. */
constexpr int MAX_DEPTH = 64;

/** Exercise 1, in pathTracer.cpp. */
std::unique_ptr<Tracer> makePathTracer();
/** Exercise 2, in photonMapper.cpp. */
std::unique_ptr<Tracer> makePhotonMapper(int photons, int nearest);

} // namespace course
