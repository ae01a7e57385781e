"""Runs in Blender: renders scenes by Recurse and by Cycles, and writes both pictures and a JSON of their means.

blender -b --factory-startup --python compareCycles.py -- ADD-ON-FOLDER PROGRAM OUTPUT-FOLDER SAMPLES WIDTHxHEIGHT [SCENE ...]
"""
import json
import os
import sys
import time

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ADDON, PROGRAM, OUTPUT, SAMPLES, SIZE, *WANTED = sys.argv[sys.argv.index("--") + 1:]
sys.path[:0] = [HERE, ADDON]

import bpy  # noqa: E402
import recurse_blender  # noqa: E402
import scenes  # noqa: E402
from recurse_blender.exr import read_exr  # noqa: E402

os.environ["RECURSE"] = PROGRAM


def rendered(engine, name):
    """Channels of the picture, and the time of its render [s]."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.recurse.samples = int(SAMPLES)
    scene.recurse.integrator = "path"
    if engine == "CYCLES":
        cycles = scene.cycles
        cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", int(SAMPLES), False, False
        cycles.sample_clamp_indirect, cycles.blur_glossy, cycles.max_bounces = 0, 0, 64
        cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = cycles.volume_bounces = 64
        cycles.transparent_max_bounces = 64
    image = scene.render.image_settings
    image.file_format, image.color_depth, image.color_mode, image.exr_codec = "OPEN_EXR", "32", "RGB", "ZIP"
    scene.render.filepath = os.path.join(OUTPUT, f"{name}-{engine.lower()}.exr")
    start = time.time()
    bpy.ops.render.render(write_still=True)
    return read_exr(scene.render.filepath), time.time() - start


def main():
    """Renders each scene by both."""
    recurse_blender.register()
    os.makedirs(OUTPUT, exist_ok=True)
    results = {}
    for make in scenes.ALL:
        if WANTED and make.__name__ not in WANTED:
            continue
        make()
        render = bpy.context.scene.render
        render.resolution_x, render.resolution_y = map(int, SIZE.split("x"))
        pictures = {engine: rendered(engine, make.__name__) for engine in ("RECURSE", "CYCLES")}
        results[make.__name__] = {engine: {"means": [float(channels[c].mean()) for c in "RGB"], "seconds": seconds}
                                  for engine, (channels, seconds) in pictures.items()}
        means = [results[make.__name__][engine]["means"] for engine in ("RECURSE", "CYCLES")]
        print(make.__name__, "Recurse / Cycles:", " ".join(f"{a / b:.4f}" for a, b in zip(*means)), flush=True)
    with open(os.path.join(OUTPUT, "means.json"), "w", encoding="utf-8") as out:
        json.dump(results, out, indent=2)


try:
    main()
except BaseException:
    import traceback
    traceback.print_exc()
    sys.exit(1)
