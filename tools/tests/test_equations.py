"""kalmanq compile MODEL.py: the C is the filter, in float too; what is refused changes nothing."""

from __future__ import annotations

import copy
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any, Callable, Sequence

import numpy as np
import pytest
from command import json_of, kalmanq
from equation_random import random_model, tried
from equations import FOLDER, NAMES, STRICT, Bare, apart, by_library, model_of, path_of, product_of, ran, rows_of, wrong_lines
from library import cc, passes, printed, saved, written
from whole import first

from kalmanq import Model, Quantity
from kalmanq.compiler.algorithm.equation_rounding import EPSILON, parts_of, visited
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import report
from kalmanq.compiler.report.equation_report import SEEDS, _apart, findings
from kalmanq.compiler.run import trial
from kalmanq.compiler.run.equation_records import drawn
from kalmanq.compiler.run.building import compiler
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.equation_device_text import compiled_device
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import compiled
from kalmanq.formulas.program import Program
from kalmanq.nonlinear import NonlinearModel, read, simulate as simulated
from kalmanq.run.simulation import simulate

TOLD = {"orbit": 0.05, "drone": 1e-2, "coordinated_turn": 1e-2, "induction_motor": 1e-2}  # sigma, where float is coarser than elsewhere
MEAN, COVARIANCE = 2e-3, 1e-3


# ------------------------------------------------------------------------------ the C is the filter


ITERATED = [(name, 300, SEEDS[:1], 2 + k % 3) for k, name in enumerate(NAMES)]
LINEAR_SENSORS = ("bicycle",)  # of those that are iterated every day


@pytest.mark.parametrize("name, rows, seeds, rounds", [
    *first(12, [(name, 120, SEEDS[:1], 1) for name in NAMES[::2] + NAMES[1::2]]), *first(0, [(name, 1000, SEEDS, 1) for name in NAMES]), *first(3, ITERATED)])
def test_double_is_the_library_and_float_is_near(name: str, rows: int, seeds: Sequence[int], rounds: int) -> None:
    model, options = model_of(name), {"iterate": rounds} if rounds > 1 else {}
    double, single = product_of(name, "f64", **options), product_of(name, "f32", **options)
    with Host(double) as of_double, Host(single) as of_single:
        for seed in seeds:
            record = rows_of(double, model, rows, seed)
            exact, low = ran(of_double, record), ran(of_single, record)
            assert (exact.taken == record.present).all() and (low.taken == exact.taken).all()
            assert max(apart(exact, by_library(model, record.measured, record.now, rounds))) < 1e-9
            mean, covariance = apart(low, exact)
            assert mean < TOLD.get(name, MEAN) and covariance < COVARIANCE * (2 if name == "induction_motor" else 1), (mean, covariance)
    if rounds > 1:  # there is something to iterate, but of linear sensors
        with Host(product_of(name, "f64")) as once:
            is_linear = len(double.arithmetic.linear) == len(model.sensors) or apart(ran(once, record), exact)[0] < 1e-9
        assert is_linear == (name in LINEAR_SENSORS)


def test_where_float_is_coarse_the_report_says_so() -> None:
    """A mean that is off by more than 1e-2 sigma, or a formula that is"""
    model = model_of("orbit")
    with Host(product_of("orbit", "f32")) as host:
        told = report.warned(product_of("orbit", "f32"), findings(model, product_of("orbit", "f32"), host))
    assert re.search(r" \(line \d+\)", told[0])


# GENERATED: errors of f32 that straight-line C of these models had in a prototype, in sigma and sigma_i sigma_j; rows, and
# between two measurements
PROTOTYPE = {"battery": (2e-4, 2e-5, 2000, 1), "coordinated_turn": (4e-4, 3e-4, 100, 1), "gps_imu": (1e-5, 3e-5, 2000, 10),
             "falling_body": (1e-4, 2e-5, 800, 16), "range_bearing": (2e-3, 7e-6, 100, 1), "attitude": (7e-5, 2e-5, 2000, 10),
             "strapdown": (7e-4, 6e-5, 2000, 10)}


