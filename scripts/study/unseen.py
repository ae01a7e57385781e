#!/usr/bin/env python3
"""Renders scenes that nobody tuned for by several integrators, and writes doc-files/results/unseen.md.

FOLDER has scenes NAME.pbrt, and beside most of them NAME.a.exr and NAME.b.exr: references with independent noise.
Each is rendered with few samples a pixel at the size of its references, at a low priority. The page says for each
whether it succeeded, and has the ratio of the picture's mean to the references' and the noise-free relMSE of means
over 8x8 pixels. Takes some minutes.
"""
import datetime
import os
import pathlib
import subprocess

import study

PAGE = study.ROOT / 'doc-files/results/unseen.md'
SEED = 100         # no seed of the references
TIMEOUT = 600      # seconds, of one render
SIZE = '160x120'   # of scenes without references
HEAD = '''# Scenes that nobody tuned for

Made by `scripts/study/unseen.py %(command)s` on %(date)s, commit %(commit)s; not edited by hand. %(spp)d samples a pixel,
seed %(seed)d, at the size of the references, or %(size)s where there are none. `mean`: mean of the picture over the mean of the
references; with so few samples single pixels may decide it. `error`: noise-free relMSE of means over 8x8 pixels.
`processor`: time of all threads, on a machine that others used meanwhile.

| scene | integrator | ended | mean | error | processor [s] | remarks |
| --- | --- | --- | ---: | ---: | ---: | --- |
'''


def row(scene, integrator, spp):
    pair = [scene.with_suffix('.%s.exr' % half) for half in 'ab']
    isKnown = all(p.exists() for p in pair)
    size = study.pictureSize(pair[0]) if isKnown else SIZE
    picture = study.temporary('picture.exr')
    cells = [scene.stem, '`%s`' % integrator]
    try:
        stats = study.render(scene, picture, '--resolution', size, '--spp', spp, '--seed', SEED, '--integrator', integrator,
                             timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return cells + ['not within %d s' % TIMEOUT, '', '', '', '']
    except subprocess.CalledProcessError as error:
        how = 'by signal %d' % -error.returncode if error.returncode < 0 else 'with status %d' % error.returncode
        return cells + [how, '', '', '', study.firstLine(error)]
    remarks = ['%d values not finite' % stats['non_finite']] if stats['non_finite'] else []
    if stats['integrator'] not in (integrator, 'auto'):
        remarks.append('by `%s`' % stats['integrator'])
    found = study.compare(picture, *pair) if isKnown else None
    return cells + ['well', '%.3f' % found['mean_ratio'] if found else '–',
                    '%.2g' % found['relmse_noise_free_at_8'] if found else '–', '%.1f' % stats['processor_seconds'],
                    ', '.join(remarks)]


def main():
    parser = study.parser(__doc__)
    parser.add_argument('folder', metavar='FOLDER', type=pathlib.Path)
    parser.add_argument('--spp', type=int, default=4)
    parser.add_argument('--integrators', metavar='NAME,...', default='auto,path,vcm')
    options = parser.parse_args()
    study.build()
    os.nice(10)
    command = 'FOLDER --spp %d --integrators %s' % (options.spp, options.integrators)
    commit = subprocess.run(['git', 'rev-parse', '--short', 'HEAD'], cwd=study.ROOT, capture_output=True, text=True)
    page = HEAD % {'command': command, 'date': datetime.date.today(), 'commit': commit.stdout.strip(), 'spp': options.spp,
                   'seed': SEED, 'size': SIZE}
    for scene in sorted(options.folder.glob('*.pbrt')):
        if 'WorldBegin' not in scene.read_text(errors='replace'):
            continue  # a part that scenes include
        for integrator in options.integrators.split(','):
            cells = row(scene, integrator, options.spp)
            print(*cells, sep=' | ', flush=True)
            page += '| ' + ' | '.join(cells) + ' |\n'
            PAGE.parent.mkdir(exist_ok=True)
            PAGE.write_text(page)
    print('written: ' + str(PAGE.relative_to(study.ROOT)))


main()
