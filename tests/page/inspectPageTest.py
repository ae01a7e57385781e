"""The page of `recurse inspect` in headless Chromium: python3 inspectPageTest.py PROGRAM.

It must load without errors and without any network, draw the scene, and answer to clicks on pixels and surfaces.
"""

import base64
import functools
import itertools
import json
import os
import re
import struct
import subprocess
import time
import zlib

import browser as chromium

chromium.FLAGS = [flag for flag in chromium.FLAGS if flag != "--disable-gpu"] + chromium.WEBGL_FLAGS

from pageTest import PROGRAM, SCENE, OfflinePage, browser, main, recurse  # noqa: E402 (the browser starts at once)

EXPRESSION_SCRIPT = os.path.join(os.path.dirname(SCENE), "..", "..", "src", "report", "inspect", "pathExpression.js")
PIXELS = [(24, 40), (4, 30), (44, 30)]
REFERENCE = (44, 30)  # on a matt wall


class InspectPage(OfflinePage):
    @classmethod
    def make(cls):
        cls.page = cls.temporary.name + "/page.html"
        pixels = [word for x, y in PIXELS for word in ("--pixel", f"{x},{y}")]
        recurse("inspect", SCENE, "-o", cls.page, "-q", "--integrator", "photonmap", "--photons", "20k", "--spp", "4",
                "--resolution", "48x48", "--path-samples", "4", "--shown-light-paths", "400", *pixels)
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")
        cls.data = browser.evaluate("JSON.parse(document.getElementById('data').textContent)")

    def setUp(self):
        browser.settle()

    def change(self, name, property, value, event="input"):
        browser.evaluate(f"(() => {{ const e = document.getElementById('{name}'); e.{property} = {json.dumps(value)};"
                         f"e.dispatchEvent(new Event('{event}')); }})()")
        browser.settle()

    def clickPixel(self, x, y):
        """Colour of the picture, which is square."""
        browser.clickAt(*browser.evaluate(
            "(() => { const c = document.getElementById('picture'); c.scrollIntoView({block: 'nearest'});"
            "const b = c.getBoundingClientRect(), s = Math.min(b.width, b.height);"
            f"return [b.left + (b.width - s) / 2 + s * {(x + 0.5) / 48}, b.top + (b.height - s) / 2 + s * {(y + 0.5) / 48}];"
            "})()"))

    def colours(self):
        """Number of different colours in the view."""
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
        recorded = self.data["pixels"][-1]
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
        self.assertIn("column 3: the expression ends too early", self.text("#filterReason"))
        self.change("filter", "value", "")
        self.assertTrue(browser.evaluate("document.getElementById('filterReason').hidden"))
        whole = self.segments()
        browser.click("document.querySelectorAll('#contributions tr')[1]")
        self.assertLess(self.segments(), whole)
        self.assertEqual(self.texts("#vertices tr td:first-child")[0], "E")
        self.assertEqual(self.texts("#vertices tr td:first-child")[-1], "L")
        browser.click("document.querySelector('#classes input')")
        self.assertLess(len(self.texts("#contributions tr")) - 1, len(self.data["pixels"][1]["contributions"]))
        browser.click("document.querySelector('#classes input')")

    def words(self, filter):
        self.change("filter", "value", filter)
        self.assertEqual(self.text("#filterReason"), "", filter)
        return self.texts("#contributions tr td:nth-child(2)")

    def test4FiltersAreExpressionsOfClasses(self):
        self.clickPixel(*PIXELS[1])
        whole = self.words("")
        # Paths with unknown events may be on both sides.
        known = lambda words: sorted(word for word in words if "…" not in word)
        inside, outside = self.words("LDE"), self.words("!(LDE)")
        self.assertEqual(known(inside + outside), known(whole))
        self.assertEqual(set(inside + outside), set(whole))
        self.assertEqual(known(inside), ["LDE"] * whole.count("LDE"))
        self.assertGreater(len(known(outside)), 0)
        for filter, isIn in {"L[SD]*DE": lambda w: w.endswith("DE"), "L[^S]*E": lambda w: "S" not in w,
                             "L.*E - LDE": lambda w: w != "LDE", "caustic": lambda w: re.fullmatch("LS+DS*E", w),
                             "direct & LDE": lambda w: w in ("LDE", "L…DE")}.items():
            found = self.words(filter)
            self.assertLessEqual({w for w in whole if "…" not in w and isIn(w)}, set(found), filter)
            self.assertTrue(all("…" in w or isIn(w) for w in found), filter)
        lamp = self.data["lamps"][0]
        self.assertEqual(sorted(self.words(f"L'{lamp}'.*E")), sorted(whole))
        # The surface that the pixel shows.
        pixel = self.data["pixels"][PIXELS.index(PIXELS[1])]
        seen = self.data["names"][pixel["vertices"][0][8][0]]
        self.assertEqual(set(self.words(f"L.*D'{seen}'E")), {w for w in whole if w.endswith("DE")})
        other = next(name for name in self.data["surfaceNames"]
                     if name not in [self.data["names"][i] for i in pixel["vertices"][0][8]])
        self.assertFalse([w for w in self.words(f"L.*D'{other}'E")])
        self.change("filter", "value", "L'nosuch'DE")
        self.assertIn("the scene has no light named 'nosuch'; accepted: '", self.text("#filterReason"))
        self.change("filter", "value", "")

    def test4TheSegmentFromTheCameraIsHiddenInItsView(self):
        self.clickPixel(*PIXELS[1])
        browser.click("document.querySelector('[data-view=top]')")
        self.assertEqual(browser.evaluate("document.getElementById('view').dataset.segmentsFromCamera"), "shown")
        browser.click("document.querySelector('[data-view=camera]')")
        self.assertEqual(browser.evaluate("document.getElementById('view').dataset.segmentsFromCamera"), "hidden")

    def test5PhotonsAreColouredByDepth(self):
        depths = self.decoded("photons", "depths", type="B")
        kinds = self.decoded("photons", "kinds", type="B")
        self.assertEqual(self.data["depths"], 8)
        self.assertLessEqual(set(depths), set(range(1, 9)))
        # Classes of one length have the depth of that length.
        known = {"direct-diffuse": 1, "interreflection-1": 2, "interreflection-2": 3, "interreflection-3": 4}
        names = [c["name"] for c in self.data["classes"]]
        counted = 0
        for depth, kind in zip(depths, kinds):
            expected = known.get(names[kind & 127]) if kind & 127 < len(names) else None
            if expected is not None:
                self.assertEqual(depth, expected)
                counted += 1
        self.assertGreater(counted, 100)
        self.change("showPhotons", "checked", True)
        colours = self.colours()
        self.change("photonColour", "value", "depth")
        self.assertGreater(self.colours(), 10)
        legend = self.texts("#depthLegend li")
        self.assertEqual(sum(int(text.split(": ")[1]) for text in legend), len(depths))
        self.assertEqual(len(legend), len(set(depths)))
        self.change("photonColour", "value", "class")
        self.assertTrue(browser.evaluate("document.getElementById('depthLegend').hidden"))
        self.change("showPhotons", "checked", False)
        self.assertGreater(colours, 10)

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

    def decoded(self, *path, type):
        """Numbers of an encoded array of the page's data."""
        code = base64.b64decode(functools.reduce(lambda data, key: data[key], path, self.data))
        planes, stride = zlib.decompress(code), struct.calcsize(type)
        count = len(planes) // stride
        whole = bytes(planes[k * count + i] for i in range(count) for k in range(stride))
        return struct.unpack(f"<{count}{type}", whole)

    def flight(self, name):
        return float(browser.evaluate(f"document.getElementById('view').dataset.{name}"))

    def test6LightFliesAndIsStored(self):
        paths = self.data["lightPaths"]
        self.assertLessEqual(paths["paths"], 400)
        self.assertGreater(paths["count"], paths["paths"])
        self.change("showPhotons", "checked", False)
        self.change("flightTime", "value", 0.3)
        self.assertGreater(self.flight("flying"), 5)
        landed, colours = self.flight("landed"), self.colours()
        self.change("flightTime", "value", 1)
        self.assertEqual(self.flight("flying"), 0)
        kinds = self.decoded("lightPaths", "kinds", type="B")
        self.assertEqual(self.flight("landed"), sum(kind & 4 != 0 for kind in kinds))
        self.assertGreater(self.flight("landed"), landed)
        self.assertGreater(colours, 10)

    def test6PlayMovesTheLightUntilItIsPaused(self):
        self.change("flightTime", "value", 0)
        self.change("flightSpeed", "value", 0.5)
        browser.click("document.getElementById('play')")
        time.sleep(0.5)
        self.assertEqual(self.text("#play"), "Pause")
        browser.click("document.getElementById('play')")
        self.assertEqual(self.text("#play"), "Play")
        at = self.flight("flightTime")
        self.assertGreater(at, 0)
        time.sleep(0.2)
        self.assertEqual(self.flight("flightTime"), at)

    def test6AClassOfLightIsAPartOfIt(self):
        self.change("flightTime", "value", 1)
        whole = self.flight("landed")
        names = self.texts("#flightClass option")
        self.assertIn("caustic", names)
        self.change("flightClass", "selectedIndex", names.index("caustic"))
        self.change("flightTime", "value", 1)
        self.assertGreater(self.flight("landed"), 0)
        self.assertLess(self.flight("landed"), whole)
        self.change("flightMode", "value", "pulse")
        self.change("flightTime", "value", 0.01)
        self.assertGreater(self.flight("flying"), self.flight("landed"))
        flying = self.flight("flying")
        self.change("flightClass", "value", "all")
        self.assertGreater(self.flight("flying"), 2 * flying)  # light that ends elsewhere does not fly
        self.change("flightMode", "value", "stream")
        self.change("flightClass", "value", "all")

    def test7TheBoxesOfTheTreeBoundThePhotons(self):
        """The page has all photons in the order of the tree, so that each box has the next ones of its map."""
        self.assertEqual(self.data["photons"]["count"], self.data["photons"]["inMap"])
        bounds, levels = self.decoded("boxes", "bounds", type="f"), self.decoded("boxes", "levels", type="B")
        caustic, sizes = self.decoded("boxes", "caustic", type="B"), self.decoded("boxes", "photons", type="I")
        positions, kinds = self.decoded("photons", "positions", type="f"), self.decoded("photons", "kinds", type="B")
        self.assertEqual(set(caustic), {0, 1})
        for isCaustic in (0, 1):
            photons = [positions[3 * i:3 * i + 3] for i in range(len(kinds)) if (kinds[i] >= 128) == isCaustic]
            at = 0
            for i in range(len(levels)):
                isLeaf = i + 1 == len(levels) or levels[i + 1] <= levels[i]
                if caustic[i] != isCaustic or not isLeaf:
                    continue
                own = photons[at:at + sizes[i]]
                at += sizes[i]
                for axis in range(3):
                    self.assertEqual(bounds[6 * i + axis], min(p[axis] for p in own))
                    self.assertEqual(bounds[6 * i + 3 + axis], max(p[axis] for p in own))
            self.assertEqual(at, len(photons))

    def test7TheBoxesOfALevelAreDrawn(self):
        self.change("showBoxes", "checked", True)
        self.change("boxLevel", "value", 0)
        self.assertEqual(self.flight("boxes"), 2)
        self.assertIn("2 boxes after 0 splits", self.text("#boxStatus"))
        self.change("boxMap", "value", "0")
        for level, boxes in ((1, 2), (3, 8)):
            self.change("boxLevel", "value", level)
            self.assertEqual(self.flight("boxes"), boxes)
        self.change("boxMap", "value", "all")
        self.change("showBoxes", "checked", False)
        self.assertEqual(self.flight("boxes"), 0)

    def estimateRows(self):
        return dict(zip(self.texts("#estimateText dt"), self.texts("#estimateText dd")))

    def test8TheEstimateOfAPixelStandsBesidePathTracing(self):
        self.clickPixel(*REFERENCE)
        browser.click("document.getElementById('atPixel')")
        self.change("number", "value", 0.8)
        rows = self.estimateRows()
        reference = [r for r in self.data["references"] if (r["x"], r["y"]) == REFERENCE][0]
        red = float(rows["path tracing, red green blue"].split()[0])
        self.assertAlmostEqual(red / reference["irradiance"][0], 1, delta=0.01)
        y, error = (float(x) for x in rows["luminance"].split(" ± "))
        expected = 0.2126 * reference["irradiance"][0] + 0.7152 * reference["irradiance"][1] \
            + 0.0722 * reference["irradiance"][2]
        self.assertLess(abs(y - expected), 4 * error + 0.1 * expected)
        self.assertIn("standard errors", rows["difference"])
        for axis in ("number", "radius"):
            self.change("curveAxis", "value", axis)
            self.assertGreater(self.ink("curve"), 500)

    def ink(self, canvas):
        """Number of pixels of a canvas that are not empty."""
        return browser.evaluate(
            f"(() => {{ const from = document.getElementById('{canvas}'), c = document.createElement('canvas');"
            "const context = c.getContext('2d', { willReadFrequently: true });"
            "[c.width, c.height] = [from.width, from.height]; context.drawImage(from, 0, 0);"
            "return context.getImageData(0, 0, c.width, c.height).data.filter((x, i) => i % 4 === 3 && x > 0).length; })()")

    def test8PixelsOnMirrorsHaveNoReference(self):
        known = {(r["x"], r["y"]) for r in self.data["references"]}
        self.assertIn(REFERENCE, known)
        for pixel in PIXELS:
            self.clickPixel(*pixel)
            self.assertEqual(browser.evaluate("document.getElementById('atPixel').disabled"), pixel not in known)


