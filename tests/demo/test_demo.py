"""Tests of the demo.

    test_demo.py --programs DIR      where kq_demo_f32, kq_estimate_f32 and so on are
                                     (or the environment variable KQ_DEMO_PROGRAMS)
"""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
DEMO = ROOT / "tools" / "demo"
sys.path[:0] = [str(DEMO), str(ROOT / "tools")]

import built_in
import csv_input
import jobs
import own_data
import reference
import report
import runner
from estimates import REFERENCE, Course
from jobs import Job
from own_data import Given
from runner import ARITHMETICS, ESTIMATING
from shared.errors import FileError
from shared.outputs import Outputs

NILE = ROOT / "tools" / "data" / "nile.csv"
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"

LEVEL, VELOCITY = "local-level", "constant-velocity"

# name, content (None: no such file), model, what the one line must say
BAD_FILES = [
    ("missing", None, LEVEL, ["no such file"]),
    ("empty", b"", LEVEL, ["row 1:", "empty"]),
    ("blank", b"\n\n", LEVEL, ["row 1:", "empty"]),
    ("comments", b"# nothing\n", LEVEL, ["row 1:", "empty"]),
    ("header_only", b"year,flow\n", LEVEL, ["row 1:", "no data"]),
    ("ragged_short", b"1,2\n2,3\n3\n", LEVEL, ["row 3:", "1 field, not 2"]),
    ("ragged_long", b"x,y\n1,2\n2,3,4\n", VELOCITY, ["row 3:", "3 fields, not 2"]),
    ("ragged_header", b"year,flow\n1\n2\n", LEVEL, ["row 2:", "1 field, not 2"]),
    ("ragged_comment", b"# a\n1,2\n# b\n2\n", LEVEL, ["row 4:", "1 field, not 2"]),
    ("word", b"1,10\n2,ten\n3,12\n", LEVEL, ["row 2, column 2:", "'ten' is not a number"]),
    ("underscore", b"1\n2_0\n3\n", LEVEL, ["row 2, column 1:", "'2_0' is not a number"]),
    ("two separators", b"1,2\n3;4,5\n", LEVEL, ["row 2, column 1:", "one separator"]),
    ("decimal commas", b"time;level\n1;2,5\n", LEVEL, ["row 2, column 2:", "decimal points"]),
    ("infinite", b"1\n2\ninf\n", LEVEL, ["row 3, column 1:", "beyond"]),
    ("huge", b"1\n2\n1e999\n", LEVEL, ["row 3, column 1:", "beyond"]),
    ("blank_line", b"1\n2\n\n4\n", LEVEL, ["row 3:", "blank line"]),
    ("too_wide", b"1,2,3\n4,5,6\n", LEVEL, ["row 1:", "3 columns"]),
    ("four_axes", b"1,2,3,4\n", VELOCITY, ["row 1:", "4 columns"]),
    ("no_values", b"1,\n2,nan\n", LEVEL, ["row 2, column 2:", "no measurement"]),
    ("no_axis", b"1,\n2,\n3,\n4,\n", VELOCITY, ["row 4, column 2:", "no measurement"]),
    ("time_gap", b"2000,1\n2001,2\n2003,3\n", LEVEL, ["row 3, column 1:", "time step 2"]),
    ("time_back", b"time,x\n1,1\n0,2\n", VELOCITY, ["row 3, column 1:", "does not increase"]),
    ("time_missing", b"2000,1\n,2\n", LEVEL, ["row 2, column 1:", "time is missing"]),
    ("too_few", b"1\n2\n3\n", LEVEL, ["row 3:", "too few"]),
    ("too_few_axes", b"1,1\n2,2\n3,3\n", VELOCITY, ["row 3:", "too few"]),
    ("too_small", b"1e-20\n2e-20\n0\n3e-20\n1e-20\n2e-20\n", LEVEL, ["row 6:", "range"]),
    ("binary", b"\x89PNG\xff\xfe\x00", LEVEL, ["row 1:", "not text"]),
    ("zero_byte", b"1\n2\x003\n", LEVEL, ["row 2"]),
    ("line\nbreak", b"", LEVEL, ["row 1:", "empty"]),
]

MODEL = "A 1 Q 1 H 1 R 1 x0 0 P0 1 x_range 9 z_range 9"
BAD_PROBLEMS = [
    ("", "line 1: the input ends where sizes"),
    ("sizes 0 1 1 0", "line 1: n is '0'"),
    ("sizes 17 1 1 0", "line 1: n is '17'"),
    ("sizes 1 1 x 0", "line 1: steps is 'x'"),
    ("sizes 1 1 1 0\nA one", "line 2: 'one' in A is not a number"),
    ("sizes 1 1 1 0\nA nan", "line 2: 'nan' in A is not a number"),
    ("sizes 1 1 1 0\nA 1e999", "line 2: '1e999' in A is out of range"),
    ("sizes 1 1 1 0\nA 1\nB 1", "line 3: 'B' where Q should be"),
    ("sizes 1 1 1 0\nA 1 Q 1 H 1 R 1 x0 0 P0 1\nz 1 end", "line 3: 'z' where x_range should be"),
    (f"sizes 1 1 2 0\n{MODEL}\nz 1 end", "line 3: 'end' in z"),
    (f"sizes 1 1 1 0\n{MODEL}\nz 1 2", "line 3: '2' where end should be"),
    ("# " + "long " * 50 + "\n" + "x" * 100, "line 2: a word of more than 63 characters"),
]

