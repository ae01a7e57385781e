"""Shared functions of the tests of pages: the program to test, a scene, a browser, and queries of a page."""

import atexit
import json
import os
import subprocess
import sys
import tempfile
import unittest

from browser import Browser, BrowserError

if len(sys.argv) < 2:
    sys.exit(f"usage: python3 {os.path.basename(sys.argv[0])} PROGRAM")
PROGRAM = os.path.abspath(sys.argv[1])
SCENE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes", "cornell-mix.pbrt")
try:
    browser = Browser()
except BrowserError as error:
    sys.exit(f"The page cannot be tested: {error}")
atexit.register(browser.close)


def recurse(*arguments):
    return subprocess.run([PROGRAM, *arguments], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          text=True).stdout


def main():
    unittest.main(module="__main__", argv=sys.argv[:1] + sys.argv[2:], verbosity=2)


class Page(unittest.TestCase):
    """Reads the page that the browser shows."""

    def text(self, selector):
        return browser.evaluate(f"document.querySelector({json.dumps(selector)}).textContent")

    def texts(self, selector):
        return browser.evaluate(f"[...document.querySelectorAll({json.dumps(selector)})].map((e) => e.textContent)")

    def set(self, name, value):
        browser.evaluate(f"(() => {{ const e = document.getElementById('{name}'); e.value = {json.dumps(value)};"
                         "e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); })()")
        browser.settle()

    def place(self, pixel, size):
        """Position of a pixel's centre in the window; the picture of `size` squared is fitted into the stage."""
        zoom, left, top, width, height = browser.evaluate(
            "(() => { const b = document.getElementById('view').getBoundingClientRect();"
            "return [parseInt(document.getElementById('zoomText').textContent) / 100,"
            "b.left, b.top, b.width, b.height]; })()")
        origin = (left + (width - size * zoom) / 2, top + (height - size * zoom) / 2)
        return [origin[i] + (pixel[i] + 0.5) * zoom for i in (0, 1)]

    def colourAt(self, pixel, size):
        """Colour of the stage after all drawing is finished, [r, g, b] of 0 to 255."""
        browser.settle()
        x, y = self.place(pixel, size)
        return browser.evaluate(
            "(() => { const v = document.getElementById('view'), b = v.getBoundingClientRect();"
            "const c = document.createElement('canvas').getContext('2d', { willReadFrequently: true });"
            f"c.drawImage(v, {x} - b.left, {y} - b.top, 1, 1, 0, 0, 1, 1);"
            "return [...c.getImageData(0, 0, 1, 1).data]; })()")[:3]


class OfflinePage(Page):
    """Page of files in a folder: it loads without errors and without any network. Subclasses write it in make()."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="recurse-page-")
        cls.folder = cls.temporary.name + "/out"
        cls.make()

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def tearDown(self):
        self.assertEqual(browser.complaints, [])
        self.assertEqual([url for url in browser.requests if not url.startswith(("file:", "data:", "blob:"))], [])
