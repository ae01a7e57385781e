"""Colours and numbers of shader nodes: constants, image files, and all other nodes baked to an image over the texture
coordinates. A node that cannot be baked is replaced by its average, with a warning."""
import os

import bpy
import numpy as np

from . import noise
from .text import number, numbers, quoted

BAKED_SIZE = 512  # resolution of baked nodes without an image [pixels]
READABLE = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".tga", ".exr", ".hdr", ".bmp")


def linear_from_srgb(x):
    """Linear values of sRGB values (IEC 61966-2-1)."""
    return np.where(x <= 0.04045, x / 12.92, ((np.maximum(x, 0) + 0.055) / 1.055) ** 2.4)


def image_pixels(image):
    """Linear pixels of a Blender image: (height, width, 4), rows from the bottom."""
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)
    if image.channels < 4:
        pixels = np.concatenate([pixels[:, :, [0, 0, 0] if image.channels < 3 else [0, 1, 2]],
                                 np.ones((height, width, 1), np.float32)], axis=2)
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        pixels[:, :, :3] = linear_from_srgb(pixels[:, :, :3])
    return pixels


class CannotBake(Exception):
    """Raised for a node that has no value over texture coordinates."""


def _luminance(colour):
    return colour[..., :3] @ np.array([0.2126, 0.7152, 0.0722])