# Expressions that `recurse classes` accepts, and some that it refuses.
EXPRESSIONS = ["LE", "LDE", "L[SD]*DE", "L[^S]*E", "!(LDE)", "L.*E - LDE", "L(S|D)*E", "LS+DS*E", "L[LS+|LD]E", "L[S|D]E",
               "L.{2,3}E", "L(SD){2}E", "LD{2,}E", "caustic", "all - direct", "direct & LDE", "!!LDE", "!direct",
               "L.*E & !(L.*SE) & !(LE)", "(LDE - LSE) | LE", "L(D|S?)*E", "L(S*)(D*)E", "L (S | D) * E", "L(D*S)?(.|DD)E",
               "LV+E", "L[^SD]*E", "L[VSD]*E", "L((((D))))E", "medium", "sds", "all - (LE|LDE|LS+E)", "(L|LD)(E|SE)",
               "L(S{0}D){1,2}E", "LLE", "LDE|LSE & LE", "![LDE|LSE]", "all", "L(.D)*E - !(L.*DE)"]
NAMED = ["L'lamp'DE", "L'lamp'.*E", "L[^D'floor']*E", "LD'floor'[SD]*E", "!(L'lamp'DE)", "L[S'pane'D]*E", "L.*E - L'it''s'.*E",
         "L'a'(D|S'b')*E", "L D 'floor' E", "L[^SD'floor']*E"]