# a model that the library refuses, and what of it the line names in floating and in fixed point
REFUSED = [
    ("A 1 Q -1 H 1 R 1 x0 0 P0 1", "A, Q: ", "Q: "),
    ("A 1 Q 1 H 1 R -1 x0 0 P0 1", "H, R: ", "R: "),
    ("A 1 Q 1 H 1 R 1 x0 0 P0 -1", "x0, P0: ", "P0: "),
]

# what floating point does not mind, and what the line says
ONE = "sizes 1 1 1 0\nA 1 Q 1 H 1 R 1"
TWO = "sizes 2 1 1 0\nA 1 1 0 1 Q 1 0 0 1 H 1 0 R 1"
MISFITS = [
    (f"{TWO} x0 0 0 P0 1 0 0 1 x_range 1 1e9 z_range 1 z 0 end", "A, Q: state 0 needs 26 more"),
    (f"{TWO} x0 0 9 P0 1 0 0 1 x_range 1 1 z_range 1 z 0 end", "x0: state 1 needs "),
    (f"{ONE} x0 0 P0 1 x_range 1e6 z_range 1 z 0 end", "H, R: measurement 0 needs 15 more"),
    (
        f"{ONE} x0 0 P0 1 x_range 1 z_range 1 z 9 end",
        "z of step 0 is 9, its range 1: measurement 0 needs ",
    ),
    (f"{ONE} x0 0 P0 1 x_range 0 z_range 1 z 0 end", "x_range 0, 0: "),
    (f"{ONE} x0 0 P0 1 x_range 1 z_range 1e99 z 0 end", "z_range 0, 1e+99: "),
]


def programs() -> Path:
    found = os.environ.get("KQ_DEMO_PROGRAMS")
    return Path(found) if found else ROOT / "build" / "demo-build" / "tools" / "demo"


def csv_rows(z: np.ndarray) -> str:
    return "\n".join(",".join(f"{value:.3f}" for value in row) for row in z)


def run_demo(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-B", str(DEMO / "demo.py"), "--programs", str(programs())]
    command += [str(argument) for argument in arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd)


def read_csv(path: Path) -> list[dict[str, str]]:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class InDirectory(unittest.TestCase):
    """A test with a directory of its own."""

    def setUp(self) -> None:
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.directory = Path(holder.name)
        self.out = self.directory / "out"

    def file(self, name: str, content: str) -> Path:
        path = self.directory / name
        path.write_text(content, encoding="utf-8")
        return path

    def assert_refused(self, done: subprocess.CompletedProcess[str], *says: str) -> None:
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stdout, "")
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        for part in says:
            self.assertIn(part, done.stderr)
        self.assertFalse(self.out.exists(), "an output directory was made")