class Evaluation:
    """Values of nodes at points of the texture coordinates."""

    def __init__(self, u, v):
        self.coordinates = np.stack([u, v, np.zeros_like(u)], axis=-1)
        self.pixels = {}

    def colour(self, socket):
        """Colours of a socket, (…, 4)."""
        value = self._value(socket)
        if np.ndim(value) == 0 or np.shape(value)[-1:] not in ((3,), (4,)) or np.shape(value) == self.coordinates.shape[:-1]:
            value = np.asarray(value)[..., None] * np.ones(4)
        if value.shape[-1] == 3:
            value = np.concatenate([value, np.ones((*value.shape[:-1], 1))], axis=-1)
        return np.broadcast_to(value, (*self.coordinates.shape[:-1], 4))

    def number(self, socket):
        """Numbers of a socket, (…)."""
        value = np.asarray(self._value(socket))
        if value.ndim and value.shape[-1] in (3, 4) and value.shape != self.coordinates.shape[:-1]:
            value = _luminance(value)
        return np.broadcast_to(value, self.coordinates.shape[:-1])

    def _value(self, socket):
        source = socket.source
        if not source:
            value = socket.default_value
            return np.array(value[:], float) if hasattr(value, "__len__") else float(value)
        node, output = source
        if node.type == "VALUE":
            return float(output.default_value)
        make = getattr(self, "_" + node.type.lower(), None)
        if not make:
            raise CannotBake(f"the node '{node.name}' ({node.bl_label})")
        return make(node, output)

    def _vector(self, node, is_uv_by_default):
        socket = node.inputs.get("Vector")
        if socket is not None and socket.is_linked:
            value = np.asarray(self._value(socket))
            if value.shape[-1:] not in ((3,), (4,)):
                value = value[..., None] * np.ones(3)
            return np.broadcast_to(value[..., :3], self.coordinates.shape)
        if not is_uv_by_default:
            raise CannotBake(f"the generated coordinates of '{node.name}' ({node.bl_label})")
        return self.coordinates

    def _rgb(self, _, output):
        return np.array(output.default_value[:], float)

    def _tex_coord(self, node, output):
        if output.name != "UV":
            raise CannotBake(f"the {output.name.lower()} coordinates of '{node.name}' ({node.bl_label})")
        return self.coordinates

    def _uvmap(self, *_):
        return self.coordinates

    def _mapping(self, node, _):
        if node.vector_type not in ("POINT", "TEXTURE"):
            raise CannotBake(f"the mapping '{node.name}'")
        vector = self._vector(node, True)
        place, turn, size = (self._even_vector(node.inputs[name]) for name in ("Location", "Rotation", "Scale"))
        from mathutils import Euler
        rotation = np.array(Euler(turn, "XYZ").to_matrix())
        if node.vector_type == "TEXTURE":
            return ((vector - place) @ rotation) / np.where(size != 0, size, 1)
        return (vector * size) @ rotation.T + place

    def _even_vector(self, socket):
        """Value of a vector socket, which must be constant."""
        value = np.asarray(self._value(socket), float)
        if value.ndim > 1:
            raise CannotBake(f"the texture of {socket.description}")
        return value[:3] if value.ndim else np.full(3, value)

    def _tex_image(self, node, output):
        if not node.image or not node.image.size[0]:
            raise CannotBake(f"the picture of '{node.name}', which is missing")
        if node.projection != "FLAT":
            raise CannotBake(f"the projection of '{node.name}'")
        if node.image.name not in self.pixels:
            self.pixels[node.image.name] = image_pixels(node.image)
        pixels = self.pixels[node.image.name]
        height, width = pixels.shape[:2]
        vector = self._vector(node, True)
        column, row = (np.floor(vector[..., i] * size).astype(int) for i, size in ((0, width), (1, height)))
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        if node.extension == "REPEAT":
            column, row = column % width, row % height
        colour = pixels[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
        if node.extension == "CLIP":
            colour = colour * inside[..., None]
        return colour[..., 3] if output.name == "Alpha" else colour

    def _tex_checker(self, node, output):
        place = (self._vector(node, False) + 1e-6) * 0.999999 * self.number(node.inputs["Scale"])[..., None]
        is_first = np.abs(np.floor(place)).astype(int).sum(axis=-1) % 2 == 0
        if output.name == "Fac":
            return is_first.astype(float)
        return np.where(is_first[..., None], self.colour(node.inputs["Color1"]), self.colour(node.inputs["Color2"]))

    def _tex_noise(self, node, output):
        name = f"'{node.name}' ({node.bl_label})"
        scale, detail, roughness, distortion = (self.number(node.inputs[key])
                                                for key in ("Scale", "Detail", "Roughness", "Distortion"))
        if (node.noise_dimensions != "3D" or getattr(node, "noise_type", "FBM") != "FBM" or distortion.any()
                or getattr(node, "normalize", True) is not True or np.ptp(detail) > 0 or np.ptp(roughness) > 0):
            raise CannotBake(f"the kind of {name}")
        points = self._vector(node, False) * scale[..., None]
        offsets = (0, noise.offset(3), noise.offset(4)) if output.name == "Color" else (0,)
        values = [noise.fractal(points + offset, detail.flat[0], roughness.flat[0]) for offset in offsets]
        return np.stack(values, axis=-1) if len(values) > 1 else values[0]

    def _valtorgb(self, node, output):
        position = self.number(node.inputs["Fac"])
        table = np.array([node.color_ramp.evaluate(i / 1023)[:] for i in range(1024)])
        colour = table[np.clip(np.rint(position * 1023).astype(int), 0, 1023)]
        return colour[..., 3] if output.name == "Alpha" else colour

    def _blend(self, node, factor, a, b):
        if node.blend_type not in BLENDS:
            raise CannotBake(f"the way of '{node.name}' to mix, {node.blend_type.lower()}")
        factor = factor[..., None]
        return a * (1 - factor) + BLENDS[node.blend_type](a, b) * factor

    def _mix_rgb(self, node, _):
        return self._blend(node, np.clip(self.number(node.inputs["Fac"]), 0, 1), self.colour(node.inputs["Color1"]),
                           self.colour(node.inputs["Color2"]))

    def _mix(self, node, _):
        inputs = [s for s in node.inputs if s.enabled]
        factor = np.clip(self.number(inputs[0]), 0, 1)
        if node.data_type == "RGBA":
            return self._blend(node, factor, self.colour(inputs[1]), self.colour(inputs[2]))
        if node.data_type != "FLOAT":
            raise CannotBake(f"the vectors of '{node.name}' ({node.bl_label})")
        return self.number(inputs[1]) * (1 - factor) + self.number(inputs[2]) * factor

    def _invert(self, node, _):
        colour, factor = self.colour(node.inputs["Color"]), self.number(node.inputs["Fac"])[..., None]
        return colour * (1 - factor) + (1 - colour) * factor

    def _gamma(self, node, _):
        return np.maximum(self.colour(node.inputs["Color"]), 0) ** self.number(node.inputs["Gamma"])[..., None]

    def _brightcontrast(self, node, _):
        bright, contrast = self.number(node.inputs["Bright"])[..., None], self.number(node.inputs["Contrast"])[..., None]
        return np.maximum((1 + contrast) * self.colour(node.inputs["Color"]) + bright - contrast / 2, 0)

    def _rgbtobw(self, node, _):
        return _luminance(self.colour(node.inputs["Color"]))

    def _math(self, node, _):
        if node.operation not in MATH:
            raise CannotBake(f"the function of '{node.name}', {node.operation.lower()}")
        with np.errstate(all="ignore"):
            value = MATH[node.operation](self.number(node.inputs[0]), self.number(node.inputs[1]))
        value = np.nan_to_num(value, posinf=0, neginf=0)
        return np.clip(value, 0, 1) if node.use_clamp else value


BLENDS = {"MIX": lambda a, b: b, "ADD": lambda a, b: a + b, "MULTIPLY": lambda a, b: a * b,
          "SUBTRACT": lambda a, b: a - b, "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b),
          "DARKEN": np.minimum, "LIGHTEN": np.maximum, "DIFFERENCE": lambda a, b: np.abs(a - b)}
MATH = {"ADD": np.add, "SUBTRACT": np.subtract, "MULTIPLY": np.multiply, "DIVIDE": np.divide, "POWER": np.power,
        "MINIMUM": np.minimum, "MAXIMUM": np.maximum, "SQRT": lambda a, _: np.sqrt(a),
        "ABSOLUTE": lambda a, _: np.abs(a), "GREATER_THAN": lambda a, b: (a > b).astype(float),
        "LESS_THAN": lambda a, b: (a < b).astype(float), "SINE": lambda a, _: np.sin(a),
        "COSINE": lambda a, _: np.cos(a), "FRACT": lambda a, _: a - np.floor(a), "FLOOR": lambda a, _: np.floor(a)}


def is_even(value, is_colour):
    """Whether baked colours or numbers are constant."""
    return np.ptp(value.reshape(-1, 3 if is_colour else 1), axis=0).max() < 1e-6


def mean(value, is_colour):
    """Mean of baked colours or numbers."""
    return value.reshape(-1, 3).mean(axis=0) if is_colour else float(value.mean())


def _images(socket, found):
    source = socket.source
    if source:
        if source[0].type == "TEX_IMAGE" and source[0].image:
            found.append(source[0].image)
        for other in source[0].inputs:
            _images(other, found)
    return found


class Textures:
    """Textures of a scene file."""

    def __init__(self, folder, warnings):
        self.folder, self.warnings = folder, warnings
        self.lines = []
        self._known = {}

    def _baked(self, socket, is_colour, owner):
        """Value over the texture coordinates, rows from the bottom; None if the socket cannot be baked."""
        images = _images(socket, [])
        sizes = [image.size[:] for image in images if image.size[0]]
        width, height = (max(size[i] for size in sizes) for i in (0, 1)) if sizes else (BAKED_SIZE, BAKED_SIZE)
        u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
        try:
            evaluation = Evaluation(u, v)
            value = evaluation.colour(socket)[..., :3] if is_colour else evaluation.number(socket)
        except CannotBake as reason:
            self.warnings.add(f"{owner}: {reason} is not supported; its average colour is used")
            return None
        return np.asarray(value)

    def average(self, socket, is_colour=True, owner="", is_named=True):
        """Constant for the socket. If it is the average of different values, a warning reports that."""
        if not socket.source:
            return self.constant(socket, is_colour)
        value = self._baked(socket, is_colour, owner)
        if value is None:
            return self._guess(socket, is_colour)
        if is_named and not is_even(value, is_colour):
            self.warnings.add(f"{owner}: {socket.description} cannot have a texture; its average is used")
        return mean(value, is_colour)

    @staticmethod
    def _guess(socket, is_colour):
        """Constant for a socket that cannot be baked."""
        node, _ = socket.source
        colours = [np.array(s.default_value[:3]) for s in node.inputs if s.type == "RGBA" and not s.is_linked]
        if not colours and not node.type.startswith("TEX_"):
            return Textures.constant(socket, is_colour)
        colour = np.mean(colours, axis=0) if colours else np.full(3, 0.5)
        return colour if is_colour else float(_luminance(colour))

    @staticmethod
    def constant(socket, is_colour=True):
        """Value of a socket without a link."""
        value = np.asarray(socket.default_value, float)
        if is_colour:
            return value[:3] if value.ndim else np.full(3, value)
        return float(_luminance(value) if value.ndim else value)

    def _plain_picture(self, socket):
        """Parameters of an imagemap that reads the image's own file; None if other nodes or settings change it."""
        node, output = socket.source
        if node.type != "TEX_IMAGE" or output.name != "Color" or not node.image or node.projection != "FLAT":
            return None
        image = node.image
        file = bpy.path.abspath(image.filepath, library=image.library)
        space = image.colorspace_settings.name
        if (image.source != "FILE" or image.packed_file or image.is_dirty or not os.path.isfile(file)
                or not file.lower().endswith(READABLE)
                or (not image.is_float and space not in ("sRGB", "Non-Color", "Raw", "Linear"))):
            return None
        text = f'"string filename" {quoted(file)}'
        if not image.is_float:
            text += f' "string encoding" "{"sRGB" if space == "sRGB" else "linear"}"'
        if node.extension != "REPEAT":
            text += f' "string wrap" "{"clamp" if node.extension == "EXTEND" else "black"}"'
        vector = node.inputs["Vector"].source
        if vector and vector[0].type == "MAPPING" and vector[0].vector_type == "POINT":
            place, turn, size = (vector[0].inputs[name] for name in ("Location", "Rotation", "Scale"))
            if any(s.is_linked for s in (place, turn, size)) or any(turn.default_value):
                return None
            for axis, i in (("u", 0), ("v", 1)):
                text += f' "float {axis}scale" {number(size.default_value[i])} "float {axis}delta" {number(place.default_value[i])}'
            vector = vector[0].inputs["Vector"].source
        if vector and not (vector[0].type == "UVMAP" or (vector[0].type == "TEX_COORD" and vector[1].name == "UV")):
            return None
        return text

    def define(self, kind, text):
        """Name of a texture of this kind ("spectrum" or "float"); `text`: its class and parameters."""
        key = (kind, text)
        if key not in self._known:
            self._known[key] = f"t{len(self._known)}"
            self.lines.append(f'Texture "{self._known[key]}" "{kind}" {text}')
        return self._known[key]

    def value(self, socket, is_colour, owner, change=None):
        """Constant, or the name of a texture. `change` is applied to all values."""
        if not socket.source:
            value = self.constant(socket, is_colour)
            return change(value) if change else value
        kind = "spectrum" if is_colour else "float"
        plain = None if change else self._plain_picture(socket)
        if plain:
            return self.define(kind, '"imagemap" ' + plain)
        value = self._baked(socket, is_colour, owner)
        if value is None:
            value = self._guess(socket, is_colour)
            return change(value) if change else value
        if change:
            value = change(value)
        if is_even(value, is_colour):
            return mean(value, is_colour)
        pixels = value if is_colour else np.repeat(value[..., None], 3, axis=2)
        file = self.folder.picture(socket.source[0].name, pixels[::-1])
        return self.define(kind, f'"imagemap" "string filename" {quoted(file)}')

    def parameter(self, name, value, is_colour):
        """Text of a parameter."""
        if isinstance(value, str):
            return f'"texture {name}" "{value}"'
        return f'"rgb {name}" {numbers(np.clip(value, 0, None))}' if is_colour else f'"float {name}" {number(value)}'

    def square(self, value):
        """Square of a number or of a texture of numbers."""
        if isinstance(value, str):
            return self.define("float", f'"scale" "texture tex" "{value}" "texture scale" "{value}"')
        return value * value
