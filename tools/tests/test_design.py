"""Designs: formats that hold, C files that do what the twin does, promises that are kept."""

from __future__ import annotations

import json
import math
import re
import subprocess
from dataclasses import replace
from functools import lru_cache
from itertools import groupby, product

import numpy as np
import pytest

import five
from command import json_of, kalmanq, refused, succeeds
from firmware_here import Firmware
from library import EXAMPLES, ROOT, objects, saved, written
from products import PRODUCTS
from random_models import random_model
from whole import MEASURED, WHOLE, first, paired
from kalmanq import KalmanqError, Model, ModelError, Quantity
from kalmanq.commands.design import no_less
from kalmanq.core import lib
from kalmanq.compiler.report.design_costs import design_of
from kalmanq.compiler.text.over_library import source, ways_of
from kalmanq.firmware.designs import ACCURATE, Part, design, errors_of
from kalmanq.firmware.life import life_of, tail
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import Record, draw, reach
from kalmanq.model import Gaps, model_file
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts, not_lean
from kalmanq.run.simulation import simulate


STRICT = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow",
          "-Werror", "-ffp-contract=off"]
LARGE = Part("m3", 1 << 24, 1 << 24)


# ------------------------------------------------------------------------------ the C files

HOST = """
#include <stdio.h>
#include "cost-calls.h"
int main(void)
{
    int wrong = DESIGN(init)();
    for (int t = 0; t < ROWS; t++) {
        wrong |= t ? STEP_OF(t, rows[t], present[t]) : DESIGN(update)(rows[0], present[0]);
        for (int i = 0; i < N; i++) wrong |= MEAN(DESIGN(filter)(), i) != expected[t][i];
    }
    puts(wrong ? "other words" : "the same words");
    return wrong;
}
"""


def with_holes(record, seed):
    """Rows of which some or all components are missing, a gap among them; the first is whole."""
    random, z = np.random.default_rng(seed), record.z.copy()
    z[1:][random.random(z[1:].shape) < 0.2] = np.nan
    z[9:16] = np.nan
    return type(record)(z, record.u)


def models_to_write():
    random = np.random.default_rng(11)
    made = [make() for make in five.FIVE]
    for k in range(12):
        model = random_model(random, int(random.integers(1, 7)), int(random.integers(1, 3)))
        model = model.changed(controls=[Quantity(one.name, range=1.0) for one in model.controls]) if model.l else model
        made.append(model.changed(name=f"random_{k}"))
        if k % 2:
            offsets = {"c": random.normal(size=model.n), "d": 3 * random.normal(size=model.m)}
            made.insert(5, model.changed(**offsets, name=f"offsets_{k}"))
    low_noise = made[1].changed(R=made[1].R * 1e-3, name="low_noise")  # a lean sensor takes it otherwise than a full one
    return [*made[:5], low_noise, *made[5:]]


@pytest.mark.parametrize("model, arithmetic", [*paired(models_to_write()[:8], ("f32", "q31")), *first(0, product(models_to_write()[8:], ("f32", "q31")))], ids=lambda one: getattr(one, "name", one))
def test_the_c_file_does_what_the_twin_does(model, arithmetic, tmp_path):
    """At every row, of which some have gaps: the means, bit for bit."""
    record = with_holes(draw(model.changed(gaps=type(model.gaps)()), 32, seeds=[3])[0], 5)
    model = with_ranges(model, draw(model))[0]
    (tmp_path / "main.c").write_text(HOST)
    for way in ways_of(model):
        name, parts, folder = f"written_{way}", Parts(model, arithmetic, way), tmp_path / way
        folder.mkdir()
        written(folder, design_of(parts, way, source(parts, way, name), record).texts)
        subprocess.run(["cc", *STRICT, f"-I{ROOT / 'include'}", f"-I{ROOT / 'src' / 'fixed_size'}", f"-I{folder}",
                        str(folder / f"{name}.c"), str(tmp_path / "main.c"),
                        *objects(f"filter_{arithmetic}", f"steady_{arithmetic}"), "-lm", "-o", str(folder / "run")],
                       check=True)
        assert subprocess.run([str(folder / "run")], capture_output=True, text=True).stdout == "the same words\n", way


