"""Logs as loggers write them: rows of one time, rows without one, pauses, columns that the model file describes."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest
from command import kalmanq, refused, rows_of, succeeds
from library import text_in

from kalmanq import Filter, NonlinearFilter, NonlinearModel, Smoother
from kalmanq.data import joining
from kalmanq.data.layouts import Layout, Source
from kalmanq.model import model_file

WALK = """
[model]
F = [[0.0, 1.0], [0.0, 0.0]]
Qc = [0.0, 0.5]
dt = 0.1
H = [[1.0, 0.0], [1.0, 0.0]]
R = [0.04, 0.09]
P0 = [4.0, 1.0]

[measurements]
names = ["a", "b"]
ranges = [50, 50]

[states]
names = ["p", "v"]
ranges = [50, 50]
"""
ALONE = WALK.replace("H = [[1.0, 0.0], [1.0, 0.0]]", "H = [1.0, 0.0]").replace("R = [0.04, 0.09]", "R = 0.04").replace(
    'names = ["a", "b"]\nranges = [50, 50]', 'names = ["a"]\nranges = [50]')


def cells(*values) -> str:
    return ",".join("" if isinstance(one, float) and np.isnan(one) else f"{one:.17g}" for one in values) + "\n"


def drawn(seed: int, rows: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """Times of whole milliseconds, and two measurements of which the second one is there at times"""
    draw = np.random.default_rng(seed)
    z = draw.normal(size=(rows, 2))
    z[::3, 1] = np.nan
    return np.cumsum(np.append(0, draw.integers(20, 300, rows - 1))) / 1000, z


def told(*arguments):
    done = succeeds(*arguments, "--json")
    return json.loads(done.stdout), done.stderr


# ------------------------------------------------------------------------------ rows of one time


@pytest.mark.parametrize("rows", [3, 65536])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_cells_of_one_time_that_do_not_overlap_are_one_row(seed, rows, tmp_path):
    t, z = drawn(seed)
    text = "t,a,b\n" + "".join(cells(at, a, np.nan) + ("" if np.isnan(b) else cells(at, np.nan, b)) for at, (a, b) in zip(t, z))
    model = model_file.read(text_in(tmp_path, WALK, "walk.toml"))
    made = list(joining.blocks_of([Source(text_in(tmp_path, text))], model, rows))
    assert np.array_equal(np.concatenate([one.columns["b"] for one in made]), z[:, 1], equal_nan=True)
    assert np.allclose(np.concatenate([one.times for one in made]), t, atol=1e-12)


@pytest.mark.parametrize("arithmetic, within", [("f64", 1e-12), ("f32", 1e-5), ("q31", 1e-5)])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_cell_given_twice_is_two_measurements(arithmetic, within, seed, tmp_path):
    """As of a model that has two sensors"""
    t, z = drawn(seed)
    both = WALK.replace("0.09", "0.04")
    text = "t,a\n" + "".join(cells(at, one) for at, row in zip(t, z) for one in row if one == one)
    model, data = text_in(tmp_path, ALONE, "walk.toml"), text_in(tmp_path, text)
    done, said = told("run", model, data, "--arith", arithmetic, "--out", tmp_path / "o.csv", "--smooth")
    right = Smoother(model_file.read(text_in(tmp_path, both, "both.toml")), arithmetic).run(z, times=t)
    again = int(np.sum(~np.isnan(z[:, 1])))
    assert said.count("\n") == 1 and "row 4: gives a cell again" in said and f"and {again - 1} more" in said
    assert done["taken"] == 30 + again and abs(done["log_likelihood"] - right.log_likelihood.sum()) < 30 * within
    assert np.allclose(done["mean"], right.mean[-1], atol=within)
    rows = rows_of(tmp_path / "o.csv")
    last = [k for k, row in enumerate(rows) if k + 1 == len(rows) or rows[k + 1]["time"] != row["time"]]
    assert np.allclose([float(rows[k]["p_smoothed"]) for k in last], right.smoothed[:, 0], atol=within)


def test_rows_that_a_logger_repeats_are_counted(tmp_path):
    """They are taken, and told: no sensor says the same twice with errors of its own"""
    model, data = text_in(tmp_path, WALK, "walk.toml"), text_in(tmp_path, "t,a,b\n0,1,2\n0.1,2,\n0.1,2,\n0.2,3,4\n0.2,3,4\n0.2,3,5\n0.3,1,1\n")
    assert "row 4: gives a cell again" in (said := told("run", model, data)[1]) and "and 2 more" in said and "2 rows with the same numbers" in said


def test_controls_of_one_time_the_last_one_holds(tmp_path):
    text = WALK.replace("dt = 0.1", "dt = 0.1\nB = [0.0, 1.0]") + '[controls]\nnames = ["push"]\n'
    model = model_file.read(text_in(tmp_path, text, "walk.toml"))
    data = text_in(tmp_path, "t,a,b,push\n0,1,,5\n0,,2,7\n0.1,3,,1\n0.1,4,,\n0.2,,,0\n")
    z, u, times = joining.record(Source(data), model)
    assert u.ravel().tolist() == [7, 1, 1, 0] and times.tolist() == [0, 0.1, 0.1, 0.2]
    assert z[:3].tolist()[0] == [1, 2] and z[1, 0] == 3 and z[2, 0] == 4


def stepped(takes_dt: bool) -> NonlinearModel:
    def f(x, t, u, dt):
        return np.array([x[0] + dt * x[1], x[1] - dt * np.sin(x[0])])

    noise = (lambda x, t, u, dt: dt * np.diag([1e-3, 0.5])) if takes_dt else np.diag([1e-3, 0.5])
    return NonlinearModel(x0=[0, 0], P0=[4.0, 1.0], Q=noise, R=[0.04], f=f, h=lambda x, t, u: np.array([x[0]]), dt=0.1)


def test_a_nonlinear_model_has_steps_of_no_length_where_its_noise_takes_dt():
    times, z = np.array([0, 0.1, 0.1, 0.3]), np.arange(4.0)
    run = NonlinearFilter(stepped(True)).run(z, times=times)
    f = NonlinearFilter(stepped(True))
    f.update(z[:1]), f.predict(dt=0.1), f.update(z[1:2]), f.update(z[2:3]), f.predict(dt=0.2), f.update(z[3:])
    assert np.allclose(run.mean[-1], f.mean, rtol=1e-12)
    with pytest.raises(Exception, match="row 2: the time is not after"):
        NonlinearFilter(stepped(False)).run(z, times=times)


def test_blocks_of_rows_may_end_within_a_time():
    t, z = drawn(1)
    model = model_file.Model.of_continuous([[0, 1], [0, 0]], H=[1, 0], R=0.04, Qc=[0, 0.5], dt=0.1, P0=[4, 1])
    t = np.repeat(t, 2)
    whole, parts = Filter(model).run(z[:, [0, 0]].ravel(), times=t), Filter(model)
    for first in range(0, 60, 5):
        parts.run(z[:, [0, 0]].ravel()[first:first + 5], times=t[first:first + 5])
    assert np.array_equal(whole.mean[-1], parts.mean)
    with pytest.raises(Exception, match="row 1: the time is before"):
        Filter(model).run([1, 2], times=[1, 0.9])


# ------------------------------------------------------------------------------ rows without a time, pauses


def test_rows_without_a_time_are_left_out_on_demand(tmp_path):
    model, data = text_in(tmp_path, ALONE, "walk.toml"), text_in(tmp_path, "t,a\n,1\n0,2\n0.1,3\n,4\n0.2,5\n")
    assert kalmanq("run", model, data).returncode == 1
    done, said = told("run", model, data, "--skip-untimed")
    assert done["rows"] == 3 and "row 2: has no time, and is left out (and 1 more)" in said
    data.write_text("t,a\n,1\n0,2\n,3\n0.1,x\n")
    assert "row 5, column a" in kalmanq("run", model, data, "--skip-untimed").stderr


@pytest.mark.parametrize("more", [(), ("--smooth",)])
def test_a_pause_begins_a_new_record(more, tmp_path):
    model, parts = text_in(tmp_path, ALONE, "walk.toml"), []
    for seed in (1, 2, 3):
        t, z = drawn(seed, 20 + seed)
        parts.append((t + 100 * seed, z[:, 0]))
    data = text_in(tmp_path, "t,a\n" + "".join(cells(*row) for t, z in parts for row in zip(t, z)))
    right = [Smoother(model_file.read(model)).run(z, times=t) for t, z in parts]
    done, _ = told("run", model, data, "--pause", 10, "--out", tmp_path / "o.csv", *more)
    assert done["records"] == 3 and done["log_likelihood"] == pytest.approx(sum(one.log_likelihood.sum() for one in right), rel=1e-9)
    if more:
        made = [float(row["p_smoothed"]) for row in rows_of(tmp_path / "o.csv")]
        assert np.allclose(made, np.concatenate([one.smoothed[:, 0] for one in right]), atol=1e-9)
    z, _, times = joining.record(Source(data, Layout(pause=10.0)), model_file.read(model))
    assert len(z) == 23 == len(times)


def test_fit_takes_each_part_for_a_record(tmp_path):
    model, paths = text_in(tmp_path, ALONE, "walk.toml"), []
    for seed in (1, 2):
        t, z = drawn(seed, 20)
        paths.append(text_in(tmp_path, "t,a\n" + "".join(cells(a + 100 * seed, b) for a, b in zip(t, z[:, 0])), f"{seed}.csv"))
    one = text_in(tmp_path, paths[0].read_text() + paths[1].read_text().split("\n", 1)[1], "one.csv")
    apart, cut = (told("fit", model, *data, "--method", "ml")[0] for data in (paths, (one, "--pause", 10)))
    assert cut["log_likelihood"] == pytest.approx(apart["log_likelihood"], rel=1e-9)


# ------------------------------------------------------------------------------ times as they are written

STEPS_OF = {  # a header, times, options, and the seconds since the first row
    "slashes": ("date", ["2024/03/01 23:59", "2024/03/02 00:00", "2024/3/2 0:01"[:8] + " 00:01"], {}, [0, 60, 120]),
    "points": ("time", ["2024.03.01", "2024.03.02", "2024.03.04"], {}, [0, 86400, 259200]),
    "basic": ("time", ["20240131T120000Z", "20240131T120001.5Z", "20240201T000000Z"], {}, [0, 1.5, 43200]),
    "digits": ("timestamp", ["20240131120000", "20240131120002"], {}, [0, 2]),
    "days of digits": ("date", ["20240228", "20240229", "20240301"], {}, [0, 86400, 172800]),
    "index of pandas": ("", ["2016-11-01", "2016-11-02", "2016-11-04"], {}, [0, 86400, 259200]),
    "day and clock": ("date,time", ["2024/03/01,23:40", "2024/03/01,23:50", "2024/03/02,0:00"], {}, [0, 600, 1200]),
    "number of the day": ("day,time", ["1,23:40", "1,23:50", "2,00:00"], {}, [0, 600, 1200]),
    "hhmm": ("day,hhmm", ["31,2350", "32,0", "32,10", "32,100"], {}, [0, 600, 1200, 4200]),
    "day of a year": ("year,doy,hhmm", ["2023,365,2350", "2024,1,0"], {}, [0, 600]),
    "parts": ("year,month,day,hour,minute", ["2024,2,28,23,30", "2024,2,29,0,0", "2024,3,1,0,0"], {}, [0, 1800, 88200]),
    "months": ("year,month", ["2023,12", "2024,1", "2024,2"], {}, [0, 31 * 86400, 62 * 86400]),
    "a format": ("when", ["1.2.24 8h", "1.2.24 20h", "2.3.24 8h"], {"time": "when", "time_format": "%d.%m.%y %Hh"}, [0, 43200, 30 * 86400]),
    "a format of two": ("d,h", ["1.2.24,8", "1.2.24,20"], {"time": "d,h", "time_format": "%d.%m.%y %H"}, [0, 43200]),
    "two that are said": ("day,hhmm,time", ["1,2350,x", "2,0,x"], {"time": "day,hhmm"}, [0, 600]),
    "seconds beside a day": ("day,time", ["1,0", "1,1.5", "1,3"], {}, [0, 1.5, 3]),
}


@pytest.mark.filterwarnings("ignore:.*median step")
@pytest.mark.parametrize("which", STEPS_OF)
def test_times_are_read_as_they_are_written(which, tmp_path):
    head, at, layout, seconds = STEPS_OF[which]
    source = Source(text_in(tmp_path, f"{head},a\n" + "".join(f"{one},1\n" for one in at)), Layout(**layout))
    dt = float(np.median(np.diff(seconds)))
    model = model_file.read(text_in(tmp_path, ALONE.replace("dt = 0.1", f"dt = {dt}"), "walk.toml"))
    assert joining.record(source, model)[2].tolist() == seconds


NO_TIMES = {  # and what is said
    "hole": ("day,hhmm", ["1,0", ",10"], (), "row 3, column day: .*missing"),
    "hhmm": ("day,hhmm", ["1,0", "1,2575"], (), "row 3, column day: '1970-01-01 25:75' is no time"),
    "month": ("year,month", ["2024,1", "2024,13"], (), "row 3, column year: '2024 13' is no time"),
    "format": ("t", ["1.2.24", "2024-02-02"], ("--time-format", "%d.%m.%y"), "row 3, column t: '2024-02-02' is not written as --time-format"),
    "no format": ("d,h", ["1.2.24,8", "1.2.24,20"], ("--time", "d,h"), "--time-format says"),
    "a column": ("d,h", ["1.2.24,8", "1.2.24,20"], ("--time", "d,x"), "there is no column d,x; there are d, h"),
    "midnight": ("day,hhmm", ["31,2350", "1,0"], (), "row 3, column day: the time goes back"),
}


@pytest.mark.parametrize("which", NO_TIMES)
def test_what_is_no_time_has_its_row(which, tmp_path):
    head, at, more, said = NO_TIMES[which]
    model, data = text_in(tmp_path, ALONE, "walk.toml"), text_in(tmp_path, f"{head},a\n" + "".join(f"{one},1\n" for one in at))
    done = kalmanq("run", model, data, *more)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and re.search(said, done.stderr), done.stderr


# ------------------------------------------------------------------------------ columns that the model file describes

TANK = """
[model]
A = [[0.9]]
Q = [0.01]
H = [[1.0], [1.0]]
R = [0.04, 0.09]
P0 = [4.0]