REFUSED = ["L(", "L)E", "LDE)", "", "L**E", "L(D", "*E", "L[SD", "L[]E", "L[^]E", "L[^SDV]E", "L[^S|D]E", "L{2", "L{2E", "LD{}E",
           "LD{3,2}E", "LD{1001}E", "LD{2}{3}E", "LD+?E", "LXE", "lde", "L1E", "L^DE", "LDE$", "LD}E", "L|", "|LE", "LE &", "- LE",
           "LE - LDE | LSE", "LE | LDE - LSE", "directE", "direct*", "L!DE", "'lamp'LE", "LD'floorE", "LV'fog'E", "LE'eye'",
           "nosuchclass", "Lü", "L[(S)]E", "L(LE & LDE", "ü" * 3, "L D\t E ]"]


class Expressions(OfflinePage):
    """The page reads path expressions as the program does."""

    @classmethod
    def make(cls):
        cls.page = cls.temporary.name + "/page.html"
        recurse("inspect", SCENE, "-o", cls.page, "-q", "--integrator", "path", "--spp", "1", "--resolution", "8x8")
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")
        with open(EXPRESSION_SCRIPT, encoding="utf-8") as file:
            browser.evaluate(file.read() + "Object.assign(globalThis, { PathExpression, wordOf }); 0")

    def inPage(self, expression, words):
        """Which words the expression contains; a pair [column, reason] if it is refused."""
        return browser.evaluate(
            "(() => { const data = JSON.parse(document.getElementById('data').textContent);"
            "try { const e = new PathExpression(%s, { lights: null, surfaces: null, classes: data.namedClasses });"
            "return %s.map((w) => e.contains(wordOf(w))); } catch (error) { return [error.column, error.reason]; } })()"
            % (json.dumps(expression), json.dumps(words)))

    def inProgram(self, expression, events):
        text = recurse("classes", "x=" + expression, "--events", str(events), "--examples", "1000").split("\n\n")[0]
        return {word for line in re.findall(r"^  \d+ events?:(.*)$", text, re.MULTILINE)
                for word in re.findall(r"L(?:'(?:[^']|'')*')?[^ ]*?E(?= |$)", line)}

    def compare(self, expression, names, events):
        lights = ["L"] + [f"L'{name}'" for name in names]
        surfaces = ["S", "D", "V"] + [f"{letter}'{name}'" for name in names for letter in "SD"]
        words = [light + "".join(path) + "E" for light in lights for n in range(events + 1)
                 for path in itertools.product(surfaces, repeat=n)]
        found = self.inPage(expression, words)
        self.assertEqual(len(found), len(words), f"{expression}: {found[:2]}")
        self.assertEqual({w for w, isIn in zip(words, found) if isIn}, self.inProgram(expression, events), expression)

    def test1TheSameWords(self):
        for expression in EXPRESSIONS:
            self.compare(expression, [], 4)

    def test2TheSameWordsWithNames(self):
        for expression in NAMED:
            names = sorted({name for name in re.findall(r"'((?:[^']|'')*)'", expression)})
            self.compare(expression, names, 2)

    def test3TheSameReasons(self):
        for expression in REFUSED:
            with self.assertRaises(subprocess.CalledProcessError) as refused:
                subprocess.run([PROGRAM, "classes", "--", expression], check=True, capture_output=True, text=True)
            expected = re.search(r"path expression, column (\d+): ([^\n]*)", refused.exception.stderr)
            self.assertIsNotNone(expected, f"{expression}: {refused.exception.stderr}")
            found = self.inPage(expression, ["LE"])
            self.assertEqual(found[0], int(expected[1]), f"{expression}: {found[1]} | {expected[2]}")
            self.assertEqual(found[1], re.sub("; is it '.*'[?]$", "", expected[2]), expression)


