#!/usr/bin/env python3
"""Renders scenes by `photonmap` and compares them with pictures by other renderers, colour by colour and place by place.

Each SCENE of ../shared/reference (default: dispersion) is rendered with 64 samples a pixel. The table has the ratios of
means, for red, green and blue, and the noise-free relMSE of means over 8x8 pixels. Exit status 1 where a mean is off by
more than .5 % or that error is above .001; scenes that are not there are left out, and it is said.
"""
import sys

import study


def main():
    parser = study.parser(__doc__)
    parser.add_argument('scenes', metavar='SCENE', nargs='*', default=['dispersion'])
    scenes = parser.parse_args().scenes
    study.build()
    print('| scene | ratio of means | relMSE of 8x8 pixels |\n| --- | --- | --- |')
    failed = False
    for scene in scenes:
        source, picture = study.REFERENCES / (scene + '.pbrt'), study.temporary('picture.exr')
        if not source.exists():
            print('| %s | not there | |' % scene)
            continue
        study.render(source, picture, '--integrator', 'photonmap', '--spp', 64)
        found = study.compare(picture, *study.independentReferences(scene))
        ratios, error = found['mean_ratio_rgb'], found['relmse_noise_free_at_8']
        wrong = error > .001 or any(abs(r - 1) > .005 for r in ratios)
        failed |= wrong
        print('| %s | %s | %.2g%s |' % (scene, ' '.join('%.4f' % r for r in ratios), error,
                                        ' (too much)' if wrong else ''))
    sys.exit(failed)


main()
