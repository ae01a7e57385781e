"""The page of `recurse inspect` in headless Chromium: python3 inspectPageTest.py PROGRAM.

It must load without errors and without any network, draw the scene, and answer to clicks on pixels and surfaces.
"""

import json
import subprocess

import browser as chromium

chromium.FLAGS = [flag for flag in chromium.FLAGS if flag != "--disable-gpu"] + chromium.WEBGL_FLAGS

from pageTest import SCENE, OfflinePage, browser, main, recurse  # noqa: E402 (the browser starts at once)

PIXELS = [(24, 40), (4, 30)]


class InspectPage(OfflinePage):
    @classmethod
    def make(cls):
        cls.page = cls.temporary.name + "/page.html"
        pixels = [word for x, y in PIXELS for word in ("--pixel", f"{x},{y}")]
        recurse("inspect", SCENE, "-o", cls.page, "-q", "--integrator", "photonmap", "--photons", "20k", "--spp", "4",
                "--resolution", "48x48", "--path-samples", "4", "--shown-photons", "5000", *pixels)
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")
        cls.data = browser.evaluate("JSON.parse(document.getElementById('data').textContent)")

    def setUp(self):
        browser.settle()

    def change(self, name, property, value, event="input"):
        browser.evaluate(f"(() => {{ const e = document.getElementById('{name}'); e.{property} = {json.dumps(value)};"
                         f"e.dispatchEvent(new Event('{event}')); }})()")
        browser.settle()

    def clickPixel(self, x, y):
        """Of the picture, which is as wide as high."""
        browser.clickAt(*browser.evaluate(
            "(() => { const c = document.getElementById('picture'); c.scrollIntoView({block: 'nearest'});"
            "const b = c.getBoundingClientRect(), s = Math.min(b.width, b.height);"
            f"return [b.left + (b.width - s) / 2 + s * {(x + 0.5) / 48}, b.top + (b.height - s) / 2 + s * {(y + 0.5) / 48}];"
            "})()"))

    def colours(self):
        """How many different colours the view shows."""
        return browser.evaluate(
            "(() => { const v = document.getElementById('view'), c = document.createElement('canvas').getContext('2d');"
            "c.canvas.width = c.canvas.height = 64; c.drawImage(v, 0, 0, 64, 64);"
            "const d = c.getImageData(0, 0, 64, 64).data, all = new Set();"
            "for (let i = 0; i < d.length; i += 4) all.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]);"
            "return all.size; })()")

    def segments(self):
        return int(browser.evaluate("document.getElementById('view').dataset.segments"))

    def test0PixelsOutsideOfThePictureAreRefused(self):
        for pixel in ("48,0", "0,-1", "7", "a,b"):
            with self.assertRaises(subprocess.CalledProcessError) as refused:
                recurse("inspect", SCENE, "-o", self.page, "--resolution", "48x48", "--pixel", pixel)
            self.assertEqual(refused.exception.returncode, 2, pixel)

    def test1TheSceneIsDrawn(self):
        self.assertGreater(self.data["mesh"]["triangles"], 10)
        self.assertGreater(self.colours(), 10)
        for name in ("top", "side", "front", "camera"):
            browser.click(f"document.querySelector('[data-view={name}]')")
            self.assertGreater(self.colours(), 3, name)

    def test2AClickOnAPixelListsItsPaths(self):
        for pixel in PIXELS:
            self.clickPixel(*pixel)
            self.assertEqual(self.text("#pixelName"), f"{pixel[0]}, {pixel[1]}")
            self.assertGreater(self.segments(), 0)
        recorded = self.data["pixels"][1]
        rows = len(self.texts("#contributions tr")) - 1
        self.assertEqual(rows, min(200, len(recorded["contributions"])))
        self.assertIn(f"{rows} of {rows} contributions of 4 samples", self.text("#pathStatus"))

    def test3TheContributionsAreThePixel(self):
        for pixel in self.data["pixels"]:
            for channel in range(3):
                found = sum(c[10][channel] for c in pixel["contributions"]) / len(pixel["samples"])
                self.assertAlmostEqual(found / pixel["value"][channel], 1, delta=1e-3)

    def test4FiltersAndTheTableOfVertices(self):
        self.clickPixel(*PIXELS[1])
        self.change("filter", "value", "LDE")
        words = self.texts("#contributions tr td:nth-child(2)")
        self.assertIn("LDE", words)
        self.assertLessEqual(set(words), {"LDE", "L…DE"})
        self.change("filter", "value", "L(")
        self.assertTrue(browser.evaluate("document.getElementById('filter').classList.contains('bad')"))
        self.change("filter", "value", "")
        whole = self.segments()
        browser.click("document.querySelectorAll('#contributions tr')[1]")
        self.assertLess(self.segments(), whole)
        self.assertEqual(self.texts("#vertices tr td:first-child")[0], "E")
        self.assertEqual(self.texts("#vertices tr td:first-child")[-1], "L")
        browser.click("document.querySelector('#classes input')")
        self.assertLess(len(self.texts("#contributions tr")) - 1, len(self.data["pixels"][1]["contributions"]))
        browser.click("document.querySelector('#classes input')")

    def test5AClickOnASurfaceWorksTheEstimateOut(self):
        self.change("showPhotons", "checked", True)
        browser.click("document.querySelector('[data-view=camera]')")
        x, y = browser.evaluate("(() => { const b = document.getElementById('view').getBoundingClientRect();"
                                "return [b.left + b.width / 2, b.top + 0.85 * b.height]; })()")
        browser.clickAt(x, y)
        self.assertNotEqual(self.text("#where"), "")
        count = int(self.text("#numberText"))
        self.assertGreater(count, 10)
        self.assertGreater(float(self.text("#radiusText")), 0)
        self.change("number", "value", 0.4)
        self.assertLess(int(self.text("#numberText")), count)
        irradiance = [float(x) for x in self.texts("#estimateText dd")[2].split()]
        self.assertGreater(min(irradiance), 0)


if __name__ == "__main__":
    main()