@pytest.mark.parametrize("seed", first(1, range(3)))
def test_a_predict_of_any_dt_is_the_host_s_at_its_times(seed, tmp_path):
    """kalmanq design --any-dt: a cart with friction and a push, steps of 1 ms to 1 s"""
    path, draws = tmp_path / "cart.toml", np.random.default_rng(seed)
    path.write_text("[model]\nF = [[0.0, 1.0], [0.0, -0.5]]\nB = [0.0, 2.0]\nQc = [0.0, 0.3]\ndt = 0.1\nH = [1.0, 0.0]\nR = 0.04\n"
                    "P0 = [4.0, 1.0]\n[states]\nranges = [100, 10]\n[measurements]\nranges = [100]\n[controls]\nranges = [9]\n")
    succeeds("design", path, "--core", "m4f", "--any-dt", "--out", tmp_path)
    firmware = Firmware.designed(tmp_path, path, "f32", any_dt=True)
    dt, u, z = 10.0 ** draws.uniform(-3, 0, 60), draws.normal(size=(60, 1)), draws.normal(size=(60, 1))
    dt[20:30] = dt[20]
    times = np.concatenate([[0], np.cumsum(dt[1:])])
    run = Filter(model_file.read(path), "f64").run(z, u, times=times)
    for t in range(60):
        assert t == 0 or firmware.call("predict", u[t - 1], float(dt[t])) == 0
        assert firmware.call("update", z[t], 1) == 0
        mean, sigma = firmware.reading(2)
        assert np.abs((mean - run.mean[t]) / run.sigma[t]).max() < 1e-4 and np.abs(sigma / run.sigma[t] - 1).max() < 1e-5
    assert [firmware.call("predict", u[0], one) for one in (0.0, -1.0)] == [lib.KQ_ERR_RANGE] * 2


@pytest.mark.parametrize("text, more, said", [
    ("A = 1\nQ = 1", (), "is of steps that are all alike"), ("F = [[0.0]]\nQc = 1\ndt = 1", ("--arith", "q31"), "in f32 and as init")])
def test_who_has_no_predict_of_any_dt(text, more, said, tmp_path):
    (tmp_path / "level.toml").write_text(f"[model]\n{text}\nH = 1\nR = 1\nP0 = 1\n")
    refused(kalmanq("design", tmp_path / "level.toml", "--core", "m4f", "--any-dt", *more), ("--any-dt", said))


CONVERTED = """
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include "written.h"
int main(int count, char **given)
{
    for (int k = 1; k < count; k++) {
        const double value = strtod(given[k], 0);
        const int32_t raw = WRITTEN_Z_POSITION_RAW(value), small = WRITTEN_TILT_RAW((float)value);
        printf("%ld %ld %.17g %.17g\\n", (long)raw, (long)small, WRITTEN_Z_POSITION_VALUE(raw), WRITTEN_TILT_VALUE(small));
    }
    if (WRITTEN_Z_POSITION_RANGE != 500.0 || WRITTEN_TILT_RANGE != 0.1 || WRITTEN_U_PUSH_RANGE != 1e12) return 1;
    int32_t z[WRITTEN_MEASUREMENTS] = {WRITTEN_Z_POSITION_RAW(NAN)}, u[WRITTEN_CONTROLS] = {WRITTEN_U_PUSH_RAW(0)};
    if (written_init() || written_update(z, WRITTEN_ALL) != KQ_ERR_RANGE) return 2;
    z[0] = WRITTEN_Z_POSITION_RAW(500.1);
    if (written_update(z, WRITTEN_ALL) != KQ_ERR_RANGE) return 3;
    z[0] = WRITTEN_Z_POSITION_RAW(100);
    if (written_update(z, WRITTEN_ALL) || written_step(u, z, WRITTEN_ALL)) return 4;
    return fabs(WRITTEN_POSITION_VALUE(kq_mean_q31(written_filter(), WRITTEN_POSITION)) - 100) < 1 ? 0 : 5;
}
"""


