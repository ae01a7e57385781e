#!/usr/bin/env python3
"""Gain of each mechanism of `photonmap`: renders scenes without each mechanism in turn, in the same processor time.

Each SCENE is rendered by `photonmap` with all mechanisms and without each in turn, with each number of SAMPLES. The
page, doc-files/results/ablation.md by default, has the ratio of noise-free relMSE, without over with the mechanism,
at one pixel and after averaging 8x8, with its standard error from several seeds. Without a SCENE: six of
../shared/reference and eight of ../shared/real/unseen if they exist, and two of scenes/; otherwise eight of scenes/.
Scenes that have pictures beside them, NAME.a.exr and NAME.b.exr, are compared with those; for all other scenes two
long renders are the reference, which are kept. Results are kept in build/ablation, and not measured again.

  scripts/study/ablation.py --seeds 8 --samples 4 scenes/window.pbrt
  scripts/study/ablation.py --only 'boundary correction' --only 'radii chosen by error'
"""
import datetime
import json
import os
import subprocess
import sys

import study

OPTIONS = None  # of the command line
STARTED = ()  # date and commit of what is measured
FIRST_SEED = 1001  # references have others
SAME_TIME = 0.25   # difference of processor times that is made up for as if the error fell as 1/time

MAP, GATHER = [], ['finalgather=4']
# Name, settings with the mechanism, additional settings that switch it off; the integrator is the last one
# named, or photonmap.
MECHANISMS = [
    ('guided emission', MAP, ['guided=false']),
    ('portals for shadow rays', MAP, ['without=shadowopenings']),
    ('learned light selection and portals', MAP, ['without=lightlearning']),
    ('photon splitting', MAP, ['without=splitting']),
    ('radii chosen by error', MAP, ['without=judgedradii']),
    ('merge weights', MAP, ['without=mergeweights']),
    ('boundary correction', MAP, ['edges=false']),
    ('indirect light by rays', MAP, ['finalgather=0']),
    ('rays from glossy lobes', MAP, ['followroughness=0']),
    ('Epanechnikov kernel', MAP, ['kernel=constant']),
    ('path tracing chosen by trial', ['auto'], ['photonmap']),
    ('shared irradiance', GATHER, ['shareirradiance=false']),
]


def defaults():
    six = ('cornell', 'cornell-glass', 'sds', 'ajar', 'hexroom-grey', 'plates')
    unseen = ('corridor', 'bathroom', 'stairs', 'desk', 'hall', 'church', 'kitchen', 'garage')
    there = [study.REFERENCES / ('%s.pbrt' % n) for n in six]
    public = [s for s in (study.PUBLIC / ('unseen/%s.pbrt' % n) for n in unseen) if s.exists()]
    own = ['trellis', 'window']
    if not there[0].exists():
        there, own = [], ['cornell-glass', 'hexroom', 'glass-of-water', 'vase', 'chess', 'lighthouse'] + own
    return there + [study.ROOT / ('scenes/%s.pbrt' % n) for n in own] + public


class Measurement:
    """One scene with one number of samples."""

    def __init__(self, scene, samples, size, target):
        self.scene, self.samples, self.size, self.target = scene, samples, size, target

    def render(self, settings, count, seed):
        """Errors at one pixel and at 8, processor time, and the processor time of learning."""
        integrator = ([s for s in settings if '=' not in s] or ['photonmap'])[-1]
        options = [o for s in settings if '=' in s for o in ('--set', s)]
        stats = study.render(self.scene, study.temporary('x.exr'), *self.size, '--integrator', integrator, '--nthreads',
                             1, '--spp', count, '--seed', seed, *options)
        e = study.compare(study.temporary('x.exr'), *self.target)
        return (e['relmse_noise_free_at_1'], e['relmse_noise_free_at_8'], stats['processor_seconds'],
                stats['processor_seconds_by_part']['learning'])

    def samplesFor(self, wanted, seconds, learning):
        """Number of samples that takes the wanted time, if `self.samples` took `seconds`."""
        if abs(seconds / wanted - 1) < SAME_TIME: return self.samples
        return max(1, round(self.samples * (wanted - learning) / max(seconds - learning, 1e-3)))

    def measure(self, skipped):
        """Ratios of errors at one pixel and at 8 for each mechanism; None where the pictures are the same. Mechanisms
        are rendered in turn, so that other load affects all of them."""
        chosen = [m for m in MECHANISMS if m[0] not in skipped and (not OPTIONS.only or m[0] in OPTIONS.only)]
        bases, counts, others = {}, {}, {name: [] for name, _, _ in chosen}
        for seed in range(FIRST_SEED, FIRST_SEED + OPTIONS.seeds):
            isFirst = seed == FIRST_SEED
            for name, on, off in chosen:
                base = bases.setdefault(tuple(on), [])
                if len(base) <= seed - FIRST_SEED: base.append(self.render(on, self.samples, seed))
                if isFirst:
                    first = self.render(on + off, self.samples, seed)
                    if first[:2] == base[0][:2]: continue
                    counts[name] = self.samplesFor(base[0][2], first[2], first[3])
                    if counts[name] == self.samples:
                        others[name].append(first)
                        continue
                if name in counts: others[name].append(self.render(on + off, counts[name], seed))
        found = {}
        for name, on, _ in chosen:
            other, base = others[name], bases[tuple(on)]
            # Ratio of times that rounding to whole samples leaves; it is applied as if the error decreased
            # as 1/time.
            over = sum(o[2] for o in other) / sum(b[2] for b in base)
            found[name] = [study.ratio([o[k] * over for o in other], [b[k] for b in base])
                           for k in (0, 1)] if other else None
            print('%s, %d samples, %s: %s' % (self.scene, self.samples, name, text(found[name])), file=sys.stderr, flush=True)
        return found


