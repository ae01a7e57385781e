#!/usr/bin/env python3
"""The Python module: recurseTest.py PACKAGE-FOLDER PROGRAM."""
import ast
import contextlib
import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
import warnings

import numpy as np

sys.path.insert(0, os.path.abspath(sys.argv[1]))
GUIDE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "doc-files", "guide", "python.md")
PROGRAM = os.path.abspath(sys.argv[2])
import recurse  # noqa: E402
from recurse import plug_ins  # noqa: E402

ROOM = """
Film "rgb" "integer xresolution" 24 "integer yresolution" 16
LookAt 0 1 -6  0 1 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 12 11 10 ]
  Translate 0 4 0
  Shape "sphere" "float radius" 0.5
AttributeEnd
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "bilinearmesh" "point3 P" [ -9 0 -9  9 0 -9  -9 0 9  9 0 9 ]
Material "dielectric" "float eta" 1.5
Translate 0 1 0
Shape "sphere" "float radius" 1
"""


def room() -> recurse.Scene:
    """The scene ROOM built in code."""
    scene = recurse.Scene()
    scene.set_film(xresolution=24, yresolution=16)
    scene.set_camera("perspective", fov=40, look_at=[(0, 1, -6), (0, 1, 0), (0, 1, 0)])
    scene.add_shape("sphere", radius=0.5, light=recurse.area_lights.diffuse(L=(12, 11, 10)),
                    transform=recurse.translate(0, 4, 0))
    scene.add_shape("bilinearmesh", P=[[-9, 0, -9], [9, 0, -9], [-9, 0, 9], [9, 0, 9]],
                    material=recurse.materials.diffuse(reflectance=(.7, .7, .7)))
    scene.add_shape("sphere", radius=1, material=recurse.materials.dielectric(eta=1.5),
                    transform=recurse.translate(0, 1, 0))
    return scene


