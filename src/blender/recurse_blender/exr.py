"""Reader of the OpenEXR files that Recurse writes: scan lines of floats, with or without zip compression."""
import struct
import zlib

import numpy as np

MAGIC = 20000630
ROWS_OF_CHUNKS = {0: 1, 2: 1, 3: 16}  # by compression: none, zip of single lines, zip of 16 lines


def _text(data, begin):
    end = data.index(b"\0", begin)
    return data[begin:end].decode(), end + 1


def _channels(data):
    names, at = [], 0
    while data[at]:
        name, at = _text(data, at)
        if struct.unpack_from("<i", data, at)[0] != 2:
            raise ValueError("channel " + name + " has no floats")
        names.append(name)
        at += 16
    return names


def _unzip(data, size):
    if len(data) == size:
        return data
    coded = np.frombuffer(zlib.decompress(data), np.uint8).astype(np.int64)
    coded[1:] -= 128
    halves = np.cumsum(coded).astype(np.uint8)
    out = np.empty(size, np.uint8)
    out[0::2], out[1::2] = halves[:(size + 1) // 2], halves[(size + 1) // 2:]
    return out.tobytes()


def read_exr(path):
    """Channels by name, as arrays (height, width) with rows from the top. Raises ValueError for other files."""
    with open(path, "rb") as file:
        data = file.read()
    if struct.unpack_from("<i", data)[0] != MAGIC:
        raise ValueError(path + " is no OpenEXR file")
    attributes, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    names, compression = _channels(attributes["channels"]), attributes["compression"][0]
    width, height, rows = x1 - x0 + 1, y1 - y0 + 1, ROWS_OF_CHUNKS[compression]
    pixels = np.empty((height, len(names), width), np.float32)
    for offset in struct.unpack_from(f"<{(height + rows - 1) // rows}q", data, at + 1):
        y, size = struct.unpack_from("<2i", data, offset)
        count = min(rows, y1 + 1 - y)
        chunk = _unzip(data[offset + 8:offset + 8 + size], count * len(names) * width * 4)
        pixels[y - y0:y - y0 + count] = np.frombuffer(chunk, "<f4").reshape(count, len(names), width)
    return {name: pixels[:, i] for i, name in enumerate(names)}
