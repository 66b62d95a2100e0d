"""How many steps a filter keeps for measurements that come late."""

from __future__ import annotations

import math

from kalmanq.errors import KalmanqError
from kalmanq.model import Model

LATEST = 1.5  # times a sensor's delay, that there is memory for
MOST_STEPS = 32767  # of a history


def latest_of(model: Model) -> int:
    """Steps that the latest measurement may be late; 0: all come in time"""
    return max((kept_for(one.delay / _dt(model)) for one in model.sensors), default=0)


def kept_for(late: float) -> int:
    """Steps before now, for what is so many late"""
    if LATEST * late >= MOST_STEPS:
        raise KalmanqError(f"delay: {late:.6g} steps, and a filter keeps {MOST_STEPS}, {LATEST:g} times the delay: give the delay in seconds, or in "
                           "rows of a model of steps, or take a longer step")
    return math.ceil(LATEST * late - 1e-6)


def steps_late(model: Model, any_dt: bool = False) -> list[int]:
    """Of each sensor its delay, at most where it varies; any_dt: where steps of the chip differ, too"""
    made = []
    for one in model.sensors:
        late = one.delay / _dt(model)
        if late and not any_dt and not one.measured and abs(late - round(late)) > 1e-6:
            raise KalmanqError(f"sensors: the delay of {one.name}, {one.delay:g}, is no multiple of dt: make it one, or give "
                               "steps of any length (design --any-dt, compile --tunable)")
        made.append(round(late))
    return made


def _dt(model: Model) -> float:
    return model.continuous.dt if model.continuous else 1.0
