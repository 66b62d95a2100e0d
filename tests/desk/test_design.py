"""Designs: formats that hold, C files that do what the twin does, promises that are kept."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import five
from products import PRODUCTS
from kalmanq import KalmanqError, Model, ModelError, Quantity, costs
from kalmanq.c_source import WAYS, source, ways_of
from kalmanq.commands.simulate import simulate
from kalmanq.core import lib
from kalmanq.designs import ACCURATE, PARTS, Part, design, errors_of
from kalmanq.filters import Filter
from kalmanq.parts import Parts
from kalmanq.reach import Record, draw, life_of, reach, tail, with_ranges

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "tools" / "kalmanq" / "examples"
sys.path.insert(0, str(ROOT / "tools" / "cost"))
from design_models import random_model, write  # noqa: E402

STRICT = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow",
          "-Werror", "-ffp-contract=off"]
LARGE = Part("m3", 1 << 24, 1 << 24)


def kalmanq(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-m", "kalmanq.command_line", *map(str, arguments)], capture_output=True,
                          text=True, check=False)


# ------------------------------------------------------------------------------ the C files

HOST = """
#include <stdio.h>
#include "design.h"
int main(void)
{
    int wrong = DESIGN(init)() || DESIGN(update)(rows[0], ALL);
    for (int t = 1; t < ROWS; t++) wrong |= STEP(t) < 0;
    for (int i = 0; i < N; i++) wrong |= MEAN(DESIGN(filter)(), i) != expected[i];
    puts(wrong ? "other words" : "the same words");
    return wrong;
}
"""


@pytest.fixture(scope="session")
def library(tmp_path_factory) -> Path:
    work = tmp_path_factory.mktemp("library")
    for T in ("f32", "q31"):
        for part in ("filter", "steady"):
            subprocess.run(["cc", "-std=c11", "-O0", "-ffp-contract=off", f"-I{ROOT / 'include'}", "-c",
                            str(ROOT / "src" / f"kq_{part}_{T}.c"), "-o", str(work / f"{part}_{T}.o")], check=True)
    return work


@pytest.mark.parametrize("make", five.FIVE)
@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_the_c_file_does_what_the_twin_does(make, arithmetic, library, tmp_path):
    model = make()
    parts, record = Parts(model, arithmetic), draw(model.changed(gaps=type(model.gaps)()), seeds=[3])[0]
    assert ways_of(parts) == list(WAYS)
    (tmp_path / "main.c").write_text(HOST)
    for way in WAYS:
        name = f"written_{way}"
        folder = write(tmp_path, name, parts, way, record)
        subprocess.run(["cc", *STRICT, f"-I{ROOT / 'include'}", f"-I{ROOT / 'src' / 'known_sizes'}", f"-I{folder}",
                        str(folder / f"{name}.c"), str(tmp_path / "main.c"),
                        *map(str, sorted(library.glob(f"*_{arithmetic}.o"))), "-lm", "-o", str(folder / "run")],
                       check=True)
        assert subprocess.run([str(folder / "run")], capture_output=True, text=True).stdout == "the same words\n", way


def test_names_are_identifiers():
    model = Model(np.eye(2), [[1, 0]], 1, np.eye(2), P0=[1, 1], states=["a b", "a-b"], measurements=["3 z"], name="9 for")
    made = source(Parts(model, "f32"), "lean")
    assert made.name == "filter_9_for"
    assert "FILTER_9_FOR_A_B,\n    FILTER_9_FOR_A_B_," in made.header


def test_a_correlated_or_unknown_start_has_its_ways():
    correlated = Model(1, [[1], [1]], [[1, 0.5], [0.5, 1]], 1, P0=1)
    assert ways_of(Parts(correlated, "f32")) == ["init"]
    with pytest.raises(KalmanqError, match="cannot be written as lean"):
        source(Parts(correlated, "f32"), "lean")
    assert ways_of(Parts(Model(1, 1, 1, 1, P0=None), "f32")) == ["init", "sizes"]


# ------------------------------------------------------------------------------ ranges and errors


def test_the_reach_has_what_is_between_components():
    """Two gauges of one state that contradict each other: between them the mean is far off."""
    model = Model(1, [[1], [1]], [1e-4, 1e-4], 1e-6, P0=100, states=["level"])
    found = reach(model, [Record(np.array([[0.0, 0.0], [9.0, -9.0]]))])
    assert 3 < found.states[0] <= 4.5 + 0.1 and found.measurements[0] == 9


def test_random_designs_hold_or_warn():
    """200 models, ranges 1.5 times the largest state: on records that were not there when it was designed."""
    random, held, warned = np.random.default_rng(7), 0, 0
    for k in range(200):
        n = int(random.integers(1, 7))
        model = random_model(random, n, int(random.integers(1, min(n, 3) + 1)))
        model = model.changed(controls=[Quantity(one.name, range=1.0) for one in model.controls]) if model.l else model
        try:
            ranged, _ = with_ranges(model, draw(model, seeds=range(k, k + 4)))
            trial = design(ranged, LARGE, draw(ranged, seeds=range(k, k + 4))).trials["q31"]
        except KalmanqError:
            warned += 1
            continue
        if trial.warnings:
            warned += 1
            continue
        for record in draw(ranged, seeds=[1000 + k, 2000 + k]):
            run, exact = (Filter(ranged, name).run(record.z, record.u) for name in ("q31", "f64"))
            assert not run.events & (lib.KQ_EVENT_SATURATED | lib.KQ_EVENT_OVERFLOW), k
            assert np.nanmax(np.abs(errors_of(run, exact)), initial=0) < ACCURATE, k
        held += 1
    assert held >= 150, (held, warned)


@pytest.mark.parametrize("make", five.FIVE)
def test_the_promised_error_is_that_of_other_records(make):
    """Of q31, in the mean square over all states; f32's depends on where the states are."""
    model = make()
    promised = design(model, LARGE, draw(model)).trials
    measured = design(model, LARGE, draw(model, seeds=range(100, 112))).trials
    ratio = np.sqrt(np.mean(measured["q31"].rms ** 2) / np.mean(promised["q31"].rms ** 2))
    assert 0.8 < ratio < 1.2, ratio
    assert measured["f32"].worst.max() < 10 * promised["f32"].worst.max()