@pytest.mark.parametrize("name", PROTOTYPE)
def test_float_is_as_near_as_a_prototype_was(name: str) -> None:
    """Twice as far at most; the strapdown's covariance is 2.2 times as far"""
    mean, covariance, rows, every = PROTOTYPE[name]
    model = model_of(name)
    products = {one: compiled_equations(model, "kf", Options(one)) for one in ("f32", "f64")}
    begun = copy.copy(model)  # half a sigma off at first
    begun.P0 = model.P0 / 4
    worst = np.zeros(2)
    with Host(products["f32"]) as single, Host(products["f64"]) as double:
        for seed in range(1, 5 if rows < 2000 else 2):
            own = 2 * np.sin(0.01 * np.arange(rows))[:, None] if name == "battery" else None  # its own empties it in 2000 rows
            _, z, u = simulated(begun, rows, seed, own)
            z[np.arange(rows) % every != 0] = np.nan
            runs = [one.run(z, np.vstack([np.zeros((1, model.l)), u[:-1]]), now=u) for one in (single, double)]
            worst = np.maximum(worst, _apart(model, *runs))
    for made, digit, times in zip(worst, (mean, covariance), (2, 2.2 if name == "strapdown" else 2)):
        assert made <= times * (digit + 10 ** np.floor(np.log10(digit)) / 2), worst  # one digit, rounded


# ------------------------------------------------------------------------------ its text


@pytest.mark.parametrize("name", first(3, ["bicycle", "drone", "unicycle", *NAMES]))
def test_it_does_not_depend_on_what_was_compiled_before(name: str) -> None:
    before, model = read(path_of(name)), read(path_of(name))
    alone = [make(read(path_of(name)), "kf", Options("f32")).sources() for make in (compiled_equations, compiled_device)]
    for make, others in ((compiled_equations, dict(iterate=3)), (compiled_equations, dict(smooth=9, student=4.0)), (compiled_device, {})):
        make(model, "kf", Options("f64", **others))
    before.formulas.derived_measurement, before.formulas.derived_transition  # as checks have them made
    for one in (before, model):
        assert [make(one, "kf", Options("f32")).sources() for make in (compiled_equations, compiled_device)] == alone


@pytest.mark.parametrize("names", [NAMES])
@pytest.mark.parametrize("arithmetic", ("f32", "f64"))
@pytest.mark.parametrize("options", [{}, {"gate": 4.0, "nis": True}, {"student": 4.0, "iterate": 3, "nis": True}],
                         ids=["plain", "gate", "student"])
def test_no_compiler_warns(names: list[str], arithmetic: str, options: dict, tmp_path: Path) -> None:
    for name in names[::2] if not options else names[::6]:
        product = product_of(name, arithmetic, **options)
        main = '#include "kf.h"\nint main() { static kf_filter f; kf_start(&f); return 0; }\n'
        written(tmp_path / name, {**product.sources(), "kf.cpp": main})
    for c, cpp in (("gcc", "g++"), ("clang", "clang++")):
        if shutil.which(c):
            cc(c, *STRICT, "-fsyntax-only", *tmp_path.glob("*/kf.c"))
            cc(cpp, "-std=c++17", *STRICT[1:], "-fsyntax-only", *list(tmp_path.glob("*/kf.cpp"))[::3])


@pytest.mark.parametrize("name, arithmetic", first(6, [(name, ("f32", "f64")[(k + turn) % 2]) for turn in (0, 1)
                                                       for k, name in enumerate(NAMES)]))
def test_its_program_prints_ok_and_the_digest(name: str, arithmetic: str, tmp_path: Path) -> None:
    product = product_of(name, arithmetic)
    with Host(product) as host:
        record = drawn(model_of(name), trial.ROWS, 1)
        text = trial.trial(product, host, record)
    written(tmp_path, {**product.sources(), "kf_test.c": text})
    digest = re.search(r"ffp-contract=off\): (\w{8})", text)[1]
    assert f"digest {digest}" in passes(tmp_path, "kf", compiler=compiler(), flags=(*STRICT, "-O2", "-ffp-contract=off"))


def test_its_program_finds_another_filter(tmp_path: Path) -> None:
    product = product_of("tank", "f32")
    with Host(product) as host:
        record = drawn(model_of("tank"), trial.ROWS, 1)
        text = trial.trial(product, host, record)
    other = product.code.replace("0.5f", "0.51f")
    assert other != product.code
    written(tmp_path, {"kf.c": other, "kf.h": product.header, "kf_test.c": text})
    cc(compiler(), "-O1", tmp_path / "kf.c", tmp_path / "kf_test.c", "-lm", "-o", tmp_path / "trial")
    done = subprocess.run([str(tmp_path / "trial")], capture_output=True, text=True)
    assert done.returncode == 1 and "OK" not in done.stdout