class InFolder(unittest.TestCase):
    """A test with a temporary folder."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)


class SceneFiles(InFolder):
    def test_pictures_have_the_bits_of_the_command_line(self):
        with open("room.pbrt", "w", encoding="utf-8") as file:
            file.write(ROOM)
        for options, arguments in [
                (["--integrator", "path", "--spp", "2", "--seed", "3"], {"integrator": "path", "spp": 2, "seed": 3}),
                (["--photons", "5000", "--spp", "2", "--resolution", "20x10", "--layers", "depth", "--error-layer"],
                 {"photons": 5000, "passes": 0, "spp": 2, "resolution": (20, 10), "features": ["depth"], "error": True})]:
            subprocess.run([PROGRAM, "render", "room.pbrt", "-q", "-o", "cli.exr", *options], check=True)
            picture = recurse.load("room.pbrt").render(**arguments)
            expected = recurse.read("cli.exr")
            self.assertEqual(set(picture.layers), set(expected.layers))
            for name, layer in expected.layers.items():
                np.testing.assert_array_equal(picture.layers[name], layer, err_msg=name)
            picture.save("own.exr")
            np.testing.assert_array_equal(recurse.read("own.exr").array, expected.array)
            self.assertEqual(recurse.read("own.exr").metadata["recurse:scene"], "room.pbrt")

    def test_a_scene_in_code_is_the_scene_in_text(self):
        options = {"integrator": "path", "spp": 2}
        expected = recurse.parse(ROOM).render(**options).array
        np.testing.assert_array_equal(room().render(**options).array, expected)
        room().save("room.pbrt")
        np.testing.assert_array_equal(recurse.load("room.pbrt").render(**options).array, expected)

    def test_errors_have_their_place(self):
        text = ROOM.replace('"float radius" 1', '"float radios" 1').replace('"float eta"', '"float etta"')
        with self.assertRaises(recurse.SceneError) as caught:
            recurse.parse(text, name="wrong.pbrt")
        error = caught.exception
        line = text.split("\n").index([x for x in text.split("\n") if "etta" in x][0]) + 1
        self.assertEqual((error.file, error.line), ("wrong.pbrt", line))
        self.assertEqual(error.column, text.split("\n")[line - 1].index('"float etta"') + 1)
        self.assertEqual(len(error.errors), 2)
        self.assertIn("radius", error.errors[1]["accepted"] + error.errors[1]["message"])
        self.assertIn(f"wrong.pbrt:{line}:", str(error))
        with self.assertRaises(recurse.Error):
            recurse.load("nowhere.pbrt")
        with self.assertRaisesRegex(recurse.Error, "nointegrator"):
            room().render(integrator="nointegrator")
        with self.assertRaisesRegex(recurse.Error, "nothing"):
            room().render(integrator="path", nothing=3)
        with self.assertRaisesRegex(TypeError, "radios"):
            room().add_shape("sphere", radios=1)

    def test_warnings_are_those_of_python(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            recurse.parse(ROOM.replace("WorldBegin", 'Sampler "pmj02bn"\nWorldBegin'))
        self.assertTrue(any("Sobol" in str(w.message) for w in caught), caught)


class Renders(InFolder):
    def test_layers_of_classes_add_up_without_copies(self):
        picture = room().render("path", spp=4, classes={"emitted": "LE", "rest": "all - LE"})
        self.assertEqual(list(picture.layers), ["all", "emitted", "rest"])
        self.assertEqual(picture.array.shape, (16, 24, 3))
        np.testing.assert_allclose(picture.layers["emitted"] + picture.layers["rest"], picture.array, rtol=1e-5)
        self.assertGreater(picture.array.mean(), 0)
        self.assertFalse(picture.array.flags.owndata)
        self.assertTrue(np.may_share_memory(picture.array, picture.layers["rest"]))
        layer = picture.layers["rest"]
        before = layer.copy()
        del picture  # the array keeps the memory
        np.testing.assert_array_equal(layer, before)

    def test_statistics_are_those_of_the_program(self):
        picture = room().render("path", spp=2, threads=1)
        self.assertEqual(picture.statistics["samples"], 2 * 24 * 16)
        self.assertEqual(picture.statistics["threads"], 1)
        self.assertEqual(picture.statistics["stop_reason"], "samples")

    def test_the_number_of_threads_changes_nothing(self):
        scene = room()
        np.testing.assert_array_equal(scene.render(spp=2, photons=3000, passes=0, threads=1).array,
                                      scene.render(spp=2, photons=3000, passes=0, threads=2).array)

    def test_progress_can_end_a_render(self):
        told = []

        def progress(p):
            told.append(p)
            return p["samples_per_pixel"] < 1

        picture = room().render("path", spp=1 << 24, progress=progress)
        self.assertEqual(picture.statistics["stop_reason"], "interrupted")
        self.assertGreater(len(told), 0)
        self.assertIn("fraction", told[0])

    def test_the_bar_shows_what_is_known(self):
        unknown = {"phase": "photons", "fraction": 0.5, "elapsed": 2.2, "seconds_left": None, "samples_per_pixel": 0}
        known = dict(unknown, seconds_left=7.4, samples_per_pixel=3)
        bar, errors = recurse.ProgressBar(), io.StringIO()
        with contextlib.redirect_stderr(errors):
            for progress in (unknown, dict(unknown, seconds_left=-1), known):
                bar(progress)
            room().render("path", spp=1, progress=True)
        lines = errors.getvalue().split("\r")
        self.assertEqual(lines[1].rstrip(), " photons [" + 15 * "#" + 15 * "." + "] 0 samples, 2 s")
        self.assertEqual(lines[2], lines[1])
        self.assertIn("3 samples, 2 s, 7 s left", lines[3])
        self.assertIn('<progress value="0.5000" max="1">', bar._repr_html_())

    def test_notebooks_get_one_bar_that_changes(self):
        """Output and updates in a notebook, with a substitute for IPython."""
        shown = unittest.mock.MagicMock()
        shell = unittest.mock.Mock(spec=["kernel"])
        modules = {"IPython": types.SimpleNamespace(get_ipython=lambda: shell),
                   "IPython.display": types.SimpleNamespace(display=shown)}
        errors = io.StringIO()
        with unittest.mock.patch.dict(sys.modules, modules), contextlib.redirect_stderr(errors):
            bar = recurse.ProgressBar()
            for fraction in (0.25, 0.5, 1):
                bar({"phase": "<render>", "fraction": fraction})
            bar.finish()
        shown.assert_called_once_with(bar, display_id=True)
        self.assertEqual(shown.return_value.update.call_count, 2)
        self.assertEqual(errors.getvalue(), "")
        self.assertIn("&lt;render&gt;", bar._repr_html_())

    def test_errors_of_progress_reach_the_caller(self):
        def progress(p):
            raise ZeroDivisionError

        with self.assertRaises(ZeroDivisionError):
            room().render("path", spp=1 << 24, progress=progress)

    def test_interrupts_end_a_render_while_other_threads_run(self):
        counter = [0]

        def interrupt():
            counter[0] += 1
            if counter[0] == 5:
                os.kill(os.getpid(), signal.SIGINT)
            elif counter[0] < 5:
                threading.Timer(0.1, interrupt).start()

        with self.assertRaises(KeyboardInterrupt):
            interrupt()
            room().render("path", spp=1 << 24)
        self.assertEqual(counter[0], 5)

    def interrupted(self, work):
        """Work that would take minutes ends soon after Ctrl-C."""
        start = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            work()
        self.assertLess(time.monotonic() - start, 60)

    def test_interrupts_end_loading(self):
        surface = ('Shape "loopsubdiv" "integer levels" 10 "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]'
                   ' "integer indices" [0 1 2 0 2 3]\n')
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        self.interrupted(lambda: recurse.parse('WorldBegin Material "diffuse"\n' + 40 * surface))

    def test_interrupts_end_photons(self):
        scene = room()
        scene.photons(1000)
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        self.interrupted(lambda: scene.photons(300_000_000))

    def test_interrupts_end_feature_layers(self):
        """Each ray crosses 1200 surfaces, and a layer takes 64 times as many rays as the picture."""
        scene = recurse.parse("""Film "rgb" "integer xresolution" 48 "integer yresolution" 48
LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 10
WorldBegin
LightSource "point"
MakeNamedMedium "m" "string type" "homogeneous" "rgb sigma_a" [ .001 .001 .001 ] "rgb sigma_s" [ 0 0 0 ]
Material "interface"
MediumInterface "m" ""
""" + 1200 * 'Shape "sphere"\n')

        def progress(state):
            if state["fraction"] >= 1:
                os.kill(os.getpid(), signal.SIGINT)

        self.interrupted(lambda: scene.render("simplepath", spp=1, features=["cryptoobject"], progress=progress))

    def test_paths_of_a_pixel_add_up_to_it(self):
        pixel = (12, 14)
        for integrator, parameters in (("path", {}), ("photonmap", {"photons": 3000})):
            paths = recurse.paths(room(), pixel, samples=4, integrator=integrator, seed=3, **parameters)
            picture = room().render(integrator, spp=4, seed=3, **parameters)
            np.testing.assert_allclose(paths.value, picture.array[pixel[1], pixel[0]], rtol=1e-5)
            np.testing.assert_allclose(paths.contributions["radiance"].sum(axis=0) / 4, paths.value, rtol=1e-3)
            self.assertEqual(set(paths.contributions["sample"]) - set(range(4)), set())
            self.assertIn("light sample", set(paths.contributions["technique"]))
            of = paths.contributions[paths.contributions["technique"] == "light sample"]
            lit = paths.vertices[of["vertex"]]
            np.testing.assert_array_equal(lit["sample"], of["sample"])
            first = lit[lit["previous"] == -1]
            self.assertEqual(set(first["event"]), {b"E"})
            np.testing.assert_allclose(first["position"][:, 1], 0, atol=1e-5)  # the floor is visible there
        with self.assertRaisesRegex(recurse.Error, "pixel 99,0 is outside of the picture"):
            recurse.paths(room(), (99, 0), integrator="path")

    def test_cameras_are_chosen_by_name(self):
        light = 'AreaLightSource "diffuse" "rgb L" [ {} ] Shape "bilinearmesh" "point3 P" [ {} ]\n'
        scene = recurse.parse("""Film "rgb" "integer xresolution" 4 "integer yresolution" 4
