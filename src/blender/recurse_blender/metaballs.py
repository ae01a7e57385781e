"""Export of metaballs: the balls of a family of objects, in the space of the object that shows their surface."""
import numpy as np

from .text import number, numbers

SAME_SCALE = 1e-4  # maximum relative difference of the scales along the axes of a ball


def _family(name):
    """Name of an object without its number. Objects of the same name share a surface."""
    stem, _, digits = name.rpartition(".")
    return stem if stem and digits.isdigit() else name


def _balls(object_, place):
    """Centres, radii and strengths in the space of `place`; None if an element is not a ball there."""
    matrix = np.linalg.inv(place) @ np.array(object_.matrix_world, float)
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    gram = matrix[:3, :3].T @ matrix[:3, :3]
    if np.abs(gram - np.eye(3) * scales.mean() ** 2).max() > SAME_SCALE * scales.mean() ** 2:
        return None
    out = []
    for element in object_.data.elements:
        if element.hide:
            continue
        if element.type != "BALL":
            return None
        centre = matrix @ np.array([*element.co, 1])
        out.append((centre[:3], element.radius * scales.mean(),
                    -element.stiffness if element.use_negative else element.stiffness))
    return out


def shape(source, objects):
    """Class and parameters of the shape of a family among the scene's objects, whose surface `source` shows; None if it
    must be a mesh."""
    place = np.array(source.matrix_world, float)
    found = []
    for other in objects:
        if other.type == "META" and _family(other.name) == _family(source.name):
            balls = _balls(other, place)
            if balls is None:
                return None
            found += balls
    if sum(max(strength, 0) for _, _, strength in found) <= source.data.threshold:
        return None
    centres, radii, strengths = (np.array(values) for values in zip(*found))
    return (f'"metaballs" "string field" "sextic" "float threshold" {number(source.data.threshold)} '
            f'"point3 P" {numbers(centres)} "float radius" {numbers(radii)} "float strength" {numbers(strengths)}')
