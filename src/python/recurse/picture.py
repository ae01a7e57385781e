"""Pictures as arrays: the result of a render, and operations on it."""
from __future__ import annotations

import json
import os
import tempfile
from typing import Any, Mapping, Union

import numpy as np

from . import _core


class Picture:
    """Rendered picture, linear Rec. 709. Its arrays share one block of memory, which lives as long as they do."""

    def __init__(self, image: "_core.Image", statistics: Mapping[str, Any] | None = None):
        self._image = image
        self.statistics = dict(statistics or {})
        #: Metadata of the file: how the picture was rendered.
        self.metadata: dict[str, str] = image.metadata
        pixels = image.array()
        #: Arrays by name, of shape (height, width, channels), or (height, width) for a single channel: "all" is the
        #: whole picture, followed by path classes, features, "error" and "samples".
        self.layers: dict[str, np.ndarray] = {}
        begin = 0
        names = [name.rpartition(".")[0] or "all" for name in image.channels]
        for end in range(1, len(names) + 1):
            if end == len(names) or names[end] != names[begin]:
                layer = pixels[:, :, begin:end]
                self.layers[names[begin]] = layer[:, :, 0] if end - begin == 1 else layer
                begin = end

    @classmethod
    def of(cls, pixels: Any) -> "Picture":
        """Picture from an array of shape (height, width, 3)."""
        return cls(_core.Image(np.asarray(pixels, np.float32), ["R", "G", "B"]))

    @property
    def array(self) -> np.ndarray:
        """Whole picture, of shape (height, width, 3): red, green and blue."""
        return self.layers["all"]

    def __array__(self, dtype: Any = None) -> np.ndarray:
        return np.asarray(self.array, dtype)

    def __repr__(self) -> str:
        height, width = self.array.shape[:2]
        return f"<recurse.Picture of {width}x{height} pixels: {', '.join(self.layers)}>"

    def develop(self, **options: Any) -> np.ndarray:
        """See recurse.develop()."""
        return develop(self, **options)

    def save(self, file: Union[str, os.PathLike], **options: Any) -> None:
        """Writes a file by its extension: .exr with all layers, .hdr and .pfm with linear colours, .png .jpg .tif for a
        display, with the options of recurse.develop()."""
        _core.write_image(self._image, os.fspath(file), _develop_options(options))

    def _repr_png_(self) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "picture.png")
            self.save(file)
            with open(file, "rb") as png:
                return png.read()


PictureLike = Union[Picture, np.ndarray, str, os.PathLike]


def _image(picture: PictureLike) -> "_core.Image":
    if isinstance(picture, Picture):
        return picture._image
    if isinstance(picture, (str, os.PathLike)):
        return _core.read_image(os.fspath(picture))
    return _core.Image(np.asarray(picture, np.float32), ["R", "G", "B"])


def read(file: Union[str, os.PathLike]) -> Picture:
    """Reads a picture, with linear values, from a file of any usual format."""
    return Picture(_core.read_image(os.fspath(file)))


def compare(picture: PictureLike, reference: PictureLike, flip: bool = False) -> dict[str, Any]:
    """Measures of the difference, the same as from `recurse compare --json`; with `flip` also LDR- and HDR-FLIP, which
    take longer."""
    return json.loads(_core.compare(_image(picture), _image(reference), flip))


def _develop_options(options: Mapping[str, Any]) -> list[str]:
    known = ("exposure", "tonemap", "white_balance", "bloom", "bloom_angle", "display", "dither")
    out: list[str] = []
    for name, value in options.items():
        if name not in known:
            raise TypeError(f"develop() has no option {name!r}; it takes: {', '.join(known)}")
        if value is True:
            out.append("--" + name)
        elif value is not None and value is not False:
            out.append(f"--{name.replace('_', '-')}={value}")
    return out


def develop(picture: PictureLike, **options: Any) -> np.ndarray:
    """Picture for a display, as bytes of shape (height, width, 3). The options are the same as in `recurse develop`:
    exposure ("auto", stops, "p98"), tonemap, white_balance, bloom, bloom_angle, display, dither."""
    image, _ = _core.develop(_image(picture), _develop_options(options))
    return np.rint(np.clip(image.array()[:, :, :3], 0, 1) * 255).astype(np.uint8)


def class_list(classes: Any) -> list[tuple[str, str]]:
    """Pairs of name and expression, from a dictionary, or from expressions that are their own names."""
    return list(classes.items()) if isinstance(classes, Mapping) else [(text, text) for text in classes]


def classes(*expressions: str, **named: str) -> str:
    """Explanation of classes of light paths, with examples and overlaps: classes("LS+DE", direct="LDE")."""
    return _core.classes(class_list(expressions) + class_list(named))


def named_classes() -> dict[str, str]:
    """Expressions of the classes that have names, by name."""
    return {name: expression for name, expression, _ in _core.named_classes()}


def in_class(expression: str, path: str) -> bool:
    """Whether a path, such as "LSDE", is in the class."""
    return _core.is_in_class(expression, path)
