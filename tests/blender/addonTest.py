"""Runs in Blender: what of the add-on can be told without Cycles.

blender -b --factory-startup --python addonTest.py -- ADD-ON-FOLDER PROGRAM
"""
import math
import os
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ADDON, PROGRAM = sys.argv[sys.argv.index("--") + 1:][:2]
sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), ADDON]

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import recurse_blender  # noqa: E402
import scenes  # noqa: E402
from recurse_blender.export import Exporter  # noqa: E402
from recurse_blender.exr import read_exr  # noqa: E402

os.environ["RECURSE"] = PROGRAM


class Addon(unittest.TestCase):
    """Each test begins with an empty scene."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def small(self):
        """Settings for a quick picture of the current scene."""
        scene = bpy.context.scene
        scene.render.engine = "RECURSE"
        scene.recurse.integrator, scene.recurse.samples = "path", 2
        image = scene.render.image_settings
        image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR_MULTILAYER", "32", "ZIP"
        scene.render.filepath = os.path.join(self.folder, "picture.exr")
        return scene

    def rendered(self):
        """Channels of the current scene's picture."""
        bpy.ops.render.render(write_still=True)
        return read_exr(bpy.context.scene.render.filepath)

    def exported(self):
        """Text and warnings of the current scene."""
        exporter = Exporter(bpy.context.evaluated_depsgraph_get(), self.folder, (64, 48))
        return exporter.write(), exporter

    def checked(self):
        """The same, taken by the program."""
        text, exporter = self.exported()
        file = os.path.join(self.folder, "scene.pbrt")
        with open(file, "w", encoding="utf-8") as out:
            out.write(text)
        done = subprocess.run([PROGRAM, "render", file, "--check"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return text, exporter, done.stdout

    def test_passes_are_in_the_picture(self):
        scenes.default_cube()
        scene, layer = self.small(), bpy.context.view_layer
        layer.use_pass_z = layer.use_pass_normal = layer.use_pass_cryptomatte_object = True
        scene.recurse.use_albedo = True
        scene.recurse.classes = "seen=LE; lit=LD+E"
        channels = self.rendered()
        names = {name.split(".", 1)[1]: values for name, values in channels.items()}
        for name in ("Combined.R", "Depth.Z", "Normal.X", "Albedo.R", "seen.R", "lit.B", "CryptoObject00.R"):
            self.assertIn(name, names)
        np.testing.assert_allclose(names["seen.G"] + names["lit.G"], names["Combined.G"], rtol=1e-4, atol=1e-6)
        self.assertGreater(names["lit.G"].mean(), 0.01)
        self.assertAlmostEqual(float(names["Albedo.G"].max()), 0.8, places=4)
        floor = names["Normal.Z"][-2, 32]  # below the cube
        self.assertAlmostEqual(float(floor), 1, places=4)
        centre = math.sqrt(7.36 ** 2 + 6.93 ** 2 + 4.96 ** 2)
        self.assertLess(abs(float(names["Depth.Z"][24, 32]) - (centre - 1.3)), 0.5)

    def test_the_border_is_rendered_where_it_is(self):
        scenes.default_cube()
        scene = self.small()
        whole = self.rendered()
        render = scene.render
        render.use_border, render.use_crop_to_border = True, False
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1
        part = self.rendered()
        red = [channels[next(name for name in channels if name.endswith("Combined.R"))] for channels in (whole, part)]
        np.testing.assert_allclose(red[1][:24, 16:48], red[0][:24, 16:48], rtol=1e-5)
        self.assertEqual(red[1][24:].max(), 0)
        render.use_crop_to_border = True
        cropped = self.rendered()
        red.append(cropped[next(name for name in cropped if name.endswith("Combined.R"))])
        self.assertEqual(red[2].shape, (24, 32))
        np.testing.assert_allclose(red[2], red[0][:24, 16:48], rtol=1e-5)

    def test_errors_of_the_program_are_told(self):
        scenes.default_cube()
        scene = self.small()
        scene.recurse.classes = "wrong=L("
        with self.assertRaisesRegex(RuntimeError, "column"):
            bpy.ops.render.render()

    def test_a_scene_without_camera_is_refused(self):
        scenes.clear()
        self.small()
        with self.assertRaisesRegex(RuntimeError, "camera"):
            bpy.ops.render.render()

    def test_nodes_without_counterpart_are_named(self):
        scenes.clear()
        made, node = scenes.material("stone", Color=(1, 1, 1))
        noise = made.node_tree.nodes.new("ShaderNodeTexNoise")
        noise.name = "My Noise"
        made.node_tree.links.new(noise.outputs["Color"], node.inputs["Color"])
        scenes.add("cube", made)
        scenes.add("cube", scenes.material("velvet", "ShaderNodeBsdfVelvet")[0])
        scenes.camera((0, -5, 0), (0, 0, 0))
        _, exporter, _ = self.checked()
        told = "\n".join(exporter.warnings.texts)
        self.assertIn("stone: the node 'My Noise' (Noise Texture)", told)
        self.assertIn("velvet: the shader 'Velvet BSDF'", told)

    def test_meshes_that_stay_are_not_written_again(self):
        scenes.instances()
        _, first = self.exported()
        self.assertGreater(first.folder.written, 0)
        text, second = self.exported()
        self.assertEqual(second.folder.written, 0)
        bpy.data.objects["Plane"].data.vertices[0].co.x += 1
        bpy.data.objects["Plane"].data.update()
        changed, third = self.exported()
        self.assertEqual(third.folder.written, 1)
        self.assertNotEqual(changed, text)
        self.assertEqual(changed.count("ObjectInstance"), 98)

    def test_cameras_of_every_kind_see_the_same_thing(self):
        """A lamp of a pixel's size is where Blender's own camera model says."""
        from bpy_extras.object_utils import world_to_camera_view
        from mathutils import Vector
        for kind, settings in (("PERSP", {"lens": 30, "shift_x": 0.1, "shift_y": -0.05}),
                               ("ORTHO", {"ortho_scale": 6, "shift_x": 0.1}), ("PERSP", {"sensor_fit": "VERTICAL"})):
            with self.subTest(kind, **settings):
                scenes.clear()
                place = Vector((0.7, 0.4, -0.3))
                scenes.add("uv_sphere", scenes.material("lamp", "ShaderNodeEmission", Strength=1.0)[0], place, radius=0.1)
                camera = scenes.camera((1, -5, 2), (0, 0, 0), type=kind, **settings)
                scene = self.small()
                scene.recurse.samples = 16
                bpy.context.view_layer.update()
                x, y, _ = world_to_camera_view(scene, camera, place)
                channels = self.rendered()
                red = channels[next(name for name in channels if name.endswith("Combined.R"))]
                rows, columns = np.indices(red.shape)
                self.assertLess(abs((red * (columns + 0.5)).sum() / red.sum() - 64 * x), 0.3)
                self.assertLess(abs((red * (rows + 0.5)).sum() / red.sum() - 48 * (1 - y)), 0.3)

    def test_panoramas_and_pictures_of_the_sky_are_the_right_way_round(self):
        scenes.clear()
        sky = bpy.data.images.new("sky", 64, 32, float_buffer=True)
        u, v = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(32) + 0.5) / 32)
        pixels = np.ones((32, 64, 4), np.float32)
        pixels[:, :, 0], pixels[:, :, 1], pixels[:, :, 2] = u, v, 0.5 + 0.5 * np.cos(2 * np.pi * u)
        sky.pixels.foreach_set(pixels.ravel())
        tree = bpy.context.scene.world.node_tree
        picture = tree.nodes.new("ShaderNodeTexEnvironment")
        picture.image = sky
        tree.links.new(picture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        # Blender's panorama of an untouched sky, looking along +y, is the sky turned by a quarter.
        camera = scenes.camera((0, 0, 0), (0, 1, 0), type="PANO")
        camera.data.cycles.panorama_type = "EQUIRECTANGULAR"
        scene = self.small()
        scene.recurse.samples = 8
        scene.render.resolution_x, scene.render.resolution_y = 64, 32
        channels = self.rendered()
        red, green = (channels[next(n for n in channels if n.endswith("Combined." + c))] for c in "RG")
        np.testing.assert_allclose(green[4:-4], 1 - v[4:-4], atol=0.05)
        expected = np.roll(u, 16, axis=1)
        away_from_seam = np.abs((np.arange(64) - 16 + 32) % 64 - 32) > 3
        np.testing.assert_allclose(red[4:-4, away_from_seam], expected[4:-4, away_from_seam], atol=0.06)

    def test_scene_files_are_written_by_a_button(self):
        scenes.textured_room()
        self.small()
        file = os.path.join(self.folder, "room.pbrt")
        bpy.ops.recurse.write_scene(filepath=file)
        done = subprocess.run([PROGRAM, "render", file, "--check"], capture_output=True, text=True, check=True)
        self.assertIn("rendered as the file says", done.stdout)

    def test_motion_is_in_the_file(self):
        scenes.motion()
        scene = self.small()
        bpy.ops.render.render()
        with open(os.path.join(scene_folder(), "scene.pbrt"), encoding="utf-8") as file:
            self.assertEqual(file.read().count("ActiveTransform EndTime"), 1)
        self.assertEqual(scene.frame_current, 2)


def scene_folder():
    """Where the engine writes."""
    from recurse_blender.engine import RecurseRenderEngine
    return RecurseRenderEngine.folder()


recurse_blender.register()
outcome = unittest.main(argv=["addonTest"], exit=False, verbosity=2).result
sys.stdout.flush()
os._exit(0 if outcome.wasSuccessful() else 1)
