"""Scenes, read from files or built in code, and their rendering."""
from __future__ import annotations

import contextlib
import json
import os
import warnings as python_warnings
from typing import Any, Callable, Iterator, Mapping, NamedTuple, Sequence, Union

import numpy as np

from . import _core
from .picture import Picture, class_list
from .plug_ins import (PlugIn, area_lights, cameras, films, filters, integrators, lights, materials, media,
                       numbers_text, quoted, samplers, shapes, textures, value_text)
from .progress import ProgressBar

Transform = Any
Medium = Union[str, "tuple[str, str]"]


class RecurseWarning(UserWarning):
    """Warning that a render differs from the scene's description, or that its picture may look wrong."""


class Paths(NamedTuple):
    """Camera paths of a pixel.

    vertices: a record for each point where a path scatters. sample: index of the pixel's sample; previous: index of the
    previous vertex, -1 for the camera; event: event at the previous vertex, S, D or V, E for the camera; position: in the
    world; normal: unit, 0 in a medium; throughput: on arrival; pdf, pdf_reverse: densities of the direction to this
    vertex and of the opposite walk [1/sr], 0 for mirrors and smooth glass.
    contributions: a record for each contribution to the pixel. vertex: index of the last vertex from the camera, -1 if
    the camera sees the light; technique: "hit", "light sample", "connection", "merge" or "unknown"; path: letters from
    that vertex to the camera; weight: MIS weight; pdf, other_pdf: densities of the technique and its competitor [1/sr];
    radiance: with weight and throughput; class: name of the path class, "" for none.
    value: red, green and blue of the pixel, the mean over the samples."""
    vertices: np.ndarray
    contributions: np.ndarray
    value: np.ndarray


