#!/usr/bin/env python3
"""Gain of adaptive samples: renders with and without them, and prints the time to the same error as a ratio.

Scenes are rendered with and without --adaptive at the same number of samples on average, and with twice that number,
equal for all pixels, with several seeds each. The table has noise-free relMSE of uniform samples, its exponent
between the two numbers of samples, the ratios of adaptive to uniform relMSE and processor time, and from these the
time to the same error as a ratio (as if the exponent were -1 where it is less: samples do not reduce an error that
all pixels share). plates, cornell and other scenes with references come from ../shared/reference and are left out
where it is missing; scenes/trellis.pbrt gets references by path tracing, with direct light of the sun (maxdepth 1)
and with all light. Takes about ten minutes.
"""
import math

import study

SHARED = (('plates', (('path', 16), ('path', 64), ('photonmap', 16), ('sppm', 32))),
          ('cornell', (('path', 32), ('photonmap', 32), ('sppm', 32))),
          ('materials', (('path', 32), ('sppm', 32))), ('cornell-glass', (('sppm', 32),)),
          ('hexroom-grey', (('path', 32), ('sppm', 32))), ('ajar', (('sppm', 32),)), ('sds', (('sppm', 32),)))


def measure(name, scene, references, options, samples, seeds):
    picture = study.temporary('x.exr')
    ways = ((options, samples), (options + ['--adaptive'], samples), (options, 2 * samples))
    errors, times = [0, 0, 0], [0, 0, 0]
    for seed in range(1, seeds + 1):
        for i, (way, n) in enumerate(ways):
            times[i] += study.render(scene, picture, *way, '--spp', n, '--seed', seed)['processor_seconds']
            errors[i] += study.compare(picture, *references)['relmse_noise_free']
    e, t = errors[1] / errors[0], times[1] / times[0]
    fall = math.log2(errors[0] / errors[2])
    print('| %s | %s, %d samples | %.3g | %.2f | %.2f | %.2f | **%.2f** |' % (
        name, ' '.join(options), samples, errors[0] / seeds, -fall, e, t, t * e ** (1 / max(fall, 1))), flush=True)


def main():
    parser = study.parser(__doc__)
    parser.add_argument('--seeds', type=int, default=2, help='default: 2')
    seeds = parser.parse_args().seeds
    study.build()
    print('| scene | options | relMSE, even | exponent | relMSE ratio | processor time ratio | time to the same error |')
    print('| --- | --- | ---: | ---: | ---: | ---: | ---: |')
    trellis = study.ROOT / 'scenes/trellis.pbrt'
    halves = [study.temporary(half) for half in ('a.exr', 'b.exr')]
    for options in (['--integrator', 'path', '--maxdepth', '1'], ['--integrator', 'path']):
        for i, half in enumerate(halves):
            study.render(trellis, half, *options, '--spp', 768, '--seed', 1001 + i)
        for samples in (16, 64):
            measure('trellis', trellis, halves, options, samples, seeds)
    for name, ways in SHARED:
        scene = study.REFERENCES / (name + '.pbrt')
        if not scene.exists():
            continue
        for integrator, samples in ways:
            measure(name, scene, study.independentReferences(name), ['--integrator', integrator], samples, seeds)


main()
