"""The page of `recurse methods` in headless Chromium: python3 methodsPageTest.py PROGRAM.

It must load without errors and without any network, and show the numbers of methods.json.
"""

import json

from pageTest import SCENE, OfflinePage, browser, main, recurse


class MethodsPage(OfflinePage):
    @classmethod
    def make(cls):
        recurse("methods", SCENE, "-o", cls.folder, "-q", "--resolution", "32x32", "--spp", "4",
                "--reference-spp", "64", "--method", "raycast", "--method", "whitted", "--method", "path")
        with open(cls.folder + "/methods.json", encoding="utf-8") as file:
            cls.data = json.load(file)

    def setUp(self):
        browser.open(self.folder + "/index.html", "document.body.dataset.ready === 'yes'")

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
    main()
