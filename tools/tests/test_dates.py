"""Times as dates and durations of NumPy, Python and pandas, and the index of a table."""

from __future__ import annotations

import time
import warnings
from datetime import date, timedelta

import numpy as np
import pytest

import kalmanq
from kalmanq import (
    Filter, FrozenGainFilter, InstantSmoother, KalmanqError, LagSmoother, Model, NonlinearFilter, NonlinearModel, NonlinearSmoother,
    ReweightedSmoother, Smoother, SteadyFilter, Varying, fit)
from test_times import cart, drawn_at_random_times

pandas = pytest.importorskip("pandas")

GIVEN = dict(h=lambda x: [x[0]], Q=[0.1, 0.1], R=[1.0], P0=[1.0, 1.0], x0=[0.0, 0.0])  # of nonlinear models
SECONDS = np.array([0, 0.1, 0.5, 2.0, 2.2, 9.0])


def of_time(seconds: float = 1.0, **more) -> Model:
    """Of one unit of so many seconds"""
    return Model.of_continuous([[0, 1], [0, 0]], H=[1, 0], R=0.1, Qc=[0, 1], dt=0.1, P0=[1, 1], **more)


def dated():
    """SECONDS as dates and durations, of NumPy, Python and pandas"""
    index = pandas.to_datetime(SECONDS + 1.7e9, unit="s").round("ms")
    since = index - index[0]
    zoned = index.tz_localize("UTC").tz_convert("Europe/Berlin")
    return [index, index.to_numpy(), index.as_unit("ms").to_numpy(), list(index), index.to_pydatetime(), list(zoned), zoned,
            [one.to_pydatetime() for one in zoned], pandas.Series(index), pandas.Series(zoned), index.to_period("ms"), since, since.to_numpy(), list(since),
            since.to_pytimedelta(), [one.to_pytimedelta() for one in since], pandas.Series(since), since.to_numpy().astype("timedelta64[ms]")]


@pytest.fixture
def far_from_utc(monkeypatch):
    with monkeypatch.context() as patched:
        patched.setenv("TZ", "UTC+9")
        time.tzset()
        yield
    time.tzset()


@pytest.mark.parametrize("unit, per_second", [("s", 1.0), ("ms", 1e3), ("min", 1 / 60)])
@pytest.mark.filterwarnings("error")
def test_dates_and_durations_are_times(unit, per_second, far_from_utc):
    """In the unit of the model, since the first one, which is of UTC; NumPy would warn of a zone"""
    model = of_time(time_unit=unit)
    z = np.arange(6.0)
    exact = Smoother(model).run(z, times=SECONDS * per_second)
    for given in dated():
        f = Filter(model)
        run = f.run(z, times=given)
        assert np.allclose(run.mean, exact.mean, rtol=1e-9, atol=1e-12) and abs(f.time - 9 * per_second) < 1e-9 * per_second, type(given)
        assert f.origin in (None, dated()[1][0]), type(given)
    days = Filter(of_time(time_unit="day"))
    days.run(z[:3], times=[date(2024, 2, 28), date(2024, 3, 1), date(2024, 3, 2)])
    assert days.time == 3 and days.origin == np.datetime64("2024-02-28")


def test_the_index_of_a_table_says_when_its_rows_are():
    """Of every entry that takes rows: dates, durations, fractions, whole numbers whose name has a unit"""
    model, z = of_time(), np.array([1.0, 2, 3, 4, 3, 5])
    exact, apart = Smoother(model).run(z, times=SECONDS), Smoother(model).run(z)
    assert np.abs(exact.mean[-1] - apart.mean[-1]).max() > 0.1
    ms = np.round(1000 * SECONDS).astype(int)
    indices = [one for one in dated() if isinstance(one, pandas.Index)] + [
        pandas.Index(SECONDS), pandas.Index(1000 * SECONDS, name="t [ms]"), pandas.Index(ms, name="t_ms"), pandas.Index(ms + 1_700_000_000_000, name="time [ms]"),
        pandas.Index(dated()[4], dtype=object)]
    for index in indices:
        table = pandas.Series(z, index=index)
        for run in (Filter(model).run(table), Smoother(model).run(table.to_frame("z1")), LagSmoother(model, 2).run(table),
                    InstantSmoother(model).run(table), FrozenGainFilter(model).run(table)):
            assert np.allclose(run.mean, exact.mean, rtol=1e-6, atol=1e-9) and run.index.equals(index)
        assert np.allclose(Smoother(model).run(table).smoothed, exact.smoothed, rtol=1e-6, atol=1e-9)
        blocks = Filter(model)
        parts = [blocks.run(table[rows]).mean for rows in (slice(0, 1), slice(1, 4), slice(4, 6))]
        assert np.allclose(np.concatenate(parts), exact.mean, rtol=1e-6, atol=1e-9)
        assert abs(kalmanq.likelihood(model, [table]) - exact.log_likelihood.sum()) < 1e-6
    pushed = of_time(B=[0, 1])
    by_u = Filter(pushed).run(z, pandas.Series(z, index=indices[0]))
    assert np.allclose(by_u.mean, Filter(pushed).run(z, z, times=SECONDS).mean)
    assert np.array_equal(Filter(model).run(table, times=0.1 * np.arange(6)).mean, apart.mean)  # what is given counts
    steps = Varying(A=np.broadcast_to(np.eye(2), (6, 2, 2)))
    assert np.array_equal(Filter(model).run(table, varying=steps).mean, Filter(model).run(z, varying=steps).mean)


