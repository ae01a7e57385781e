"""The render engine: writes the scene, runs the program `recurse`, and reads the image."""
import os
import queue
import shutil
import signal
import subprocess
import tempfile
import threading
import traceback

import bpy
import numpy as np

from . import film
from .exr import read_exr
from .export import Exporter
from .progress import read_progress

FAR = 1e10  # depth of the background, as in Blender


def program():
    """Path of the program: from the preferences, RECURSE, the add-on's folder or PATH. Raises FileNotFoundError."""
    addon = bpy.context.preferences.addons.get(__package__)
    own = os.path.join(os.path.dirname(__file__), "bin", "recurse")
    for path in (addon.preferences.program if addon and addon.preferences else "", os.environ.get("RECURSE", ""), own):
        if path and os.path.isfile(bpy.path.abspath(path)):
            return bpy.path.abspath(path)
    found = shutil.which("recurse")
    if not found:
        raise FileNotFoundError("the program 'recurse' was not found: set its path in the preferences of the add-on")
    return found


class Frame:
    """Size and rendered region of the image. Blender's result contains the region only, and places it itself."""

    def __init__(self, render):
        scale = render.resolution_percentage / 100
        self.size = max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale))
        self.crop, self.rendered = None, self.size
        if not render.use_border:
            return
        width, height = self.size
        x0, x1 = int(render.border_min_x * width), int(round(render.border_max_x * width))
        y0, y1 = int(render.border_min_y * height), int(round(render.border_max_y * height))
        x1, y1 = max(x1, x0 + 1), max(y1, y0 + 1)
        self.rendered = x1 - x0, y1 - y0
        edges = ((x0, width), (x1, width), (height - y1, height), (height - y0, height))
        # The program rounds the edges up to whole pixels.
        self.crop = [max(0, (pixel - 0.5) / size) for pixel, size in edges]


