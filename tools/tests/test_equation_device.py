"""kalmanq compile --library: a nonlinear model over the library comes to what the straight-line C in double comes to."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np
import pytest
from command import succeeds
from equation_random import random_model
from equations import path_of
from library import EXAMPLES, STRICT, cc, objects, passes, written
from whole import first, paired

import kalmanq as kalmanq_package
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.equation_records import drawn
from kalmanq.compiler.run.host import Host, numbered
from kalmanq.compiler.run.record import Record, in_whole_groups, times_of
from kalmanq.compiler.text.emit import PREDICTS, UPDATES, Row
from kalmanq.compiler.text.equation_device_text import compiled_device
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import Product
from kalmanq.nonlinear import NonlinearModel, NonlinearSmoother, read

ROOT, OWN = Path(__file__).resolve().parents[2], Path(__file__).parent / "equations"
MODELS = [EXAMPLES / "battery.py", EXAMPLES / "range_bearing.py", OWN / "attitude.py", OWN / "drift.py"]
TIMED = [OWN / "timed" / f"{name}.py" for name in ("battery", "correlated", "radar", "vehicle")]  # of noises that are functions
MORE = {"range_bearing": ("--iterate", 4)}  # options of a model
ARITHMETICS = ("f32", "f64")
MOST = {"f32": 1e-3, "f64": 1e-9}  # sigma
ITERATIONS = 3
SEEDS, ROWS = (1, 2, 3), 300
NEAR = 100  # of range_bearing the target is 2 km away in the end, where float rounds h to 3e-3 sigma in any filter
DRIVER = """\
#include <string.h>
#include "{name}.h"
static {name}_device f, s; /* the filter; a smoothed step */
{uses}
static int has_read({name}_device *of, double *mean, double *P)
{{
    {type} covariance[{n} * {n}];
    {means}
    if (kq_covariance_{T}({name}_filter(of), covariance)) return 0;
    for (int k = 0; k < {n} * {n}; k++) P[k] = (double)covariance[k];
    return 1;
}}
void run(int rows, const unsigned char *what, const unsigned *present, const double *z, const double *u, const double *now, const double *clock,
         double *mean, double *P, unsigned *taken);