def text(value):
    if value is None: return '='
    return ' / '.join(map(study.ratioText, value))


def title(scene):
    return scene.split('/')[-2] if scene.endswith('/scene.pbrt') else os.path.basename(scene[:-5])


def page(scenes, results):
    """The text of the page; `results` by samples, then by scene."""
    out = '''# The gain of each mechanism of photonmap

Made by `scripts/study/ablation.py` on %s, commit %s; not edited by hand. Each number is the noise-free relMSE without a
mechanism over that with it, in the same processor time: at one pixel / after averaging 8x8 pixels, each with its standard
error from %d seeds. Above 1 the mechanism helps; `=`: it has no effect in this scene, the pictures are the same; `–`: the
error is smaller than the uncertainty of the reference; empty: not measured. Processor time includes the initial learning. The
row of the trial is for `auto`; shared irradiance is measured with `finalgather=4`. `scripts/study/adaptive.py` measures
adaptive samples. `learned light selection and portals` removes both.
''' % (*STARTED, OPTIONS.seeds)
    for samples in OPTIONS.samples:
        shown = [s for s in scenes if results.get(key(s, samples))]
        if not shown: continue
        out += '\n## %d samples of a pixel\n\n| mechanism | %s |\n| --- |%s\n' % (
            samples, ' | '.join(map(title, shown)), ' --- |' * len(shown))
        for name, _, _ in MECHANISMS:
            cells = [text(r[name]) if name in r else '' for r in (results[key(s, samples)] for s in shown)]
            if any(cells): out += '| %s | %s |\n' % (name, ' | '.join(cells))
    return out


def commit():
    return subprocess.run(['git', 'rev-parse', '--short', 'HEAD'], cwd=study.ROOT, capture_output=True,
                          text=True).stdout.strip() or 'unknown'


def numbers(text): return [int(n) for n in text.split(',')]


def key(scene, samples): return '%s | %d | %d' % (scene, OPTIONS.seeds, samples)


def main():
    global OPTIONS, STARTED
    parser = study.parser(__doc__)
    parser.add_argument('scenes', metavar='SCENE', nargs='*')
    parser.add_argument('--seeds', type=int, default=3, help='default: 3')
    parser.add_argument('--samples', type=numbers, default=[4, 64, 256], metavar='N,...', help='of a pixel; default: 4,64,256')
    parser.add_argument('--only', action='append', choices=[m[0] for m in MECHANISMS], metavar='MECHANISM',
                        help='that one; may be repeated')
    parser.add_argument('--minutes', type=float, default=2, help='of each of the two references; default: 2')
    parser.add_argument('--references', default=study.CACHE, metavar='DIR', help='where they are kept; default: %(default)s')
    parser.add_argument('--page', default=study.ROOT / 'doc-files/results/ablation.md', help='the page to write')
    OPTIONS = parser.parse_args()
    study.build()
    STARTED = datetime.date.today(), commit()
    kept = study.ROOT / 'build/ablation'
    kept.mkdir(parents=True, exist_ok=True)
    store = kept / 'results.json'
    results = json.load(open(store)) if store.exists() else {}
    scenes = [os.path.relpath(s, study.ROOT) for s in OPTIONS.scenes or defaults()]
    for samples in OPTIONS.samples:
        for scene in scenes:
            known = results.setdefault(key(scene, samples), {})
            wanted = {m[0] for m in MECHANISMS if not OPTIONS.only or m[0] in OPTIONS.only}
            # A mechanism without effect with few samples has none with many.
            for fewer in OPTIONS.samples:
                for name, value in results.get(key(scene, fewer), {}).items():
                    if value is None: known.setdefault(name, None)
            if wanted <= known.keys(): continue
            path = os.path.join(study.ROOT, scene)
            try:
                target = study.references(path, OPTIONS.references, 192, OPTIONS.minutes)
                known.update(Measurement(path, samples, *target).measure(known.keys()))
            except subprocess.CalledProcessError as e:
                print('%s: not rendered: %s' % (scene, study.firstLine(e)), file=sys.stderr)
                continue
            with open(store, 'w') as file: json.dump(results, file)
    os.makedirs(os.path.dirname(OPTIONS.page), exist_ok=True)
    with open(OPTIONS.page, 'w') as out: out.write(page(scenes, results))
    print(OPTIONS.page)


main()
