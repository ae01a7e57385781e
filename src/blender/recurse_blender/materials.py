"""Materials: a tree of shader nodes becomes a sum of Recurse's materials, what the surface emits, its opacity, and the
medium inside."""
import math

import numpy as np

from .text import number, numbers, quoted
from .textures import linked

MOST_PARTS = 8  # of a compound
INSIDE_DIFFUSE = 0.596  # part of diffuse light that a smooth surface of index 1.5 reflects back inside


class Surface:
    """What a shape needs of its material."""

    def __init__(self):
        self.material = ""  # name; empty: it does not scatter
        self.emission = None  # radiance
        self.alpha = None  # a number or the name of a texture
        self.medium = ""  # name of what is inside

    @property
    def emits(self):
        """Whether it is a lamp."""
        return self.emission is not None and max(self.emission) > 0


class Parts:
    """A sum: materials with colours as weights, emitted radiance, and what is let through."""

    def __init__(self, materials=(), emission=(0, 0, 0), clear=(0, 0, 0)):
        self.materials = list(materials)  # weight, and text after "string type"
        self.emission = np.asarray(emission, float)
        self.clear = np.asarray(clear, float)

    def scaled(self, factor):
        """All of it times a number or a colour."""
        factor = np.ones(3) * factor
        return Parts([(weight * factor, text) for weight, text in self.materials], self.emission * factor,
                     self.clear * factor)

    def __add__(self, other):
        return Parts(self.materials + other.materials, self.emission + other.emission, self.clear + other.clear)


def below_coat(colour):
    """The base of a plastic whose diffuse part has this albedo."""
    return np.clip(colour / ((1 - INSIDE_DIFFUSE) * 0.908 + INSIDE_DIFFUSE * colour), 0, 1)