void run(int rows, const unsigned char *what, const unsigned *present, const double *z, const double *u, const double *now, const double *clock,
         double *mean, double *P, unsigned *taken)
{{
    if ({starts}) return;
    for (int t = 0; t < rows; t++, z += {m}, u += {l}, now += {l}, clock += 3, mean += {carried}, P += {n} * {n}) {{
        {type} v[{m}], w[{l} + 1], at[{l} + 1];
        (void)w, (void)at;
        for (int k = 0; k < {m}; k++) v[k] = ({type})z[k];
        for (int k = 0; k < {l}; k++) w[k] = ({type})u[k], at[k] = ({type})now[k];
        taken[t] = 0;
        {calls}
        if (!has_read(&f, mean, P)) return;
    }}
    {ends}
}}
"""
SMOOTHS = """\
if (kq_smooth_{T}(&tape)) return;
    for (int t = 0; t < rows; t++, mean += {carried}, P += {n} * {n}) {{
        kq_filter_{T} view;
        if (kq_smoothed_{T}(&tape, (size_t)t, &view) || kq_filter_copy_{T}({name}_filter(&s), &view)) return;
        {shows}
        if (!has_read(&s, mean, P)) return;
    }}"""


def parts(T: str) -> list[str]:
    return objects(f"filter_{T}", f"nonlinear_{T}", "status")


class Program:
    """A device and a program around it.  run(record): means, covariances and bits of what was taken; then smoothed ones

    calls: of a predict and of the updates of a row; uses: what they read"""

    def __init__(self, product: Product, folder: Path, calls: Sequence[str] = (), uses: str = "", start: str = "",
                 smooths: bool = False):
        self.given, self.smooths, name, a = product.given, smooths, product.given.name, product.arithmetic
        made = [f"if (what[t] & {one} && {call}) return;" for one, call in zip((PREDICTS, UPDATES), calls)]
        made = [*made, "taken[t] = present[t];"] if calls else \
            product.text.row(Row("what[t]", "present[t]", "v", "w", "at", *(f"clock[{k}]" for k in range(3)), "taken[t]"))
        history = re.findall(r"^ \*     (KQ_\w+\(.*|kq_attach.*);$", product.header, re.M) if smooths else []  # as NAME.h has it
        noises = "STEPS, STEPS)" if a.Q or "sigma_points" in "".join(calls) else "STEPS, 1)"  # as it says there, too
        uses = [*(f"{one};".replace("STEPS, 1)", noises) for one in history if one[0] == "K"), uses]
        starts = [f"{name}_start(&s)", start or f"{name}_start(&f)", *(one for one in history if one[0] == "k")]
        sizes = {"name": name, "T": a.T, "type": a.type, "n": self.given.of.n, "m": self.given.of.m, "l": self.given.of.l,
                 "carried": len(self.given.carried)}
        shows = ""
        if smooths and a.has_errors:
            uses.append(f"static {a.type} left[STEPS][{sizes['carried']}];")
            made.append("memcpy(left[t], f.x, sizeof f.x);")
            shows = f"memcpy(s.x, left[t], sizeof s.x); if ({name}_reset(&s)) return;"
        means = (f"mean[{i}] = (double){name}_mean_{one}(of);" for i, one in enumerate(self.given.carried))
        driver = DRIVER.format(**sizes, calls="\n        ".join(made), means="\n    ".join(means), uses="\n".join(uses),
                               starts=" || ".join(starts), ends=SMOOTHS.format(**sizes, shows=shows) if smooths else "(void)s;")
        written(folder, {**product.sources(), "driver.c": driver})
        cc("cc", *STRICT, "-O0", "-ffp-contract=off", "-fPIC", "-shared", f"-I{ROOT / 'include'}", f"-DSTEPS={NEAR}", f"{name}.c",
           "driver.c", *parts(a.T), "-lm", "-o", "run.so", folder=folder)
        self.library = ctypes.CDLL(str(folder / "run.so"))

    def run(self, record: Record) -> list[np.ndarray]:
        rows, n = len(record.what), self.given.of.n
        made = [np.full((rows * (1 + self.smooths), *shape), np.nan) for shape in ((len(self.given.carried),), (n, n))]
        taken = np.zeros(rows, np.uint32)
        arrays = [np.ascontiguousarray(one) for one in (record.what, record.present, record.z, record.u, record.now,
                                                            numbered(rows) if record.clock is None else record.clock)]
        self.library.run(rows, *(ctypes.c_void_p(one.ctypes.data) for one in (*arrays, *made, taken)))
        return [*(one[:rows] for one in made), taken, *(one[rows:] for one in made)]


def apart(model: NonlinearModel, made: Sequence[np.ndarray], mean: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, float]:
    """Means in sigma, row by row; the largest entry of a covariance in sigma_i sigma_j"""
    sigma = np.sqrt(np.einsum("tii->ti", P))
    errors = np.abs([model.minus(*pair) for pair in zip(made[0], mean)]) / sigma
    return errors, np.abs((made[1] - P) / (sigma[:, :, None] * sigma[:, None, :])).max()


@pytest.mark.parametrize("path, iterate, arithmetic", paired(
    [*((path, 1) for path in (*MODELS, *TIMED)), (MODELS[1], 4), (MODELS[3], 3), (TIMED[0], 3)], ARITHMETICS), ids=lambda one: getattr(one, "stem", one))
def test_it_comes_to_what_straight_lines_in_double_come_to(path, iterate, arithmetic, tmp_path):
    model, options = read(path), Options(iterate=iterate)
    program, both = Program(compiled_device(model, "device", replace(options, arithmetic=arithmetic)), tmp_path), []
    with Host(compiled_equations(model, "straight", replace(options, arithmetic="f64"))) as straight, \
            Host(compiled_equations(model, "straight", replace(options, arithmetic=arithmetic))) as same:
        for seed in SEEDS:
            record = in_whole_groups(drawn(model, ROWS, seed), program.given.together)
            assert np.any(record.present != 2**model.m - 1)
            exact, other = (one.run_record(record) for one in (straight, same))
            made = program.run(record)
            errors, spread = apart(model, made, exact.mean, exact.covariance)
            theirs, _ = apart(model, (other.mean, other.covariance), exact.mean, exact.covariance)
            assert np.array_equal(made[2], exact.taken)
            assert errors[:NEAR].max() < MOST[arithmetic] and spread < MOST[arithmetic]
            both.append([np.mean(one**2) for one in (errors, theirs)])
    own, of_straight = np.sqrt(np.mean(both, axis=0))  # the largest of a record is that of one rounding
    print(f"device {path.stem} {arithmetic} {own:.1e} straight {of_straight:.1e}")
    assert own < max(MOST[arithmetic] / 10, 1.5 * of_straight)


# Calls of a predict and of the updates of a row
POINTS = {"battery": ("device_predict(&f, w)", "{update} &(device_row){{v, at}}, {rule}"),
          "range_bearing": ("device_predict(&f)", "{update} &(device_row){{v}}, {rule}"),
          "bearing_only": ("device_predict(&f)", "{update} &(device_row){{v, ({type})t}}, {rule}"),
          "gps_imu": ("{predict} &(device_row){{w}}, {rule}", "device_update(&f, v)"),
          "drift": ("{predict} &(device_row){{v, w}}, {rule}",
                    "(device_update_mark(&f, v) || {update} &(device_row){{v + 1, w}}, {rule})")}
METHODS = [("extended", "drift"), ("extended", "timed/radar"), ("extended", "timed/vehicle"), ("iterated", "timed/correlated"), ("iterated", "range_bearing"), ("central", "battery"), ("cubature", "bearing_only"),
           ("extended", "range_bearing"), ("iterated", "battery"), ("cubature", "range_bearing"), ("cubature", "gps_imu"),
           ("cubature", "drift")]


@pytest.mark.parametrize("method, name, arithmetic", [*paired(METHODS[:7], ARITHMETICS), *first(0, [(*one, T) for one in METHODS[7:] for T in ARITHMETICS])])
def test_filters_and_smoothers_are_the_library_s_on_the_host(method, name, arithmetic, tmp_path):
    model, by_points = read(path_of(name)), method in ("cubature", "central")
    product = compiled_device(model, "device", Options(arithmetic, iterate=ITERATIONS if method == "iterated" else 1))
    points, update = f"sigma_points_{arithmetic}(device_filter(&f), &f.", "_far" if name == "drift" else ""
    words = {"predict": f"kq_predict_{points}process, device_point_increment,", "type": product.arithmetic.type,
             "update": f"kq_update_{points}sensor{update}, device_point_innovation{update},",
             "rule": f"KQ_SIGMA_POINTS_{method.upper()}, work)"}
    calls = [one.format(**words) for one in POINTS[name]] if by_points else ()
    work = f"static {product.arithmetic.type} work[KQ_SIGMA_POINTS_LEN({model.n}, {model.m})];" if by_points else ""
    program = Program(product, tmp_path, calls, work, smooths=True)
    for seed in SEEDS:
        record = drawn(model, NEAR, seed)
        record = in_whole_groups(record, [2**model.m - 1] if by_points else product.given.together)
        u = record.now if model.l else None
        run = NonlinearSmoother(model, "f64", method, ITERATIONS).run(record.measured, u, times=times_of(record), covariance=True)
        mean, P, _, smoothed, smoothed_P = program.run(record)
        for one, *other in (((mean, P), run.mean, run.covariance), ((smoothed, smoothed_P), run.smoothed, run.smoothed_covariance)):
            errors, spread = apart(model, one, *other)
            assert errors.max() < MOST[arithmetic] and spread < MOST[arithmetic]


def bryson_frazier(model: NonlinearModel, z: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Smoothed nominal numbers.  Errors of a step add up, as in a history."""
    x, P, made = np.array(model.x0), np.array(model.P0), []
    for t, row in enumerate(z):
        steps = []  # of the adjoint, from the row to the one before it: factors and what is added
        if t:
            A = model.transition(x, t - 1, u[t - 1])
            x, P, steps = model.moved(x, t - 1, u[t - 1]), A @ P @ A.T + model.Q, [(A.T, 0)]
        for sensor in model.sensors:
            some = [c for c in range(sensor.first, sensor.first + sensor.m) if not np.isnan(row[c])]
            H, e = model.measurement(x, t, u[t])[some], model.innovation(row, x, t, u[t])[some]
            weights = np.linalg.solve(H @ P @ H.T + model.R[np.ix_(some, some)], H).T
            left = np.eye(model.n) - P @ weights @ H
            x, P, steps = model.plus(x, P @ weights @ e), left @ P, [(left.T, weights @ e), *steps]
        made.append((x, P, steps))
    adjoint, smoothed = np.zeros(model.n), []
    for x, P, steps in reversed(made):
        smoothed.append(model.plus(x, P @ adjoint))
        for factor, more in steps:
            adjoint = factor @ adjoint + more
    return np.array(smoothed[::-1])


