"""The page of `recurse develop -o PAGE.html` in headless Chromium: python3 developPageTest.py PROGRAM.

Whatever its sliders say, it must show what `recurse develop` makes of the picture.
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
SIZE = 32
PIXELS = ((20, 23), (5, 5), (16, 2), (15, 1), (9, 28), (30, 16), (1, 6), (2, 6))  # the last two on bright edges
browser = None


def recurse(*arguments):
    return subprocess.run([PROGRAM, *arguments], check=True, stdout=subprocess.PIPE, text=True).stdout


def encoded(x):
    return 255 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055)


class DevelopPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="recurse-develop-page-")
        cls.folder = cls.temporary.name
        recurse("render", SCENE, "-q", "--resolution", "%dx%d" % (SIZE, SIZE), "--integrator", "path", "--spp", "8",
                "-o", cls.folder + "/picture.exr")
        recurse("develop", cls.folder + "/picture.exr", "-q", "-o", cls.folder + "/page.html")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def tearDown(self):
        self.assertEqual(browser.complaints, [])
        self.assertEqual([url for url in browser.requests if not url.startswith(("file:", "data:", "blob:"))], [])

    def shown(self, pixel):
        """Colour of the window at the centre of a pixel; the picture is fitted into the stage."""
        return browser.evaluate(
            "(() => { const v = document.getElementById('view'), d = v.width / v.getBoundingClientRect().width;"
            "const zoom = parseInt(document.getElementById('zoomText').textContent) / 100;"
            f"const place = (size, i) => (size / d - {SIZE} * zoom) / 2 + (i + 0.5) * zoom;"
            "const c = document.createElement('canvas').getContext('2d', { willReadFrequently: true });"
            f"c.drawImage(v, place(v.width, {pixel[0]}) * d, place(v.height, {pixel[1]}) * d, 1, 1, 0, 0, 1, 1);"
            "return [...c.getImageData(0, 0, 1, 1).data];"
            " })()")[:3]

    def developed(self, exposure, operator, *more):
        """Bytes of the program's own picture."""
        path = self.folder + "/developed.png"
        recurse("develop", self.folder + "/picture.exr", "-q", "-o", path, "--exposure", exposure, "--tonemap", operator,
                *more)
        out = []
        for pixel in PIXELS:
            lines = recurse("info", path, "--pixel", "%d,%d" % pixel).splitlines()
            out.append([round(encoded(float(line.split()[1]))) for line in lines[:3]])
        return out

    def choose(self, exposure, operator):
        browser.evaluate(
            "(() => { const e = document.getElementById('exposure'), o = document.getElementById('operator');"
            f"o.value = {json.dumps(operator)}; o.dispatchEvent(new Event('change'));"
            f"e.value = {exposure}; e.dispatchEvent(new Event('input')); }})()")
        browser.settle()

    def testShowsWhatTheProgramMakes(self):
        browser.open(self.folder + "/page.html", "document.body.dataset.ready")
        browser.settle()
        self.compare(self.developed("auto", "filmic"), "as it opens")
        names = browser.evaluate("[...document.getElementById('operator').options].map((o) => o.value)")
        self.assertEqual(names, ["none", "filmic", "aces", "reinhard", "drago", "dodgeburn", "durand"])
        for operator in names:
            for exposure in (-1.5, 2):
                self.choose(exposure, operator)
                self.compare(self.developed(str(exposure), operator), f"{operator} {exposure}")
        browser.evaluate("document.getElementById('automatic').click()")
        browser.settle()
        self.compare(self.developed("auto", names[-1]), "automatic again")

    def testShowsEdgesOfLampsInTheirGlare(self):
        bloom = ("--bloom", "0.2")
        recurse("develop", self.folder + "/picture.exr", "-q", "-o", self.folder + "/bloom.html", *bloom)
        browser.open(self.folder + "/bloom.html", "document.body.dataset.ready")
        browser.settle()
        self.compare(self.developed("auto", "filmic", *bloom), "as it opens")
        self.choose(3, "aces")
        self.compare(self.developed("3", "aces", *bloom), "brighter")

    def compare(self, expected, what):
        for pixel, colour in zip(PIXELS, expected):
            shown = self.shown(pixel)
            self.assertLessEqual(max(abs(a - b) for a, b in zip(shown, colour)), 1, (what, pixel, shown, colour))

    def testWhatPagesHaveNotIsRefused(self):
        for more in (("--tonemap", 'durand "float sigmarange" 0.2'), ("--sheet",)):
            done = subprocess.run([PROGRAM, "develop", self.folder + "/picture.exr", "-q", "-o",
                                   self.folder + "/other.html", *more], stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 2, done.stderr)


if __name__ == "__main__":
    if not PROGRAM:
        sys.exit("usage: python3 developPageTest.py PROGRAM")
    try:
        browser = Browser()
    except BrowserError as error:
        sys.exit(f"The page cannot be tested: {error}")
    try:
        outcome = unittest.main(argv=sys.argv[:1] + sys.argv[2:], exit=False, verbosity=2).result
    finally:
        browser.close()
    sys.exit(not outcome.wasSuccessful())
