"""The page of `recurse converge` in headless Chromium: python3 convergePageTest.py PROGRAM.

It must load without errors and without any network, and show the numbers of converge.json.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
import unittest

from browser import Browser, BrowserError

PROGRAM = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else None
SCENE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes", "cornell-mix.pbrt")
browser = None


class ConvergePage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="recurse-converge-page-")
        cls.folder = cls.temporary.name + "/study"
        subprocess.run(
            [PROGRAM, "converge", SCENE, "-o", cls.folder, "-q", "--resolution", "32x32", "--samples", "1,4,16",
             "--reference-error", "0.05", "--run", "path=--integrator path",
             "--run", "pm=--integrator photonmap --photons 20k"], check=True, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        with open(cls.folder + "/points.csv", encoding="utf-8") as file:
            cls.points = list(csv.DictReader(file))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        browser.open(self.folder + "/index.html", "document.body.dataset.ready === 'yes'")

    def tearDown(self):
        self.assertEqual(browser.complaints, [])
        self.assertEqual([url for url in browser.requests if not url.startswith(("file://", "data:", "blob:"))], [])

    def text(self, selector):
        return browser.evaluate(f"document.querySelector({json.dumps(selector)}).textContent")

    def chart(self, expression):
        return browser.evaluate(f"(() => {{ const chart = Chart.getChart('plot'); return {expression}; }})()")

    def select(self, name, value):
        browser.evaluate(f"(() => {{ const e = document.getElementById('{name}'); e.value = {json.dumps(value)};"
                         "e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); })()")
        browser.settle()

    def colourAt(self, x, y):
        """Of the stage, at fractions of its size."""
        return browser.evaluate(
            "(() => { const v = document.getElementById('view'), copy = document.createElement('canvas');"
            "copy.width = copy.height = 1; const c = copy.getContext('2d');"
            f"c.drawImage(v, -Math.round(v.width * {x}), -Math.round(v.height * {y}));"
            "return [...c.getImageData(0, 0, 1, 1).data]; })()")

    def testPlotShowsThePoints(self):
        path = [p for p in self.points if p["run"] == "path"]
        shown = self.chart("chart.data.datasets[0].data")
        self.assertEqual(len(shown), 3)
        for point, data in zip(path, shown):
            self.assertAlmostEqual(data["x"] / float(point["seconds"]), 1, 6)
            self.assertAlmostEqual(data["y"] / float(point["relmse_noise_free"]), 1, 6)
        self.assertEqual(self.chart("[chart.scales.x.type, chart.scales.y.type]"), ["logarithmic"] * 2)
        labels = self.chart("chart.data.datasets.map((d) => d.label)")
        self.assertTrue(labels[0].startswith("path  t^-"), labels)
        self.assertEqual(labels[-2:], ["∝ t^-1", "∝ t^-2/3"])
        self.assertEqual(self.chart("chart.data.datasets[1].data.length"), 6)  # three budgets, two seeds
        # A line of slope -1, whatever its length.
        line = self.chart("chart.data.datasets.at(-2).data")
        self.assertAlmostEqual(line[0]["x"] * line[0]["y"] / (line[1]["x"] * line[1]["y"]), 1, 6)

    def testOtherMeasures(self):
        self.select("measure", "1")
        self.assertIn("(x−r)²/(r²+ε), ε 0.01, no trim", self.text("#definition"))
        point = next(p for p in self.points if p["run"] == "path")
        self.assertAlmostEqual(self.chart("chart.data.datasets[0].data[0].y") / float(point["relmse"]), 1, 6)
        self.assertIn("relMSE", self.text("#reach"))

    def testTables(self):
        self.assertEqual(browser.evaluate("document.querySelectorAll('#reach tr').length"), 3)
        self.assertEqual(browser.evaluate("document.querySelectorAll('#all tr').length"), 7)
        self.assertIn("t^-", self.text("#reach tr:nth-child(2)"))
        self.assertIn("…", self.text("#all tr:nth-child(2)"))
        self.assertIn("photons 20000", self.text("#settings"))
        self.assertIn("relMSE of their mean", self.text("#settings"))

    def testPicturesAndErrors(self):
        self.assertIn("path, ", self.text("#nameA"))
        self.assertIn("pm, ", self.text("#nameB"))
        self.select("left", "reference")
        self.assertEqual(self.text("#nameA"), "reference")
        lit = self.colourAt(0.45, 0.5)
        self.assertGreater(sum(lit[:3]), 60)
        # The error of the reference against itself is none: the darkest colour of the scale.
        self.select("show", "error")
        self.assertEqual(self.colourAt(0.45, 0.5)[:3], browser.evaluate(
            "JSON.parse(document.getElementById('data').textContent).colours[0]"))
        self.assertNotEqual(self.colourAt(0.55, 0.5)[:3], self.colourAt(0.45, 0.5)[:3])
        self.assertFalse(browser.evaluate("document.getElementById('scale').hidden"))
        self.select("budget", "0")
        self.assertEqual(self.text("#budgetText"), "1")
        # The slider moves the line between the two.
        self.select("split", "100")
        self.assertNotEqual(self.colourAt(0.4, 0.5)[:3], browser.evaluate(
            "JSON.parse(document.getElementById('data').textContent).colours[0]"))

    def testPixel(self):
        browser.evaluate("document.getElementById('view').focus()")
        browser.key("ArrowRight")
        self.assertRegex(self.text("#pixelPlace"), r"x 16\s+y 16")
        self.assertRegex(self.text("#pixelR"), r"r [\d.e-]+\s+[\d.e-]+\s+[\d.e-]+")


if __name__ == "__main__":
    if not PROGRAM:
        sys.exit("usage: python3 convergePageTest.py PROGRAM")
    try:
        browser = Browser()
    except BrowserError as error:
        sys.exit(f"The page cannot be tested: {error}")
    try:
        outcome = unittest.main(argv=sys.argv[:1] + sys.argv[2:], exit=False, verbosity=2).result
    finally:
        browser.close()
    sys.exit(not outcome.wasSuccessful())