FLOOR = """
Film "rgb" "integer xresolution" 32 "integer yresolution" 32
LookAt 0 0 6  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "distant" "rgb L" [ 2 2 2 ] "point3 from" [ 0 0 9 ] "point3 to" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 0 1 0  2 1 0  2 1 2  0 1 2 ]
"""


class EdgesOfAFloor(OfflinePage):
    """A square floor in uniform light, with a wall across a part of it."""

    @classmethod
    def make(cls):
        scene = cls.temporary.name + "/floor.pbrt"
        with open(scene, "w", encoding="utf-8") as file:
            file.write(FLOOR)
        cls.page = cls.temporary.name + "/page.html"
        pixels = [word for x, y in ((16, 16), (2, 16), (8, 9)) for word in ("--pixel", f"{x},{y}")]
        recurse("inspect", scene, "-o", cls.page, "-q", "--integrator", "simplephotonmap", "--photons", "60k", "--spp", "1",
                *pixels)
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")
        cls.data = browser.evaluate("JSON.parse(document.getElementById('data').textContent)")

    def setUp(self):
        browser.settle()

    change, clickPixel, estimateRows = InspectPage.change, InspectPage.clickPixel, InspectPage.estimateRows

    def test3AMirrorStoresNoPhotons(self):
        scene = self.temporary.name + "/mirror.pbrt"
        with open(scene, "w", encoding="utf-8") as file:
            file.write(FLOOR + 'Material "conductor"\nShape "disk" "float radius" .5 "float height" .5\n')
        page = self.temporary.name + "/mirror.html"
        recurse("inspect", scene, "-o", page, "-q", "--integrator", "simplephotonmap", "--photons", "5k", "--spp", "1",
                "--reference-samples", "0")
        browser.open(page, "document.body.dataset.ready === 'yes'")
        browser.clickAt(*browser.evaluate("(() => { const b = document.getElementById('view').getBoundingClientRect();"
                                          "return [b.left + b.width / 2, b.top + .5 * b.height]; })()"))
        self.assertIn("none are stored here", self.estimateRows()["photons"])

    def coverage(self, radius, left, wall):
        """Fraction of the kernel on the floor: distances to its nearest edge across x, and to a wall across y."""
        inside = whole = 0
        n = 400
        for i in range(n):
            for j in range(n):
                x, y = ((2 * k + 1) / n - 1 for k in (i, j))
                q = x * x + y * y
                if q < 1:
                    whole += 1 - q
                    inside += (1 - q) * (x * radius > -left and y * radius < wall)
        return inside / whole

    def test1TheKernelIsCutAtEdgesAndWalls(self):
        for x, y in ((16, 16), (2, 16), (8, 9)):
            self.clickPixelOf(x, y)
            browser.click("document.getElementById('atPixel')")
            reference = [r for r in self.data["references"] if (r["x"], r["y"]) == (x, y)][0]
            at = [reference["position"][k] + self.data["origin"][k] for k in range(3)]
            for part in (0.5, 0.8, 0.95):
                self.change("radius", "value", part)
                rows, radius = self.estimateRows(), float(self.text("#radiusText"))
                if radius > (2 - abs(at[1])):
                    continue
                wall = 1 - at[1] if (x, y) == (8, 9) else 9
                found = float(rows["kernel on the surface"].split()[0]) / 100
                self.assertAlmostEqual(found, self.coverage(radius, 2 - abs(at[0]), wall), delta=0.04, msg=f"{at} {radius}")

    def test2TheEstimateHasNoBiasAtTheEdge(self):
        for x, y in ((16, 16), (2, 16)):
            self.clickPixelOf(x, y)
            browser.click("document.getElementById('atPixel')")
            self.change("number", "value", 0.85)
            rows = self.estimateRows()
            value, error = (float(part) for part in rows["luminance"].split(" ± "))
            reference = float(rows["path tracing, red green blue"].split()[0])
            self.assertAlmostEqual(reference, 2, delta=0.05)  # and a little from the wall
            self.assertLess(abs(value - reference), 4 * error + 0.04 * reference)

    def clickPixelOf(self, x, y):
        browser.clickAt(*browser.evaluate(
            "(() => { const c = document.getElementById('picture'); c.scrollIntoView({block: 'nearest'});"
            "const b = c.getBoundingClientRect(), s = Math.min(b.width, b.height);"
            f"return [b.left + (b.width - s) / 2 + s * {(x + 0.5) / 32}, b.top + (b.height - s) / 2 + s * {(y + 0.5) / 32}];"
            "})()"))