def test_a_fit_takes_the_times_of_an_index():
    times, z = drawn_at_random_times(1)
    index = pandas.to_datetime(1e9 * times + 1e18)
    for offset in (None, [0.5]):
        model = cart(d=offset)
        tables, given = [pandas.DataFrame({model.measurements[0].name: z.ravel()}, index=index)], fit(model, [z], ["R"], times=[times])
        assert abs(fit(model, tables, ["R"]).log_likelihood - given.log_likelihood) < 1e-5
    for call in (lambda: kalmanq.gradient(model, tables), lambda: kalmanq.Estimation(model, tables)):
        with pytest.raises(KalmanqError, match="records .*dt"):
            call()


def test_a_step_may_be_a_duration():
    for make in (lambda: Filter(of_time()), lambda: NonlinearFilter(NonlinearModel(lambda x, dt: [x[0] + dt * x[1], x[1]], dt=0.1, **GIVEN))):
        one, other = make(), make()
        for dt in (pandas.Timedelta("250ms"), np.timedelta64(250, "ms"), timedelta(seconds=0.25)):
            one.predict(dt=dt)
            other.predict(dt=0.25)
            assert np.array_equal(one.covariance, other.covariance)
        for wrong in (pandas.Timestamp(0), "1 s", pandas.Timedelta(0), np.nan, [1.0]):
            with pytest.raises(KalmanqError, match="^(dt|times): "):
                one.predict(dt=wrong)


def test_one_record_is_no_list_of_them():
    model, z = of_time(), np.arange(5.0)
    for given in (z, pandas.DataFrame({"z": z}), pandas.Series(z)):
        with pytest.raises(KalmanqError, match=r"^z: .*\[z\]$"):
            fit(model, given, ["R"])


def test_an_index_that_may_count_rows_is_asked_about():
    model, z = of_time(), np.arange(5.0)
    apart = Filter(model).run(z)
    rows = pandas.Series(z)
    for table in (rows, rows.set_axis(range(100, 105)), rows.set_axis(pandas.to_datetime(0.1 * np.arange(5) + 1e9, unit="s").round("ms"))):
        assert np.allclose(Filter(model).run(table).mean, apart.mean, rtol=1e-12)
    for index, said in ((pandas.Index([0, 1, 2, 4, 5]), "^z: its index .*whole numbers .*times=, or z.to_numpy"),
                        (pandas.RangeIndex(0, 10, 2), "whole numbers"), (pandas.RangeIndex(5, name="time"), "whole numbers"),
                        (pandas.Index(["2024-01-01"] * 5), "^z: its index .*pandas.to_datetime"),
                        (pandas.MultiIndex.from_product([["a"], range(5)]), "pandas.to_datetime"),
                        (pandas.to_datetime(["2024-01-01"] * 5), "^row 1: the index of z: all rows have one time.*times=, or z.to_numpy")):
        with pytest.raises(KalmanqError, match=said):
            Filter(model).run(rows.set_axis(index))
    seconds = Model.of_continuous([[0.0]], H=[1], R=1, Qc=[1], dt=2, P0=[1])
    assert np.array_equal(Filter(seconds).run(rows.set_axis(range(0, 10, 2))).mean, Filter(seconds).run(z).mean)  # both say the same
    f = Filter(model)
    f.run(rows.set_axis(pandas.date_range("2024-01-01", periods=5, freq="s")))
    with pytest.raises(KalmanqError, match="times: numbers, .*dates"):
        f.run(z, times=np.arange(100.0, 105))


def test_a_column_of_times_is_taken_where_the_index_counts_rows():
    model, z = of_time(), np.arange(6.0)
    exact, apart = Filter(model).run(z, times=SECONDS), Filter(model).run(z)
    assert np.abs(exact.mean - apart.mean).max() > 0.1
    name, dates = model.measurements[0].name, pandas.to_datetime(SECONDS + 1.7e9, unit="s").round("ms")
    for head, times in (("time", dates), ("time", SECONDS), ("t [ms]", (1000 * SECONDS).round().astype(int))):
        table = pandas.DataFrame({head: times, name: z, "note": "x"})
        assert np.allclose(Filter(model).run(table).mean, exact.mean, rtol=1e-6, atol=1e-9)
        assert np.array_equal(Filter(model).run(table.set_index(0.1 * np.arange(6))).mean, apart.mean)  # the index says it
    for times in (range(6), ["2024-01-01"] * 6, SECONDS[::-1]):
        with pytest.raises(KalmanqError, match="column time"):
            Filter(model).run(pandas.DataFrame({"time": times, name: z}))
    table = pandas.DataFrame({"time": SECONDS, "z1": z})
    with pytest.warns(kalmanq.KalmanqWarning, match="column time"):
        Filter(Model(1, H=1, R=1, Q=1, P0=1)).run(table)