def test_without_range_or_data_a_wandering_state_is_refused_and_a_stationary_one_is_not():
    with pytest.raises(KalmanqError, match="level has no range.*its states wander"):
        with_ranges(Model(1, 1, 1, 1, P0=1, states=["level"]), [])
    ranged, notes = with_ranges(Model(0.5, 1, 1, 0.75, P0=1), [])
    assert 6 * 1 * 1.5 <= ranged.states[0].range < 11 and len(notes) == 2


def bare(model):
    """Without ranges"""
    def names(which):
        return [replace(one, range=None) for one in which]

    return model.changed(states=names(model.states), measurements=names(model.measurements),
                         controls=names(model.controls) if model.l else None)


def drawn(model, seed, rows=2000):
    u = np.random.default_rng([seed, 7]).uniform(-1, 1, (rows, model.l)) if model.l else None
    return Record(simulate(model, rows, seed, u)[1], u)


@pytest.mark.parametrize("seed", (1000, 1001, 1002))
def test_ranges_of_one_record_hold_others(seed):
    """640 of 16 products: none saturates, none is refused by a range"""
    for make in PRODUCTS:
        model = bare(make())
        ranged, _ = with_ranges(model, [drawn(model, seed)], lives=True)
        parts = Parts(ranged, "q31")
        for other in range(40):
            record = drawn(model, other)
            run = Filter(ranged, "q31", parts=parts).run(record.z, record.u)
            assert not run.events & (lib.KQ_EVENT_SATURATED | lib.KQ_EVENT_OVERFLOW), (make, other)


def test_ranges_hold_the_prior():
    """Of a record that begins near x0, where the next one need not"""
    model = Model(1, 1, 1.0, 0.1, P0=1e4, states=["level"], measurements=["z"])
    ranged, notes = with_ranges(model, [Record(np.zeros((200, 1)))], lives=True)
    assert min(ranged.states[0].range, ranged.measurements[0].range) > 6 * 100
    assert re.fullmatch(r"level: a range of \S+ was chosen; the model \S+ in 10000 rows \(farther: a "
                        r"chance of 1e-06\); it wanders, and goes farther later: declare what bounds it", notes[0]), notes


