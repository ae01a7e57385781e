#!/usr/bin/env python3
"""Builds doc-files/course as students do, and with the solutions, and tests the output of its checks.

  courseTest.py SOURCE_DIR BUILD_DIR PREFIX [CMAKE OPTION...]

PREFIX has the installed library. With gaps, all of them are missing; solved, all are right and the marks of the pictures
are clean. A third program has the solutions with switches, which open gaps and fill them wrongly.
"""
import os
import re
import shutil
import subprocess
import sys
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

SOURCE, BUILD, PREFIX = (Path(argument).resolve() for argument in sys.argv[1:4])
OPTIONS = sys.argv[4:]
COURSE = SOURCE / "doc-files" / "course"
sys.dont_write_bytecode = True
LOADER = SourceFileLoader("handout", str(COURSE / "handout"))
handout = module_from_spec(spec_from_loader("handout", LOADER))
LOADER.exec_module(handout)

EXERCISES = {"path": "pathTracer.cpp", "photons": "photonMapper.cpp"}
GAPS = {"path": 10, "photons": 8}

# Wrong fillings of gaps: (statement, pattern of the hint), and 1 for the second function of a gap.
WRONG = {
    "path": {
        1: [("return lampRadiance;", "nothing behind"),
            ("return lampRadiance * std::max(0.0f, cosLamp);", "does not depend on the cosine"),
            ("return cosLamp > 0 ? lampRadiance : lampRadiance * 0.5f;", r"\(1, 1.5, 2.5\) instead of \(0, 0, 0\)")],
        2: [("return albedo;", "factor of pi is missing"),
            ("return albedo / (2 * PI);", "is pi, not 2 pi"),
            ("return albedo * (2 / PI);", "2 times too large"),
            ("return albedo * 0.31841f;", "a value is .* instead of")],
        3: [("{ const float s = std::sqrt(1 - u.x * u.x), a = 2 * PI * u.y;"
             " return {Vec3f(s * std::cos(a), s * std::sin(a), u.x), INV_PI / 2}; }", "uniform over the hemisphere"),
            ("{ const float s = std::sqrt(u.x), a = 2 * PI * u.y, z = std::sqrt(1 - u.x);"
             " return {Vec3f(s * std::cos(a), s * std::sin(a), z), z}; }", "to 3.142"),
            ("{ const float s = std::sqrt(u.x), a = PI * u.y, z = std::sqrt(1 - u.x);"
             " return {Vec3f(s * std::cos(a), s * std::sin(a), z), z * INV_PI}; }", "not uniform around"),
            ("{ const float s = u.x, a = 2 * PI * u.y, z = std::sqrt(1 - u.x);"
             " return {Vec3f(s * std::cos(a), s * std::sin(a), z), z * INV_PI}; }", "length"),
            ("{ const float s = std::sqrt(u.x), a = 2 * PI * u.y, z = std::sqrt(1 - u.x);"
             " return {Vec3f(s * std::cos(a), s * std::sin(a), z), INV_PI / 2}; }", "always 0.159"),
            ("{ const float s = std::sqrt(u.x), a = 2 * PI * u.y, z = std::sqrt(1 - u.x);"
             " return {Vec3f(s * std::cos(a), s * std::sin(a), z), z * s * INV_PI}; }", "over solid angle has none")],
        4: [("return bsdf / pdf;", "cosine is missing"),
            ("return bsdf * cosine;", "division by the density is missing"),
            ("return bsdf * cosine * pdf;", "divisor, not a factor"),
            ("return bsdf * PI;", "cosine-weighted directions only"),
            ("return bsdf * (cosine / pdf * INV_PI);", "a second time")],
        5: [("return bsdf * lampRadiance * (c.cosLamp / (c.distance2 * pdfArea));", "cosine at the surface is missing"),
            ("return bsdf * lampRadiance * (c.cosSurface / (c.distance2 * pdfArea));", "cosine at the lamp is missing"),
            ("return bsdf * lampRadiance * (1 / (c.distance2 * pdfArea));", "both cosines"),
            ("return bsdf * lampRadiance * (c.cosSurface * c.cosLamp / pdfArea);", "squared distance is missing"),
            ("return bsdf * lampRadiance * (c.cosSurface * c.cosLamp / (c.distance2 * c.distance2 * pdfArea));",
             "squared twice"),
            ("return bsdf * lampRadiance * (c.cosSurface * c.cosLamp / c.distance2);", "division by the density"),
            ("return bsdf * lampRadiance * (c.cosSurface * c.cosLamp / (PI * c.distance2 * pdfArea));",
             "a second time.*disc: 0.318 times"),
            ("return bsdf * lampRadiance * (2 * c.cosSurface * c.cosLamp / (c.distance2 * pdfArea));",
             "2 times too large.*disc: 2 times")],
        6: [("return u < maxComponent(throughput);", "must be divided"),
            ("return true;", "no path ever ends"),
            ("{ const float p = luminance(throughput); if (u >= p) return false; throughput /= p; return true; }",
             "limit the probability to 1"),
            ("{ if (u >= 0.5f) return false; throughput *= 2.0f * 2.0f; return true; }", "mean over all u")],
        7: [("return wo;", "goes back"), ("return -wo;", "into the mirror"), ("return {wo.x, -wo.y, wo.z};", "0.6, 0, 0.8")],
        8: [("eta = 1 / eta;", "upside down"),
            ("{ const float c = std::sqrt(1 - (1 - wo.z * wo.z) / (eta * eta)); const float f = 0.04f;"
             " return Refraction{Vec3f(-wo.x / eta, -wo.y / eta, -c), f}; }", "square root of a negative"),
            ("{ const float s2 = (1 - wo.z * wo.z) / (eta * eta); if (s2 >= 1) return {};"
             " return Refraction{Vec3f(-wo.x / eta, -wo.y / eta, std::sqrt(1 - s2)), 0.04f}; }", "behind the surface"),
            ("{ const float s2 = (1 - wo.z * wo.z) / (eta * eta); if (s2 >= 1) return {}; const float c = std::sqrt(1 - s2);"
             " return Refraction{Vec3f(-wo.x / eta, -wo.y / eta, -c), 0.04f + 0.96f * std::pow(1 - wo.z, 5.0f)}; }", "Schlick"),
            ("{ const float s2 = (1 - wo.z * wo.z) / (eta * eta); if (s2 >= 1) return {}; const float c = std::sqrt(1 - s2);"
             " const float p = (eta * wo.z - c) / (eta * wo.z + c);"
             " return Refraction{Vec3f(-wo.x / eta, -wo.y / eta, -c), p * p}; }", "one polarisation")],
        9: [("return pdfArea * cosLamp / distance2;", "other way round"),
            ("return pdfArea * distance2;", "cosine at the lamp is missing"),
            ("return 0;", "other half of the gap is open: pdfSolidAngle"),
            ("return 1;", "other half of the gap is open: misWeight", 1),
            ("return pdf;", "add up to 1", 1),
            ("return 0.5f;", "weights of 1/2", 1),
            ("return otherPdf / (pdf + otherPdf);", "larger weight", 1)],
        10: [("return 1;", "LDE is counted twice"), ("return misWeight(pdfLamp, pdfRay);", "exchanged")],
    },
    "photons": {
        1: [("return lampRadiance * (1 / (pdfArea * pdfDirection * float(photons)));", "cosine at the lamp"),
            ("return lampRadiance * (cosine / (pdfArea * pdfDirection));", "divide by their number"),
            ("return lampRadiance * (cosine / (pdfArea * float(photons)));", "density of the direction"),
            ("return lampRadiance * (1 / float(photons));", "radiance is no power"),
            ("return lampRadiance * (PI / (pdfArea * float(photons)));", "cosine-weighted directions only"),
            ("return lampRadiance * (cosine * INV_PI / (pdfArea * pdfDirection * float(photons)));",
             "pi times too small.*0.318 times the power")],
        2: [("return {true, history.specular > 0 && history.diffuse == 0};", "at mirrors or glass"),
            ("{ const bool is = kind == Surface::Kind::DIFFUSE; return {is, is && history.diffuse == 0}; }",
             "LDE, which is counted twice"),
            ("{ const bool is = kind == Surface::Kind::DIFFUSE; return {is, is && history.specular > 0}; }",
             "scattered diffusely before"),
            ("{ const bool is = kind == Surface::Kind::DIFFUSE; return {is && history.diffuse + history.specular > 0,"
             " is && history.specular > 0 && history.diffuse == 0}; }", "needs them for LDDE"),
            ("{ const bool is = kind == Surface::Kind::DIFFUSE, caustic = history.specular > 0 && history.diffuse == 0;"
             " return {is && !caustic, is && caustic}; }", "global map lacks photons: .*caustics"),
            ("{ const bool is = kind == Surface::Kind::DIFFUSE; return {is, false}; }", "caustic map lacks")],
        3: [("{ power *= reflectance; return u < maxComponent(reflectance); }", "lost twice"),
            ("{ power *= reflectance; return true; }", "no path ever ends"),
            ("return u < maxComponent(reflectance);", "mean over all u")],
        4: [("return planeDistance < radius2;", "visit parts of the tree|miss photons"),
            ("return true;", "too far away"),
            ("return 4 * planeDistance * planeDistance < radius2;", "miss photons")],
        5: [("{ Rgb flux(0); for (const NearPhoton& p : photons) flux += p.power; return bsdf * flux / radius2; }", "pi is missing"),
            ("{ Rgb flux(0); for (const NearPhoton& p : photons) flux += p.power; return flux / (PI * radius2); }", "BSDF is missing"),
            ("{ Rgb flux(0); for (const NearPhoton& p : photons) flux += p.power; return bsdf * flux / (4 * PI * radius2); }",
             "surface of the sphere")],
        6: [("return (1 - std::sqrt(distance2 / radius2)) / (PI * radius2);", "3 times too small.*0.3333"),
            ("return 1 / (PI * radius2);", "constant kernel"),
            ("return 2 * (1 - distance2 / radius2) / (PI * radius2);", "parabola")],
        7: [("return bsdf * radiance / pdf;", "cosine is missing"), ("return bsdf * radiance * cosine;", "division by the density")],
        8: [("{ const Vec3f d = cosineHemisphere(sampler.next2D()); const Seen s = seeThrough(scene, rayFrom(surface, d), sampler, counts);"
             " return s.surface ? surface.colour * (s.emitted + s.weight * estimate(*s.surface)) : BLACK; }", "a lamp emits is added"),
            ("{ const Vec3f d = uniformCone(sampler.next2D(), 1); const Seen s = seeThrough(scene, rayFrom(surface, d), sampler, counts);"
             " return s.surface ? surface.colour * s.weight * estimate(*s.surface) : BLACK; }", "directions are uniform"),
            ("{ const Vec3f d = cosineHemisphere(sampler.next2D()); const auto s = traceRay(scene, rayFrom(surface, d), counts);"
             " return s ? surface.colour * estimate(*s) : BLACK; }", "radiance of a mirror"),
            ("{ const Vec3f d = cosineHemisphere(sampler.next2D()); const Seen s = seeThrough(scene, rayFrom(surface, d), sampler, counts);"
             " return s.surface ? surface.colour * estimate(*s.surface) : BLACK; }", "Seen::weight"),
            ("{ const Vec3f d = cosineHemisphere(sampler.next2D()); const Seen s = seeThrough(scene, rayFrom(surface, d), sampler, counts);"
             " return s.surface ? surface.colour * (1 / PI) * s.weight * estimate(*s.surface) : BLACK; }", "pi times too small")],
    },
}
# Right fillings that differ from the solutions.
RIGHT = {
    ("path", 3): ["{ const Vec2f d = uniformDisk(u); const float z = std::sqrt(1 - d.x * d.x - d.y * d.y);"
                  " return {Vec3f(d.x, d.y, z), z * INV_PI}; }"],
    ("path", 6): ["{ if (u >= 0.5f) return false; throughput *= 2.0f; return true; }",
                  "{ const float p = std::min(1.0f, luminance(throughput)); if (u > p) return false;"
                  " throughput /= p; return true; }",
                  "{ const float p = std::min(0.95f, (throughput.r + throughput.g + throughput.b) / 3);"
                  " if (u > p) return false; throughput /= p; return true; }"],
    ("path", 9): ["return pdfArea / (cosLamp / distance2);"],
    ("path", 10): ["return pdfRay == 0 ? 0 : misWeight(pdfRay, pdfLamp);"],
    ("photons", 3): ["{ const float p = (reflectance.r + reflectance.g + reflectance.b) / 3; if (u > p) return false;"
                     " power *= reflectance / p; return true; }"],
    ("photons", 4): ["return std::abs(planeDistance) < std::sqrt(radius2);"],
    ("photons", 8): ["{ const Vec3f d = uniformCone(sampler.next2D(), 1);"
                     " const Seen s = seeThrough(scene, rayFrom(surface, d), sampler, counts);"
                     " return s.surface ? surface.colour * (2 * d.z) * s.weight * estimate(*s.surface) : BLACK; }"],
}

