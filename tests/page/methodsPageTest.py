"""The page of `recurse methods` in headless Chromium: python3 methodsPageTest.py PROGRAM.

It must load without errors and without any network, and show the numbers of methods.json.
"""

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


class MethodsPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="recurse-methods-page-")
        cls.folder = cls.temporary.name + "/out"
        subprocess.run(
            [PROGRAM, "methods", SCENE, "-o", cls.folder, "-q", "--resolution", "32x32", "--spp", "4",
             "--reference-spp", "64", "--method", "raycast", "--method", "whitted", "--method", "path"],
            check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with open(cls.folder + "/methods.json", encoding="utf-8") as file:
            cls.data = json.load(file)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        browser.open(self.folder + "/index.html", "document.body.dataset.ready === 'yes'")

    def tearDown(self):
        self.assertEqual(browser.complaints, [])
        self.assertEqual([url for url in browser.requests if not url.startswith(("file://", "data:", "blob:"))], [])

    def texts(self, selector):
        return browser.evaluate(f"[...document.querySelectorAll({json.dumps(selector)})].map((e) => e.textContent)")

    def set(self, name, value):
        browser.evaluate(f"(() => {{ const e = document.getElementById('{name}'); e.value = {json.dumps(value)};"
                         "e.dispatchEvent(new Event('input')); })()")
        browser.settle()

    def brightness(self, card):
        return browser.evaluate(
            f"(() => {{ const c = document.querySelectorAll('#cards canvas')[{card}];"
            "const copy = document.createElement('canvas'); copy.width = c.width; copy.height = c.height;"
            "const context = copy.getContext('2d', { willReadFrequently: true }); context.drawImage(c, 0, 0);"
            "const d = context.getImageData(0, 0, c.width, c.height).data;"
            "let sum = 0; for (let i = 0; i < d.length; i += 4) sum += d[i] + d[i + 1] + d[i + 2];"
            "return sum / d.length; })()")

    def testCards(self):
        self.assertEqual(self.texts("figcaption b"), ["reference", "raycast", "whitted", "path"])
        self.assertEqual(self.texts("figcaption code"), ["all", "LD?E", "LD?S*E", "all"])
        captions = self.texts("figcaption small")
        self.assertIn("4 samples per pixel", captions[1])
        self.assertIn("leaves out 0 %", captions[3])
        self.assertEqual(self.texts("#settings dt"), ["raycast", "whitted", "path"])

    def testWhatIsMissing(self):
        self.assertLess(self.brightness(1), self.brightness(2))
        self.set("show", "missing")
        self.assertEqual(self.brightness(0), 0)
        self.assertGreater(self.brightness(1), self.brightness(2))
        self.set("show", "picture")
        before = self.brightness(3)
        self.set("exposure", "-4")
        self.assertLess(self.brightness(3), before)

    def testClasses(self):
        rows = self.texts("#classes tr")
        self.assertEqual(len(rows), 1 + len(self.data["classes"]))
        light = sum(c["mean"] for c in self.data["classes"])
        for i, c in enumerate(self.data["classes"]):
            cells = self.texts(f"#classes tr:nth-child({i + 2}) td")
            self.assertEqual(cells[1], f"{100 * c['mean'] / light:.2f}")
            for k, m in enumerate(self.data["methods"]):
                expected = f"{100 * m['class_means'][i] / light:.2f}" if m["class_is_claimed"][i] else "–"
                self.assertEqual(cells[2 + k], expected)


if __name__ == "__main__":
    if not PROGRAM:
        sys.exit("usage: python3 methodsPageTest.py PROGRAM")
    try:
        browser = Browser()
    except BrowserError as error:
        sys.exit(f"The page cannot be tested: {error}")
    try:
        outcome = unittest.main(argv=sys.argv[:1] + sys.argv[2:], exit=False, verbosity=2).result
    finally:
        browser.close()
    sys.exit(not outcome.wasSuccessful())
