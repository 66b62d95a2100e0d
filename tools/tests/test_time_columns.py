"""Columns of times: seconds, milliseconds, dates and clocks, on the command line and in tables; what is refused, with its row."""

from __future__ import annotations

import json
import sys
import warnings

import numpy as np
import pytest
from command import json_of, kalmanq, refused, rows_of, succeeds
from library import text_in

from kalmanq import Filter, KalmanqError, KalmanqWarning, Smoother
from kalmanq.data import joining, tables
from kalmanq.data.layouts import Layout, Source
from kalmanq.model import model_file

CART = """
[model]
F = [[0.0, 1.0], [0.0, 0.0]]
Qc = [0.0, 0.5]
dt = 0.1
H = [1.0, 0.0]
R = 0.04
P0 = [4.0, 1.0]

[measurements]
names = ["pos"]
"""
STEPS = """
[model]
A = [[1.0, 0.1], [0.0, 1.0]]
Q = [0.001, 0.01]
H = [1.0, 0.0]
R = 0.04
P0 = [4.0, 1.0]

[measurements]
names = ["pos"]
"""
ROWS = 30


def cart(folder, text=CART):
    return text_in(folder, text, "cart.toml")


def in_seconds(seed: int = 1) -> list:
    return [f"{one / 1000:.3f}" for one in times_of(seed)]


def times_file(folder, rows):
    return text_in(folder, "t [ms]\n" + "".join(f"{one}\n" for one in times_of(7, rows)), "t.csv")


def times_of(seed: int = 1, rows: int = ROWS) -> np.ndarray:
    """Of whole milliseconds, from 0"""
    return np.cumsum(np.append(0, np.random.default_rng(seed).integers(20, 300, rows - 1)))


def data_of(head: str, cells, seed: int = 1) -> str:
    z = np.random.default_rng(seed + 100).normal(size=len(cells))
    return f"{head},pos\n" + "".join(f"{cell},{value:.17g}\n" for cell, value in zip(cells, z))


def read(path, model, **layout):
    source = Source(path, Layout(**layout))
    return joining.record(source, model)


FORMS = {
    "seconds": ("t", lambda ms: f"{ms / 1000:.3f}"), "unit": ("t [ms]", str), "unit in the name": ("time_ms", str),
    "microseconds": ("timestamp_us", lambda ms: str(1000 * ms)), "minutes": ("t (min)", lambda ms: repr(ms / 60000)),
    "epoch": ("time", lambda ms: f"{1700000000 + ms // 1000}.{ms % 1000:03}"),
    "epoch ms": ("timestamp", lambda ms: str(1700000000000 + ms)),
    "epoch us": ("epoch", lambda ms: str((1700000000000 + ms) * 1000)),
    "iso": ("time", lambda ms: str(np.datetime64("2024-03-01T10:00:00.000") + ms)),
    "iso z": ("Date (UTC)", lambda ms: str(np.datetime64("2024-03-01T23:59:58.000") + ms) + "Z"),
    "iso zone": ("time", lambda ms: str(np.datetime64("2024-03-01T10:00:00.000") + ms).replace("T", " ") + "+02:00"),
    "clock": ("clock time", lambda ms: f"10:{ms // 60000:02}:{ms % 60000 / 1000:06.3f}"),
    "day first": ("Datum", lambda ms: f"31.05.2026 8:{ms // 60000:02}:{ms % 60000 / 1000:06.3f}"),
    "month first": ("date", lambda ms: f"5/31/2026 8:{ms // 60000:02}:{ms % 60000 / 1000:06.3f} PM"),
    "signed": ("t", lambda ms: f"{ms / 1000 - 7:.3f}"),
}


@pytest.mark.parametrize("blocks", [4, 65536])
@pytest.mark.parametrize("form", FORMS)
def test_each_form_is_read_to_the_nanosecond(form, blocks, tmp_path):
    head, cell = FORMS[form]
    ms = times_of()
    path = text_in(tmp_path, data_of(head, [cell(int(one)) for one in ms]))
    made = tables.joined(list(tables.read(path, ["pos"], blocks, dt=0.1))).times
    assert np.abs((made - made[0]) - ms / 1000).max() < 1e-9 if form != "clock" else 1e-8


