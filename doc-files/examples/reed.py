#!/usr/bin/env python3
"""Writes reed.gltf: a reed of one mesh with a skeleton of five joints, which the animation "sway" bends in the
wind. The motion has a period of 2 s and the animation lasts 4 s, so that reeds can start at different times."""
import base64
import json
import math
import os
import struct

HEIGHT = 2.0  # of the skeleton [m]
JOINTS = 5
BONE = HEIGHT / JOINTS
PERIOD, DURATION, KEYS = 2.0, 4.0, 33


class Buffer:
    """The binary buffer, with the accessors and views of its arrays."""

    def __init__(self):
        self.data, self.accessors, self.views = b"", [], []

    def add(self, kind, code, values, bounds=False):
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        flat = [float(x) if code == "f" else x for v in values for x in (v if width > 1 else [v])]
        packed = struct.pack(f"<{len(flat)}{code}", *flat)
        accessor = {"bufferView": len(self.views), "count": len(values), "type": kind,
                    "componentType": {"f": 5126, "H": 5123, "B": 5121}[code]}
        if bounds:
            columns = list(zip(*([[v] if width == 1 else v for v in values])))
            single = [struct.unpack("<f", struct.pack("<f", f(c)))[0] for f in (min, max) for c in columns]
            accessor["min"], accessor["max"] = single[:len(columns)], single[len(columns):]
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)})
        self.accessors.append(accessor)
        self.data += packed + b"\0" * (-len(packed) % 4)
        return len(self.accessors) - 1


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def grid(point, columns, rows):
    """Vertices, normals and triangles of a surface over [0, 1]^2, with normals from differences."""
    step = 1e-4
    points, normals, triangles = [], [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            u, v = i / columns, min(max(j / rows, step), 1 - step)
            du = [b - a for a, b in zip(point(u - step, v), point(u + step, v))]
            dv = [b - a for a, b in zip(point(u, v - step), point(u, v + step))]
            n = cross(dv, du)
            length = math.hypot(*n)
            points.append(point(u, j / rows))
            normals.append([x / length for x in n])
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b = a + columns + 1
            triangles += [a, b, a + 1, a + 1, b, b + 1]
    return points, normals, triangles


def lathe(radius, low, high):
    """Surface of revolution about the y axis."""
    def point(u, v):
        r = radius(v)
        return [r * math.cos(2 * math.pi * u), low + (high - low) * v, r * math.sin(2 * math.pi * u)]
    return point


def leaf(azimuth, length, spread):
    """A blade that leaves the stem upwards and bends outwards."""
    c, s = math.cos(azimuth), math.sin(azimuth)

    def point(u, v):
        out = 0.02 + spread * v**2
        up = 0.1 + length * (v - 0.35 * v**3)
        half = 0.045 * (1 - v)**0.6 * (0.5 + 0.5 * min(4 * v, 1))
        across = (2 * u - 1) * half
        fold = 0.4 * abs(across)  # a shallow V
        return [c * (out - fold) - s * across, up, s * (out - fold) + c * across]
    return point


def influences(height):
    """The two joints of a vertex and their weights, linear in the height between the middles of bones."""
    f = min(max(height / BONE - 0.5, 0), JOINTS - 1)
    joint = min(int(f), JOINTS - 2)
    return [joint, joint + 1, 0, 0], [1 - (f - joint), f - joint, 0, 0]


def rotation(joint, time):
    """Quaternion of a joint: a lean to +x that swings, and a smaller swing along z."""
    phase = 2 * math.pi * time / PERIOD - 0.6 * joint
    z = -0.05 - (0.04 + 0.016 * joint) * math.sin(phase)
    x = (0.02 + 0.01 * joint) * math.sin(phase + 1.2)
    cz, sz, cx, sx = math.cos(z / 2), math.sin(z / 2), math.cos(x / 2), math.sin(x / 2)
    return [cz * sx, sz * sx, sz * cx, cz * cx]  # z after x


def main():
    out = Buffer()
    head = lathe(lambda v: 0.05 * min(1, 4 * math.sqrt(max(v * (1 - v), 1e-9)))**0.7, 1.58, 1.96)
    parts = [(0, [grid(lathe(lambda v: 0.028 - 0.018 * v, 0, 2.15), 10, 24)]),
             (1, [grid(head, 14, 14)]),
             (2, [grid(leaf(a, length, spread), 2, 14)
                  for a, length, spread in ((0.4, 1.9, 0.45), (2.5, 1.6, 0.55), (4.4, 2.1, 0.35))])]
    primitives = []
    for material, surfaces in parts:
        points, normals, triangles = [], [], []
        for p, n, t in surfaces:
            triangles += [i + len(points) for i in t]
            points += p
            normals += n
        bound = [influences(p[1]) for p in points]
        primitives.append({"material": material, "indices": out.add("SCALAR", "H", triangles), "attributes": {
            "POSITION": out.add("VEC3", "f", points, True), "NORMAL": out.add("VEC3", "f", normals),
            "JOINTS_0": out.add("VEC4", "B", [b[0] for b in bound]),
            "WEIGHTS_0": out.add("VEC4", "f", [b[1] for b in bound])}})

    inverse_binds = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -BONE * j, 0, 1] for j in range(JOINTS)]
    times = [DURATION * k / (KEYS - 1) for k in range(KEYS)]
    clock = out.add("SCALAR", "f", times, True)
    samplers = [{"input": clock, "output": out.add("VEC4", "f", [rotation(j, t) for t in times])}
                for j in range(JOINTS)]
    nodes = [{"name": "reed", "mesh": 0, "skin": 0, "children": [1]}]
    for j in range(JOINTS):
        node = {"name": f"joint {j + 1}", "translation": [0, BONE if j else 0, 0]}
        if j + 1 < JOINTS:
            node["children"] = [j + 2]
        nodes.append(node)
    colours = {"stem": [0.16, 0.26, 0.06], "head": [0.17, 0.07, 0.025], "leaf": [0.22, 0.36, 0.08]}
    model = {
        "asset": {"version": "2.0", "generator": "reed.py"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": nodes, "meshes": [{"name": "reed", "primitives": primitives}],
        "skins": [{"joints": list(range(1, JOINTS + 1)), "inverseBindMatrices": out.add("MAT4", "f", inverse_binds)}],
        "materials": [{"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": colour + [1], "metallicFactor": 0, "roughnessFactor": 0.6}}
            for name, colour in colours.items()],
        "animations": [{"name": "sway", "samplers": samplers, "channels": [
            {"sampler": j, "target": {"node": j + 1, "path": "rotation"}} for j in range(JOINTS)]}]}
    model["accessors"], model["bufferViews"] = out.accessors, out.views
    model["buffers"] = [{"byteLength": len(out.data),
                         "uri": "data:application/octet-stream;base64," + base64.b64encode(out.data).decode()}]
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "reed.gltf"), "w", encoding="ascii") as file:
        file.write(json.dumps(model, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