@pytest.mark.parametrize("options", first(1, [{}, {"smooth": 10}, {"iterate": 3}]))
def test_its_program_bears_another_math_library(options: dict, tmp_path: Path) -> None:
    """An orbit, whose range float rounds by a share of sigma: a cosine that is off by one unit in the last place"""
    def f(x: Any) -> list[Any]:
        return [x[0] + 10 * x[2], x[1] + 10 * x[3] / x[0], x[2] + 10 * (x[3] * x[3] / x[0] - 398600.4418 / x[0]**2), x[3] - 10 * x[2] * x[3] / x[0]]

    model = NonlinearModel(f, lambda x: np.sqrt(x[0]**2 + 6378.137**2 - 2 * x[0] * 6378.137 * np.cos(x[1])), x0=[7000.0, 0.2, 0.0, 7.546],
                           P0=[1.0, 1e-6, 1e-4, 1e-4], Q=[1e-10, 1e-18, 1e-12, 1e-12], R=[1e-4])
    product = compiled_equations(model, "kf", Options("f32", **options))
    with Host(product) as host:
        found, record = findings(model, product, host), drawn(model, trial.ROWS, 1)
        text = trial.trial(product, host, record, found.first)
    other = "#include <math.h>\nfloat other(float x);\nfloat other(float x) { return nextafterf(cosf(x), 2.0f); }\n"
    written(tmp_path, {**product.sources(), "kf_test.c": text, "other.c": other})
    (tmp_path / "kf.c").write_text(product.code.replace("cosf(", "other(").replace("<math.h>", "<math.h>\nfloat other(float x);"), encoding="utf-8")
    passes(tmp_path, "kf", "other.c", compiler=compiler(), flags=["-O1"])


# ------------------------------------------------------------------------------ random models


@pytest.mark.parametrize("seeds", first(1, [range(20), *(range(begin, begin + 1000) for begin in range(0, 10000, 1000))]), ids=str)
def test_random_models_stay_positive(seeds: Sequence[int]) -> None:
    """D is above 0, and all is finite; where float is far off though double follows the truth, an event says so, or the report
    has warned: of a function f that rounds a state without noise by more than sigma"""
    made = tried(seeds)
    assert not [one.name for one in made if not (one.single.is_sound and one.double.is_sound and one.single.least.min() > 0)]
    for one in made:
        if one.is_wrong and not one.single.events:
            product = compiled_equations(random_model(one.seed), "kf", Options("f32"))
            with Host(product) as host:
                assert any("In float f(" in line for line in report.warned(product, findings(random_model(one.seed), product, host))), one.name


@pytest.mark.parametrize("arithmetic, steps", [("f32", 100), ("f64", 1000)])
def test_a_variance_that_shrinks_below_all_numbers_grows_again(arithmetic: str, steps: int) -> None:
    """Without noise a state halves, and then doubles: from a D of 0 the filter would take no measurement any more"""
    model = NonlinearModel(lambda x, t, u: [u[0] * x[0]], lambda x: [x[0]], x0=[1.0], P0=[1.0], Q=[0.0], R=[1.0],
                           controls=[Quantity("factor", "", 4)])
    u = np.repeat([0.5, 2.0, 1.0], [steps, steps, 30])[:, None]
    x = 2.5 * np.cumprod(np.vstack([[[1.0]], u[:-1]]), axis=0)
    z = x + np.random.default_rng(1).normal(size=x.shape)
    with Host(compiled_equations(model, "kf", Options(arithmetic))) as host:
        ran = host.run(z, np.vstack([[[0.0]], u[:-1]]), now=u)
    sigma = np.sqrt(ran.covariance[:, 0, 0])
    assert sigma.min() > 0 and 0.1 < sigma[-1] < 0.3 and abs(ran.mean[-1] - x[-1]) < 3 * sigma[-1]


# ------------------------------------------------------------------------------ rounding


def test_where_rounding_makes_it_wrong_an_event_says_so() -> None:
    for one in tried((35, 602)):
        assert one.is_wrong and one.single.events == {"PRECISION"} and not one.double.events, one.name


@pytest.mark.parametrize("options", first(1, [{}, {"iterate": 3}]))
def test_ordinary_models_have_no_code_for_it(options: dict) -> None:
    for name in NAMES:
        assert not product_of(name, "f32", **options).arithmetic.watched, name


@pytest.mark.parametrize("options", [{}, {"iterate": 3}, {"gate": 4.0, "nis": True}])
def test_the_c_looks_at_the_state(options: dict, tmp_path: Path) -> None:
    """A sigma of 0.1 mm: at 1 km float rounds the range to 0.03 mm, at 10 km to 0.5 mm"""
    model = NonlinearModel(lambda x: x, lambda x: [np.sqrt(x[0]**2 + 1e6)], x0=[2000.0], P0=[4e6], Q=[1.0], R=[1e-8])
    product = compiled_equations(model, "kf", Options("f32", **options))
    assert list(product.arithmetic.watched) == [0] and not compiled_equations(model, "kf", Options("f64", **options)).arithmetic.watched
    f = Bare(product, tmp_path)
    for x, events in ((300, set()), (10000, {"PRECISION"}), (300, set())):
        f.call("start_at", f.numbers([x]), f.numbers([1]))
        assert f.update([np.sqrt(x**2 + 1e6)]) == 1 and f.events == events