def test_what_takes_steps_alone_refuses_an_index_of_others():
    model, z = Model.of_continuous([[0.0]], H=[1], R=1, Qc=[1], dt=0.1, P0=[1]), np.arange(6.0)
    table, even = (pandas.Series(z, index=pandas.to_timedelta(one, unit="s")) for one in (SECONDS, 0.1 * np.arange(6)))
    for make in (SteadyFilter, ReweightedSmoother):
        with pytest.raises(KalmanqError, match="dt = 0.1 .*0.1 to 0.5 s"):
            make(model).run(table)
        assert np.array_equal(make(model).run(even).mean, make(model).run(z).mean)
    f = SteadyFilter(model)
    f.run(even[:2])
    with pytest.raises(KalmanqError, match="0.1 to 0.4 s"):
        f.run(even[4:])


def test_a_model_of_steps_warns_of_an_irregular_index():
    model, z = Model(1, H=1, R=1, Q=1, P0=1), np.arange(8.0)
    stamps = pandas.date_range("2024-01-01", periods=9, freq="D")
    left_out = np.delete(np.arange(9), 5)
    rows = pandas.Series(z)
    said = "^z: row 5: .*index .*irregular, .* {0} to {1}, .* {0}: "
    for index, least, most in ((stamps[left_out], 86400, 172800), (pandas.Index(left_out), 1, 2), (pandas.Index(0.5 * left_out), 0.5, 1),
                               (pandas.Index(stamps[left_out].to_pydatetime(), dtype=object), 86400, 172800)):
        for call in (Filter(model).run, Smoother(model).run, SteadyFilter(model).run, ReweightedSmoother(model).run,
                     lambda table: kalmanq.likelihood(model, [table]), lambda table: fit(model, [table], iterations=2)):
            with pytest.warns(kalmanq.KalmanqWarning, match=said.format(least, most)) as told:
                call(rows.set_axis(index))
            assert len(told) == 1, [str(one.message) for one in told]
    with pytest.warns(kalmanq.KalmanqWarning, match="^z: row 1: .*index .*sort"):
        Filter(model).run(rows.set_axis(stamps[left_out][::-1]))
    for index in (stamps[:8][::-1], pandas.Index(np.arange(8.0)[::-1])):  # newest first
        with pytest.warns(kalmanq.KalmanqWarning, match="^z: row 1: .*index .*sort"):
            Filter(model).run(rows.set_axis(index))
    with pytest.warns(kalmanq.KalmanqWarning, match="^z: row .: .*index .*irregular"):
        Filter(model).run(rows.set_axis(pandas.Index([0, 0.1, 0.2, 17, 17.1, 20, 33, 40])))
    random = np.random.default_rng(1).integers(0, 999, 8)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for index in (stamps[:8], pandas.bdate_range("2024-01-01", periods=8), pandas.date_range("2024-01-01", periods=8, freq="MS"), random,
                      np.sort(random), list("abcdefgh"), range(8, 0, -1), pandas.period_range("2024-01", periods=8, freq="M")):
            Filter(model).run(rows.set_axis(index))
        Filter(model).run(rows.set_axis(stamps[left_out]), varying=Varying(Q=np.ones(8)))


def test_a_nonlinear_model_takes_the_times_of_an_index():
    z = np.arange(6.0)
    model = NonlinearModel(lambda x, dt: [x[0] + dt * x[1], x[1]], dt=0.1, **GIVEN)
    table = pandas.Series(z, index=pandas.to_datetime(SECONDS + 1.7e9, unit="s").round("ms"))
    exact, apart = NonlinearSmoother(model).run(z, times=SECONDS), NonlinearSmoother(model).run(z)
    assert np.abs(exact.mean - apart.mean).max() > 0.1
    for run in (NonlinearFilter(model).run(table), NonlinearSmoother(model).run(table)):
        assert np.allclose(run.mean, exact.mean, rtol=1e-6, atol=1e-9) and run.index is table.index
    assert np.allclose(NonlinearSmoother(model).run(table).smoothed, exact.smoothed, rtol=1e-6, atol=1e-9)
    assert abs(kalmanq.likelihood(model, [table]) - exact.log_likelihood.sum()) < 1e-6
    f = NonlinearFilter(model)
    assert np.allclose(np.concatenate([f.run(table[:2]).mean, f.run(table[2:]).mean]), exact.mean, rtol=1e-6, atol=1e-9)
    steps = NonlinearModel(lambda x: [x[0] + x[1], x[1]], **GIVEN)
    for call in (NonlinearFilter(steps).run, NonlinearSmoother(steps).run):
        with pytest.warns(kalmanq.KalmanqWarning, match="index .*irregular, .* functions of dt") as told:
            call(table)
        assert len(told) == 1