class BadInput(InDirectory):
    def test_bad_files(self) -> None:
        for name, content, model, says in BAD_FILES:
            with self.subTest(name):
                path = self.directory / f"{name}.csv"
                if content is not None:
                    path.write_bytes(content)
                done = run_demo(path, "--model", model, "--out", self.out)
                self.assert_refused(done, f"{name}.csv".replace("\n", "?"), *says)

    def test_a_directory_is_no_csv(self) -> None:
        done = run_demo(self.directory, "--model", LEVEL, "--out", self.out)
        self.assert_refused(done, str(self.directory), "directory")

    def test_too_many_rows(self) -> None:
        path = self.file("long.csv", "1\n" * (csv_input.MAX_ROWS + 5))
        self.assert_refused(
            run_demo(path, "--model", LEVEL, "--out", self.out), "long.csv: row", "more than"
        )

    def test_bad_options(self) -> None:
        good = self.file("good.csv", "1\n2\n4\n3\n5\n4\n6\n")
        for arguments, says in (
            ([good], "--model is missing"),
            (["--model", LEVEL], "a CSV of your own"),
            (["--q", "1"], "a CSV of your own"),
            (["--estimate"], "a CSV of your own"),
            ([good, "--model", LEVEL, "--estimate", "--q", "0"], "--q 0: must be from 1e-30"),
            ([good, "--model", LEVEL, "--q", "-1"], "--q -1"),
            ([good, "--model", LEVEL, "--r", "0"], "--r 0"),
            ([good, "--model", LEVEL, "--r", "nan"], "--r nan"),
            ([good, "--model", VELOCITY, "--dt", "0"], "--dt 0"),
            ([good, "--model", LEVEL, "--range", "-3"], "--range -3"),
            (["--range", "3"], "a CSV of your own"),
            ([good, "--model", LEVEL, "--forecast", "-1"], "--forecast -1"),
        ):
            with self.subTest(says):
                self.assert_refused(run_demo(*arguments, "--out", self.out), says)

    def test_dt_against_the_times(self) -> None:
        path = self.file("timed.csv", "time,x\n0,1\n2,2\n4,3\n6,5\n8,4\n")
        done = run_demo(path, "--model", VELOCITY, "--dt", 1, "--out", self.out)
        self.assert_refused(done, "timed.csv: row 6", "the times step by 2")

    def test_a_range_that_the_data_leave(self) -> None:
        path = self.file("good.csv", "1\n2\n4\n3\n50\n4\n6\n")
        done = run_demo(path, "--model", LEVEL, "--range", 10, "--out", self.out)
        says = "kq_demo_q31: z of step 4 is 50, its range 10: measurement 0 needs "
        self.assert_refused(done, says, "more integer bits")

    def test_a_range_beyond_every_format(self) -> None:
        path = self.file("good.csv", "1\n2\n4\n3\n5\n4\n6\n")
        done = run_demo(path, "--model", LEVEL, "--range", 1e30, "--out", self.out)
        self.assert_refused(done, "kq_demo_q31: x_range 0, 1e+30: ")

    def test_data_that_are_not_enough_for_an_estimate(self) -> None:
        for name, content, arguments, says in (
            ("one", "5\n", ["--q", 1, "--r", 1], "fewer measurements than free parameters"),
            ("few", "5\n6\n7\n", [], "few.csv: row 3: too few measurements"),
            ("flat", "5\n" * 20, [], "the likelihood is infinite or zero"),
        ):
            with self.subTest(name):
                path = self.file(f"{name}.csv", content)
                arguments = [*arguments, "--model", LEVEL, "--estimate"]
                self.assert_refused(run_demo(path, *arguments, "--out", self.out), says)

    def test_programs_that_are_not_built(self) -> None:
        good = self.file("good.csv", "1\n2\n4\n3\n5\n4\n6\n")
        nowhere = self.directory / "nowhere"
        done = run_demo(good, "--model", LEVEL, "--out", self.out, "--programs", nowhere)
        self.assert_refused(done, "kq_demo_f32", "No such file")

    def test_a_file_where_the_results_should_go(self) -> None:
        good = self.file("good.csv", "1\n2\n4\n3\n5\n4\n6\n")
        done = run_demo(good, "--model", LEVEL, "--out", good)
        self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1), done.stderr)
        self.assertEqual(good.read_text(), "1\n2\n4\n3\n5\n4\n6\n")

    def test_the_input_is_not_overwritten(self) -> None:
        with self.assertRaisesRegex(Exception, "is the input"):
            with Outputs(NILE.parent, [NILE]) as outputs:
                outputs.write("nile.csv", "")
        self.assertEqual(len(csv_input.read(NILE, csv_input.LOCAL_LEVEL).values), 100)


def run_program(
    arithmetic: str, problem: str, kind: str = "demo"
) -> subprocess.CompletedProcess[str]:
    program = str(programs() / f"kq_{kind}_{arithmetic}")
    return subprocess.run([program], input=problem, capture_output=True, text=True)


class ProgramTest(unittest.TestCase):
    def assert_stops(self, arithmetic: str, problem: str, says: str, kind: str = "demo") -> None:
        done = run_program(arithmetic, problem, kind)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertTrue(done.stderr.startswith(f"kq_{kind}_{arithmetic}: {says}"), done.stderr)

    def assert_notices_a_full_disk(self, kind: str, problem: str) -> None:
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full here")
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run(
                [str(programs() / f"kq_{kind}_f64")],
                input=problem,
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
            )
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1))


class Programs(ProgramTest):
    def test_bad_problems(self) -> None:
        for arithmetic in ARITHMETICS:
            for problem, says in BAD_PROBLEMS:
                with self.subTest(arithmetic=arithmetic, says=says):
                    self.assert_stops(arithmetic, problem, says)

    def test_refused_models(self) -> None:
        for arithmetic in ARITHMETICS:
            for model, floating, fixed in REFUSED:
                with self.subTest(arithmetic=arithmetic, model=model):
                    problem = f"sizes 1 1 1 0\n{model} x_range 9 z_range 9 z 1 end"
                    says = fixed if arithmetic == "q31" else floating
                    self.assert_stops(arithmetic, problem, says)

    def test_misfits(self) -> None:
        for problem, says in MISFITS:
            with self.subTest(says):
                self.assert_stops("q31", problem, says)
                self.assertEqual(run_program("f64", problem).returncode, 0)

    def test_beyond_a_float(self) -> None:
        problem = f"sizes 1 1 1 0\n{MODEL}\nz 1e100 end"
        for arithmetic, status in (("f32", 1), ("f64", 0), ("q31", 1)):
            self.assertEqual(run_program(arithmetic, problem).returncode, status)

    def test_a_saturated_state(self) -> None:
        """x doubles until it leaves its word; the event tells, in the forecast as well."""
        start = "A 2 Q 0 H 1 R 1 x0 1 P0 0 x_range 1.9 z_range 1.9"
        for sizes, data, events in (
            ("1 1 1 0", "z nan", 0),
            ("1 1 9 0", "z" + " nan" * 9, 8),
            ("1 1 1 9", "z nan", 8),
        ):
            done = run_program("q31", f"sizes {sizes} {start} {data} end")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"\nevents {events}\n", done.stdout)

    def test_fixed_point_is_exact_where_it_can_be(self) -> None:
        """A constant from measurements without noise: what is read is what was given."""
        problem = "sizes 1 1 2 1 A 1 Q 0 H 1 R 0 x0 0 P0 1 x_range 3 z_range 3 z 1.25 nan end"
        done = run_program("q31", problem)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("\nformats state 29 measurement 29\n", done.stdout)
        lines = {tuple(line.split()[:2]): line.split()[2:] for line in done.stdout.splitlines()}
        for record in (("step", "0"), ("step", "1"), ("forecast", "1")):
            filtered, _, other, _ = map(float, lines[record])
            self.assertAlmostEqual(filtered, 1.25, delta=2**-29)
            self.assertAlmostEqual(other, 1.25, delta=2**-29)

    def test_results_that_cannot_be_written(self) -> None:
        self.assert_notices_a_full_disk("demo", f"sizes 1 1 1 0\n{MODEL}\nz 1 end")

    def test_against_the_reference(self) -> None:
        """Missing components, several axes, a forecast: as the textbook has it."""
        job = built_in.track(7)
        z = job.z.copy()
        z[20:30, 0] = np.nan
        z[0, 1] = np.nan
        job = type(job)(**{**job.__dict__, "z": z})
        true = reference.run(job.model, job.z, job.ahead)
        for name, limit in (("f32", 2e-5), ("f64", 1e-9), ("q31", 2e-6)):
            found = runner.run(programs() / f"kq_demo_{name}", job)
            for part in ("filtered", "smoothed", "forecast", "forecast_z"):
                error = report.mean_error(getattr(found, part), getattr(true, part))
                self.assertLess(error, limit, f"{name}, {part}")
            self.assertLess(report.sigma_error(found, true), limit)
            self.assertAlmostEqual(found.log_likelihood, true.log_likelihood, delta=1e-3)
            self.assertEqual(found.events, 0)