@pytest.mark.parametrize("path, arithmetic", paired([OWN / "attitude.py", EXAMPLES / "attitude.py"], ARITHMETICS))
def test_smoothed_error_states_are_those_of_a_textbook(path, arithmetic, tmp_path):
    model = read(path)
    program = Program(compiled_device(model, "device", Options(arithmetic)), tmp_path, smooths=True)
    with Host(compiled_equations(model, "straight", Options("f64", smooth=NEAR))) as straight:
        for seed in SEEDS:
            record = in_whole_groups(drawn(model, NEAR, seed), program.given.together)
            straight.run_record(record)
            exact = bryson_frazier(model, record.measured, record.now), straight.smoothed(record.what).covariance
            errors, spread = apart(model, program.run(record)[3:], *exact)
            assert errors.max() < MOST[arithmetic] and spread < MOST[arithmetic]


ROBUST = {"battery": ("device_predict(&f, w)", "(device_innovation(&f, v, at, e) || {update} e, 1, &loss))"),
          "range_bearing": ("device_predict(&f)", "(device_innovation(&f, v, e) || {update} e, present[t], &loss))"),
          "gps_imu": ("device_predict(&f, w)", "{update} v, present[t], &loss)")}


@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
@pytest.mark.parametrize("name", first(1, ROBUST))
def test_robust_updates_are_those_of_straight_lines(name, arithmetic, tmp_path):
    model = read(path_of(name))
    product = compiled_device(model, "device", Options(arithmetic))
    loss = f"static kq_loss_{arithmetic} loss = {{.kind = &kq_loss_student_{arithmetic}, .parameter = 4}};"
    calls = [one.format(update=f"kq_update_robust_{arithmetic}(device_filter(&f), &f.sensor,") for one in ROBUST[name]]
    uses = f"#include <kalmanq/robust.h>\n{loss}\n{product.arithmetic.type} e[{model.m}];"
    program = Program(product, tmp_path, calls, uses)
    with Host(compiled_equations(model, "straight", Options("f64", student=4.0))) as straight, \
            Host(compiled_equations(model, "plain", Options("f64"))) as plain:
        for seed in SEEDS:
            record = drawn(model, NEAR, seed)
            record.z[5::17] += 20 * np.sqrt(np.diag(model.R))
            exact, other = (one.run_record(record) for one in (straight, plain))
            errors, spread = apart(model, program.run(record), exact.mean, exact.covariance)
            moved, _ = apart(model, (other.mean, other.covariance), exact.mean, exact.covariance)
            assert errors.max() < MOST[arithmetic] and spread < MOST[arithmetic] and moved.max() > 5