class Scene:
    """Scene. Scene() is empty, and is built by the functions set_... and add_...; load() and parse() read
    a scene."""

    def __init__(self, *, lenient: bool = False):
        self._name, self._directory, self._source = "scene in Python", os.getcwd(), None
        self._lenient = lenient
        self._settings: dict[str, str] = {}
        self._world: list[str] = []
        self._names: dict[tuple[int, str], str] = {}
        self._kept: list[PlugIn] = []
        self._core: _core.Scene | None = None

    # Building

    def text(self) -> str:
        """Text of the scene file; of a parsed scene, the text it was parsed from. Raises ValueError for a loaded file."""
        if self._source is not None:
            return self._source
        if self._directory is None:
            raise ValueError(f"{self._name} is a file")
        return "\n".join([*self._settings.values(), "WorldBegin", *self._world]) + "\n"

    def save(self, file: Union[str, os.PathLike]) -> None:
        """Writes text() to a file. Names of files in the text are not changed."""
        with open(file, "w", encoding="utf-8") as out:
            out.write(self.text())

    def _change(self) -> None:
        if self._directory is None or self._source is not None:
            raise ValueError(f"{self._name} was read; only scenes that begin as recurse.Scene() can be built on")
        self._core = None

    def _setting(self, directive: str, plug_in: PlugIn, before: Sequence[str] = ()) -> None:
        self._change()
        self._settings[directive] = "\n".join([*before, f"{directive} {self._use(plug_in)}"])

    def set_camera(self, name: str | PlugIn = "perspective", *, look_at: Sequence[Sequence[float]] | None = None,
                   transform: Transform = None, **parameters: Any) -> None:
        """Sets the camera, placed by `look_at` (eye, target and up), or by a matrix from camera space (x right, y up,
        z forward) to the world."""
        before = ["Identity"]
        if look_at is not None:
            before.append("LookAt " + numbers_text(look_at)[2:-2])
        if transform is not None:
            before.append("ConcatTransform " + numbers_text(np.linalg.inv(np.asarray(transform, float)).T))
        self._setting("Camera", cameras.make(name, parameters), before)

    def set_film(self, name: str | PlugIn = "rgb", **parameters: Any) -> None:
        """Sets the size, crop and exposure of the picture."""
        self._setting("Film", films.make(name, parameters))

    def set_integrator(self, name: str | PlugIn, **parameters: Any) -> None:
        """Sets the default integrator of render()."""
        self._setting("Integrator", integrators.make(name, parameters))

    def set_sampler(self, name: str | PlugIn = "sobol", **parameters: Any) -> None:
        """Sets the default samples per pixel and seed of render()."""
        self._setting("Sampler", samplers.make(name, parameters))

    def set_filter(self, name: str | PlugIn, **parameters: Any) -> None:
        """Sets the pixel filter of the film."""
        self._setting("PixelFilter", filters.make(name, parameters))

    def add_shape(self, name: str | PlugIn, *, material: PlugIn | str | None = None, light: PlugIn | None = None,
                  transform: Transform = None, medium: Medium | None = None, reverse_orientation: bool = False,
                  **parameters: Any) -> None:
        """Adds a shape of a material (from `materials`, or the name of one), which emits if it has a light (from
        `area_lights`). `medium`: names of the media inside and outside of it."""
        lines = self._placed(transform, medium)
        if isinstance(material, str):
            lines.append(f"NamedMaterial {quoted(material)}")
        elif material is not None:
            lines.append(f"NamedMaterial {quoted(self._named(materials.make(material, {}), 'Material'))}")
        if light is not None:
            lines.append(f"AreaLightSource {self._use(area_lights.make(light, {}))}")
        if reverse_orientation:
            lines.append("ReverseOrientation")
        lines.append(f"Shape {self._use(shapes.make(name, parameters))}")
        self._add(lines)

    def add_light(self, name: str | PlugIn, *, transform: Transform = None, medium: Medium | None = None,
                  **parameters: Any) -> None:
        """Adds a light that is not a surface."""
        self._add(self._placed(transform, medium) + [f"LightSource {self._use(lights.make(name, parameters))}"])

    def add_medium(self, medium_name: str, name: str | PlugIn, *, transform: Transform = None,
                   **parameters: Any) -> str:
        """Defines a medium under a name that shapes can refer to. Returns the name."""
        plug_in = media.make(name, parameters)
        self._add(self._placed(transform, None) + [self._definition("MakeNamedMedium", medium_name, plug_in)])
        return medium_name

    def add_material(self, material_name: str, name: str | PlugIn, **parameters: Any) -> str:
        """Defines a material under a name that shapes and materials can refer to. Returns the name."""
        self._change()
        self._world.append(self._definition("MakeNamedMaterial", material_name, materials.make(name, parameters)))
        return material_name

    @contextlib.contextmanager
    def object(self, name: str) -> Iterator[None]:
        """Context in which additions become an object, which is placed by add_instance()."""
        self._change()
        world, self._world = self._world, []
        try:
            yield
        finally:
            inside, self._world = self._world, world
        # Definitions apply to the whole scene, and are not part of an object.
        kinds = ("MakeNamed", "Texture")
        definitions = [text for text in inside if text.startswith(kinds)]
        shapes_inside = [text for text in inside if not text.startswith(kinds)]
        self._world += [*definitions, f"ObjectBegin {quoted(name)}", *shapes_inside, "ObjectEnd"]

    def add_instance(self, name: str, transform: Transform = None) -> None:
        """Places an instance of an object."""
        self._add(self._placed(transform, None) + [f"ObjectInstance {quoted(name)}"])

    def add_text(self, directives: str) -> None:
        """Adds directives of a scene file, as after WorldBegin."""
        self._add([directives])

    def _add(self, lines: list[str]) -> None:
        self._change()
        self._world.append("\n".join(["AttributeBegin", *lines, "AttributeEnd"]))

    @staticmethod
    def _placed(transform: Transform, medium: Medium | None) -> list[str]:
        lines = []
        if transform is not None:
            lines.append("ConcatTransform " + numbers_text(np.asarray(transform, float).reshape(4, 4).T))
        if medium is not None:
            both = [medium] if isinstance(medium, str) else medium
            lines.append("MediumInterface " + " ".join(map(quoted, both)))
        return lines

    def _definition(self, directive: str, name: str, plug_in: PlugIn) -> str:
        return f'{directive} {quoted(name)} "string type" {self._use(plug_in)}'

    def _named(self, plug_in: PlugIn, kind: str) -> str:
        """Name of a material, or of a texture of that kind. Defines it on first use."""
        key = (id(plug_in), kind)
        if key not in self._names:
            name = f"{plug_in.name} {len(self._names) + 1}"
            if kind == "Material":
                text = self._definition("MakeNamedMaterial", name, plug_in)
            else:
                text = f"Texture {quoted(name)} {quoted(kind)} {self._use(plug_in, kind)}"
            self._change()
            self._world.append(text)
            self._names[key] = name
            self._kept.append(plug_in)  # keeps its id() unique
        return self._names[key]

    def _use(self, plug_in: PlugIn, texture_kind: str | None = None) -> str:
        """Name and parameters of a plug-in, with textures and materials by name."""
        out = [quoted(plug_in.name)]
        for name, (spec, value) in plug_in.parameters.items():
            if isinstance(value, PlugIn) and value.namespace == "textures":
                kind = "float" if spec["type"] != "spectrum" else texture_kind or "spectrum"
                out.append(f'"texture {name}" {quoted(self._named(textures.make(value, {}), kind))}')
                continue
            if spec["type"] == "string" and not isinstance(value, str) and hasattr(value, "__iter__"):
                value = [self._named(v, "Material") if isinstance(v, PlugIn) else v for v in value]
            kind, text = value_text(spec, value)
            out.append(f'"{kind} {name}" {text}')
        return " ".join(out)

    # Rendering

    def _loaded(self) -> "_core.Scene":
        if self._core is None:
            text = None if self._directory is None else self.text()
            self._core = _core.load(self._name, text, self._directory or "", self._lenient)
            self._warn()
        return self._core

    def _warn(self) -> None:
        for text in self._core.take_warnings():
            python_warnings.warn(text, RecurseWarning, stacklevel=4)

    def check(self) -> str:
        """Report on the scene's contents, memory and settings, as text. Raises SceneError for an invalid scene."""
        return self._loaded().report()

    def render(self, integrator: str | PlugIn | None = None, *, spp: int | None = None,
               time_limit: float | None = None, error_target: float | None = None, threads: int | None = None,
               seed: int | None = None, resolution: tuple[int, int] | None = None,
               crop: Sequence[float] | None = None, camera: str | None = None, adaptive: bool = False,
               classes: Mapping[str, str] | Sequence[str] = (), features: Sequence[str] = (), error: bool = False,
               samples: bool = False, progress: Callable[[dict], Any] | bool | None = None,
               **parameters: Any) -> Picture:
        """Renders the scene; the scene's settings are the defaults. The picture is bit for bit the same as by `recurse
        render` with the same options.

        integrator: its name, or one of `integrators`; **parameters are its parameters.
        spp: samples per pixel. time_limit [s] and error_target alone take as many samples as necessary.
        resolution: width and height. crop: x0, x1, y0, y1 as fractions.
        camera: name of a camera of the scene; by default the first.
        classes: classes of light paths, such as {"caustic": "LS+DE"}, which become layers.
        features: additional layers, see `--layers` of `recurse render --help`. error, samples: whether to add this layer.
        progress: called about ten times a second with a dictionary, whose `seconds_left` is negative while unknown. If it
        returns False, the render ends and keeps its samples. True shows a bar.

        Ctrl-C raises KeyboardInterrupt as soon as the render has stopped.
        """
        given = {"spp": spp, "time-limit": time_limit, "error-target": error_target, "nthreads": threads, "seed": seed,
                 "resolution": resolution and "x".join(map(str, resolution)),
                 "cropwindow": crop and ",".join(map(repr, map(float, crop))), "camera": camera}
        options = _options(integrator, given, parameters)
        if adaptive:
            options.append("--adaptive")
        scene = self._loaded()
        shown = ProgressBar() if progress is True else progress or None
        try:
            image, statistics = scene.render(options, class_list(classes), error, samples, list(features), shown)
        finally:
            self._warn()
            if isinstance(shown, ProgressBar):
                shown.finish()
        return Picture(image, json.loads(statistics))

    def paths(self, pixel: tuple[int, int], *, samples: int = 16, integrator: str | PlugIn | None = None,
              seed: int | None = None, resolution: tuple[int, int] | None = None, camera: str | None = None,
              classes: Mapping[str, str] | Sequence[str] | None = None, **parameters: Any) -> Paths:
        """First `samples` camera paths of a pixel (x, y), the same as in render() with the same settings.

        classes: as in render(); by default the classes of `recurse stills`. `path` and `photonmap` record vertices;
        other integrators record contributions only, with the technique "unknown".
        """
        pairs = _core.default_classes(True) if classes is None else class_list(classes)
        given = {"spp": samples, "seed": seed, "resolution": resolution and "x".join(map(str, resolution)),
                 "camera": camera}
        scene = self._loaded()
        try:
            vertices, contributions, value = scene.paths(_options(integrator, given, parameters), pairs, tuple(pixel),
                                                         samples)
        finally:
            self._warn()
        return Paths(vertices, _named(contributions, {
            "class": [name for name, _ in pairs] + [""],  # of -1, the last
            "technique": [_core.technique_name(i) for i in range(5)]}), np.array(value, np.float32))

    def photons(self, count: int = 100000, *, seed: int = 0, max_depth: int = -1,
                classes: Mapping[str, str] | Sequence[str] | None = None) -> np.ndarray:
        """Photons of `count` light paths: a record for each surface on the path with a lobe other than a mirror or smooth
        glass, and for each scattering point in a medium.

        position: in the world. direction: unit, back along the path.
        normal: normal of the surface, on the side of `direction`; 0 in a medium.
        power: red, green and blue [W]; in a medium, the scattered power.
        path: letters from L up to that point, at most 17; event: letter of the point, D or V.
        class: name of the first of `classes` that contains this path continued straight to the camera; "" if none does.
        By default the classes of `recurse stills`.

        The sum of the power near a point of a surface, divided by the area that it covers, is the irradiance there; in a
        medium, divided by the volume, it is the fluence times the scattering coefficient.
        """
        pairs = _core.default_classes(True) if classes is None else class_list(classes)
        records = self._loaded().photons(count, seed, max_depth, [expression for _, expression in pairs])
        return _named(records, {"class": [name for name, _ in pairs] + [""]})  # of -1, the last


