"""The command line, as a user has it: results, and one line for what is wrong."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from command import json_of, kalmanq, refused, rows_of, succeeds
from library import EXAMPLES, saved
from scipy import special, stats

import kalmanq as kalmanq_package
from kalmanq import Filter, LagSmoother, Robust, Smoother
from kalmanq.data import joining
from kalmanq.model import model_file
from kalmanq.pages import pictures
from kalmanq.run.robust import limit_of
from kalmanq.run.simulation import simulate

NILE, MODEL = EXAMPLES / "nile.csv", EXAMPLES / "nile.toml"
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_run_writes_what_the_twin_says(arithmetic, tmp_path):
    out, plot = tmp_path / "out.csv", tmp_path / "out.png"
    done = succeeds("run", MODEL, NILE, "--arith", arithmetic, "--smooth", "--forecast", 5, "--out", out, "--plot", plot, "--json", "--digits", 17)
    said, rows = json.loads(done.stdout), rows_of(out)
    z = np.loadtxt(NILE, delimiter=",", skiprows=5)[:, 1]
    run = Smoother(model_file.read(MODEL), arithmetic).run(z)
    assert list(rows[0]) == ["step", "level_mean", "level_sigma", "level_smoothed", "level_smoothed_sigma",
                             "flow_innovation", "nis", "loglik"]
    assert [float(row["level_smoothed"]) for row in rows] == run.smoothed[:, 0].tolist()
    assert rows[0]["flow_innovation"] == "" and rows[99]["step"] == "99"
    assert said["rows"] == 100 and len(said["forecast"]) == 5
    assert abs(said["log_likelihood"] - -633.4646) < 1e-3
    assert plot.read_bytes()[:8] == PNG


def test_data_that_do_not_fit_name_the_next_command(tmp_path):
    """Noise that is too small or too large, and outliers; a robust run looks after these"""
    wrong, wild = tmp_path / "wrong.toml", tmp_path / "wild.csv"
    rows = NILE.read_text().splitlines()
    wild.write_text("\n".join(f"{row.split(',')[0]},20000" if k % 40 == 30 else row for k, row in enumerate(rows)) + "\n")
    for R, data, options, said in (("15099.0", NILE, (), False), ("150.0", NILE, (), True), ("1.5e6", NILE, (), True),
                                   ("15099.0", wild, (), True), ("15099.0", wild, ("--robust", "huber"), False)):
        wrong.write_text(f'[model]\nA = [1]\nR = {R}\nH = [1]\nQ = [1468.0]\nP0 = "unknown"\n[measurements]\nnames = ["flow"]\n')
        assert ("the data do not fit the model; kalmanq report shows where" in kalmanq("run", wrong, data, *options).stdout) == said


@pytest.mark.parametrize("more", [(), ("--compiled", "--arith", "f32")])
def test_a_forecast_leaves_the_last_control_as_it_is(more, tmp_path):
    model, head = EXAMPLES / "cart.toml", "range,push\n0.1,0\n0.2,1\n0.1,3\n"
    told = []
    for name, rows, ahead in (("a.csv", "", 4), ("b.csv", ",3\n" * 4, 0)):
        (tmp_path / name).write_text(head + rows, encoding="utf-8")
        told.append(json_of("run", model, tmp_path / name, "--forecast", ahead, *more))
    assert len(told[0]["forecast"]) == 4 and told[0]["mean"] != told[1]["mean"]
    assert told[0]["forecast"][-1]["mean"] == told[1]["mean"] and told[0]["forecast"][-1]["covariance"] == told[1]["covariance"]


def test_run_in_blocks_is_run_at_once(tmp_path):
    data, out = tmp_path / "data.csv", tmp_path / "out.csv"
    succeeds("simulate", EXAMPLES / "track.toml", "-n", 70000, "--seed", 3, "-o", data)
    succeeds("run", EXAMPLES / "track.toml", data, "--arith", "f32", "-o", out, "--digits", 17)
    z = np.array([[float(row["east"]), float(row["north"])] for row in rows_of(data)])
    last = rows_of(out)[-1]
    run = Filter(model_file.read(EXAMPLES / "track.toml"), "f32").run(z)
    assert float(last["vy_mean"]) == run.mean[-1, 3] and last["step"] == "69999"


def test_lag_robust_and_an_unknown_start(tmp_path):
    out = tmp_path / "out.csv"
    succeeds("run", MODEL, NILE, "--lag", 3, "--robust", "huber", "--out", out)
    rows = rows_of(out)
    assert [row["level_lagged"] == "" for row in rows[:5]] == [True, True, True, False, False]


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
@pytest.mark.parametrize("loss, usual, other", [("gate", 3.8906, 2.5), ("huber", 3, 1), ("student", 10, 2.5), ("jump", 9, 4)])
def test_a_robust_run_takes_a_parameter(loss, usual, other, arithmetic, tmp_path):
    """Left out it is the usual one; another one gives what Filter gives with it, and other means"""
    model, data = model_file.read(EXAMPLES / "track.toml"), tmp_path / "data.csv"
    z = simulate(model, 200, 1)[1] + 8 * np.random.default_rng(2).standard_t(2, (200, 2))
    data.write_text("\n".join(["east,north", *(",".join(repr(float(one)) for one in row) for row in z)]) + "\n")
    means = {}
    for given in (loss, f"{loss}={usual}", f"{loss}={other}"):
        out = tmp_path / f"{given}.csv"
        succeeds("run", EXAMPLES / "track.toml", data, "--arith", arithmetic, "--robust", given, "-o", out, "--digits", 17)
        means[given] = [[float(row[f"{one.name}_mean"]) for one in model.states] for row in rows_of(out)]
    plain, first, second = means.values()
    assert np.allclose(plain, first, rtol=1e-9, atol=0) and np.abs(np.subtract(first, second)).max() > 0.1
    assert second == Filter(model, arithmetic).run(z, robust=Robust(loss, other)).mean.tolist()


@pytest.mark.parametrize("more", [(), ("--smooth",), ("--arith", "f32"), ("--arith", "q31")])
def test_what_a_gate_rejects_is_counted_apart(more, tmp_path):
    """Neither taken nor missing, and the NIS of the others has none of it: at most the gate's"""
    rows = NILE.read_text().splitlines()
    rows[50], rows[60] = rows[50].replace(rows[50].split(",")[-1], ""), rows[60].replace(rows[60].split(",")[-1], "2500")
    (tmp_path / "nile.csv").write_text("\n".join(rows) + "\n")
    told = json_of("run", MODEL, tmp_path / "nile.csv", "--robust", "gate=1.5", *more)
    assert told["missing"] == 1 and told["rejected"] > 5 and told["taken"] == 99 - told["rejected"]
    assert told["nis_per_measurement"] < 1.5**2


