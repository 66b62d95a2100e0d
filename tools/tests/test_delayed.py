"""Firmware that takes what was measured some steps ago: equal to the one in which nothing was late."""

from __future__ import annotations

import csv
import ctypes

import numpy as np
import pytest
from command import json_of, kalmanq, refused, succeeds
from driven import Called
from firmware_here import Firmware
from library import passes, saved
from whole import first

from kalmanq import Filter
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.equation_records import recorded
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import compiled
from kalmanq.core import lib
from kalmanq.compiler.text.over_library import bytes_of_delays
from kalmanq.firmware.steps_kept import latest_of
from kalmanq.model import Model, Quantity, Sensor, model_file
from kalmanq.nonlinear import read, simulate


class Late(Called):
    """The compiled filter's NAME_delayed"""

    STRUCT, NOW, MORE = "delayed", "p->now", "void begin({name}_delayed *p) {{ {name}_start(&p->now), {name}_delayed_start(p); }}\n"
    FLAGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror")

    def start(self):
        self.library.begin(self.f)

    def predict(self, u, dt=0.0):
        """Of steps of any length: whether dt is one"""
        of_any = self.product.given.options.tunable
        done = self.call("delayed_predict", *self.controls(u), *([self.type(dt)] if of_any else []))
        return done if of_any else 1

    def update(self, z, present, ago):
        return self.call("delayed_update", self.words("measurements", np.nan_to_num(z)), *map(ctypes.c_uint, (int(present), int(ago))))

    @property
    def events(self):
        return self.library.events(self.f)


class Tuned(Late):
    MORE = Late.MORE + """\
void set_r({name}_delayed *p, int j, double value) {{ p->now.r[j] = value; }}
double r(const {name}_delayed *p, int j) {{ return p->now.r[j]; }}
"""


def some_model(seed: int, continuous: bool = False, pushes: bool = True) -> Model:
    """Two or three sensors, of which one or two are late"""
    draw = np.random.default_rng(seed)
    n, m = int(draw.integers(1, 5)), int(draw.integers(2, 4))
    sensors = [Sensor(f"s{j}", (f"z{j}",), float(draw.integers(1, 9)) * (0.1 if continuous else 1) if j else 0.0) for j in range(m)]
    turned = np.linalg.qr(draw.normal(size=(n, n)))[0] * draw.uniform(0.5, 0.99)
    root = draw.normal(size=(n, n))
    given = {"F": turned - 1.5 * np.eye(n), "Qc": root @ root.T, "dt": 0.1} if continuous else {"A": turned, "Q": 0.1 * root @ root.T}
    offsets = {"c": draw.normal(size=n), "d": draw.normal(size=m)} if seed % 2 else {}
    l = int(pushes and seed % 3 > 0)
    B = {"B": draw.normal(size=(n, l)), "controls": [Quantity("push", range=50.0)]} if l else {}
    made = (Model.of_continuous if continuous else Model)(H=draw.normal(size=(m, n)), R=np.diag(draw.uniform(0.01, 1, m)), P0=10 * np.eye(n), x0=np.zeros(n), **given, **offsets, **B,
                 states=[Quantity(f"x{i}", range=200.0) for i in range(n)],
                 measurements=[Quantity(f"z{j}", range=500.0) for j in range(m)])
    made.sensors = tuple(sensors)
    return made


def log_of(model: Model, seed: int, rows: int = 70):
    """What is measured in each row, the row in which each component is told, and controls"""
    draw = np.random.default_rng(seed + 1000)
    m, latest = model.m, latest_of(model)
    z, u = draw.normal(size=(rows, m), scale=3.0).astype(np.float32), draw.normal(size=(rows, len(model.inputs))).astype(np.float32)
    is_there = draw.random((rows, m)) < 0.7
    is_there[rows - latest:] = False
    told = np.arange(rows)[:, None] + np.where([one.delay > 0 for one in model.sensors], draw.integers(0, latest + 1, (rows, m)), 0)
    return z.astype(float), u.astype(float), is_there, told


