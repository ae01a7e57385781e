"""The page of `recurse stills` in headless Chromium: python3 stillsPageTest.py PROGRAM.

It must load without errors and without any network, and show the same values of a pixel as the program for stills.exr.
"""

import base64
import json
import os
import re
import struct
import zlib

from pageTest import SCENE, OfflinePage, browser, main, recurse

SIZE = 32
PIXEL = (20, 23)
# Half floats have eleven bits, and the page prints four digits.
TOLERANCE = 2 ** -11 + 5.1e-4


def pixelOf(folder, pixel):
    """{layer: [r, g, b]} of stills.exr, as the program prints it; the whole picture is layer ''."""
    out = {}
    for line in recurse("info", folder + "/stills.exr", "--pixel", "%d,%d" % pixel).splitlines():
        channel, value = line.split()
        layer, _, colour = channel.rpartition(".")
        out.setdefault(layer, [0, 0, 0])["RGB".index(colour)] = float(value)
    return out


def sumOf(colours):
    return [sum(c) for c in zip([0, 0, 0], *colours)]


def displayed(linear, exposure):
    x = min(max(linear * 2 ** exposure, 0), 1)
    return 255 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055)


def linear(byte):
    x = byte / 255
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


# Three lamps of different kinds, one of them without a name.
LAMPS = """
Film "rgb" "integer xresolution" 32 "integer yresolution" 32
LookAt 0 -5 1.6  0 0 .8  0 0 1
Camera "perspective" "float fov" 45
WorldBegin
Material "diffuse" "rgb reflectance" [ .7 .6 .5 ]
Shape "bilinearmesh" "point3 P" [ -2 -2 0  2 -2 0  -2 2 0  2 2 0 ]
Shape "bilinearmesh" "point3 P" [ -2 2 0  2 2 0  -2 2 3  2 2 3 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 9 8 7 ] "string name" "key \\"left\\""
Translate -.6 0 .8
Shape "sphere" "float radius" .25
AttributeEnd
LightSource "spot" "point3 from" [ 0 -1 2.6 ] "point3 to" [ 1 1 .5 ] "rgb I" [ 6 5 4 ] "float coneangle" 40
LightSource "infinite" "rgb L" [ .2 .25 .4 ] "string name" "sky"
"""


