"""Principled BSDF of Blender 3 and 4."""
import math

import numpy as np

from .parts import Parts
from .text import number

INSIDE_DIFFUSE = 0.596  # internal reflectance of a smooth surface of index 1.5 for diffuse light
COAT_INDEX = 1.5
COAT_OF_BLENDER_3 = 0.25  # weight of the coat where the input Clearcoat is 1
LEFT_OUT = ("Subsurface", "Subsurface Weight", "Sheen", "Sheen Weight", "Specular Tint", "Transmission Roughness",
            "Anisotropic Rotation", "Thin Film Thickness", "Clearcoat Normal", "Coat Normal", "Tangent")


def below_coat(colour):
    """Base colour of a plastic whose diffuse component has this albedo."""
    return np.clip(colour / ((1 - INSIDE_DIFFUSE) * 0.908 + INSIDE_DIFFUSE * colour), 0, 1)


def principled(materials, node):
    """Sum of materials, and opacity (a number or the name of a texture)."""
    shader = _Principled(materials, node)
    return shader.parts(), materials.value(node, "Alpha")


class _Principled:
    def __init__(self, materials, node):
        self.materials, self.node = materials, node
        self.bumps = materials.bumps(node)

    def _name(self, *names):
        """Name of the input in this version of Blender."""
        return next(name for name in names if name in self.node.inputs)

    def _fraction(self, *names):
        return min(max(self.materials.average(self.node, self._name(*names)), 0), 1)

    def _colour(self, change=None):
        colour = self.materials.value(self.node, "Base Color", True, change)
        return self.materials.parameter("reflectance", colour, True)

    def parts(self):
        """Sum of metal, glass and plastic, and the emission."""
        materials, node = self.materials, self.node
        self._warn()
        metallic, transmission = self._fraction("Metallic"), self._fraction("Transmission", "Transmission Weight")
        out = Parts()
        if metallic > 0:
            out += self._with_coat(self._metal, self._coated_metal).scaled(metallic)
        if metallic < 1 and transmission > 0:
            glass = materials.dielectric(node, materials.average(node, "Base Color", True))
            out += glass.scaled((1 - metallic) * transmission)
        if metallic < 1 and transmission < 1:
            out += self._with_coat(self._plastic, self._coated_base).scaled((1 - metallic) * (1 - transmission))
        emission = materials.average(node, self._name("Emission", "Emission Color"), True)
        out.emission = emission * materials.average(node, "Emission Strength")
        return out

    def _warn(self):
        for name in LEFT_OUT:
            socket = self.node.inputs.get(name)
            if socket is None or (name == "Anisotropic Rotation" and not self._has("Anisotropic")):
                continue
            if self._has(name):
                self.materials.warnings.add(f"{self.materials.owner}: {socket.description} is left out")

    def _has(self, name):
        """Whether an input has an effect."""
        socket = self.node.inputs[name]
        return bool(socket.source) or (socket.type == "VALUE" and socket.default_value > 0)

    # The coat

    def _with_coat(self, bare, coated):
        """Mixture of the material without and with a coat."""
        is_old = "Clearcoat" in self.node.inputs
        weight = self._fraction("Clearcoat", "Coat Weight") * (COAT_OF_BLENDER_3 if is_old else 1)
        out = Parts()
        if weight < 1:
            out += bare().scaled(1 - weight)
        if weight > 0:
            out += coated().scaled(weight)
        return out

    def _coat(self, prefix):
        """Parameters of the coat, which has its own roughness."""
        name = self._name("Clearcoat Roughness", "Coat Roughness")
        index = self.materials.average(self.node, "Coat IOR") if "Coat IOR" in self.node.inputs else COAT_INDEX
        alpha = self.materials.average(self.node, name) ** 2
        return (f' "float {prefix}eta" {number(max(index, 1))} "float {prefix}roughness" {number(alpha)} '
                '"float thickness" 0')

    # The materials below

    def _metal(self):
        facets = self.materials.anisotropic(self.node) + self.materials.multiscatter(self.node)
        return self.materials.one(f'"conductor"{self._colour(lambda c: np.clip(c, 0, 0.9999))}{facets}{self.bumps}')

    def _coated_metal(self):
        facets = self.materials.anisotropic(self.node, prefix="conductor.")
        return self.materials.one(f'"coatedconductor"{self._colour(lambda c: np.clip(c, 0, 0.9999))}{facets}'
                                  f'{self._coat("interface.")}{self.bumps}')

    def _plastic(self):
        """Opaque dielectric: plastic, or diffuse if its refractive index is nearly 1."""
        materials, node = self.materials, self.node
        if "Specular" in node.inputs:
            normal = 0.08 * materials.average(node, "Specular")
        else:
            index = materials.average(node, "IOR")
            normal = 2 * materials.average(node, "Specular IOR Level") * ((index - 1) / (index + 1)) ** 2
        root = math.sqrt(min(max(normal, 0), 0.9))
        index = (1 + root) / (1 - root)
        if index < 1.01:
            return materials.one(f'"diffuse"{self._colour()}{self.bumps}')
        return materials.one(f'"plastic" "float eta" {number(index)}{self._colour(below_coat)}'
                             f'{materials.anisotropic(node)}{self.bumps}')

    def _coated_base(self):
        return self.materials.one(f'"coateddiffuse"{self._colour(below_coat)} "bool remaproughness" false'
                                  f'{self._coat("")}{self.bumps}')
