"""A compiled filter that is run over data on this machine, as kalmanq.run's filters are: so a simulation is of the
firmware.  Means and covariances are the C's; innovations, NIS and the likelihood are worked out of them in double."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Any, Optional

import numpy as np

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.text.product import Product, compiled
from kalmanq.data.rows import controls_of, whole_steps
from kalmanq.model import Model
from kalmanq.run.resolution import warn_of_coarse
from kalmanq.run.results import Run

NAME = "filter_of"
UNEVEN = "leave --compiled out; --jitter takes steps that are nearly k dt for k dt; --time none takes each row for one"
NO_SMOOTHER = "the emitted filter looks at no later row"


@dataclass(repr=False)
class CompiledRun(Run):
    """emitted: events as NAME.h calls them, and what they mean"""

    emitted: list[tuple[str, str]] = field(default_factory=list)

    @property
    def event_names(self) -> list[str]:
        return [name for name, _ in self.emitted]

    @property
    def faults(self) -> list[tuple[str, str]]:
        return [one for one in self.emitted if one[0] != "gated"]

    @property
    def is_held(self) -> bool:
        return "mean saturated" in self.event_names


def compiled_run(model: Model, arithmetic: str, z: np.ndarray, u: Optional[np.ndarray] = None, times: Optional[np.ndarray] = None) -> CompiledRun:
    """From the start.  The C is built once, for as many runs of a model as come one after the other."""
    made = _built(pickle.dumps((model, arithmetic)))
    made.restart()
    return made.run(z, u, times)


@lru_cache(maxsize=4)
def _built(model_and_arithmetic: bytes) -> CompiledFilter:
    with CompiledFilter(*pickle.loads(model_and_arithmetic)) as made:
        return made  # of a library that is loaded, the folder may go


class CompiledFilter:
    """A context.  run(z, u, times) goes on where the one before ended; forecast(k) comes after all rows."""

    made = CompiledRun

    def __init__(self, model: Model, arithmetic: str, product: Optional[Product] = None):
        self.model, self.arithmetic = model, arithmetic
        self.product = product or compiled(model, NAME, Options(arithmetic))
        self.restart()

    def restart(self) -> None:
        of = self.product.given.of.doubles()
        self.mean, self.covariance = np.array(of.x0), np.array(of.P0)
        self.begins, self.left = True, self._rest()  # the last row's control moves the state to the next
        self.at: Optional[float] = None  # the last row's time
        self.events, self.digest, self.coarse = 0, 0, ""
        self._ahead: list[Ahead] = []

    def __enter__(self) -> CompiledFilter:
        self.host = Host(self.product).__enter__()
        return self

    def __exit__(self, *given: object) -> None:
        self.host.__exit__(*given)

    @property
    def sigma(self) -> np.ndarray:
        return np.sqrt(np.diag(self.covariance).clip(0))

    @property
    def event_names(self) -> list[str]:
        """As NAME.h calls them"""
        return [name for name, _ in self._told(self.events)]

    def _told(self, events: int) -> list[tuple[str, str]]:
        return [(name.lower().replace("_", " "), meaning)
                for bit, (name, meaning) in enumerate(self.product.events.items()) if events >> bit & 1]

    def run(self, z: np.ndarray, u: Optional[np.ndarray] = None, times: Optional[np.ndarray] = None, **_: Any) -> CompiledRun:
        """u: row t moves the state from row t to row t + 1; times: where k steps of dt are between rows, it predicts k times"""
        steps = None if times is None else whole_steps(self.model, np.append([] if self.at is None else self.at, times), "--compiled", UNEVEN)
        if steps is not None and len(times):
            self.at = float(times[-1])
            if np.any(steps > 1):
                return self._run_over_gaps(np.append(np.ones(len(times) - len(steps), int), steps), z, u)
        return self._run(z, u)

    def _run_over_gaps(self, steps: np.ndarray, z: np.ndarray, u: Optional[np.ndarray]) -> CompiledRun:
        """steps: to each row.  Rows without measurements are between, in which controls stay as they are"""
        at, z = np.cumsum(steps) - 1, np.asarray(z, float).reshape(len(steps), -1)
        known = np.full((at[-1] + 1, z.shape[1]), np.nan)
        known[at] = z
        if u is not None:
            before = np.searchsorted(at, np.arange(len(known)), "right")  # how many rows there have been
            u = np.vstack([self.left, controls_of(u, self.model, len(z))])[before]
        made = self._run(known, u)
        return replace(made, **{one.name: value[at] for one in fields(made) if isinstance(value := getattr(made, one.name), np.ndarray)})

    def _run(self, z: np.ndarray, u: Optional[np.ndarray]) -> CompiledRun:
        ran = self._ran(z, u)
        events = int(np.bitwise_or.reduce(ran.events, initial=0))
        sigma = np.sqrt(np.diagonal(ran.covariance, axis1=1, axis2=2).clip(0))
        run = self.made(self.model, self.arithmetic, ran.mean, sigma, ran.covariance, emitted=self._told(events))
        self._explain(run, np.asarray(z, float).reshape(len(ran.mean), -1), u, ran)
        self.events |= events
        if self.arithmetic != "q31" or isinstance(self.model, Model):
            warn_of_coarse(self, self.arithmetic, np.asarray(z, float).reshape(len(ran.mean), -1))
        if len(run):
            self.begins, self.mean, self.covariance = False, ran.mean[-1], ran.covariance[-1]
            self.left = self.left if u is None else controls_of(u, self.model, len(run))[-1]
        return run

    def _rest(self) -> np.ndarray:
        """Without controls"""
        made = controls_of(None, self.model, 1)
        return np.zeros(self.model.l) if made is None else made[0]

    def _ran(self, z: np.ndarray, u: Optional[np.ndarray]) -> Ran:
        controls = self._carried(u, len(z))
        ran = self.host.run(z, controls, goes_on=not self.begins)
        self.digest = ran.digest
        return ran

    def _carried(self, u: Optional[np.ndarray], rows: int) -> np.ndarray:
        """Of the step that leads to each row"""
        given = controls_of(None if u is None else np.asarray(u, float).reshape(rows, -1), self.model, rows)
        given = np.zeros((rows, self.model.l)) if given is None else given
        return np.vstack([self.left[None], given[:-1]]) if rows else given

    def _explain(self, run: Run, z: np.ndarray, u: Optional[np.ndarray], ran: Ran) -> None:
        model, of = self.model, self.product.given.of.doubles()
        x = np.vstack([self.mean[None], ran.mean[:-1]]) @ of.A.T + self._carried(u, len(z)) @ of.B.T
        P = of.A @ np.concatenate([self.covariance[None], ran.covariance[:-1]]) @ of.A.T + of.Q
        if self.begins:
            x[0], P[0] = self.mean, self.covariance
        S = model.H @ P @ model.H.T + model.R
        scored(run, z - x @ model.H.T - (0.0 if model.d is None else model.d), S, ran)

    def forecast(self, steps: int, u: Optional[np.ndarray] = None) -> Ahead:
        """So many rows ahead without measurements; u: steps x l.  No row can be run after it."""
        while len(self._ahead) < steps:
            self.left = self._rest() if u is None else controls_of(u[len(self._ahead)][None], self.model, 1)[0]
            ran = self._ran(np.full((1, self.model.m), np.nan), None)
            self.begins = False
            self._ahead.append(Ahead(ran.mean[-1], ran.covariance[-1]))
        return self._ahead[steps - 1]


def scored(run: Run, innovation: np.ndarray, S: np.ndarray, ran: Ran) -> None:
    """NIS and likelihood of what the filter took, from innovations and their covariances"""
    count, m = innovation.shape
    run.innovation, run.innovation_sigma = innovation, np.sqrt(np.diagonal(S, axis1=1, axis2=2))
    run.taken, run.nis = (ran.taken[:, None] >> np.arange(m) & 1).sum(axis=1), np.full(count, np.nan)
    run.log_likelihood = np.zeros(count)
    for pattern in np.unique(ran.taken[ran.taken > 0]):
        some, rows = np.flatnonzero(pattern >> np.arange(m) & 1), ran.taken == pattern
        spread, e = S[np.ix_(np.flatnonzero(rows), some, some)], innovation[np.ix_(np.flatnonzero(rows), some)]
        run.nis[rows] = np.einsum("ti,ti->t", e, np.linalg.solve(spread, e[:, :, None])[:, :, 0])
        run.log_likelihood[rows] = -(run.nis[rows] + np.linalg.slogdet(spread)[1] + len(some) * np.log(2 * np.pi)) / 2


class Ahead:
    def __init__(self, mean: np.ndarray, covariance: np.ndarray):
        self.mean, self.covariance, self.sigma = mean, covariance, np.sqrt(np.diag(covariance).clip(0))
