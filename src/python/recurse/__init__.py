"""Recurse: photon mapping and path tracing of scenes, with pictures and photons as NumPy arrays.

    import recurse
    scene = recurse.load("scenes/cornell-glass.pbrt")
    picture = scene.render(spp=16, classes={"caustic": "LS+DE"})
    print(picture.layers["caustic"].mean())

Parameters have the names of `recurse reference`. The functions of `shapes`, `materials`, `textures`, `lights`,
`area_lights`, `media`, `cameras`, `filters`, `films`, `samplers` and `integrators` list their parameters in help().
"""
from ._core import Error, SceneError
from .picture import Picture, classes, compare, develop, in_class, named_classes, read
from .plug_ins import (PlugIn, area_lights, cameras, films, filters, integrators, lights, materials, media,
                       samplers, shapes, textures)
from .progress import ProgressBar
from .scene import Paths, RecurseWarning, Scene, load, parse, paths, photons
from .transforms import look_at, rotate, scale, translate

__all__ = ["Error", "Picture", "PlugIn", "ProgressBar", "RecurseWarning", "Scene", "SceneError", "area_lights",
           "cameras", "classes", "compare", "develop", "films", "filters", "in_class", "integrators", "lights",
           "load", "look_at", "materials", "media", "named_classes", "parse", "paths", "photons", "read", "rotate", "samplers",
           "scale", "shapes", "textures", "translate"]

Error.__module__ = SceneError.__module__ = "recurse"