# Gaps whose check needs a second gap.
DEPENDENT = {("path", 9): {10: "waits its weights are those of gap 9, which is open"}}


# Numbers of the openings: (exercise, gap, None) is the open gap, (exercise, gap, i) a wrong filling,
# (exercise, gap, "right0") a right one.
NUMBERS = {key: number for number, key in enumerate(
    (exercise, gap, i) for exercise, gaps in WRONG.items() for gap, fillings in gaps.items()
    for i in [None, *range(len(fillings)), *(f"right{i}" for i in range(len(RIGHT.get((exercise, gap), []))))])}


def switched(exercise, text):
    """Solved file with switches that open each gap, or fill it wrongly."""
    filled = []

    def fill(gap, indent, solution, statement):
        out = f"{indent}if (openings[{NUMBERS[exercise, gap, None]}]) {statement}\n"
        for i, (wrong, _, *place) in enumerate(WRONG[exercise][gap]):
            if filled.count(gap) == (place[0] if place else 0):
                out += f"{indent}if (openings[{NUMBERS[exercise, gap, i]}]) {wrong}\n"
        if gap not in filled:
            for i, right in enumerate(RIGHT.get((exercise, gap), [])):
                out += f"{indent}if (openings[{NUMBERS[exercise, gap, f'right{i}']}]) {right}\n"
        filled.append(gap)
        return out + solution

    return '#include <cmath>\n#include <recurse/core/sampling/sampling.h>\n#include "openings.h"\n' + handout.with_gaps(text, fill)