ON_WALL = f"{REFERENCE[0]},{REFERENCE[1]}"


class LightPathsOfBothSides(OfflinePage):
    """Connections, merges and virtual lights."""

    @classmethod
    def make(cls):
        cls.page = cls.temporary.name + "/page.html"

    def setUp(self):
        browser.settle()

    change = InspectPage.change

    def open(self, integrator, pixel="24,40"):
        recurse("inspect", SCENE, "-o", self.page, "-q", "--integrator", integrator, "--spp", "4", "--resolution", "48x48",
                "--path-samples", "4", "--pixel", pixel)
        browser.open(self.page, "document.body.dataset.ready === 'yes'")

    def drawPathsOf(self, technique):
        """Chooses the first path of a technique, and returns its word, its vertices and its segments."""
        browser.evaluate("(() => { for (const row of document.querySelectorAll('#contributions tr'))"
                         f"if (row.path?.technique === '{technique}') return row.click(); }})()")
        browser.settle()
        return (self.text("#word"), self.texts("#vertices tr td:nth-child(2)"),
                int(browser.evaluate("document.getElementById('view').dataset.segments")))

    def test1ConnectionsOfBdpt(self):
        self.open("bdpt")
        self.assertIn("vertices of light paths", self.text("#photonCount"))
        word, objects, segments = self.drawPathsOf("connection")
        self.assertRegex(word, "^L[SD]*DD[SD]*E$")
        self.assertIn("light path", objects)
        self.assertEqual(segments, len(word) - 1)  # an edge for each pair of successive vertices

    def test2MergesOfVcm(self):
        self.open("vcm")
        word, objects, segments = self.drawPathsOf("merge")
        self.assertRegex(word, "^L[SD]+D[SD]*E$")
        self.assertIn("light path", objects)
        self.assertEqual(segments, len(word))  # and one from the point to the photon
        self.change("showBoxes", "checked", True)
        self.assertGreater(int(browser.evaluate("document.getElementById('view').dataset.boxes")), 1)

    def test3VirtualLightsArePoints(self):
        self.open("vpl")
        self.assertIn("virtual point lights", self.text("#photonCount"))
        self.change("showPhotons", "checked", True)
        self.assertTrue(browser.evaluate("document.getElementById('boxPanel').hidden"))
        self.change("flightTime", "value", 1)
        self.assertGreater(int(browser.evaluate("document.getElementById('view').dataset.landed")), 10)
        word, objects, segments = self.drawPathsOf("connection")
        self.assertRegex(word, "^L[SD]*DD[SD]*E$")
        self.assertEqual(segments, len(word) - 1)

    def rows(self):
        """The table of vertices, as lists of cells."""
        return browser.evaluate("[...document.querySelectorAll('#vertices tr')].map((r) =>"
                                "[...r.cells].map((c) => c.textContent))")

    def test5TheTableHasEveryVertexOfBothSides(self):
        self.open("bdpt")
        for technique in ("connection", "light sample"):
            word, _, _ = self.drawPathsOf(technique)
            rows = [row for row in self.rows()[1:] if row[1] != "light path"]
            self.assertEqual("".join(row[0] for row in rows)[::-1], word)
            positions = [row[7] for row in rows]
            self.assertEqual(len(set(positions)), len(positions))  # the lamp's point, too
            for letter, name, material, lobe, throughput, pdf, reverse, _ in rows[1:-1]:
                self.assertNotEqual(name, "")
                self.assertNotEqual(material, "")
                self.assertIn(lobe, ("reflection", "transmission", "mirror", "refraction", "reflection, transmission"))
                if letter == "D":
                    self.assertGreater(float(pdf), 0)
                    self.assertGreater(float(reverse), 0)
            weights = self.text("#pathWeights")
            self.assertTrue(weights.startswith("Weights of all techniques: "), weights)
            parts = [float(part.split()[-1]) for part in weights.split(": ")[1].split(" · ")]
            self.assertAlmostEqual(sum(parts), 1, delta=0.02)
            self.assertEqual(self.text("#omission"), "")

    def test6WhatIsNotRecordedHasAReason(self):
        self.open("lightpath", ON_WALL)
        self.assertIn("Connections of light paths to the camera are not recorded", self.text("#recordNotes"))
        self.assertIn("connections to the camera, without a record, add ", self.text("#pathStatus"))
        self.open("ambientocclusion", ON_WALL)
        self.assertIn("This integrator supposes white light", self.text("#recordNotes"))
        word, objects, segments = self.drawPathsOf("hit")
        self.assertEqual((word, segments), ("LDE", 2))
        for integrator, technique, reason in (
                ("simplephotonmap", "merge", "photons are stored without the paths"),
                ("radiosity", "patches", "patches store irradiance")):
            self.open(integrator, ON_WALL)
            self.assertEqual(browser.evaluate("document.getElementById('recordNotes').hidden"), integrator != "radiosity")
            word, objects, segments = self.drawPathsOf(technique)
            self.assertRegex(word, "^L…D[SD]*E$")
            self.assertEqual(segments, len(word) - 3)  # up to the last known vertex
            self.assertIn(reason, self.text("#omission"))

    def test7RaysOfTheOldMethodsEndAtTheLamp(self):
        for integrator in ("raycast", "whitted", "radiosity", "vpl"):
            self.open(integrator, ON_WALL)
            word, objects, segments = self.drawPathsOf("light sample")
            self.assertRegex(word, "^LD[SD]*E$", integrator)
            self.assertEqual(segments, len(word) - 1, integrator)

    def test4PathTracingHasNeitherPhotonsNorLightPaths(self):
        self.open("path")
        for name in ("flightPanel", "boxPanel", "photonTools"):
            self.assertTrue(browser.evaluate(f"document.getElementById('{name}').hidden"), name)


