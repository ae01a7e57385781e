#!/usr/bin/env python3
"""Makes the contact sheet of all tone operators, doc-files/operators.jpg.

PICTURE.exr has linear values; by default scenes/cornell-glass.pbrt is rendered, in a minute or so.
"""
import subprocess

import study


def main():
    parser = study.parser(__doc__)
    parser.add_argument('picture', metavar='PICTURE.exr', nargs='?')
    picture = parser.parse_args().picture
    study.build('openimageio-tools')
    if not picture:
        picture = study.temporary('picture.exr')
        study.render(study.ROOT / 'scenes/cornell-glass.pbrt', picture, '--resolution', '300x300', '--spp', 64)
    sheet = study.temporary('sheet.png')
    study.recurse('develop', picture, '--sheet', '-o', sheet)
    subprocess.run(['oiiotool', '--nosoftwareattrib', sheet, '--compression', 'jpeg:80', '-o', study.ROOT / 'doc-files/operators.jpg'],
                   check=True)
    print('written: doc-files/operators.jpg')


main()
