"""Shared functions of the studies: building the program, rendering, comparing, references that are made once and
kept."""
import argparse
import datetime
import json
import math
import os
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / 'build/release/recurse'
REFERENCES = ROOT.parent / 'shared/reference'   # scenes with pictures by other renderers, where they are there
PUBLIC = ROOT.parent / 'shared/real'            # public scenes, where they are there
CACHE = pathlib.Path(os.environ.get('XDG_CACHE_HOME', pathlib.Path.home() / '.cache')) / 'recurse-study'
WORK = tempfile.TemporaryDirectory(prefix='recurse-study-')
BUILDS = True


class UseProgram(argparse.Action):
    """--program FILE: measures that one, and builds none."""

    def __call__(self, parser, namespace, value, option_string=None):
        global PROGRAM, BUILDS
        PROGRAM, BUILDS = pathlib.Path(value).resolve(), False


def parser(text):
    """Command line of a study, which is explained by its docstring."""
    made = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument('--program', metavar='FILE', action=UseProgram, help='measure this one; default: build it')
    return made


def build(*packages):
    """Installs missing packages, including the Debian packages named, and builds the program, unless one is given."""
    if not BUILDS:
        return
    subprocess.run(['bash', '-c', 'source scripts/lib.sh; requirePackages "${BUILD_PACKAGES[@]}" "$@"; configure release; '
                    'build release recurse', 'study', *packages], cwd=ROOT, check=True)


def recurse(*arguments, timeout=None):
    """Standard output of the program; subprocess.TimeoutExpired after `timeout` seconds."""
    return subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True,
                          timeout=timeout).stdout


def temporary(name):
    """Path of a file that is gone when the study ends."""
    return os.path.join(WORK.name, name)


def render(scene, out, *options, command='render', timeout=None):
    """Renders, or with the command `stills` into a folder, and returns the numbers of --stats."""
    stats = temporary('stats.json')
    recurse(command, scene, '-q', '--lenient', '-o', out, '--stats', stats, *options, timeout=timeout)
    with open(stats) as file:
        return json.load(file)


def compare(picture, *references):
    """The numbers of `recurse compare --json`."""
    return json.loads(recurse('compare', picture, *references, '--json'))


def sizeOfWidth(scene, width):
    """A resolution of this width in the picture's proportions, as --resolution takes it."""
    report = recurse('render', scene, '--check', '--lenient')
    x, y = map(int, re.search(r'(\d+)x(\d+) pixels', report).groups())
    return '%dx%d' % (width, max(1, round(width * y / x)))


def referencePair(scene, folder, size, minutes, method='path', command='render'):
    """Two long renders with independent noise; kept in `folder` and not made again. Stills are folders."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    stem = re.sub(r'\W+', '-', '%s-%s-%s' % (os.path.abspath(scene)[:-len('.pbrt')], size, method)).strip('-')
    suffix = '' if command == 'stills' else '.exr'
    pair = [folder / ('%s.%s.%d%s' % (stem, command, i, suffix)) for i in (1, 2)]
    for i, out in enumerate(pair):
        if not out.exists():
            render(scene, out, '--resolution', size, '--integrator', method, '--time-limit', '%gm' % minutes,
                   '--seed', 11 + i, command=command)
    return pair


def references(scene, folder, width, minutes, method='path'):
    """Options of a render for the size of the references, and what compare() takes: NAME.a.exr and NAME.b.exr beside
    the scene, or two renders that are kept in `folder`."""
    stem = str(scene)[:-len('.pbrt')]
    if not os.path.exists(stem + '.a.exr'):
        size = sizeOfWidth(scene, width)
        return ['--resolution', size], referencePair(scene, folder, size, minutes, method)
    pair = [stem + '.a.exr', stem + '.b.exr']
    size = ['--resolution', pictureSize(pair[0])]
    return size, [stem + '.exr', '--noise-free', *pair] if os.path.exists(stem + '.exr') else pair


def pictureSize(picture):
    """Size of the picture in the format of --resolution."""
    return re.search(r'(\d+)\s*x\s*(\d+)', recurse('info', picture)).group(0).replace(' ', '')


def ratio(others, bases):
    """Ratio of means, with its standard error from the spread over seeds; None if it is undefined."""
    def mean(x): return sum(x) / len(x)

    def relative(x):
        return math.sqrt(sum((v - mean(x)) ** 2 for v in x) / (len(x) - 1) / len(x)) / mean(x) if len(x) > 1 else math.nan
    if not others or not bases or mean(bases) <= 0 or mean(others) <= 0:
        return None
    r = mean(others) / mean(bases)
    return r, r * math.hypot(relative(others), relative(bases))


def ratioText(value):
    """Text of a result of ratio()."""
    if value is None:
        return '–'
    return '%.2f' % value[0] if math.isnan(value[1]) else '%.2f ± %.2f' % tuple(value)


def independentReferences(name):
    """Arguments of compare() for a scene of REFERENCES."""
    stem = str(REFERENCES / name)
    return [stem + '.exr', '--noise-free', stem + '.a.exr', stem + '.b.exr']


def firstLine(error):
    """First line of the messages of a failed run."""
    return error.stderr.strip().split('\n')[0]


def provenance():
    """Date and commit of a page, as '2026-11-24, commit 451bb23'."""
    commit = subprocess.run(['git', 'rev-parse', '--short', 'HEAD'], cwd=ROOT, capture_output=True, text=True)
    return '%s, commit %s' % (datetime.date.today(), commit.stdout.strip() or 'unknown')


def loadAverage():
    """Load average of the last minute."""
    return os.getloadavg()[0]


def processorName():
    """The processor's name, as Linux has it."""
    with open('/proc/cpuinfo') as file:
        found = re.search(r'^model name[^:]*: *(.*)$', file.read(), re.M)
    return found.group(1) if found else 'an unknown processor'
