"""Coefficients of volume shaders."""
import numpy as np


def coefficients(materials, node):
    """Absorption, scattering, mean cosine and emission; None for an unsupported node."""
    none = np.zeros(3)
    if node.type == "ADD_SHADER":
        parts = [coefficients(materials, socket.source[0]) for socket in node.inputs if socket.source]
        if not parts or any(part is None for part in parts):
            return None
        scattering = sum(part[1] for part in parts)
        g = sum(part[2] * part[1].mean() for part in parts) / max(scattering.mean(), 1e-9)
        return sum(part[0] for part in parts), scattering, g, sum(part[3] for part in parts)
    if node.type not in ("VOLUME_ABSORPTION", "VOLUME_SCATTER", "PRINCIPLED_VOLUME", "EMISSION"):
        return None
    if node.type == "EMISSION":
        return none, none, 0, materials.average(node, "Color", True) * materials.average(node, "Strength")
    colour, density = np.clip(materials.average(node, "Color", True), 0, 1), materials.average(node, "Density")
    if node.type == "VOLUME_ABSORPTION":
        return density * (1 - colour), none, 0, none
    if node.type == "VOLUME_SCATTER":
        return none, density * colour, materials.average(node, "Anisotropy"), none
    absorbed = np.sqrt(np.clip(materials.average(node, "Absorption Color", True), 0, 1))
    emission = materials.average(node, "Emission Color", True) * materials.average(node, "Emission Strength")
    if materials.average(node, "Blackbody Intensity") > 0:
        materials.warnings.add(f"{materials.owner}: the blackbody of '{node.name}' is left out")
    return density * (1 - colour) * (1 - absorbed), density * colour, materials.average(node, "Anisotropy"), emission