def test_a_linear_sensor_is_looked_at_too(tmp_path: Path) -> None:
    """Alone, it reads the mean from the filter where it needs it"""
    model = NonlinearModel(lambda x: [0.9 * x[0] + np.sin(x[1]), x[1]], lambda x: [1.5 * x[0] + 0.3], x0=[100.0, 1.0], P0=[1.0, 1.0],
                           Q=[0.1, 0.1], R=[1e-14])
    f = Bare(compiled_equations(model, "kf", Options("f32")), tmp_path)
    for x, events in ((0.1, set()), (100, {"PRECISION"})):
        f.call("start_at", f.numbers([x, 1]), f.numbers([1, 1]))
        assert f.update([1.5 * x + 0.3]) == 1 and f.events == events


def test_a_sensor_of_one_state_does_not_round_the_state() -> None:
    """An encoder after 16384 rad, where a float has 1 mrad, and sigma is 0.3 mrad"""
    model = NonlinearModel(lambda x: [x[0] + 1e-3 * x[1], 0.99 * x[1] + 0.01 * np.sin(x[1])], lambda x: x[0], x0=[16384.0, 200.0],
                           P0=[1e-6, 1.0], Q=[1e-12, 1e-6], R=[1e-7])
    _, z, _ = simulated(model, 400, 1)
    z = z.astype(np.float32).astype(float)
    with Host(compiled_equations(model, "kf", Options("f32"))) as single, Host(compiled_equations(model, "kf", Options("f64"))) as double:
        one, other = single.run(z), double.run(z)
    sigma = np.sqrt(np.diagonal(other.covariance, axis1=1, axis2=2))
    assert not np.any(one.events) and np.abs((one.mean - other.mean) / sigma).max() < 0.2


def test_a_start_without_variance_has_an_error_in_the_report() -> None:
    """Where a sigma is 0 the error is a number, too"""
    model = NonlinearModel(lambda x: x, lambda x: x[0], x0=[1.0], P0=[0.0], Q=[1e-3], R=[0.1])
    product = compiled_equations(model, "kf", Options("f32"))
    with Host(product) as host:
        found = findings(model, product, host)
    assert found.beside < 1e-6 and found.mean < 1e-3


def test_no_constant_is_unused(tmp_path: Path) -> None:
    """What a state loses is there with its sign turned, too"""
    model = NonlinearModel(lambda x: [x[0] - np.exp(x[1]) * x[0], 0.5 * x[1]], lambda x: x[0], x0=[0.1, 0.1], P0=[1.0, 1.0],
                           Q=[1.0, 1.0], R=[1.0])
    written(tmp_path, compiled_equations(model, "kf", Options("f32")).sources())
    cc(compiler(), *STRICT, "-fsyntax-only", tmp_path / "kf.c")


@pytest.mark.parametrize("name", first(4, NAMES))
def test_parts_of_a_formula_bound_its_rounding(name: str) -> None:
    """Of a function of the math library a unit in the last place, twice what an operation is off"""
    model = model_of(name)
    given = {one: np.asarray(value, np.float32) for one, value in visited(model).items()}
    exact = {one: value.astype(float) for one, value in given.items()}
    for one in model.formulas.expected:
        parts = parts_of(one)
        low, high = (Program([one]).values(values, number)[0] for values, number in ((given, np.float32), (exact, np.float64)))
        bound = 2 * EPSILON * sum(np.abs(part) for part in Program(parts).values(exact)) if parts else 0
        assert np.all(np.abs(low - high) <= 1.01 * bound), one


# ------------------------------------------------------------------------------ options


def linear_pair() -> tuple[Model, NonlinearModel]:
    """A linear model, and the same in functions"""
    A, B, H = np.array([[1, 0.1], [-0.05, 0.95]]), np.array([[0.0], [0.1]]), np.array([[1, 0], [0.5, 1]])
    given: dict[str, Any] = dict(x0=[1, 0], P0=[4, 1], Q=[1e-3, 1e-2], R=[0.25, 0.5])
    linear = Model(A, H=H, R=given["R"], Q=given["Q"], B=B, P0=given["P0"], x0=given["x0"], controls=[Quantity("push", "", 5)])
    return linear, NonlinearModel(lambda x, t, u: A @ x + B @ u, lambda x: H @ x, controls=[Quantity("push", "", 5)], **given)