@pytest.mark.parametrize("language, flags", [("c", STRICT), ("c++", [
    "-std=c++11", *(flag for flag in STRICT if not flag.startswith("-std"))])])
def test_values_in_units_and_back(language, flags, tmp_path):
    """The header is C and C++; its macros round, saturate and have no undefined behaviour, at any fraction."""
    model = Model(np.eye(2), H=[[1, 0]], R=1, Q=[1, 1e-6], B=[1e-10, 0], P0=[1e4, 1e-4], states=[
        Quantity("position", range=1000), Quantity("tilt", range=0.1)], measurements=[Quantity("position", range=500)],
        controls=[Quantity("push", range=1e12)], name="written")
    parts = Parts(model, "q31")
    made = source(parts, "lean")
    assert min(parts.fractions("controls")) < 0 and max(parts.fractions("states")) > 31
    (tmp_path / "written.h").write_text(made.header)
    (tmp_path / "written.c").write_text(made.text)
    (tmp_path / "main").write_text(CONVERTED)
    subprocess.run(["cc", *STRICT, f"-I{ROOT / 'include'}", f"-I{tmp_path}", "-c", str(tmp_path / "written.c"), "-o",
                    str(tmp_path / "written.o")], check=True)
    subprocess.run(["c++" if language == "c++" else "cc", *flags, "-fsanitize=undefined", "-fno-sanitize-recover=all",
                    f"-I{ROOT / 'include'}", f"-I{tmp_path}", "-x", language, str(tmp_path / "main"), "-x", "none",
                    str(tmp_path / "written.o"), *objects("filter_q31", "steady_q31"), "-lm", "-o",
                    str(tmp_path / "run")], check=True)
    values = [0.0, 1.5, -499.999, 0.1, -1 / 3, 2.0**-40, -0.4999, 1e30, -1e30, math.inf, -math.inf, math.nan, 1e-300]
    done = subprocess.run([str(tmp_path / "run"), *map(repr, values)], capture_output=True, text=True)
    assert done.returncode == 0, (done.returncode, done.stderr)
    end, no_word = 2**31 - 1, -(2**31)
    for value, line in zip(values, done.stdout.splitlines()):
        for k, fraction in ((0, parts.fractions("measurements")[0]), (1, parts.fractions("states")[1])):
            given = float(np.float32(value)) if k else value
            raw = int(line.split()[k])
            exact = no_word if math.isnan(given) else max(-end, min(end, given * 2.0**fraction))
            assert raw == exact or abs(raw - exact) <= 0.5, (value, line)
            back = float(line.split()[2 + k])
            assert math.isnan(back) if math.isnan(given) else back == raw * 2.0**-fraction


def test_names_are_identifiers():
    model = Model(np.eye(2), H=[[1, 0]], R=1, Q=np.eye(2), P0=[1, 1], states=["a b", "a-b"], measurements=["3 z"], name="9 for")
    made = source(Parts(model, "f32"), "lean")
    assert made.name == "filter_9_for"
    assert "FILTER_9_FOR_A_B,\n    FILTER_9_FOR_A_B_," in made.header


def test_a_correlated_or_unknown_start_has_its_ways():
    correlated = Model(1, H=[[1], [1]], R=[[1, 0.5], [0.5, 1]], Q=1, P0=1)
    assert ways_of(correlated) == ["init"]
    with pytest.raises(KalmanqError, match="cannot be written as lean: R is correlated"):
        source(Parts(correlated, "f32"), "lean")
    assert ways_of(Model(1, H=1, R=1, Q=1, P0=None)) == ["init", "sizes"]


# ------------------------------------------------------------------------------ ranges and errors


def test_the_reach_has_what_is_between_components():
    """Two gauges of one state that contradict each other: between them the mean is far off."""
    model = Model(1, H=[[1], [1]], R=[1e-4, 1e-4], Q=1e-6, P0=100, states=["level"])
    found = reach(model, [Record(np.array([[0.0, 0.0], [9.0, -9.0]]))])
    assert 3 < found.states[0] <= 4.5 + 0.1 and found.measurements[0] == 9


