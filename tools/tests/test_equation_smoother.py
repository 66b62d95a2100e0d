"""compile MODEL.py --smooth: beside the library's smoother, and beside that of Rauch, Tung and Striebel in 40 digits."""

from __future__ import annotations

import decimal
import shutil
import subprocess
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Sequence

import numpy as np
import pytest
from command import kalmanq, succeeds
from library import EXAMPLES, STRICT, passes

from kalmanq.compiler.given import exact
from kalmanq.compiler.given.request import Options, groups
from kalmanq.compiler.run.equation_records import drawn
from kalmanq.compiler.run.host import PREDICTS, UPDATES, Host, Ran, Smoothed, numbered
from kalmanq.compiler.run.record import Record, in_whole_groups
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import Product
from kalmanq.nonlinear import NonlinearModel, NonlinearSmoother, read

ROWS, SEEDS = 150, (1, 2, 3)
LOOPS = (False, True)


def turning(sharp: float = 1.0) -> NonlinearModel:
    """A car, of which speed and turn rate wander; the places and the heading have no noise.  By range and bearing"""
    def increment(x: Any) -> list:
        return [0.2 * x[2] * np.cos(x[3]), 0.2 * x[2] * np.sin(x[3]), 0.0, 0.2 * x[4], 0.0]

    def h(x: Any) -> list:
        return [np.hypot(x[0] - 40, x[1] + 30), np.arctan2(x[1] + 30, x[0] - 40)]

    return NonlinearModel(h=h, increment=increment, x0=[0, 0, 5, 0.3, 0], P0=[4, 4, 1, 0.1, 0.01], Q=[0, 0, 0.01, 0, 1e-4],
                          R=[0.25 * sharp, 1e-4 * sharp], angles=[1], states=["x", "y", "speed", "heading", "rate"], name="turning")


def sailing(sharp: float = 1.0) -> NonlinearModel:
    """Place, speed and heading with the biases of an accelerometer and a gyro; two sensors by name"""
    def increment(x: Any, t: Any, u: Any) -> list:
        return [0.1 * x[2] * np.cos(x[3]), 0.1 * x[2] * np.sin(x[3]), 0.1 * (u[0] - x[4]), 0.1 * (u[1] - x[5]), 0, 0]

    sensors = {"gps": (lambda x: x[:2], np.array([[2, 0.5], [0.5, 2]]) * sharp), "log": (lambda x: x[2] * np.exp(0.01 * x[2]), [0.04 * sharp])}
    return NonlinearModel(increment=increment, sensors=sensors, x0=[0, 0, 5, 0, 0, 0], P0=[4, 4, 1, 0.1, 0.01, 1e-3],
                          Q=[1e-6, 1e-6, 1e-3, 1e-5, 1e-8, 1e-10], controls=["push", "turn"], name="sailing",
                          simulated_controls=lambda t: [0.3 * np.sin(0.02 * t), 0.2 * np.cos(0.013 * t)])


def gusting(sharp: float = 1.0) -> NonlinearModel:
    """A level that is moved by a gust, which is new in each row, and a bias of the sensor that never changes"""
    def f(x: Any, t: Any) -> list:
        return [x[0] + 0.1 * np.sin(x[0]) + x[1] + 0.05 * np.cos(0.3 * t), 0.0, x[2]]

    return NonlinearModel(f, lambda x: x[0] + 0.1 * x[0]**2 + x[2], x0=[1, 0, 0], P0=[1, 0.04, 0.01], Q=[0, 0.04, 0], R=[0.01 * sharp],
                          name="gusting")


def of_example(name: str, sharp: float = 1.0) -> NonlinearModel:
    model = read(EXAMPLES / f"{name}.py")
    return model if sharp == 1 else changed(model, R=model.R * sharp)


def changed(model: NonlinearModel, **other: Any) -> NonlinearModel:
    functions = {key: given.function for key, given in model.given.items() if key not in ("A", "H")}
    return NonlinearModel(**{**functions, "x0": model.x0, "P0": model.P0, "Q": model.Q, "R": model.R, "states": model.states,
                             "measurements": model.measurements, "controls": model.controls, "angles": model.angles, **other})


