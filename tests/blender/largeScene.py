"""Runs in Blender: writes a large scene by the add-on, and prints the time as JSON.

blender -b --factory-startup --python largeScene.py -- ADD-ON-FOLDER OUTPUT-FOLDER TRIANGLES INSTANCES
"""
import json
import math
import os
import sys
import time

sys.dont_write_bytecode = True
ADDON, OUTPUT, TRIANGLES, INSTANCES = sys.argv[sys.argv.index("--") + 1:]
sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), ADDON]

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import recurse_blender  # noqa: E402
import scenes  # noqa: E402
from recurse_blender.export import Exporter  # noqa: E402


def grid(name, side, size, height):
    """A mesh of side x side quadrilaterals, with smooth normals."""
    x, y = np.meshgrid(np.linspace(-size, size, side + 1), np.linspace(-size, size, side + 1))
    points = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3).astype(np.float32)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    corners = np.stack([first, first + 1, first + side + 2, first + side + 1], axis=-1).astype(np.int32)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.loops.add(corners.size)
    mesh.loops.foreach_set("vertex_index", corners.ravel())
    mesh.polygons.add(len(corners))
    mesh.polygons.foreach_set("loop_start", np.arange(0, corners.size, 4, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(corners), 4, np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(corners), bool))
    mesh.update(calc_edges=True)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    return made


def main():
    """Hills, and an object at each vertex of a mesh."""
    scenes.clear()
    recurse_blender.register()
    scenes.world_colour((0.7, 0.8, 1))
    grid("hills", int(math.sqrt(int(TRIANGLES) / 2)), 50, lambda x, y: np.sin(x) * np.cos(y))
    side = int(math.sqrt(int(INSTANCES))) - 1
    places = grid("places", side, 49, lambda x, y: np.sin(x) * np.cos(y) + 0.2)
    places.instance_type = "VERTS"
    places.show_instancer_for_render = places.show_instancer_for_viewport = False
    ball = scenes.add("ico_sphere", scenes.material("ball", Color=(0.7, 0.3, 0.2))[0], radius=0.1)
    ball.parent = places
    scenes.camera((0, -60, 30), (0, 0, 0))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    out = {"instances": sum(1 for instance in depsgraph.object_instances if instance.is_instance)}
    for name in ("first", "again"):
        start, processor = time.time(), time.process_time()
        exporter = Exporter(depsgraph, OUTPUT, (64, 48))
        text = exporter.write()
        with open(os.path.join(OUTPUT, "scene.pbrt"), "w", encoding="utf-8") as file:
            file.write(text)
        out[name] = {"seconds": time.time() - start, "processor": time.process_time() - processor}
    with open(os.path.join(OUTPUT, "seconds.json"), "w", encoding="utf-8") as file:
        json.dump(out, file)


try:
    main()
except BaseException:
    import traceback
    traceback.print_exc()
    sys.exit(1)