@pytest.mark.parametrize("models", [12, pytest.param(200, marks=WHOLE)])
def test_random_designs_hold_or_warn(models):
    """Ranges 1.5 times the largest state: on records that were not there when it was designed."""
    random, held, warned = np.random.default_rng(7), 0, 0
    for k in range(models):
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
    assert held >= 3 * models / 4, (held, warned)


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
        with_ranges(Model(1, H=1, R=1, Q=1, P0=1, states=["level"]), [])
    ranged, notes = with_ranges(Model(0.5, H=1, R=1, Q=0.75, P0=1), [])
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


@pytest.mark.parametrize("seed, others", first(1, ((1000, 10), (1000, 40), (1001, 40), (1002, 40))))
def test_ranges_of_one_record_hold_others(seed, others):
    """640 of 16 products, every day 160: none saturates, none is refused by a range"""
    for make in PRODUCTS:
        model = bare(make())
        ranged, _ = with_ranges(model, [drawn(model, seed)])
        parts = Parts(ranged, "q31")
        for other in range(others):
            record = drawn(model, other)
            run = Filter(ranged, "q31", parts=parts).run(record.z, record.u)
            assert not run.events & (lib.KQ_EVENT_SATURATED | lib.KQ_EVENT_OVERFLOW), (make, other)


def test_ranges_hold_the_prior():
    """Of a record that begins near x0, where the next one need not"""
    model = Model(1, H=1, R=1.0, Q=0.1, P0=1e4, states=["level"], measurements=["z"])
    ranged, notes = with_ranges(model, [Record(np.zeros((200, 1)))])
    assert min(ranged.states[0].range, ranged.measurements[0].range) > 6 * 100
    assert re.fullmatch(r"level: a range of \S+ was chosen; the model \S+ in 10000 rows \(farther: a "
                        r"chance of 1e-06\); it wanders, and goes farther later: declare what bounds it", str(notes[0])), notes


@lru_cache(None)
def farthest(steps):
    """The largest variances of each product's states within so many steps, all products at once"""
    models = [bare(make()) for make in PRODUCTS]
    n = max(model.n for model in models)
    A, P, Q = (np.array([np.pad(getattr(model, name), (0, n - model.n)) for model in models]) for name in ("A", "P0", "Q"))
    most = np.einsum("kii->ki", P).copy()
    for _ in range(steps):
        P = A @ P @ A.swapaxes(1, 2) + Q
        np.fmax(most, np.einsum("kii->ki", P), out=most)
    return dict(zip(PRODUCTS, most))


@pytest.mark.parametrize("steps", (1, 1000, 30_000))
def test_a_life_is_as_its_covariance_says(steps):
    """Row by row, of what grows, swings and fades"""
    for make in PRODUCTS:
        model = bare(make())
        most = farthest(steps)[make][:model.n]
        life = life_of(model.changed(B=None, controls=None), [], max(steps, 10_000))
        least = tail(life.rows * (model.n + model.m)) * np.sqrt(most)
        assert np.all(life.reach[:model.n] >= least * (1 - 1e-9))
        if model.name != "load_cell":  # of a long life only, beside its prior
            assert life.wanders.any() == (model.name not in ("battery", "anemometer", "spring", "oven"))


def test_only_what_wanders_is_said_to():
    """A model with controls that fade does not, and needs no data"""
    model = Model([[0.9, 0.1], [0, 0.8]], H=[1, 0], R=1, Q=[0.1, 0.1], B=[0, 1], P0=[1, 1], controls=[Quantity("u", range=3)])
    ranged, notes = with_ranges(model, [])
    assert all(one.range for one in (*ranged.states, *ranged.measurements)) and "wander" not in "".join(map(str, notes))
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
    model = Model(1.5, H=1, R=1, Q=1, P0=1)
    ranged, notes = with_ranges(model, [Record(np.full((50, 1), 4.0))])
    assert ranged.states[0].range < 15 and "the model grows without end: the range comes from the data alone" in str(notes[0])


@lru_cache(None)
def tried(make):
    model, _ = with_ranges(make(), [drawn(make(), 1)])
    return model, design(model, LARGE, [drawn(model, 1)]).trials


