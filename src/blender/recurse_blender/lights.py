"""Lamps and the world, with Blender's definition of power."""
import math
import os

import bpy
import numpy as np

from .nodes import output_node
from .text import matrix, number, numbers, quoted
from .textures import image_pixels

LARGE_SUN = math.radians(2)  # minimum angle at which a sun is exported as a disc
SUN_MAP = (1024, 512)


def _shape(text, radiance, placement, is_hidden, first=()):
    if is_hidden:
        text += ' "float alpha" 0'  # emits, but is invisible
    return "\n".join(["AttributeBegin", f"Transform {matrix(placement)}", 'Material "interface"',
                      f'AreaLightSource "diffuse" "rgb L" {numbers(radiance)}', *first, text, "AttributeEnd"])


def power_of(light, textures):
    """Power of a lamp: red, green and blue [W], or [W/m^2] for suns."""
    power = np.array(light.color[:]) * light.energy
    output = output_node(light.node_tree) if light.use_nodes and light.node_tree else None
    source = output.inputs["Surface"].source if output else None
    if not source:
        return power
    if source[0].type != "EMISSION":
        textures.warnings.add(f"{light.name}: its nodes are not supported; the colour and power of the lamp are used")
        return power
    return (power * textures.average(source[0].inputs["Color"], True, light.name)
            * textures.average(source[0].inputs["Strength"], False, light.name))


def lamp(light, placement, is_hidden, textures):
    """Directives of a lamp; None for a large sun, see sun_map(). `is_hidden`: its surface is invisible."""
    warnings, power = textures.warnings, power_of(light, textures)
    place = np.array(placement, float)
    if light.type == "SUN":
        return _sun(light, power, place)
    if light.type == "AREA":
        if light.spread < math.pi - 1e-3:
            warnings.add(f"{light.name}: the spread of an area lamp is left out")
        return _area(light, power, place, is_hidden)
    intensity = power / (4 * math.pi)
    radius = light.shadow_soft_size
    if light.type == "POINT" and radius > 0:
        centre = np.eye(4)
        centre[:3, 3] = place[:3, 3]
        return _shape(f'Shape "sphere" "float radius" {number(radius)}', intensity / radius ** 2 / math.pi,
                      centre, is_hidden)
    rigid = place.copy()
    rigid[:3, :3] /= np.linalg.norm(place[:3, :3], axis=0)
    text = f'"rgb I" {numbers(intensity)}'
    if light.type == "POINT":
        return f'AttributeBegin\nTransform {matrix(rigid)}\nLightSource "point" {text}\nAttributeEnd'
    if radius > 0:
        warnings.add(f"{light.name}: the shadows of a spot lamp are sharp; its radius is left out")
    half = light.spot_size / 2
    inner = math.acos(min(1, math.cos(half) + (1 - math.cos(half)) * light.spot_blend))
    return (f'AttributeBegin\nTransform {matrix(rigid)}\nLightSource "spot" {text} "point3 to" [ 0 0 -1 ] '
            f'"float coneangle" {number(math.degrees(half))} "float conedeltaangle" {number(math.degrees(half - inner))}\n'
            "AttributeEnd")


def size_of(light, place):
    """Width and height of an area lamp [scene units]."""
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    return np.array([light.size, height]) * np.linalg.norm(place[:3, :2], axis=0)


def _area(light, power, place, is_hidden):
    width = light.size
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else width
    round_part = math.pi / 4 if light.shape in ("DISK", "ELLIPSE") else 1
    radiance = power / (4 * round_part * max(size_of(light, place).prod(), 1e-30))
    if light.shape in ("DISK", "ELLIPSE"):
        shape = place @ np.diag([width / 2, height / 2, 1, 1])
        return _shape('Shape "disk"', radiance, shape, is_hidden, ["ReverseOrientation"])
    shape = place @ np.diag([width, height, 1, 1])
    # Counterclockwise as seen from -z, the direction of emission.
    return _shape('Shape "trianglemesh" "point3 P" [ -.5 -.5 0 -.5 .5 0 .5 .5 0 .5 -.5 0 ] '
                  '"integer indices" [ 0 1 2 0 2 3 ]', radiance, shape, is_hidden)


def _sun(light, power, place):
    away = place[:3, 2] / np.linalg.norm(place[:3, 2])
    if light.angle < LARGE_SUN:
        return f'LightSource "distant" "rgb L" {numbers(power)} "point3 from" {numbers(away)} "point3 to" [ 0 0 0 ]'
    return None  # exported as an environment map, see sun_map()


