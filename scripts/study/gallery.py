#!/usr/bin/env python3
"""Renders the sheet of materials, a sphere for each model and roughness, into doc-files/materials.jpg.

Rows are models, columns a roughness from 0 to 1; the last row has what has none. Further options go to `recurse render`.
"""
import subprocess

import study

METAL = '"rgb reflectance" [.95 .8 .45]'
GLOSS = '"rgb specular" [.3 .3 .3] "rgb reflectance" [.15 .35 .6]'
PLAIN = '"bool remaproughness" false'
ALPHAS = (0, .05, .1, .2, .4, .7, 1)
# The materials of a row; {a}: roughness, {e}: power of a cosine whose lobe is as wide, {t}: an angle in degrees.
ROWS = (
    ('conductor', METAL + ' "float roughness" {a} ' + PLAIN),
    ('conductor', METAL + ' "float roughness" {a} ' + PLAIN + ' "bool multiscatter" true'),
    ('conductor', METAL + ' "float uroughness" {a} "float vroughness" .05 ' + PLAIN),
    ('dielectric', '"float roughness" {a} ' + PLAIN),
    ('dielectric', '"float roughness" {a} ' + PLAIN + ' "bool multiscatter" true'),
    ('coateddiffuse', '"rgb reflectance" [.6 .15 .1] "float roughness" {a} ' + PLAIN),
    ('coatedconductor', METAL + ' "float conductor.roughness" {a} ' + PLAIN),
    ('plastic', '"rgb reflectance" [.6 .15 .1] "float roughness" {a} ' + PLAIN),
    ('torrancesparrow', '"rgb reflectance" [.15 .35 .6] "rgb specular" [.7 .7 .7] "float roughness" {a}'),
    ('ward', GLOSS + ' "float uroughness" {a} "float vroughness" {a}'),
    ('ashikhminshirley', GLOSS + ' "float uexponent" {e} "float vexponent" {e}'),
    ('blinnphong', GLOSS + ' "float exponent" {e}'),
    ('orennayar', '"rgb reflectance" [.5 .45 .35] "float sigma" {t}'),
)
WITH_MIRROR_LIMIT = {'conductor', 'dielectric', 'coateddiffuse', 'coatedconductor', 'plastic', 'orennayar'}
LAST = (
    ('diffuse', '"rgb reflectance" [.5 .45 .35]'),
    ('diffusetransmission', '"rgb reflectance" [.2 .3 .1] "rgb transmittance" [.4 .6 .1]'),
    ('thindielectric', ''),
    ('measured', '"string filename" "%s"' % (study.ROOT / 'scenes/materials/satin.binary')),
    ('mix', '"string materials" ["gold" "red"]'),
    ('compound', '"string materials" ["red" "gold" "glass"] "rgb weights" [.4 .4 .4 .3 .3 .3 .3 .3 .3]'),
    ('coateddiffuse', '"rgb albedo" [.9 .9 .9] "float thickness" 1 "rgb reflectance" [.6 .15 .1]'),
)
HEAD = '''Film "rgb" "integer xresolution" %d "integer yresolution" %d "string filename" "materials.jpg"
PixelFilter "gaussian"
Sampler "independent" "integer pixelsamples" 96
Integrator "photonmap" "integer passes" 0 "integer photons" 300000 "float radius" .2
LookAt 3 -6.5 -20  3 -6.5 0  0 1 0
Camera "orthographic" "float screenwindow" [ -3.5 3.5 -7 7 ]
WorldBegin
LightSource "infinite" "rgb L" [ .3 .32 .36 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 14 13 12 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -9 4 -13  -2 6 -13  -2 6 -7  -9 4 -7 ]
AttributeEnd
Texture "squares" "spectrum" "checkerboard" "float uscale" 42 "float vscale" 84
  "rgb tex1" [ .15 .16 .18 ] "rgb tex2" [ .5 .5 .5 ]
Material "diffuse" "texture reflectance" "squares"
Shape "bilinearmesh" "point3 P" [ -4 -17 .9  10 -17 .9  -4 11 .9  10 11 .9 ] "point2 uv" [ 0 0  1 0  0 1  1 1 ]
MakeNamedMaterial "red" "string type" "diffuse" "rgb reflectance" [ .6 .15 .1 ]
MakeNamedMaterial "gold" "string type" "conductor" %s "float roughness" .05 %s
MakeNamedMaterial "glass" "string type" "dielectric"
'''


def sphere(column, row, model, parameters):
    return ('AttributeBegin\nMaterial "%s" %s\nTranslate %d %d 0\nRotate 90 1 0 0\nShape "sphere" "float radius" .42\n'
            'AttributeEnd\n' % (model, parameters, column, -row))


def main():
    parser = study.parser(__doc__)
    options = parser.parse_known_args()[1]
    study.build()
    text = HEAD % (76 * len(ALPHAS), 76 * (len(ROWS) + 1), METAL, PLAIN)
    for row, (model, parameters) in enumerate(ROWS):
        for column, alpha in enumerate(ALPHAS):
            if alpha == 0 and model not in WITH_MIRROR_LIMIT:
                alpha = .01
            power = 2 / alpha ** 2 - 2 if alpha > 0 else 0
            text += sphere(column, row, model, parameters.format(a='%g' % alpha, e='%g' % power, t='%g' % (90 * alpha)))
    for column, (model, parameters) in enumerate(LAST):
        text += sphere(column, len(ROWS), model, parameters)
    scene = study.temporary('materials.pbrt')
    with open(scene, 'w') as file:
        file.write(text)
    subprocess.run([study.PROGRAM, 'render', scene, '-o', study.ROOT / 'doc-files/materials.jpg', '--exposure', '0',
                    '--tonemap', 'none', *options], check=True)


main()
