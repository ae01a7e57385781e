"""Scenes: read from files, or built in code, and rendered."""
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
    """A difference between the scene and the render, or a visible problem of the picture."""


class Paths(NamedTuple):
    """Camera paths of a pixel.

    vertices: a record for each point where a path scatters. sample: of the pixel; previous: index of the vertex before,
    -1 for the camera; event: at that one, S, D or V, E for the camera; position: in the world; normal: unit, 0 in a
    medium; throughput: that arrives; pdf, pdf_reverse: of the direction that led here and of the opposite walk [1/sr],
    0 for mirrors and smooth glass.
    contributions: a record for each that reached the pixel. vertex: index of the last vertex from the camera, -1 where
    the camera sees the light; technique: "hit", "light sample", "connection", "merge" or "unknown"; path: the letters
    from that vertex to the camera; weight: of multiple importance sampling; pdf, other_pdf: of the technique and of its
    rival [1/sr]; radiance: with weight and throughput; class: the name of its class, "" for none.
    value: of the pixel, red, green and blue, the mean over the samples."""
    vertices: np.ndarray
    contributions: np.ndarray
    value: np.ndarray


class Scene:
    """A scene. Scene() is empty, and is built by the functions set_... and add_...; load() and parse() return one
    that is read."""

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
        """The scene as a scene file; of one that was read, what it was read from."""
        if self._source is not None:
            return self._source
        if self._directory is None:
            raise ValueError(f"{self._name} is a file")
        return "\n".join([*self._settings.values(), "WorldBegin", *self._world]) + "\n"

    def save(self, file: Union[str, os.PathLike]) -> None:
        """Writes text() to a file. Names of files in it are as they were given."""
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
        """The camera, seen from `look_at`: eye, target and up, or placed by a matrix from camera space, x right, y up
        and z forward, to the world."""
        before = ["Identity"]
        if look_at is not None:
            before.append("LookAt " + numbers_text(look_at)[2:-2])
        if transform is not None:
            before.append("ConcatTransform " + numbers_text(np.linalg.inv(np.asarray(transform, float)).T))
        self._setting("Camera", cameras.make(name, parameters), before)

    def set_film(self, name: str | PlugIn = "rgb", **parameters: Any) -> None:
        """Size, crop and exposure of the picture."""
        self._setting("Film", films.make(name, parameters))

    def set_integrator(self, name: str | PlugIn, **parameters: Any) -> None:
        """The algorithm that computes light, unless render() names another."""
        self._setting("Integrator", integrators.make(name, parameters))

    def set_sampler(self, name: str | PlugIn = "zsobol", **parameters: Any) -> None:
        """Number of samples per pixel, and the seed, unless render() has others."""
        self._setting("Sampler", samplers.make(name, parameters))

    def set_filter(self, name: str | PlugIn, **parameters: Any) -> None:
        """The filter of the film's pixels."""
        self._setting("PixelFilter", filters.make(name, parameters))

    def add_shape(self, name: str | PlugIn, *, material: PlugIn | str | None = None, light: PlugIn | None = None,
                  transform: Transform = None, medium: Medium | None = None, reverse_orientation: bool = False,
                  **parameters: Any) -> None:
        """A shape of a material (of `materials`, or the name of one), which emits where it has a light (of
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
        """A light without a surface."""
        self._add(self._placed(transform, medium) + [f"LightSource {self._use(lights.make(name, parameters))}"])

    def add_medium(self, medium_name: str, name: str | PlugIn, *, transform: Transform = None,
                   **parameters: Any) -> str:
        """A medium by which shapes can name it."""
        plug_in = media.make(name, parameters)
        self._add(self._placed(transform, None) + [self._definition("MakeNamedMedium", medium_name, plug_in)])
        return medium_name

    def add_material(self, material_name: str, name: str | PlugIn, **parameters: Any) -> str:
        """A material by which shapes and materials can name it."""
        self._change()
        self._world.append(self._definition("MakeNamedMaterial", material_name, materials.make(name, parameters)))
        return material_name

    @contextlib.contextmanager
    def object(self, name: str) -> Iterator[None]:
        """What is added inside of a `with` becomes an object, which appears where add_instance() places it."""
        self._change()
        world, self._world = self._world, []
        try:
            yield
        finally:
            inside, self._world = self._world, world
        # Definitions hold for the whole scene, and are no part of an object.
        kinds = ("MakeNamed", "Texture")
        definitions = [text for text in inside if text.startswith(kinds)]
        shapes_inside = [text for text in inside if not text.startswith(kinds)]
        self._world += [*definitions, f"ObjectBegin {quoted(name)}", *shapes_inside, "ObjectEnd"]

    def add_instance(self, name: str, transform: Transform = None) -> None:
        """Places an object."""
        self._add(self._placed(transform, None) + [f"ObjectInstance {quoted(name)}"])

    def add_text(self, directives: str) -> None:
        """Directives as they stand in a scene file after WorldBegin."""
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
        """The name of a material or, of that kind, a texture; defines it where it has none yet."""
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
            self._kept.append(plug_in)  # so that nothing else gets its id()
        return self._names[key]

    def _use(self, plug_in: PlugIn, texture_kind: str | None = None) -> str:
        """Name and parameters of a plug-in, textures and materials by their names."""
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
        """A report of the contents and the memory of the scene. Raises SceneError if it has errors."""
        return self._loaded().report()

    def render(self, integrator: str | PlugIn | None = None, *, spp: int | None = None,
               time_limit: float | None = None, error_target: float | None = None, threads: int | None = None,
               seed: int | None = None, resolution: tuple[int, int] | None = None,
               crop: Sequence[float] | None = None, adaptive: bool = False,
               classes: Mapping[str, str] | Sequence[str] = (), features: Sequence[str] = (), error: bool = False,
               samples: bool = False, progress: Callable[[dict], Any] | bool | None = None,
               **parameters: Any) -> Picture:
        """Renders, with the scene's settings where nothing else is said. The picture is bit for bit that of `recurse
        render` with the same options.

        integrator: its name, or one of `integrators`; **parameters are its own.
        spp: samples of each pixel. time_limit [s] and error_target alone mean as many as it takes.
        resolution: width and height. crop: x0, x1, y0, y1 as fractions.
        classes: classes of light paths, such as {"caustic": "LS+DE"}, which become layers.
        features: more layers, see `--layers` of `recurse render --help`. error, samples: a layer each.
        progress: called about ten times a second with a dictionary; what returns False ends the render, which keeps
        what there is; `seconds_left` is negative while it is not known. True shows a bar.

        Ctrl-C raises KeyboardInterrupt as soon as the render has stopped.
        """
        given = {"spp": spp, "time-limit": time_limit, "error-target": error_target, "nthreads": threads, "seed": seed,
                 "resolution": resolution and "x".join(map(str, resolution)),
                 "cropwindow": crop and ",".join(map(repr, map(float, crop)))}
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
              seed: int | None = None, resolution: tuple[int, int] | None = None,
              classes: Mapping[str, str] | Sequence[str] | None = None, **parameters: Any) -> Paths:
        """The first `samples` camera paths of a pixel (x, y), as render() with the same settings walks them.

        classes: as in render(); without it those of `recurse stills`. `path` and `photonmap` record vertices; other
        integrators record contributions only, with the technique "unknown".
        """
        pairs = _core.default_classes(True) if classes is None else class_list(classes)
        given = {"spp": samples, "seed": seed, "resolution": resolution and "x".join(map(str, resolution))}
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
        """Photons of `count` light paths, a record for each surface on their way that scatters other than a mirror or
        smooth glass, and for each point in a medium where they are scattered.

        position: in the world. direction: unit, towards where it came from.
        normal: of a surface, on that side; 0 in a medium.
        power: red, green and blue [W]; in a medium, the part that is scattered.
        path: the letters from L up to that point, at most 17; event: the letter of the point, D or V.
        class: the name of the first of `classes` that has the path which ends here and is seen from here; "" where none
        has. Without `classes` they are those of `recurse stills`.

        The sum of the power near a point of a surface, over the area that it is spread on, is the irradiance there; in
        a medium, over the volume, it is the fluence times the scattering coefficient.
        """
        pairs = _core.default_classes(True) if classes is None else class_list(classes)
        records = self._loaded().photons(count, seed, max_depth, [expression for _, expression in pairs])
        return _named(records, {"class": [name for name, _ in pairs] + [""]})  # of -1, the last


def _options(integrator: str | PlugIn | None, given: Mapping[str, Any], parameters: Mapping[str, Any]) -> list[str]:
    """Options of the command line."""
    if isinstance(integrator, PlugIn):
        parameters = {name: value for name, (_, value) in integrator.parameters.items()} | dict(parameters)
        integrator = integrator.name
    options = [f"--{name}={value}" for name, value in {"integrator": integrator, **given}.items() if value is not None]
    for name, value in parameters.items():
        text = str(value).lower() if isinstance(value, (bool, np.bool_)) else str(value)
        options.append(f"--set={name}={text}")
    return options


def _named(records: np.ndarray, columns: Mapping[str, Sequence[str]]) -> np.ndarray:
    """The same records with names in the place of the indices of some columns."""
    names = {column: np.array(texts) for column, texts in columns.items()}
    types = [(column, names[column].dtype if column in names else records.dtype.fields[column][0])
             for column in records.dtype.names]
    out = np.empty(len(records), types)
    for column in records.dtype.names:
        out[column] = names[column][records[column]] if column in names else records[column]
    return out


def load(file: Union[str, os.PathLike], *, lenient: bool = False) -> Scene:
    """Reads a scene file, or a model. Raises SceneError if it has errors; `lenient` makes unknown parameters
    warnings."""
    scene = Scene(lenient=lenient)
    scene._name, scene._directory = os.fspath(file), None
    scene._loaded()
    return scene


def parse(text: str, *, name: str = "scene in Python", directory: Union[str, os.PathLike] = ".",
          lenient: bool = False) -> Scene:
    """The same from text; `name` is its name in messages, and files that it names are in `directory`."""
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