def given_late(late: Late, z, u, is_there, told, dt=None):
    """In any order within a row"""
    for t in range(len(z)):
        if t:
            assert late.predict(u[t - 1], 0.0 if dt is None else dt[t])
        for row in sorted(set(range(max(0, t - 40), t + 1)), key=lambda one: (one * 7919) % 31):
            present = int((is_there[row] & (told[row] == t)) @ (1 << np.arange(z.shape[1])))
            if present:
                assert late.update(z[row], present, t - row) == present, (t, row)


OPTIONS = [Options(), Options("q31"), Options(gate=2.0), Options("f64"), Options("f64", student=4.0), Options(nis=True),
           Options("q31", gate=2.5), Options(loops=True), Options("q31", loops=True)]


@pytest.mark.parametrize("seed, options", first(5, [(seed + 10 * k, one) for seed in range(10) for k, one in enumerate(OPTIONS)]))
def test_compiled_bits_are_those_of_the_run_in_which_nothing_was_late(seed, options, tmp_path):
    model = some_model(seed)
    product = compiled(model, "late", options)
    z, u, is_there, told = log_of(model, seed)
    late = Late(product, tmp_path)
    assert len(late.f) == product.ram_delayed
    if options.gate is None:
        given_late(late, z, u, is_there, told)
    else:  # what the gate takes depends on what is known then
        for t in range(len(z)):
            if t:
                late.predict(u[t - 1])
            for row in range(t + 1):
                late.update(z[row], int((is_there[row] & (told[row] == t)) @ (1 << np.arange(model.m))), t - row)
    with Host(product) as host:
        ran = host.run(np.where(is_there, z, np.nan), np.vstack([np.zeros((1, product.given.of.l)), _with_one(u, model)[:-1]]))
    mean, covariance = late.read()
    assert np.array_equal(mean, ran.mean[-1]) and np.array_equal(covariance, ran.covariance[-1])


def _with_one(u, model):
    return np.column_stack([u, np.ones((len(u), model.l - len(model.inputs)))])


@pytest.mark.parametrize("seed", first(1, [3, 4, 5]))
def test_steps_of_any_length(seed, tmp_path):
    """As when the same calls come in time"""
    model = some_model(seed, continuous=True, pushes=False)
    product = compiled(model, "late", Options("f64", tunable=True))
    z, u, is_there, told = log_of(model, seed)
    dt = np.random.default_rng(seed).uniform(0.05, 0.2, len(z))
    late = Late(product, tmp_path)
    assert len(late.f) == product.ram_delayed and late.predict(u[0], -1.0) == 0
    given_late(late, z, u, is_there, told, dt)
    mean, covariance = late.read()
    late.start()
    given_late(late, z, u, is_there, np.arange(len(z))[:, None] + np.zeros((1, model.m), int), dt)
    for made, right in zip((mean, covariance), late.read()):
        assert np.array_equal(made, right)


def test_a_variance_that_a_program_sets_holds(tmp_path):
    """Of all steps that are kept, as of those that come"""
    model = some_model(3, continuous=True, pushes=False)
    product = compiled(model, "late", Options("f64", tunable=True))
    z, u, is_there, told = log_of(model, 3)
    ends = []
    for is_late in (True, False):
        late = Tuned(product, tmp_path / str(is_late))
        late.library.set_r(late.f, 1, ctypes.c_double(7.0))
        given_late(late, z, u, is_there, told if is_late else np.arange(len(z))[:, None] + np.zeros((1, model.m), int), np.full(len(z), 0.1))
        ends.append(late.read())
    late.library.set_r(late.f, 1, ctypes.c_double(model.R[1, 1]))
    late.library.r.restype = ctypes.c_double
    assert all(np.array_equal(*pair) for pair in zip(*ends)) and late.library.r(late.f, 1) == model.R[1, 1]


def test_what_is_no_step_that_is_kept_is_refused(tmp_path):
    model = some_model(1)
    product = compiled(model, "late", Options())
    late, kept = Late(product, tmp_path), latest_of(model)
    told = [name for name in product.events]
    bit = 1 << told.index("TOO_LATE")
    assert late.update(np.ones(model.m), 1, 1) == 0 and late.events == bit  # before the first step
    for _ in range(kept + 3):
        late.predict(np.zeros(1))
    before = late.read()
    assert late.update(np.ones(model.m), 1, kept + 1) == 0 and late.update(np.ones(model.m), 0, kept) == 0
    assert all(np.array_equal(one, other) for one, other in zip(before, late.read()))
    assert late.update(np.ones(model.m), 3, kept) == 3 and late.update(np.ones(model.m), 2, kept) == 0
    assert late.update(np.full(model.m, 1e30), 1, 0) == 0 and late.events == bit | 1