def _options(integrator: str | PlugIn | None, given: Mapping[str, Any], parameters: Mapping[str, Any]) -> list[str]:
    """Arguments of the command line."""
    if isinstance(integrator, PlugIn):
        parameters = {name: value for name, (_, value) in integrator.parameters.items()} | dict(parameters)
        integrator = integrator.name
    options = [f"--{name}={value}" for name, value in {"integrator": integrator, **given}.items() if value is not None]
    for name, value in parameters.items():
        text = str(value).lower() if isinstance(value, (bool, np.bool_)) else str(value)
        options.append(f"--set={name}={text}")
    return options


def _named(records: np.ndarray, columns: Mapping[str, Sequence[str]]) -> np.ndarray:
    """Records with the indices of some columns replaced by names."""
    names = {column: np.array(texts) for column, texts in columns.items()}
    types = [(column, names[column].dtype if column in names else records.dtype.fields[column][0])
             for column in records.dtype.names]
    out = np.empty(len(records), types)
    for column in records.dtype.names:
        out[column] = names[column][records[column]] if column in names else records[column]
    return out


def load(file: Union[str, os.PathLike], *, lenient: bool = False) -> Scene:
    """Reads a scene file, or a model. Raises SceneError for an invalid one. `lenient`: unknown parameters are only
    warnings."""
    scene = Scene(lenient=lenient)
    scene._name, scene._directory = os.fspath(file), None
    scene._loaded()
    return scene


def parse(text: str, *, name: str = "scene in Python", directory: Union[str, os.PathLike] = ".",
          lenient: bool = False) -> Scene:
    """Reads a scene from text. `name`: its name in messages; `directory`: folder of the files that it names."""
    scene = Scene(lenient=lenient)
    scene._name, scene._directory, scene._source = name, os.fspath(directory), text
    scene._loaded()
    return scene


def paths(scene: Scene, pixel: tuple[int, int], **options: Any) -> Paths:
    """See Scene.paths()."""
    return scene.paths(pixel, **options)


def photons(scene: Scene, count: int = 100000, **options: Any) -> np.ndarray:
    """See Scene.photons()."""
    return scene.photons(count, **options)
