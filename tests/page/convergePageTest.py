"""The page of `recurse converge` in headless Chromium: python3 convergePageTest.py PROGRAM.

It must load without errors and without any network, and show the numbers of converge.json.
"""

import csv
import json

from pageTest import SCENE, OfflinePage, browser, main, recurse


class ConvergePage(OfflinePage):
    @classmethod
    def make(cls):
        recurse("converge", SCENE, "-o", cls.folder, "-q", "--resolution", "32x32", "--samples", "1,8,64",
                "--reference-error", "0.05", "--run", "path=--integrator path",
                "--run", "pm=--integrator photonmap --photons 20k")
        with open(cls.folder + "/points.csv", encoding="utf-8") as file:
            cls.points = list(csv.DictReader(file))

    def setUp(self):
        browser.open(self.folder + "/index.html", "document.body.dataset.ready === 'yes'")

    def chart(self, expression):
        return browser.evaluate(f"(() => {{ const chart = Chart.getChart('plot'); return {expression}; }})()")

    def stageColour(self, x, y):
        """Colour of the stage at fractions of its size."""
        return browser.evaluate(
            "(() => { const v = document.getElementById('view'), copy = document.createElement('canvas');"
            "copy.width = copy.height = 1; const c = copy.getContext('2d');"
            f"c.drawImage(v, -Math.round(v.width * {x}), -Math.round(v.height * {y}));"
            "return [...c.getImageData(0, 0, 1, 1).data]; })()")

    def pathByTime(self):
        """The points of `path` in the order of the chart: a short budget may have taken longer than a long one."""
        return sorted((p for p in self.points if p["run"] == "path"), key=lambda p: float(p["seconds"]))

    def testPlotShowsThePoints(self):
        path = self.pathByTime()
        shown = self.chart("chart.data.datasets[0].data")
        self.assertEqual(len(shown), 3)
        for point, data in zip(path, shown):
            self.assertAlmostEqual(data["x"] / float(point["seconds"]), 1, 6)
            self.assertAlmostEqual(data["y"] / float(point["relmse_noise_free"]), 1, 6)
        self.assertEqual(self.chart("[chart.scales.x.type, chart.scales.y.type]"), ["logarithmic"] * 2)
        labels = self.chart("chart.data.datasets.map((d) => d.label)")
        # Such short renders may take the same time, which gives no slope; convergeTest.cpp uses given times.
        self.assertRegex(labels[0], r"^path  (t\^|no fit)")
        self.assertEqual(labels[-2:], ["∝ t^-1", "∝ t^-2/3"])
        self.assertEqual(self.chart("chart.data.datasets[1].data.length"), 6)  # three budgets, two seeds
        # A line of slope -1 of any length.
        line = self.chart("chart.data.datasets.at(-2).data")
        self.assertAlmostEqual(line[0]["x"] * line[0]["y"] / (line[1]["x"] * line[1]["y"]), 1, 6)

    def testOtherMeasures(self):
        self.set("measure", "1")
        self.assertIn("(x−r)²/(r²+ε), ε 0.01, no trim", self.text("#definition"))
        point = self.pathByTime()[0]
        self.assertAlmostEqual(self.chart("chart.data.datasets[0].data[0].y") / float(point["relmse"]), 1, 6)
        self.assertIn("relMSE", self.text("#reach"))

    def testTables(self):
        self.assertEqual(browser.evaluate("document.querySelectorAll('#reach tr').length"), 3)
        self.assertEqual(browser.evaluate("document.querySelectorAll('#all tr').length"), 7)
        self.assertRegex(self.text("#reach tr:nth-child(2)"), r"t\^|no fit")
        self.assertIn("…", self.text("#all tr:nth-child(2)"))
        self.assertIn("photons 20000", self.text("#settings"))
        self.assertIn("relMSE of their mean", self.text("#settings"))

    def testPicturesAndErrors(self):
        self.assertIn("path, ", self.text("#nameA"))
        self.assertIn("pm, ", self.text("#nameB"))
        self.set("left", "reference")
        self.assertEqual(self.text("#nameA"), "reference")
        lit = self.stageColour(0.45, 0.5)
        self.assertGreater(sum(lit[:3]), 60)
        # The error of the reference against itself is zero: the darkest colour of the scale.
        self.set("show", "error")
        self.assertEqual(self.stageColour(0.45, 0.5)[:3], browser.evaluate(
            "JSON.parse(document.getElementById('data').textContent).colours[0]"))
        self.assertNotEqual(self.stageColour(0.55, 0.5)[:3], self.stageColour(0.45, 0.5)[:3])
        self.assertFalse(browser.evaluate("document.getElementById('scale').hidden"))
        self.set("budget", "0")
        self.assertEqual(self.text("#budgetText"), "1")
        # The slider moves the line between the two.
        self.set("split", "100")
        self.assertNotEqual(self.stageColour(0.4, 0.5)[:3], browser.evaluate(
            "JSON.parse(document.getElementById('data').textContent).colours[0]"))

    def testPixel(self):
        browser.evaluate("document.getElementById('view').focus()")
        browser.key("ArrowRight")
        self.assertRegex(self.text("#pixelPlace"), r"x 16\s+y 16")
        self.assertRegex(self.text("#pixelR"), r"r [\d.e-]+\s+[\d.e-]+\s+[\d.e-]+")


if __name__ == "__main__":
    main()
