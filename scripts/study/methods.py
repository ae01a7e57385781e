#!/usr/bin/env python3
"""Renders three scenes by every method side by side, and writes doc-files/results/methods.md with a sheet of each.

Runs `recurse methods` on the hexagonal room, the Cornell box with glass and the room with a window, TIME for each
method (default: 10s). Takes ten minutes, and needs the machine for itself; finished pictures are kept in
build/methods, and a second run continues from them.
"""
import os
import subprocess

import study

SCENES = (('hexroom', '200x200', 600, 'The hexagonal room of a course report'),
          ('cornell-glass', '200x200', 600, 'A Cornell box with a mirror and a glass sphere'),
          ('window', '200x150', 1500, 'A room that the sun and the sky light through a window'))
HEAD = '''# Methods side by side

Made by `scripts/study/methods.py` on %s; not edited by hand. Each method has %s on %d threads, %s, with a load
average of %.2f before. Left in each pair is the picture of the method, right its missing light: the difference from
the reference where the picture is darker. The tables are the output of `recurse methods`. **error** is relMSE against all
light, **own error** and **own mean** against the light on the paths that the method computes, which the last column gives
as an expression; **left out** is the fraction of the light on all other paths.
'''
SECTION = '''
## %(title)s

[scenes/%(name)s.pbrt](../../scenes/%(name)s.pbrt), %(size)s pixels.

![%(title)s by every method](methods-%(name)s.jpg)

```
%(table)s
```
'''


def main():
    parser = study.parser(__doc__)
    parser.add_argument('time', metavar='TIME', nargs='?', default='10s')
    limit = parser.parse_args().time
    study.build('imagemagick')
    work = study.ROOT / 'build/methods'
    work.mkdir(parents=True, exist_ok=True)
    page = HEAD % (study.provenance(), limit, os.cpu_count(), study.processorName(), study.loadAverage())
    for name, size, samples, title in SCENES:
        print(name, flush=True)
        table = study.recurse('methods', study.ROOT / ('scenes/%s.pbrt' % name), '-o', work / name, '--time-limit', limit,
                              '--resolution', size, '--reference-spp', samples, '-q')
        subprocess.run(['convert', work / name / 'sheet.png', '-resize', '1400x', '-quality', '82',
                        study.ROOT / ('doc-files/results/methods-%s.jpg' % name)], check=True)
        page += SECTION % {'title': title, 'name': name, 'size': size, 'table': table.rstrip('\n')}
    (study.ROOT / 'doc-files/results/methods.md').write_text(page)
    print('written: doc-files/results/methods.md and its pictures')


main()