def estimate(arithmetic: str, guess: Job) -> Course:
    return runner.estimate(programs() / f"kq_estimate_{arithmetic}", guess)


class Estimation(ProgramTest):
    def assert_highest(self, course: Course, z: np.ndarray, change: float) -> None:
        """No q or r beside the last ones is likelier, by the textbook's filter."""
        best = course.models[-1]

        def likelihood(q_factor: float, r_factor: np.ndarray) -> float:
            beside = best.with_noise(best.Q * q_factor, best.R * r_factor)
            return reference.run(beside, z, 0).log_likelihood

        m = len(best.R)
        highest = likelihood(1, np.ones(m))
        for factor in (1 - change, 1 + change):
            self.assertLess(likelihood(factor, np.ones(m)), highest)
            for c in range(m):
                factors = np.where(np.arange(m) == c, factor, 1)
                self.assertLess(likelihood(1, factors), highest)

    def test_the_nile(self) -> None:
        """Four digits of what Durbin and Koopman publish."""
        guess = built_in.nile(ROOT, None)
        for arithmetic in ESTIMATING:
            with self.subTest(arithmetic):
                course = estimate(arithmetic, guess)
                self.assertTrue(course.settled)
                first, last = course.models[0], course.models[-1]
                self.assertEqual((first.q, first.r), (1e4, 1e4))
                self.assertEqual(f"{last.q[0]:.4g} {last.r[0]:.4g}", "1469 1.51e+04")
                self.assert_highest(course, guess.z, 1e-2)

    def test_the_log_likelihood_rises(self) -> None:
        guess = built_in.nile(ROOT, None)
        for arithmetic, rounding in (("f32", 2e-4), ("f64", 1e-11)):
            with self.subTest(arithmetic):
                found = estimate(arithmetic, guess).log_likelihood
                self.assertGreater(np.diff(found).min(), -rounding)
                self.assertGreater(np.diff(found[:50]).min(), 0)
                self.assertAlmostEqual(found[-1] - found[0], 4.2202, delta=rounding + 5e-5)

    def test_every_log_likelihood_is_that_of_its_noise(self) -> None:
        guess = built_in.track(0)
        course = estimate("f64", guess)
        for k in (0, 1, 10, course.last):
            true = reference.run(course.models[k], guess.z, 0)
            self.assertAlmostEqual(course.log_likelihood[k], true.log_likelihood, delta=1e-8)

    def test_two_axes_with_a_dropout(self) -> None:
        """Q stays a multiple of the guess, R diagonal; both come near the truth."""
        settings = built_in.Settings(seed=9, steps=1500, beyond=0)
        made = built_in.simulate(settings)
        x0, p0 = [0.0] * 4, [1e4, 1e2, 1e4, 1e2]
        model = jobs.constant_velocity(("x", "y"), 1.0, [1.0, 1.0], [9.0, 900.0], x0, p0)
        guess = Job("track", "", model, made.z, made.time, 1.0, 0)
        for arithmetic in ESTIMATING:
            with self.subTest(arithmetic):
                course = estimate(arithmetic, guess)
                last = course.models[-1]
                np.testing.assert_allclose(last.Q, last.q[0] * model.Q, rtol=1e-6)
                self.assertEqual(np.count_nonzero(last.R), 2)
                np.testing.assert_allclose(last.q, settings.q, rtol=0.2)
                np.testing.assert_allclose(last.r, settings.r, rtol=0.1)
                self.assert_highest(course, made.z, 2e-2)

    def test_bad_problems(self) -> None:
        problem = f"sizes 1 1 1 0\n{MODEL}\nz 1 2"
        few = f"sizes 1 1 1 0\n{MODEL}\nz 1 end"
        none = f"sizes 1 1 3 0\n{MODEL}\nz nan nan nan end"
        still = "sizes 1 1 3 0 A 1 Q 0 H 1 R 1 x0 0 P0 1 x_range 9 z_range 9 z 1 2 3 end"
        for arithmetic in ESTIMATING:
            for given, says in (
                (problem, "line 3: '2' where end should be"),
                (few, "EM: there are fewer measurements than free parameters"),
                (none, "EM: every measurement is missing"),
                (still, "EM: a parameter is not of the form"),
            ):
                with self.subTest(arithmetic=arithmetic, says=says):
                    self.assert_stops(arithmetic, given, says, "estimate")

    def test_iterations_that_cannot_be_written(self) -> None:
        self.assert_notices_a_full_disk("estimate", f"sizes 1 1 3 0\n{MODEL}\nz 1 2 3 end")