@pytest.mark.parametrize("arithmetic", ("f32", "q31"))
def test_the_reading_that_the_header_names_keeps_its_figure(arithmetic):
    """kq_mean without its low part, in every run on records that were not there"""
    runs, beyond, shares = 0, 0, []
    for make in (*five.FIVE, *PRODUCTS):
        model, trials = tried(make)
        trial = trials[arithmetic]
        if not trial.is_good:
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
            assert np.nanmax(np.abs(mean - run.mean) / exact.sigma) <= trial.reading.low * (1 + 1e-9), make
            error = np.nanmax(np.abs(mean - exact.mean) / exact.sigma)
            assert error <= trial.reading.within, (make, seed)
            runs, beyond = runs + 1, beyond + (error > trial.worst.max())
            shares.append(error / trial.reading.within)
    assert runs > 100 and beyond > 0.4 * runs  # what was printed before: without what the reading loses
    assert np.median(shares) > 0.05 and max(shares) > 0.3  # it is no figure that holds whatever happens


def test_the_header_and_json_say_what_the_reading_is_off(tmp_path):
    done = kalmanq("design", EXAMPLES / "track.toml", "--core", "m3", "--arith", "q31", "--way", "init", "-o", tmp_path, "--json")
    whole = json.loads(done.stdout)
    told = whole["trials"]["q31"]["kq_mean"]
    assert [(one["arithmetic"], one["way"]) for one in whole["ways"]] == [("q31", "init")] and whole["compiled"] == []  # no other is looked at
    text = " ".join((tmp_path / "track.h").read_text().replace("\n *", "").split())
    said = re.search(r"kq_mean_q31 alone is within (\S+) sigma of double's mean while states are within their ranges. Its 32 "
                     r"bits lose (\S+) at most, which kq_mean_low_q31 has. The rest is (\S+) times the largest error of "
                     r"(\d+) rows, (\S+): the ranges are up to", text)
    assert said and int(said[4]) == told["rows"] > 1000
    for k, name in ((1, "within"), (2, "low"), (3, "times"), (5, "seen")):
        assert told[name] <= float(said[k]) <= 1.11 * told[name]
    assert told["within"] == pytest.approx(told["low"] + told["times"] * told["seen"])


def test_page_header_and_json_say_life_and_chance(tmp_path):
    (tmp_path / "level.toml").write_text("[model]\nA = 1.0\nH = 1.0\nR = 1.0\nQ = 0.1\nP0 = 1e4\n")
    (tmp_path / "z.csv").write_text("z1\n" + "\n".join(f"{np.sin(row / 9):.3f}" for row in range(200)))
    options = ("design", tmp_path / "level.toml", "--core", "m3", "--data", tmp_path / "z.csv", "--arith", "q31")
    done = kalmanq(*options, "--way", "init", "-o", tmp_path)
    header = " ".join((tmp_path / "level.h").read_text().replace("\n *", "").split())
    kalmanq(*options, "--way", "compiled", "-o", tmp_path)
    compiled = " ".join((tmp_path / "level_report.txt").read_text().split())
    for text in (" ".join(done.stdout.split()), header, compiled):
        assert re.search(r"x1: a range of 1100 was chosen; the data reach \S+, the model 6\d\d in 10000 rows \(farther: a chance "
                         r"of 1e-06\); it wanders, and goes farther later: declare what bounds it", text), text
    chosen = json_of(*options)["chosen_ranges"]
    assert [(one["name"], one["range"], one["rows"], one["chance"], one["wanders"]) for one in chosen] == [
        ("x1", 1100, 10000, 1e-6, True), ("z1", 1100, 10000, 1e-6, True)]


def test_a_life_is_no_longer_than_q31_is_accurate_with():
    """Nor shorter than the record: a velocity that wanders for 10000 rows took q31 its accuracy"""
    made = next(make for make in PRODUCTS if make.__name__ == "ultrasound")
    model = bare(made())
    ranged, chosen = with_ranges(model, [drawn(model, 1000)])
    assert {one.rows for one in chosen} == {2000} and ranged.states[0].range < 1e4
    assert with_ranges(model, [drawn(model, 1000)], life=10_000)[0].states[0].range > 1e4
    assert design(ranged, LARGE, [drawn(model, 1000)]).trials["q31"].is_good
    assert with_ranges(model, [drawn(model, 1000)], life=0)[0].states[0].range < 200  # the record alone


