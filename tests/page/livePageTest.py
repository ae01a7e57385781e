"""The page of `recurse render --live` in headless Chromium: python3 livePageTest.py PROGRAM.

It must show the growing picture as developed by the program and the values of its pixels, and stop the render.
"""

import json
import os
import re
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request

import browser as chromium

chromium.FLAGS = [flag for flag in chromium.FLAGS if flag != "--disable-gpu"] + chromium.WEBGL_FLAGS

from pageTest import PROGRAM, SCENE, Page, browser, main  # noqa: E402 (the browser starts at once)

SIZE = 32


class Render:
    """A running render with a page."""

    def __init__(self, *options, integrator="path"):
        self.folder = tempfile.TemporaryDirectory(prefix="recurse-live-page-")
        self.output = self.folder.name + "/out.exr"
        self.process = subprocess.Popen(
            [PROGRAM, "render", SCENE, "-o", self.output, "--resolution", f"{SIZE}x{SIZE}", "--integrator", integrator,
             "--spp", "1000000000", "--progress", "off", *options],
            stderr=subprocess.PIPE, text=True)
        self.url = None
        for line in self.process.stderr:
            found = re.search(r"http://\S+", line)
            if found:
                self.url = found.group(0)
                break

    def get(self, path):
        with urllib.request.urlopen(self.url + path, timeout=60) as answer:
            return answer.read()

    def state(self):
        return json.loads(self.get("state"))

    def wait(self):
        self.process.communicate(timeout=120)
        return self.process.returncode

    def close(self):
        self.process.kill()
        self.process.wait()
        self.process.stderr.close()
        self.folder.cleanup()


def until(condition, seconds=300):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("it did not come to that")
        time.sleep(0.1)