@pytest.mark.parametrize("form", ["seconds", "epoch ms", "iso z"])
def test_run_takes_each_row_at_its_time(form, tmp_path):
    """The command's file beside the package's smoother; blocks and --smooth alike"""
    head, cell = FORMS[form]
    ms = times_of(3)
    data = text_in(tmp_path, data_of(head, [cell(int(one)) for one in ms], 3))
    model, out = cart(tmp_path), tmp_path / "o.csv"
    done = kalmanq("run", model, data, "--smooth", "--out", out, "--digits", 17)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    rows = rows_of(out)
    z = np.random.default_rng(103).normal(size=ROWS)
    right = Smoother(model_file.read(model)).run(z, times=ms / 1000)
    for name, column in (("x1_smoothed", right.smoothed[:, 0]), ("x2_sigma", right.sigma[:, 1]), ("loglik", right.log_likelihood)):
        assert np.allclose([float(row[name]) for row in rows], column, rtol=1e-9, atol=1e-12), name
    assert np.allclose([float(row["time"]) for row in rows], ms / 1000, atol=1e-9)
    told = json_of("run", model, data, "--forecast", 2)
    assert told["log_likelihood"] == pytest.approx(right.log_likelihood.sum(), rel=1e-10)
    f = Filter(model_file.read(model))
    f.run(z, times=ms / 1000)
    assert np.allclose(told["forecast"][1]["mean"], f.forecast(2).mean, rtol=1e-9)
    for more in (("--lag", 4), ("--robust", "huber"), ("--arith", "f32")):
        succeeds("run", model, data, *more)


def test_rows_in_steps_of_dt_are_those_without_times(tmp_path):
    model = cart(tmp_path)
    plain = kalmanq("simulate", model, "-n", 50)
    lines = plain.stdout.splitlines()
    cells = [line.split(",", 1) for line in lines[1:]]
    timed = [lines[0].replace("step", "time")] + [f"{0.1 * int(step):.6f},{rest}" for step, rest in cells]
    said = [kalmanq("run", model, text_in(tmp_path, "\n".join(text) + "\n"), "--json").stdout for text in (lines, timed)]
    assert said[0] == said[1] and '"rows": 50' in said[0]


REFUSED = {
    "back": ("t", ["0", "0.1", "0.3", "0.2"], "row 5, column t: .*back, from 0.3 to 0.2: --sort"),
    "missing": ("t", ["0", "0.1", "", "0.2"], "row 4, column t: .*missing: --skip-untimed"),
    "NA": ("t", ["0", "0.1", "NA", "0.2"], "row 4, column t: .*missing"),
    "no number": ("t", ["0", "0.1", "x", "0.2"], "row 4, column t: 'x' .*numbers: --time"),
    "local dates": ("t", ["01.05.2026 08:00", "01.05.2026 08:01"], "row 2, column t: '01.05.2026 08:00' .*certain"),
    "two orders": ("t", ["31.05.2026 08:00", "05.31.2026 08:01"], "row 2, column t: '31.05.2026 08:00' .*certain"),
    "no local date": ("t", ["31.05.2026 08:00", "x"], "row 3, column t: 'x' .*date"),
    "no time": ("t", ["warm", "cold"], "row 2, column t: 'warm' "),
    "zones": ("time", ["2024-01-01T00:00:00Z", "2024-01-01T00:00:01+01:00"],
              "row 3, column time: 2024-01-01T00:00:01.01:00: .0100, .*UTC: .*one zone"),
    "half a zone": ("time", ["2024-01-01T00:00:00Z", "2024-01-01T00:00:01"], "row 3, column time: .*zone"),
    "no unit": ("t", ["0", "100", "210", "300"], r"column t: .*unit .*is 100, dt is 0.1: --time 't \[ms\]'"),
    "counter": ("t", ["100000000", "100100000", "100200000"], "unit .*certain"),
    "other unit": ("t [mm]", ["0", "1"], "row 2, column t .mm.: mm .*units s, "),
    "midnight": ("time", ["23:59:59", "00:00:00"], "back, .*clock"),
    "other kind": ("t", ["0", "0.1", "2024-01-01"], "row 4, column t: '2024-01-01' .*numbers"),
    "no date": ("t", ["2024-01-01", "2024-13-01"], "row 3, column t: '2024-13-01' .*dates"),
    "infinite": ("t", ["0", "inf"], "row 3, column t: 'inf' "),
}


