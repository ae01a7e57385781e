"""Ten scenes for Blender, each made by a function in an empty file."""
import math

import bpy
import numpy as np
from mathutils import Vector


def clear():
    """An empty scene with a small picture."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
    world = bpy.data.worlds.new("World")
    scene.world = world
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    return scene


def world_colour(colour, strength=1):
    """Sets the colour of the surroundings."""
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*colour, 1)
    background.inputs["Strength"].default_value = strength


def camera(place, target, **settings):
    """Adds the camera at a position, looking at target."""
    data = bpy.data.cameras.new("Camera")
    for name, value in settings.items():
        setattr(data, name, value)
    made = bpy.data.objects.new("Camera", data)
    bpy.context.collection.objects.link(made)
    made.location = place
    made.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = made
    return made


def lamp(kind, place, energy, target=(0, 0, 0), **settings):
    """A lamp that shines towards target."""
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = energy
    for name, value in settings.items():
        setattr(data, name, value)
    made = bpy.data.objects.new(kind.title(), data)
    bpy.context.collection.objects.link(made)
    made.location = place
    made.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    return made


def material(name, shader="ShaderNodeBsdfDiffuse", **inputs):
    """A material of one shader."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    output, node = nodes.new("ShaderNodeOutputMaterial"), nodes.new(shader)
    for key, value in inputs.items():
        socket = node.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1) if socket.type == "RGBA" else value
    made.node_tree.links.new(node.outputs[0], output.inputs["Volume" if "Volume" in shader else "Surface"])
    return made, node


def add(kind, of, place=(0, 0, 0), smooth=False, **settings):
    """A mesh by Blender's operators."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=place, **settings)
    made = bpy.context.object
    if of:
        made.data.materials.append(of)
    if smooth:
        made.data.polygons.foreach_set("use_smooth", [True] * len(made.data.polygons))
    return made


def floor(colour=(0.6, 0.6, 0.6), size=12):
    """A level, matt square."""
    return add("plane", material("floor", Color=colour)[0], size=size)


def default_cube():
    """Blender's own first scene: a cube and a point lamp."""
    clear()
    world_colour((0.05, 0.05, 0.05))
    add("cube", material("cube", Color=(0.8, 0.8, 0.8))[0])
    camera((7.36, -6.93, 4.96), (0, 0, 0), lens=50)
    lamp("POINT", (4.08, 1.01, 5.90), 1000, shadow_soft_size=0.1)
    floor().location.z = -1