class Simulator(unittest.TestCase):
    def test_the_seed_determines_the_track(self) -> None:
        settings = built_in.Settings()
        first, second = built_in.simulate(settings), built_in.simulate(settings)
        self.assertEqual(built_in.track_csv(first), built_in.track_csv(second))
        other = built_in.simulate(built_in.Settings(seed=settings.seed + 1))
        self.assertFalse(np.array_equal(first.truth, other.truth))

    def test_the_numbers_of_a_known_seed(self) -> None:
        track = built_in.simulate(built_in.Settings(seed=1))
        noise = np.random.RandomState(1).standard_normal(2)
        np.testing.assert_allclose(noise, [1.62434536, -0.61175641], atol=1e-8)
        np.testing.assert_allclose(track.z[0], np.round(8 * noise, 3))

    def test_the_length_of_the_forecast_does_not_change_the_data(self) -> None:
        short = built_in.simulate(built_in.Settings(beyond=0))
        long = built_in.simulate(built_in.Settings(beyond=50))
        np.testing.assert_array_equal(short.z, long.z)
        np.testing.assert_array_equal(short.truth, long.truth[: len(short.truth)])

    def test_the_dropout(self) -> None:
        missing = np.isnan(built_in.simulate(built_in.Settings()).z)
        self.assertEqual(missing.sum(axis=0).tolist(), [30, 30])
        self.assertEqual(built_in.track(None).gaps(0, 1), [(75, 104)])

    def test_the_truth_follows_the_model(self) -> None:
        settings = built_in.Settings(steps=20000, beyond=0, q=0.05, dt=2.0)
        track = built_in.simulate(settings)
        for axis in track.truth[:, :2], track.truth[:, 2:]:
            step = np.array([[1.0, 2.0], [0.0, 1.0]])
            noise = axis[1:] - axis[:-1] @ step.T
            found = noise.T @ noise / len(noise)
            np.testing.assert_allclose(found, 0.05 * jobs.velocity_noise(2.0), rtol=0.05)


class Reference(unittest.TestCase):
    def test_a_constant(self) -> None:
        """Prior N(0, a^2), k measurements of variance s^2: known in closed form."""
        a2, s2, count = 9.0, 4.0, 12
        z = np.random.RandomState(3).standard_normal((count, 1)) + 5
        found = reference.run(jobs.local_level("level", 0.0, s2, 0.0, a2), z, 0)
        k = np.arange(1, count + 1)
        mean = a2 / (a2 + s2 / k) * np.cumsum(z) / k
        np.testing.assert_allclose(found.filtered.mean[:, 0], mean, rtol=1e-12)
        np.testing.assert_allclose(found.filtered.sigma[:, 0] ** 2, 1 / (1 / a2 + k / s2))
        np.testing.assert_allclose(found.smoothed.mean[:, 0], mean[-1], rtol=1e-12)
        # the measurements together are one Gaussian vector
        S = a2 * np.ones((count, count)) + s2 * np.eye(count)
        exact = -(count * np.log(2 * np.pi) + np.linalg.slogdet(S)[1]) / 2
        exact -= float(z[:, 0] @ np.linalg.solve(S, z[:, 0])) / 2
        self.assertAlmostEqual(found.log_likelihood, exact, places=9)

    def test_one_update_and_one_prediction(self) -> None:
        P0 = np.array([[0.4, 0.3], [0.3, 0.45]])
        model = jobs.Model(
            "rocket", ("a", "b"), ("a", "b"), np.diag([1.2, -0.2]), 0.3 * P0, np.eye(2), 0.5 * P0,
            np.array([0.2, -0.2]), P0,
        )
        found = reference.run(model, np.array([[2.3, -1.9]]), 1)
        np.testing.assert_allclose(found.filtered.mean, [[1.6, -4 / 3]])
        np.testing.assert_allclose(found.filtered.sigma ** 2, [[2 / 15, 0.15]])
        np.testing.assert_allclose(found.forecast.mean, [[1.92, 4 / 15]])
        np.testing.assert_allclose(found.forecast.sigma ** 2, [[0.312, 0.141]])
        np.testing.assert_allclose(found.forecast_z.sigma ** 2, [[0.512, 0.366]])

    def test_smoothing_is_least_squares(self) -> None:
        """All steps at once, with measurements missing: one weighted least-squares problem."""
        model = jobs.constant_velocity(("x",), 0.5, [0.7], [2.0], [1.0, -1.0], [9.0, 4.0])
        z = np.random.RandomState(4).standard_normal((8, 1)) * 3
        z[[2, 3]] = np.nan
        precision = np.zeros((16, 16))
        right = np.zeros(16)

        def add(rows: np.ndarray, value: np.ndarray, covariance: np.ndarray) -> None:
            weight = rows.T @ np.linalg.inv(covariance)
            precision[:] += weight @ rows
            right[:] += weight @ value

        pick = np.eye(16).reshape(8, 2, 16)
        add(pick[0], model.x0, model.P0)
        for t in range(8):
            if t > 0:
                add(pick[t] - model.A @ pick[t - 1], np.zeros(2), model.Q)
            if not np.isnan(z[t, 0]):
                add(model.H @ pick[t], z[t], model.R)
        found = reference.run(model, z, 0).smoothed
        np.testing.assert_allclose(found.mean.ravel(), np.linalg.solve(precision, right))
        np.testing.assert_allclose(
            found.sigma.ravel() ** 2, np.diag(np.linalg.inv(precision)), rtol=1e-9
        )

    def test_process_noise_over_two_steps(self) -> None:
        step = np.array([[1.0, 0.3], [0.0, 1.0]])
        once = jobs.velocity_noise(0.3)
        np.testing.assert_allclose(step @ once @ step.T + once, jobs.velocity_noise(0.6))


