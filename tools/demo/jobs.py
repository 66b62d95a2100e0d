"""What is run: a state-space model with its data, how to call it, and the ranges that fixed point
asks for.

    x[t+1] = A x[t] + w, w ~ N(0, Q);  z[t] = H x[t] + v, v ~ N(0, R)

x0 and P0 hold before the first measurement.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Sequence

import numpy as np

FORECAST_STEPS = 10  # where nothing else is asked for

# ---- models ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Model:
    kind: str
    states: tuple[str, ...]  # names
    measured: tuple[str, ...]  # names
    A: np.ndarray
    Q: np.ndarray
    H: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray
    # m, as --q has them; Q is proportional to them
    q: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def r(self) -> np.ndarray:
        return np.diag(self.R)

    def with_noise(self, Q: np.ndarray, R: np.ndarray) -> Model:
        """The same model with other noise; Q is a multiple of what it was."""
        return replace(self, Q=Q, R=R, q=self.q * (Q[0, 0] / self.Q[0, 0]))


def local_level(name: str, q: float, r: float, x0: float, p0: float) -> Model:
    """A level that walks at random, q per step, measured with noise of variance r."""
    return Model(
        kind="local level",
        states=(name,),
        measured=(name,),
        A=np.eye(1),
        Q=np.array([[q]]),
        H=np.eye(1),
        R=np.array([[r]]),
        x0=np.array([x0]),
        P0=np.array([[p0]]),
        q=np.array([q]),
    )


def constant_velocity(
    axes: Sequence[str],
    dt: float,
    q: Sequence[float],
    r: Sequence[float],
    x0: Sequence[float],
    p0: Sequence[float],
) -> Model:
    """Axes that move independently, each with the states position, velocity.

    The velocity is driven by white noise of spectral density q (length^2 / time^3); Q is exact
    for any dt.  x0 and p0 (variances) are given state by state.
    """
    d = len(axes)
    position = np.array([[1.0, 0.0]])
    return Model(
        kind="constant velocity",
        states=tuple(name for axis in axes for name in (axis, f"v{axis}")),
        measured=tuple(axes),
        A=np.kron(np.eye(d), np.array([[1.0, dt], [0.0, 1.0]])),
        Q=np.kron(np.diag(q), velocity_noise(dt)),
        H=np.kron(np.eye(d), position),
        R=np.diag(np.asarray(r, dtype=float)),
        x0=np.asarray(x0, dtype=float),
        P0=np.diag(np.asarray(p0, dtype=float)),
        q=np.asarray(q, dtype=float),
    )


def velocity_noise(dt: float) -> np.ndarray:
    """Q of one axis over a step, for unit spectral density."""
    return np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])


def noise_text(model: Model, q_origin: str = "", r_origin: str = "") -> str:
    """q and r of every measured component, which is named where there are several."""
    pairs = [f"q = {q:.6g}{q_origin}, r = {r:.6g}{r_origin}" for q, r in zip(model.q, model.r)]
    if len(pairs) == 1:
        return pairs[0]
    return "; ".join(f"{name}: {pair}" for name, pair in zip(model.measured, pairs))


# ---- jobs ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Published:
    """Noise that the literature has estimated from the same data."""

    source: str
    q: float
    r: float


@dataclass(frozen=True)
class Job:
    name: str  # of the output files
    title: str
    model: Model
    z: np.ndarray  # T x m, NaN where missing
    time: np.ndarray  # T
    dt: float
    ahead: int
    unit: str = ""  # of what is measured
    time_unit: str = ""
    time_name: str = "time"
    truth: np.ndarray | None = None  # T + ahead rows of states, where it is known
    note: str = ""  # a line below the table: the model's numbers
    to_estimate: bool = False  # the model's Q and R are a guess
    published: Published | None = None
    range: float | None = None  # of the measurements, as the user declares it
    inputs: list[Path] = field(default_factory=list)  # files that must not be overwritten
    extra_files: dict[str, str] = field(default_factory=dict)  # to be written too, by name

    @property
    def steps(self) -> int:
        return len(self.z)

    @property
    def future(self) -> np.ndarray:
        """The times of the forecasts."""
        return self.time[-1] + self.dt * np.arange(1, self.ahead + 1)

    @property
    def measured_states(self) -> list[int]:
        """The state that each component measures."""
        return [int(np.argmax(row)) for row in self.model.H]

    def gaps(self, *components: int) -> list[tuple[int, int]]:
        """Runs of steps in which all these are missing: first and last step of each."""
        return runs_of(np.isnan(self.z[:, components]).all(axis=1))


def runs_of(missing: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of each run."""
    edges = np.diff(np.concatenate([[0], missing.astype(int), [0]]))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))


# ---- ranges ----------------------------------------------------------------------------------

# In firmware they are known beforehand (the span of a sensor, the size of a workspace).  Here they
# are the user's --range, or derived from the data:
#
#     measurement   4 times the largest |z|; to that the data's span counts once more for every
#                   stretch as long as the data that is to be forecast, and |x0| and one sigma of
#                   the noise count if they are larger
#     state         measured: as its measurement.  Not measured: what takes a measured state
#                   across its range in one step (a velocity: that range / dt).  Derived ranges
#                   are not below |x0| plus one sigma of P0.
#
# A factor of 4 is two integer bits in reserve: for what the state does where nothing is measured,
# and for measurements to come.  The price is small: of a word's 31 bits 29 are left, and behind a
# state's word the filter keeps 24 more.
MARGIN = 4.0


@dataclass(frozen=True)
class Ranges:
    states: np.ndarray  # n
    measured: np.ndarray  # m


def ranges_of(job: Job) -> Ranges:
    """The declared ranges of a job, in the units of its states and measurements."""
    if job.range is not None:
        measured = np.full(len(job.model.H), job.range)
        return Ranges(state_ranges(job, measured), measured)
    measured = ranges_from_data(job)
    start = np.abs(job.model.x0) + np.sqrt(np.diag(job.model.P0))
    return Ranges(np.maximum(state_ranges(job, measured), start), measured)


def ranges_from_data(job: Job) -> np.ndarray:
    model = job.model
    largest = np.nanmax(np.abs(job.z), axis=0)
    span = np.nanmax(job.z, axis=0) - np.nanmin(job.z, axis=0)
    reach = largest + span * job.ahead / job.steps
    start = np.abs(model.x0[job.measured_states])
    return MARGIN * np.maximum(reach, np.maximum(start, np.sqrt(np.diag(model.R))))


def state_ranges(job: Job, measured: np.ndarray) -> np.ndarray:
    model = job.model
    known = dict(zip(job.measured_states, measured))
    states = range(len(model.x0))
    return np.array([known.get(i) or across_in_a_step(model, i, known) for i in states])


def across_in_a_step(model: Model, i: int, known: dict[int, float]) -> float:
    """The value of state i that takes a measured state across its range in one step."""
    return min(width / abs(model.A[k, i]) for k, width in known.items() if model.A[k, i] != 0)
