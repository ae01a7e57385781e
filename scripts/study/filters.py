#!/usr/bin/env python3
"""Measures the effect of pixel filters on fine detail, and writes doc-files/results/filters.md and
doc-files/results/filters.jpg.

  scripts/study/filters.py            renders scenes/filters/zone-plate.pbrt, slanted-edge.pbrt and siemens-star.pbrt by every filter
  scripts/study/filters.py --scenes   writes these three scenes, which are made of black disks and triangles before a white sky

Aliasing is the remaining contrast of the zone plate's rings that pixels cannot resolve (0.62 to 0.99 cycles per
pixel): the deviation from uniform grey there, relative to the rings themselves. Sharpness is the frequency at which a
slanted edge keeps half of its contrast (MTF50, by the method of ISO 12233), and the contrast of the star's spokes at
about a quarter of a cycle per pixel. Overshoot is how far an edge goes beyond black and white.
"""
import cmath
import math
import pathlib
import subprocess

import study

ROOT = study.ROOT
SIZE = 256
FILTERS = ("box", "triangle", "gaussian", "mitchell")
SAMPLES = 64
STAR_FREQUENCY = 0.22  # at 0.25 its third harmonic would be taken for the first
SPOKES = 96
EDGE_DEGREES = 5
FINEST = 1.0  # cycles per pixel of the zone plate's outermost rings


def head(what, command):
    return f"""# {what}
# Shows: pixel filters (scripts/study/filters.py measures them).
# Try: scripts/render scenes/filters/{command}.pbrt -o {command}.png --exposure 0 --tonemap none

Film "rgb" "integer xresolution" {SIZE} "integer yresolution" {SIZE} "string filename" "{command}.exr"
PixelFilter "gaussian"
Sampler "sobol" "integer pixelsamples" 64
Integrator "path" "integer maxdepth" 0
# A unit is a pixel.
LookAt 0 0 -10  0 0 0  0 1 0
Camera "orthographic" "float screenwindow" [ -{SIZE // 2} {SIZE // 2} -{SIZE // 2} {SIZE // 2} ]
WorldBegin
LightSource "infinite" "rgb L" [ 1 1 1 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
"""


