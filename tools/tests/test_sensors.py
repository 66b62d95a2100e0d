"""Sensors by name, and files of data that are joined by their times."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command import json_of, kalmanq, refused, rows_of, succeeds
from dense import Steps, conditioned
from firmware_here import Firmware
from library import STRICT, cc, printed, saved
from whole import WHOLE, first

from kalmanq import Consistency, Filter, KalmanqError, NonlinearFilter, NonlinearModel, Robust, Smoother
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.product import compiled
from kalmanq.core import lib
from kalmanq.data import joining, tables
from kalmanq.model import model_file


WALK = """
[model]
F = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -0.5]]
Qc = [0.0, 0.0, 2.0]
dt = 0.0025
P0 = [1.0, 1.0, 1.0]
{more}
[states]
names = ["p", "v", "a"]

[[sensors]]
name = "imu"
measurements = ["acc"]
units = ["m/s^2"]
H = [0.0, 0.0, 1.0]
R = 0.01

[[sensors]]
name = "gps"
measurements = ["pos", "speed"]
H = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
R = [[0.04, 0.01], [0.01, 0.09]]
"""


ONE_LATE = """
[model]
F = 0.0
Qc = 0.1
dt = 0.1
P0 = 10.0
[[sensors]]
name = "a"
H = 1.0
R = 1.0
[[sensors]]
name = "b"
H = 1.0
R = 1.0
delay = 0.6
"""


PUSHED = 'B = [0.0, 0.0, 1.0]\n[controls]\nnames = ["push"]\n'


def walk(folder, *changes, more="", name="walk.toml"):
    """Its file, in which each change (old, new) is made once"""
    text = WALK.format(more=more)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return saved(folder / name, text)


def told_late(delay, more=""):
    """A change: the receiver's rows come so late"""
    return "R = [[0.04", f"delay = {delay}\n{more}R = [[0.04"


def written(folder, name, head, *columns):
    path = folder / name
    rows = zip(*[[one if isinstance(one, str) else "" if np.isnan(one) else f"{one:.17g}" for one in column] for column in columns])
    path.write_text("\n".join([head, *map(",".join, rows)]) + "\n")
    return path


def two_rates(folder, seed: int, seconds: float = 0.4):
    """An inertial sensor at 400 Hz and a receiver at 10 Hz, each with jitter; some instants are common"""
    draw = np.random.default_rng(seed)
    fast = np.round(0.0025 * np.arange(int(400 * seconds)) + draw.uniform(0, 0.001, int(400 * seconds)), 6)
    slow = np.round(0.013 + 0.1 * np.arange(int(10 * seconds)) + draw.uniform(0, 0.02, int(10 * seconds)), 6)
    slow[1] = fast[np.argmin(np.abs(fast - slow[1]))]
    acc, pos, speed = draw.normal(size=len(fast)), draw.normal(size=len(slow)), draw.normal(size=len(slow))
    speed[-1] = np.nan
    imu = written(folder, "imu.csv", "t [s],acc", [f"{one:.6f}" for one in fast], acc)
    gps = written(folder, "gps.csv", "time_us,speed [m/s],pos", [f"{one * 1e6:.0f}" for one in slow], speed, pos)
    times = np.union1d(fast, slow)
    z = np.full((len(times), 3), np.nan)
    z[np.searchsorted(times, fast), 0] = acc
    z[np.searchsorted(times, slow), 1], z[np.searchsorted(times, slow), 2] = pos, speed
    return imu, gps, times, z


@pytest.mark.parametrize("seed", range(3))
def test_two_rates_with_jitter_beside_the_joint_normal(seed, tmp_path):
    """400 Hz and 10 Hz, from two files, through the command"""
    imu, gps, times, z = two_rates(tmp_path, seed)
    path, out = walk(tmp_path), tmp_path / "out.csv"
    assert succeeds("run", path, imu, gps, "--smooth", "--out", out, "--digits", 17).stderr == ""
    rows = rows_of(out)
    model = model_file.read(path)
    A, Q, _ = model.continuous.steps(np.append(np.diff(times), 1))
    right = conditioned(model.x0, model.P0, Steps(A, None, Q, *(np.tile(one, (len(times), 1, 1)) for one in (model.H, model.R))), z)
    assert np.allclose([float(row["time"]) for row in rows], times - times[0], rtol=0, atol=1e-9)
    for k, name in enumerate("pva"):
        sigma, smoothed = np.sqrt(right.covariance[:, k, k]), np.sqrt(right.smoothed_covariance[:, k, k])
        assert np.abs(([float(row[f"{name}_mean"]) for row in rows] - right.mean[:, k]) / sigma).max() < 1e-7
        assert np.abs(([float(row[f"{name}_smoothed"]) for row in rows] - right.smoothed[:, k]) / smoothed).max() < 1e-7
        assert np.abs([float(row[f"{name}_sigma"]) for row in rows] / sigma - 1).max() < 1e-7
    told = json_of("run", path, gps, imu)
    assert told["log_likelihood"] == pytest.approx(float(right.log_likelihood), rel=1e-8)
    assert told["taken"] == int(np.sum(~np.isnan(z))) and told["rows"] == len(times)