class Moments(unittest.TestCase):
    def test_local_level(self) -> None:
        random = np.random.RandomState(5)
        level = np.cumsum(random.standard_normal(50000)) * 2
        z = level + 3 * random.standard_normal(50000)
        q, r = own_data.level_noise(z, None, None)
        np.testing.assert_allclose([q, r], [4, 9], rtol=0.1)
        np.testing.assert_allclose(own_data.level_noise(z, None, 9.0), [4, 9], rtol=0.1)
        np.testing.assert_allclose(own_data.level_noise(z, 4.0, None), [4, 9], rtol=0.1)
        self.assertEqual(own_data.level_noise(z[:1], 1.0, 2.0), (1.0, 2.0))

    def test_constant_velocity(self) -> None:
        settings = built_in.Settings(seed=6, steps=5000, dt=0.5, q=0.4, r=25.0)
        z = built_in.simulate(settings).z[:, 0]
        q, r = own_data.axis_noise(z, 0.5, None, None)
        np.testing.assert_allclose([q, r], [0.4, 25], rtol=0.3)
        np.testing.assert_allclose(own_data.axis_noise(z, 0.5, 0.4, None)[1], 25, rtol=0.1)

    def test_estimates_stay_positive(self) -> None:
        random = np.random.RandomState(7)
        for z in (np.full(20, 5.0), np.zeros(20), np.arange(20.0), random.standard_normal(20)):
            for estimate in (
                own_data.level_noise(z, None, None),
                own_data.axis_noise(z, 1.0, None, None),
            ):
                self.assertTrue(all(value > 0 for value in estimate), estimate)


class Ranges(InDirectory):
    def test_of_the_track(self) -> None:
        """With a margin of 4, and further by as much as the forecast adds to the time."""
        job = built_in.track(75)
        reach = np.nanmax(np.abs(job.z), axis=0)
        reach += (np.nanmax(job.z, axis=0) - np.nanmin(job.z, axis=0)) * 75 / 150
        found = jobs.ranges_of(job)
        np.testing.assert_allclose(found.measured, 4 * reach)
        np.testing.assert_allclose(found.states, np.repeat(4 * reach, 2))  # dt is 1 s

    def test_declared(self) -> None:
        path = self.file("walk.csv", "time,x\n0,1\n0.5,2\n1,4\n1.5,3\n2,5\n2.5,4\n")
        job = own_data.constant_velocity(path, Given(q=1.0, r=1.0, range=100.0))
        found = jobs.ranges_of(job)
        np.testing.assert_allclose(found.measured, [100])
        np.testing.assert_allclose(found.states, [100, 200])

    def test_never_below_the_prior_or_the_noise(self) -> None:
        path = self.file("flat.csv", "0\n0\n0\n0\n")
        found = jobs.ranges_of(own_data.local_level(path, Given(q=1.0, r=4.0, ahead=0)))
        np.testing.assert_allclose(found.measured, [4 * 2])
        np.testing.assert_allclose(found.states, [10 * 2])