@pytest.mark.parametrize("count", [1, 2, 3, 8, 31])
@pytest.mark.parametrize("sigmas", [1.01, 2, 3.8906, 12, 35])
def test_a_gate_of_sigmas_is_as_unlikely_in_each_count(sigmas, count):
    wanted = stats.chi2.isf(special.erfc(sigmas / np.sqrt(2)), count)
    assert abs(limit_of(sigmas, count) / wanted - 1) < 1e-9
    assert limit_of(100, count) > limit_of(99, count) >= 99**2  # less likely than a double says


@pytest.mark.parametrize("arithmetic, way", [("q31", "lean"), ("q31", "tables"), ("f32", "lean"), ("q31", "sizes")])
def test_run_as_a_design_has_its_very_words(arithmetic, way, tmp_path):
    """With gaps and rows in part; of q31 lean not those of init."""
    model, data, out = model_file.read(EXAMPLES / "track.toml"), tmp_path / "data.csv", tmp_path / "out.csv"
    z = simulate(model, 300, 1)[1]
    z[40:60], z[5::7, 0] = np.nan, np.nan
    data.write_text("\n".join([",".join(one.name for one in model.measurements), *(",".join(
        "" if np.isnan(value) else repr(float(value)) for value in row) for row in z)]))
    done = succeeds("run", EXAMPLES / "track.toml", data, "--arith", arithmetic, "--as", way, "--out", out, "--digits", 17, "--json")
    columns = [f"{state.name}_{what}" for what in ("mean", "sigma") for state in model.states]
    written = np.array([[float(row[name]) for name in columns] for row in rows_of(out)])
    read = joining.record(data, model)[0]
    runs = [Filter(model, arithmetic, way=one).run(read) for one in (way, "init")]
    expected, of_init = (np.hstack([run.mean, run.sigma]) for run in runs)
    assert written.tolist() == expected.tolist()
    assert ((arithmetic, way) == ("q31", "lean")) == bool(np.any(expected != of_init))
    assert json.loads(done.stdout)["way"] == way