@pytest.mark.parametrize("blocks", [1, 3, 17, 65536])
def test_blocks_of_any_size_are_joined_alike(blocks, tmp_path):
    imu, gps, times, z = two_rates(tmp_path, 7)
    made = list(joining.blocks_of([imu, gps], model_file.read(walk(tmp_path)), blocks))
    assert len(made) > 1 or blocks > 100
    at = np.concatenate([one.times for one in made])
    assert np.allclose(at - at[0], times - times[0], atol=1e-9) and np.all(np.diff(at) > 0)
    got = np.column_stack([np.concatenate([one.columns[name] for one in made]) for name in ("acc", "pos", "speed")])
    assert np.array_equal(got, z, equal_nan=True)


@pytest.mark.usefixtures("no_offers")
def test_a_sensor_that_no_file_has_is_missing(tmp_path):
    imu, gps, times, z = two_rates(tmp_path, 2)
    path = walk(tmp_path)
    told = json_of("run", path, imu)
    right = Filter(model_file.read(path))
    there = np.searchsorted(times, np.genfromtxt(imu, delimiter=",", skip_header=1)[:, 0])
    right.run(np.column_stack([z[there, 0], np.full((len(there), 2), np.nan)]), times=times[there] - times[there[0]])
    assert told["log_likelihood"] == pytest.approx(right.log_likelihood, rel=1e-9)
    for command in (("compare", path, imu, gps), ("report", path, imu, gps, "-o", tmp_path / "r.html")):
        assert succeeds(*command).stderr == ""


def test_a_control_stays_until_the_next_one(tmp_path):
    path = walk(tmp_path, more=PUSHED)
    imu, gps, times, z = two_rates(tmp_path, 3)
    push = written(tmp_path, "push.csv", "t,push", ["0.000000", "0.100000", "0.250000"], [1.0, -2.0, 0.5])
    made = [json_of("run", path, *files, "--time", "t")["log_likelihood"]
            for files in ((push, written(tmp_path, "one.csv", "t,acc", [f"{one:.6f}" for one in times], z[:, 0])),)]
    all_times = np.union1d(times, [0, 0.1, 0.25])
    rows = np.full((len(all_times), 3), np.nan)
    rows[np.searchsorted(all_times, times), 0] = z[:, 0]
    u = np.array([1.0, -2.0, 0.5])[np.searchsorted([0.1, 0.25], all_times, side="right")]
    f = Filter(model_file.read(path))
    f.run(rows, u, times=all_times)
    assert made[0] == pytest.approx(f.log_likelihood, rel=1e-8)
    late = written(tmp_path, "late.csv", "t,push", ["0.2"], [1.0])
    refused(kalmanq("run", path, imu, late), "late.csv: has no push at 0 s")


def test_the_order_of_files_says_nothing_of_what_is_late(tmp_path):
    """The file that begins later given first: measured between the two beginnings"""
    path = walk(tmp_path, told_late(0.12))
    imu = written(tmp_path, "imu.csv", "t,acc", [f"{0.02 + 0.02 * k:.6f}" for k in range(60)], np.arange(60) % 3.0)
    gps = written(tmp_path, "gps.csv", "t,pos,speed", [f"{0.08 + 0.1 * k:.6f}" for k in range(9)], np.arange(9.0), np.arange(9.0))
    made = [json_of("run", path, *files) for files in ((imu, gps), (gps, imu))]
    assert made[0]["taken"] == made[1]["taken"] == 60 + 2 * 8 and made[0]["log_likelihood"] == pytest.approx(made[1]["log_likelihood"], rel=1e-12)


def test_a_fitted_file_keeps_sensors_and_delays(tmp_path):
    path = walk(tmp_path, told_late(0.12), ("dt = 0.0025", "dt = 0.02"))
    succeeds("simulate", path, "-n", "150", "--seed", "4", "--out", tmp_path / "log.csv")
    done = kalmanq("fit", path, tmp_path / "log.csv", "--free", "Q,R", "--hold", "Q[0,*],Q[1,*]", "-o", tmp_path / "found.toml", "--json")
    found, told = model_file.read(tmp_path / "found.toml"), json.loads(done.stdout)
    assert [one.delay for one in found.sensors] == [0, 0.12] and found.continuous.dt == 0.02 and not np.any(found.R[0, 1:])
    assert found.R[1, 2] != 0  # of one sensor
    ran = json_of("run", tmp_path / "found.toml", tmp_path / "log.csv")
    assert ran["log_likelihood"] == pytest.approx(told["log_likelihood"], rel=1e-6)


