/** @file
 * All registries together. src/plugins/list.h is the one list of plug-ins.
 */
#pragma once

#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/camera/camera.h"
#include "recurse/model/film/toneMap.h"
#include "recurse/model/light/light.h"
#include "recurse/model/medium/medium.h"
#include "recurse/model/scene/sceneImport.h"
#include "recurse/model/shape/shape.h"
#include "recurse/model/texture/texture.h"
#include "recurse/scene/parameters/registry.h"

namespace recurse {

class Integrator; // transport/integrator.h

/** The Accelerator directive has no effect: Embree builds the tree. */
struct AcceleratorSettings {};

struct PlugIns {
  Registry<Shape, ShapeContext> shapes{"Shape"};
  Registry<SceneImport, ImportContext> imports{"Shape (files)"};
  Registry<Material, MaterialContext> materials{"Material"};
  Registry<Texture, TextureContext> textures{"Texture"};
  Registry<Light, LightContext> lights{"LightSource"};
  Registry<AreaLight, AreaLightContext> areaLights{"AreaLightSource"};
  Registry<Medium, MediumContext> media{"MakeNamedMedium"};
  Registry<PhaseFunction, NoContext> phaseFunctions{"phase"}; ///< of the media's parameter
  Registry<Camera, CameraContext> cameras{"Camera"};
  Registry<Filter, NoContext> filters{"PixelFilter"};
  Registry<FilmSettings, NoContext> films{"Film"};
  Registry<SamplerSettings, NoContext> samplers{"Sampler"};
  Registry<AcceleratorSettings, NoContext> accelerators{"Accelerator"};
  Registry<Integrator, NoContext> integrators{"Integrator"};
  Registry<ToneMap, NoContext> toneMaps{"ToneMap"}; ///< of the option --tonemap
};

/** Every plug-in of this build. */
const PlugIns& plugIns();

} // namespace recurse