@pytest.mark.parametrize("options", [{"student": 4.0}, {"gate": 3.0}, {"student": 3.0, "nis": True}])
def test_of_a_linear_model_it_is_the_linear_filter(options: dict) -> None:
    linear, functions = linear_pair()
    z = simulate(linear, 200, 1)[1]
    z[::17] += 20
    z[5, 0] = z[8] = np.nan
    u = np.sin(np.arange(200.0))[:, None]
    made = compiled_equations(functions, "kf", Options("f64", **options))
    with Host(made) as one, Host(compiled(linear, "kf", Options("f64", settle=1e-15, **options))) as other:
        ours, theirs = one.run(z, u), other.run(z, u)
    assert (ours.taken == theirs.taken).all() and max(apart(ours, theirs)) < 1e-9
    if "gate" in options:
        assert (ours.events[::17] > 0).all()


def test_a_gate_refuses_outliers_and_opens_after_eight(tmp_path: Path) -> None:
    f = Bare(product_of("gps_imu", "f32", gate=4.0), tmp_path)
    f.call("start_at", f.numbers([0, 0, 5, 0, 0, 0]), f.numbers([2, 2, 1, 0.3, 0.1, 0.03]))
    for t in range(30):
        f.predict([0.0, 0.0])
        f.update([0.5 * t, 0.0])
    f.clear()
    before = f.mean
    f.predict([0, 0])
    assert f.update([1e3, 0.0]) == 2 and f.events == {"GATED"}
    assert abs(f.mean[0] - before[0]) < 1
    for k in range(7):
        f.predict([0, 0])
        assert f.update([1e3, 0.0]) == 2
    f.predict([0, 0])
    assert f.update([1e3, 0.0]) == 3 and f.mean[0] > 20
    f.clear()
    assert f.update([np.nan, 0.0]) == 2 and f.events == {"REFUSED"}


def test_student_weighs_outliers_down(tmp_path: Path) -> None:
    moved = []
    for k, options in enumerate(({}, {"student": 4.0})):
        folder = tmp_path / str(k)
        folder.mkdir()
        f = Bare(product_of("range_rate", "f64", **options), folder)
        before = f.mean
        assert f.update([163.0, -0.32, 5.0]) == 7
        moved.append(np.abs(f.mean - before)[0])
    assert moved[0] > 20 and moved[1] < moved[0] / 4