@pytest.mark.parametrize("which", REFUSED)
def test_what_is_no_time_is_one_line_with_its_row_and_the_cure(which, tmp_path):
    head, cells, said = REFUSED[which]
    model, path, out = cart(tmp_path), text_in(tmp_path, data_of(head, cells)), tmp_path / "out.csv"
    with pytest.raises(KalmanqError, match=said):
        read(path, model_file.read(model))
    for command in (("run", model, path, "--out", out), ("report", model, path, "-o", out)):
        refused(kalmanq(*command), str(path))
        assert not out.exists()


def test_the_order_of_the_first_rows_holds(tmp_path):
    cells = [f"{day:02}.{month:02}.2026" for day, month in ((12, 5), (13, 5), (1, 6), (2, 6))]
    path = text_in(tmp_path, data_of("t", cells))
    assert tables.joined(list(tables.read(path, ["pos"], 2, dt=86400.0))).times.tolist() == [86400.0 * k for k in (0, 1, 20, 21)]


def test_without_pandas_other_dates_are_one_line(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    path = text_in(tmp_path, data_of("t", ["31.05.2026 08:00", "31.05.2026 08:01"]))
    with pytest.raises(KalmanqError, match=r"row 2, column t: .*tools\[pandas\]"):
        read(path, model_file.read(cart(tmp_path)))


def test_a_row_in_a_later_block_is_told(tmp_path):
    path = text_in(tmp_path, data_of("t", [f"{0.1 * k:.3f}" for k in (0, 1, 2, 3, 4, 5, 4.5, 7)]))
    with pytest.raises(KalmanqError, match="row 8, column t: .*from 0.500 to 0.450"):
        list(tables.read(path, ["pos"], 2, dt=0.1))
    path = text_in(tmp_path, data_of("t", ["0", "0.1", "0.2", "0.2"]))  # of a model whose steps of no length are some
    with pytest.raises(KalmanqError, match="row 5, column t: 0.2 .*before"):
        list(tables.read(path, ["pos"], 3, dt=0.1, repeats=False))


def test_sorted_on_demand(tmp_path):
    ms = times_of(5)
    cells = [f"{one / 1000:.3f}" for one in ms]
    lines = data_of("t", cells, 5).splitlines()
    order = np.random.default_rng(0).permutation(ROWS)
    model, straight = cart(tmp_path), text_in(tmp_path, "\n".join(lines) + "\n", "a.csv")
    mixed = text_in(tmp_path, "\n".join([lines[0], *(lines[1 + k] for k in order)]) + "\n", "b.csv")
    a, b = tmp_path / "a.out", tmp_path / "b.out"
    succeeds("run", model, straight, "--out", a)
    succeeds("run", model, mixed, "--sort", "--out", b)
    columns = [np.genfromtxt(one, delimiter=",", names=True) for one in (a, b)]
    assert np.allclose(columns[0]["x1_mean"], columns[1]["x1_mean"], rtol=1e-10, atol=1e-12)
    twice = text_in(tmp_path, "\n".join([lines[0], *(lines[1 + k] for k in order), lines[3]]) + "\n", "c.csv")
    done = kalmanq("run", model, twice, "--sort")
    assert done.returncode == 0 and done.stderr.count("\n") == 1 and "row 32: gives a cell again" in done.stderr


def test_the_column_is_found_or_said(tmp_path):
    model = cart(tmp_path)
    cells = in_seconds()
    texts = {"t": data_of("t", cells), "clk": data_of("clk", cells)}
    likelihood = {}
    for name, more in (("t", ()), ("clk", ("--time", "clk")), ("clk", ()), ("t", ("--time", "none"))):
        done = kalmanq("run", model, text_in(tmp_path, texts[name]), "--json", *more)
        likelihood[name, more] = json.loads(done.stdout)["log_likelihood"]
    assert likelihood["t", ()] == likelihood["clk", ("--time", "clk")] != likelihood["clk", ()]
    assert likelihood["clk", ()] == likelihood["t", ("--time", "none")]
    ms = text_in(tmp_path, data_of("t", list(map(str, times_of()))))
    assert "is not certain" in kalmanq("run", model, ms).stderr
    said = json_of("run", model, ms, "--time", "t [ms]")["log_likelihood"]
    assert said == pytest.approx(likelihood["t", ()], rel=1e-9)
    refused(kalmanq("run", model, ms, "--time", "when"), "--time: there is no column when; there are t, pos")


def test_days_are_not_taken_for_a_dt_of_1_without_a_word(tmp_path):
    model = cart(tmp_path, CART.replace("dt = 0.1", "dt = 1.0"))
    done = kalmanq("run", model, text_in(tmp_path, data_of("date", [f"2024-01-{day:02}" for day in range(1, 20)])))
    assert done.returncode == 0 and done.stderr.count("\n") == 1
    assert "the median step of column date is 86400 s, dt is 1: times are in seconds here" in done.stderr


def read_and_told(path, layout=None, dt=1.0):
    """The times of all rows, and the warnings"""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        block, = tables.read(Source(path, layout or Layout()), ["pos"], dt=dt, cure="")
    return block.times, [str(one.message) for one in told]


@pytest.mark.parametrize("unit", ["s", "us"])
def test_a_unit_that_is_wrong_by_a_thousand_is_warned_of(unit, tmp_path):
    path = text_in(tmp_path, data_of(f"t [{unit}]", [str(1000 * k) for k in range(20)]))
    _, told = read_and_told(path)
    assert len(told) == 1 and "--time 't [ms]' says another unit of the column" in told[0]
    assert not read_and_told(path, Layout(time="t [ms]"))[1]


@pytest.mark.parametrize("head, per_second", [("millis", 1000), ("millis()", 1000), ("ms", 1000), ("uptime_ms", 1000), ("micros", 1e6),
                                              ("elapsed", 1), ("seconds", 1), ("ts", 1), ("clock,date", None), ("Datum,Uhrzeit", None)])
def test_names_that_loggers_give_are_times(head, per_second, tmp_path):
    steps = np.cumsum([0, *([1] * 9), 5, *([1] * 9)])
    parts = {"date": "2026-03-01", "Datum": "2026-03-01"}
    cells = [",".join(parts.get(one, f"9:00:{k:02}") for one in head.split(",")) if per_second is None else f"{k * per_second:.0f}" for k in steps]
    times, told = read_and_told(text_in(tmp_path, data_of(head, cells)))
    assert times.tolist() == steps.tolist() and not told


def test_a_clock_goes_on_over_midnight_where_a_date_is_beside_it(tmp_path):
    at = ["2026-02-28,23:59:58", "2026-02-28,23:59:59", "2026-03-01,0:00:00", "2026-03-01,00:00:01"]
    assert read_and_told(text_in(tmp_path, data_of("date,time", at)))[0].tolist() == [0, 1, 2, 3]
    turned = [",".join(one.split(",")[::-1]) for one in at]
    assert read_and_told(text_in(tmp_path, data_of("time,date", turned)))[0].tolist() == [0, 1, 2, 3]
    other = ["8:00:00,01.03.2026", "8:00:01,01.03.2026", "08:00:02,01.03.2026"]  # no date of ISO 8601: the clock alone
    assert read_and_told(text_in(tmp_path, data_of("time,date", other)))[0].tolist() == [0, 1, 2]
    seconds = ["2026-03-01 08:00:00,5", "2026-03-01 08:00:01,5"]
    assert read_and_told(text_in(tmp_path, data_of("date,time", seconds)))[0].tolist() == [0, 1]


@pytest.mark.parametrize("rows", [2, 65536])
def test_a_hole_in_a_date_is_told_with_its_row(rows, tmp_path):
    at = [f"2026-02-28,9:00:{k:02}" for k in range(8)]
    for hole, cell in ((0, ",9:00:00"), (4, ",9:00:04"), (5, "2026-02-28,")):
        path = text_in(tmp_path, data_of("date,time", [*at[:hole], cell, *at[hole + 1:]]))
        with pytest.raises(KalmanqError, match=f"row {hole + 2}, .*missing"):
            list(tables.read(Source(path, Layout()), ["pos"], rows, dt=1.0, cure=""))


def test_a_column_that_rises_like_a_clock_and_is_not_taken_is_warned_of(tmp_path):
    cells = [f"{0.1 * k + (1 if k > 12 else 0):.3f}" for k in range(20)]
    for head, at, lines in (("sample", cells, 1), ("step", cells, 0), ("sample", list(map(str, range(20))), 0),
                            ("x_true", cells, 0), ("sample", ["ok"] * 20, 0), ("sample", cells[::-1], 0)):
        times, told = read_and_told(text_in(tmp_path, data_of(head, at)), dt=0.1)
        assert times is None and len(told) == lines, (head, told)
    done = kalmanq("run", cart(tmp_path), text_in(tmp_path, data_of("sample", cells)))
    assert done.returncode == 0 and done.stderr.count("\n") == 1 and "column sample rises like a clock" in done.stderr
    for layout in (Layout(time="none"), Layout(time="sample [s]")):
        assert not read_and_told(text_in(tmp_path, data_of("sample", cells)), layout, 0.1)[1]


def test_a_model_of_steps_is_told_of_the_cure(tmp_path):
    model, data = text_in(tmp_path, STEPS, "steps.toml"), text_in(tmp_path, data_of("t", in_seconds()))
    done = kalmanq("run", model, data)
    assert done.returncode == 0 and done.stderr.count("\n") == 1
    assert "times of column t are irregular" in done.stderr and "give F, Qc and dt in the place of A and Q" in done.stderr
    assert kalmanq("run", model, data, "--time", "none").stderr == ""
    for option in ("--sort", "--jitter=0.1"):
        refused(kalmanq("run", model, data, option), "of a linear model with F, Qc and dt")


def test_jitter_is_rounded_on_demand(tmp_path):
    model = cart(tmp_path)
    draw = np.random.default_rng(2)
    times = 0.1 * np.arange(40) + draw.uniform(-0.002, 0.002, 40)
    data = text_in(tmp_path, data_of("t", [f"{one:.6f}" for one in times]))
    regular = text_in(tmp_path, data_of("t", [f"{0.1 * k:.6f}" for k in range(40)]), "regular.csv")
    said = {more: kalmanq("run", model, path, "--json", *more).stdout for path, more in
            ((data, ()), (data, ("--jitter", "0.05")), (regular, ("--time", "t")))}
    assert said["--jitter", "0.05"] == said["--time", "t"] != said[()]
    jittery = text_in(tmp_path, CART.replace("dt = 0.1", "dt = 0.1\njitter = 0.05"), "jitter.toml")
    assert json_of("run", jittery, data)["mean"] == json.loads(said["--time", "t"])["mean"]
    for more, *said in ((("--compiled",), "--compiled: a filter of steps of dt = 0.1 alone", "s is not 1 to "),
                        (("--as", "tables", "--arith", "f32"), "--as: ", "s is not one: ")):
        refused(kalmanq("run", model, data, *more), (*said, "--jitter"))
    succeeds("run", model, data, "--as", "tables", "--arith", "f32", "--jitter", "0.05")
    assert "jitter" in model_file.text_of(model_file.read(jittery))
    wrong = text_in(tmp_path, CART.replace("dt = 0.1", "dt = 0.1\njitter = 0.5"), "wrong.toml")
    assert "line 6: jitter: is not a share of dt from 0 to below 0.5" in kalmanq("run", wrong, data).stderr


@pytest.mark.usefixtures("no_offers")
def test_report_and_compare_take_the_times(tmp_path):
    """Of a record that only fits at its own times"""
    model, times = cart(tmp_path), times_file(tmp_path, 400)
    data = tmp_path / "drawn.csv"
    succeeds("simulate", model, "--at", times, "--out", data, "--seed", 4)
    assert data.read_text().startswith("step,time,pos\n0,0,")
    told = json_of("run", model, data)
    assert told["rows"] == 400 and abs(told["nis_per_measurement"] - 1) < 0.2
    assert json_of("run", model, data, "--time", "none")["nis_per_measurement"] > 1.5
    done = kalmanq("report", model, data, "-o", tmp_path / "r.html")
    assert done.returncode == 0 and "The data fit the model." in done.stdout, done.stdout
    figures = json_of("compare", model, data)
    assert figures["f32"]["mean_error_in_sigma"] < 1e-4 and "refused" in figures["q31"]


def test_fit_takes_the_times(tmp_path):
    model, data, out = cart(tmp_path), tmp_path / "drawn.csv", tmp_path / "fitted.toml"
    succeeds("simulate", model, "--at", times_file(tmp_path, 200), "--out", data)
    done = kalmanq("fit", model, data, "--q-form", "multiple", "--out", out)
    assert done.returncode == 0 and "Qc[1,1]" in done.stdout and "at the maximum" in done.stdout, done.stderr
    fitted = model_file.read(out)
    assert 0.2 < fitted.continuous.Qc[1, 1] < 1.2 and abs(fitted.R[0, 0] / 0.04 - 1) < 0.4 and fitted.continuous.dt == 0.1
    told = json_of("fit", model, data, "--q-form", "multiple")
    assert told["Qc"][1][1] == pytest.approx(fitted.continuous.Qc[1, 1]) and told["standard_errors"]["R"][0][0] > 0
    refused(kalmanq("fit", model, data, "--free", "A,Q"), "A of records at irregular times is not fitted")


def test_many_runs_at_their_times(tmp_path):
    model, times = cart(tmp_path), times_file(tmp_path, 60)
    out = tmp_path / "runs.csv"
    done = kalmanq("simulate", model, "--at", times, "--runs", 60, "--out", out, "--workers", 1, "--smooth", "--json")
    told = json.loads(done.stdout)
    assert told["rows"] == 60 and told["nees"]["within"] and told["nis"]["within"]
    refused(kalmanq("simulate", model, "--at", times, "-n", 70), "has 60 rows, fewer than the 70 of -n")
    steps = text_in(tmp_path, STEPS, "steps.toml")
    assert "of a linear model with F, Qc and dt" in kalmanq("simulate", steps, "--at", times).stderr


def test_controls_stay_until_the_next_row(tmp_path):
    text = CART.replace("dt = 0.1", "dt = 0.1\nB = [0.0, 1.0]") + "\n[controls]\nnames = [\"push\"]\n"
    model, cells = text_in(tmp_path, text, "cart.toml"), times_of(2) / 1000
    u, z = np.random.default_rng(1).normal(size=ROWS), np.random.default_rng(2).normal(size=ROWS)
    data = text_in(tmp_path, "t,push,pos\n" + "".join(f"{a:.3f},{b:.17g},{c:.17g}\n" for a, b, c in zip(cells, u, z)))
    right = Filter(model_file.read(model)).run(z, u, times=cells)
    told = json_of("run", model, data)
    assert told["log_likelihood"] == pytest.approx(right.log_likelihood.sum(), rel=1e-9)


def test_rows_that_are_read_as_steps_say_that_they_are_not_alike(tmp_path):
    model = text_in(tmp_path, CART + "ranges = [50]\n[states]\nnames = [\"p\", \"v\"]\nranges = [50, 50]\n", "cart.toml")
    source = Source(text_in(tmp_path, data_of("t", in_seconds())))
    with pytest.warns(KalmanqWarning, match="one step .*resample"):
        list(tables.read(source, tables.wanted_of(model_file.read(model), dt=None, cure=tables.RESAMPLE)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert joining.record(source, model_file.read(model))[2] is not None
