#!/usr/bin/env python3
"""Renders ten scenes by the Blender add-on and by Cycles into doc-files/blender.jpg: of each pair the left one is
Recurse's. Prints the means of Recurse over those of Cycles. Needs Blender, and the Python module in build/release.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / 'build' / 'release'
COLUMNS = 2


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--samples', default='64', help='samples of each pixel (default: 64)')
    parser.add_argument('--size', default='120x90', help='of each picture (default: 120x90)')
    options = parser.parse_args()
    import numpy as np
    sys.path.insert(0, str(BUILD / 'python'))
    import recurse
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(['blender', '-b', '--factory-startup', '--python-exit-code', '1', '--python',
                        ROOT / 'tests' / 'blender' / 'compareCycles.py', '--', ROOT / 'src' / 'blender', BUILD / 'recurse',
                        folder, options.samples, options.size], check=True, stdout=subprocess.DEVNULL)
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
