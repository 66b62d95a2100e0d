"""The physical ranges that fixed point asks for: of every state and every measurement.

In firmware they are known beforehand (the span of a sensor, the size of a workspace).  Here
they are the user's --range, or derived from the data:

    measurement   4 times the largest |z|; to that the data's span counts once more for every
                  stretch as long as the data that is to be forecast, and |x0| and one sigma of
                  the noise count if they are larger
    state         measured: as its measurement.  Not measured: what takes a measured state
                  across its range in one step (a velocity: that range / dt).  Derived ranges
                  are not below |x0| plus one sigma of P0.

A factor of 4 is two integer bits in reserve: for what the state does where nothing is measured,
and for measurements to come.  The price is small: of a word's 31 bits 29 are left, and behind a
state's word the filter keeps 24 more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from job import Job
from models import Model

MARGIN = 4.0


@dataclass(frozen=True)
class Ranges:
    states: np.ndarray  # n
    measured: np.ndarray  # m


def of(job: Job) -> Ranges:
    """The declared ranges of a job, in the units of its states and measurements."""
    if job.range is not None:
        measured = np.full(len(job.model.H), job.range)
        return Ranges(of_states(job, measured), measured)
    measured = from_data(job)
    start = np.abs(job.model.x0) + np.sqrt(np.diag(job.model.P0))
    return Ranges(np.maximum(of_states(job, measured), start), measured)


def from_data(job: Job) -> np.ndarray:
    model = job.model
    largest = np.nanmax(np.abs(job.z), axis=0)
    span = np.nanmax(job.z, axis=0) - np.nanmin(job.z, axis=0)
    reach = largest + span * job.ahead / job.steps
    start = np.abs(model.x0[job.measured_states])
    return MARGIN * np.maximum(reach, np.maximum(start, np.sqrt(np.diag(model.R))))


def of_states(job: Job, measured: np.ndarray) -> np.ndarray:
    model = job.model
    known = dict(zip(job.measured_states, measured))
    states = range(len(model.x0))
    return np.array([known.get(i) or across_in_a_step(model, i, known) for i in states])


def across_in_a_step(model: Model, i: int, known: dict[int, float]) -> float:
    """The value of state i that takes a measured state across its range in one step."""
    return min(width / abs(model.A[k, i]) for k, width in known.items() if model.A[k, i] != 0)