def test_a_fit_joins_the_files_of_sensors_to_records(tmp_path):
    """The log-likelihood of one evaluation, at the model's own values, is that of the runs"""
    path, rng = walk(tmp_path), np.random.default_rng(3)
    pairs = []
    for day in "ab":
        imu = written(tmp_path, f"imu_{day}.csv", "t,acc", [f"{0.02 * k:.6f}" for k in range(60)], rng.normal(size=60))
        gps = written(tmp_path, f"gps_{day}.csv", "t,pos,speed", [f"{0.1 * k:.6f}" for k in range(12)], *rng.normal(size=(2, 12)))
        pairs.append((imu, gps))
    ran = [json_of("run", path, *pair)["log_likelihood"] for pair in pairs]
    for files, expected in ((pairs[0], ran[0]), (pairs[0][::-1], ran[0]), (pairs[0] + pairs[1], sum(ran))):
        done = kalmanq("fit", path, *files, "--free", "R", "--method", "ml", "--iterations", "1", "--json")
        told = json.loads(done.stdout)
        assert told["course"][0] == pytest.approx(expected, rel=1e-8), done.stderr
        assert told["records"] == [list(map(str, files[k : k + 2])) for k in range(0, len(files), 2)]
    done = kalmanq("fit", path, *pairs[0], *pairs[1], "--free", "R", "--method", "ml", "--iterations", "1")
    assert done.stdout.startswith(f"2 records: {pairs[0][0]} + {pairs[0][1]}; {pairs[1][0]} + {pairs[1][1]}\nlog")
    os.mkfifo(pipe := tmp_path / "pipe")
    for given, name in (("-", "standard input"), (pipe, str(pipe))):
        refused(kalmanq("fit", path, pairs[0][0], given, input=pairs[0][1].read_text()),
                f"kalmanq: {name}: is one of several, which are read twice: write it to a file\n")


def test_files_of_steps_are_records_and_a_file_of_controls_is_a_part_of_one(tmp_path):
    imu, gps = written(tmp_path, "imu.csv", "acc", np.arange(9.0)), written(tmp_path, "gps.csv", "pos,speed", np.arange(9.0), np.arange(9.0))
    steps = saved(tmp_path / "steps.toml", '[model]\nA = [[1, 1, 0], [0, 1, 1], [0, 0, 1]]\nQ = [0, 0, 1]\nP0 = [1, 1, 1]\n' + "".join(
                              f'[[sensors]]\nname = "{name}"\nmeasurements = {columns}\nH = {H}\nR = {R}\n' for name, columns, H, R in (
                                  ("imu", '["acc"]', "[0, 0, 1]", "1"), ("gps", '["pos", "speed"]', "[[1, 0, 0], [0, 1, 0]]", "[1, 1]"))))
    assert [list(map(str, one)) for one in joining.records_of([imu, gps], model_file.read(steps))] == [[str(imu)], [str(gps)]]
    wrong = written(tmp_path, "wrong.csv", "other", np.arange(9.0))
    refused(kalmanq("fit", steps, imu, wrong), f"kalmanq: {wrong}: there is no column", told=1)
    path, times = walk(tmp_path, more=PUSHED), ["0", "0.1"]
    files = [written(tmp_path, name, columns, times, *np.zeros((count, 2))) for name, columns, count in (
        ("push.csv", "t,push", 1), ("at.csv", "t,acc", 1), ("where.csv", "t,pos,speed", 2))]
    assert [list(map(str, one)) for one in joining.records_of([*files, *files[1:]], model_file.read(path))] == [
        list(map(str, files)), list(map(str, files[1:]))]


REFUSED = [
    (lambda f: [written(f, "a.csv", "acc", [1.0]), written(f, "b.csv", "t,pos,speed", ["0"], [1.0], [1.0])],
     "a.csv: .*--time"),
    (lambda f: [written(f, "a.csv", "t,acc", ["0"], [1.0]), written(f, "b.csv", "t,acc", ["0"], [1.0])],
     "column acc .*a.csv .*b.csv"),
    (lambda f: [written(f, "a.csv", "t,acc", ["0"], [1.0]), written(f, "b.csv", "t,pos", ["0"], [1.0])],
     "speed .*gps"),
    (lambda f: [written(f, "a.csv", "t,x", ["0"], [1.0])], "sensor: acc, pos, speed"),
    (lambda f: [written(f, "a.csv", "t,acc", ["0"], [1.0]), written(f, "b.csv", "t,x", ["0"], [1.0])],
     "b.csv: .*acc, pos, speed .--rename acc="),
    (lambda f: [written(f, "a.csv", "t,acc", ["0"], [1.0]), written(f, "b.csv", "t,pos,speed", ["2024-01-01"], [1.0], [1.0])],
     "b.csv: row 2, column t: .*dates, .*numbers"),
    (lambda f: [written(f, "a.csv", "t,acc", ["0", "1"], [1.0, 2.0]),
                written(f, "b.csv", "t,pos,speed", ["0", "7"], [1.0] * 2, [1.0] * 2)],
     "unit .* is 1, dt is 0.0025"),
    (lambda f: [written(f, "a.csv", "t [s],acc", ["0", "0.0025"], [1.0, 2.0]),
                written(f, "b.csv", "t,pos,speed", ["0", "100"], [1.0] * 2, [1.0] * 2)],
     "b.csv: column t: .*unit .* is 100"),
    (lambda f: [written(f, "a.csv", "t [s],acc", ["0", "1", "0.5"], [1.0] * 3),
                written(f, "b.csv", "t [s],pos,speed", ["0"], [1.0], [1.0])],
     "a.csv: row 4, column t .s.: .*back"),
]


@pytest.mark.parametrize("make, said", REFUSED)
def test_files_that_cannot_be_joined(make, said, tmp_path):
    path, files = walk(tmp_path), make(tmp_path)
    with pytest.raises(KalmanqError, match=said):
        joining.record(files, model_file.read(path))
    refused(kalmanq("run", path, *files), "")