def run(*command):
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return result.returncode, result.stdout


def build():
    shutil.rmtree(BUILD / "handout", ignore_errors=True)
    BUILD.mkdir(parents=True, exist_ok=True)
    for stills in (BUILD / "course").glob("stills*.exr"):
        stills.unlink()
    # A copy of the course in which the teacher has built the solutions.
    shutil.rmtree(BUILD / "copy", ignore_errors=True)
    shutil.copytree(COURSE, BUILD / "copy", ignore=shutil.ignore_patterns("build*"))
    (BUILD / "copy/build").mkdir()
    (BUILD / "copy/build/course").write_text("the solved program")
    steps = [[BUILD / "copy/handout", BUILD / "handout"]]
    for variant in ("solved", "switched"):
        (BUILD / variant).mkdir(exist_ok=True)
    for exercise, name in EXERCISES.items():
        text = (COURSE / "solutions" / name).read_text()
        (BUILD / "solved" / name).write_text(text)
        (BUILD / "switched" / name).write_text(switched(exercise, text))
    steps.append(["cmake", "-S", SOURCE / "tests" / "course", "-B", BUILD, f"-DCOURSE={BUILD / 'handout'}",
                  f"-DCMAKE_PREFIX_PATH={PREFIX}", *OPTIONS])
    steps.append(["cmake", "--build", BUILD])
    for step in steps:
        status, output = run(*step)
        if status != 0:
            sys.exit(f"{output}\n{step[0]} failed")