LAMPS = """
Film "rgb" "integer xresolution" 32 "integer yresolution" 32
LookAt 0 0 6  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "point" "string name" "left" "point3 from" [ -3 0 3 ] "rgb I" [ 9 1 1 ]
LightSource "point" "string name" "right" "point3 from" [ 3 0 3 ] "rgb I" [ 1 1 9 ]
Material "diffuse"
Shape "trianglemesh" "string name" "floor" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Shape "sphere" "string name" "ball" "float radius" .7
"""


class Names(OfflinePage):
    """Classes and filters name lamps and surfaces."""

    @classmethod
    def make(cls):
        cls.scene, cls.page = cls.temporary.name + "/lamps.pbrt", cls.temporary.name + "/page.html"
        with open(cls.scene, "w", encoding="utf-8") as file:
            file.write(LAMPS)
        recurse("inspect", cls.scene, "-o", cls.page, "-q", "--integrator", "simplephotonmap", "--photons", "20k", "--spp", "4",
                "--path-samples", "4", "--class", "b=LD'floor'E", "--class", "r=L'right'.*D'ball'E", "--pixel", "16,16",
                "--pixel", "6,16")
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")
        cls.data = browser.evaluate("JSON.parse(document.getElementById('data').textContent)")

    def setUp(self):
        browser.settle()

    change, decoded, clickPixelOf = InspectPage.change, InspectPage.decoded, EdgesOfAFloor.clickPixelOf

    def test1PhotonsHaveTheClassesOfTheirSurfaces(self):
        self.assertEqual([c["name"] for c in self.data["classes"]], ["b", "r", "rest"])
        positions = self.decoded("photons", "positions", type="f")
        kinds, depths = self.decoded("photons", "kinds", type="B"), self.decoded("photons", "depths", type="B")
        counts = [0, 0, 0]
        for i, kind in enumerate(kinds):
            p = [positions[3 * i + k] + self.data["origin"][k] for k in range(3)]
            onBall = sum(x * x for x in p) ** 0.5 < 0.701 and p[2] > 1e-3
            counts[kind & 127] += 1
            if kind & 127 == 0:
                self.assertFalse(onBall)
                self.assertEqual(depths[i], 1)
            if kind & 127 == 1:
                self.assertTrue(onBall)
            if kind & 127 == 2 and not onBall:
                self.assertGreater(depths[i], 1)
        self.assertGreater(min(counts), 20)

    def test2FiltersByLamp(self):
        recurse("inspect", self.scene, "-o", self.page, "-q", "--integrator", "path", "--spp", "4", "--path-samples", "4",
                "--pixel", "16,16", "--pixel", "6,16")
        browser.open(self.page, "document.body.dataset.ready === 'yes'")
        self.clickPixelOf(6, 16)
        both = 0
        whole = len(self.texts("#contributions tr")) - 1
        for lamp in ("left", "right"):
            self.change("filter", "value", f"L'{lamp}'.*E")
            self.assertEqual(self.text("#filterReason"), "")
            both += len(self.texts("#contributions tr")) - 1
        self.assertEqual(both, whole)
        self.change("filter", "value", "L.*D'ball'E")
        self.assertEqual(len(self.texts("#contributions tr")) - 1, 0)
        self.clickPixelOf(16, 16)
        self.assertGreater(len(self.texts("#contributions tr")) - 1, 0)
        self.change("filter", "value", "L'ball'E")
        self.assertIn("it is a surface", self.text("#filterReason"))

    def test3SurfacesOfLightPathsHaveNames(self):
        recurse("inspect", self.scene, "-o", self.page, "-q", "--integrator", "bdpt", "--spp", "4096", "--path-samples", "4096",
                "--pixel", "9,16")
        browser.open(self.page, "document.body.dataset.ready === 'yes'")
        data = browser.evaluate("JSON.parse(document.getElementById('data').textContent)")
        named = [[data["names"][i] for i in v[10]] for v in data["pixels"][0]["lightVertices"] if v[10]]
        self.assertIn(["ball"], named)
        # Balls light the floor; a floor lights no floor.
        def words(filter):
            self.change("filter", "value", filter)
            return [w for w in self.texts("#contributions tr td:nth-child(2)") if len(w) == 4]
        self.assertGreater(len(words("LD'ball'D'floor'E")), 0)
        self.assertEqual(words("LD'floor'D'floor'E"), [])