START = "device_start_at(&f, x0, minus) != KQ_ERR_NOT_SEMIDEFINITE || device_start_at(&f, x0, sigma0)"


@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
@pytest.mark.parametrize("path", MODELS[::2], ids=lambda path: path.stem)
def test_start_at_is_a_start_of_another_model(path, arithmetic, tmp_path):
    model = read(path)
    mean, sigma = model.x0 + 1 / 16, 2.0 ** -np.arange(1, model.n + 1)
    other = copy(model)
    other.x0, other.P0 = mean, np.diag(sigma**2)
    runs = []
    for k, (one, start) in enumerate(((model, START), (other, ""))):
        (tmp_path / str(k)).mkdir()
        product = compiled_device(one, "device", Options(arithmetic))
        numbers = [f"static const {product.arithmetic.type} {name}[] = {{{', '.join(map(product.arithmetic.number, values))}}};"
                   for name, values in (("x0", mean), ("sigma0", sigma), ("minus", -sigma)) if start]
        runs.append(Program(product, tmp_path / str(k), uses="\n".join(numbers), start=start))
    for seed in SEEDS:
        record = in_whole_groups(drawn(model, NEAR, seed), runs[0].given.together)
        made, wanted = (one.run(record) for one in runs)
        assert all(np.array_equal(*pair) for pair in zip(made, wanted)) and np.all(np.isfinite(made[0]))