def verdicts(output):
    """The verdict on each gap, with its hint in one line."""
    found = re.findall(r"^ *(\d+)  .{30}(\w+)\n((?:    .*\n)*)", output, re.M)
    return {int(gap): " ".join([state, *hint.split()]) for gap, state, hint in found}


def answers(commands):
    """Output of the program with switches: commands are (command, exercise, openings)."""
    commands = list(commands)
    lines = [" ".join([command, exercise, *(str(NUMBERS[opening]) for opening in openings)])
             for command, exercise, openings in commands]
    result = subprocess.run([BUILD / "bin/switched"], input="\n".join(lines) + "\n", stdout=subprocess.PIPE, text=True)
    assert result.returncode == 0, result.stdout
    out = result.stdout.split("-----\n")[:-1]
    assert len(out) == len(commands), result.stdout
    return out


class CourseTest(unittest.TestCase):
    def test_solutions_are_not_installed(self):
        installed = [path.name for path in PREFIX.glob("share/doc/*/doc-files/course/*")]
        self.assertIn("pathTracer.cpp", installed)
        self.assertNotIn("solutions", installed)
        self.assertNotIn("handout", installed)

    def test_exercises_are_what_the_solutions_make(self):
        status, output = run(COURSE / "handout", "--check")
        self.assertEqual(status, 0, output)

    def test_handout_has_no_solutions(self):
        names = {str(path.relative_to(BUILD / "handout")) for path in (BUILD / "handout").rglob("*")}
        self.assertEqual({name.split("/")[0] for name in names}, {
            "CMakeLists.txt", "README.md", "main.cpp", "missing.jpg", "checks", "frame", "scenes", *EXERCISES.values()})
        self.assertIn("pathTracer.cpp", names)
        self.assertFalse([name for name in names if "solution" in name or "handout" in name], names)
        page = (BUILD / "handout" / "README.md").read_text()
        self.assertNotIn("teachers", page)
        for link in re.findall(r"\]\(([^)]*)\)", page):
            self.assertIn(link, names)
        for name in EXERCISES.values():
            text = (BUILD / "handout" / name).read_text()
            self.assertNotIn("solution", text)
            self.assertNotIn("handout", text)
            for _, solution, _ in handout.blocks((COURSE / "solutions" / name).read_text()):
                self.assertNotIn(solution, text)

    def test_all_gaps_are_missing_at_first(self):
        for exercise, count in GAPS.items():
            status, output = run(BUILD / "course/course", "check", exercise)
            self.assertEqual(status, 1, output)
            self.assertEqual(verdicts(output), {gap: "missing" for gap in range(1, count + 1)})
            self.assertRegex(output, r"direct +\d.*missing")

    def test_all_gaps_and_the_marks_are_right_with_the_solutions(self):
        for exercise, count in GAPS.items():
            status, output = run(BUILD / "bin/solved", "check", exercise)
            self.assertEqual(verdicts(output), {gap: "right" for gap in range(1, count + 1)})
            self.assertEqual(status, 0, output)
            states = re.findall(r"^[\w-]+ +[\d.]+ %    (\w+)", output, re.M)
            self.assertEqual(states, ["right"] * 8, output)

    def test_each_open_gap_is_found(self):
        openings = [key for key in NUMBERS if key[2] is None]
        for key, output in zip(openings, answers(("check", key[0], [key]) for key in openings)):
            exercise, gap, _ = key
            expected = {other: "right" for other in range(1, GAPS[exercise] + 1)}
            self.assertEqual(verdicts(output), expected | {gap: "missing"} | DEPENDENT.get((exercise, gap), {}), key)

    def test_wrong_fillings_get_a_hint(self):
        openings = [key for key in NUMBERS if isinstance(key[2], int)]
        for key, output in zip(openings, answers(("check", key[0], [key]) for key in openings)):
            exercise, gap, i = key
            statement, hint = WRONG[exercise][gap][i][:2]
            found = verdicts(output)
            self.assertRegex(found[gap], f"^wrong .*({hint})", f"{key}: {statement}")
            others = {other: verdict for other, verdict in found.items() if verdict != "right" and other != gap}
            self.assertIn(others, [{}, DEPENDENT.get((exercise, gap))], key)

    def test_other_right_fillings_are_right(self):
        openings = [key for key in NUMBERS if isinstance(key[2], str)]
        for key, output in zip(openings, answers(("check", key[0], [key]) for key in openings)):
            self.assertEqual(set(verdicts(output).values()), {"right"}, f"{key}: {output}")

    def test_lamps_are_sampled_by_their_density(self):
        area, density = map(float, answers([("lamps", "path", [])])[0].split())
        self.assertLess(abs(area), 0.003)
        self.assertLess(density, 1e-4)

    def test_scenes_of_other_kinds_are_refused(self):
        lamp = 'AttributeBegin AreaLightSource "diffuse" Shape "disk" AttributeEnd '
        worlds = {"diffuse surfaces": lamp + 'Material "conductor" "float roughness" .3 Shape "sphere"',
                  "diffuse surfaces, ": lamp + 'Material "diffuse" Shape "sphere" Material "orennayar" Shape "disk"',
                  "lamps on surfaces only": 'LightSource "point"',
                  "one side only": 'AreaLightSource "diffuse" "bool twosided" true Shape "disk"',
                  "": lamp}
        for exercise in GAPS:
            for message, world in worlds.items():
                scene, picture = BUILD / "scene.pbrt", BUILD / "picture.exr"
                scene.write_text('Film "rgb" "integer xresolution" 8 "integer yresolution" 8 LookAt 0 0 3  0 0 0  0 1 0 '
                                 'Camera "perspective" WorldBegin ' + world)
                picture.unlink(missing_ok=True)
                status, output = run(BUILD / "bin/solved", "render", exercise, scene, picture, "1")
                self.assertEqual((status, picture.exists()), (1, False) if message else (0, True), output)
                self.assertIn(message, output)

    def test_marks_use_the_files_of_a_student_but_the_own_headers(self):
        student, marks = BUILD / "student", BUILD / "marks"
        for folder in (student, marks):
            shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(BUILD / "handout", student)
        for name in ("pathTracer.h", "photonMapper.h", "course.h"):
            (student / "frame" / name).write_text("#error a header of the student\n")
        for step in (["cmake", "-S", BUILD / "handout", "-B", marks, f"-DEXERCISES={student}", f"-DCMAKE_PREFIX_PATH={PREFIX}",
                      *OPTIONS], ["cmake", "--build", marks]):
            status, output = run(*step)
            self.assertEqual(status, 0, output)
        check = (marks / "course", "check", "path", "--no-picture")
        self.assertEqual(set(verdicts(run(*check)[1]).values()), {"missing"})
        shutil.copy(BUILD / "solved/pathTracer.cpp", student)
        os.utime(student / "pathTracer.cpp")
        status, output = run("cmake", "--build", marks)
        self.assertEqual(status, 0, output)
        status, output = run(*check)
        self.assertEqual((status, set(verdicts(output).values())), (0, {"right"}), output)

    def test_wrong_commands_have_the_status_2(self):
        for command in ([], ["check"], ["check", "paths"], ["check", "path", "--picture"], ["render", "path", "a.pbrt"],
                        ["render", "path", "a.pbrt", "a.exr", "0"]):
            self.assertEqual(run(BUILD / "course/course", *command)[0], 2, command)

    def test_page_shows_what_is_printed(self):
        def without_numbers(text):
            return re.sub(r"[\d.]+", "#", text)

        wrong = [("photons", 2, 1)]
        output = "".join(answers([("check", "photons", wrong), ("mark", "photons", wrong)]))
        shown = re.search(r"check again:\n\n```\n(.*?)```", (COURSE / "README.md").read_text(), re.S)[1]
        for part in shown.split("...\n"):
            self.assertIn(without_numbers(part), without_numbers(output))

    def test_page_has_all_gaps(self):
        page = (COURSE / "README.md").read_text()
        for exercise, name in EXERCISES.items():
            section = page[page.index("## Path tracer" if exercise == "path" else "## Photon mapper"):]
            source = (COURSE / name).read_text()
            for gap in range(1, GAPS[exercise] + 1):
                row = re.search(rf"^\| {gap} ((?:`\w+`(?:, )?)+) \|", section, re.M)
                for function in re.findall(r"`(\w+)`", row[1]):
                    self.assertRegex(source, rf"(?s){function}\([^{{}}]*\) {{\n((?!\n}}\n).)*// gap {gap} is open")

    def test_pictures_show_mistakes(self):
        cases = [("path", [("path", 9, None), ("path", 10, 0)], r"direct .*doubled +2"),  # emission counted twice
                 ("path", [("path", 2, 0)], r"reflect\s+more\s+light\s+than\s+they\s+receive"),  # without 1 / pi
                 ("path", [("path", 5, 0)], r"direct .*scaled +1\.[2-6]"),                    # without a cosine
                 ("path", [("path", 7, None)], r"mirrored-emission .*missing"),
                 ("photons", [("photons", 2, 1)], r"direct .*doubled +(2|1\.9)"),        # direct light in the caustic map
                 ("photons", [("photons", 8, None)], r"indirect-1 .*missing")]
        outputs = answers(("mark", exercise, openings) for exercise, openings, _ in cases)
        for (_, openings, expected), output in zip(cases, outputs):
            self.assertRegex(output, expected, openings)


build()
unittest.main(argv=sys.argv[:1])