LookAt 0 0 0  0 0 -1  0 1 0
Camera "perspective" "float fov" 20 "string name" "back"
Identity
Camera "perspective" "float fov" 20 "string name" "front"
WorldBegin
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
""" + light.format("1 0 0", "-9 -9 -1  9 -9 -1  -9 9 -1  9 9 -1")
                              + light.format("0 1 0", "-9 -9 1  -9 9 1  9 -9 1  9 9 1"))
        for camera, colour in ((None, (1, 0, 0)), ("front", (0, 1, 0)), ("back", (1, 0, 0))):
            picture = scene.render("path", spp=1, camera=camera)
            np.testing.assert_allclose(picture.array[2, 2], colour, rtol=1e-5)
        paths = scene.paths((2, 2), samples=1, integrator="path", camera="front")
        np.testing.assert_allclose(paths.value, (0, 1, 0), rtol=1e-5)
        with self.assertRaisesRegex(recurse.Error, "there are: back, front"):
            scene.render("path", spp=1, camera="side")

    def test_photons_carry_the_power_of_the_lamp(self):
        scene = recurse.Scene()
        scene.set_film(xresolution=4, yresolution=4)
        scene.set_camera(look_at=[(0, 0, 0), (0, 0, 1), (0, 1, 0)])
        scene.add_light("point", I=(1, 2, 3), from_=(100, 0, 0.2))
        scene.add_shape("sphere", radius=2, transform=recurse.translate(100, 0, 0),
                        material=recurse.materials.diffuse(reflectance=0))
        photons = recurse.photons(scene, 2000)
        self.assertEqual(len(photons), 2000)
        np.testing.assert_allclose(photons["power"].sum(axis=0), 4 * np.pi * np.array([1, 2, 3]), rtol=1e-4)
        self.assertEqual(set(photons["path"]), {b"L"})
        self.assertEqual(set(photons["event"]), {b"D"})
        self.assertEqual(set(photons["class"]), {"direct-diffuse"})
        named = scene.photons(20, classes={"other": "LDDE", "seen": "LDE", "all": "all"})
        self.assertEqual(set(named["class"]), {"seen"})
        self.assertEqual(set(scene.photons(20, classes=["LS+DE"])["class"]), {""})
        np.testing.assert_allclose(np.linalg.norm(photons["position"] - [100, 0, 0], axis=1), 2, rtol=1e-5)
        np.testing.assert_allclose(np.linalg.norm(photons["direction"], axis=1), 1, rtol=1e-4)
        self.assertTrue((np.einsum("ij,ij->i", photons["direction"], photons["normal"]) > 0).all())
        np.testing.assert_array_equal(photons, scene.photons(2000))

    def test_photons_in_a_medium_carry_what_it_scatters(self):
        """A lamp in the middle of a ball of fog: the power of first scattering events has a closed form."""
        scene = recurse.Scene()
        scene.set_film(xresolution=4, yresolution=4)
        scene.set_camera(look_at=[(0, 0, -9), (0, 0, 1), (0, 1, 0)])
        absorption, scattering, radius = 0.3, np.array([0.2, 0.4, 0.8]), 2
        scene.add_medium("fog", "homogeneous", sigma_a=(absorption,) * 3, sigma_s=scattering)
        scene.add_light("point", I=(1, 1, 1), medium=("fog", "fog"))
        scene.add_shape("sphere", radius=radius, material=recurse.materials.interface(), medium=("fog", ""))
        photons = scene.photons(40000)
        first = photons[photons["path"] == b"L"]
        self.assertEqual(set(photons["event"]), {b"V"})
        self.assertTrue((photons["normal"] == 0).all())
        self.assertEqual(set(photons["path"]) & {b"LV", b"LVV"}, {b"LV", b"LVV"})
        extinction = absorption + scattering
        expected = 4 * np.pi * scattering / extinction * (1 - np.exp(-extinction * radius))
        np.testing.assert_allclose(first["power"].sum(axis=0), expected, rtol=0.02)
        distance = np.linalg.norm(first["position"], axis=1)
        near = first["power"][distance < 0.5].sum(axis=0)
        np.testing.assert_allclose(near, 4 * np.pi * scattering / extinction * (1 - np.exp(-extinction / 2)), rtol=0.05)

    def test_density_by_hand_is_the_irradiance(self):
        photons = room().photons(200000)
        on_floor = (np.abs(photons["position"][:, 1]) < 1e-4) & (photons["path"] == b"L")
        x, z = photons["position"][on_floor][:, 0], photons["position"][on_floor][:, 2]
        near = (x - 4) ** 2 + z ** 2 < 0.7 ** 2
        estimate = photons["power"][on_floor][near].sum(axis=0) / (np.pi * 0.7 ** 2)
        distance2 = 4 ** 2 + 4 ** 2
        expected = np.pi * np.array([12, 11, 10]) * 0.5 ** 2 / distance2 * 4 / np.sqrt(distance2)
        np.testing.assert_allclose(estimate, expected, rtol=0.06)
        caustic = [p for p in set(photons["path"]) if recurse.in_class("LS+DE", p.decode() + "DE")]
        self.assertIn(b"LSS", caustic)


class Pictures(InFolder):
    def test_pictures_are_compared_and_developed(self):
        picture = np.full((32, 32, 3), 0.5, np.float32)
        other = picture * 1.1
        self.assertEqual(recurse.compare(picture, picture)["mse"], 0)
        self.assertAlmostEqual(recurse.compare(other, picture)["mse"], 0.0025, places=6)
        shown = recurse.develop(picture, exposure=0, tonemap="none")
        self.assertEqual((shown.dtype, shown.shape), (np.uint8, (32, 32, 3)))
        self.assertEqual(set(shown.ravel()), {188})
        with self.assertRaisesRegex(recurse.Error, "--tonemap"):
            recurse.develop(picture, tonemap="nosuch")

    def test_pictures_are_shown_in_notebooks(self):
        picture = room().render("path", spp=1)
        self.assertTrue(picture._repr_png_().startswith(b"\x89PNG"))

    def test_classes_are_explained(self):
        self.assertIn("caustic", recurse.named_classes())
        self.assertIn("LSDE", recurse.classes("LS+DE"))
        self.assertTrue(recurse.in_class("LS+DE", "LSSDE"))
        self.assertFalse(recurse.in_class("LS+DE", "LDE"))
        with self.assertRaisesRegex(recurse.Error, "column"):
            recurse.classes("L(")


#: Parameters of which a plug-in needs one of several.
NEEDED = {"points": {"P": [(0, 0, 0)], "radius": 1}}
#: Parameters that require further ones.
TOGETHER = {"v1": {"mapping": "planar"}, "v2": {"mapping": "planar"}, "sigma_a": {"sigma_s": 1}, "sigma_s": {"sigma_a": 1}}


class Guide(InFolder):
    def test_its_examples_run(self):
        with open(GUIDE, encoding="utf-8") as file:
            blocks = file.read().split("```python\n")[1:]
        names = {}
        for block in blocks:
            exec(compile(block.split("```")[0], "python.md", "exec"), names)  # pylint: disable=exec-used
        self.assertTrue(os.path.getsize("first.png") > 1000 and os.path.getsize("first.pbrt") > 100)
        expected = np.pi * np.array([12, 11, 10]) * 0.5 ** 2 / 32 * 4 / np.sqrt(32)
        np.testing.assert_allclose(names["irradiance"], expected, rtol=0.2)
        self.assertTrue(names["caustic"].any())


class Notebooks(InFolder):
    def run_cells(self, name):
        """Names that the code cells of a notebook define, and the values at the ends of cells."""
        with open(os.path.join(os.path.dirname(GUIDE), name), encoding="utf-8") as file:
            cells = json.load(file)["cells"]
        names, shown = {}, []
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            for number, cell in enumerate(cells):
                if cell["cell_type"] != "code":
                    continue
                self.assertEqual(cell["outputs"], [], "outputs are not kept")
                tree = ast.parse("".join(cell["source"]))
                last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
                place = f"{name}, cell {number}"
                exec(compile(tree, place, "exec"), names)  # pylint: disable=exec-used
                if last:
                    shown.append(eval(compile(ast.Expression(last.value), place, "eval"), names))  # pylint: disable=eval-used
        return names, shown

    def test_first_picture(self):
        names, shown = self.run_cells("first-picture.ipynb")
        for value in shown:
            if isinstance(value, recurse.Picture):
                self.assertTrue(value._repr_png_().startswith(b"\x89PNG"))
        self.assertEqual(names["rows"].shape, (50, 160, 3))
        np.testing.assert_array_equal(recurse.read("first.exr").layers["caustic"], names["caustic"].array)

    def test_error_against_time(self):
        names, shown = self.run_cells("error-against-time.ipynb")
        self.assertEqual(set(shown[-1]), {"path", "photonmap"})
        self.assertTrue(-2 < names["slopes"]["path"] < -0.9, names["slopes"])
        self.assertTrue(all(seconds > 0 for seconds in names["seconds"]["path"]))

    def test_density_estimation(self):
        names, shown = self.run_cells("density-estimation.ipynb")
        np.testing.assert_allclose(names["estimates"][1], names["exact"], rtol=0.1)
        self.assertGreater(abs(names["estimates"][5] / names["exact"] - 1).min(), 0.15)  # the blur
        self.assertEqual(shown[-1].array.shape, (60, 60, 3))
        middle, aside = names["picture"].array[28:32, 28:32].mean(), names["picture"].array[:, 5].mean()
        self.assertGreater(middle, 3 * aside)  # the caustic
        self.assertGreater(len(names["caustic"]), 100)


class PlugIns(unittest.TestCase):
    def test_every_plug_in_has_a_function_with_its_parameters(self):
        for info in recurse._core.plug_ins():
            namespace = getattr(recurse, plug_ins.KINDS[info["kind"]])
            make = getattr(namespace, plug_ins.python_name(info["name"]))
            self.assertIn(info["summary"], make.__doc__)
            names = [plug_ins.python_name(spec["name"]) for spec in info["parameters"]]
            self.assertEqual(len(names), len(set(names)), info["name"])
            for name in names:
                self.assertTrue(name.isidentifier(), f"{info['name']}: {name}")
                self.assertNotIn(name, ("material", "light", "transform", "medium", "reverse_orientation", "look_at"))
            self.assertEqual(make().name, info["name"])

    def test_every_default_goes_through_the_text_of_a_scene(self):
        """The program reads written default values of parameters as equal to the defaults."""
        for info in recurse._core.plug_ins():
            if info["kind"] not in ("Shape", "Material", "LightSource", "Texture"):  # all other kinds use the same code
                continue
            if any(spec["required"] for spec in info["parameters"]):
                continue
            for spec in info["parameters"]:
                if spec["ignored"] or not spec["default"]:
                    continue
                if spec["type"] == "bool":
                    value = spec["default"] == "true"
                elif spec["type"] == "string":
                    value = spec["default"]
                else:
                    numbers = [float(x) for x in spec["default"].split()]
                    value = numbers[0] if len(numbers) == 1 else numbers
                values = {plug_ins.python_name(spec["name"]): value}
                values |= TOGETHER.get(spec["name"], {})
                values |= NEEDED.get(info["name"], {})
                with self.subTest(info["name"], parameter=spec["name"]):
                    self.check_scene(info, values)

    @staticmethod
    def check_scene(info, values):
        """Loads a scene with a plug-in of these parameters."""
        scene = recurse.Scene()
        scene.set_film(xresolution=2, yresolution=2)
        if info["kind"] == "Shape":
            scene.add_shape(info["name"], **values)
        elif info["kind"] == "Material":
            scene.add_shape("sphere", material=recurse.materials.make(info["name"], values))
        elif info["kind"] == "LightSource":
            scene.add_light(info["name"], **values)
        else:
            texture = recurse.textures.make(info["name"], values)
            is_float = info["name"] in ("fbm", "wrinkled", "windy")
            scene.add_shape("sphere", material=recurse.materials.orennayar(sigma=texture) if is_float
                            else recurse.materials.diffuse(reflectance=texture))
        scene.check()

    def test_materials_and_textures_nest(self):
        scene = recurse.Scene()
        checks = recurse.textures.checkerboard(tex1=recurse.textures.marble(), tex2=(.1, .2, .3), uscale=4)
        stripes = recurse.textures.checkerboard(tex1=0.2, tex2=recurse.textures.fbm())
        mix = recurse.materials.mix(materials=[recurse.materials.diffuse(reflectance=checks),
                                               recurse.materials.conductor(roughness=.1)], amount=stripes)
        with scene.object("ball"):
            scene.add_shape(recurse.shapes.sphere(radius=.5), material=mix)
        scene.add_instance("ball", recurse.scale(2, 1, 1) @ recurse.rotate(30, (0, 1, 0)))
        scene.add_instance("ball")
        scene.add_medium("fog", "homogeneous", sigma_a=.1, sigma_s=.1)
        scene.add_shape("sphere", radius=.2, material=recurse.materials.interface(), medium=("fog", ""))
        self.assertIn("2 instances", scene.check())

    def test_stubs_are_python(self):
        with open(os.path.join(os.path.dirname(recurse.__file__), "plug_ins.pyi"), encoding="utf-8") as file:
            tree = ast.parse(file.read())
        functions = {node.name for cls in tree.body if isinstance(cls, ast.ClassDef) for node in cls.body
                     if isinstance(node, ast.FunctionDef)}
        for info in recurse._core.plug_ins():
            self.assertIn(plug_ins.python_name(info["name"]), functions)

    def test_stubs_have_all_of_the_module_in_cpp(self):
        """Names of the module and its classes, with the numbers of arguments of their functions."""
        with open(os.path.join(os.path.dirname(recurse.__file__), "_core.pyi"), encoding="utf-8") as file:
            tree = ast.parse(file.read())

        def check(stubs, owner):
            named = {node.name: node for node in stubs if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
            missing = {name for name in vars(owner) if not name.startswith("_")} - set(named)
            self.assertEqual(missing, set(), owner)
            for name, node in named.items():
                self.assertTrue(hasattr(owner, name), name)
                if isinstance(node, ast.ClassDef):
                    check(node.body, getattr(owner, name))
                elif not node.decorator_list:
                    arguments = re.findall(r"\barg\d+: ", getattr(owner, name).__doc__.splitlines()[0])
                    self.assertEqual(len(arguments), len(node.args.args) - (owner is not recurse._core), name)

        check(tree.body, recurse._core)

    def test_cameras_look_where_they_are_placed(self):
        by_points, by_matrix = room(), room()
        by_matrix.set_camera("perspective", fov=40, transform=recurse.look_at((0, 1, -6), (0, 1, 0)))
        self.assertLess(recurse.compare(by_matrix.render("raycast", spp=16), by_points.render("raycast", spp=16))
                        ["relmse"], 1e-3)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