class ShapesWithoutFaces(OfflinePage):
    """A page of metaballs, a csg and curves far before a horizon."""

    @classmethod
    def make(cls):
        scene, cls.page = cls.temporary.name + "/shapes.pbrt", cls.temporary.name + "/page.html"
        with open(scene, "w", encoding="utf-8") as file:
            file.write("""
Film "rgb" "integer xresolution" 32 "integer yresolution" 32
LookAt 0 0 6  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "point" "point3 from" [ 0 0 6 ] "rgb I" [ 30 30 30 ]
Material "diffuse"
Shape "disk" "float radius" 50000 "float height" -2
Material "diffuse" "rgb reflectance" [ .8 .1 .1 ]
Shape "metaballs" "point3 P" [ -.5 0 0  .5 0 0 ] "float radius" 1.5
Shape "curve" "point3 P" [ -2 -2 0  -2 -1 0  -2 1 0  -2 2 0 ] "float width" .2
""")
        recurse("inspect", scene, "-o", cls.page, "-q", "--integrator", "path", "--spp", "1", "--pixel", "16,16")
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")
        cls.data = browser.evaluate("JSON.parse(document.getElementById('data').textContent)")

    colours = InspectPage.colours

    def redness(self):
        """Fraction of the view that is red."""
        return browser.evaluate(
            "(() => { const v = document.getElementById('view'), c = document.createElement('canvas').getContext('2d');"
            "c.canvas.width = c.canvas.height = 64; c.drawImage(v, 0, 0, 64, 64);"
            "const d = c.getImageData(0, 0, 64, 64).data; let n = 0;"
            "for (let i = 0; i < d.length; i += 4) n += d[i] > 60 && d[i] > 2 * d[i + 1];"
            "return n / 4096; })()")

    def test1TheyAreDrawnAndThePageSaysHow(self):
        self.assertIn("Approximated by a grid: 1 shape without faces.", self.text("#simplified"))
        browser.evaluate("(() => { const e = document.getElementById('showPaths'); e.checked = false;"
                         "e.dispatchEvent(new Event('input')); })()")
        browser.settle()
        self.assertGreater(self.redness(), 0.05)

    def test2TheViewsAreOfWhatTheCameraSees(self):
        for name in ("top", "front", "side"):
            browser.click(f"document.querySelector('[data-view={name}]')")
            self.assertGreater(self.redness(), 5e-4, name)
        browser.click("document.querySelector('[data-view=camera]')")
        browser.settle()
        self.assertGreater(self.redness(), 0.05)