MODELS = {"battery": lambda sharp: of_example("battery", sharp), "range_bearing": lambda sharp: of_example("range_bearing", sharp),
          "turning": turning, "sailing": sailing, "gusting": gusting}


@lru_cache(None)
def model_of(name: str, sharp: float = 1.0) -> NonlinearModel:
    return MODELS[name](sharp)


def product_of(model: NonlinearModel, arithmetic: str, **options: Any) -> Product:
    return compiled_equations(model, "kf", Options(**{"smooth": ROWS, **options, "arithmetic": arithmetic}))


def run_back(model: NonlinearModel, records: Sequence[Record], arithmetic: str = "f64", **options: Any) -> list[tuple[Ran, Smoothed]]:
    with Host(product_of(model, arithmetic, **options), ("-O0",)) as host:
        return [(run_of(host, one), host.smoothed(one.what)) for one in records]


@lru_cache(None)
def records_of(name: str, sharp: float = 1.0) -> list[Record]:
    model = model_of(name, sharp)
    return [in_whole_groups(drawn(model, ROWS, seed), groups(model.R)) for seed in SEEDS]


@lru_cache(None)
def smoothed_of(name: str, arithmetic: str, loops: bool, sharp: float = 1.0) -> list[Smoothed]:
    return [made for _, made in run_back(model_of(name, sharp), records_of(name, sharp), arithmetic, loops=loops)]


def run_of(host: Host, record: Record, rows: slice = slice(None), **how: Any) -> Ran:
    z, u, present, what, now = (one[rows] for one in (record.z, record.u, record.present, record.what, record.now))
    return host.run(z, u, present, what, now=now, **how)


def apart(one: Any, other: Any) -> tuple[float, float]:
    """Of means in sigma of the other, of covariances in sigma_i sigma_j of it; a constant has no sigma"""
    sigma = np.sqrt(np.einsum("tii->ti", other.covariance))
    sigma = np.where(sigma > 0, sigma, 1)
    spread = np.abs(one.covariance - other.covariance) / (sigma[:, :, None] * sigma[:, None, :])
    return float((np.abs(one.mean - other.mean) / sigma).max()), float(spread.max())


def by_library(model: NonlinearModel, z: np.ndarray, now: np.ndarray) -> Smoothed:
    run = NonlinearSmoother(model, "f64", "extended", passes=1).run(z, now if model.l else None, covariance=True)
    return Smoothed(run.smoothed, run.smoothed_covariance, run.smoothed)


def textbook(model: NonlinearModel, ran: Ran, u: np.ndarray) -> Smoothed:
    """Rauch, Tung and Striebel in 40 digits, from the filter's means and covariances and Jacobians in double"""
    with decimal.localcontext(decimal.Context(prec=40)):
        Q, x, P = exact.decimals(model.Q), exact.decimals(ran.mean[-1]), exact.decimals(ran.covariance[-1])
        made = [(x, P)]
        for t in range(len(ran.mean) - 2, -1, -1):
            A = exact.decimals(model.transition(ran.mean[t], t, u[t]))
            moved = exact.decimals(ran.mean[t]) + exact.decimals(model.increment(ran.mean[t], t, u[t]))
            before = exact.decimals(ran.covariance[t])
            ahead = A @ before @ A.T + Q
            C = before @ A.T @ exact.inverse(ahead)
            x, P = exact.decimals(ran.mean[t]) + C @ (x - moved), before + C @ (P - ahead) @ C.T
            made.append((x, P))
        means, covariances = (np.array(one[::-1]).astype(float) for one in zip(*made))
    return Smoothed(means, covariances, means)


# ------------------------------------------------------------------------------ what it is


@pytest.mark.parametrize("loops", LOOPS)
@pytest.mark.parametrize("name", MODELS)
def test_double_is_the_library_s_smoother(name: str, loops: bool) -> None:
    for record, made in zip(records_of(name), smoothed_of(name, "f64", loops)):
        expected = by_library(model_of(name), record.measured, record.now)
        assert max(apart(made, expected)) < 1e-9
        assert apart(Smoothed(made.lagged, made.covariance, made.lagged), expected)[0] < 1e-9


