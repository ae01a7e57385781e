#!/usr/bin/env python3
"""Renders ten scenes by the Blender add-on and by Cycles into doc-files/blender.jpg: Recurse is on the left of each
pair. Prints the ratios of the means, Recurse over Cycles. With --large, prints instead the time that the add-on takes
to write a large scene, and the program to start it. Needs Blender, the Python module in build/release, and the
system's Python, beside which Blender looks for its modules.
"""
import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / 'build' / 'release'
COLUMNS = 2


def in_blender(script, *arguments):
    """Runs a script of tests/blender with the add-on."""
    subprocess.run(['blender', '-b', '--factory-startup', '--python-exit-code', '1', '--python',
                    ROOT / 'tests' / 'blender' / script, '--', ROOT / 'src' / 'blender', *arguments],
                   check=True, stdout=subprocess.DEVNULL)


def large(triangles, instances):
    """Prints a table of seconds."""
    with tempfile.TemporaryDirectory() as folder:
        in_blender('largeScene.py', folder, str(triangles), str(instances))
        written = json.loads(pathlib.Path(folder, 'seconds.json').read_text())
        start, before = time.time(), resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([BUILD / 'recurse', 'render', f'{folder}/scene.pbrt', '-q', '-o', f'{folder}/picture.exr', '--spp', '1',
                        '--integrator', 'raycast', '--stats', f'{folder}/stats.json'], check=True)
        program, after = time.time() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
        processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        statistics = json.loads(pathlib.Path(folder, 'stats.json').read_text())
    print('| step | seconds | of one processor |\n| --- | --- | --- |')
    for name, step in (('written', 'first'), ('written again', 'again')):
        print(f"| {name} | {written[step]['seconds']:.1f} | {written[step]['processor']:.1f} |")
    print(f"| read | {statistics['load_seconds']:.1f} | |\n| built | {statistics['build_seconds']:.1f} | |")
    print(f"| program | {program:.1f} | {processor:.1f} |")
    print(f"{written['instances']} instances")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--samples', default='64', help='samples of each pixel (default: 64)')
    parser.add_argument('--size', default='120x90', help='of each picture (default: 120x90)')
    parser.add_argument('--large', action='store_true', help='how long a large scene takes to write and to start')
    parser.add_argument('--triangles', type=int, default=5000000, help='of the large scene (default: 5000000)')
    parser.add_argument('--instances', type=int, default=100000, help='of the large scene (default: 100000)')
    options = parser.parse_args()
    if options.large:
        large(options.triangles, options.instances)
        return
    import numpy as np
    sys.path.insert(0, str(BUILD / 'python'))
    import recurse
    with tempfile.TemporaryDirectory() as folder:
        in_blender('compareCycles.py', BUILD / 'recurse', folder, options.samples, options.size)
        results = json.loads(pathlib.Path(folder, 'means.json').read_text())
        pairs = []
        for name, engines in results.items():
            ratios = [a / b for a, b in zip(engines['RECURSE']['means'], engines['CYCLES']['means'])]
            print(f'| {name} |', ' '.join(f'{ratio:.4f}' for ratio in ratios), '|',
                  f"{engines['RECURSE']['seconds']:.1f} | {engines['CYCLES']['seconds']:.1f} |")
            pairs.append(np.concatenate([recurse.read(f'{folder}/{name}-{engine.lower()}.exr').array for engine in engines],
                                        axis=1))
    rows = [np.concatenate(pairs[i:i + COLUMNS], axis=1) for i in range(0, len(pairs), COLUMNS)]
    sheet = recurse.Picture.of(np.concatenate(rows))
    sheet.save(ROOT / 'doc-files' / 'blender.jpg', exposure=0, tonemap='none')


main()