@pytest.mark.parametrize("steps", (1, 1000, 30_000))
def test_a_life_is_as_its_covariance_says(steps):
    """Row by row, of what grows, swings and fades"""
    for make in PRODUCTS:
        model = bare(make())
        P = model.P0
        most = np.diag(P)
        for _ in range(steps):
            P = model.A @ P @ model.A.T + model.Q
            most = np.fmax(most, np.diag(P))
        life = life_of(model.changed(B=None, controls=None), [Record(np.zeros((steps, model.m)))])
        least = tail(life.rows * (model.n + model.m)) * np.sqrt(most)
        assert life.rows >= 4 * steps and np.all(life.reach[:model.n] >= least * (1 - 1e-9))
        if model.name != "load_cell":  # of a long life only, beside its prior
            assert life.wanders.any() == (model.name not in ("battery", "anemometer", "spring", "oven"))


def test_only_what_wanders_is_said_to():
    """A model with controls that fade does not, and needs no data"""
    model = Model([[0.9, 0.1], [0, 0.8]], [1, 0], 1, [0.1, 0.1], B=[0, 1], P0=[1, 1], controls=[Quantity("u", range=3)])
    ranged, notes = with_ranges(model, [])
    assert all(one.range for one in (*ranged.states, *ranged.measurements)) and "wander" not in "".join(notes)
    x = np.zeros(2)
    for _ in range(500):
        x = model.A @ x + model.B[:, 0] * 3
    assert np.all(np.array([one.range for one in ranged.states]) > 1.5 * x)
    with pytest.raises(KalmanqError, match="u has no range"):
        with_ranges(model.changed(controls=["u"]), [])
    with pytest.raises(KalmanqError, match="its states wander"):
        with_ranges(model.changed(A=[[1, 0.1], [0, 0.8]]), [])
    known = model.changed(A=[[1, 0.1], [0, 1]], states=[Quantity("a", range=50), Quantity("b", range=9)])
    assert 50 < with_ranges(known, [])[0].measurements[0].range < 100  # no farther than what it sees


def test_what_grows_by_a_power_has_its_data_alone():
    model = Model(1.5, 1, 1, 1, P0=1)
    ranged, notes = with_ranges(model, [Record(np.full((50, 1), 4.0))], lives=True)
    assert ranged.states[0].range < 15 and "the model grows without end: the range is that of the data alone" in notes[0]


def test_saturating_ranges_are_warned_of():
    model = Model(1, 1, 1e-4, 1.0, P0=1, states=[Quantity("level", range=4)], measurements=[Quantity("z", range=1e6)])
    records = [type(draw(model)[0])(np.cumsum(np.full((400, 1), 0.5), axis=0))]
    trial = design(model, LARGE, records).trials["q31"]
    assert not trial.is_good and trial.warnings


@pytest.mark.parametrize("arithmetic", ("f32", "q31"))
def test_the_reading_that_the_header_names_keeps_its_figure(arithmetic):
    """kq_mean without its low part, over records that were not there: its rounding is bounded, the rest was seen"""
    runs, beyond, over = 0, 0, []
    for make in (*five.FIVE, *PRODUCTS):
        model, _ = with_ranges(make(), [drawn(make(), 1)], lives=True)
        trial = design(model, LARGE, [drawn(model, 1)]).trials[arithmetic]
        if trial.refused:
            continue
        parts = Parts(model, arithmetic)
        for seed in range(2, 10):
            record = drawn(model, seed)
            if any(np.any(np.abs(record.z[:, j]) > one.range) for j, one in enumerate(model.measurements)):
                continue
            run, exact = (Filter(model, name).run(record.z, record.u) for name in (arithmetic, "f64"))
            if np.any(np.abs(exact.mean) > [one.range for one in model.states]):
                continue
            mean = parts.arithmetic.values(run.words["mean"], parts.fractions("states"))
            assert np.nanmax(np.abs(mean - run.mean) / exact.sigma) <= trial.reading * (1 + 1e-9), make
            error = np.nanmax(np.abs(mean - exact.mean) / exact.sigma)
            runs, beyond = runs + 1, beyond + (error > trial.worst.max())
            over.append(error / (trial.reading + trial.worst.max()))
    assert runs > 80 and beyond > 0.4 * runs  # what was printed before: without what the reading loses
    assert np.mean(np.array(over) > 1) < 0.15 and max(over) < 3, (max(over), np.mean(np.array(over) > 1))