class LivePage(Page):
    def setUp(self):
        self.render = Render("--live")
        self.assertIsNotNone(self.render.url)
        self.assertTrue(self.render.url.startswith("http://127.0.0.1:"))

    def tearDown(self):
        browser.call("Page.navigate", url="about:blank")  # otherwise the page would query the next render
        browser.settle()
        self.render.close()

    def shownPixel(self, x, y):
        browser.settle()
        return self.colourAt((x, y), SIZE)

    def version(self):
        return int(browser.evaluate("document.body.dataset.version ?? '0'"))

    def testShowsThePictureAndStops(self):
        browser.openUrl(self.render.url, "Number(document.body.dataset.version) > 0")
        first = self.version()
        until(lambda: self.version() > first)  # it grows
        self.assertIn(f"{SIZE}x{SIZE}", self.text("#label"))
        self.assertIn("samples", "samples " + self.text("#samples"))
        self.assertGreater(float(self.text("#samples")), 0)
        self.assertRegex(self.text("#left"), r"\d")

        # The slider makes the picture brighter, equal to the program's own development.
        dark = sum(self.shownPixel(9, 24))
        browser.evaluate("document.getElementById('exposure').value = 2,"
                         "document.getElementById('exposure').dispatchEvent(new Event('input'))")
        until(lambda: sum(self.shownPixel(9, 24)) > dark + 60)
        browser.evaluate("document.getElementById('operator').value = 'none',"
                         "document.getElementById('operator').dispatchEvent(new Event('change'))")
        until(lambda: "none" in browser.evaluate("document.body.dataset.shown"))
        shown, stops = self.shownPixel(9, 24), float(self.text("#exposureText"))
        linear = json.loads(self.render.get("pixel?x=9&y=24"))
        for value, byte in zip(linear, shown):
            x = min(value * 2 ** stops, 1)
            expected = 255 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055)
            self.assertAlmostEqual(byte, expected, delta=12)  # the picture changes between the queries

        # Values of a pixel.
        browser.clickAt(*self.place((9, 24), SIZE))
        until(lambda: len(self.text("#pixelShown").split()) == 3)

        def showsItsValue():  # which changes while the picture grows
            linear = json.loads(self.render.get("pixel?x=9&y=24"))
            return all(abs(float(shown) - value) < 0.01 * value + 1e-4
                       for shown, value in zip(self.text("#pixelShown").split(), linear))

        until(showsItsValue)

        # The button ends the render, which writes its picture.
        browser.click("document.getElementById('stop')")
        self.assertEqual(self.render.wait(), 130)
        self.assertTrue(os.path.exists(self.render.output))
        until(lambda: self.text("#phase") in ("ended", "finished"))
        gone = ("ERR_CONNECTION", "ERR_SOCKET_NOT_CONNECTED")  # requests after the server has ended
        self.assertEqual([c for c in browser.complaints if not any(error in c for error in gone)], [])
        self.assertTrue(all(url.startswith((self.render.url, "data:")) for url in browser.requests), browser.requests)

    def inFrame(self, expression):
        return browser.evaluate("(() => { const d = document.getElementById('pathsPage').contentDocument;"
                                f"return {expression}; }})()")

    def askPixel(self, x, y):
        """Clicks a pixel, and waits for the page with its paths. Returns that page's data."""
        until(lambda: int(self.text("#zoomText").split()[0]) > 100)  # the small picture is fitted into the stage
        before = browser.evaluate("document.body.dataset.answered ?? ''")
        browser.clickAt(*self.place((x, y), SIZE))
        until(lambda: browser.evaluate("document.body.dataset.answered ?? ''") != before)
        # A single expression, because between two the frame may replace the page of the previous pixel.
        until(lambda: self.inFrame("d?.body?.dataset?.ready === 'yes'"
                                   f" && d.getElementById('pixelName')?.textContent === '{x}, {y}'"))
        return self.inFrame("JSON.parse(d.getElementById('data').textContent)")

    def testAClickOnAPixelShowsItsPaths(self):
        browser.openUrl(self.render.url, "Number(document.body.dataset.version) > 0")
        data = self.askPixel(9, 24)
        pixel, = data["pixels"]
        self.assertEqual((pixel["x"], pixel["y"]), (9, 24))
        # The contributions of a sample add up to its value in the picture.
        self.assertGreater(len(pixel["samples"]), 0)
        for first, last, _, _, total in pixel["samples"]:
            for c in range(3):
                self.assertAlmostEqual(sum(k[10][c] for k in pixel["contributions"][first:last]), total[c],
                                       delta=1e-4 * max(total))
        linear = json.loads(self.render.get("pixel?x=9&y=24"))
        greens = [total[1] for *_, total in pixel["samples"]]
        self.assertAlmostEqual(pixel["value"][1], sum(greens) / len(greens), delta=1e-4 * max(greens))
        # The picture has more samples. A single bright one of these may make their mean ten times as bright.
        self.assertLess(min(greens), 2 * linear[1])
        self.assertGreater(max(greens), linear[1] / 2)
        # The table has the contributions, and for one of them its vertices.
        rows = self.inFrame("d.getElementById('contributions').rows.length")
        self.assertEqual(rows, 1 + min(200, len(pixel["contributions"])))
        self.inFrame("d.getElementById('contributions').rows[1].click()")
        self.assertEqual(self.inFrame("d.getElementById('vertices').rows[1].cells[1].textContent"), "camera")
        self.assertGreater(self.inFrame("Number(d.getElementById('view').dataset.segments)"), 0)
        # The page finds the classes of paths itself, which the render does not have, and the only lamp.
        names = self.inFrame("[...d.querySelectorAll('#classes li')].map((li) => li.textContent)")
        self.assertTrue(any(name.startswith("direct-diffuse") for name in names), names)
        self.assertGreater(len(names), 1)
        lamp = data["lamps"][0]
        for text, part in ((f"L'{lamp}'.*E", rows), ("!all", 1), ("L'nosuch'E", rows)):
            self.inFrame("(() => { const f = d.getElementById('filter'); f.value = %s;"
                         "f.dispatchEvent(new d.defaultView.Event('input')); })()" % json.dumps(text))
            self.assertEqual(self.inFrame("d.getElementById('contributions').rows.length"), part, text)
        self.assertIn("no light named", self.inFrame("d.getElementById('filterReason').textContent"))
        # Another pixel has other paths; the render has gone on.
        other = self.askPixel(20, 9)["pixels"][0]
        self.assertNotEqual(other["samples"], pixel["samples"])
        before = self.render.state()["samples_per_pixel"]
        until(lambda: self.render.state()["samples_per_pixel"] > before)
        browser.click("document.getElementById('closePaths')")
        self.assertTrue(browser.evaluate("document.getElementById('paths').hidden"))
        self.assertEqual(browser.complaints, [])

    def testAClassOfTheRenderIsAClassOfThePage(self):
        self.render.close()
        self.render = Render("--live", "--class", "lampy=LDE")
        browser.openUrl(self.render.url, "Number(document.body.dataset.version) > 0")
        self.askPixel(9, 24)
        names = self.inFrame("[...d.querySelectorAll('#classes li')].map((li) => li.textContent)")
        self.assertEqual(len(names), 2, names)
        self.assertTrue(any(name.startswith("lampy") for name in names), names)
        self.assertTrue(any(name.startswith("other") for name in names), names)

    def testQuestionsAreChecked(self):
        until(lambda: self.render.state()["version"] > 0)
        def post(path):
            return urllib.request.urlopen(urllib.request.Request(self.render.url + path, b""), timeout=60)
        for path in ("ask?x=99&y=0", "ask?x=0", "ask?x=a&y=1"):
            with self.assertRaises(urllib.error.HTTPError) as caught:
                post(path)
            self.assertEqual(caught.exception.code, 400, path)
            caught.exception.close()
        with self.assertRaises(urllib.error.HTTPError) as caught:
            self.render.get("paths")
        self.assertEqual(caught.exception.code, 404)
        caught.exception.close()
        for path in ("reference?position=0,0&normal=0,0,1", "reference?position=0,0,0&normal=0,0,2",
                     "reference?position=0,0,0&normal=0,0,1"):  # the last one: path tracing has no photons
            with self.assertRaises(urllib.error.HTTPError) as caught:
                self.render.get(path)
            self.assertEqual(caught.exception.code, 400, path)
            caught.exception.close()

    def testRefusesWhatItDoesNotKnow(self):
        until(lambda: self.render.state()["version"] > 0)
        for path in ("shown?tonemap=filmc", "shown?exposure=bright", "pixel?x=99&y=0", "pixel?x=a&y=0", "nothing"):
            with self.assertRaises(urllib.error.HTTPError) as caught:
                self.render.get(path)
            self.assertIn(caught.exception.code, (400, 404), path)
            caught.exception.close()
        # A page of a different origin cannot stop it.
        request = urllib.request.Request(self.render.url + "stop", b"", {"Origin": "http://example.org"})
        with self.assertRaises(urllib.error.HTTPError) as caught:
            urllib.request.urlopen(request, timeout=60)
        self.assertEqual(caught.exception.code, 403)
        caught.exception.close()
        self.assertFalse(self.render.state()["stopped"])

    def testPortInUseIsAnError(self):
        port = self.render.url.rsplit(":", 1)[1].split("/")[0]
        other = subprocess.run([PROGRAM, "render", SCENE, "-o", os.devnull + ".exr", "--live", "--live-address",
                                "127.0.0.1:" + port], stderr=subprocess.PIPE, text=True)
        self.assertNotEqual(other.returncode, 0)