class StillsPage(OfflinePage):
    @classmethod
    def make(cls):
        folder = cls.temporary.name
        cls.photons, cls.path, cls.overlap = folder + "/photons", folder + "/path", folder + "/overlap"
        common = (SCENE, "-q", "--resolution", "%dx%d" % (SIZE, SIZE), "--spp", "4")
        recurse("stills", *common, "-o", cls.photons, "--integrator", "photonmap", "--photons", "20k")
        recurse("stills", *common, "-o", cls.path, "--integrator", "path", "--compare", cls.photons)
        recurse("stills", *common, "-o", cls.overlap, "--class", "a=LD+E", "--class", "b=L[SD]E")
        cls.lamps = folder + "/lamps"
        with open(folder + "/scene.pbrt", "w", encoding="utf-8") as file:
            file.write(LAMPS)
        recurse("stills", folder + "/scene.pbrt", "-q", "--spp", "64", "--integrator", "path", "-o", cls.lamps,
                "--by", "light")

    def open(self, folder):
        browser.open(folder + "/index.html", "document.body.dataset.ready")
        browser.settle()
        self.names = browser.evaluate("[...document.querySelectorAll('#classes b')].map((b) => b.textContent)")

    def values(self, selector):
        return [float(v) for v in self.text(selector).split()]

    def markPixel(self):
        browser.clickAt(*self.place(PIXEL, SIZE))
        self.assertEqual(self.text("#pixelPlace"), "x %d  y %d" % PIXEL)

    def assertColours(self, shown, expected, what=""):
        self.assertEqual(len(shown), 3, what)
        for a, b in zip(shown, expected):
            self.assertAlmostEqual(a, b, delta=TOLERANCE * abs(b) + 1e-9, msg=f"{what} {shown} {expected}")

    def assertShows(self, linear):
        """Checks the picture itself in addition to the numbers beside it."""
        exposure = float(self.text("#exposureText").replace("−", "-"))
        for shown, value in zip(self.colourAt(PIXEL, SIZE), linear):
            # The exposure is printed with one digit after the point.
            low, high = displayed(value, exposure - 0.06), displayed(value, exposure + 0.06)
            self.assertTrue(low - 1.5 <= shown <= high + 1.5, (shown, low, high))

    def checkbox(self, index):
        return f"document.querySelectorAll('#classes input[type=checkbox]')[{index}]"

    def testPixelsAreStoredExactlyEnough(self):
        with open(self.photons + "/index.html", encoding="utf-8") as file:
            data = json.loads(re.search(r'id="data">(.*?)</script>', file.read(), re.S).group(1))
        self.assertEqual((data["width"], data["height"]), (SIZE, SIZE))
        layers = {layer["name"]: layer for layer in data["sets"][0]["layers"]}
        pixels = {}
        for name, layer in layers.items():
            if "pixels" in layer:
                planes = zlib.decompress(base64.b64decode(layer["pixels"]))
                half = len(planes) // 2
                both = bytes(b for pair in zip(planes[half:], planes[:half]) for b in pair)
                pixels[name] = [v / 2 ** layer["scale"] for v in struct.unpack("<%de" % half, both)]
        for at in ((0, 0), (SIZE - 1, 0), (5, 30), PIXEL):
            expected = pixelOf(self.photons, at)
            self.assertEqual(set(pixels), set(expected) - {""})
            for name, planes in pixels.items():
                for c in range(3):
                    stored, true = planes[c * SIZE * SIZE + at[1] * SIZE + at[0]], expected[name][c]
                    self.assertLessEqual(abs(stored - true), 2 ** -11 * abs(true), (name, at, c))

    def testTogglingClassesChangesTheSum(self):
        self.open(self.photons)
        expected = pixelOf(self.photons, PIXEL)
        self.assertEqual(set(self.names), set(expected) - {""})
        self.markPixel()
        self.assertColours(self.values("#beautyValue"), expected[""], "beauty")
        self.assertColours(self.values("#sumValue"), expected[""], "everything")
        self.assertColours(self.values("#pixelShown"), expected[""], "shown")
        self.assertShows(expected[""])
        ticked = dict.fromkeys(self.names, True)
        brightest = sorted(self.names, key=lambda n: -sum(expected[n]))
        for name in (brightest[0], brightest[1], brightest[0]):
            browser.click(self.checkbox(self.names.index(name)))
            ticked[name] = not ticked[name]
            total = sumOf(expected[n] for n in self.names if ticked[n])
            self.assertColours(self.values("#sumValue"), total, name)
            self.assertColours(self.values("#pixelShown"), total, name)
            self.assertShows(total)
        browser.click("document.getElementById('tickNone')")
        self.assertColours(self.values("#sumValue"), [0, 0, 0], "none")
        self.assertShows([0, 0, 0])
        browser.click("document.getElementById('tickAll')")
        self.assertColours(self.values("#sumValue"), expected[""], "all")

    def testClassesAreShownLarge(self):
        self.open(self.photons)
        expected = pixelOf(self.photons, PIXEL)
        self.markPixel()
        for index, name in enumerate(self.names):
            browser.click(f"document.querySelectorAll('#classes button')[{index}]")
            self.assertEqual(self.text("#nameA"), name)
            self.assertColours(self.values("#pixelShown"), expected[name], name)
            self.assertColours(self.values(f"#classes li:nth-child({index + 1}) .value"), expected[name], name)
            browser.click("document.getElementById('ownExposure')")
            self.assertShows(expected[name])

    def testKeyboard(self):
        self.open(self.photons)
        expected = pixelOf(self.photons, (17, 15))
        browser.evaluate("document.getElementById('view').focus()")
        for key in ("ArrowRight", "ArrowRight", "ArrowUp"):
            browser.key(key)
        self.assertEqual(self.text("#pixelPlace"), "x 17  y 15")
        self.assertColours(self.values("#beautyValue"), expected[""])
        browser.key("2", "Digit2")
        self.assertEqual(self.text("#nameA"), self.names[1])
        browser.key("0", "Digit0")
        self.assertEqual(self.text("#nameA"), "beauty")
        browser.key("@", "Digit2", shift=True)
        self.assertFalse(browser.evaluate(self.checkbox(1) + ".checked"))
        others = [expected[n] for n in self.names if n != self.names[1]]
        self.assertColours(self.values("#sumValue"), sumOf(others))
        before = float(self.text("#exposureText").replace("−", "-"))
        browser.key("]")
        self.assertAlmostEqual(float(self.text("#exposureText").replace("−", "-")), before + 0.5, delta=0.11)
        zoom = int(self.text("#zoomText").split()[0])
        browser.key("+")
        self.assertEqual(int(self.text("#zoomText").split()[0]), 2 * zoom)
        browser.key("f")
        self.assertEqual(int(self.text("#zoomText").split()[0]), zoom)
        browser.key("Escape")
        self.assertNotIn("x 17", self.text("#pixelPlace"))

    def testComparesIntegrators(self):
        self.open(self.path)
        path, photons = pixelOf(self.path, PIXEL), pixelOf(self.photons, PIXEL)
        self.assertIn("path", self.text("#nameA"))
        self.assertIn("photonmap", self.text("#nameB"))
        self.markPixel()
        self.assertColours(self.values("#pixelShown"), path[""])
        self.assertColours(self.values("#pixelCompared"), photons[""])
        self.assertShows(photons[""])  # the slider is in the middle, the pixel to the right of it
        for _ in range(25):
            browser.key(".")
        self.assertShows(path[""])
        # A class is compared with the same class of the second render.
        browser.click("document.querySelectorAll('#classes button')[1]")
        self.assertTrue(self.text("#nameB").startswith(self.names[1]), self.text("#nameB"))
        self.assertColours(self.values("#pixelCompared"), photons[self.names[1]])
        browser.key("s")
        browser.key("c")
        self.assertTrue(browser.evaluate("document.getElementById('nameB').hidden"))
        self.assertShows(path[""])
        # Two classes of one render.
        browser.evaluate("(() => { const s = document.getElementById('compare');"
                         "s.selectedIndex = 3; s.dispatchEvent(new Event('change')); })()")
        self.assertTrue(self.text("#nameB").startswith(self.names[0]), self.text("#nameB"))
        self.assertColours(self.values("#pixelCompared"), path[self.names[0]])

    def setPower(self, index, stops=None, colour=None):
        for name, value in (("stops", stops), ("colour", colour)):
            if value is not None:
                browser.evaluate(f"(() => {{ const i = document.querySelectorAll('#classes .{name}')[{index}];"
                                 f"i.value = '{value}'; i.dispatchEvent(new Event('input')); }})()")

    def saved(self, button):
        """Name and content of the file that the button saves."""
        name, content = browser.evaluate(
            "new Promise((done) => { let name, content; const tell = () => { if (name && content) done([name, content]); };"
            "URL.createObjectURL = (blob) => { const reader = new FileReader();"
            "reader.onload = () => { content = reader.result; tell(); }; reader.readAsDataURL(blob); return '#'; };"
            "HTMLAnchorElement.prototype.click = function () { name = this.download; tell(); };"
            f"document.getElementById('{button}').click(); }})")
        return name, base64.b64decode(content.split(",")[1])

    @staticmethod
    def layersOf(folder):
        with open(folder + "/index.html", encoding="utf-8") as file:
            data = json.loads(re.search(r'id="data">(.*?)</script>', file.read(), re.S).group(1))
        return {layer["name"]: layer for layer in data["sets"][0]["layers"]}

    def testPowersOfLampsChangeTheSumAtOnce(self):
        self.open(self.lamps)
        expected = pixelOf(self.lamps, PIXEL)
        self.assertEqual(self.names, ["key-left", "light-2", "sky"])
        self.markPixel()
        before = self.text("#exposureText")
        self.setPower(0, stops=-2)
        self.setPower(2, stops=1.5, colour="#ff8040")
        factors = {"key-left": [0.25] * 3, "light-2": [1] * 3,
                   "sky": [2 ** 1.5 * linear(byte) for byte in (0xff, 0x80, 0x40)]}
        total = [sum(expected[n][c] * factors[n][c] for n in self.names) for c in range(3)]
        self.assertColours(self.values("#sumValue"), total)
        self.assertColours(self.values("#pixelShown"), total)
        self.assertShows(total)
        self.assertEqual(self.text("#exposureText"), before, "the exposure is kept")
        browser.click("document.getElementById('keepExposure')")
        self.assertNotEqual(self.text("#exposureText"), before, "the exposure follows")
        self.assertShows(total)
        name, png = self.saved("savePng")
        self.assertEqual(name, "scene-relit.png")
        self.assertTrue(png.startswith(b"\x89PNG"))
        self.assertEqual(struct.unpack(">II", png[16:24]), (SIZE, SIZE))
        browser.click("document.getElementById('resetPowers')")
        self.assertColours(self.values("#sumValue"), expected[""])

    def testSavedSceneHasThePowersOfThePage(self):
        self.open(self.lamps)
        self.setPower(0, stops=-2)
        self.setPower(1, colour="#80ff40")
        browser.click(self.checkbox(2))
        name, text = self.saved("saveScene")
        self.assertEqual(name, "scene-relit.pbrt")
        folder = os.path.dirname(self.lamps)
        with open(folder + "/" + name, "wb") as file:
            file.write(text)
        relit = folder + "/relit"
        recurse("stills", folder + "/" + name, "-q", "--spp", "64", "--integrator", "path", "-o", relit, "--by", "light")
        factors = [[0.25] * 3, [linear(byte) for byte in (0x80, 0xff, 0x40)], [0] * 3]
        before, after = self.layersOf(self.lamps), self.layersOf(relit)
        self.assertEqual(set(before), set(after))
        for layer, factor in zip(self.names, factors):
            for c in range(3):
                expected = before[layer]["mean"][c] * factor[c]
                self.assertAlmostEqual(after[layer]["mean"][c], expected, delta=0.03 * expected + 1e-9, msg=(layer, c))

    def testSceneIsSavedForLampsOnly(self):
        self.open(self.photons)
        self.assertTrue(browser.evaluate("document.getElementById('saveScene').hidden"))

    def testOverlapsAreTold(self):
        self.open(self.overlap)
        expected = pixelOf(self.overlap, PIXEL)
        self.assertEqual(self.names, ["a", "b", "rest"])
        self.assertIn("overlap", self.text("#remarks"))
        self.markPixel()
        self.assertEqual(self.text("#nameA"), "beauty")
        self.assertColours(self.values("#pixelShown"), expected[""])
        self.assertColours(self.values("#sumValue"), sumOf(expected[n] for n in self.names))


if __name__ == "__main__":
    main()
