"""The unknown start in fixed point: within realistic ranges, beside double with the ranges as its prior."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.linalg import block_diag

from kalmanq import KalmanqError, KalmanqWarning, Model, Quantity, Smoother
from kalmanq.core import lib
from kalmanq.firmware.designs import Part, design
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import Record


def turn(rows: float) -> np.ndarray:
    w = 2 * np.pi / rows
    return np.array([[np.cos(w), np.sin(w)], [-np.sin(w), np.cos(w)]])


TREND = np.array([[1.0, 1.0], [0.0, 1.0]])
# A, Q, H, R, the first state, rows
WEEKLY = (block_diag(TREND, turn(52), turn(26)), np.diag([0.02, 1e-6, 1e-5, 1e-5, 1e-5, 1e-5]), [1, 0, 1, 0, 1, 0],
          0.1, [320, 0.03, 2.5, 1, 0.7, 0.3], 500)
LEVEL_AND_SLOPE = (TREND, np.diag([0.1, 0.01]), [1, 0], 4.0, [100, 1], 200)
MODELS = {"weekly": WEEKLY, "trend": LEVEL_AND_SLOPE}


def drawn(which: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    A, Q, H, R, x, rows = MODELS[which]
    draw, states = np.random.default_rng(seed), np.empty((rows, len(A)))
    for t in range(rows):
        states[t] = x
        x = A @ x + np.sqrt(np.diag(Q)) * draw.normal(size=len(A))
    return states, states @ H + np.sqrt(R) * draw.normal(size=rows)


def model(which: str, ranges: np.ndarray, most: float, **prior: object) -> Model:
    A, Q, H, R, _, _ = MODELS[which]
    return Model(A, H=H, R=R, Q=Q, states=[Quantity(f"x{i}", "", one) for i, one in enumerate(ranges)],
                 measurements=[Quantity("z", "", most)], **prior)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("room", [1.1, 1.5, 10, 1000])
@pytest.mark.parametrize("which", MODELS)
def test_ranges_carry_the_start(which: str, room: float, seed: int) -> None:
    """Between the exact start and the start with ranges / 3; it was up to 4500 sigma off, and saturated."""
    states, z = drawn(which, seed)
    ranges, most = room * np.abs(states).max(0), max(room, 1.05) * np.abs(z).max()
    run = Smoother(model(which, ranges, most), "q31").run(z)
    exact = Smoother(model(which, ranges, most)).run(z)
    bounded = Smoother(model(which, ranges, most, P0=np.diag((ranges / 3) ** 2))).run(z)
    assert not run.events & lib.KQ_EVENT_SATURATED
    ends = [np.abs(run.smoothed - one.smoothed) / one.smoothed_sigma for one in (exact, bounded)]
    assert np.minimum(*ends).max() < 0.1
    if which == "weekly":  # weekly rows tell so little at first that the ranges are all there is
        assert ends[1].max() < 0.1
    late = np.abs(run.sigma / bounded.sigma - 1)[-20:]
    assert late.max() < 0.01
    # right beside the truth, too: the mean square of errors in sigma over the first rows
    assert np.mean(((run.smoothed - states) / run.smoothed_sigma)[:60] ** 2) < 3


def test_a_float_that_cannot_tell_says_so() -> None:
    """Harmonics from six weeks: a sigma just known was 57 to 73 % off, without an event"""
    for seed in range(3):
        _, z = drawn("weekly", seed)
        with pytest.warns(KalmanqWarning, match="precision"):
            Smoother(model("weekly", np.full(6, np.nan), np.nan), "f32").run(z)
    _, z = drawn("trend", 0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Smoother(model("trend", np.full(2, np.nan), np.nan), "f32").run(z)


def test_a_design_gives_the_start_room() -> None:
    A, Q, H, R, _, _ = LEVEL_AND_SLOPE
    for seed in range(3):
        records = [Record(drawn("trend", seed)[1][:, None])]
        ranged, _ = with_ranges(Model(A, H=H, R=R, Q=Q), records)
        made = design(ranged, Part("m3", 128000, 20000), records)
        assert made.trials["q31"].is_good, made.trials["q31"].warnings


@pytest.mark.parametrize("seed", range(3))
def test_a_design_of_a_start_that_the_first_rows_hardly_tell(seed: int) -> None:
    """First estimates go to 5e4 for 50: with that for ranges there was no design.  Other records are held, too."""
    A, Q, H, R, _, _ = WEEKLY
    records = [Record(drawn("weekly", seed)[1][:, None])]
    ranged, chosen = with_ranges(Model(A, H=H, R=R, Q=Q), records)
    made = design(ranged, Part("m3", 128000, 20000), records)
    assert made.trials["q31"].is_good and "the ranges are the prior" in made.trials["q31"].warnings[0]
    assert ranged.states[0].range < 1e4 and max(one.range for one in ranged.states[1:]) < 20
    bounded = ranged.changed(P0=np.diag([(one.range / 3) ** 2 for one in ranged.states]), unknown=[])
    for other in range(10, 20):
        states, z = drawn("weekly", other)
        run, double = Smoother(ranged, "q31").run(z), Smoother(bounded).run(z)
        assert not run.events & lib.KQ_EVENT_SATURATED
        assert np.max(np.abs(run.smoothed - double.smoothed) / double.smoothed_sigma) < 0.01
        assert np.mean(((run.smoothed - states) / run.smoothed_sigma)[:60] ** 2) < 3


def test_an_unknown_start_that_fades_is_not_said_to_wander() -> None:
    z = np.random.default_rng(1).normal(size=(300, 1))
    assert not any(one.wanders for one in with_ranges(Model(0.9, H=1, R=1.0, Q=0.19), [Record(z)])[1])
    assert all(one.wanders for one in with_ranges(Model(1, H=1, R=1.0, Q=0.19), [Record(z)])[1])
    with pytest.raises(KalmanqError, match="unknown"):
        with_ranges(Model(0.9, H=1, R=1.0, Q=0.19), [])