class LivePhotonPage(Page):
    """A render with photons: path tracing at any clicked point of a surface."""

    def setUp(self):
        self.render = Render("--live", "--set", "passes=1", "--photons", "100k", "--direct", "photons",
                             integrator="photonmap")
        self.assertIsNotNone(self.render.url)

    tearDown, inFrame, askPixel = LivePage.tearDown, LivePage.inFrame, LivePage.askPixel

    def testPathTracingIsAskedAtAClickedPoint(self):
        browser.openUrl(self.render.url, "Number(document.body.dataset.version) > 0")
        data = self.askPixel(16, 3)
        self.assertGreater(data["photons"]["count"], 1000)
        box = self.inFrame("(() => { const f = document.getElementById('pathsPage').getBoundingClientRect();"
                           "const v = d.getElementById('view').getBoundingClientRect();"
                           "return [f.left + v.left, f.top + v.top, v.width, v.height]; })()")
        browser.clickAt(box[0] + 0.5 * box[2], box[1] + 0.4 * box[3])
        until(lambda: self.inFrame("d.getElementById('view').dataset.reference ?? ''"))
        reference = float(self.inFrame("d.getElementById('view').dataset.reference"))
        texts = self.inFrame("[...d.querySelectorAll('#estimateText dd')].map((e) => e.textContent)")
        names = self.inFrame("[...d.querySelectorAll('#estimateText dt')].map((e) => e.textContent)")
        estimate, error = map(float, texts[names.index("luminance")].split(" ± "))
        self.assertTrue(any(re.match("luminance by [0-9]+ paths", name) for name in names), names)
        self.assertAlmostEqual(reference, estimate, delta=5 * error + 0.15 * reference)
        self.assertEqual(browser.complaints, [])