def test_the_picture_of_a_lag_has_the_lagged_estimate(tmp_path):
    """At the rows that it is of: where it is drawn, later rows have been taken."""
    kalmanq("simulate", EXAMPLES / "track.toml", "-n", 60, "--seed", 2, "--out", tmp_path / "z.csv")
    pictures_of = [tmp_path / name for name in ("plain.png", "lag.png")]
    for path, options in zip(pictures_of, ((), ("--lag", 7))):
        succeeds("run", EXAMPLES / "track.toml", tmp_path / "z.csv", *options, "--plot", path)
    assert pictures_of[0].read_bytes() != pictures_of[1].read_bytes()
    model = model_file.read(EXAMPLES / "track.toml")
    z = joining.record(tmp_path / "z.csv", model)[0]
    run = LagSmoother(model, 7).run(z)
    axis = pictures.draw_run(run, z).axes[1]
    line = next(line for line in axis.get_lines() if line.get_label() == "7 rows later, 95 %")
    assert np.array_equal(line.get_xdata(), np.arange(53)) and np.array_equal(line.get_ydata(), run.lagged[7:, 1])
    pictures.draw_run(LagSmoother(model, 60).run(z), z)  # nothing is known that late


def test_two_columns_that_measure_one_level(tmp_path):
    data = saved(tmp_path / "data.csv", "fine,coarse,other\n1.0,2.0,a\n,2.5,b\n1.2,,c\n")
    said = json_of("run", EXAMPLES / "two_gauges.toml", data)
    assert said["taken"] == 4 and said["missing"] == 2


def test_fit_simulate_compare_steady_check(tmp_path):
    guess, fitted = tmp_path / "guess.toml", tmp_path / "fitted.toml"
    guess.write_text(MODEL.read_text().replace('P0 = "unknown"', "P0 = [[1e7]]"))
    done = succeeds("fit", guess, NILE, "--out", fitted, "--plot", tmp_path / "fit.png", "--json")
    assert abs(json.loads(done.stdout)["R"][0][0] / 15099.69 - 1) < 1e-3
    assert abs(model_file.read(fitted).Q[0, 0] / 1468.5 - 1) < 1e-2
    compared = json_of("compare", MODEL, NILE)
    assert 0 < compared["q31"]["mean_error_in_sigma"] < 1e-6 < 1
    assert 0 < compared["f32"]["mean_error_in_sigma"] < 1e-4
    steady = json_of("steady", MODEL)
    assert 0 < steady["gain"][0][0] < 1
    succeeds("check", MODEL)
    hidden = saved(tmp_path / "hidden.toml", "[model]\nA=[[1.0,0.0],[0.0,1.0]]\nH=[1.0,0.0]\nQ=[1.0,1.0]\nR=1.0\nP0=[1.0,1.0]\n")
    checked = kalmanq("check", hidden)
    assert checked.returncode == 1 and "never measured" in checked.stdout
    assert "prior" not in kalmanq("check", MODEL).stdout  # nothing is known of it
    for sigma, code, said in ((40, 0, "3 sigma are within"), (60, 0, "3 sigma reach beyond"), (130, 1, "beyond its range")):
        hidden.write_text(f"[model]\nA=1.0\nH=1.0\nQ=1.0\nR=1.0\nP0={sigma**2}.0\n[states]\nranges=[125]\n"
                          "[measurements]\nranges=[900]\n")
        checked = kalmanq("check", hidden)
        assert checked.returncode == code and said in checked.stdout
    one, two = (kalmanq("simulate", MODEL, "--seed", 5).stdout for _ in range(2))
    assert one == two and one != kalmanq("simulate", MODEL, "--seed", 6).stdout