@pytest.mark.parametrize("loops", LOOPS)
@pytest.mark.parametrize("options", [{}, {"gate": 1.5}, {"student": 4.0}, {"iterate": 3}, {"nis": True}], ids=str)
def test_forty_digits(options: dict, loops: bool) -> None:
    """Whatever an update does, the smoother goes back over what it left."""
    model = model_of("range_bearing" if "iterate" in options else "battery")
    record = drawn(model, 80, 1)
    [(ran, made)] = run_back(model, [record], loops=loops, **options)
    assert max(apart(made, textbook(model, ran, record.now))) < 1e-9


@pytest.mark.parametrize("loops", LOOPS)
@pytest.mark.parametrize("name", MODELS)
def test_float(name: str, loops: bool) -> None:
    for single, double in zip(smoothed_of(name, "f32", loops), smoothed_of(name, "f64", loops)):
        x, P = apart(single, double)
        assert x < 5e-3 and P < 1e-3
        assert np.all(np.abs(single.lagged - single.mean) <= 5e-3 * np.sqrt(np.einsum("tii->ti", double.covariance)))


@pytest.mark.parametrize("loops", LOOPS)
@pytest.mark.parametrize("name", MODELS)
def test_sharp_sensors_leave_no_variance_below_0(name: str, loops: bool) -> None:
    for made in smoothed_of(name, "f32", loops, 1e-6):
        assert np.all(np.isfinite(made.mean)) and np.all(np.isfinite(made.covariance))
        assert np.all(np.einsum("tii->ti", made.covariance) >= 0)


def textbook_of_errors(model: NonlinearModel, ran: Ran, u: np.ndarray) -> Smoothed:
    """The same of nominal numbers, in double: what the smoother says is errors of them"""
    x, P = ran.mean[-1], ran.covariance[-1]
    made = [(x, P)]
    for t in range(len(ran.mean) - 2, -1, -1):
        A, before = model.transition(ran.mean[t], t, u[t]), ran.covariance[t]
        ahead = A @ before @ A.T + model.Q
        C = np.linalg.solve(ahead, A @ before).T
        x = model.plus(ran.mean[t], C @ model.minus(x, model.moved(ran.mean[t], t, u[t])))
        P = before + C @ (P - ahead) @ C.T
        made.append((x, P))
    means, covariances = (np.array(one[::-1]) for one in zip(*made))
    return Smoothed(means, covariances, means)


@pytest.mark.parametrize("loops", LOOPS)
def test_error_states(loops: bool) -> None:
    model = read(Path(__file__).parent / "equations" / "attitude.py")
    records = [drawn(model, ROWS, seed) for seed in SEEDS]
    for record, (ran, made), (_, single) in zip(records, *(run_back(model, records, arithmetic, loops=loops) for arithmetic in ("f64", "f32"))):
        expected = textbook_of_errors(model, ran, record.now)
        sigma = np.sqrt(np.einsum("tii->ti", expected.covariance))
        off = np.array([model.minus(one, other) for one, other in zip(made.mean, expected.mean)])
        assert np.max(np.abs(off) / sigma) < 1e-9
        assert apart(replace(made, mean=sigma), replace(expected, mean=sigma))[1] < 1e-9
        off = np.array([model.minus(one, other) for one, other in zip(single.mean, made.mean)])
        assert np.max(np.abs(off) / sigma) < 5e-3
        assert apart(replace(single, mean=sigma), replace(made, mean=sigma))[1] < 1e-3


# ------------------------------------------------------------------------------ the history


def test_the_oldest_step_gives_way() -> None:
    model = model_of("battery")
    record = drawn(model, ROWS, 1)
    whole, some = (run_back(model, [record], smooth=steps)[0][1] for steps in (ROWS, 7))
    for one, other in ((whole.mean, some.mean), (whole.covariance, some.covariance), (whole.lagged, some.lagged)):
        assert np.array_equal(one[-8:], other[-8:]) and np.all(np.isnan(other[:-8]))


