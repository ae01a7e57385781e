#!/usr/bin/env python3
"""Renders the table of a Monte Carlo course report again, and writes doc-files/results/hexroom.md and
doc-files/results/hexroom.jpg.

The hexagonal room with the five settings of the report: time then, time now, and the remaining error. Takes a few
minutes. The converged reference of all light is looked for in ../shared/reference; without it one is rendered, and
the page says so. --reach: only the time that photonmap and path take to the error of the last row, as the page has
it.
"""
import os
import re
import subprocess

import study

SETTINGS = ((3, 1, 3), (3, 10, 10), (3, 3, 5), (10, 3, 15), (50, 3, 80))  # samples, shadow rays, minutes then
BOUNCES = 3
TARGET_SECONDS = (2, 4, 8, 16, 32, 64)  # of the runs that are to reach the error of the last row
NOISE_SAMPLES = 24  # of each of the two references with three bounces
FULL_SAMPLES = 96   # of each of the two references with all light, where they are made here
SCENE = study.ROOT / 'scenes/hexroom.pbrt'
PAGE = study.ROOT / 'doc-files/results/hexroom.md'
HEAD = '''# The hexagonal room of a course report

Made by `scripts/study/hexroom.py` on %(provenance)s; not edited by hand.

A Monte Carlo course report gives a table of five renderings of a room with six coloured walls, a diffuse and a mirror
sphere, a tetrahedron and a lamp of 2x1 under the ceiling ([scenes/hexroom.pbrt](../../scenes/hexroom.pbrt)): 800x800
pixels, paths of at most three bounces, and given numbers of samples per pixel and of shadow rays at each bounce. This
is the same table with the same parameters, by `--integrator path --maxdepth %(bounces)d --spp N --light-samples N`.

![The room, 50 samples per pixel and 3 shadow rays, reduced to 560x560](hexroom.jpg)

| samples | shadow rays | then | here, processor | times as fast | noise left | error left, all light | light that is there |
| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
%(rows)s
- **here**: processor time of the render alone, of its %(threads)d threads together, on %(machine)s, at a load average
  of %(load).2f before.
- **noise left**: relMSE against a converged picture with the same three bounces, which is the error that more samples
  would remove: mean of (x−a)(x−b)/(r²+ε), ε = 0.01, no trim, where a and b are two independent pictures of
  %(noise)d samples and r is their mean. Their own noise is not included.
- **error left, all light**: the same measure for the same settings against a reference with paths of any length,
  %(full)s.
  It includes the missing light of the fourth and later bounces, which more samples do not add.
- **light that is there**: mean of that picture over mean of that reference.
'''
REACH = '''
## The time to the error of the last row

That row leaves an error of %(target).3g against all light, after 80 minutes then. The table has renders
of the same room and size as the reference, each with twice the time limit of the one before, until the error is as small, with
wall time and processor time, on %(threads)d threads, at a load average of %(load).2f before.
Where the limit ends before the first photon map is ready, the picture is one sample of each pixel by path tracing: its error is
high.

| method | wall time | processor time | error left, all light |
| --- | ---: | ---: | ---: |
%(rows)s'''
LOAD = study.loadAverage()


def fullReference():
    """Scene, options, arguments of compare() without and with a best picture, and a description of the reference."""
    scene = study.REFERENCES / 'hexroom-grey.pbrt'
    if scene.exists():
        return (scene, [], study.independentReferences('hexroom-grey'),
                'of the same room with grey walls at 256x256 (bidirectional path tracing by another renderer, 398 samples '
                'per pixel)')
    halves = [study.temporary('full.%s.exr' % half) for half in 'ab']
    size = ['--resolution', '256x256']
    for i, half in enumerate(halves):
        study.render(SCENE, half, *size, '--integrator', 'path', '--spp', FULL_SAMPLES, '--seed', 1003 + i)
    return (SCENE, size, halves, "at 256x256 by Recurse's own path tracer, two of %d samples per pixel, as the one of "
            'another renderer was not at hand' % FULL_SAMPLES)


def reach(target, scene, size, references):
    rows, picture = '', study.temporary('t.exr')
    for name, options in (('photonmap', ['--integrator', 'photonmap']),
                          ('photonmap with one map', ['--integrator', 'photonmap', '--set', 'passes=1']),
                          ('path, paths of any length', ['--integrator', 'path'])):
        for seconds in TARGET_SECONDS:
            print('%s, %d s' % (name, seconds), flush=True)
            stats = study.render(scene, picture, *size, '--time-limit', '%ds' % seconds, *options)
            error = study.compare(picture, *references)['relmse_noise_free']
            rows += '| %s | %.1f s | %.1f s | %.3g |\n' % (name, stats['render_seconds'], stats['processor_seconds'], error)
            if error <= target:
                break
        else:
            rows += '| %s | not within %d s | | |\n' % (name, TARGET_SECONDS[-1])
    return REACH % {'target': target, 'threads': os.cpu_count(), 'load': LOAD, 'rows': rows}


def table(scene, size, references):
    """Rows of the page, the error of the last one, and the threads."""
    noise = [study.temporary('noise.%s.exr' % half) for half in 'ab']
    for i, half in enumerate(noise):
        study.render(SCENE, half, '--integrator', 'path', '--maxdepth', BOUNCES, '--spp', NOISE_SAMPLES, '--seed', 1001 + i)
    rows, picture, shown = '', study.temporary('x.exr'), study.temporary('x.png')
    for samples, shadowRays, minutes in SETTINGS:
        print('%d samples, %d shadow rays' % (samples, shadowRays), flush=True)
        settings = ['--integrator', 'path', '--maxdepth', BOUNCES, '--spp', samples, '--light-samples', shadowRays]
        stats = study.render(SCENE, picture, '-o', shown, '--exposure', 0, '--tonemap', 'none', *settings)
        left = study.compare(picture, *noise)['relmse_noise_free']
        full = study.temporary('full.exr')
        study.render(scene, full, *size, *settings)
        all = study.compare(full, *references)
        rows += '| %d | %d | %d min | %.2f s | %.0f | %.3g | %.3g | %.4f |\n' % (
            samples, shadowRays, minutes, stats['processor_seconds'], minutes * 60 / stats['processor_seconds'], left,
            all['relmse_noise_free'], all['mean_ratio'])
    subprocess.run(['oiiotool', '--nosoftwareattrib', shown, '--resize', '560x560', '--compression', 'jpeg:80', '-o',
                    study.ROOT / 'doc-files/results/hexroom.jpg'], check=True)
    return rows, all['relmse_noise_free'], stats['threads']


def main():
    parser = study.parser(__doc__)
    parser.add_argument('--reach', action='store_true')
    options = parser.parse_args()
    study.build('openimageio-tools')
    scene, size, references, what = fullReference()
    if options.reach:
        page = PAGE.read_text().split('\n## The time to the error')[0]
        target = float(re.search(r'^\| 50 \|(?:[^|]*\|){5} *([^ |]+)', page, re.M).group(1))
    else:
        rows, target, threads = table(scene, size, references)
        page = HEAD % {'provenance': study.provenance(), 'bounces': BOUNCES, 'rows': rows, 'threads': threads, 'machine': study.processorName(), 'load': LOAD,
                       'noise': NOISE_SAMPLES, 'full': what}
    PAGE.write_text(page + reach(target, scene, size, references))
    print('written: doc-files/results/hexroom.md' + ('' if options.reach else ', doc-files/results/hexroom.jpg'))


main()