BAD_DATA = {
    "no such file": None, "empty": "", "there is no column flow": "year,level\n1,2\n", "no data": "flow\n", "row 3, column flow: 'ten' is": "flow\n1\nten\n",
    "not representable": "flow\ninf\n", "decimal point": 'a,flow\n1,"2,500"\n',
}


@pytest.mark.parametrize("said", BAD_DATA)
def test_bad_data_is_one_line_and_no_file(said, tmp_path):
    data, out, plot = tmp_path / "data.csv", tmp_path / "out.csv", tmp_path / "out.png"
    if BAD_DATA[said] is not None:
        data.write_text(BAD_DATA[said])
    for command in (("run", MODEL, data, "--out", out, "--plot", plot), ("compare", MODEL, data, "--plot", plot), ("report", MODEL, data, "-o", out)):
        refused(kalmanq(*command), said, tmp_path)


OPTIONS = [  # of a run, and what is said
    (["--out", "none/out.csv"], "no such folder"),
    (["--plot", "none/out.png"], "no such folder"),
    (["--smooth", "--lag", "3"], "one of them"),
    (["--smooth", "--robust", "jump=4"], "give --robust jump"),
    (["--lag", "2", "--robust", "jump"], "a lag cannot follow"),
    (["--lag", "2", "--robust", "jump=4"], "leave --lag out"),
    (["--robust", "median"], "give one of gate, huber, student, jump"),
    (["--robust", "gate=0.9999"], "K is in sigma, above 1"),
    (["--robust", "gate=nan"], "K is in sigma, above 1"),
    (["--robust", "huber=x"], "x is not a number: give one, such as huber=3"),
    (["--robust", "student="], "nothing is not a number"),
    (["--robust", "huber=-3"], "give one above 0, usually 3"),
    (["--robust", "student=0"], "give one above 0, usually 10"),
    (["--robust", "student=inf"], "give one above 0, usually 10"),
    (["--robust", "jump=0.5"], "give 1 or more, usually 9"),
    (["--robust=huber=nan"], "give one above 0"),
    (["--as", "init"], "--as init and --arith f64"),
    (["--as", "init", "--arith", "q31", "--smooth"], "--as init and --smooth"),
    (["--as", "init", "--arith", "f32", "--lag", "0"], "--as init and --lag"),
    (["--as", "lean", "--arith", "q31"], "cannot run as lean, but as init, sizes: the start is unknown, which init and sizes take"),
    (["--out", "out.png", "--plot", "./out.png"], "out.png: --out and --plot are one file; give two names"),
    (["--out", "."], "is a folder"), (["--plot", "/"], "is a folder"),
]
GUESS, CART = EXAMPLES / "nile_guess.toml", EXAMPLES / "cart.toml"
GIVEN = {"two.csv": "flow\n1\n2\n", "wide.csv": "flow\n1000\n5000\n", "huge.csv": "year,flow\n1,1000\n2,1e300\n",
         "u.csv": "other;push [m/s2]\n" + "x;0.5\n" * 100}