def test_fixed_lag_while_rows_come() -> None:
    model, steps = model_of("range_bearing"), 10
    record = drawn(model, 60, 2)
    with Host(product_of(model, "f64", smooth=steps), ("-O0",)) as host:
        for t in range(60):
            run_of(host, record, slice(t, t + 1), goes_on=t > 0, clock=numbered(1, t))
            back = host.smoothed(np.full(min(t, steps) + 1, PREDICTS))
            if t % 20 == 19:
                expected = by_library(model, record.measured[:t + 1], record.now[:t + 1])
                sigma = np.sqrt(np.diag(expected.covariance[t - steps]))
                assert np.all(np.abs(back.lagged[0] - expected.mean[t - steps]) < 1e-9 * sigma)


def test_steps_that_are_not_finite_and_rows_without_a_step() -> None:
    """A predict that changed nothing is a step back that changes nothing; a row without a predict is no step."""
    model = model_of("battery")
    record = drawn(model, 60, 1)
    record.u[20] = np.nan
    record.what[40] = UPDATES
    for loops in LOOPS:
        [(ran, made)] = run_back(model, [record], loops=loops)
        assert ran.events[20] and np.all(np.isfinite(made.mean))
        assert np.array_equal(made.mean[19], made.mean[20]) and np.array_equal(made.covariance[39], made.covariance[40])
        assert not np.array_equal(made.mean[18], made.mean[19])


# ------------------------------------------------------------------------------ as a user has it


def compile_file(folder: Path, name: str, *options: str) -> str:
    done = succeeds("compile", EXAMPLES / f"{name}.py", "-o", folder / f"{name}.c", *options)
    return " ".join(done.stdout.split())


@pytest.mark.parametrize("name, form, arithmetic, size", [
    ("battery", "--straight", "f64", 64), ("range_bearing", "--straight", "f32", 72), ("range_bearing", "--loops", "f32", 72)])
def test_files_compile_and_their_test_is_ok(name: str, form: str, arithmetic: str, size: int, tmp_path: Path) -> None:
    said = compile_file(tmp_path, name, "--smooth", "9", form, "--arith", arithmetic)
    assert f"the history holds 9 steps of {size} bytes" in said
    for compiler in filter(shutil.which, ("gcc", "clang")):
        passes(tmp_path, name, compiler=compiler)
    text = (tmp_path / f"{name}_test.c").read_text()
    begin = text.index("smoothed[9]")
    place = text.index("{", text.index("{", begin) + 1) + 1  # a mean of the table, that the program has to find wrong
    (tmp_path / f"{name}_test.c").write_text(f"{text[:place]}1 + {text[place:]}")
    subprocess.run(["gcc", *STRICT[:2], f"{name}.c", f"{name}_test.c", "-lm", "-o", "t"], cwd=tmp_path, check=True)
    assert "OK" not in subprocess.run([tmp_path / "t"], capture_output=True, text=True).stdout


def test_the_sizes_of_the_report_are_those_of_the_structs(tmp_path: Path) -> None:
    for name in MODELS:
        for arithmetic in ("f32", "f64"):
            product = product_of(model_of(name), arithmetic, smooth=5)
            smoother = product.text.smoother
            lines = [f"_Static_assert(sizeof(kf_record) == {smoother.record_size}, \"record\");",
                     f"_Static_assert(sizeof(kf_history) == {smoother.history_size}, \"history\");"]
            (tmp_path / "kf.h").write_text(product.header)
            (tmp_path / "sizes.c").write_text("\n".join(['#include "kf.h"', *lines, ""]))
            subprocess.run(["gcc", *STRICT, "-c", "sizes.c", "-o", "sizes.o"], cwd=tmp_path, check=True)


def test_lines_where_they_are_short() -> None:
    forms = {name: product_of(model_of(name), "f32").text.smoother.is_straight for name in MODELS}
    assert forms == {"battery": True, "range_bearing": True, "turning": True, "sailing": False, "gusting": True}


def test_constant_models_are_refused(tmp_path: Path) -> None:
    done = kalmanq("compile", EXAMPLES / "level.toml", "-o", tmp_path / "l.c", "--smooth", "5")
    assert done.returncode and "--smooth: is of nonlinear model files" in done.stderr and not list(tmp_path.iterdir())
    done = kalmanq("compile", EXAMPLES / "battery.py", "-o", tmp_path / "b.c", "--loops")
    assert done.returncode and "--loops" in done.stderr