[measurements]
names = ["near", "far"]
units = ["m", "m"]
columns = ["LVL [cm]", "far"]
factors = [0.01, -1.0]
offsets = [0.5, 10.0]
missing = [[-127, "ERR"], []]
plausible = [[0, 4], []]
ranges = [8, 20]

[recording]
separator = ";"
time = "none"
"""


def test_columns_are_what_the_model_file_says(tmp_path):
    model, data = text_in(tmp_path, TANK, "tank.toml"), text_in(tmp_path, "t;LVL [cm];far\n1;100;9\n2;-127;8\n4;ERR;7\n7;900;\n8;350;6\n")
    z, _, _ = joining.record(Source(data), model_file.read(model))
    assert np.array_equal(z, [[1.5, 1], [np.nan, 2], [np.nan, 3], [np.nan, np.nan], [4, 4]], equal_nan=True)
    done, said = told("run", model, data)
    assert done["missing"] == 4 and said.count("\n") == 1 and "row 5: near = 9.5 is not plausible, 0 to 4 is: it is missing" in said
    for command in (("fit", "--method", "em", "--iterations", 2), ("report", "-o", tmp_path / "r.html"), ("check",)):
        assert "row 5: near = 9.5" in kalmanq(command[0], model, data, *command[1:]).stderr
    assert told("run", model, text_in(tmp_path, "x,far\n100,9\n", "b.csv"), "--separator", ",", "--rename", "near=x")[0]["mean"] != done["mean"]
    for text in (model_file.text_of(model_file.read(model)),):
        again = model_file.read(text_in(tmp_path, text, "again.toml"))
        assert again.measurements == model_file.read(model).measurements and again.recording == model_file.read(model).recording


@pytest.mark.parametrize("separator, decimal", [(";", "."), ("tab", ","), (";", ",")])
def test_what_is_drawn_reads_back(separator, decimal, tmp_path):
    model = text_in(tmp_path, TANK.replace('separator = ";"\n', f'separator = "{separator}"\ndecimal = "{decimal}"\n'), "tank.toml")
    plain = text_in(tmp_path, "\n".join(line for line in TANK.splitlines() if line.split(" ")[0] not in (
        "columns", "factors", "offsets", "missing", "plausible", "separator")), "plain.toml")
    for name, path in (("a.csv", model), ("b.csv", plain)):
        succeeds("simulate", path, "-n", 50, "--out", tmp_path / name)
    assert (tmp_path / "a.csv").read_text().startswith("step;LVL [cm];far\n".replace(";", "\t" if separator == "tab" else separator))
    a, b = (joining.record(Source(tmp_path / name), model_file.read(path))[0] for name, path in (("a.csv", model), ("b.csv", plain)))
    is_there = ~np.isnan(a)
    assert np.allclose(a[is_there], b[is_there], atol=1e-12) and np.all(is_there[(b[:, 0] > 0) & (b[:, 0] < 4), 0])


@pytest.mark.parametrize("time, cells", [("stamp [ms]", ["0", "100", "200"]), ("uptime_us", ["0", "100000", "200000"]), ("when", ["0", "0.1", "0.2"])])
def test_times_are_drawn_as_the_model_file_says(time, cells, tmp_path):
    model = text_in(tmp_path, f'{ALONE}\n[recording]\ntime = "{time}"\n', "walk.toml")
    rows = list(csv.reader(kalmanq("simulate", model, "-n", 3, "--at", text_in(tmp_path, f"{time}\n" + "\n".join(cells) + "\n", "t.csv")).stdout.splitlines()))
    assert rows[0][1] == time and np.allclose([float(row[1]) for row in rows[1:]], list(map(float, cells)))
    done = kalmanq("run", model, "-", input="\n".join(map(",".join, rows)) + "\n")
    assert done.returncode == 0 and not done.stderr, done.stderr


@pytest.mark.parametrize("change, said", [
    (("columns = [", "columns = [1, "), "columns is not a list of texts"), (("0.01, -1.0", "0.0, -1.0"), "a factor other than 0"),
    (("[[0, 4], []]", "[[4, 0], []]"), "plausible: "), (('[[-127, "ERR"], []]', "[[-127], [true]]"), "missing: a cell"),
    (('time = "none"', "pause = 0"), "pause is above 0"), (('time = "none"', "sort = 1"), "sort is not true or false"),
    (('time = "none"', 'when = "t"'), "when: no such key in .recording."), (("factors = [0.01, -1.0]", "factors = [0.01]"), "has 1 factor")])
def test_what_is_no_description_of_columns(change, said, tmp_path):
    assert TANK != (text := TANK.replace(*change))
    with pytest.raises(model_file.ModelFileError, match=f"line [0-9]+: .*{said}"):
        model_file.read(text_in(tmp_path, text, "tank.toml"))


def test_a_unit_without_a_factor_is_refused(tmp_path):
    text = TANK.replace("factors = [0.01, -1.0]\noffsets = [0.5, 10.0]\n", "")
    refused(kalmanq("run", text_in(tmp_path, text, "tank.toml"), text_in(tmp_path, "LVL [cm];far\n1;2\n")),
            ("LVL [cm] is in cm, the model has near in m", "factors"))


def test_a_nonlinear_file_says_it_alike(tmp_path):
    model = text_in(tmp_path, """