class Input(InDirectory):
    def test_the_nile(self) -> None:
        data = csv_input.read(NILE, csv_input.LOCAL_LEVEL)
        flow = data.values[:, 0]
        self.assertEqual((len(flow), flow[0], flow[42], flow[-1]), (100, 1120, 456, 740))
        self.assertEqual((data.time[0], data.time[-1]), (1871, 1970))
        self.assertAlmostEqual(flow.mean(), 919.35, places=9)
        self.assertEqual(data.names, ("flow",))

    def test_missing_values_and_units(self) -> None:
        path = self.file("a.csv", "\ufefftime [s],\"east [m]\",north (m)\n0, 1.5,\n0.5,nan,-2\n\n")
        data = csv_input.read(path, csv_input.POSITIONS)
        np.testing.assert_array_equal(data.values, [[1.5, np.nan], [np.nan, -2]])
        np.testing.assert_array_equal(data.time, [0, 0.5])
        self.assertEqual(data.names, ("east", "north"))

    def test_semicolons_and_tabs(self) -> None:
        for mark in ";\t":
            text = f"# a, comment\ntime{mark}level\n0{mark}3\n1{mark}\n2{mark}5\n"
            data = csv_input.read(self.file("a.csv", text), csv_input.LOCAL_LEVEL)
            np.testing.assert_array_equal(data.values, [[3], [np.nan], [5]])
            np.testing.assert_array_equal(data.time, [0, 1, 2])

    def test_one_column_without_header(self) -> None:
        data = csv_input.read(self.file("a.csv", "3\r\nnan\r\n5\r\n"), csv_input.LOCAL_LEVEL)
        np.testing.assert_array_equal(data.values, [[3], [np.nan], [5]])
        self.assertIsNone(data.time)

    def test_errors_are_input_errors(self) -> None:
        with self.assertRaises(FileError):
            csv_input.read(self.directory / "none.csv", csv_input.LOCAL_LEVEL)


class WholeFiles(InDirectory):
    def test_nothing_is_left_after_an_error(self) -> None:
        with self.assertRaises(ValueError):
            with Outputs(self.directory, []) as outputs:
                outputs.write("a.csv", "text")
                raise ValueError
        self.assertEqual(list(self.directory.iterdir()), [])

    def test_all_appear_at_the_end(self) -> None:
        with Outputs(self.directory, []) as outputs:
            outputs.write("a.csv", "text")
            self.assertFalse((self.directory / "a.csv").exists())
        self.assertEqual([path.name for path in self.directory.iterdir()], ["a.csv"])


