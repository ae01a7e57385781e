"""The page of `recurse compare --classes` in headless Chromium: python3 markingPageTest.py PROGRAM.

It must load without errors and without any network, name the mistakes, and show their regions.
"""

import json
import os

from pageTest import SCENE, OfflinePage, browser, main, recurse

MISSING = "rgb(111, 182, 255)"  # colour of the word and of the map


class MarkingPage(OfflinePage):
    @classmethod
    def make(cls):
        os.makedirs(cls.folder)
        stills, student = cls.folder + "/stills", cls.folder + "/student"
        recurse("stills", SCENE, "-o", stills, "-q", "--resolution", "64x48", "--spp", "32")
        # The picture lacks light that mirrors or glass focus on matt surfaces.
        recurse("render", SCENE, "-o", student + ".exr", "-q", "--resolution", "64x48", "--spp", "16", "--seed", "2",
                "--paths", "all - LS+DS*E")
        cls.page = cls.folder + "/marks.html"
        cls.data = json.loads(recurse("compare", student + ".exr", stills, "--classes", "--json", "-o", cls.page))

    def setUp(self):
        browser.open(self.page, "document.body.dataset.ready === 'yes'")

    def canvasSum(self, name):
        """Red, green and blue of all pixels of a canvas."""
        return browser.evaluate(
            f"(() => {{ const c = document.getElementById('{name}');"
            "const copy = document.createElement('canvas'); copy.width = c.width; copy.height = c.height;"
            "const context = copy.getContext('2d', { willReadFrequently: true }); context.drawImage(c, 0, 0);"
            "const d = context.getImageData(0, 0, c.width, c.height).data; const s = [0, 0, 0];"
            "for (let i = 0; i < d.length; i += 4) for (let k = 0; k < 3; ++k) s[k] += d[i + k] * d[i + 3] / 255;"
            "return s; })()")

    def testStatements(self):
        self.assertIn("caustic", self.data["statements"][0]["what"])
        self.assertEqual(self.texts("#statements b"), [s["what"] for s in self.data["statements"]])
        self.assertRegex(self.text("#verdict"), r"^\d+ errors? w")

    def testClassesAndTheirMap(self):
        rows = self.texts("#classes tbody tr")
        self.assertEqual(len(rows), len(self.data["classes"]))
        caustic = next(i for i, c in enumerate(self.data["classes"]) if c["name"] == "caustic")
        state = browser.evaluate(f"getComputedStyle(document.getElementById('classes').tBodies[0].rows[{caustic}]"
                                 ".cells[2]).color")
        self.assertEqual(state, MISSING)
        # The map begins with the class of the first statement, and changes with the row that is clicked.
        self.assertEqual(browser.evaluate("document.getElementById('map').value"), str(caustic))
        before = self.canvasSum("regions")
        browser.click("document.getElementById('classes').tBodies[0].rows[1]")
        self.assertEqual(browser.evaluate("document.getElementById('map').value"), "1")
        self.assertNotEqual(before, self.canvasSum("regions"))

    def testPictures(self):
        shown = self.canvasSum("view")
        self.assertGreater(sum(shown), 0)
        self.set("show", "reference")
        self.assertGreater(sum(self.canvasSum("view")), sum(shown) * 0.9)
        self.set("show", "less")
        self.assertLess(sum(self.canvasSum("view")), sum(shown))
        self.set("exposure", "-12")
        self.assertLess(sum(self.canvasSum("view")), sum(shown) * 0.1)

    def testRegion(self):
        region = next(r for r in self.data["regions"] if any(c["state"] == "missing" for c in r["classes"]))
        box = browser.evaluate("(() => { const e = document.getElementById('regions'); e.scrollIntoView();"
                               "const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()")
        x = box[0] + (region["x"] + region["width"] / 2) / 64 * box[2]
        y = box[1] + (region["y"] + region["height"] / 2) / 48 * box[3]
        browser.clickAt(x, y)
        self.assertIn("missing (", self.text("#region"))


if __name__ == "__main__":
    main()