def sun_map(light, placement, power):
    """Pixels of an environment map, rows from the top, that is black except for a large sun. A surface that faces the
    centre of the disc receives the irradiance `power`."""
    width, height = SUN_MAP
    away = np.array(placement, float)[:3, 2]
    away /= np.linalg.norm(away)
    azimuth = (np.arange(width) + 0.5) / width * 2 * math.pi
    polar = (np.arange(height) + 0.5) / height * math.pi
    direction = np.stack([np.outer(np.sin(polar), np.cos(azimuth)), np.outer(np.sin(polar), np.sin(azimuth)),
                          np.outer(np.cos(polar), np.ones(width))], axis=-1)
    cosine = direction @ away
    inside = cosine > math.cos(light.angle / 2)
    solid = np.sin(polar)[:, None] * (math.pi / height) * (2 * math.pi / width)
    irradiance = (inside * np.maximum(cosine, 0) * solid).sum()
    return inside[..., None] * power / max(irradiance, 1e-30)


def world(scene_world, textures):
    """Directives of the world's light."""
    folder, warnings = textures.folder, textures.warnings
    if not scene_world:
        return []
    if not scene_world.use_nodes:
        return [f'LightSource "infinite" "rgb L" {numbers(scene_world.color[:])}'] if max(scene_world.color) > 0 else []
    output = output_node(scene_world.node_tree)
    source = output.inputs["Surface"].source if output else None
    if not source:
        return []
    if output.inputs["Volume"].is_linked:
        warnings.add("the volume of the world is left out")
    node = source[0]
    if node.type not in ("BACKGROUND", "EMISSION"):
        warnings.add(f"the world's shader '{node.name}' ({node.bl_label}) is not supported: it is black")
        return []
    strength = textures.average(node.inputs["Strength"], False, "the world")
    picture = node.inputs["Color"].source
    if picture and picture[0].type == "TEX_ENVIRONMENT" and picture[0].image and picture[0].projection == "EQUIRECTANGULAR":
        return [_environment(picture[0], strength, folder, warnings)]
    if picture and picture[0].type == "TEX_SKY":
        return [_sky(picture[0], strength, warnings)]
    radiance = np.clip(textures.average(node.inputs["Color"], True, "the world"), 0, None) * strength
    return [f'LightSource "infinite" "rgb L" {numbers(radiance)}'] if radiance.max() > 0 else []


def _environment(node, strength, folder, warnings):
    turn = np.eye(3)
    vector = node.inputs["Vector"].source
    if vector and vector[0].type not in ("MAPPING", "TEX_COORD"):
        warnings.add(f"the world: {node.inputs['Vector'].description} supports only a mapping")
    if vector and vector[0].type == "MAPPING":
        from mathutils import Euler
        if np.any(np.array(vector[0].inputs["Scale"].default_value[:]) != 1):
            warnings.add(f"the world: the scale of '{vector[0].name}' (Mapping) is left out")
        if vector[0].inputs["Rotation"].source:
            warnings.add(f"the world: {vector[0].inputs['Rotation'].description} cannot have a texture")
        turn = np.array(Euler(vector[0].inputs["Rotation"].default_value[:], "XYZ").to_matrix())
        if vector[0].vector_type == "TEXTURE":
            turn = turn.T
    file = bpy.path.abspath(node.image.filepath, library=node.image.library)
    if node.image.packed_file or not node.image.is_float or not os.path.isfile(file):
        file = folder.picture(node.image.name, image_pixels(node.image)[::-1])
    # Blender's maps have -x at their left and right edges, and the opposite direction of rotation.
    light_from_world = np.eye(4)
    light_from_world[:3, :3] = np.diag([-1, 1, 1]) @ turn
    return (f'AttributeBegin\nTransform {matrix(np.linalg.inv(light_from_world))}\nLightSource "infinite" '
            f'"string filename" {quoted(file)} "string mapping" "latlong" "float scale" {number(strength)}\nAttributeEnd')


def _sky(node, strength, warnings):
    if node.sky_type == "NISHITA":
        elevation, azimuth = node.sun_elevation, node.sun_rotation
        turbidity = 2 + 2 * node.dust_density
    else:
        x, y, z = node.sun_direction
        elevation, azimuth = math.asin(min(max(z, -1), 1)), math.atan2(x, y)
        turbidity = node.turbidity
    warnings.add("the sky of the world is that of Preetham, Shirley and Smits: brightness and colours differ")
    # Recurse's sky has north at +x, which is Blender's +y, and east at +y.
    north = np.array([[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], float)
    return (f'AttributeBegin\nTransform {matrix(north)}\nLightSource "sky" "float turbidity" '
            f'{number(min(max(turbidity, 1.9), 10))} "float elevation" {number(math.degrees(elevation))} '
            f'"float azimuth" {number(math.degrees(azimuth) % 360)} "float scale" {number(strength)}\nAttributeEnd')