class LimitOfPhotons(OfflinePage):
    @classmethod
    def make(cls):
        cls.page = cls.temporary.name + "/page.html"
        recurse("inspect", SCENE, "-o", cls.page, "-q", "--integrator", "photonmap", "--photons", "20k", "--spp", "4",
                "--resolution", "48x48", "--shown-photons", "1000", "--shown-light-paths", "0", "--reference-samples", "0")
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")

    def test1ThePageSaysItsLimit(self):
        self.assertRegex(self.text("#photonCount"), r"^\d+ of \d+ photons .*, each represents \d+\. Limit: --shown-photons 1000\.$")

    def test2WhatIsNotAskedForIsNotThere(self):
        self.assertTrue(browser.evaluate("document.getElementById('flightPanel').hidden"))
        self.assertTrue(browser.evaluate("document.getElementById('atPixel').disabled"))


class RadiosityPage(OfflinePage):
    """Patches of radiosity, and form factors from a clicked one."""

    @classmethod
    def make(cls):
        cls.page = cls.temporary.name + "/radiosity.html"
        recurse("inspect", SCENE, "-o", cls.page, "-q", "--integrator", "radiosity", "--set", "patchsize=.3", "--spp", "1",
                "--resolution", "48x48", "--pixel", "24,40")
        browser.open(cls.page, "document.body.dataset.ready === 'yes'")
        cls.data = browser.evaluate("JSON.parse(document.getElementById('data').textContent)")

    def setUp(self):
        browser.settle()

    change, colours = InspectPage.change, InspectPage.colours

    def decoded(self, name, code):
        bytes = zlib.decompress(base64.b64decode(self.data["patches"][name]))
        size = struct.calcsize(code)
        count = len(bytes) // size
        ordered = b"".join(bytes[k * count + i:k * count + i + 1] for i in range(count) for k in range(size))
        return struct.unpack("<%d%s" % (count, code), ordered)

    def test1FormFactorsAreReciprocal(self):
        count, rays = self.data["patches"]["count"], self.data["patches"]["rays"]
        areas, ends = self.decoded("areas", "f"), self.decoded("ends", "I")
        columns, hits = self.decoded("columns", "I"), self.decoded("hits", "H")
        self.assertEqual((len(areas), len(ends), ends[-1]), (count, count, len(columns)))
        factors = {}
        for i in range(count):
            row = range(ends[i - 1] if i else 0, ends[i])
            self.assertLessEqual(sum(hits[k] for k in row), rays)
            for k in row:
                factors[i, columns[k]] = hits[k] / rays
        large = [(i, j) for (i, j), f in factors.items() if f > 0.03 and factors.get((j, i), 0) > 0]
        self.assertGreater(len(large), 20)
        for i, j in large:
            a, b = areas[i] * factors[i, j], areas[j] * factors[j, i]
            error = (areas[i] ** 2 * factors[i, j] / rays + areas[j] ** 2 * factors[j, i] / rays) ** 0.5
            self.assertAlmostEqual(a, b, delta=6 * error)

    def test2AClickShowsTheFormFactorsOfAPatch(self):
        self.assertEqual(browser.evaluate("document.getElementById('view').dataset.patches"), str(self.data["patches"]["count"]))
        before = self.colours()
        self.assertGreater(before, 10)
        browser.clickAt(*browser.evaluate("(() => { const b = document.getElementById('view').getBoundingClientRect();"
                                          "return [b.left + b.width / 2, b.top + b.height * .85]; })()"))
        patch = int(browser.evaluate("document.getElementById('view').dataset.patch"))
        self.assertGreaterEqual(patch, 0)
        texts = self.texts("#patchText dd")
        self.assertTrue(texts[0].startswith(f"{patch}, "), texts)
        total = float(texts[3].split(" ")[0])
        ends, hits = self.decoded("ends", "I"), self.decoded("hits", "H")
        expected = sum(hits[ends[patch - 1] if patch else 0:ends[patch]]) / self.data["patches"]["rays"]
        self.assertAlmostEqual(total, expected, delta=6e-4)
        self.assertGreater(total, 0.1)
        listed = [float(text) for text in self.texts("#factors tr td:nth-child(2)")]
        self.assertEqual(listed, sorted(listed, reverse=True))
        self.assertGreater(len(listed), 3)
        # A click chooses the next patch of the list.
        browser.evaluate("document.getElementById('factors').rows[1].click()")
        browser.settle()
        self.assertNotEqual(int(browser.evaluate("document.getElementById('view').dataset.patch")), patch)
        self.change("showPatches", "checked", False)
        self.assertEqual(browser.evaluate("document.getElementById('view').dataset.patches"), "0")


if __name__ == "__main__":
    main()