class RecurseRenderEngine(bpy.types.RenderEngine):
    """Renders by the program `recurse`."""

    bl_idname = "RECURSE"
    bl_label = "Recurse"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    bl_use_postprocess = True

    _folder = None
    _shines = False  # whether an object of the scene visibly emits light

    @classmethod
    def folder(cls):
        """Folder of this Blender session, so that unchanged meshes are written once."""
        if not cls._folder or not os.path.isdir(cls._folder):
            cls._folder = tempfile.mkdtemp(prefix="recurse_", dir=bpy.app.tempdir)
        return cls._folder

    # Passes

    @staticmethod
    def extra_passes(scene, layer):
        """Additional passes: name, letters, kind, and layer of the program's image."""
        settings = scene.recurse
        out = []
        if settings.use_albedo:
            out.append(("Albedo", "RGB", "COLOR", "albedo"))
        for kind in ("object", "material"):
            if getattr(layer, f"use_pass_cryptomatte_{kind}"):
                out += [(f"Crypto{kind.title()}{i:02}", "RGBA", "COLOR", f"Crypto{kind.title()}{i:02}") for i in range(3)]
        return out + [(name, "RGB", "COLOR", name) for name, _ in settings.class_list()]

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        if renderlayer.use_pass_z:
            self.register_pass(scene, renderlayer, "Depth", 1, "Z", "VALUE")
        if renderlayer.use_pass_normal:
            self.register_pass(scene, renderlayer, "Normal", 3, "XYZ", "VECTOR")
        for name, letters, kind, _ in self.extra_passes(scene, renderlayer):
            self.register_pass(scene, renderlayer, name, len(letters), letters, kind)

    # Rendering

    def render(self, depsgraph):
        try:
            self._render(depsgraph)
        except (OSError, ValueError, RuntimeError) as error:
            self._fail(str(error))
        except Exception as error:  # a bug of the add-on: its traceback goes to the console
            traceback.print_exc()
            self._fail(f"{type(error).__name__}: {error}")

    def _fail(self, text):
        self.report({"ERROR"}, text)
        self.error_set(text)

    def _render(self, depsgraph):
        scene, layer = depsgraph.scene, depsgraph.view_layer
        frame = Frame(scene.render)
        folder = self.folder()
        self.update_stats("", "Recurse: writing the scene")
        exporter = Exporter(depsgraph, folder, frame.size, frame.crop)
        file = os.path.join(folder, "scene.pbrt")
        text = exporter.write(lambda number, part: self.frame_set(number, subframe=part))
        with open(file, "w", encoding="utf-8") as out:
            out.write(text)
        for warning in exporter.warnings.texts:
            self.report({"WARNING"}, warning)
        self._shines = exporter.shines
        picture = os.path.join(folder, "picture.exr")
        if os.path.exists(picture):
            os.remove(picture)
        layers = [name for name, wanted in (
            (film.LAYER, scene.render.film_transparent and not layer.use_pass_cryptomatte_object),
            ("depth", layer.use_pass_z), ("normal", layer.use_pass_normal), ("albedo", scene.recurse.use_albedo),
            ("cryptoobject", layer.use_pass_cryptomatte_object),
            ("cryptomaterial", layer.use_pass_cryptomatte_material)) if wanted]
        command = [program(), "render", file, "-o", picture, "--progress", "json", *scene.recurse.options()]
        if scene.render.film_transparent:
            command += ["--class", film.CLASS]
        if layers:
            command += ["--layers", ",".join(layers)]
        if self._run(command, folder) and os.path.exists(picture):
            self._show(read_exr(picture), frame, scene, layer)

    def _run(self, command, folder):
        """Runs the program. Returns whether it ended without an error."""
        lines = queue.Queue()
        with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, cwd=folder, text=True,
                              errors="replace") as process:
            def read():
                for line in process.stderr:
                    lines.put(line.rstrip("\n"))

            reader = threading.Thread(target=read, daemon=True)
            reader.start()
            told = []
            try:
                self._watch(process, reader, lines, told)
            except BaseException:
                process.kill()
                raise
        if process.returncode not in (0, 130):
            self._fail("\n".join(told) or f"recurse ended with status {process.returncode}")
            return False
        return True

    def _watch(self, process, reader, lines, told):
        """Shows the program's progress and messages until it has ended."""
        is_ending = False
        while process.poll() is None or reader.is_alive() or not lines.empty():
            if self.test_break() and not is_ending:
                process.send_signal(signal.SIGINT)  # the program then writes its image
                is_ending = True
            try:
                self._tell(lines.get(timeout=0.1), told)
            except queue.Empty:
                pass

    def _tell(self, line, told):
        if line.startswith("{"):
            progress = read_progress(line)
            if progress:
                self.update_progress(progress[0])
                self.update_stats("", progress[1])
        elif "warning:" in line:
            self.report({"WARNING"}, line)
        elif line and "seconds" not in line:
            told.append(line)

    def _show(self, channels, frame, scene, layer):
        """Fills the passes of Blender's result, whose rows begin at the bottom."""
        def stacked(names):
            return np.stack([channels[name] for name in names], axis=-1)[::-1]

        if scene.render.film_transparent:
            colours, opacity = film.without_background(channels, self._shines)
        else:
            colours, opacity = np.stack([channels[c] for c in "RGB"], axis=-1), np.ones_like(channels["R"])
        passes = {"Combined": np.concatenate([colours, opacity[..., None]], axis=-1)[::-1]}
        if "depth.Z" in channels:
            distance = stacked(["depth.Z"])
            passes["Depth"] = np.where(distance > 0, distance, FAR)
        if "normal.X" in channels:
            passes["Normal"] = stacked(["normal.X", "normal.Y", "normal.Z"])
        for name, letters, _, source in self.extra_passes(scene, layer):
            if f"{source}.{letters[0]}" in channels:
                self.add_pass(name, len(letters), letters, layer=layer.name)
                passes[name] = stacked([f"{source}.{letter}" for letter in letters])
        result = self.begin_result(0, 0, *frame.rendered, layer=layer.name)
        for one in result.layers[0].passes:
            if one.name in passes:
                pixels = np.ascontiguousarray(passes[one.name], np.float32)
                one.rect.foreach_set(pixels.reshape(-1, pixels.shape[-1]))
        self.end_result(result)


class RECURSE_OT_write_scene(bpy.types.Operator):
    """Writes the scene as a file for the program, and opens its folder"""

    bl_idname = "recurse.write_scene"
    bl_label = "Write Scene File"

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", default="scene.pbrt")
    open_folder: bpy.props.BoolProperty(name="Open Folder", default=True)

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        file = bpy.path.ensure_ext(bpy.path.abspath(self.filepath), ".pbrt")
        folder = os.path.dirname(os.path.abspath(file))
        frame = Frame(context.scene.render)
        try:
            exporter = Exporter(context.evaluated_depsgraph_get(), folder, frame.size, frame.crop)
            text = exporter.write()
        except (OSError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        with open(file, "w", encoding="utf-8") as out:
            out.write(text)
        for warning in exporter.warnings.texts:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, f"written: {file}")
        if self.open_folder and not bpy.app.background:
            bpy.ops.wm.path_open(filepath=folder)
        return {"FINISHED"}


CLASSES = (RecurseRenderEngine, RECURSE_OT_write_scene)