class LiveGuidedPage(Page):
    """A render that learns directions."""

    def setUp(self):
        self.render = Render("--live", "--set", "guided=true")
        self.assertIsNotNone(self.render.url)

    tearDown = LivePage.tearDown

    def testShowsTheGuideAndTheTimeOfLearning(self):
        browser.openUrl(self.render.url, "Number(document.body.dataset.version) > 0")
        until(lambda: self.text("#guide") != "–")
        self.assertRegex(self.text("#guide"), r"^[1-9]\d* cells, \d+ % sampled$")
        self.assertRegex(self.text("#learning"), r"\d")


class DisplayServer(unittest.TestCase):
    """Reads the packets of the tev protocol."""

    def testReceivesThePicture(self):
        server = socket.create_server(("127.0.0.1", 0))
        packets = []

        def serve():
            connection, _ = server.accept()
            with connection, connection.makefile("rb") as stream:
                while True:
                    head = stream.read(4)
                    if len(head) < 4:
                        return
                    packets.append(stream.read(struct.unpack("<I", head)[0] - 4))

        thread = threading.Thread(target=serve)
        thread.start()
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, "render", SCENE, "-o", folder + "/a.exr", "--resolution", f"{SIZE}x{SIZE}",
                            "--integrator", "path", "--spp", "64", "-q", "--display-server",
                            "127.0.0.1:%d" % server.getsockname()[1]], check=True)
            info = subprocess.run([PROGRAM, "info", folder + "/a.exr", "--pixel", "9,24"], check=True,
                                  stdout=subprocess.PIPE, text=True).stdout
        thread.join(60)
        server.close()
        self.assertEqual(packets[0][0], 4)  # CreateImage
        name, _, rest = packets[0][2:].partition(b"\0")
        self.assertEqual(struct.unpack("<iii", rest[:12]), (SIZE, SIZE, 3))
        self.assertEqual(rest[12:], b"R\0G\0B\0")
        last = {}
        for packet in packets[1:]:
            self.assertEqual(packet[0], 3)  # UpdateImage
            title, channel, data = packet[2:].split(b"\0", 2)
            self.assertEqual(title, name)
            self.assertEqual(struct.unpack("<iiii", data[:16]), (0, 0, SIZE, SIZE))
            last[channel.decode()] = struct.unpack("<%df" % (SIZE * SIZE), data[16:])
        for line in info.splitlines():
            channel, value = line.split()
            self.assertAlmostEqual(last[channel][24 * SIZE + 9], float(value), delta=1e-5 * abs(float(value)))

    def testAServerThatIsNotThereDoesNotStopTheRender(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([PROGRAM, "render", SCENE, "-o", folder + "/a.exr", "--resolution", "16x16",
                                   "--integrator", "path", "--time-limit", "3s", "-q", "--display-server",
                                   f"127.0.0.1:{port}"], stderr=subprocess.PIPE, text=True)
            self.assertEqual(done.returncode, 0)
            self.assertIn("the render continues without it", done.stderr)
            self.assertEqual(done.stderr.count("the render continues"), 1)
            self.assertTrue(os.path.exists(folder + "/a.exr"))


if __name__ == "__main__":
    main()