def zonePlate():
    """Fresnel's zones of equal area: the frequency grows in proportion to the radius."""
    area = SIZE / 2 / FINEST  # radius² of a zone
    text = head("A zone plate: rings that become finer than pixels.", "zone-plate")
    for n in range(1, SIZE * SIZE // 4 // int(area) + 1, 2):
        text += f'Shape "disk" "float innerradius" {math.sqrt(n * area):.6g} "float radius" {math.sqrt((n + 1) * area):.6g}\n'
    return text


def slantedEdge():
    x = SIZE * math.tan(math.radians(EDGE_DEGREES))
    return head("An edge that is nearly upright, so that its rows of pixels sample it at every distance.", "slanted-edge") + \
        f'Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]\n  "point3 P" [ {-x:.6g} {-SIZE} 0  {2 * SIZE} {-SIZE} 0  ' \
        f'{2 * SIZE} {SIZE} 0  {x:.6g} {SIZE} 0 ]\n'


def siemensStar():
    text = head("A Siemens star: spokes that become finer towards the middle.", "siemens-star")
    points, indices, radius = ["0 0 0"], [], SIZE / 2 - 4
    for k in range(SPOKES):
        for side in (0, 1):
            angle = math.pi * (2 * k + side) / SPOKES
            points.append(f"{radius * math.cos(angle):.6g} {radius * math.sin(angle):.6g} 0")
        indices.append(f"0 {2 * k + 1} {2 * k + 2}")
    return text + f'Shape "trianglemesh" "integer indices" [ {"  ".join(indices)} ]\n  "point3 P" [ {"  ".join(points)} ]\n'


SCENES = {"zone-plate": zonePlate, "slanted-edge": slantedEdge, "siemens-star": siemensStar}


def readPfm(path):
    data = path.read_bytes()
    kind, size, order, pixels = data.split(b"\n", 3)
    assert kind == b"PF" and float(order) < 0
    width, height = map(int, size.split())
    floats = memoryview(pixels).cast("f")
    return [[floats[3 * (y * width + x)] for x in range(width)] for y in reversed(range(height))]


def radial(picture):
    """(radius in pixels, angle, value) of all pixels."""
    middle = SIZE / 2
    for y, row in enumerate(picture):
        for x, value in enumerate(row):
            dx, dy = x + 0.5 - middle, middle - y - 0.5
            yield math.hypot(dx, dy), math.atan2(dy, dx), value


def aliasing(one, other):
    """Aliasing of two renders with independent noise, which the covariance excludes."""
    low, high = (f / FINEST * SIZE / 2 for f in (0.62, 0.99))
    pairs = [(a, b) for (r, _, a), (_, _, b) in zip(radial(one), radial(other)) if low < r < high]
    meanA, meanB = (sum(p[i] for p in pairs) / len(pairs) for i in (0, 1))
    covariance = sum((a - meanA) * (b - meanB) for a, b in pairs) / len(pairs)
    return math.sqrt(max(covariance, 0)) / 0.5


def starContrast(picture, frequency):
    """Contrast of the spokes' first harmonic, whose amplitude in the star is 2 / pi."""
    radius = SPOKES / (2 * math.pi * frequency)
    values = [(a, v) for r, a, v in radial(picture) if abs(r - radius) < 1]
    amplitude = abs(sum(v * cmath.exp(-1j * SPOKES * a) for a, v in values)) * 2 / len(values)
    return amplitude / (2 / math.pi)


def edge(picture):
    """MTF50 in cycles per pixel, and the overshoot."""
    bins, tangent, cosine = {}, math.tan(math.radians(EDGE_DEGREES)), math.cos(math.radians(EDGE_DEGREES))
    parts, reach = 8, 16  # bins in a pixel; pixels on either side
    for y, row in enumerate(picture):
        for x, value in enumerate(row):
            distance = (x + 0.5 - SIZE / 2 - (SIZE / 2 - y - 0.5) * tangent) * cosine
            if abs(distance) < reach:
                bins.setdefault(math.floor(distance * parts), []).append(value)
    spread = [sum(b) / len(b) for _, b in sorted(bins.items())]
    line = [b - a for a, b in zip(spread, spread[1:])]

    def transfer(frequency):
        return abs(sum(v * cmath.exp(-2j * math.pi * frequency * i / parts) for i, v in enumerate(line)))

    whole, frequency = transfer(0), 0
    while transfer(frequency) > whole / 2:
        frequency += 0.001
    return frequency, max(max(spread) - 1, -min(spread))


def main():
    parser = study.parser(__doc__)
    parser.add_argument("--scenes", action="store_true")
    if parser.parse_args().scenes:
        for name, make in SCENES.items():
            (ROOT / "scenes/filters" / (name + ".pbrt")).write_text(make())
        return
    study.build("imagemagick")
    rows, sheet = "", []
    folder = study.WORK.name
    for name in FILTERS:
        pictures = {}
        for scene in SCENES:
            text = (ROOT / "scenes/filters" / (scene + ".pbrt")).read_text().replace('"gaussian"', f'"{name}"')
            path = pathlib.Path(folder) / f"{scene}-{name}"
            path.with_suffix(".pbrt").write_text(text)
            for seed in ("1", "2") if scene == "zone-plate" else ("1",):
                subprocess.run([study.PROGRAM, "render", path.with_suffix(".pbrt"), "-q", "--spp",
                                str(SAMPLES), "-o", path.with_suffix(".pfm"), "-o", path.with_suffix(".png"),
                                "--seed", seed, "--exposure", "0", "--tonemap", "none"], check=True)
                pictures[scene + seed] = readPfm(path.with_suffix(".pfm"))
        sheet.append(pathlib.Path(folder) / f"zone-plate-{name}.png")
        half, overshoot = edge(pictures["slanted-edge1"])
        rows += f"| `{name}` | {100 * aliasing(pictures['zone-plate1'], pictures['zone-plate2']):.2f} % | {half:.3f} | " \
                f"{100 * starContrast(pictures['siemens-star1'], STAR_FREQUENCY):.0f} % | {100 * overshoot:.1f} % |\n"
        print(rows.splitlines()[-1], flush=True)
    subprocess.run(["convert", *sheet, "+append", "-quality", "85", ROOT / "doc-files/results/filters.jpg"], check=True)
    (ROOT / "doc-files/results/filters.md").write_text(f"""# Pixel filters and fine detail

Made by `scripts/study/filters.py` on {study.provenance()}, with {SAMPLES} samples per pixel and each filter's own defaults; not edited by hand.

![Zone plates by each filter: {', '.join(FILTERS)}](filters.jpg)

| filter | aliasing | MTF50 [cycles per pixel] | contrast at {STAR_FREQUENCY} cycles per pixel | overshoot |
| --- | ---: | ---: | ---: | ---: |
{rows}
- **aliasing**: of rings that pixels cannot resolve, 0.62 to 0.99 cycles per pixel
  ([scenes/filters/zone-plate.pbrt](../../scenes/filters/zone-plate.pbrt)): the deviation from uniform grey, relative to the rings themselves. Less is better.
- **MTF50**: the frequency at which an edge keeps half of its contrast, by the method of ISO 12233
  ([scenes/filters/slanted-edge.pbrt](../../scenes/filters/slanted-edge.pbrt)). More is sharper; pixels resolve at most 0.5.
- **contrast**: contrast of the spokes of a Siemens star ([scenes/filters/siemens-star.pbrt](../../scenes/filters/siemens-star.pbrt)).
- **overshoot**: of the edge beyond black and white, relative to its height.
""")


main()
