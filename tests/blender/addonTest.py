"""Runs in Blender: tests of the add-on that do not need Cycles.

blender -b --factory-startup --python addonTest.py -- ADD-ON-FOLDER PROGRAM
"""
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

sys.dont_write_bytecode = True
ADDON, PROGRAM = sys.argv[sys.argv.index("--") + 1:][:2]
sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), ADDON]

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import recurse_blender  # noqa: E402
import scenes  # noqa: E402
from recurse_blender.export import Exporter  # noqa: E402
from recurse_blender.exr import read_exr  # noqa: E402
from recurse_blender.progress import read_progress  # noqa: E402

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
        """Text and warnings of the current scene, which the program must accept."""
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

    def test_progress_lines_of_any_kind_are_read(self):
        self.assertEqual(read_progress('{"phase": "render", "fraction": 0.25, "seconds_left": 7.4, "samples_per_pixel": 2}'),
                         (0.25, "Recurse: render, 2 samples, 7 s left"))
        # The remaining time is null if it is unknown.
        self.assertEqual(read_progress('{"phase": "photons", "fraction": 0, "seconds_left": null, "samples_per_pixel": 0}'),
                         (0, "Recurse: photons"))
        self.assertEqual(read_progress('{"fraction": 2, "phase": null, "samples_per_pixel": null}'), (1, "Recurse: render"))
        for line in ("{", "[]", "{}", '{"fraction": null}', '{"fraction": "half"}', '{"fraction": NaN}', "1"):
            self.assertIsNone(read_progress(line), line)

    def test_the_default_integrator_renders_while_the_time_left_is_not_known(self):
        scenes.default_cube()
        scene = self.small()
        scene.recurse.property_unset("integrator")
        self.assertEqual(scene.recurse.integrator, "photonmap")
        slow = os.path.join(self.folder, "slow")
        with open(slow, "w", encoding="utf-8") as out:
            out.write("#!/bin/sh\n"
                      """echo '{"phase": "photons", "fraction": 0, "seconds_left": null, "samples_per_pixel": 0}' >&2\n"""
                      f"echo '{{\"fraction\": null}}' >&2\nexec '{PROGRAM}' \"$@\"\n")
        os.chmod(slow, 0o700)
        with unittest.mock.patch.dict(os.environ, RECURSE=slow):
            channels = self.rendered()
        green = next(values for name, values in channels.items() if name.endswith("Combined.G"))
        self.assertGreater(green.mean(), 0.01)

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

    def test_transparent_films_have_objects_alone(self):
        """The picture with alpha, composited over its background, is the picture with background."""
        scenes.clear()
        scenes.world_colour((0.5, 1, 2))
        scenes.add("cube", scenes.material("grey", Color=(0.5, 0.5, 0.5))[0])
        scenes.camera((0, -7, 0), (0, 0, 0))
        scene = self.small()
        scene.recurse.samples = 64
        opaque, clear = {}, {}
        for is_clear, found in ((False, opaque), (True, clear)):
            scene.render.film_transparent = is_clear
            for name, values in self.rendered().items():
                found[name.rpartition(".")[2]] = values
        self.assertEqual(opaque["A"].min(), 1)
        self.assertEqual((clear["A"][24, 32], clear["A"][0, 0]), (1, 0))
        self.assertLess(abs(clear["A"].mean() - np.mean(clear["A"] > 0.5)), 0.01)
        for letter, background in zip("RGB", (0.5, 1, 2)):
            self.assertAlmostEqual(float(clear[letter][0, 0]), 0, places=5)
            np.testing.assert_allclose(clear[letter][20:28, 28:36], opaque[letter][20:28, 28:36], rtol=1e-4)
            over = clear[letter] + (1 - clear["A"]) * background
            self.assertLess(np.abs(over - opaque[letter]).max() / background, 0.15)

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
        cells = made.node_tree.nodes.new("ShaderNodeTexVoronoi")
        cells.name = "My Cells"
        made.node_tree.links.new(cells.outputs["Color"], node.inputs["Color"])
        scenes.add("cube", made)
        cloudy, node = scenes.material("cloud", Color=(1, 1, 1))
        noise = cloudy.node_tree.nodes.new("ShaderNodeTexNoise")
        cloudy.node_tree.links.new(noise.outputs["Color"], node.inputs["Color"])
        scenes.add("cube", cloudy)
        scenes.add("cube", scenes.material("velvet", "ShaderNodeBsdfVelvet")[0])
        scenes.camera((0, -5, 0), (0, 0, 0))
        _, exporter, _ = self.checked()
        told = "\n".join(exporter.warnings.texts)
        self.assertIn("stone: the node 'My Cells' (Voronoi Texture)", told)
        self.assertIn("cloud: the generated coordinates of 'Noise Texture'", told)
        self.assertIn("velvet: the shader 'Velvet BSDF'", told)

    def test_averaged_inputs_are_named(self):
        """Inputs without textures, each of a node with its own name."""
        cases = [("ShaderNodeBsdfPrincipled", name) for name in
                 ("Metallic", "Transmission", "Emission", "Emission Strength", "Specular", "IOR", "Clearcoat",
                  "Clearcoat Roughness")]
        cases += [("ShaderNodeBsdfGlass", "Color"), ("ShaderNodeBsdfTransparent", "Color"), ("ShaderNodeEmission", "Color"),
                  ("ShaderNodeVolumeScatter", "Density"), ("ShaderNodeNormalMap", "Strength"), ("ShaderNodeBump", "Distance")]
        for kind, name in cases:
            with self.subTest(kind, input=name):
                scenes.clear()
                varied = bpy.data.materials.new("varied")
                varied.use_nodes = True
                tree = varied.node_tree
                tree.nodes.clear()
                node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
                node.name = "My Node"
                image = tree.nodes.new("ShaderNodeTexImage")
                image.image = scenes.picture("stripes", lambda u, v: np.stack([u, u, u], axis=-1))
                tree.links.new(image.outputs["Color"], node.inputs[name])
                if kind == "ShaderNodeBsdfPrincipled":
                    node.inputs["Clearcoat"].default_value = node.inputs["Transmission"].default_value = 0.5
                shader = node
                if kind in ("ShaderNodeNormalMap", "ShaderNodeBump"):
                    tree.links.new(image.outputs["Color"], node.inputs["Color" if "Map" in kind else "Height"])
                    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
                    tree.links.new(node.outputs["Normal"], shader.inputs["Normal"])
                tree.links.new(shader.outputs[0], output.inputs["Volume" if "Volume" in kind else "Surface"])
                scenes.add("plane", varied)
                scenes.camera((0, 0, 3), (0, 0, 0))
                _, exporter = self.exported()
                named = [text for text in exporter.warnings.texts if f"varied: '{name}' of 'My Node'" in text]
                self.assertEqual(len(named), 1, exporter.warnings.texts)

    def test_textures_of_the_world_and_of_lamps_are_named(self):
        scenes.default_cube()
        trees = [(bpy.context.scene.world.node_tree, "Background", "Strength"), (bpy.data.lights[0], "Emission", "Color")]
        bpy.data.lights[0].use_nodes = True
        for owner, node, name in trees:
            tree = getattr(owner, "node_tree", owner)
            image = tree.nodes.new("ShaderNodeTexImage")
            image.image = scenes.picture("stripes", lambda u, v: np.stack([u, u, u], axis=-1))
            tree.links.new(image.outputs["Color"], tree.nodes[node].inputs[name])
        _, exporter, _ = self.checked()
        told = "\n".join(exporter.warnings.texts)
        self.assertIn("the world: 'Strength' of 'Background'", told)
        self.assertIn("Point: 'Color' of 'Emission'", told)

    def test_node_groups_are_looked_through(self):
        """A material of nested groups with an input: the text is the same without groups."""
        texts = []
        for depth in range(3):
            scenes.clear()
            made, node = scenes.material("grouped", Color=(0.1, 0.1, 0.1))
            tree = made.node_tree
            image = tree.nodes.new("ShaderNodeTexImage")
            image.image = scenes.picture("stripes", lambda u, v: np.stack([u, v, u], axis=-1))
            invert = tree.nodes.new("ShaderNodeInvert")
            invert.inputs["Fac"].default_value = 0.75
            tree.links.new(image.outputs["Color"], invert.inputs["Color"])
            if depth == 0:
                tree.links.new(invert.outputs[0], node.inputs["Color"])
            else:
                self.grouped(tree, node, invert, depth)
            scenes.add("plane", made)
            scenes.camera((0, 0, 3), (0, 0, 0))
            text, exporter, _ = self.checked()
            self.assertEqual(exporter.warnings.texts, [])
            texts.append(text.replace("Group.001", "Invert").replace("Group", "Invert"))
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(texts[0], texts[2])

    @staticmethod
    def grouped(tree, node, invert, depth):
        """Moves the shader, and the inversion of its colour, into nested groups with the inputs factor and colour."""
        image = invert.inputs["Color"].links[0].from_socket
        group = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        group.inputs.new("NodeSocketFloat", "Factor")
        group.inputs.new("NodeSocketColor", "Tint")
        group.outputs.new("NodeSocketShader", "Shader")
        begin, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        shader, inner = group.nodes.new("ShaderNodeBsdfDiffuse"), group.nodes.new("ShaderNodeInvert")
        reroute = group.nodes.new("NodeReroute")
        group.links.new(begin.outputs["Factor"], inner.inputs["Fac"])
        group.links.new(begin.outputs["Tint"], reroute.inputs[0])
        group.links.new(reroute.outputs[0], inner.inputs["Color"])
        group.links.new(inner.outputs[0], shader.inputs["Color"])
        group.links.new(shader.outputs[0], end.inputs["Shader"])
        for _ in range(depth - 1):
            outer = bpy.data.node_groups.new("outer", "ShaderNodeTree")
            outer.inputs.new("NodeSocketFloat", "Factor")
            outer.inputs.new("NodeSocketColor", "Tint")
            outer.outputs.new("NodeSocketShader", "Shader")
            begin, end, use = (outer.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "ShaderNodeGroup"))
            use.node_tree = group
            for name in ("Factor", "Tint"):
                outer.links.new(begin.outputs[name], use.inputs[name])
            outer.links.new(use.outputs[0], end.inputs[0])
            group = outer
        use = tree.nodes.new("ShaderNodeGroup")
        use.node_tree = group
        use.inputs["Factor"].default_value = 0.75
        tree.links.new(image, use.inputs["Tint"])
        tree.links.new(use.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        tree.nodes.remove(node)
        tree.nodes.remove(invert)

    def test_metaballs_are_metaballs(self):
        """The field of the file's balls has the threshold value on Blender's own surface."""
        scenes.clear()
        for i, (place, settings) in enumerate((((0, 0, 0), {}), ((1.3, 0.2, 0.1), {"radius": 1.5, "stiffness": 3}),
                                               ((0.5, 0.9, 0), {"radius": 0.8, "use_negative": True}))):
            data = bpy.data.metaballs.new("Drop")
            data.resolution = data.render_resolution = 0.05
            element = data.elements.new()
            for name, value in settings.items():
                setattr(element, name, value)
            drop = bpy.data.objects.new("Drop" if i == 0 else f"Drop.{i:03}", data)
            drop.location, drop.scale = place, (1 + 0.2 * i,) * 3
            bpy.context.collection.objects.link(drop)
        scenes.camera((0, -6, 0), (0, 0, 0))
        text, exporter, _ = self.checked()
        self.assertEqual(exporter.warnings.texts, [])
        self.assertEqual(text.count("Shape"), 1, text)
        line = next(line for line in text.split("\n") if "metaballs" in line)
        centres, radii, strengths = (np.array(line.split(f'{name}" [')[1].split("]")[0].split(), float)
                                     for name in ("P", "radius", "strength"))
        threshold = float(line.split('threshold" ')[1].split()[0])
        shown = bpy.data.objects["Drop"].evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        points = np.array([vertex.co[:] for vertex in shown.vertices])
        self.assertGreater(len(points), 100)
        q = ((points[:, None] - centres.reshape(-1, 3)) ** 2).sum(axis=2) / radii ** 2
        field = (np.clip(1 - q, 0, 1) ** 3 * strengths).sum(axis=1)
        self.assertLess(np.abs(field - threshold).max(), 0.02)
        bpy.data.metaballs[0].elements[0].type = "ELLIPSOID"
        text, exporter, _ = self.checked()
        self.assertIn("plymesh", text)
        self.assertIn("Drop: metaballs other than balls", "\n".join(exporter.warnings.texts))

    def test_curves_and_text_are_there_once(self):
        scenes.clear()
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
        bpy.ops.object.text_add()
        text = bpy.context.object
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
        group = bpy.data.collections.new("Words")
        group.objects.link(text)
        bpy.context.scene.collection.objects.unlink(text)
        for i in range(2):
            place = bpy.data.objects.new("Place", None)
            place.instance_type, place.instance_collection, place.location.x = "COLLECTION", group, i
            bpy.context.scene.collection.objects.link(place)
        scenes.camera((0, -6, 0), (0, 0, 0))
        written, exporter = self.exported()
        self.assertEqual(exporter.warnings.texts, [])
        self.assertEqual(written.count('Shape "plymesh"'), 3)
        self.assertEqual(written.count("ObjectInstance"), 2)

    def test_volumes_are_read_from_files_beside_them(self):
        scenes.clear()
        data = bpy.data.volumes.new("smoke")
        data.filepath = os.path.join(self.folder, "smoke.vdb")
        smoke = bpy.data.objects.new("Smoke", data)
        smoke.location.x = 5
        bpy.context.collection.objects.link(smoke)
        scenes.camera((0, -6, 0), (0, 0, 0))
        text, exporter = self.exported()
        self.assertIn("Smoke: the volume has no shader", "\n".join(exporter.warnings.texts))
        data.materials.append(scenes.material("fog", "ShaderNodeVolumePrincipled", Density=3.0, Color=(0.5, 0.5, 0.5))[0])
        with unittest.mock.patch("shutil.which", return_value=None):
            text, exporter = self.exported()
        self.assertIn("smoke.nvdb", "\n".join(exporter.warnings.texts))
        self.assertNotIn("nanovdb", text)
        entries = [b"\0" * 40 + struct.pack("<6d", *box) + b"\0" * 48 + struct.pack("<I", 8) + b"\0" * 36 + b"density\0"
                   for box in ((-1, -2, -3, 1, 2, 3), (-1, -1, -1, 4, 1, 1))]
        with open(os.path.join(self.folder, "smoke.nvdb"), "wb") as out:
            out.write(b"NanoVDB0" + struct.pack("<IHH", 32 << 21, len(entries), 0) + b"".join(entries))
        text, exporter = self.exported()
        self.assertEqual(exporter.warnings.texts, [])
        lines = text.split("\n")
        at = next(i for i, line in enumerate(lines) if '"nanovdb"' in line)
        self.assertIn('"rgb sigma_s" [ 1.5 1.5 1.5 ]', lines[at])
        self.assertIn("5 0 0 1 ]", lines[at - 1])
        lower, upper = (np.array(lines[at + 3].split(f'{name}" [')[1].split("]")[0].split(), float) for name in ("p1", "p2"))
        np.testing.assert_allclose(lower, (-1, -2, -3), atol=0.2)
        np.testing.assert_allclose(upper, (4, 2, 3), atol=0.2)
        self.assertTrue((lower < (-1, -2, -3)).all() and (upper > (4, 2, 3)).all())

    def test_noise_over_uv_is_blenders(self):
        """The baked values, and the values of Cycles from a picture of a plane."""
        scenes.clear()
        made, node = scenes.material("stone", "ShaderNodeEmission", Strength=1.0)
        tree = made.node_tree
        noise, coordinates = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeTexCoord")
        for name, value in (("Scale", 3), ("Detail", 2.5), ("Roughness", 0.6)):
            noise.inputs[name].default_value = value
        tree.links.new(coordinates.outputs["UV"], noise.inputs["Vector"])
        scenes.add("plane", made, size=2)
        scenes.camera((0, 0, 3), (0, 0, 0), type="ORTHO", ortho_scale=2)
        scene = self.small()
        scene.render.resolution_x = scene.render.resolution_y = 32
        scene.render.engine = "CYCLES"
        scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 64, False
        scene.cycles.pixel_filter_type = "BOX"
        u, v = np.meshgrid((np.arange(256) + 0.5) / 256, (np.arange(256) + 0.5) / 256)
        from recurse_blender.nodes import Node
        from recurse_blender.textures import Evaluation
        for output in ("Fac", "Color"):
            tree.links.new(noise.outputs[output], node.inputs["Color"])
            channels = {name.rpartition(".")[2]: values for name, values in self.rendered().items() if "Combined" in name}
            expected = np.stack([channels[letter] for letter in "RGB"], axis=-1)[::-1]
            baked = Evaluation(u, v).colour(Node(node).inputs["Color"])[..., :3]
            baked = baked.reshape(32, 8, 32, 8, 3).mean(axis=(1, 3))
            self.assertGreater(np.ptp(expected), 0.2)
            np.testing.assert_allclose(baked, expected, atol=0.004)

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
        """A lamp of a pixel's size is at the position of Blender's own camera model."""
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
        # Blender's panorama of a sky without rotation, looking along +y, is the sky rotated by 90 degrees.
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
    """Output files of the engine."""
    from recurse_blender.engine import RecurseRenderEngine
    return RecurseRenderEngine.folder()


recurse_blender.register()
outcome = unittest.main(argv=["addonTest"], exit=False, verbosity=2).result
sys.stdout.flush()
os._exit(0 if outcome.wasSuccessful() else 1)
