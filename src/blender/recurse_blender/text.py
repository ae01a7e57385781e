"""Text of scene files, and the folder that a scene is written to."""
import hashlib
import os

import numpy as np


MATRIX = "[ " + 16 * "%.9g " + "]"


def number(value):
    """Number with the digits of single precision."""
    return f"{float(value):.9g}"


def numbers(values):
    """Numbers in brackets."""
    return "[ " + " ".join(map(number, np.ravel(values))) + " ]"


def quoted(text):
    """String in quotes, with escapes; unprintable characters become underscores."""
    text = "".join(c if c.isprintable() else "_" for c in str(text))
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def matrix(values):
    """Matrix in the form of Transform and ConcatTransform, column by column."""
    return MATRIX % tuple(np.asarray(values, float).T.ravel().tolist())


class Folder:
    """Folder for a scene and its files. Files are named by a hash of their contents, so that existing ones are not
    written again."""

    def __init__(self, path):
        self.path = path
        self.written = 0
        os.makedirs(path, exist_ok=True)

    def file(self, name, extension, parts):
        """Writes a file with these contents, a list of bytes; returns its name in the scene."""
        digest = hashlib.blake2b(digest_size=12)
        for part in parts:
            digest.update(part)
        safe = "".join(c if c.isalnum() or c in "-_." else "_" for c in name) or "file"
        folder = os.path.join("data", digest.hexdigest())
        relative = os.path.join(folder, safe + extension)
        full = os.path.join(self.path, relative)
        if not os.path.exists(full):
            os.makedirs(os.path.join(self.path, folder), exist_ok=True)
            with open(full + ".part", "wb") as out:
                for part in parts:
                    out.write(part)
            os.replace(full + ".part", full)
            self.written += 1
        return relative

    def picture(self, name, pixels):
        """Writes linear pixels, rows from the top, as PFM; returns the file's name in the scene."""
        pixels = np.ascontiguousarray(np.asarray(pixels, "<f4")[::-1, :, :3])
        head = f"PF\n{pixels.shape[1]} {pixels.shape[0]}\n-1.0\n".encode()
        return self.file(name, ".pfm", [head, pixels.tobytes()])


class Warnings:
    """Warnings about differences from Blender's rendering, without repetition."""

    def __init__(self):
        self.texts = []

    def add(self, text):
        """Adds a warning unless it is already there."""
        if text not in self.texts:
            self.texts.append(text)