def test_the_header_says_what_was_seen_and_what_is_bounded(tmp_path):
    done = kalmanq("design", EXAMPLES / "track.toml", "--core", "m3", "--arith", "q31", "-o", tmp_path, "--json")
    trial = json.loads(done.stdout)["trials"]["q31"]
    text = " ".join((tmp_path / "track.h").read_text().replace("\n *", "").split())
    said = re.search(r"kq_mean_q31 alone is (\S+) sigma from double's: of these, (\S+) at most by its 32 bits while states are "
                     r"within their ranges, and (\S+) \((\S+) in the mean square\) by what was seen over (\d+) rows, which is "
                     r"no bound", text)
    assert said and int(said[5]) == trial["rows"] > 100
    for figure, value in zip(said.groups(), (trial["reading"] + max(trial["worst"]), trial["reading"],
                                             max(trial["worst"]), max(trial["rms"]))):
        assert value <= float(figure) <= 1.11 * value


# ------------------------------------------------------------------------------ costs


def test_estimates_are_near_what_was_measured():
    """Each row of the table from all rows of its kind: instructions, flash and RAM to 20 %."""
    errors = []
    for row in costs.measured():
        for measure in costs.SUMS:
            found = costs.factors(row["core"], row["arithmetic"], row["way"], measure) @ costs.terms(measure, row)
            errors.append(abs(found / row[measure] - 1))
    assert len(errors) > 1000 and max(errors) < 0.2, max(errors)


def test_the_stack_is_never_less_than_what_was_measured():
    for row in costs.measured():
        assert costs.deepest(row["core"], row["arithmetic"], row["way"], row) >= row["stack"]


# ------------------------------------------------------------------------------ the command


@pytest.mark.parametrize("core", sorted(PARTS))
def test_the_command_writes_a_filter(core, tmp_path):
    done = kalmanq("design", EXAMPLES / "track.toml", "--core", core, "--flash", 512, "-o", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["chosen"] and sorted(path.name for path in tmp_path.iterdir()) == ["track.c", "track.h"]
    assert {one["arithmetic"] for one in told["ways"]} == {"f32", "q31"}
    assert all(one["instructions"] > 0 and one["stack"] > 0 for one in told["ways"])


def test_what_does_not_fit_is_said(tmp_path):
    done = kalmanq("design", EXAMPLES / "track.toml", "--core", "m0", "--flash", 4, "-o", tmp_path)
    assert done.returncode == 1 and not list(tmp_path.iterdir())
    assert "no way fits 4 kB of flash" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize("arguments, said", [
    (["nowhere.toml", "--core", "m0"], "nowhere.toml: no such file"),
    ([EXAMPLES / "level.toml", "--core", "m0"], "its states wander; give ranges, or --data"),
    ([EXAMPLES / "track.toml", "--core", "m0", "--data", "no.csv"], "no.csv: no such file"),
    ([EXAMPLES / "track.toml", "--core", "m0", "-o", "nowhere"], "nowhere: there is no such folder"),
])
def test_wrong_input_is_one_line(arguments, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = kalmanq("design", *arguments)
    assert done.returncode == 1 and said in done.stderr
    assert done.stderr.count("\n") == 1 and not list(tmp_path.iterdir())


def test_an_unknown_core_is_a_usage_error():
    assert kalmanq("design", EXAMPLES / "track.toml", "--core", "z80").returncode == 2


def test_a_model_without_ranges_is_no_fixed_point():
    with pytest.raises(ModelError):
        Parts(Model(1, 1, 1, 1, P0=1), "q31")


@pytest.mark.parametrize("name, states", [
    ("small", ["h", "v"]), ("kq", ["states", "v"]), ("t", ["x", "x_fraction"]), ("kalmanq/kalmanq", ["all", "b"]),
    ("t", ["*/ int x; /*", "a??/"]), ("stdint", ["a\nb", "ß"]), ("while", ["", " "]), ("main", ["x", "X"])])
@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_any_names_make_c(name, states, arithmetic, tmp_path):
    model = Model(np.eye(2), [1, 0], 1, np.eye(2), P0=[1, 1], name=name, measurements=[Quantity("h", "*/", 9)],
                  states=[Quantity(one, "m/*s", 9) for one in states])
    made = source(Parts(model, arithmetic), "lean")
    (tmp_path / f"{made.name}.h").write_text(made.header, encoding="utf-8")
    (tmp_path / f"{made.name}.c").write_text(made.text, encoding="utf-8")
    done = subprocess.run(["cc", *STRICT, "-Wtrigraphs", f"-I{ROOT / 'include'}", f"-I{tmp_path}", "-c",
                           str(tmp_path / f"{made.name}.c"), "-o", str(tmp_path / "x.o")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr + made.header
