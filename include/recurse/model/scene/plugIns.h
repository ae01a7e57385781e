/** @file
 * All registries of plug-ins. The list of the library's plug-ins is src/plugins/list.h.
 */
#pragma once

#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/camera/camera.h"
#include "recurse/model/camera/pixelSampler.h"
#include "recurse/model/film/toneMap.h"
#include "recurse/model/light/light.h"
#include "recurse/model/medium/medium.h"
#include "recurse/model/scene/sceneImport.h"
#include "recurse/model/shape/shape.h"
#include "recurse/model/texture/texture.h"
#include "recurse/scene/parameters/registry.h"

namespace recurse {

class Integrator; // transport/integrator/integrator.h

/** Settings of the Accelerator directive, which has no effect: Embree builds the tree. */
struct AcceleratorSettings {};

/** Registries by kind; a registry's text is the directive that names its plug-ins, for messages. The file of
 * a plug-in defines `void registerNAME(PlugIns&)`, and the list names NAME. The makers of a scene are called
 * by one thread. Afterwards several threads call the const functions of a plug-in at the same time. */
struct PlugIns {
  Registry<Shape, ShapeContext> shapes{"Shape"};
  Registry<SceneImport, ImportContext> imports{"Shape (files)"};
  Registry<Material, MaterialContext> materials{"Material"};
  Registry<Texture, TextureContext> textures{"Texture"};
  Registry<Light, LightContext> lights{"LightSource"};
  Registry<AreaLight, AreaLightContext> areaLights{"AreaLightSource"};
  Registry<Medium, MediumContext> media{"MakeNamedMedium"};
  Registry<PhaseFunction, NoContext> phaseFunctions{"phase"}; ///< for a parameter of media
  Registry<Camera, CameraContext> cameras{"Camera"};
  Registry<Filter, NoContext> filters{"PixelFilter"};
  Registry<FilmSettings, NoContext> films{"Film"};
  Registry<PixelSampler, NoContext> samplers{"Sampler"};
  Registry<AcceleratorSettings, NoContext> accelerators{"Accelerator"};
  Registry<Integrator, NoContext> integrators{"Integrator"};
  Registry<ToneMap, NoContext> toneMaps{"ToneMap"}; ///< for the option --tonemap
};

/** All plug-ins of this build, registered at the first call. */
const PlugIns& plugIns();

} // namespace recurse