def glass_and_caustic():
    """A glass ball and a metal ring below an area lamp."""
    clear()
    floor()
    add("uv_sphere", material("glass", "ShaderNodeBsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=1.5)[0], (-1, 0, 1.2), True,
        segments=48, ring_count=24)
    add("torus", material("metal", "ShaderNodeBsdfGlossy", Color=(0.9, 0.7, 0.4), Roughness=0.1)[0], (1.5, 0, 0.4), True,
        major_radius=0.9, minor_radius=0.3)
    lamp("AREA", (0, -1, 5), 300, size=2, shape="SQUARE")
    world_colour((0.1, 0.1, 0.12))
    camera((0, -7, 4), (0, 0, 0.5), lens=40)


def every_lamp():
    """A lamp of each kind and shape over a floor."""
    clear()
    floor((0.7, 0.7, 0.7), 24)
    lamp("POINT", (-6, 3, 1.5), 80, shadow_soft_size=0)
    lamp("POINT", (-3, 3, 1.5), 80, shadow_soft_size=0.3, color=(1, 0.5, 0.3))
    lamp("SPOT", (0, 3, 3), 300, (0, 3, 0), spot_size=math.radians(60), spot_blend=0.4, shadow_soft_size=0)
    lamp("AREA", (3, 3, 2), 60, (3, 3, 0), shape="SQUARE", size=1)
    lamp("AREA", (6, 3, 2), 60, (6, 3, 0), shape="RECTANGLE", size=2, size_y=0.5)
    lamp("AREA", (-3, -2, 2), 60, (-3, -2, 0), shape="DISK", size=1)
    lamp("AREA", (3, -2, 2), 60, (3, -2, 0), shape="ELLIPSE", size=1.5, size_y=0.6)
    lamp("SUN", (0, 0, 5), 0.3, (1, 1, 0), angle=0)
    lamp("SUN", (0, 0, 5), 0.3, (-1, 1, 0), angle=math.radians(10), color=(0.4, 0.6, 1))
    add("cube", material("cube", Color=(0.5, 0.7, 0.5))[0], (0, -2, 0.5), size=1)
    camera((0, -12, 9), (0, 1, 0), lens=35)


def every_material():
    """Balls of many materials under a uniform sky."""
    clear()
    world_colour((0.8, 0.9, 1.0), 0.7)
    lamp("AREA", (0, -4, 6), 500, shape="SQUARE", size=3)
    floor((0.4, 0.4, 0.4), 20)
    principled = "ShaderNodeBsdfPrincipled"
    made = [
        material("diffuse", Color=(0.8, 0.3, 0.2))[0],
        material("rough", Color=(0.3, 0.5, 0.8), Roughness=0.5)[0],
        material("glossy", "ShaderNodeBsdfGlossy", Color=(0.9, 0.8, 0.6), Roughness=0.3)[0],
        material("glass", "ShaderNodeBsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=1.45)[0],
        material("rough glass", "ShaderNodeBsdfGlass", Color=(0.9, 1, 0.9), Roughness=0.3, IOR=1.45)[0],
        material("translucent", "ShaderNodeBsdfTranslucent", Color=(0.7, 0.6, 0.2))[0],
        material("emission", "ShaderNodeEmission", Color=(1, 0.4, 0.2), Strength=2.0)[0],
        material("plastic", principled, Base_Color=(0.2, 0.5, 0.3), Roughness=0.3, Specular=0.5)[0],
        material("metal", principled, Base_Color=(0.9, 0.6, 0.3), Roughness=0.2, Metallic=1.0)[0],
        material("transmission", principled, Base_Color=(1, 1, 1), Roughness=0.0, Transmission=1.0)[0],
        material("coated", principled, Base_Color=(0.6, 0.1, 0.1), Roughness=0.8, Clearcoat=1.0, Clearcoat_Roughness=0.1)[0],
        material("coated metal", principled, Base_Color=(0.5, 0.5, 0.7), Roughness=0.5, Metallic=1.0, Clearcoat=1.0,
                 Clearcoat_Roughness=0.05)[0],
        material("half there", principled, Base_Color=(0.8, 0.2, 0.6), Roughness=0.8, Alpha=0.5, Specular=0.0)[0],
        material("anisotropic", principled, Base_Color=(0.8, 0.8, 0.8), Roughness=0.3, Metallic=1.0, Anisotropic=0.7)[0],
    ]
    mixed, first = material("mix", Color=(0.8, 0.1, 0.1))
    tree = mixed.node_tree
    mix, second = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfGlossy")
    second.inputs["Roughness"].default_value = 0.2
    mix.inputs[0].default_value = 0.3
    tree.links.new(first.outputs[0], mix.inputs[1])
    tree.links.new(second.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    made.append(mixed)
    for i, one in enumerate(made):
        add("uv_sphere", one, (2.2 * (i % 5 - 2), 2.4 * (i // 5) - 2, 1), True, segments=32, ring_count=16)
    camera((0, -11, 7), (0, 0.3, 0.5), lens=38)


def picture(name, function, size=64):
    """A picture in memory of function(u, v), packed into the file."""
    image = bpy.data.images.new(name, size, size, float_buffer=False)
    u, v = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size)
    pixels = np.ones((size, size, 4), np.float32)
    pixels[:, :, :3] = function(u, v)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def textured_room():
    """An open room with pictures, checks and a colour ramp on its walls."""
    clear()
    bricks = picture("bricks", lambda u, v: np.stack([0.3 + 0.5 * u, 0.6 - 0.4 * v, 0.3 + 0 * u], axis=-1))
    painted, node = material("picture", Color=(1, 1, 1))
    image = painted.node_tree.nodes.new("ShaderNodeTexImage")
    image.image = bricks
    painted.node_tree.links.new(image.outputs["Color"], node.inputs["Color"])
    checked, node = material("checks", Color=(1, 1, 1))
    tree = checked.node_tree
    checks, coordinates = tree.nodes.new("ShaderNodeTexChecker"), tree.nodes.new("ShaderNodeTexCoord")
    checks.inputs["Scale"].default_value = 6
    checks.inputs["Color1"].default_value, checks.inputs["Color2"].default_value = (0.8, 0.7, 0.2, 1), (0.1, 0.2, 0.5, 1)
    tree.links.new(coordinates.outputs["UV"], checks.inputs["Vector"])
    tree.links.new(checks.outputs["Color"], node.inputs["Color"])
    ramped, node = material("ramp", Color=(1, 1, 1))
    tree = ramped.node_tree
    ramp, image = tree.nodes.new("ShaderNodeValToRGB"), tree.nodes.new("ShaderNodeTexImage")
    image.image = bricks
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.1, 0.4, 0.1, 1), (0.9, 0.8, 0.7, 1)
    tree.links.new(image.outputs["Color"], ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], node.inputs["Color"])
    add("plane", checked, size=6)
    add("plane", painted, (0, 3, 3), size=6).rotation_euler = (math.pi / 2, 0, 0)
    add("plane", ramped, (-3, 0, 3), size=6).rotation_euler = (0, math.pi / 2, 0)
    add("plane", painted, (3, 0, 3), size=6).rotation_euler = (0, -math.pi / 2, 0)
    lamp("AREA", (0, 0, 5), 200, size=2, shape="SQUARE")
    camera((0, -10, 3), (0, 0, 2.7), lens=35)


def instances():
    """A collection with many instances, and linked copies."""
    scene = clear()
    floor((0.5, 0.5, 0.4), 30)
    world_colour((0.6, 0.7, 0.9))
    lamp("SUN", (0, 0, 5), 2, (2, 3, 0), angle=0)
    tree = bpy.data.collections.new("Tree")
    crown = add("ico_sphere", material("crown", Color=(0.2, 0.5, 0.15))[0], (0, 0, 1.4), True, subdivisions=2, radius=0.6)
    trunk = add("cylinder", material("trunk", Color=(0.4, 0.25, 0.1))[0], (0, 0, 0.5), radius=0.15, depth=1)
    for one in (crown, trunk):
        tree.objects.link(one)
        scene.collection.objects.unlink(one)
    for i in range(49):
        empty = bpy.data.objects.new(f"Place {i}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", tree
        empty.location = (2 * (i % 7 - 3), 2 * (i // 7 - 3), 0)
        empty.rotation_euler, empty.scale = (0, 0, i), (1 + 0.3 * math.sin(i),) * 3
        scene.collection.objects.link(empty)
    camera((0, -13, 8), (0, 0, 0.5), lens=35)


def hair():
    """A ball with hair of particles."""
    clear()
    floor()
    world_colour((0.7, 0.7, 0.7))
    lamp("AREA", (2, -3, 5), 300, size=2, shape="SQUARE")
    skin, fibre = material("skin", Color=(0.7, 0.5, 0.4))[0], material("fibre", Color=(0.3, 0.2, 0.1))[0]
    ball = add("uv_sphere", skin, (0, 0, 1.2), True, segments=32, ring_count=16)
    ball.data.materials.append(fibre)
    system = ball.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system
    settings = system.settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", 800, 0.5, 3
    settings.material, settings.root_radius, settings.tip_radius, settings.radius_scale = 2, 1, 0.5, 0.02
    camera((0, -6, 3), (0, 0, 1.1), lens=45)


def volumes():
    """Scattering fog, and an absorbing ball."""
    clear()
    floor()
    world_colour((0.6, 0.7, 0.8))
    lamp("AREA", (0, -2, 6), 500, size=2, shape="SQUARE")
    add("cube", material("fog", "ShaderNodeVolumeScatter", Color=(0.8, 0.9, 0.8), Density=0.8, Anisotropy=0.3)[0],
        (-1.6, 0, 1.1), size=2)
    add("uv_sphere", material("ink", "ShaderNodeVolumeAbsorption", Color=(0.2, 0.5, 0.9), Density=0.7)[0], (1.6, 0, 1.2), True,
        segments=32, ring_count=16)
    camera((0, -8, 4), (0, 0, 0.8), lens=40)


def depth_of_field():
    """A row of cubes with the middle one in focus."""
    clear()
    floor((0.5, 0.5, 0.5), 40)
    world_colour((0.4, 0.5, 0.6))
    lamp("SUN", (0, 0, 5), 2, (2, 3, -4), angle=0)
    for i in range(5):
        add("cube", material(f"cube {i}", Color=(0.8 - 0.15 * i, 0.2 + 0.1 * i, 0.2))[0], (i - 2, 2.5 * i - 5, 0.5), size=1)
    place = camera((0, -9, 3), (0, 0, 0.5), lens=60)
    dof = place.data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop, dof.aperture_blades = True, 9, 0.1, 6


def motion():
    """A moving cube and a static camera."""
    scene = clear()
    floor()
    world_colour((0.3, 0.3, 0.3))
    lamp("SUN", (0, 0, 5), 2, (1, 2, -4), angle=0)
    cube = add("cube", material("cube", Color=(0.8, 0.4, 0.1))[0], (-2, 0, 1), size=1.2)
    cube.keyframe_insert("location", frame=1)
    cube.location = (2, 0, 1)
    cube.keyframe_insert("location", frame=3)
    for curve in cube.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1
    scene.frame_set(2)
    camera((0, -7, 4), (0, 0, 0.7), lens=35)


ALL = (default_cube, glass_and_caustic, every_lamp, every_material, textured_room, instances, hair, volumes, depth_of_field,
       motion)