def test_saturating_ranges_are_warned_of():
    model = Model(1, H=1, R=1e-4, Q=1.0, P0=1, states=[Quantity("level", range=4)], measurements=[Quantity("z", range=1e6)])
    records = [type(draw(model)[0])(np.cumsum(np.full((400, 1), 0.5), axis=0))]
    trial = design(model, LARGE, records).trials["q31"]
    assert not trial.is_good and trial.warnings


# ------------------------------------------------------------------------------ lean or not


def velocity(q=0.1, R=0.01, n=2, **given):
    """Position, velocity, ...; after 30 rows without a measurement R < 2^-16 S"""
    A, Q = np.eye(n) + np.eye(n, k=1), np.zeros((n, n))
    Q[-2:, -2:] = q * np.array([[1 / 3, 1 / 2], [1 / 2, 1]])
    return Model(A, R=R, Q=Q, P0=np.ones(n), name="velocity", **{
        "H": np.eye(1, n), "states": [Quantity(f"x{i}", range=1e6) for i in range(n)],
        "measurements": [Quantity(f"z{c}", range=4e6) for c in range(np.size(R))], **given})


def three(H, **given):
    return velocity(H=H, R=[0.01] * len(H), n=3, **given)


@pytest.mark.parametrize("model, why", [
    (velocity(R=0.0), "R of z0 is 0 (2^-120 or less), which init and sizes take"),
    (velocity(H=np.eye(2), R=[1.0, 1e-40]), "R of z1 is 0 (2^-120 or less)"),
    (velocity(H=np.eye(2), R=[[1, 0.5], [0.5, 1]], measurements=["a", "b"]), "R is correlated, which init takes"),
    (velocity(unknown=[0]), "the start is unknown, which init and sizes take"),
    (three([[1, 0, 0], [0, 1, 0], [1, 0, 0]]), "the row of H of z2 repeats others: the full sensor finds what is redundant"),
    (three([[1 / 3, 0.1, 0], [-1, -0.3, 0], [0, 0, 1]]), "the row of H of z1 repeats others"),
    (three([[1, 2, 3], [1, 0, -1], [0, 1, 2], [1, 1, 1]]), "the row of H of z2 repeats others"),
    (three([[1, 0, 0], [1, 1e-3, 0]]), ""), (three([[1, 0, 0], [1, 1e-9, 0], [0, 1e-9, 1]]), ""),
    (three([[1e-9, 1e9, 1], [1e-9, 1e9, 2]]), ""), (velocity(gaps=Gaps(30, 10)), ""), (velocity(R=1e-9), ""),
    (Model(1.5, H=1, R=1, Q=1, P0=1, states=[Quantity("x", range=1e6)], measurements=[Quantity("z", range=1e6)]), "")])
def test_lean_is_offered_unless_R_is_0_or_rows_repeat(model, why):
    assert not_lean(model).startswith(why) and bool(not_lean(model)) == bool(why)
    assert ("lean" in ways_of(model)) == (not why) and (ways_of(model)[0] == "lean") == (not why)
    assert ("tables" in ways_of(model)) == (not why or "repeats" in why)


@pytest.mark.parametrize("models", [20, pytest.param(40, marks=WHOLE)])
def test_random_lean_designs_are_as_good_as_full_ones(models):
    """The lean filter is tried where measurements have low noise."""
    random, low = np.random.default_rng(23), 0
    for k in range(models):
        given = {"q": 10.0 ** random.uniform(-3, 3), "R": 10.0 ** random.uniform(-4, 1)}
        model, z = velocity(**given, n=int(random.integers(2, 5)), gaps=Gaps(100, 100)), np.zeros((300, 1))
        z[100:200] = np.nan
        made = design(model, LARGE, [Record(z)])
        low += min(given["R"] / one**2 for one in Filter(model, "f64").run(z).innovation_sigma[200:201, 0]) < 2.0**-16
        for one in made.ways:
            assert one.way != "lean" or one.trial.is_good or not made.trials[one.arithmetic].is_good, (k, one)
        assert {one.arithmetic for one in made.ways if one.way == "lean"} == set(made.trials), k
    assert low >= models / 4


