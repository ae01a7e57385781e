#!/usr/bin/env python3
"""Scenes of many triangles: time and memory of 100 million in instances and 20 million of their own.

Renders generated scenes with and without --compact, and writes doc-files/results/big-scenes.md. Takes some minutes, 16 GB of
memory and 1 GB of disk; --quick renders a hundredth of each, and only prints.
"""
import array
import math
import os

import study

HEAD = '''Film "rgb" "integer xresolution" 320 "integer yresolution" 200
LookAt 0 -2.6 1.2  0 0 0  0 0 1
Camera "perspective" "float fov" 60
WorldBegin
LightSource "distant" "point3 from" [ 1 -1 2 ] "rgb L" [ 2 2 2 ]
LightSource "infinite" "rgb L" [ .4 .5 .7 ]
Material "diffuse" "rgb reflectance" [ .6 .55 .5 ]
'''

def hills(n):
    """A binary PLY file of about n triangles over [-1.8, 1.8]²."""
    side = round(math.sqrt(n / 2))
    with open(study.temporary('hills.ply'), 'wb') as f:
        f.write(('ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n'
                 'property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n'
                 % ((side + 1) ** 2, 2 * side * side)).encode())
        for j in range(side + 1):
            y, row = 3.6 * j / side - 1.8, array.array('f')
            for i in range(side + 1):
                x = 3.6 * i / side - 1.8
                row.extend((x, y, .1 * math.sin(7 * x) * math.cos(5 * y) + .01 * math.sin(90 * x + 60 * y)))
            f.write(row.tobytes())
        for j in range(side):
            row = bytearray()
            for a in range(j * (side + 1), j * (side + 1) + side):
                row += b'\3' + array.array('i', (a, a + 1, a + side + 1)).tobytes()
                row += b'\3' + array.array('i', (a + 1, a + side + 2, a + side + 1)).tobytes()
            f.write(row)
    return 2 * side * side

def measure(name, text, compact):
    path = study.temporary(name)
    with open(path, 'w') as f: f.write(text)
    return study.render(path, study.temporary('o.exr'), '--integrator', 'path', '--spp', '8', '--maxdepth', '3',
                        *(['--compact'] if compact else []))

rows = ''
def row(title, triangles, name, text):
    global rows
    for compact in (False, True):
        s = measure(name, text, compact)
        rows += '| %s | %.1f M | %s | %.1f | %.1f | %.2f | %.2f |\n' % (
            title, triangles / 1e6, 'yes' if compact else 'no', s['load_seconds'] + s['build_seconds'],
            s['processor_seconds'], s['rays'] / s['processor_seconds'] / 1e6, s['peak_memory_bytes'] / 1e9)
        print(rows.splitlines()[-1], flush=True)

def main():
    parser = study.parser(__doc__)
    parser.add_argument('--quick', action='store_true')
    quick = parser.parse_args().quick
    part, page = 100 if quick else 1, study.ROOT / 'doc-files/results/big-scenes.md'
    study.build()
    count, side = hills(10000), 100 // (10 if quick else 1)
    text = HEAD + 'ObjectBegin "hills"\nShape "plymesh" "string filename" "hills.ply"\nObjectEnd\n'
    for j in range(side):
        for i in range(side):
            text += 'AttributeBegin Translate %.6g %.6g 0 Scale %.6g %.6g .1 Rotate %d 0 0 1 ObjectInstance "hills" AttributeEnd\n' % (
                3.6 * (i + .5) / side - 1.8, 3.6 * (j + .5) / side - 1.8, 1 / side, 1 / side, 90 * ((i * 7 + j * 3) % 4))
    row('%d instances of one mesh' % (side * side), side * side * count, 'instances.pbrt', text)
    count = hills(20000000 // part)
    row('one mesh', count, 'mesh.pbrt', HEAD + 'Shape "plymesh" "string filename" "hills.ply"\n')
    if not quick:
        with open(page, 'w') as f:
            f.write('''# Big scenes

Made by `scripts/study/big.py` on %s; not edited by hand. 320x200 pixels, 8 samples, `path` with three bounces, %s threads. Reading and
building is wall time, of what else runs on the machine too; the picture is processor time of all threads.

| scene | triangles | `--compact` | read and build [s] | picture, processor [s] | rays [M/s of a core] | memory [GB] |
| --- | ---: | --- | ---: | ---: | ---: | ---: |
%s''' % (study.provenance(), os.cpu_count(), rows))


main()