class Materials:
    """Materials and media of a scene file."""

    def __init__(self, textures, folder, warnings):
        self.textures, self.folder, self.warnings = textures, folder, warnings
        self.lines, self.media_lines = [], []
        self._surfaces, self._names = {}, {}

    def surface(self, material):
        """Of a material of Blender; None: the grey of faces without one."""
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
        output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
        if not output:
            return out
        self.owner, self.extra = material.name, ""
        self.mixed_alpha = None
        if output.inputs["Displacement"].is_linked:
            self.warnings.add(f"{material.name}: displacement of surfaces is left out")
        out.medium = self._medium(material, output.inputs["Volume"])
        source = linked(output.inputs["Surface"])
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
            self.warnings.add(f"{material.name}: what a transparent shader lets through has no colour")
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
        """The name of one material that is the sum."""
        if len(materials) == 1 and np.allclose(materials[0][0], 1):
            return self._name(name, materials[0][1])
        if len(materials) > MOST_PARTS:
            self.warnings.add(f"{name}: of {len(materials)} parts the {MOST_PARTS} strongest are kept")
            materials = sorted(materials, key=lambda part: -part[0].max())[:MOST_PARTS]
        total = sum(weight for weight, _ in materials).max()
        if total > 1 + 1e-6:
            self.warnings.add(f"{name}: its shaders would reflect more than arrives; they are scaled down")
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
        self.warnings.add(f"{self.owner}: the shader '{node.name}' ({node.bl_label}) has no counterpart; "
                          "a diffuse surface of its average colour is taken")
        colours = [s for s in node.inputs if s.type == "RGBA"]
        colour = self.textures.average(colours[0], True, self.owner) if colours else np.full(3, 0.5)
        return Parts([(np.ones(3), f'"diffuse" "rgb reflectance" {numbers(np.clip(colour, 0, 1))}')])

    def _input(self, socket):
        source = linked(socket)
        return self._shader(source[0]) if source else Parts()

    def _value(self, node, name, is_colour=False, change=None):
        return self.textures.value(node.inputs[name], is_colour, self.owner, change)

    def _average(self, node, name, is_colour=False):
        return self.textures.average(node.inputs[name], is_colour, self.owner)

    def _parameter(self, name, value, is_colour=False):
        if is_colour and not isinstance(value, str):
            value = np.clip(value, 0, 1)
        return " " + self.textures.parameter(name, value, is_colour)

    def _roughness(self, node, name="Roughness"):
        """Blender's roughness is the square root of alpha."""
        if getattr(node, "distribution", "") == "SHARP":
            return ' "float roughness" 0'
        text = ' "bool remaproughness" false' + self._parameter("roughness", self.textures.square(self._value(node, name)))
        if getattr(node, "distribution", "") == "BECKMANN":
            text += ' "string distribution" "beckmann"'
        if getattr(node, "distribution", "") == "MULTI_GGX":
            text += ' "bool multiscatter" true'
        return text

    def _anisotropic(self, node, name="Roughness"):
        """The same with the node's anisotropy, where that is a number."""
        anisotropy = self._average(node, "Anisotropic") if "Anisotropic" in node.inputs else 0
        if anisotropy == 0 or getattr(node, "distribution", "") == "SHARP":
            return self._roughness(node, name)
        alpha = self._average(node, name) ** 2
        aspect = math.sqrt(1 - 0.9 * min(abs(anisotropy), 1))
        u, v = (alpha / aspect, alpha * aspect) if anisotropy > 0 else (alpha * aspect, alpha / aspect)
        return f' "bool remaproughness" false "float uroughness" {number(u)} "float vroughness" {number(v)}'

    def _bumps(self, node):
        socket = node.inputs.get("Normal")
        source = linked(socket) if socket else None
        if not source:
            return ""
        bump = source[0]
        if bump.type == "BUMP":
            height = self.textures.value(bump.inputs["Height"], False, self.owner)
            if not isinstance(height, str):
                return ""
            scale = self._average(bump, "Strength") * self._average(bump, "Distance") * (-1 if bump.invert else 1)
            scaled = self.textures.define("float", f'"scale" "texture tex" "{height}" "float scale" {number(scale)}')
            return f' "texture displacement" "{scaled}"'
        image = linked(bump.inputs["Color"]) if bump.type == "NORMAL_MAP" else None
        if image and image[0].type == "TEX_IMAGE" and image[0].image and bump.space == "TANGENT":
            from .textures import image_pixels
            pixels = image_pixels(image[0].image)[::-1, :, :3]
            strength = self._average(bump, "Strength")
            pixels = pixels * strength + np.array([0.5, 0.5, 1]) * (1 - strength)
            return f' "string normalmap" {quoted(self.folder.picture(image[0].image.name, pixels))}'
        self.warnings.add(f"{self.owner}: the normals of '{bump.name}' ({bump.bl_label}) have no counterpart; "
                          "the surface is smooth")
        return ""

    def _bsdf_diffuse(self, node):
        colour = self._parameter("reflectance", self._value(node, "Color", True), True)
        sigma = self._average(node, "Roughness")
        if sigma > 0:
            return self._one(f'"orennayar"{colour} "float sigma" {number(min(math.degrees(sigma), 90))}{self._bumps(node)}')
        return self._one(f'"diffuse"{colour}{self._bumps(node)}')

    @staticmethod
    def _one(text, weight=(1, 1, 1)):
        return Parts([(np.asarray(weight, float) * np.ones(3), text)])

    def _bsdf_glossy(self, node):
        rest = self._anisotropic(node) + self._bumps(node)
        if linked(node.inputs["Color"]):
            colour = self._value(node, "Color", True, lambda c: np.clip(c, 0, 0.9999))
            return self._one(f'"conductor"{self._parameter("reflectance", colour, True)}{rest}')
        # As bright from all sides: a mirror without Fresnel's effect.
        return self._one(f'"conductor" "float eta" 1 "float k" 1e4{rest}', self._average(node, "Color", True))

    _bsdf_anisotropic = _bsdf_glossy

    def _dielectric(self, node, colour):
        index = self._average(node, "IOR")
        return self._one(f'"dielectric" "float eta" {number(max(index, 1e-3))}{self._roughness(node)}{self._bumps(node)}', colour)

    def _bsdf_glass(self, node):
        return self._dielectric(node, self._average(node, "Color", True))

    def _bsdf_refraction(self, node):
        self.warnings.add(f"{self.owner}: '{node.name}' (Refraction BSDF) reflects as well, as glass does")
        return self._bsdf_glass(node)

    def _bsdf_translucent(self, node):
        colour = self._parameter("transmittance", self._value(node, "Color", True), True)
        return self._one(f'"diffusetransmission" "rgb reflectance" [ 0 0 0 ]{colour}{self._bumps(node)}')

    def _bsdf_transparent(self, node):
        return Parts(clear=self._average(node, "Color", True))

    def _holdout(self, _):
        return Parts()

    def _emission(self, node):
        return Parts(emission=self._average(node, "Color", True) * self._average(node, "Strength"))

    def _add_shader(self, node):
        return self._input(node.inputs[0]) + self._input(node.inputs[1])

    def _mix_shader(self, node):
        first, second = self._input(node.inputs[1]), self._input(node.inputs[2])
        value = self.textures.value(node.inputs[0], False, self.owner) if self._is_plain(node.inputs[0]) else None
        if not isinstance(value, str):
            factor = min(max(self._average_factor(node.inputs[0]), 0), 1)
            return first.scaled(1 - factor) + second.scaled(factor)
        if first.emission.any() or second.emission.any():
            self.warnings.add(f"{self.owner}: what '{node.name}' mixes shines evenly, by the average of its texture")
        average = min(max(self._average_factor(node.inputs[0]), 0), 1)
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
        source = linked(socket)
        return not source or source[0].type not in ("FRESNEL", "LAYER_WEIGHT", "LIGHT_PATH")

    def _average_factor(self, socket):
        source = linked(socket)
        if source and source[0].type == "FRESNEL":
            index = self.textures.average(source[0].inputs["IOR"], False, self.owner)
            self.warnings.add(f"{self.owner}: '{source[0].name}' (Fresnel) mixes by its value for light from the front")
            return ((index - 1) / (index + 1)) ** 2
        return self.textures.average(socket, False, self.owner)

    def _bsdf_principled(self, node):
        out = Parts()
        for name in ("Subsurface", "Subsurface Weight", "Sheen", "Sheen Weight", "Clearcoat", "Coat Weight"):
            if name in node.inputs and (linked(node.inputs[name]) or node.inputs[name].default_value > 0):
                self.warnings.add(f"{self.owner}: '{name}' of '{node.name}' (Principled BSDF) is left out")
        transmission_name = "Transmission" if "Transmission" in node.inputs else "Transmission Weight"
        metallic, transmission = self._average(node, "Metallic"), self._average(node, transmission_name)
        metallic, transmission = min(max(metallic, 0), 1), min(max(transmission, 0), 1)
        rough, bumps = self._anisotropic(node), self._bumps(node)
        if metallic > 0:
            colour = self._value(node, "Base Color", True, lambda c: np.clip(c, 0, 0.9999))
            out += self._one(f'"conductor"{self._parameter("reflectance", colour, True)}{rough}{bumps}', metallic)
        if metallic < 1 and transmission > 0:
            out += self._dielectric(node, self._average(node, "Base Color", True)).scaled((1 - metallic) * transmission)
        if metallic < 1 and transmission < 1:
            out += self._coated(node, rough, bumps).scaled((1 - metallic) * (1 - transmission))
        emission = self._average(node, "Emission" if "Emission" in node.inputs else "Emission Color", True)
        out.emission = emission * self._average(node, "Emission Strength")
        alpha = self._value(node, "Alpha")
        if isinstance(alpha, str):
            self.mixed_alpha = alpha
        elif alpha < 1:
            out = out.scaled(alpha) + Parts(clear=np.full(3, 1 - alpha))
        return out

    def _coated(self, node, rough, bumps):
        """The part that is no metal and lets nothing through."""
        if "Specular" in node.inputs:
            normal = 0.08 * self._average(node, "Specular")
        else:
            index = self._average(node, "IOR")
            normal = 2 * self._average(node, "Specular IOR Level") * ((index - 1) / (index + 1)) ** 2
        root = math.sqrt(min(max(normal, 0), 0.9))
        index = (1 + root) / (1 - root)
        if index < 1.01:
            return self._one(f'"diffuse"{self._parameter("reflectance", self._value(node, "Base Color", True), True)}{bumps}')
        colour = self._value(node, "Base Color", True, below_coat)
        return self._one(f'"plastic" "float eta" {number(index)}{self._parameter("reflectance", colour, True)}{rough}{bumps}')

    # Media

    def _medium(self, material, socket):
        """The name of the medium inside; empty: none."""
        source = linked(socket)
        if not source:
            return ""
        sigma = self._volume(source[0])
        if sigma is None:
            self.warnings.add(f"{self.owner}: the volume '{source[0].name}' ({source[0].bl_label}) has no counterpart")
            return ""
        absorption, scattering, g, emission = sigma
        name = f"medium of {material.name}"
        text = (f'MakeNamedMedium {quoted(name)} "string type" "homogeneous" "rgb sigma_a" {numbers(absorption)} '
                f'"rgb sigma_s" {numbers(scattering)} "float g" {number(min(max(g, -0.99), 0.99))}')
        if max(emission) > 0:  # what is emitted along a unit of length
            floor = np.maximum(absorption, 1e-6)
            text = text.replace(numbers(absorption), numbers(floor), 1) + f' "rgb Le" {numbers(emission / floor)}'
        self.media_lines.append(text)
        return name

    def _volume(self, node):
        """Absorption, scattering, mean cosine, emission; None where the node is another one."""
        none = np.zeros(3)
        if node.type == "ADD_SHADER":
            parts = [self._volume(source[0]) for source in map(linked, node.inputs) if source]
            if not parts or any(part is None for part in parts):
                return None
            scattering = sum(part[1] for part in parts)
            g = sum(part[2] * part[1].mean() for part in parts) / max(scattering.mean(), 1e-9)
            return sum(part[0] for part in parts), scattering, g, sum(part[3] for part in parts)
        if node.type not in ("VOLUME_ABSORPTION", "VOLUME_SCATTER", "PRINCIPLED_VOLUME", "EMISSION"):
            return None
        if node.type == "EMISSION":
            return none, none, 0, self._average(node, "Color", True) * self._average(node, "Strength")
        colour, density = np.clip(self._average(node, "Color", True), 0, 1), self._average(node, "Density")
        if node.type == "VOLUME_ABSORPTION":
            return density * (1 - colour), none, 0, none
        if node.type == "VOLUME_SCATTER":
            return none, density * colour, self._average(node, "Anisotropy"), none
        absorbed = np.sqrt(np.clip(self._average(node, "Absorption Color", True), 0, 1))
        emission = self._average(node, "Emission Color", True) * self._average(node, "Emission Strength")
        if self._average(node, "Blackbody Intensity") > 0:
            self.warnings.add(f"{self.owner}: the blackbody of '{node.name}' is left out")
        return density * (1 - colour) * (1 - absorbed), density * colour, self._average(node, "Anisotropy"), emission