# ------------------------------------------------------------------------------ over the library, as design writes it

ROOM = """
[model]
name = "room"
{model}
x0 = [20.0, 0.0]
P0 = [4.0, 1.0]
{more}
[states]
ranges = [100, 20]
[controls]
names = ["heat"]
ranges = [10]
[[sensors]]
name = "quick"
H = [1.0, 0.0]
R = 0.25
ranges = [100]
[[sensors]]
name = "reference"
H = [[1.0, 1.0], [0.5, 0.0]]
R = [0.01, 0.4]
d = [-1.5, 0.0]
ranges = [100, 100]
delay = {delay}
"""
IN_STEPS = "A = [[0.98, 0.05], [0.0, 0.9]]\nB = [0.1, 0.0]\nQ = [0.01, 0.02]"
CONTINUOUS = "F = [[-0.2, 0.5], [0.0, -1.0]]\nB = [1.0, 0.0]\nQc = [0.1, 0.2]\ndt = 0.1"


def room(folder, model: str = IN_STEPS, delay: float = 4, more: str = ""):
    path = saved(folder / "room.toml", ROOM.format(model=model, delay=delay, more=more))
    return path


class Words:
    """Numbers of a row as the firmware takes them, and as the host does"""

    def __init__(self, model, T, way):
        self.filter = Filter(model, T, way=way)
        self.is_fixed, parts = T == "q31", self.filter.parts
        self.of_z, self.of_u, self.of_x = (2.0 ** np.array(parts.fractions(one)) for one in ("measurements", "controls", "states"))
        self.of_u = self.of_u[:len(model.inputs)]  # without the 1 of an offset

    def given(self, values, scale):
        return np.round(values * scale).astype(int) if self.is_fixed else values.astype(np.float32)

    def taken(self, values, scale):
        return self.given(values, scale) / (scale if self.is_fixed else 1.0)


@pytest.mark.parametrize("T, way, seed", first(3, [(T, way, seed) for seed in range(4) for T, way in (
    ("q31", "tables"), ("f32", "init"), ("q31", "sizes"), ("f32", "lean"), ("q31", "lean"), ("q31", "init"), ("f32", "tables"), ("f32", "sizes"))]))
def test_firmware_of_design_has_the_hosts_bits(T, way, seed, tmp_path):
    """What is late, in any order, beside the host's run in which nothing was"""
    path = room(tmp_path, more="c = [0.4, 0.0]\n" if seed % 2 else "")
    model, draw = model_file.read(path), np.random.default_rng(seed)
    firmware, words, rows, latest = Firmware.designed(tmp_path, path, T, way=way), Words(model, T, way), 60, 6
    z, u = 20 + draw.normal(size=(rows, 3)), draw.normal(size=(rows, 1))
    is_there = draw.random((rows, 3)) < 0.6
    is_there[rows - latest:, 1:] = False
    told = np.arange(rows) + draw.integers(0, latest + 1, rows)
    given, pushed = words.given(z, words.of_z), words.given(u, words.of_u)
    for t in range(rows):
        assert t == 0 or firmware.call("predict", pushed[t - 1]) == 0
        assert firmware.call("update_quick", given[t, :1], int(is_there[t, 0])) == 0
        for row in draw.permutation(np.flatnonzero(told == t)):
            assert firmware.call("update_reference", given[row, 1:], int(is_there[row, 1:] @ [1, 2]), int(t - row)) == 0
    f = words.filter
    f.run(np.where(is_there, words.taken(z, words.of_z), np.nan), words.taken(u, words.of_u))
    assert np.array_equal(firmware.memory(len(f.memory)), f.memory)