@pytest.mark.parametrize("path, T", paired(MODELS, ARITHMETICS), ids=lambda one: getattr(one, "stem", one))
def test_its_files_are_free_of_warnings_and_its_test_says_ok(path, T, tmp_path):
    succeeds("compile", path, "--library", "--arith", T, *MORE.get(path.stem, ()), "-o", tmp_path / f"own_{T}.c")
    for compiler in filter(shutil.which, ("gcc", "clang")):
        passes(tmp_path, f"own_{T}", *parts(T), compiler=compiler, flags=(*STRICT, f"-I{ROOT / 'include'}", "-ffp-contract=off"))
    cc("g++", "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{ROOT / 'include'}", "-fsyntax-only", "-x", "c++",
       "-include", f"own_{T}.h", os.devnull, folder=tmp_path)


def test_what_is_linear_is_told_once_and_the_rest_in_each_call(tmp_path):
    texts = {path.stem: compiled_device(read(path), path.stem, Options()).code for path in MODELS}
    for name in ("battery", "range_bearing"):
        assert "kq_predict_f32(" in texts[name] and "kq_predict_extended" not in texts[name]
    assert "f->H[" in texts["range_bearing"] and "f->H[2]" not in texts["range_bearing"]
    assert "kq_update_f32(&f->filter, &f->sensor_mark, z)" in texts["drift"] and "kq_update_f32(&f->filter, &f->sensor_far, z)" not in texts["drift"]
    given = {"x0": [0.0, 0.0], "P0": [1.0, 1.0], "Q": [0.1, 0.1]}
    own = NonlinearModel(lambda x: x, lambda x: [x[0]], innovation=lambda z, x: [np.sin(z[0] - x[0])], R=[0.1], **given)
    assert "sinf(" in compiled_device(own, "own", Options()).code
    sensors = {"place": (lambda x: [x[0]], [0.1]), "course": (lambda x: [x[1]], [0.1])}
    turned = compiled_device(NonlinearModel(lambda x: x, sensors=sensors, angles=[1], **given), "turned", Options()).code
    assert "kq_update_f32(&f->filter, &f->sensor_place, z)" in turned and "kq_update_f32(&f->filter, &f->sensor_course, z)" not in turned
    assert "device_reset" not in texts["drift"] and "kq_sensor_init_diagonal_f32(&f->sensor_mark, H_mark, R_mark)" in texts["drift"]
    assert "f->A[1] = u[0]" in texts["drift"].replace("u0;", "u[0];") and "f->A[0]" not in texts["drift"]
    assert "kq_move_f32" in texts["attitude"]


@pytest.mark.parametrize("share, told", [(1, 128), (1e8, 0)])  # KQ_EVENT_PRECISION
@pytest.mark.parametrize("iterate", [1, 3])
def test_an_event_where_float_rounds_an_innovation_by_more_than_sigma(share, told, iterate, tmp_path):
    given = random_model(602)
    model = NonlinearModel(given.given["f"].function, given.given["h"].function, x0=given.x0, P0=given.P0, Q=given.Q, R=share * given.R)
    recorded = drawn(model, 40, 1)
    product = compiled_device(model, "rounded", Options("f32", iterate=iterate))
    made = Program(product, tmp_path, uses="unsigned events(void); unsigned events(void) { return kq_events_f32(&f.filter); }")
    made.run(recorded)
    assert made.library.events() == told and ("PRECISION" in product.code) == (told > 0)