@pytest.mark.parametrize("name", ("coordinated_turn", "two_rc", "sir"))
@pytest.mark.parametrize("rounds", (1, 3))
def test_nis_and_likelihood_are_those_of_the_library(name: str, rounds: int, tmp_path: Path) -> None:
    product, model = product_of(name, "f64", nis=True, iterate=rounds), model_of(name)
    f = Bare(product, tmp_path)
    record = rows_of(product, model, 40, 2)
    library = by_library(model, record.measured, record.now, rounds)
    for t in range(40):
        if t:
            f.predict(record.u[t], t - 1.0)
        if record.present[t]:
            taken = f.update(record.z[t], record.now[t], t, present=int(record.present[t]) if model.m > 1 else None)
            assert f.nis == pytest.approx(library.nis[t], rel=1e-8, abs=1e-9)
            assert f.likelihood(taken) == pytest.approx(library.log_likelihood[t], rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("arithmetic", ("f32", "f64"))
def test_samples_in_part(arithmetic: str, tmp_path: Path) -> None:
    """A NaN is refused; without its bit it is missing; correlated components are together or not at all"""
    f = Bare(product_of("range_rate", arithmetic), tmp_path)
    z = [63.0, -0.32, 5.0]
    before = f.bytes
    assert f.update(z, present=0) == 0 and f.bytes == before and not f.events
    assert f.update(z, present=1) == 0 and f.bytes == before and f.events == {"REFUSED"}
    f.clear()
    assert f.update(z, present=2) == 2 and not f.events
    assert f.update([z[0], np.nan, z[2]], present=5) == 5 and not f.events
    assert f.update([z[0], np.inf, z[2]], present=7) == 5 and f.events == {"REFUSED"}
    f.clear()
    assert f.update(z, present=0xFFFFFFF8) == 0
    assert f.update([z[0], z[1], np.nan]) == 2 and f.events == {"REFUSED"}


@pytest.mark.parametrize("bad", (np.nan, np.inf, -np.inf, 1e30))
def test_what_is_refused_changes_nothing(bad: float, tmp_path: Path) -> None:
    f = Bare(product_of("cell", "f32", nis=True), tmp_path)
    f.update([3.75], [0.0])
    before, nis = f.mean.tobytes(), f.covariance.tobytes()
    assert f.update([bad], [0.0]) == 0 and f.events == {"REFUSED"}
    assert (f.mean.tobytes(), f.covariance.tobytes()) == (before, nis)


def test_controls_beyond_their_range(tmp_path: Path) -> None:
    f, other = (Bare(product_of("tank", "f32"), _made(tmp_path / name)) for name in "ab")
    for given, meant in ((7.0, 1.0), (-7.0, -1.0), (np.inf, 1.0), (-np.inf, -1.0), (np.nan, 0.0)):
        f.predict([given])
        assert f.events == {"CONTROL_REFUSED"}, given
        f.clear()
        other.predict([meant])
        assert f.bytes == other.bytes and not other.events, given


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


@pytest.mark.parametrize("options", [{}, {"iterate": 3}, {"nis": True}, {"gate": 3.0}, {"student": 4.0}], ids=str)
@pytest.mark.parametrize("arithmetic", ("f32", "f64"))
def test_not_finite_leaves_every_byte(arithmetic: str, options: dict, tmp_path: Path) -> None:
    """log and 1 / x of states where they have no value, and controls that are NaN"""
    def f_of(x, t, u):  # type: ignore[no-untyped-def]
        return [x[0] + 0.1 * u[0], x[1] + 0.1 * np.log(x[0])]

    def h(x, t, u):  # type: ignore[no-untyped-def]
        return [x[0] + u[0], np.sqrt(x[1] - 3.0), x[1] / (x[1] - 1.0)]

    model = NonlinearModel(f_of, h, x0=[1, 2], P0=[1, 1], Q=[0.1, 0.1], R=[1, 1, 1], controls=["push"])
    f = Bare(compiled_equations(model, "kf", Options(arithmetic, **options)), tmp_path)
    for mean, present in (([1, 2], 7), ([1, 2], 2), ([1, 1], 4)):
        f.call("start_at", f.numbers(mean), f.numbers([1, 1]))
        before = f.bytes
        assert f.update([1, 1, 1], [0.0], present=present) == 0 and f.events == {"NOT_FINITE"}
        assert f.bytes == before or options.get("nis") and f.mean.tolist() == mean
    f.call("start_at", f.numbers([1, 5]), f.numbers([1, 1]))
    before = f.bytes
    for bad in (np.nan, np.inf):
        assert f.update([1, 1, 1], [bad]) == 0 and f.events == {"NOT_FINITE"}
        f.clear()
        f.predict([bad])
        assert f.events == {"NOT_FINITE"}
        f.clear()
    assert f.bytes == before or options.get("nis")
    f.call("start_at", f.numbers([-1, 2]), f.numbers([1, 1]))
    before = f.bytes
    f.predict([0.0])
    assert f.events == {"NOT_FINITE"} and f.bytes == before


def _many_states(h: Callable, m: int) -> NonlinearModel:
    """Six, whose factor is written component by component"""
    return NonlinearModel(lambda x: [a + 0.1 * b for a, b in zip(x, [*x[1:], 0.0])], h, x0=[1, 2, 0, 0, 0, 0], P0=[1] * 6, Q=[0.1] * 6, R=[1.0] * m)


@pytest.mark.parametrize("h, z", [
    (lambda x: [x[0] + x[1] * x[1], np.sqrt(x[0] - 3.0)], [1, 1]), (lambda x: [x[0] + x[1] * x[1], np.sqrt(x[2])], [1, 0]),
    (lambda x: [np.sqrt(x[2])], [0])], ids=["value", "slope", "slope of one"])
def test_not_finite_leaves_every_byte_of_many_states(h: Callable, z: list[float], tmp_path: Path) -> None:
    """The second component's formula, or its slope, has no value"""
    f = Bare(compiled_equations(_many_states(h, len(z)), "kf", Options("f32")), tmp_path)
    before = f.bytes
    assert f.update(z) == 0 and f.events == {"NOT_FINITE"} and f.bytes == before
    f.clear()
    if len(z) > 1:
        assert f.update(z, present=1) == 1 and not f.events and f.bytes != before


def test_a_component_without_a_variance_is_not_taken(tmp_path: Path) -> None:
    f = Bare(compiled_equations(_many_states(lambda x: [x[0] + x[1] * x[1], x[2] + np.sin(1e16 * x[3])], 2), "kf", Options("f32")), tmp_path)
    f.call("start_at", f.numbers([1, 2, 0, 0, 0, 0]), f.numbers([1, 1, 1, 1e5, 1, 1]))
    before = f.covariance
    assert f.update([1, 1]) == 1 and f.events == {"NOT_FINITE"}
    assert np.array_equal(f.covariance[2:, 2:], before[2:, 2:]) and f.covariance[0, 0] < before[0, 0]


def test_a_variance_that_overflows_is_told(tmp_path: Path) -> None:
    model = NonlinearModel(lambda x: [30 * x[0] * (1 + 0.01 * np.sin(x[0]))], lambda x: [x[0]], x0=[0.0], P0=[1.0], Q=[1.0], R=[1.0])
    f = Bare(compiled_equations(model, "kf", Options("f32")), tmp_path)
    for _ in range(60):
        f.predict()
    assert "OVERFLOW" in f.events
    f.call("start")
    assert not f.events and f.update([0.5]) == 1


def test_start_at(tmp_path: Path) -> None:
    f = Bare(product_of("house", "f64"), tmp_path)
    f.call("start_at", f.numbers([15, 14, 0.5]), f.numbers([2, 3, 0.25]))
    assert f.mean.tolist() == [15, 14, 0.5]
    assert np.allclose(f.covariance, np.diag([4, 9, 0.0625]))
    assert f.update([16.0]) == 1 and 15 < f.mean[0] < 16


# ------------------------------------------------------------------------------ the command


@pytest.mark.parametrize("name", first(2, ["diff_drive", "pv_panel", "coordinated_turn", "drone"]))
def test_the_command(name: str, tmp_path: Path) -> None:
    told = json_of("compile", FOLDER / f"{name}.py", "-o", tmp_path / "kf.c", "--robust", "gate=5", "--nis")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["kf.c", "kf.h", "kf_report.txt", "kf_test.c"]
    assert (told["n"], told["m"], told["l"]) == (model_of(name).n, model_of(name).m, model_of(name).l)
    assert [one["name"] for one in told["sensors"]] == [one.name for one in model_of(name).sensors]
    assert all(one["arguments"][0] == "z" for one in told["sensors"]) and told["predict"] == {"pv_panel": ["u", "t"]}.get(name, ["u"] * (told["l"] > 0))
    passes(tmp_path, "kf", compiler=compiler(), flags=(*STRICT, "-O1", "-ffp-contract=off"))
    saved(tmp_path / "size.c", '#include "kf.h"\n#include <stdio.h>\nint main(void) { printf("%zu", sizeof(kf_filter)); return 0; }\n')
    cc(compiler(), "size.c", "-o", "size", folder=tmp_path)
    assert int(printed(tmp_path / "size")) == told["ram"]


FINE = """\
import numpy as np
x0, P0, Q, R = [1.0, 2.0], [1.0, 1.0], [0.01, 0.01], [0.1]


def f(x):
    return [x[0] + 0.1 * x[1], x[1] * np.cos(x[0])]


def h(x):
    return [np.hypot(x[0], x[1])]
"""
REFUSED: dict[str, tuple[Callable[[str], str], tuple, str]] = {
    "no f": (lambda s: s.replace("def f", "def g"), (), "f: is missing"),
    "no h": (lambda s: s.replace("def h", "def g"), (), "h: is missing"),
    "wrong H": (lambda s: s + "\n\ndef H(x):\n    return [[x[0], x[1]]]\n", (), "H["),
    "wrong A": (lambda s: s + "\n\ndef A(x):\n    return np.eye(2)\n", (), "A["),
    "R is 0": (lambda s: s.replace("[0.1]", "[0.0]"), (), "no noise"),
    "R is a function that is 0": (lambda s: s + "\n\ndel R\n\n\ndef R(x):\n    return [0 * x[0]]\n", (), "no noise"),
    "R is negative": (lambda s: s.replace("[0.1]", "[-0.1]"), (), "R"),
    "R is NaN": (lambda s: s.replace("[0.1]", "[np.nan]"), (), "R"),
    "x0 is infinite": (lambda s: s.replace("[1.0, 2.0]", "[np.inf, 2.0]"), (), "x0"),
    "Q is no covariance": (lambda s: s.replace("[0.01, 0.01]", "[[0.01, 1.0], [1.0, 0.01]]"), (), "Q"),
    "a NaN constant in f": (lambda s: s.replace("0.1 *", "np.nan *"), (), "f: answers nan for x1"),
    "an infinite constant in f": (lambda s: s.replace("0.1 *", "np.inf *"), (), "f: answers inf for x1"),
    "an infinite constant in h": (lambda s: s.replace("np.hypot(x[0]", "1e999 + np.hypot(x[0]"), (), "h: answers inf for z1"),
    "erf": (lambda s: s.replace("np.hypot(x[0], x[1])", "__import__('math').erf(x[0])"), (), "line 10"),
    "while": (lambda s: s.replace("    return [np.hypot", "    while x[0] > 1:\n        x[0] -= 1\n    return [np.hypot"), (), "line 10"),
    "random": (lambda s: s.replace("np.hypot(x[0], x[1])", "x[0] + np.random.normal()"), (), "twice"),
    "an index": (lambda s: s.replace("np.hypot(x[0], x[1])", "[1, 2, 3][int(x[0])]"), (), "line 10"),
    "text": (lambda s: s.replace("np.hypot(x[0], x[1])", "'far'"), (), "h"),
    "None": (lambda s: s.replace("return [np.hypot", "[np.hypot"), (), "h"),
    "two numbers": (lambda s: s.replace("[np.hypot(x[0], x[1])]", "[x[0], x[1]]"), (), "h"),
    "too large for a float": (lambda s: s.replace("[0.1]", "[1e60]"), (), "float"),
    "a number of f too large": (lambda s: s.replace("0.1 *", "1e60 *"), (), "f(x1): has the number 1e+60"),
    "17 states": (lambda s: s.replace("x0, P0, Q", "x0, P0, Q, _ = [0] * 17, [1] * 17, [1] * 17, 0; _").replace("], [1.0, 1.0], [0.01, 0.01], [0.1]", "]; R = [0.1]"), (), "16"),
    "33 rounds": (lambda s: s.replace("    return [x[0]", "    for _ in range(5000):\n        x = [x[0] + np.sin(x[1]), x[1] + np.cos(x[0])]\n    return [x[0]"), (), "operations"),
    "a file that fails": (lambda s: s + "1 / 0\n", (), "ZeroDivisionError"),
    "no file": (lambda s: "", (), "missing"),
}


@pytest.mark.parametrize("which", REFUSED)
def test_what_is_refused(which: str, tmp_path: Path) -> None:
    change, options, said = REFUSED[which]
    text = change(FINE)
    assert text != FINE or options
    (tmp_path / "model.py").write_text(text, encoding="utf-8")
    done = kalmanq("compile", "model.py", "-o", "kf.c", *options, folder=tmp_path)
    assert done.returncode not in (0, -11), done.stdout
    assert said in done.stderr and "Traceback" not in done.stderr
    assert len(wrong_lines(done)) == 1 or "Usage" in done.stderr, done.stderr
    assert not done.stdout.strip() and [one.name for one in tmp_path.iterdir()] == ["model.py"]


@pytest.mark.parametrize("out", ("int.c", "class.c", "math.c", "Kf.c", "2.c", "kf.h", "a b.c", "a/kf.c", "model.py"))
def test_names_that_no_function_may_have(out: str, tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text(FINE, encoding="utf-8")
    done = kalmanq("compile", "model.py", "-o", out, folder=tmp_path)
    assert done.returncode not in (0, -11) and len(wrong_lines(done)) == 1 and "Traceback" not in done.stderr
    assert (tmp_path / "model.py").read_text() == FINE and [one.name for one in tmp_path.iterdir()] == ["model.py"]


NAMED = (["int", "double"], ["x", "x low"], ["Höhe über NN", "速度"], ["a b", "a  b"], ["x" * 200, "x" * 200 + "y"],
         ["*/ evil", "\\"], ["covariance", "start"], ["f", "z"], ["", " "], ["mean", "variance_mean"])


@pytest.mark.parametrize("names", first(4, NAMED), ids=str)
def test_states_of_any_name(names: list[str], tmp_path: Path) -> None:
    """They come to C that compiles, or are refused by name."""
    text = FINE + f"\n\nstates = {{'names': {names!r}, 'units': ['*/', 'm\\n2']}}\nmeasurements = {names[:1]!r}\n"
    (tmp_path / "model.py").write_text(text, encoding="utf-8")
    done = kalmanq("compile", "model.py", "-o", "kf.c", folder=tmp_path)
    if done.returncode:
        assert len(wrong_lines(done)) == 1 and "Traceback" not in done.stderr
    else:
        cc(compiler(), *STRICT, "-fsyntax-only", tmp_path / "kf.c", tmp_path / "kf_test.c")


@pytest.mark.parametrize("name", first(3, ["int", "a_some", "größe", "some", "A", "covariance"]))
def test_sensors_of_any_name(name: str, tmp_path: Path) -> None:
    sensors = f"sensors = {{'{name}': (h, [0.1]), 'a': (lambda x: x, [1.0, 1.0])}}"
    text = FINE.replace("Q, R =", "Q, _ =") + f"\n\n{sensors}\ndel h\n"
    (tmp_path / "model.py").write_text(text, encoding="utf-8")
    done = kalmanq("compile", "model.py", "-o", "kf.c", folder=tmp_path)
    if done.returncode:
        assert len(wrong_lines(done)) == 1 and done.stderr.startswith("kalmanq: model.py: sensors: ")
    else:
        cc(compiler(), *STRICT, "-fsyntax-only", tmp_path / "kf.c", tmp_path / "kf_test.c")