@pytest.mark.parametrize("seed", first(1, range(3)))
def test_firmware_that_goes_several_steps(seed, tmp_path):
    """q31, 1 to 3 steps of dt in a predict: late beside in time"""
    path, draw = room(tmp_path, CONTINUOUS, 0.3), np.random.default_rng(seed)
    late, rows, ends = Firmware.designed(tmp_path, path, "q31", steps=3, way="tables"), 40, []
    z, steps = draw.integers(-(1 << 26), 1 << 26, (rows, 3)), draw.integers(1, 4, rows)
    told = np.arange(rows) + draw.integers(0, 5, rows)
    for is_late in (True, False):
        assert late.call("init") == 0
        for t in range(rows):
            assert t == 0 or late.call("predict", z[t - 1, 2:] // 4, int(steps[t])) == 0
            if not is_late:
                assert late.call("update", z[t], 7 if told[t] < rows else 1) == 0
                continue
            assert late.call("update_quick", z[t, :1], 1) == 0
            for row in np.flatnonzero(told == t):
                assert late.call("update_reference", z[row, 1:], 3, int(t - row)) == 0
        ends.append(late.memory(7))
    assert np.array_equal(*ends) and late.call("predict", z[0, 2:] // 4, 4) != 0


@pytest.mark.parametrize("T", ["f32", "q31"])
def test_firmware_of_design_refuses_and_changes_nothing(T, tmp_path):
    path = room(tmp_path)
    firmware, none = Firmware.designed(tmp_path, path, T), np.array([-2**31, 0]) if T == "q31" else np.array([np.nan, 0], np.float32)
    some = np.ones(2, int if T == "q31" else np.float32)
    for _ in range(9):
        assert firmware.call("predict", some[:1]) == 0 and firmware.call("update_quick", some[:1], 1) == 0
    before = firmware.memory(5)
    for given, present, ago, status in ((none, 3, 2, "RANGE"), (none, 1, 0, "RANGE"), (some, 3, 7, "SIZE"), (some, 3, 1000, "SIZE")):
        assert firmware.call("update_reference", given, present, ago) in (getattr(lib, f"KQ_ERR_{status}"), lib.KQ_ERR_NOT_FINITE)
        assert np.array_equal(firmware.memory(5), before)
    assert firmware.call("update_reference", none, 2, 2) == 0 and not np.array_equal(firmware.memory(5), before)
    assert firmware.call("update_reference", some, 3, 2) == lib.KQ_ERR_HISTORY_FULL and firmware.call("update_reference", some, 1, 2) == 0
    assert firmware.call("update_quick", some[:1], 1) == lib.KQ_ERR_HISTORY_FULL
    told = bytes_of_delays(model_file.read(path), T)
    assert told - 64 <= firmware.late_ram <= told


# ------------------------------------------------------------------------------ of a nonlinear model

ROVER = '''
import numpy as np

states = ["east", "north", "heading", "gyro_bias"]
controls = ["speed", "turn"]
measurements = ["compass", "gps_east", "gps_north", "range"]
angles = ["compass"]
x0, P0, dt = [0, 0, 0.5, 0], [4, 4, 0.1, 1e-4], 0.05

def increment(x, t, u, dt):
    return [dt * u[0] * np.cos(x[2]), dt * u[0] * np.sin(x[2]), dt * (u[1] - x[3]), 0]

def Q(x, t, u, dt):
    return np.diag([1e-4 * dt, 1e-4 * dt, 1e-4 * dt, 1e-8 * dt])

def from_mast(x, t, u):
    return [np.hypot(x[0] - 5, x[1] + 3) + 0.01 * u[0] * t]

sensors = {"compass": (lambda x: [x[2]], [0.01]), "gps": (lambda x: [x[0], x[1]], [0.25, 0.25]), "mast": (from_mast, [0.04])}
delays = {"gps": 0.2, "mast": 0.1}

def simulated_controls(t):
    return [1.5, 0.3 * np.sin(0.5 * t)]
'''

@pytest.mark.parametrize("seed, arithmetic", first(2, [(seed, T) for seed in range(4) for T in ("f32", "f64")]))
def test_a_nonlinear_filter_takes_what_is_late(seed, arithmetic, tmp_path):
    """Steps of any length, h of u and t, sensors 2 to 6 steps late in any order: the bits of the run in which nothing was late"""
    (tmp_path / "rover.py").write_text(ROVER)
    model, draw, rows = read(tmp_path / "rover.py"), np.random.default_rng(seed), 60
    product = compiled_equations(model, "rover", Options(arithmetic))
    times = np.cumsum(draw.uniform(0.03, 0.07, rows).astype(np.float32)).astype(float)
    _, z, u = simulate(model, rows, seed, times=times)
    z, u, latest = z.astype(np.float32).astype(float), u.astype(np.float32).astype(float), 6
    is_there = draw.random((rows, 3)) < 0.7
    is_there[rows - latest:] = False
    told = np.arange(rows)[:, None] + np.where([False, True, True], draw.integers(0, latest + 1, (rows, 3)), 0)
    late = Late(product, tmp_path)
    assert len(late.f) == product.ram_delayed

    def update(sensor, row, ago):
        more = {"compass": [], "gps": [ctypes.c_uint(ago)], "mast": [late.numbers(u[row]), late.type(times[row]), ctypes.c_uint(ago)]}
        measured = z[row, sensor.first:sensor.first + sensor.m]
        return late.call(f"delayed_update_{sensor.name}", late.numbers(measured), *more[sensor.name])

    for t in range(rows):
        if t:
            late.call("delayed_predict", late.numbers(u[t - 1]), late.type(times[t] - times[t - 1]))
        for which, sensor in enumerate(model.sensors):
            for row in draw.permutation(np.flatnonzero(is_there[:, which] & (told[:, which] == t))):
                assert update(sensor, row, int(t - row)) == 2**sensor.m - 1
    known = np.repeat(is_there, [1, 2, 1], axis=1)
    record = recorded(model, np.where(known, z, np.nan), u, times)
    with Host(product) as host:
        ran = host.run_record(record)
    assert update(model.sensors[1], 0, latest + 1) == 0 and late.events
    assert late.mean.tolist() == ran.mean[-1].tolist()


def test_a_late_log_of_a_nonlinear_model(tmp_path):
    """The command's run of a log that tells late is that of the log in which nothing is late; and its test program passes"""
    path = saved(tmp_path / "rover.py", ROVER)
    on_time = saved(tmp_path / "on_time.py", ROVER.replace('delays = {"gps": 0.2, "mast": 0.1}', ""))
    for model, log in ((path, "late.csv"), (on_time, "log.csv")):
        succeeds("simulate", model, "-n", "90", "--seed", "2", "--out", tmp_path / log)
    rows = list(csv.reader((tmp_path / "log.csv").open()))
    for row in rows[-4:]:
        row[2:4] = ["", ""]
    for row in rows[-2:]:
        row[4] = ""
    (tmp_path / "log.csv").write_text("\n".join(map(",".join, rows)) + "\n")
    late, right = (json_of("run", model, tmp_path / log) for model, log in ((path, "late.csv"), (on_time, "log.csv")))
    assert late["taken"] == right["taken"] and late["log_likelihood"] == pytest.approx(right["log_likelihood"], rel=1e-12)
    assert np.allclose(late["mean"], right["mean"], rtol=1e-9) and late["taken"] < 360
    assert "rover_delayed: " in succeeds("compile", path, "-o", tmp_path / "rover.c").stdout
    passes(tmp_path, "rover", compiler="gcc")


@pytest.mark.parametrize("old, new, command, said", [
    ('"gps": 0.2', '"gsp": 0.2', ("run",), "delays: is {name of a sensor: how late it tells}; sensors: compass, gps, mast"),
    ('"gps": 0.2', '"gps": -1', ("run",), "delays: gps is to be 0 or more"),
    ("0.05\n", "0.05\n", ("compare",), "compare cannot use delays (run, report, check and fit can)"),
])
def test_what_is_no_delay_is_refused(old, new, command, said, tmp_path):
    (tmp_path / "rover.py").write_text(ROVER.replace(old, new, 1))
    (tmp_path / "log.csv").write_text("time,compass,gps_east,gps_north,range,speed,turn\n0,0,0,0,5,1,0\n0.05,0,0,0,5,1,0\n")
    given = [] if command[0] == "compile" else [tmp_path / "log.csv"]
    refused(kalmanq(command[0], tmp_path / "rover.py", *given, *(tmp_path / one if one.endswith(".c") else one for one in command[1:])), said)
    assert not (tmp_path / "rover.c").exists()
