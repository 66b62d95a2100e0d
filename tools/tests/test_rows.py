"""What goes in: rows, gaps, controls, gates over partial rows, and tables of pandas."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

import kalmanq
import models
from kalmanq import Filter, KalmanqError, LagSmoother, Quantity, Robust, Smoother, SteadyFilter
from kalmanq.core import ARITHMETICS as CORE
from kalmanq.core import ffi, lib
from kalmanq.run.parts import Parts, doubles
from test_twin import ARITHMETICS, LIMITS, SEEDS

# ------------------------------------------------------------------------------ gates


def outliers(model: kalmanq.Model, z: np.ndarray, seed: int) -> np.ndarray:
    """Some rows that lie between the limits of one component and of all"""
    draw = np.random.default_rng(seed)
    made = z.copy()
    rows = draw.choice(np.arange(20, len(z)), 30, replace=False)
    made[rows] += draw.choice([-1, 1], size=(30, model.m)) * draw.uniform(2.5, 8, size=(30, model.m))
    made[rows[:20], draw.integers(0, model.m, 20)] = np.nan
    return made


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_gate_s_limit_is_that_of_the_components_which_are_there(arithmetic, seed):
    model = models.pair()
    z = outliers(model, models.data(model, 200, seed)[0], seed)
    limits = stats.chi2.ppf(0.99, [1, 2])
    mean, sigma, rejected = models.gated(model, z, None, limits)
    _, _, by_two = models.gated(model, z, None, limits[[1, 1]])
    assert np.any(rejected != by_two)  # or there is nothing to see here
    f, rows = Filter(model, arithmetic), Filter(model, arithmetic)
    run = f.run(z, robust=Robust("gate", 0.99, 65535))
    there = np.any(~np.isnan(z), axis=1)
    assert np.array_equal(run.taken[there] == 0, rejected[there])
    assert np.max(np.abs(run.mean - mean) / sigma) < LIMITS[arithmetic]
    assert np.max(np.abs(run.sigma / sigma - 1)) < LIMITS[arithmetic]
    for t in range(len(z)):
        if t:
            rows.predict()
        rows.update(z[t], Robust("gate", 0.99, 65535))
    assert np.array_equal(rows.memory, f.memory)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_gate_over_full_rows_is_the_core_s_with_one_limit(arithmetic):
    model = models.pair()
    z = outliers(model, models.data(model, 120, 5)[0], 5)
    z = np.where(np.isnan(z), 3.0, z)
    a, f = CORE[arithmetic], Filter(model, arithmetic)
    gates = a.losses("gate", 1)
    gate = gates[0]
    gate.limit, gate.run = a.function("chi_square_limit")(2, lib.KQ_LEVEL_99), 3
    words = np.ascontiguousarray(f.parts.words(z, "measurements"))
    for t in range(len(z)):
        if t:
            f.predict()
        status = a.function("update_robust")(f._handle, f.parts.sensor, a.pointer(words[t]), 3, gates)
        assert status == 0
    other = Filter(model, arithmetic)
    run = other.run(z, robust=Robust("gate", 0.99, 3))
    assert np.array_equal(f.memory, other.memory) and {"gated", "rejections"} <= set(run.event_names)


# ------------------------------------------------------------------------------ words


def test_words_are_those_that_the_core_makes():
    """Halves go away from 0, and the last one that the range leaves room for is refused as there."""
    model = kalmanq.Model([[1]], H=[1], R=1.0, Q=1.0, P0=[1], states=[Quantity("x", "", 100, 2)],
                          measurements=[Quantity("z", "", 100.25, 2)])
    parts, one, range_error = Parts(model, "q31"), ffi.new("int32_t *"), ffi.new("kq_range_error_q31 *")
    draw = np.random.default_rng(1)
    ends = [100.25, 100.37, 100.375, 100.38, -100.375, -100.374]
    near_half = [np.nextafter(0.125, 0), -np.nextafter(0.125, 0), np.nextafter(0.125, 1)]
    for value in [*np.arange(-3, 3, 0.125), *draw.uniform(-101, 101, 200), *ends, *near_half]:
        status = lib.kq_vector_prepare_q31(one, [value], 1, parts.formats["measurements"], range_error)
        if status:
            with pytest.raises(KalmanqError, match="range"):
                parts.words(np.array([[value]]), "measurements")
        else:
            assert parts.words(np.array([[value]]), "measurements")[0, 0] == one[0]


def test_numbers_are_those_that_the_core_makes():
    a, formats = CORE["q31"], ffi.new("kq_format_q31[]", [[2**30, 3], [2**30, 20]])
    draw = np.random.default_rng(2)
    values = draw.normal(size=(200, 2)) * 10.0 ** draw.integers(-6, 6, size=(200, 2))
    values[:3] = [[0, 1], [1 - 2.0**-40, -1 + 2.0**-40], [0.1, -0.99]]
    made = a.made_of(values, np.array([3 - 3, 3 - 20]))
    out = ffi.new("kq_scaled_q31[2]")
    for row, given in zip(made, values):
        assert lib.kq_matrix_prepare_q31(out, doubles(given), 1, 2, formats, formats) == 0
        assert [tuple(one) for one in row.tolist()] == [(one.mantissa, one.exponent) for one in out]
        assert a.parameter(given[0]) == {"mantissa": out[0].mantissa, "exponent": out[0].exponent}
    assert np.allclose(a.numbers(made, np.array([0, -17])), values, rtol=2.0**-30)


# ------------------------------------------------------------------------------ matrices by their names


@pytest.mark.parametrize("said, call", [
    ("Model(A, H=..., R=..., Q=...)", lambda I: kalmanq.Model(I, I, I, I)), ("Model(A, H=..., R=..., Q=...)", lambda I: kalmanq.Model(I, I, R=I, Q=I)),
    ("Model.of_continuous(F, H=..., R=..., Qc=..., dt=...)", lambda I: kalmanq.Model.of_continuous(I, I, I, I, dt=1)),
    ("Varying(A=..., B=..., Q=..., H=..., R=..., D=...)", lambda I: kalmanq.Varying(I, I)),
    ("LeastSquares(x0=..., P0=..., arithmetic=...)", lambda I: kalmanq.LeastSquares([0, 0], [1, 1])),
    ("run(H=..., z=..., r=...)", lambda I: kalmanq.LeastSquares(x0=[0], P0=[1]).run([1, 2], [3, 4]))])
def test_matrices_that_may_be_mistaken_for_one_another_have_names(said, call):
    with pytest.raises(TypeError) as refused:
        call(np.eye(2))
    assert str(refused.value) == f"{said}: give the matrices by their names, in any order"


def test_matrices_by_name_are_in_any_order():
    model = kalmanq.Model(Q=[[2.0]], R=3.0, H=[1], A=[[4.0]])
    assert (model.A, model.H, model.R, model.Q) == (4, 1, 3, 2)
    model = kalmanq.Model.of_continuous(0.0, Qc=2.0, R=3.0, H=1, dt=0.5)
    assert (model.R, model.Q) == (3, 1)


# ------------------------------------------------------------------------------ rows and controls


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_what_is_refused_changes_nothing(arithmetic):
    f = Filter(models.cart(), arithmetic)
    before = f.memory
    with pytest.raises(KalmanqError):
        f.step([np.inf], [0.1])
    assert np.array_equal(f.memory, before) and f.row == 0
    for call in (lambda: f.run([1.0, 2.0], [[0.1], [np.nan]]), lambda: f.predict([np.nan]),
                 lambda: f.forecast(1, [[np.nan]])):
        with pytest.raises(KalmanqError, match="push: .*missing"):
            call()
    assert np.array_equal(f.memory, before)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_row_without_a_measurement_takes_nothing(arithmetic):
    f = Filter(models.pair(), arithmetic)
    f.update([1.0, 2.0])
    assert f.taken == 2
    f.predict()
    f.update([np.nan, np.nan])
    assert (f.taken, f.nis) == (0, 0.0)
    run = f.run([[1.0, np.nan], [np.nan, np.nan]])
    assert f.taken == 0 and run.taken.tolist() == [1, 0] and np.isnan(run.nis[1])


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_calls_and_sequences_may_follow_each_other(arithmetic):
    model = models.cart()
    z, u = models.data(model, 40, 3)
    whole, mixed = Filter(model, arithmetic), Filter(model, arithmetic)
    whole.run(z, u)
    mixed.run(z[:10], u[:10])
    mixed.predict(u[9])  # in the place of what a run would carry over
    mixed.update(z[10])
    for t in range(11, 39):
        mixed.step(z[t], u[t - 1])
    mixed.predict(u[38])
    mixed.update(z[39])
    assert np.array_equal(whole.memory, mixed.memory) and whole.row == mixed.row == 39
    begun = Filter(model, arithmetic)
    begun.update(z[0])
    begun.run(z[1:4])  # each row of a run is a row more
    assert begun.row == 3
    copied = mixed.copy()
    assert copied.row == 39 and mixed.forecast(5).row == 44


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_steady_filter_in_blocks_is_the_same_bits(arithmetic):
    model = models.cart()
    z, u = models.data(model, 60, 8)
    whole, blocks = SteadyFilter(model, arithmetic).run(z, u), SteadyFilter(model, arithmetic)
    parts = [blocks.run(z[a:b], u[a:b]).mean for a, b in ((0, 1), (1, 23), (23, 60))]
    assert np.array_equal(np.vstack(parts), whole.mean)


def test_controls_have_a_row_for_each_row():
    model = models.cart()
    z, u = models.data(model, 30, 1)
    calls = (lambda: Filter(model).run(z, u[:3]), lambda: Smoother(model).run(z, u[:3]),
             lambda: SteadyFilter(model).run(z, u[:3]), lambda: kalmanq.Estimation(model, [z], u=[u[:3]]),
             lambda: LagSmoother(model, 2).run(z, u[:3]))
    for call in calls:
        with pytest.raises(KalmanqError, match="u has 3 rows, z has 30"):
            call()


# ------------------------------------------------------------------------------ tables


def frame(z: np.ndarray):
    pandas = pytest.importorskip("pandas")
    index = pandas.date_range("2024-03-01", periods=len(z), freq="h", name="when")
    table = pandas.DataFrame({"second": z[:, 1], "note": "x", "first": z[:, 0]}, index=index)
    return pandas, table


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_table_s_columns_are_known_by_their_names_and_its_index_is_kept(arithmetic):
    model = models.pair()
    z, _ = models.data(model, 30, 2)
    pandas, table = frame(z)
    exact = Smoother(model, arithmetic).run(z)
    assert exact.index is None
    for make in (Filter, Smoother, lambda m, a: LagSmoother(m, 3, a)):
        run = make(model, arithmetic).run(table)
        assert np.array_equal(run.mean, exact.mean) and run.index.equals(table.index)
    back = Smoother(model, arithmetic).run(table).to_frame()
    assert back.index.equals(table.index) and back.index.name == "when"
    assert np.array_equal(back["b_smoothed"], exact.smoothed[:, 1])
    assert back.loc[table.index[4], "a_mean"] == exact.mean[4, 0]


def test_tables_that_do_not_fit_are_refused_by_name():
    z, _ = models.data(models.pair(), 10, 2)
    pandas, table = frame(z)
    f = Filter(models.pair())
    with pytest.raises(KalmanqError, match="^z: .*second; .*note, first"):
        f.run(table.drop(columns="second"))
    with pytest.raises(KalmanqError, match="^z: .*first; .*0, 1"):
        f.run(pandas.DataFrame(z))
    with pytest.raises(KalmanqError, match="^z: .*first .*twice"):
        f.run(pandas.concat([table, table["first"]], axis=1))
    with pytest.raises(KalmanqError, match="array of numbers"):
        f.run(table.assign(first="wild"))


def test_series_and_what_pandas_calls_missing():
    pandas = pytest.importorskip("pandas")
    model = kalmanq.Model([[1]], H=[1], R=4.0, Q=1.0, P0=[100])
    z = pandas.Series([1, None, 3, 2], dtype="Int64", index=[10, 20, 30, 40], name="anything")
    run, exact = Filter(model).run(z), Filter(model).run([1.0, np.nan, 3.0, 2.0])
    assert np.array_equal(run.mean, exact.mean) and list(run.index) == [10, 20, 30, 40]
    assert exact.index is None  # a list has an index, too: a method
    assert list(run.to_frame().index) == [10, 20, 30, 40] and len(exact.to_frame()) == 4
    table = pandas.DataFrame({"z1": z.astype("Float64")})
    assert np.array_equal(Filter(model).run(table).mean, exact.mean)


def test_controls_may_be_a_table_whose_index_agrees():
    pandas = pytest.importorskip("pandas")
    model = models.cart()
    z, u = models.data(model, 20, 4)
    index = pandas.RangeIndex(100, 120)
    both = pandas.DataFrame({"push": u[:, 0], "range": z[:, 0]}, index=index)
    exact = Filter(model).run(z, u)
    for given in ((both, both), (z, both), (both["range"], both["push"]), (both, u)):
        run = Filter(model).run(*given)
        assert np.array_equal(run.mean, exact.mean) and run.index.equals(index)
    steady = SteadyFilter(model).run(both, both)
    assert steady.index.equals(index) and np.array_equal(steady.mean, SteadyFilter(model).run(z, u).mean)
    estimation = kalmanq.Estimation(model, [both], u=[both])
    assert estimation.run(2).log_likelihood == kalmanq.Estimation(model, [z], u=[u]).run(2).log_likelihood
    with pytest.raises(KalmanqError, match="indices"):
        Filter(model).run(both, both.set_axis(range(20)))
    with pytest.raises(KalmanqError, match="^u: .*push"):
        Filter(model).run(both, both[["range"]])


# ------------------------------------------------------------------------------ masks, and what is no real number


def masked(z):
    return np.ma.array(np.nan_to_num(z, nan=1e6), mask=np.isnan(z))


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_what_is_masked_is_missing(arithmetic):
    model = models.cart()
    z, u = models.data(model, 80, 1)
    wanted = Filter(model, arithmetic).run(z, u)
    for given in (masked(z), masked(z[:, 0]), list(masked(z)), masked(z).astype(np.float32).astype(object)):
        close = 1e-5 if getattr(given, "dtype", None) == object else 0
        assert np.allclose(Filter(model, arithmetic).run(given, u).mean, wanted.mean, rtol=close, atol=close)
    assert np.array_equal(Smoother(model, arithmetic).run(masked(z), u).smoothed,
                          Smoother(model, arithmetic).run(z, u).smoothed)
    f = Filter(model, arithmetic)
    f.update(np.ma.array([5.0], mask=[True]))
    assert f.taken == 0
    with pytest.raises(KalmanqError, match="push: .*missing"):
        Filter(model, arithmetic).run(z, np.ma.array(u, mask=u > 2))
    level = kalmanq.Model(1, H=1, R=1, Q=1, P0=100, states=[Quantity("x", range=1e3)], measurements=[Quantity("z", range=1e3)])
    assert Filter(level, arithmetic).run(np.ma.array([1, 99, 3], mask=[0, 1, 0])).mean[-1, 0] < 3


def test_a_masked_entry_of_a_model_is_refused():
    for key in ("A", "H", "R", "Q", "x0", "P0"):
        given = {"A": 1.0, "H": 1.0, "R": 1.0, "Q": 1.0, "x0": 0.0, "P0": 1.0, key: np.ma.array([1.0], mask=[True])}
        with pytest.raises(KalmanqError, match=f"{key}: .*finite"):
            kalmanq.Model(**given)


COMPLEX = [np.array([1, 2 + 1j, 3]), [1, 2 + 1j, 3], np.array([1, np.complex128(2 + 1j), 3], object),
           np.ma.array([1, 2 + 1j, 3], mask=[0, 0, 1])]


@pytest.mark.parametrize("z", COMPLEX, ids=range(len(COMPLEX)))
def test_complex_numbers_are_refused(z):
    model = kalmanq.Model(1, H=1, R=1, Q=1, P0=1, B=1)
    pandas = pytest.importorskip("pandas")
    for given in (z, pandas.Series(z), pandas.DataFrame({"z1": z})):
        with pytest.raises(KalmanqError, match="^z: .*complex"):
            Filter(model).run(given, np.zeros(3))
    with pytest.raises(KalmanqError, match="^u: .*complex"):
        Smoother(model).run(np.zeros(3), z)
    f = Filter(model)
    for call in (f.update, f.predict, f.step):
        with pytest.raises(KalmanqError, match="complex"):
            call(z[1:2])
    for key in ("A", "H", "R", "Q", "x0", "P0"):
        with pytest.raises(KalmanqError, match=f"{key}: .*complex"):
            kalmanq.Model(**{"A": 1.0, "H": 1.0, "R": 1.0, "Q": 1.0, "x0": 0.0, "P0": 1.0, key: z[1:2]})
    with pytest.raises(KalmanqError, match="^H: .*complex"):
        kalmanq.Filter(kalmanq.Model(1, H=1, R=1, Q=1, P0=1)).run(np.zeros(3), varying=kalmanq.Varying(H=np.array(z)[:, None]))
    with pytest.raises(KalmanqError, match="complex"):
        kalmanq.LeastSquares(x0=[0.0], P0=[1.0]).run(H=np.ones(3), z=np.zeros(3), r=z)