class EndToEnd(InDirectory):
    def run_well(self, *arguments: object) -> str:
        done = run_demo(*arguments, "--out", self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def assert_plot(self, name: str) -> None:
        content = (self.out / name).read_bytes()
        self.assertTrue(content.startswith(PNG_SIGNATURE))
        self.assertGreater(len(content), 20000)

    def assert_close(self, path: Path, names: list[str], limit: float) -> None:
        """Every arithmetic against the reference in a file of results, in standard deviations."""
        rows = read_csv(path)
        true = [row for row in rows if row["arithmetic"] == REFERENCE]
        for arithmetic in ARITHMETICS:
            found = [row for row in rows if row["arithmetic"] == arithmetic]
            self.assertEqual(len(found), len(true))
            for a, b in zip(found, true):
                for name in names:
                    if b[name]:
                        error = abs(float(a[name]) - float(b[name])) / float(b[f"{name}_sigma"])
                        self.assertLess(error, limit, f"{arithmetic} {name} {a['step']}")

    def assert_iterations(self, name: str, noise: list[str], agree: float) -> None:
        """From the same guess, over rising log-likelihoods, to nearly the same noise."""
        rows = read_csv(self.out / name)
        ends = []
        for arithmetic in ESTIMATING:
            found = [row for row in rows if row["arithmetic"] == arithmetic]
            self.assertEqual([int(row["iteration"]) for row in found], list(range(len(found))))
            self.assertGreater(
                float(found[-1]["log_likelihood"]), float(found[0]["log_likelihood"])
            )
            ends.append([[float(row[name]) for name in noise] for row in (found[0], found[-1])])
        np.testing.assert_allclose(ends[0][0], ends[1][0], rtol=1e-6)
        np.testing.assert_allclose(ends[0][1], ends[1][1], rtol=agree)

    def test_the_built_in_data(self) -> None:
        printed = self.run_well()
        names = ["nile.csv", "nile.png", "nile_em.csv", "nile_em.png"]
        names += ["track.csv", "track.png", "track_data.csv"]
        self.assertEqual(sorted(path.name for path in self.out.iterdir()), names)
        for name in names:
            self.assertIn(name, printed)
        self.assertEqual(printed.count("-641.5856"), 7)  # of estimates 3, of runs 4
        self.assertIn("rose by 4.2202, from -645.8058 to -641.5856", printed)
        self.assertIn("estimate (EM in f64): q = 1468.55, r = 15099.6\n", printed)
        self.assertIn("Durbin and Koopman", printed)
        self.assertIn("q31 formats, states: flow Q13.18 (\u00b15846)\n", printed)
        self.assertIn("q31 formats, measurements: flow Q13.18 (\u00b15846)\n", printed)
        self.assertNotIn("KQ_EVENT", printed)
        self.assert_plot("nile.png")
        self.assert_plot("nile_em.png")
        self.assert_plot("track.png")
        self.assert_iterations("nile_em.csv", ["q_flow", "r_flow"], 1e-3)
        self.assertEqual(len(read_csv(self.out / "nile.csv")), 4 * (100 + 10))
        self.assertEqual(len(read_csv(self.out / "track.csv")), 4 * (150 + 20))
        self.assert_close(self.out / "nile.csv", ["filtered_flow", "smoothed_flow"], 1e-4)
        self.assert_close(self.out / "track.csv", ["filtered_x", "smoothed_vy", "forecast_y"], 1e-4)
        gap = read_csv(self.out / "track_data.csv")[75:105]
        self.assertTrue(all(row["x"] == "" and row["true_x"] for row in gap))

    def test_a_level_of_ones_own(self) -> None:
        years = range(1900, 1950)
        flow = "".join(f"{year},{'' if year % 7 == 0 else year % 5}\n" for year in years)
        path = self.file("my level.csv", "year,a$b_$\n" + flow)
        printed = self.run_well(path, "--model", LEVEL, "--forecast", 3)
        self.assertIn("(estimated)", printed)
        self.assert_plot("my level_kalmanq.png")
        self.assertEqual(len(read_csv(self.out / "my level_kalmanq.csv")), 4 * 53)

    def test_a_track_of_ones_own(self) -> None:
        track = built_in.simulate(built_in.Settings(seed=8, steps=120, dt=0.1))
        for axes in (1, 2, 3):
            z = np.column_stack([track.z, track.z[:, 0]])[:, :axes]
            path = self.file(f"walk{axes}.csv", csv_rows(z))
            self.run_well(path, "--model", VELOCITY, "--dt", 0.1, "--forecast", 0, "--r", 64)
            self.assert_plot(f"walk{axes}_kalmanq.png")
            names = ["filtered_x", "smoothed_x", "smoothed_vx"]
            self.assert_close(self.out / f"walk{axes}_kalmanq.csv", names, 1e-3)

    def test_an_estimate_of_ones_own(self) -> None:
        path = self.file("flow.csv", NILE.read_text(encoding="utf-8"))
        printed = self.run_well(path, "--model", LEVEL, "--estimate", "--q", 1e4, "--r", 1e4)
        self.assertIn("\nguess: q = 10000, r = 10000\n", printed)
        self.assertNotIn("published", printed)
        self.assertEqual(len(list(self.out.iterdir())), 4)
        self.assert_plot("flow_kalmanq_em.png")
        self.assert_iterations("flow_kalmanq_em.csv", ["q_flow", "r_flow"], 1e-3)
        names = ["filtered_flow", "smoothed_flow", "forecast_flow"]
        self.assert_close(self.out / "flow_kalmanq.csv", names, 1e-4)

    def test_an_estimate_of_a_track(self) -> None:
        track = built_in.simulate(built_in.Settings(seed=8, steps=120, beyond=0))
        path = self.file("walk.csv", csv_rows(track.z))
        self.run_well(path, "--model", VELOCITY, "--estimate")
        self.assert_plot("walk_kalmanq_em.png")
        self.assert_iterations("walk_kalmanq_em.csv", ["q_x", "q_y", "r_x", "r_y"], 1e-2)

    def test_an_estimate_that_does_not_settle(self) -> None:
        """A ramp is no local level with any r: q takes the slope, r goes on falling."""
        path = self.file("ramp.csv", "".join(f"{3 * t + t % 3 / 2}\n" for t in range(40)))
        printed = self.run_well(path, "--model", LEVEL, "--estimate")
        self.assertEqual(printed.count("not settled after 1000 iterations"), 2)

    def test_very_little_data(self) -> None:
        path = self.file("one.csv", "5\n")
        self.run_well(path, "--model", LEVEL, "--q", 0, "--r", 1)
        self.run_well(path, "--model", VELOCITY, "--q", 1, "--r", 1, "--forecast", 0)
        path = self.file("flat.csv", "5,0\n" * 9)
        self.run_well(path, "--model", VELOCITY)

    def test_a_range_of_ones_own(self) -> None:
        path = self.file("good.csv", "1\n2\n4\n3\n5\n4\n6\n")
        printed = self.run_well(path, "--model", LEVEL, "--range", 1000)
        self.assertIn("q31 formats, measurements: level Q10.21 (\u00b11000)", printed)

    def test_a_forecast_out_of_range(self) -> None:
        """Saturation is reported, and only of the arithmetic that has it."""
        path = self.file("fast.csv", "".join(f"{10 * t}\n" for t in range(20)))
        arguments = ["--model", VELOCITY, "--q", 1e-3, "--r", 1, "--range", 200]
        printed = self.run_well(path, *arguments, "--forecast", 30)
        self.assertIn("q31: KQ_EVENT_SATURATED", printed)
        self.assertEqual(printed.count("KQ_EVENT"), 1)

    def test_where_it_is_started_does_not_matter(self) -> None:
        self.file("here.csv", "1\n2\n4\n3\n5\n4\n6\n")
        done = run_demo("here.csv", "--model", LEVEL, "--out", "out", cwd=self.directory)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("wrote out/here_kalmanq.png", done.stdout)
        self.assertTrue((self.out / "here_kalmanq.png").exists())


def take_option() -> None:
    """Moves --programs DIR from the command line to where programs() looks."""
    if "--programs" in sys.argv[:-1]:
        at = sys.argv.index("--programs")
        os.environ["KQ_DEMO_PROGRAMS"] = os.path.abspath(sys.argv[at + 1])
        del sys.argv[at : at + 2]


if __name__ == "__main__":
    take_option()
    unittest.main()
