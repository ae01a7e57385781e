"""Functions for all plug-ins, made from the program's own registries.

`shapes.sphere(radius=2)` describes a sphere. Only names are checked until a scene is loaded. In the names of parameters
`_` replaces `.`, and follows a name that is a keyword of Python, such as `from_`.
"""
from __future__ import annotations

import inspect
import keyword
from typing import Any, Iterator

import numpy as np

from . import _core

#: Names of the plug-in kinds, by directive of scene files.
KINDS = {"Shape": "shapes", "Shape (files)": "shapes", "Material": "materials", "Texture": "textures",
         "LightSource": "lights", "AreaLightSource": "area_lights", "MakeNamedMedium": "media", "Camera": "cameras",
         "PixelFilter": "filters", "Film": "films", "Sampler": "samplers", "Integrator": "integrators"}

_COORDINATES = {"point2": 2, "vector2": 2, "point3": 3, "vector3": 3, "normal": 3}


def python_name(parameter: str) -> str:
    """Name of a parameter or a plug-in in Python."""
    name = parameter.replace(".", "_")
    return name + "_" if keyword.iskeyword(name) else name


class PlugIn:
    """Plug-in with its parameters, to be added to a scene."""

    def __init__(self, info: dict, parameters: dict[str, Any]):
        self.info = info
        known = {python_name(spec["name"]): spec for spec in info["parameters"]}
        self.parameters = {}
        for name, value in parameters.items():
            if name not in known:
                raise TypeError(f"{info['name']} has no parameter {name!r}; it takes: {', '.join(known) or 'none'}")
            if value is not None:
                self.parameters[known[name]["name"]] = (known[name], value)

    @property
    def namespace(self) -> str:
        """Kind of the plug-in, see KINDS."""
        return KINDS[self.info["kind"]]

    @property
    def name(self) -> str:
        """Name in scene files."""
        return self.info["name"]

    def __repr__(self) -> str:
        values = ", ".join(f"{python_name(name)}={value!r}" for name, (_, value) in self.parameters.items())
        return f"{self.namespace}.{python_name(self.name)}({values})"


class Namespace:
    """Plug-ins of a kind, as functions that take their parameters."""

    def __init__(self, name: str):
        self._name = name
        self._infos = {python_name(info["name"]): info for info in _core.plug_ins() if KINDS[info["kind"]] == name}
        for function_name, info in self._infos.items():
            setattr(self, function_name, _maker(name, function_name, info))

    def __iter__(self) -> Iterator[str]:
        return iter(self._infos)

    def make(self, name: str | PlugIn, parameters: dict[str, Any]) -> PlugIn:
        """Plug-in of that name; a PlugIn is returned as it is. Raises TypeError or ValueError."""
        if isinstance(name, PlugIn):
            if name.namespace != self._name:
                raise TypeError(f"{name!r} is none of {self._name}")
            if parameters:
                raise TypeError(f"{name!r} has its parameters already")
            return name
        info = self._infos.get(python_name(name))
        if info is None:
            raise ValueError(f"there is no {name!r} among {self._name}: {', '.join(self._infos)}")
        return PlugIn(info, parameters)


def description(info: dict) -> str:
    """Summary and parameters of a plug-in, as text."""
    lines = [info["summary"]]
    for spec in info["parameters"]:
        if spec["ignored"]:
            continue
        notes = [text for text in (spec["range"], "a texture" if spec["textured"] else "",
                                   "required" if spec["required"] else "",
                                   f"default {spec['default']}" if spec["default"] else "") if text]
        lines.append(f"    {python_name(spec['name'])} ({spec['type']}{'; ' + ', '.join(notes) if notes else ''}): "
                     + spec["description"])
    return "\n".join(lines[:1] + [""] * (len(lines) > 1) + lines[1:])


def _maker(namespace: str, name: str, info: dict):
    def make(**parameters):
        return PlugIn(info, parameters)

    make.__name__, make.__qualname__, make.__doc__ = name, f"{namespace}.{name}", description(info)
    make.__signature__ = inspect.Signature(
        [inspect.Parameter(python_name(spec["name"]), inspect.Parameter.KEYWORD_ONLY, default=None)
         for spec in info["parameters"] if not spec["ignored"]])
    return make


def number_text(value: float) -> str:
    """Number with all its digits, as in scene files."""
    return repr(int(value)) if float(value).is_integer() and abs(value) < 1e15 else repr(float(value))


def numbers_text(values: Any) -> str:
    """Numbers of an array with all their digits, in brackets."""
    flat = np.asarray(values, float).ravel()
    return "[ " + " ".join(map(number_text, flat.tolist())) + " ]"


def quoted(text: str) -> str:
    """String in quotes, as in scene files."""
    return '"' + str(text).replace("\\", "\\\\").replace('"', '\\"') + '"'


def value_text(spec: dict, value: Any) -> tuple[str, str]:
    """Type and value of a parameter in a scene file, except for textures and other plug-ins."""
    kind = spec["type"]
    if kind == "string":
        texts = [value] if isinstance(value, str) or not hasattr(value, "__iter__") else list(value)
        return kind, "[ " + " ".join(map(quoted, texts)) + " ]"
    if kind == "bool":
        return kind, "true" if value else "false"
    if kind == "spectrum":
        if isinstance(value, str):
            return kind, quoted(value)
        array = np.asarray(value, float)
        is_colour = array.ndim > 0 and array.shape[-1] == 3 and (array.ndim > 1 or spec["count"] == 1)
        return ("rgb" if is_colour else "float"), numbers_text(array)
    if kind in _COORDINATES and np.size(value) % _COORDINATES[kind]:
        raise ValueError(f"{spec['name']}: {np.size(value)} numbers are no {kind}s")
    return kind, numbers_text(value)


shapes = Namespace("shapes")
materials = Namespace("materials")
textures = Namespace("textures")
lights = Namespace("lights")
area_lights = Namespace("area_lights")
media = Namespace("media")
cameras = Namespace("cameras")
filters = Namespace("filters")
films = Namespace("films")
samplers = Namespace("samplers")
integrators = Namespace("integrators")