x0, P0, Q, R = [1.0], [1.0], [0.01], [0.04]
measurements = {"names": ["level"], "columns": ["LVL"], "factors": [0.01], "missing": [[-127]]}
recording = {"separator": ";"}

def f(x, t, u):
    return [0.9 * x[0]]

def h(x, t, u):
    return [x[0]]
""", "tank.py")
    done, _ = told("run", model, text_in(tmp_path, "LVL;b\n100;1\n-127;2\n"))
    assert done["missing"] == 1 and done["taken"] == 1


LATE = """
[model]
F = [[0.0, 1.0], [0.0, 0.0]]
Qc = [0.0, 0.5]
dt = 0.1
P0 = [4.0, 1.0]

[[sensors]]
name = "speed"
H = [0.0, 1.0]
R = 0.01

[[sensors]]
name = "gps"
H = [1.0, 0.0]
R = 0.25
delay = 0.45
measured = "gps_time"
"""


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_late_times_are_drawn_and_read_back(seed, tmp_path):
    model, out = text_in(tmp_path, LATE, "late.toml"), tmp_path / "o.csv"
    succeeds("simulate", model, "-n", 600, "--seed", seed, "--truth", "-o", out)
    rows = rows_of(out)
    late = np.array([float(row["time"]) - float(row["gps_time"]) for row in rows if row["gps_time"]])
    assert late.min() == 0 and 0.39 < late.max() < 0.45 + 1e-9 and len(np.unique(np.round(late, 6))) == 5 and len(late) > 300
    off = [float(row["gps"]) - float(rows[round(10 * float(row["gps_time"]))]["x1_true"]) for row in rows if row["gps"]]
    assert np.std(off) == pytest.approx(0.5, rel=0.15)
    done, said = told("run", model, out)
    assert not said and abs(done["nis_per_measurement"] - 1) < 0.2


# ------------------------------------------------------------------------------ pictures


@pytest.mark.parametrize("smooth", [True, False])
def test_a_picture_has_room_for_what_is_known(smooth):
    """Means that nothing was known of at first do not set its scale"""
    from kalmanq.pages import pictures

    draw = np.random.default_rng(1)
    model = model_file.Model([[1, 1, 0], [0, 1, 0], [0, 0, 0.9]], H=[1, 0, 1], R=0.01, Q=[1e-6, 1e-8, 1e-6], P0=None)
    z = 5 + 1e-3 * np.arange(300) + 0.1 * draw.normal(size=300)
    run = (Smoother if smooth else Filter)(model).run(z)
    figure = pictures.draw_run(run, z[:, None])
    for axis, i in zip(figure.axes, range(2)):
        low, high = axis.get_ylim()
        assert low < (run.smoothed if smooth else run.mean)[-1, i] < high
        assert high - low < (20 if smooth else 4 * pictures.WIDE) * (np.ptp(run.mean[150:, i]) + run.sigma[150, i])
    pictures.plt.close(figure)


def test_no_line_joins_two_records():
    from kalmanq.commands.run import _drawn_apart

    made = _drawn_apart([np.array([1.0, 2]), np.array([3.0]), np.array([9.0])], [1, 1, 2])
    assert np.array_equal(made, [1, 2, 3, np.nan, 9], equal_nan=True)