REFUSED = [  # commands where these files are, and what is said
    *((["run", MODEL, NILE, *options], said) for options, said in OPTIONS),
    (["run", MODEL, "two.csv", "--out", "two.csv"], "is an input"),
    (["run", MODEL, "wide.csv", "--arith", "q31", "--out", "out.csv"], "wide.csv: row 3: flow = 5000"),
    (["run", MODEL, "huge.csv", "--arith", "f32"], "huge.csv: row 3: flow = 1e+300"),
    (["simulate", MODEL, "--out", "."], "is a folder"), (["fit", GUESS, NILE, "--out", "."], "is a folder"),
    (["simulate", MODEL, "--gap", 3, 1], "--gap 3 1"), (["fit", GUESS, NILE, "--free", ""], "--free: names nothing"),
    (["simulate", MODEL, "--controls", "u.csv"], "the model has no controls"),
    (["simulate", CART, "--controls", "u.csv", "-n", 200], "u.csv: has 100 rows, fewer than the 200 of -n"),
    (["simulate", CART, "--controls", "u.csv", "--out", "u.csv"], "u.csv: is an input"),
    (["simulate", CART, "--controls", "u.csv", "--rename", "push=no"], "there is no column no"),
]


@pytest.mark.parametrize("command, said", REFUSED)
def test_what_cannot_be_is_one_line_and_changes_no_file(command, said, tmp_path):
    for name, text in GIVEN.items():
        saved(tmp_path / name, text)
    refused(kalmanq(*command, folder=tmp_path), said, tmp_path)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == GIVEN


def test_an_interrupt_leaves_nothing(tmp_path):
    """It waits for rows that do not come, with a part of the output written"""
    running = subprocess.Popen([sys.executable, "-m", "kalmanq.command_line", "run", str(MODEL), "-", "--out", str(tmp_path / "out.csv")],
                               stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    running.stdin.write("flow\n" + "1000.5\n" * 140_000)  # two blocks and a part
    running.stdin.flush()
    while running.poll() is None and not list(tmp_path.glob(".out*")):
        time.sleep(0.02)
    os.kill(running.pid, signal.SIGINT)
    _, said = running.communicate()
    assert running.returncode == 130 and said == "kalmanq: interrupted\n"
    assert list(tmp_path.iterdir()) == []


def python(code, folder=None):
    """A Python of its own, without what this process has imported"""
    return subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, cwd=folder)


def without(missing, command=()):
    """A program of the command line where these modules are not installed"""
    return (f"import sys; sys.modules.update(dict.fromkeys({missing.split()})); sys.argv = {['kalmanq', *map(str, command)]}\n"
            "from kalmanq.__main__ import main; main()")


def test_help_reads_well():
    said = succeeds("--help")
    for command in ("run", "check", "steady", "simulate", "compare", "report", "fit"):
        assert command in said.stdout and kalmanq(command, "--help").returncode == 0


def test_doctor_says_what_is_missing_and_its_cure(tmp_path):
    there = {one["name"]: one for one in json_of("doctor")}
    library = re.search('KQ_VERSION_STRING "(.*)"', (Path(__file__).parents[2] / "include/kalmanq/version.h").read_text())[1]
    assert kalmanq("--version").stdout == f"kalmanq {there['kalmanq']['version']}, C library {library}\n"
    assert re.match(r"\d+\.\d+", there["numpy"]["version"]) and there["simavr"]["cure"] == "apt install simavr"
    (tmp_path / "avr-gcc").write_text("#!/bin/sh\necho 'avr-gcc (GCC 12.3) 5.4.0'\n")
    (tmp_path / "avr-gcc").chmod(0o755)
    done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", "doctor", "--json"], capture_output=True, text=True,
                          env={**{key: one for key, one in os.environ.items() if key != "CC"}, "PATH": str(tmp_path)})
    found = {one["name"]: one["version"] for one in json.loads(done.stdout)}
    assert found["avr-gcc"] == "5.4.0" and found["C compiler"] is None and found["qemu-system-arm"] is None
    assert kalmanq("doctor").stdout.splitlines()[0].startswith("kalmanq doctor")


# ------------------------------------------------------------------------------ outputs and names of all kinds