def test_an_error_of_joined_rows_names_its_time(tmp_path):
    path = walk(tmp_path, more=PUSHED)
    a = written(tmp_path, "a.csv", "t [s],acc", ["0", "0.1", "0.2"], [1.0, 2.0, 1e300])
    b = written(tmp_path, "b.csv", "t [s],push", ["0", "0.15"], [1.0, 2.0])
    for more in ((), ("--smooth",)):
        refused(kalmanq("run", path, a, b, "--arith", "f32", *more), ("at 0.2 s: acc = 1e+300", "a.csv, "), told=bool(more))


def test_steps_are_not_joined(tmp_path):
    path = saved(tmp_path / "steps.toml", "[model]\nA = 1\nH = 1\nQ = 1\nR = 1\nP0 = 1\n[measurements]\nnames = ['z']\n")
    data = written(tmp_path, "z.csv", "t,z", ["0", "1"], [1.0, 2.0])
    refused(kalmanq("run", path, data, data), "several files are joined by their times: of a linear model with F, Qc and dt")


def test_sensors_are_one_below_the_other(tmp_path):
    model = model_file.read(walk(tmp_path))
    assert np.array_equal(model.H, [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    assert np.array_equal(model.R, [[0.01, 0, 0], [0, 0.04, 0.01], [0, 0.01, 0.09]])
    assert [one.name for one in model.sensors] == ["imu", "gps"] and model.measurements[0].unit == "m/s^2"
    copy = saved(tmp_path / "copy.toml", model_file.text_of(model))
    again = model_file.read(copy)
    assert "[[sensors]]" in copy.read_text() and again.sensors == model.sensors and again.measurements == model.measurements
    assert all(np.array_equal(getattr(again, name), getattr(model, name)) for name in "AQHR")
    mixed = model.changed(R=model.R + 0.001)
    assert "[[sensors]]" not in model_file.text_of(mixed) and len(mixed.sensors) == 2
    z = np.random.default_rng(1).normal(size=(20, 3))
    assert np.array_equal(Smoother(model).run(z).smoothed, Smoother(again).run(z).smoothed)


def test_sensors_of_a_model_of_steps(tmp_path):
    path = tmp_path / "steps.toml"
    path.write_text("[model]\nA = 1\nQ = 1\nP0 = 1\n[[sensors]]\nname = 'a'\nH = 1\nR = 1\n[[sensors]]\nname = 'b'\nH = 2\nR = 1\n")
    data = written(tmp_path, "z.csv", "b", [1.0, 2.0, 3.0])
    told = json_of("run", path, data)
    f = Filter(model_file.read(path))
    f.run([[np.nan, 1], [np.nan, 2], [np.nan, 3]])
    assert told["log_likelihood"] == f.log_likelihood and told["taken"] == 3


def test_files_of_two_time_zones_are_joined_by_the_instants(tmp_path):
    times = np.datetime64("2024-03-01T10:00:00.000") + np.arange(5) * np.timedelta64(10, "ms")
    made = {zone: written(tmp_path, f"gps{k}.csv", "time,pos,speed", [str(one + np.timedelta64(hours, "m")) + zone for one in times[::2]],
                          [1.0, 2, 3], [4.0, 5, 6]) for k, (zone, hours) in enumerate((("Z", 0), ("+05:30", 330), ("-08:00", -480), ("", 0)))}
    imu, model = written(tmp_path, "imu.csv", "time,acc", [f"{one}Z" for one in times], [0.0] * 5), model_file.read(walk(tmp_path))
    z, _, at = joining.record([imu, made["Z"]], model)
    assert len(at) == 5 and np.array_equal(z[:, 1], [1, np.nan, 2, np.nan, 3], equal_nan=True)
    for zone in ("+05:30", "-08:00"):
        again, _, then = joining.record([imu, made[zone]], model)
        assert np.array_equal(again, z, equal_nan=True) and np.array_equal(at, then)
    with pytest.raises(KalmanqError, match="gps3.csv: row 2, column time: .*zone, .*UTC"):
        joining.record([imu, made[""]], model)


def late_log(folder, seed, delay):
    """One log with both sensors, the receiver's rows `delay` late; and the two files in which nothing was late"""
    imu, gps, _, _ = two_rates(folder, seed)
    (_, *fast), (_, *slow) = (list(csv.reader(one.open())) for one in (imu, gps))
    told = {int(row[0]) + round(delay * 1e6): row[1:] for row in slow}
    rows = {round(float(row[0]) * 1e6): [row[1], "", ""] for row in fast}
    for at, (speed, pos) in told.items():
        rows.setdefault(at, ["", "", ""])[1:] = [pos, speed]
    log = saved(folder / "log.csv", "\n".join(["time_us,acc,pos,speed", *(",".join([str(at), *rows[at]]) for at in sorted(rows))]) + "\n")
    first = int(1e6 * float(fast[0][0]))
    gps.write_text("\n".join(["time_us,speed,pos", *(",".join(row) for row in slow if int(row[0]) >= first)]) + "\n")
    return log, imu, gps


@pytest.mark.parametrize("seed, delay", [(0, 0.12), (1, 0.0371), (2, 1e-6)])
@pytest.mark.parametrize("blocks", [1, 17, 65536])
def test_what_is_told_late_is_in_the_row_that_it_was_measured_at(seed, delay, blocks, tmp_path):
    log, imu, gps = late_log(tmp_path, seed, delay)
    model = model_file.read(walk(tmp_path))
    late = walk(tmp_path, told_late(delay))
    assert model_file.read(late).sensors[1].delay == delay and f"delay = {delay}" in model_file.text_of(model_file.read(late))
    right, made = (tables.joined(list(joining.blocks_of(data, of, blocks)))
                   for data, of in (([imu, gps], model), (log, model_file.read(late))))
    is_there = np.any([~np.isnan(one) for one in made.columns.values()], axis=0)  # a row that only told what was late is a step
    assert np.allclose(made.times[is_there], right.times, rtol=0, atol=1e-9)
    assert all(np.array_equal(made.columns[name][is_there], right.columns[name], equal_nan=True) for name in made.columns)


@pytest.mark.parametrize("seed", range(3))
def test_a_column_says_when_each_was_measured(seed, tmp_path):
    """0 to 300 ms before it is told, these two among them, in any order: equal to the files in which nothing was late"""
    imu, gps, _, _ = two_rates(tmp_path, seed)
    _, imu, gps = late_log(tmp_path, seed, 0.0)
    (_, *fast), (_, *slow), draw = *(list(csv.reader(one.open())) for one in (imu, gps)), np.random.default_rng(seed)
    rows = {round(float(row[0]) * 1e6): [row[1], "", "", ""] for row in fast}
    for at, speed, pos in slow:
        told = int(at) + int(np.clip(draw.integers(-50_000, 350_000), 0, 300_000))
        rows.setdefault(told, ["", "", "", ""])[1:] = [pos, speed, at]
    log, names = tmp_path / "own.csv", "time_us,acc,pos,speed,gps_us"
    log.write_text("\n".join([names, *(f"{at},{','.join(rows[at])}" for at in sorted(rows))]) + "\n")
    path, late = walk(tmp_path), walk(tmp_path, told_late(0.3, "measured = 'gps_us'\n"), name="late.toml")
    assert model_file.text_of(model_file.read(late)).count("measured = ") == 1
    ran = [json_of("run", model, *data) for model, data in ((path, (imu, gps)), (late, (log,)))]
    assert ran[1]["log_likelihood"] == pytest.approx(ran[0]["log_likelihood"], rel=1e-12) and ran[1]["taken"] == ran[0]["taken"]
    whole, made = (tables.joined(list(joining.blocks_of(log, model_file.read(late), blocks))) for blocks in (65536, 7))
    assert np.array_equal(whole.times, made.times)
    assert all(np.array_equal(whole.columns[name], made.columns[name], equal_nan=True) for name in whole.columns)
    first = slow[0][0]
    for old, new, said in ((f",{first}\n", ",\n", "the time that it was measured at is missing"), (f",{first}\n", f",{int(first) + 10**6}\n", "is after the row's time"),
                           (f",{first}\n", f",{int(first) - 10**6}\n", "is more than 0.3 s before"), ("gps_us", "gps_ms", "gps_us")):
        bad = saved(tmp_path / "bad.csv", log.read_text().replace(old, new, 1))
        refused(kalmanq("run", late, bad), said)


RANGES = (("]\nunits", "]\nranges = [60]\nunits"), ("R = [[0.04", "ranges = [1000, 100]\nR = [[0.04"), ('"a"]', '"a"]\nranges = [1000, 100, 50]'))


@pytest.mark.parametrize("seed", first(1, range(3)))
def test_the_firmware_of_design_takes_what_is_late(seed, tmp_path):
    """400 Hz with jitter, and 10 Hz that tells 120 ms late: the C file, by a function a sensor, beside the host's run of the log"""
    log, _, _ = late_log(tmp_path, seed, 0.12)
    path = walk(tmp_path, told_late(0.12), *RANGES)
    told = json_of("run", path, log)
    sigma, firmware = np.sqrt(np.diag(told["covariance"])), Firmware.designed(tmp_path, path, "f32", any_dt=True)
    steps, measured, late = instants(log, 120_000)
    for k, now in enumerate(steps):
        assert k == 0 or firmware.call("predict", float((now - steps[k - 1]) * 1e-6)) == 0
        if now in measured:
            assert firmware.call("update_imu", measured[now], 1) == 0
        if now - 120_000 in late:
            z = late[now - 120_000]
            assert firmware.call("update_gps", np.nan_to_num(z), int((~np.isnan(z)) @ [1, 2]), k - steps.index(now - 120_000)) == 0
    mean, spread = firmware.reading(3)
    assert np.abs((mean - told["mean"]) / sigma).max() < 1e-4 and np.abs(spread / sigma - 1).max() < 1e-5
    assert firmware.call("update_gps", np.zeros(2), 3, 1000) != 0


@pytest.mark.parametrize("T", first(1, ["f32", "q31"]))
def test_the_c_of_compile_has_a_function_a_sensor(T, tmp_path):
    """Beside update_some, to the bit; and the events of a number that is none"""
    path = walk(tmp_path, ("F = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -0.5]]\nQc = [0.0, 0.0, 2.0]\ndt = 0.0025",
                           "A = [[1, 0.1, 0], [0, 1, 0.1], [0, 0, 0.9]]\nQ = [1e-6, 1e-6, 0.01]"), *RANGES)
    succeeds("compile", path, "--arith", T, "-o", tmp_path / "walk.c")
    saved(tmp_path / "main.c", ONE_BY_ONE.replace("WORD", "int32_t" if T == "q31" else "float").replace("SCALE", "65536" if T == "q31" else "1"))
    cc("cc", *STRICT, "walk.c", "main.c", "-lm", "-o", "main", folder=tmp_path)
    printed(tmp_path / "main")


ONE_BY_ONE = """#include <string.h>
#include "walk.h"
int main(void)
{
    walk_filter one, other;
    memset(&one, 0, sizeof one), memset(&other, 0, sizeof other);
    walk_start(&one), walk_start(&other);
    for (int t = 0; t < 200; t++) {
        const WORD z[3] = {(WORD)(t % 7 * SCALE), (WORD)(t % 5 * SCALE), (WORD)(-t % 3 * SCALE)};
        if (t) walk_predict(&one), walk_predict(&other);
        if (walk_update_imu(&one, z) != 1 || walk_update_some(&other, z, 1) != 1) return 1;
        if (t % 4 == 0 && (walk_update_gps(&one, z + 1) != 3 || walk_update_some(&other, z, 6) != 6)) return 2;
        if (memcmp(&one, &other, sizeof one)) return 3;
    }
    return 0;
}
"""


def instants(log: Path, late: int) -> tuple[list[int], dict[int, np.ndarray], dict[int, np.ndarray]]:
    """When something is measured, in microseconds; what the first sensor and the late one measured then"""
    rows = [[int(row[0]), *(float(cell or "nan") for cell in row[1:])] for row in list(csv.reader(log.open()))[1:]]
    told = {row[0] - late: np.array(row[2:]) for row in rows if not np.isnan(row[2]) and row[0] - late >= rows[0][0]}
    return sorted({row[0] for row in rows} | set(told)), {row[0]: np.array(row[1:2]) for row in rows if not np.isnan(row[1])}, told


@pytest.mark.parametrize("T, off, late", first(2, [("f32", 2e-5, 3), ("q31", 1e-5, 0), ("f32", 2e-5, 0), ("q31", 1e-5, 3)]))
def test_the_firmware_of_sensors_in_steps(T, off, late, tmp_path):
    """A temperature and its slow reference, which comes 3 rows late; offsets among them"""
    path = saved(tmp_path / "room.toml",
                 "[model]\nname = 'room'\nA = [[0.98, 0.05], [0.0, 0.9]]\nc = [0.4, 0.0]\nQ = [0.01, 0.02]\nx0 = [20.0, 0.0]\nP0 = [4.0, 1.0]\n"
                 "[states]\nranges = [100, 20]\n[[sensors]]\nname = 'quick'\nH = [1.0, 0.0]\nR = 0.25\nranges = [100]\n"
                 f"[[sensors]]\nname = 'reference'\nH = [1.0, 1.0]\nR = 0.01\nd = [-1.5]\nranges = [100]\ndelay = {late}\n")
    for seed in range(3):
        draw = np.random.default_rng(seed)
        z = 20 + draw.normal(size=(60, 2))
        z[np.arange(60) % 7 != 0, 1] = np.nan
        f, firmware = Filter(model_file.read(path), T), Firmware.designed(tmp_path, path, T)
        scale = 2.0 ** np.array(f.parts.fractions("measurements"))
        words = np.round(z * scale) if T == "q31" else z.astype(np.float32)
        given = words / scale if T == "q31" else words.astype(float)
        for t in range(60):
            assert t == 0 or firmware.call("predict") == 0
            assert firmware.call("update_quick", words[t, :1].astype(int) if T == "q31" else words[t, :1], 1) == 0
            if t >= late and not np.isnan(z[t - late, 1]):
                one = words[t - late, 1:]
                assert firmware.call("update_reference", one.astype(int) if T == "q31" else one, 1, *([late] if late else [])) == 0
        known = given.copy()
        known[60 - late:, 1] = np.nan
        f.run(known)
        mean, sigma = firmware.reading(2) / (2.0 ** np.array(f.parts.fractions("states")) if T == "q31" else 1)
        assert np.abs((mean - f.mean) / f.sigma).max() <= (off if late else 1e-6) or np.array_equal(mean, f.mean.astype(np.float32))
        assert np.abs(sigma / f.sigma - 1).max() < 1e-5


@pytest.mark.parametrize("way", first(1, ["tables", "lean", "init"]))
def test_fixed_point_goes_several_steps_at_once(way, tmp_path):
    """1 to 5 dt, with a control and offsets: the host's words at these times"""
    path = saved(tmp_path / "cart.toml",
                 "[model]\nname = 'cart'\nF = [[0.0, 1.0], [0.0, -0.5]]\nB = [0.0, 2.0]\nc = [0.0, -0.3]\nQc = [0.0, 0.3]\ndt = 0.1\nH = [1.0, 0.0]\n"
                 "R = 0.04\nd = [3.0]\nP0 = [4.0, 1.0]\n[states]\nranges = [100, 20]\n[measurements]\nranges = [100]\n[controls]\nranges = [9]\n")
    firmware, draw = Firmware.designed(tmp_path, path, "q31", steps=5, way=way), np.random.default_rng(1)
    count, u, z = draw.integers(1, 6, 60), draw.normal(size=(60, 1)), 3 + draw.normal(size=(60, 1))
    f = Filter(model_file.read(path), "q31", way="lean" if way == "lean" else "")
    scales = [2.0 ** f.parts.fractions(which)[0] for which in ("measurements", "controls")]
    words = [np.round(one * scale).astype(int) for one, scale in zip((z, u), scales)]
    run = f.run(words[0] / scales[0], words[1] / scales[1], times=0.1 * np.cumsum([0, *count[1:]]))
    for t in range(60):
        assert t == 0 or firmware.call("predict", words[1][t - 1], int(count[t])) == 0
        assert firmware.call("update", words[0][t], 1) == 0
    assert np.array_equal(firmware.reading(2)[0], run.words["mean"][-1])
    assert firmware.call("predict", words[1][0], 6) != 0 and firmware.call("predict", words[1][0], 0) != 0
    for more in (["--steps", "5", "--arith", "f32"], ["--steps", "5", "--any-dt"]):
        refused(kalmanq("design", path, "--core", "m0", *more), "--steps: of a model with F, Qc and dt, in q31")


def test_a_delay_in_rows(tmp_path):
    path = tmp_path / "steps.toml"
    text = "[model]\nA = 0.9\nQ = 1\nP0 = 1\n[[sensors]]\nname = 'a'\nH = 1\nR = 1\n[[sensors]]\nname = 'b'\nH = 2\nR = 1\ndelay = {}\n"
    path.write_text(text.format(2))
    data = written(tmp_path, "z.csv", "a,b", [1.0, 2, 3, 4], [9.0, 9, 5, 6])
    f = Filter(model_file.read(path))
    f.run([[1, 5], [2, 6], [3, np.nan], [4, np.nan]])
    assert json_of("run", path, data)["log_likelihood"] == f.log_likelihood
    wild = written(tmp_path, "wild.csv", "# a note\na,b", [1.0, 1e300, 1.0], [9.0, 9, 5])
    refused(kalmanq("run", path, wild, "--arith", "f32"), "row 4")
    names = ("simulate", path, "-n", "9", "--seed", "3")
    late = [list(csv.DictReader(kalmanq(*names).stdout.splitlines())), path.write_text(text.format(0)),
            list(csv.DictReader(kalmanq(*names).stdout.splitlines()))]
    assert [row["b"] for row in late[0]] == ["", "", *(row["b"] for row in late[2][:-2])]
    assert [row["a"] for row in late[0]] == [row["a"] for row in late[2]]


@pytest.mark.parametrize("old, new, said", [
    ("R = 0.01", "R = 0.01\ndelay = -1", "line 17: delay: .*0 or more"),
    ("R = 0.01", "R = 0.01\ndelay = '1 s'", "line 17: delay: "),
    ('name = "gps"', 'name = "imu"', "line 19: name: imu .*twice"), ("R = 0.01", "", "line 11: R: .*missing"),
    ("R = 0.01", "S = 1\nR = 0.01", "line 16: S: .*sensors"),
    ("H = [0.0, 0.0, 1.0]", "H = [1.0]", "line 15: H: is 1 x 1"),
    ("R = 0.01", "R = 0.01\nmeasured = 'at'", "measured: .*`delay`"),
    ('["pos", "speed"]', '["pos"]', "measurements: names .* 1 .* 2 "),
    ('["pos", "speed"]', '["pos", "acc"]', "measurements: .*twice"),
    ("dt = 0.0025", "dt = 0.0025\nH = 1", "line 6: H: is each"),
    ("[states]", "[measurements]\nnames = []\n[states]", "measurements: .*sensor's"),
    ("R = 0.01", "R = -1", "line 16: R: has a neg"), ('name = "gps"', "name = 3", "line 19: name: .*text"),
    ("[[sensors]]\nname = \"gps\"", "[sensors]\nname = \"gps\"", "line 18: ")])
def test_what_is_no_sensor_is_refused(old, new, said, tmp_path):
    with pytest.raises(KalmanqError, match=said):
        model_file.read(walk(tmp_path, (old, new)))


# ------------------------------------------------------------------------------ a million rows


@WHOLE
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks Linux for the peak")
@pytest.mark.parametrize("more", [(), ("--smooth",)])
def test_a_million_rows_take_no_more_memory(more, tmp_path):
    """With time stamps of microseconds, in one pass, or two"""
    path, peaks = walk(tmp_path), []
    for rows in (250_000, 1_000_000):
        draw = np.random.default_rng(1)
        times = 2500 * np.arange(rows) + draw.integers(0, 500, rows)
        data = tmp_path / "long.csv"
        np.savetxt(data, np.column_stack([times, draw.normal(size=rows)]), "%d,%.6g", header="t [us],acc", comments="")
        program = ("import re, sys; from kalmanq.command_line import app\n"  # VmHWM: without this process's own, before exec
                   "try: app(sys.argv[1:])\n"
                   "finally: print(re.search(r'VmHWM:\\s*(\\d+)', open('/proc/self/status').read())[1], file=sys.stderr)")
        done = subprocess.run([sys.executable, "-c", program, "run", str(path), str(data), "--out", str(tmp_path / "o.csv"), *more],
                              capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        peaks.append(int(done.stderr.split()[-1]))
    assert peaks[1] < 1.1 * peaks[0], peaks


def test_what_was_measured_in_the_first_row_of_all_is_kept_however_times_round(tmp_path):
    path = saved(tmp_path / "late.toml", ONE_LATE)
    for start in np.arange(10, 16, 0.1):
        first = round(start - 0.9, 6)
        files = [written(tmp_path, "a.csv", "t,a", np.round(start + 0.1 * np.arange(8), 6), np.ones(8)),
                 written(tmp_path, "b.csv", "t,b", [first, *np.round(first + 0.6 + 0.1 * np.arange(4), 6)], [np.nan, 5, 6, 7, 8])]
        z, *_ = joining.record(files, model_file.read(path))
        assert z[0, 1] == 5, start


def gauges(count: int) -> str:
    """So many sensors of a level"""
    one = '[[sensors]]\nname = "{}"\nmeasurements = ["z{}"]\nH = [1.0, 0.0]\nR = {}\nranges = [1000]\n'
    return ("[model]\nA = [[1.0, 0.1], [0.0, 1.0]]\nQ = [[0.01, 0.0], [0.0, 0.01]]\nP0 = [100.0, 1.0]\n[states]\nranges = [1000, 1000]\n"
            + "".join(one.format(name, k, k + 1.0) for k, name in enumerate("abc"[:count])))


def with_faults(count: int, rows: int = 300) -> np.ndarray:
    """Rows of one sensor and of several; each is off for a while, at most eight of its rows in a row"""
    draw = np.random.default_rng(count)
    z = draw.normal(size=(rows, count)) * np.sqrt(np.arange(count) + 1.0)
    z[draw.random(z.shape) < 0.4] = np.nan
    for begin in range(20, rows - 40, 25):
        at, which = begin + np.arange(20), begin // 25 % count
        wrong = at[~np.isnan(z[at, which])][: 3 + begin // 25 % 6]
        z[wrong, which] += 60
    return z


@pytest.mark.parametrize("arithmetic", ["f64", "f32", "q31"])
@pytest.mark.parametrize("count", [2, 3])
def test_each_sensor_has_a_gate(count, arithmetic, tmp_path):
    """As the C of compile counts, and a nonlinear run: a good sensor's rows say nothing of another's"""
    path, z = saved(tmp_path / "gauges.toml", gauges(count)), with_faults(count)
    data = written(tmp_path, "log.csv", ",".join(f"z{k}" for k in range(count)), *z.T)
    model, gate = model_file.read(path), Robust("gate", 4.0)
    run = Filter(model, arithmetic).run(z, robust=gate)
    wrong = z > 40
    assert run.events == lib.KQ_EVENT_GATED and np.array_equal(np.sum(~np.isnan(z), axis=1) - run.taken, np.sum(wrong, axis=1))
    told = json_of("run", path, data, "--arith", arithmetic, "--robust", "gate=4")
    assert told["rejected"] == np.sum(wrong) > 30 and told["mean"] == run.mean[-1].tolist() and 0.5 < told["nis_per_measurement"] < 1.5
    with Host(compiled(model, "filter", Options(arithmetic, gate=4.0))) as host:
        ours = host.run(z)
    assert np.array_equal(ours.taken, (~np.isnan(z) & ~wrong) @ (1 << np.arange(count))) and np.allclose(ours.mean, run.mean, atol=1e-3)
    bent = NonlinearModel(f=lambda x: model.A @ x, Q=model.Q, x0=model.x0, P0=model.P0, states=model.states, measurements=model.measurements,
                          sensors={one.name: (lambda x: x[:1], [[model.R[k, k]]]) for k, one in enumerate(model.sensors)})
    other = NonlinearFilter(bent, arithmetic).run(z, robust=gate)
    assert np.array_equal(other.taken, run.taken) and np.allclose(other.mean, run.mean, atol=1e-4)
    assert np.allclose(other.nis, run.nis, rtol=1e-3, atol=1e-4, equal_nan=True) and np.allclose(other.log_likelihood, run.log_likelihood, atol=1e-3)
    smoothed = Smoother(model, arithmetic).run(z, robust=gate)
    assert np.array_equal(smoothed.taken, run.taken) and np.allclose(smoothed.mean, run.mean, atol=1e-6)


@pytest.mark.parametrize("arithmetic", ["f64", "f32", "q31"])
def test_a_sensor_that_stays_elsewhere_comes_in(arithmetic, tmp_path):
    """After eight of its rows, whatever the other says; blocks, single rows and copies go on counting"""
    model, gate, draw = model_file.read(saved(tmp_path / "gauges.toml", gauges(2))), Robust("gate", 4.0), np.random.default_rng(0)
    z = draw.normal(size=(60, 2))
    z[::2, 0] = z[1::2, 1] = np.nan
    z[30:, 1] += 50
    run = Filter(model, arithmetic).run(z, robust=gate)
    second = run.taken[30::2]
    assert np.all(run.taken[:30] == 1) and not np.any(second[:8]) and second[8] == 1 and run.mean[46, 0] > 30
    parts = Filter(model, arithmetic)
    for begin, end in ((0, 37), (37, 38), (38, 60)):
        last = parts.run(z[begin:end], robust=gate)
        parts = parts.copy()
    assert np.array_equal(last.mean, run.mean[38:])
    watch = Consistency(model, 60, arithmetic)
    Filter(model, arithmetic).run(z, robust=gate, watch=watch)
    assert len(watch) == np.count_nonzero(run.taken) and watch.nis()[0] == pytest.approx(np.sum(run.nis[run.taken > 0]) / np.sum(run.taken), rel=1e-5)
