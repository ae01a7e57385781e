#!/usr/bin/env python3
"""Compares two ways of rendering at equal processor time: the ratio of their errors at one pixel and over 8x8 pixels.

Each SCENE is rendered with the options A and B, on one thread, with a number of samples that takes SECONDS of
processor time by a calibration; the errors are multiplied by the measured time. The table has the noise-free relMSE
of both, and the ratio A over B with its standard error from several seeds: above 1, B is the better one. With
--classes it has a row for each class of paths, by `recurse stills`.

Scenes with pictures beside them, NAME.a.exr and NAME.b.exr, are compared with those, at their size; for all other
scenes, and for classes, two long renders are the reference, which are kept. Without a SCENE: all of scenes/ and, if
it exists, of ../shared/real with its folder `unseen`.

  scripts/study/equalTime.py scenes/window.pbrt --a '--integrator path' --b '--integrator vcm' --seeds 2 --seconds 10
"""
import collections
import os
import shlex
import subprocess

import study

SCALES = (1, 8)
FIRST_SEED = 1001  # references have others

Way = collections.namedtuple('Way', 'options samples')
Found = collections.namedtuple('Found', 'errors seconds mean')  # errors by class, then by scale; times the time


def rendered(scene, options, samples, seed, classes):
    """Processor seconds of a render, and its picture."""
    picture = study.temporary('picture' if classes else 'picture.exr')
    stats = study.render(scene, picture, '--nthreads', 1, '--seed', seed, *options, '--spp', samples,
                         command='stills' if classes else 'render')
    return stats['processor_seconds'], picture


def calibrated(scene, options, wanted, classes):
    """The number of samples that takes the wanted processor time."""
    few, many = 1, 5
    first, more = (rendered(scene, options, n, FIRST_SEED, classes)[0] for n in (few, many))
    return max(1, round(few + (wanted - first) / max((more - first) / (many - few), 1e-3)))


def measured(scene, way, seed, pair, classes):
    """The errors of one render times the seconds it took."""
    seconds, picture = rendered(scene, way.options, way.samples, seed, classes)
    e = study.compare(picture, *pair)
    rows = {c['name']: c for c in e['classes']} if classes else {'': e}
    errors = {name: [c['relmse_noise_free_at_%d' % k] for k in SCALES] for name, c in rows.items()}
    return Found({n: [v * seconds for v in values] for n, values in errors.items()}, seconds, e['mean_ratio'])


def measure(scene, options):
    if options.classes:
        size = study.sizeOfWidth(scene, options.width)
        pair = study.referencePair(scene, options.references, size, options.minutes, options.reference, 'stills')
        resolution = ['--resolution', size]
    else:
        resolution, pair = study.references(scene, options.references, options.width, options.minutes,
                                            options.reference)
    ways = []
    for text in (options.a, options.b):
        way = resolution + shlex.split(text)
        ways.append(Way(way, calibrated(scene, way, options.seconds, options.classes)))
    found = ([], [])
    for seed in range(FIRST_SEED, FIRST_SEED + options.seeds):  # in turns, so that other load meets both
        for way, results in zip(ways, found):
            results.append(measured(scene, way, seed, pair, options.classes))

    def mean(values): return sum(values) / len(values)
    name = os.path.relpath(scene, study.ROOT)
    both = ['%d / %d' % (ways[0].samples, ways[1].samples)]
    both.append(' / '.join('%.1f' % mean([r.seconds for r in results]) for results in found))
    both.append(' / '.join('%.4f' % mean([r.mean for r in results]) for results in found))
    for kind in found[0][0].errors:
        row = [name + (': ' + kind if kind else '')] + both
        for k in range(len(SCALES)):
            errors = [[r.errors[kind][k] for r in results] for results in found]
            row.append(' / '.join('%.3g' % (mean(e) / options.seconds) for e in errors))
            row.append(study.ratioText(study.ratio(*errors)))
        print('| %s |' % ' | '.join(row), flush=True)


def main():
    parser = study.parser(__doc__)
    parser.add_argument('scenes', metavar='SCENE', nargs='*')
    parser.add_argument('--a', default='--integrator path', metavar='OPTIONS', help='default: --integrator path')
    parser.add_argument('--b', default='--integrator photonmap', metavar='OPTIONS',
                        help='default: --integrator photonmap')
    parser.add_argument('--seconds', type=float, default=30, help='of processor time for each picture; default: 30')
    parser.add_argument('--seeds', type=int, default=5, help='default: 5')
    parser.add_argument('--width', type=int, default=320, help='of pictures without references [pixels]; default: 320')
    parser.add_argument('--classes', action='store_true', help='a row for each class of paths')
    parser.add_argument('--minutes', type=float, default=3, help='of each of the two references; default: 3')
    parser.add_argument('--reference', default='path', metavar='INTEGRATOR', help='of the references; default: path')
    parser.add_argument('--references', default=study.CACHE, metavar='DIR', help='where they are kept; default: %(default)s')
    options = parser.parse_args()
    study.build()
    print('A: %s; B: %s\n' % (options.a, options.b))
    print('| scene | samples | processor s | mean over reference | relMSE A / B | ratio | 8x8 pixels A / B | ratio |')
    print('| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |')
    own = sorted((study.ROOT / 'scenes').glob('*.pbrt'))
    for scene in options.scenes or own + sorted(study.PUBLIC.glob('*/*.pbrt')):
        try:
            measure(scene, options)
        except subprocess.CalledProcessError as e:
            print('| %s | not rendered: %s |' % (os.path.relpath(scene, study.ROOT), study.firstLine(e)), flush=True)


main()