def test_an_output_may_be_a_link_a_pipe_or_a_device(tmp_path):
    (tmp_path / "link.csv").symlink_to(tmp_path / "real.csv")
    (tmp_path / "real.csv").write_text("old")
    (tmp_path / "real.csv").chmod(0o600)
    succeeds("run", MODEL, NILE, "--out", tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink() and (tmp_path / "real.csv").stat().st_mode & 0o777 == 0o600
    assert len((tmp_path / "real.csv").read_text().splitlines()) == 101
    os.mkfifo(tmp_path / "pipe")
    reader = subprocess.Popen(["cat", str(tmp_path / "pipe")], stdout=subprocess.PIPE, text=True)
    succeeds("run", MODEL, NILE, "--out", tmp_path / "pipe")
    assert reader.communicate()[0] == (tmp_path / "real.csv").read_text()
    full = Path("/dev/full")
    if full.is_char_device():
        refused(kalmanq("run", MODEL, NILE, "--out", full), "/dev/full: No space left")
        assert full.is_char_device()


def test_names_are_no_markup(tmp_path):
    model = saved(tmp_path / "m.toml", '[model]\nname = "[/x]"\nA = [[1.0]]\nH = [1.0]\nQ = [[1.0]]\nR = [[1.0]]\nP0 = [1.0]\n'
                                       '[states]\nnames = ["speed [m/s]"]\n[measurements]\nnames = ["[/z]"]\n')
    data = saved(tmp_path / "d.csv", "[/z]\n1\n2\n")
    assert "speed [m/s]" in succeeds("run", model, data).stdout
    succeeds("check", model)


def test_all_missing_with_an_unknown_start_is_a_run_of_nothing(tmp_path):
    data, out = saved(tmp_path / "d.csv", "year,flow\n1,\n2,\n"), tmp_path / "o.csv"
    model = saved(tmp_path / "m.toml", '[model]\nA = [[1.0]]\nH = [1.0]\nQ = [[1.0]]\nR = [[1.0]]\nP0 = "unknown"\n'
                                       '[measurements]\nnames = ["flow"]\n')
    done = succeeds("run", model, data, "--out", out, "--json")
    assert json.loads(done.stdout)["covariance"] == [[None]] and not done.stderr


# ------------------------------------------------------------------------------ simulate: controls, and who reads it


def pushed(tmp_path, rows):
    u = np.round(np.random.default_rng(3).normal(size=rows), 3)
    return saved(tmp_path / "u.csv", "other;push [m/s2]\n" + "".join(f"x;{value}\n" for value in u)), u


def test_simulated_controls_are_those_of_a_file(tmp_path):
    path, u = pushed(tmp_path, 120)
    succeeds("simulate", CART, "--controls", path, "--truth", "--seed", 4, "--out", tmp_path / "z.csv")
    rows = rows_of(tmp_path / "z.csv")
    model = model_file.read(CART)
    name = model.controls[0].name
    assert [float(row[name]) for row in rows] == u.tolist()  # as many rows as the file has
    x, z = simulate(model, 120, 4, u[:, None])
    assert [float(row[model.measurements[0].name]) for row in rows] == z[:, 0].tolist()
    assert np.abs(x - simulate(model, 120, 4)[0]).max() > 0.1  # or there is nothing to see here
    assert 0.5 < json_of("run", CART, tmp_path / "z.csv")["nis_per_measurement"] < 1.5


def test_controls_of_runs_and_of_nonlinear_models(tmp_path):
    path, u = pushed(tmp_path, 100)
    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    succeeds("simulate", CART, "--controls", path, "--seed", 2, "--runs", 3, "--workers", 1, "--out", one)
    succeeds("simulate", CART, "-n", 100, "--seed", 2, "--runs", 3, "--workers", 1, "--out", other)
    model, nis = model_file.read(CART), [[float(row["nis"]) for row in rows_of(path)] for path in (one, other)]
    assert np.allclose(nis[0], nis[1])  # the filter knows of them
    current = saved(tmp_path / "current.csv", "current\n" + "0.5\n" * 30)
    assert succeeds("simulate", EXAMPLES / "battery.py", "--controls", current).stdout.count(",0.5\n") == 30
    assert model.l == 1


def test_simulate_goes_into_run_and_head(tmp_path):
    command = f"{sys.executable} -m kalmanq.command_line"
    piped = subprocess.run(f"{command} simulate {MODEL} -n 300 | {command} run {MODEL} - --json", shell=True,
                           capture_output=True, text=True)
    assert json.loads(piped.stdout)["rows"] == 300 and not piped.stderr
    for what in (f"simulate {MODEL} -n 100000", f"run {MODEL} {NILE} --json", "--help"):
        head = subprocess.run(f"{command} {what} | head -1 >/dev/null; echo ${{PIPESTATUS[0]}}", shell=True,
                              capture_output=True, text=True, executable="/bin/bash")
        assert not head.stderr and head.stdout in ("0\n", "1\n" if what == "--help" else "141\n")
    closed = subprocess.run(f"({command} simulate {MODEL} -n 100000; echo $? >&2) | true", shell=True,
                            capture_output=True, text=True)
    assert closed.stderr == "141\n"


@pytest.mark.parametrize("missing, command, extra", [
    ("matplotlib", ["run", MODEL, NILE, "--plot", "out.png"], "plots"), ("matplotlib", ["report", MODEL, NILE, "-o", "o.html"], "plots"),
    ("scipy", ["fit", MODEL, NILE], "fitting"), ("scipy", ["design", EXAMPLES / "constant_velocity.toml", "--core", "m3"], "fitting"),
    ("joblib", ["simulate", MODEL, "--runs", 2, "--out", "o.csv"], "campaigns")])
def test_what_an_extra_of_the_package_has_is_named(missing, command, extra, tmp_path):
    done = python(without(missing, command), folder=tmp_path)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert f"this needs {missing}" in done.stderr and f"[{extra}]" in done.stderr and not list(tmp_path.iterdir())


def test_help_imports_no_numbers():
    """So that it is there at once"""
    program = ("import sys\nfrom kalmanq.__main__ import main\nsys.argv = ['kalmanq', '--help']\n"
               "try:\n    main()\nfinally:\n    print([name for name in ('numpy', 'scipy', 'kalmanq._core') if name in sys.modules])")
    done = python(program)
    assert done.returncode == 0 and done.stdout.rstrip().endswith("[]") and "compile" in done.stdout
    again = subprocess.run([sys.executable, "-B", "-m", "kalmanq", "--help"], capture_output=True, text=True)
    assert again.returncode == 0 and "compile" in again.stdout


def test_every_public_name_is_there():
    """They are imported when they are used; folders and modules are, too."""
    assert len(kalmanq_package.__all__) == 51 and set(kalmanq_package.__all__) <= set(dir(kalmanq_package))
    assert all(getattr(kalmanq_package, name).__module__.startswith("kalmanq.") for name in kalmanq_package.__all__)
    assert kalmanq_package.nonlinear.read and kalmanq_package.core.lib
    with pytest.raises(AttributeError, match="no attribute 'Fliter'"):
        kalmanq_package.Fliter


@pytest.mark.parametrize("missing", ["typer", "rich"])
def test_without_the_extra_of_the_command_line_it_says_what_to_install(missing):
    done = python(without(missing))
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr == (f"kalmanq: the command line needs {missing}, which is not installed: pip install 'kalmanq[cli]', or "
                           "'./tools[cli]' in the project's folder\n")


def test_without_jinja2_compile_says_what_to_install(tmp_path):
    done = python(without("jinja2", ["compile", MODEL, "-o", "nile.c"]), folder=tmp_path)
    assert (done.returncode, done.stdout, list(tmp_path.iterdir())) == (1, "", [])
    assert done.stderr == "kalmanq: this needs jinja2, which is not installed: pip install './tools[cli]'\n"


def test_the_library_needs_nothing_of_the_command_line():
    code = ("import sys; sys.modules.update(typer=None, rich=None, click=None, jinja2=None, joblib=None, scipy=None, matplotlib=None); import kalmanq\n"
            "for name in kalmanq.__all__: getattr(kalmanq, name)\nimport kalmanq.run.campaigns")
    done = python(code)
    assert (done.returncode, done.stderr) == (0, "")