def test_a_lean_way_that_is_worse_than_the_full_one_is_not_recommended(monkeypatch):
    model, run = velocity(), Filter.run
    monkeypatch.setattr(Filter, "run", lambda self, *given, **more: spoilt(run(self, *given, **more), self.parts.sensor.plain == 0))
    made = design(model, LARGE, [Record(np.zeros((300, 1)))])
    assert made.chosen("f32", "lean") is None and made.chosen("f32", "tables").trial is made.trials["f32"]
    (lean,) = [one for one in made.ways if (one.arithmetic, one.way) == ("f32", "lean")]
    assert lean.trial.warnings == ["lean in f32: low noise"]


def spoilt(run, is_lean):
    run.events |= lib.KQ_EVENT_LOW_NOISE if is_lean else 0
    return run


def test_the_page_and_json_say_why_there_is_no_lean(tmp_path):
    model_file_ = saved(tmp_path / "velocity.toml",
                        "[model]\nA = [[1.0, 1.0], [0.0, 1.0]]\nH = [1.0, 0.0]\nR = 0.01\nP0 = [1.0, 1.0]\n"
                        "Q = [[0.0333, 0.05], [0.05, 0.1]]\n[states]\nranges = [1e6, 1e6]\n[measurements]\nranges = [1e6]\n")
    (tmp_path / "z.csv").write_text("z1\n" + "\n".join(f"{np.sin(row / 9):.3f}" for row in range(200)))
    options = ("design", model_file_, "--core", "m0", "--data", tmp_path / "z.csv", "--way", "lean", "-o", tmp_path)
    done = kalmanq(*options, "--arith", "f32")
    assert done.returncode == 0 and "no lean" not in done.stdout and "KQ_SENSOR_LEAN_TABLE_F32" in (tmp_path / "velocity.c").read_text()
    assert json.loads(kalmanq(*options, "--json").stdout)["no_lean"] == ""
    model_file_.write_text(model_file_.read_text().replace("R = 0.01", "R = 0.0"))
    why = "R of z1 is 0 (2^-120 or less), which init and sizes take"
    done = kalmanq(*options)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and done.stderr.strip().endswith(f"lean: {why}")
    assert f"no lean: {why}" in " ".join(done.stdout.split())
    assert json.loads(kalmanq(*options[:6], "--json").stdout)["no_lean"] == why


# ------------------------------------------------------------------------------ the command


