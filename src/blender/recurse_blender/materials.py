"""Materials: converts a tree of shader nodes to a sum of Recurse's materials, the emission of the surface, its opacity,
and the medium inside."""
import math

import numpy as np

from .nodes import output_node
from .parts import Parts
from .principled import principled
from .text import number, numbers, quoted
from .textures import image_pixels
from .volumes import coefficients

MOST_PARTS = 8  # maximum materials of a compound


class Surface:
    """Properties of a material that its shapes use."""

    def __init__(self):
        self.material = ""  # name; empty: it does not scatter
        self.emission = None  # radiance
        self.alpha = None  # opacity: a number or the name of a texture; None: opaque
        self.medium = ""  # name of the medium inside; empty: none

    @property
    def emits(self):
        """Whether the surface emits light."""
        return self.emission is not None and max(self.emission) > 0


class Materials:
    """Materials and media of a scene file."""

    def __init__(self, textures, folder, warnings):
        self.textures, self.folder, self.warnings = textures, folder, warnings
        self.lines, self.media_lines = [], []
        self._surfaces, self._names = {}, {}

    def surface(self, material):
        """Surface of a Blender material; None: the grey of faces without a material."""
        key = material.name_full if material else None
        if key not in self._surfaces:
            self._surfaces[key] = self._make(material)
        return self._surfaces[key]

    def _make(self, material):
        out = Surface()
        tree = material.node_tree if material and material.use_nodes else None
        if not tree:
            colour = material.diffuse_color[:3] if material else (0.8, 0.8, 0.8)
            out.material = self._name("grey" if not material else material.name,
                                      f'"diffuse" "rgb reflectance" {numbers(colour)}')
            return out
        output = output_node(tree)
        if not output:
            return out
        self.owner, self.extra = material.name, ""
        self.mixed_alpha = None
        if output.inputs["Displacement"].is_linked:
            self.warnings.add(f"{material.name}: displacement of surfaces is left out")
        out.medium = self._medium(material, output.inputs["Volume"])
        source = output.inputs["Surface"].source
        if source:
            parts = self._shader(source[0])
            out.emission = parts.emission if parts.emission.max() > 0 else None
            self._finish(material, parts, out)
        elif not out.medium:  # a surface without a shader is black
            out.material = self._name(material.name, '"diffuse" "rgb reflectance" [ 0 0 0 ]')
        return out

    def _finish(self, material, parts, out):
        clear = float(parts.clear.mean())
        if np.ptp(parts.clear) > 1e-3:
            self.warnings.add(f"{material.name}: transparent shaders are rendered without colour")
        out.alpha = self.mixed_alpha
        if clear > 0:
            out.alpha = 1 - min(clear, 1) if out.alpha is None else out.alpha
            parts = parts.scaled(1 / (1 - clear)) if clear < 1 else Parts()
        materials = [(np.minimum(weight, 1), text) for weight, text in parts.materials if weight.max() > 0]
        if out.alpha == 0 and not out.emits:
            return
        if not materials:
            out.material = self._name(material.name, '"diffuse" "rgb reflectance" [ 0 0 0 ]') if not out.medium or out.emits else ""
            return
        out.material = self._sum(material.name, materials)

    def _sum(self, name, materials):
        """Name of a material that is the weighted sum of several."""
        if len(materials) == 1 and np.allclose(materials[0][0], 1):
            return self._name(name, materials[0][1])
        if len(materials) > MOST_PARTS:
            self.warnings.add(f"{name}: of {len(materials)} parts the {MOST_PARTS} strongest are kept")
            materials = sorted(materials, key=lambda part: -part[0].max())[:MOST_PARTS]
        total = sum(weight for weight, _ in materials).max()
        if total > 1 + 1e-6:
            self.warnings.add(f"{name}: its shaders would reflect more light than arrives; they are scaled down")
        weights = [weight / max(total, 1) for weight, _ in materials]
        names = " ".join(quoted(self._name(name, text)) for _, text in materials)
        return self._name(name, f'"compound" "string materials" [ {names} ] "rgb weights" {numbers(np.array(weights) * 0.9999999)}')

    def _name(self, hint, text):
        if text not in self._names:
            self._names[text] = f"{hint} {len(self._names) + 1}"
            self.lines.append(f'MakeNamedMaterial {quoted(self._names[text])} "string type" {text}')
        return self._names[text]

    # Shaders

    def _shader(self, node):
        make = getattr(self, "_" + node.type.lower(), None)
        if make:
            return make(node)
        self.warnings.add(f"{self.owner}: the shader '{node.name}' ({node.bl_label}) is not supported; "
                          "a diffuse surface of its average colour is used")
        colours = [s for s in node.inputs if s.type == "RGBA"]
        colour = self.textures.average(colours[0], True, self.owner) if colours else np.full(3, 0.5)
        return Parts([(np.ones(3), f'"diffuse" "rgb reflectance" {numbers(np.clip(colour, 0, 1))}')])

    def _input(self, socket):
        source = socket.source
        return self._shader(source[0]) if source else Parts()

    def value(self, node, name, is_colour=False, change=None):
        """Value of an input: a number, a colour, or the name of a texture."""
        return self.textures.value(node.inputs[name], is_colour, self.owner, change)

    def average(self, node, name, is_colour=False):
        """Average of an input: a number or a colour. A texture is reported by a warning."""
        return self.textures.average(node.inputs[name], is_colour, self.owner)

    def parameter(self, name, value, is_colour=False):
        """Text of a parameter, with a leading space."""
        if is_colour and not isinstance(value, str):
            value = np.clip(value, 0, 1)
        return " " + self.textures.parameter(name, value, is_colour)

    def roughness(self, node, name="Roughness", prefix=""):
        """Roughness parameters of a microfacet surface, with names that begin with `prefix`. Blender's roughness is the
        square root of alpha."""
        distribution = getattr(node, "distribution", "")
        if distribution == "SHARP":
            return f' "float {prefix}roughness" 0'
        alpha = self.textures.square(self.value(node, name))
        text = ' "bool remaproughness" false' + self.parameter(prefix + "roughness", alpha)
        if distribution == "BECKMANN":
            text += ' "string distribution" "beckmann"'
        return text

    @staticmethod
    def multiscatter(node):
        """Parameter of conductors and dielectrics for multiple scattering between facets."""
        return ' "bool multiscatter" true' if getattr(node, "distribution", "") == "MULTI_GGX" else ""

    def anisotropic(self, node, name="Roughness", prefix=""):
        """Roughness parameters with the node's anisotropy, of which a texture is averaged."""
        anisotropy = self.average(node, "Anisotropic") if "Anisotropic" in node.inputs else 0
        if anisotropy == 0 or getattr(node, "distribution", "") == "SHARP":
            return self.roughness(node, name, prefix)
        alpha = self.average(node, name) ** 2
        aspect = math.sqrt(1 - 0.9 * min(abs(anisotropy), 1))
        u, v = (alpha / aspect, alpha * aspect) if anisotropy > 0 else (alpha * aspect, alpha / aspect)
        return (f' "bool remaproughness" false "float {prefix}uroughness" {number(u)} '
                f'"float {prefix}vroughness" {number(v)}')

    def bumps(self, node):
        """Parameters of a bump or normal map."""
        socket = node.inputs.get("Normal")
        source = socket.source if socket else None
        if not source:
            return ""
        bump = source[0]
        if bump.type == "BUMP":
            if bump.inputs["Normal"].source:
                self.warnings.add(f"{self.owner}: {bump.inputs['Normal'].description} is left out")
            height = self.textures.value(bump.inputs["Height"], False, self.owner)
            if not isinstance(height, str):
                return ""
            scale = self.average(bump, "Strength") * self.average(bump, "Distance") * (-1 if bump.invert else 1)
            scaled = self.textures.define("float", f'"scale" "texture tex" "{height}" "float scale" {number(scale)}')
            return f' "texture displacement" "{scaled}"'
        image = bump.inputs["Color"].source if bump.type == "NORMAL_MAP" else None
        if image and image[0].type == "TEX_IMAGE" and image[0].image and bump.space == "TANGENT":
            pixels = image_pixels(image[0].image)[::-1, :, :3]
            strength = self.average(bump, "Strength")
            pixels = pixels * strength + np.array([0.5, 0.5, 1]) * (1 - strength)
            return f' "string normalmap" {quoted(self.folder.picture(image[0].image.name, pixels))}'
        self.warnings.add(f"{self.owner}: the normals of '{bump.name}' ({bump.bl_label}) are not supported; "
                          "the surface is smooth")
        return ""

    def _bsdf_diffuse(self, node):
        colour = self.parameter("reflectance", self.value(node, "Color", True), True)
        sigma = self.value(node, "Roughness", change=lambda r: np.clip(np.degrees(r), 0, 90))
        if isinstance(sigma, str) or sigma > 0:
            return self.one(f'"orennayar"{colour}{self.parameter("sigma", sigma)}{self.bumps(node)}')
        return self.one(f'"diffuse"{colour}{self.bumps(node)}')

    @staticmethod
    def one(text, weight=(1, 1, 1)):
        """Parts of a single material."""
        return Parts([(np.asarray(weight, float) * np.ones(3), text)])

    def _bsdf_glossy(self, node):
        rest = self.anisotropic(node) + self.multiscatter(node) + self.bumps(node)
        if node.inputs["Color"].source:
            colour = self.value(node, "Color", True, lambda c: np.clip(c, 0, 0.9999))
            return self.one(f'"conductor"{self.parameter("reflectance", colour, True)}{rest}')
        # Mirror with the same reflectance at all angles, without a Fresnel effect.
        return self.one(f'"conductor" "float eta" 1 "float k" 1e4{rest}', self.average(node, "Color", True))

    _bsdf_anisotropic = _bsdf_glossy

    def dielectric(self, node, colour):
        """Glass with the node's refractive index and roughness."""
        index = self.average(node, "IOR")
        facets = self.roughness(node) + self.multiscatter(node)
        return self.one(f'"dielectric" "float eta" {number(max(index, 1e-3))}{facets}{self.bumps(node)}', colour)

    def _bsdf_glass(self, node):
        return self.dielectric(node, self.average(node, "Color", True))

    def _bsdf_refraction(self, node):
        self.warnings.add(f"{self.owner}: '{node.name}' (Refraction BSDF) reflects as well, as glass does")
        return self._bsdf_glass(node)

    def _bsdf_translucent(self, node):
        colour = self.parameter("transmittance", self.value(node, "Color", True), True)
        return self.one(f'"diffusetransmission" "rgb reflectance" [ 0 0 0 ]{colour}{self.bumps(node)}')

    def _bsdf_transparent(self, node):
        return Parts(clear=self.average(node, "Color", True))

    def _holdout(self, _):
        return Parts()

    def _emission(self, node):
        return Parts(emission=self.average(node, "Color", True) * self.average(node, "Strength"))

    def _add_shader(self, node):
        return self._input(node.inputs[0]) + self._input(node.inputs[1])

    def _mix_shader(self, node):
        first, second = self._input(node.inputs[1]), self._input(node.inputs[2])
        value = self.textures.value(node.inputs[0], False, self.owner) if self._is_plain(node.inputs[0]) else None
        if not isinstance(value, str):
            factor = min(max(self._average_factor(node.inputs[0]), 0), 1)
            return first.scaled(1 - factor) + second.scaled(factor)
        if first.emission.any() or second.emission.any():
            self.warnings.add(f"{self.owner}: what '{node.name}' mixes emits with the average of its texture")
        average = min(max(self.textures.average(node.inputs[0], False, self.owner, is_named=False), 0), 1)
        emission = first.emission * (1 - average) + second.emission * average
        if first.clear.min() == 1 or second.clear.min() == 1:
            opaque = second if first.clear.min() == 1 else first
            self.mixed_alpha = value if opaque is second else self.textures.define(
                "float", f'"mix" "float tex1" 1 "float tex2" 0 "texture amount" "{value}"')
            return Parts(opaque.materials, emission)
        names = [self._sum(self.owner, part.materials) for part in (first, second)]
        return Parts([(np.ones(3), f'"mix" "string materials" [ {quoted(names[0])} {quoted(names[1])} ] "texture amount" "{value}"')],
                     emission)

    @staticmethod
    def _is_plain(socket):
        source = socket.source
        return not source or source[0].type not in ("FRESNEL", "LAYER_WEIGHT", "LIGHT_PATH")

    def _average_factor(self, socket):
        source = socket.source
        if source and source[0].type == "FRESNEL":
            index = self.textures.average(source[0].inputs["IOR"], False, self.owner)
            self.warnings.add(f"{self.owner}: '{source[0].name}' (Fresnel) mixes by its value for light from the front")
            return ((index - 1) / (index + 1)) ** 2
        return self.textures.average(socket, False, self.owner)

    def _bsdf_principled(self, node):
        parts, alpha = principled(self, node)
        if isinstance(alpha, str):
            self.mixed_alpha = alpha
        elif alpha < 1:
            parts = parts.scaled(alpha) + Parts(clear=np.full(3, 1 - alpha))
        return parts

    # Media

    def _medium(self, material, socket):
        """Name of the medium inside; empty: none."""
        source = socket.source
        if not source:
            return ""
        text = self._medium_parameters(source[0])
        if not text:
            return ""
        name = f"medium of {material.name}"
        self.media_lines.append(f'MakeNamedMedium {quoted(name)} "string type" "homogeneous"{text}')
        return name

    def _medium_parameters(self, node):
        """Parameters of a volume shader's medium; empty if the shader is not supported."""
        sigma = coefficients(self, node)
        if sigma is None:
            self.warnings.add(f"{self.owner}: the volume '{node.name}' ({node.bl_label}) is not supported")
            return ""
        absorption, scattering, g, emission = sigma
        is_lamp = max(emission) > 0
        if is_lamp:
            absorption = np.maximum(absorption, 1e-6)
        text = (f' "rgb sigma_a" {numbers(absorption)} "rgb sigma_s" {numbers(scattering)} '
                f'"float g" {number(min(max(g, -0.99), 0.99))}')
        return text + (f' "rgb Le" {numbers(emission / absorption)}' if is_lamp else "")  # emission per unit of length

    def volume(self, material):
        """Parameters of the medium that a volume's density multiplies; empty: there is none."""
        tree = material.node_tree if material and material.use_nodes else None
        output = output_node(tree) if tree else None
        source = output.inputs["Volume"].source if output else None
        if not source:
            return ""
        self.owner = material.name
        text = self._medium_parameters(source[0])
        return text if not text or "Le" in text else text + ' "float Lescale" 0'  # a file's temperatures do not glow

