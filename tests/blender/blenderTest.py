#!/usr/bin/env python3
"""Tests of the add-on outside of Blender: blenderTest.py BLENDER SOURCE-FOLDER PROGRAM."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

BLENDER, SOURCE, PROGRAM = sys.argv[1:4]
HERE = os.path.dirname(os.path.abspath(__file__))
SAMPLES = 16
BOUND = 0.03


class Cycles(unittest.TestCase):
    def test_means_of_ten_scenes_are_those_of_cycles(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([BLENDER, "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                                   os.path.join(HERE, "compareCycles.py"), "--", os.path.join(SOURCE, "src", "blender"),
                                   PROGRAM, folder, str(SAMPLES), "64x48"], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout[-2000:] + done.stderr[-2000:])
            with open(os.path.join(folder, "means.json"), encoding="utf-8") as file:
                results = json.load(file)
        self.assertEqual(len(results), 10)
        for name, engines in results.items():
            for own, other in zip(engines["RECURSE"]["means"], engines["CYCLES"]["means"]):
                with self.subTest(name):
                    self.assertLess(abs(own / other - 1), BOUND)


class Package(unittest.TestCase):
    def test_the_zip_is_installed_and_enabled(self):
        with tempfile.TemporaryDirectory() as folder:
            package = os.path.join(folder, "addon.zip")
            subprocess.run([os.path.join(SOURCE, "scripts", "package"), "--blender", package], check=True,
                           capture_output=True)
            script = (f"import bpy; bpy.ops.preferences.addon_install(filepath={package!r}); "
                      "bpy.ops.preferences.addon_enable(module='recurse_blender'); "
                      "bpy.context.scene.render.engine = 'RECURSE'; print('engine', bpy.context.scene.recurse.integrator)")
            done = subprocess.run([BLENDER, "-b", "--factory-startup", "--python-exit-code", "1", "--python-expr", script],
                                  env={**os.environ, "BLENDER_USER_SCRIPTS": os.path.join(folder, "scripts")},
                                  capture_output=True, text=True, check=False)
            self.assertIn("engine photonmap", done.stdout, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