@MEASURED
def test_what_does_not_fit_is_said(tmp_path):
    done = kalmanq("design", EXAMPLES / "track.toml", "--core", "m4f", "--way", "init", "--flash", 4, "-o", tmp_path)
    assert done.returncode == 1 and not list(tmp_path.iterdir())
    assert "no way fits 4 kB of flash" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize("arguments, said", [
    (["nowhere.toml", "--core", "m0"], "nowhere.toml: no such file"),
    ([EXAMPLES / "level.toml", "--core", "m0"], "its states wander; give ranges, or `kalmanq design --data`"),
    ([EXAMPLES / "track.toml", "--core", "m0", "--data", "no.csv"], "no.csv: no such file"),
    ([EXAMPLES / "track.toml", "--core", "m0", "-o", "nowhere"], "nowhere: there is no such folder"),
])
def test_wrong_input_is_one_line(arguments, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused(kalmanq("design", *arguments), said)
    assert not list(tmp_path.iterdir())


COUNTS = """
[model]
name = "adc"
A = [[1.0]]
H = [1.0]
Q = [0.04]
R = 4.0
x0 = [512]
P0 = [{variance}]

[states]
names = ["level"]
ranges = [{range}]

[measurements]
names = ["count"]
ranges = [{range}]
fractions = [0]
"""


def counts(folder, variance, range):
    return saved(folder / "adc.toml", COUNTS.format(variance=variance, range=range))


def test_what_is_drawn_has_the_steps_of_its_sensor(tmp_path):
    """An ADC's counts are no error of the filter"""
    path = counts(tmp_path, "'unknown'", 2000)
    model = model_file.read(path)
    record = draw(with_ranges(model, [])[0], 50, [1])[0]
    assert np.array_equal(record.z, np.rint(record.z)) and len(np.unique(record.z)) > 3
    told = json.loads(kalmanq("design", path, "--core", "m3", "--json").stdout)
    assert told["trials"]["q31"]["worst"][0] < 1e-3
    assert all(one["mean"] < 1e-3 for one in told["compiled"]), told["compiled"]


@pytest.mark.parametrize("gaps", [Gaps(3, 9), Gaps(2)])
def test_what_is_drawn_has_the_gaps_of_its_model(gaps):
    z = draw(Model(1, H=1, R=1, Q=1, P0=1, gaps=gaps), 300, [1])[0].z
    rows = [(is_there, len(list(of))) for is_there, of in groupby(~np.isnan(z[:, 0]))][:-1]
    assert {count for is_there, count in rows if not is_there} == {*range(1, gaps.max_gap + 1)}
    assert min(count for is_there, count in rows if is_there) == (gaps.min_run or 1)


@pytest.mark.parametrize("variance, range, code", [(90000, 1100, 0), (1, 500, 1)])
def test_records_that_begin_outside_the_ranges(variance, range, code, tmp_path):
    """Some do, or all"""
    done = kalmanq("design", counts(tmp_path, variance, range), "--core", "m0")
    assert done.returncode == code and "Traceback" not in done.stderr
    assert code == 0 or ("begins outside the declared ranges" in done.stderr and done.stderr.count("\n") == 1)


def test_a_way_that_is_not_offered(tmp_path):
    done = kalmanq("design", counts(tmp_path, 10000, 2000), "--core", "m0", "--way", "sizes")
    said = "sizes is not offered for this model on Cortex-M0: here --way is one of lean, tables, init, compiled"
    assert done.returncode == 1 and said in done.stderr and done.stderr.count("\n") == 1


def test_an_unknown_core_is_a_usage_error():
    assert kalmanq("design", EXAMPLES / "track.toml", "--core", "z80").returncode == 2


def test_a_model_without_ranges_is_no_fixed_point():
    with pytest.raises(ModelError):
        Parts(Model(1, H=1, R=1, Q=1, P0=1), "q31")


@pytest.mark.parametrize("name, states", [
    ("small", ["h", "v"]), ("kq", ["states", "v"]), ("t", ["x", "x_fraction"]), ("t", ["x_raw", "x"]), ("t", ["x_range", "x"]), ("kalmanq/kalmanq", ["all", "b"]),
    ("t", ["*/ int x; /*", "a??/"]), ("stdint", ["a\nb", "ß"]), ("while", ["", " "]), ("main", ["x", "X"])])
@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_any_names_make_c(name, states, arithmetic, tmp_path):
    model = Model(np.eye(2), H=[1, 0], R=1, Q=np.eye(2), P0=[1, 1], name=name, measurements=[Quantity("h", "*/", 9)],
                  states=[Quantity(one, "m/*s", 9) for one in states])
    made = source(Parts(model, arithmetic), "lean")
    (tmp_path / f"{made.name}.h").write_text(made.header, encoding="utf-8")
    (tmp_path / f"{made.name}.c").write_text(made.text, encoding="utf-8")
    done = subprocess.run(["cc", *STRICT, "-Wtrigraphs", f"-I{ROOT / 'include'}", f"-I{tmp_path}", "-c",
                           str(tmp_path / f"{made.name}.c"), "-o", str(tmp_path / "x.o")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr + made.header


def test_a_promise_is_not_rounded_down() -> None:
    assert [no_less(one) for one in (8.5e-7, 8.501e-7, 9.99e-5)] == ["8.6e-07", "8.6e-07", "1.0e-04"]
