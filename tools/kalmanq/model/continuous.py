"""x' = F x + B u + noise, made a step of dt: exactly, with the noise of all the step and controls that stay as they are.

By series over dt / 2^k and doubling: Q of twice the step is Q + A Q A', a sum without a difference (Van Loan 1978 says the
same in one matrix).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from kalmanq.core import lib, pointer_of

UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "day": 86400.0, "week": 604800.0, "year": 31556952.0}  # in seconds
TERMS = 20  # of the series, over a step in which F counts for half at most
SHORT = 0.5


@dataclass(frozen=True)
class Continuous:
    """F: n x n; Qc: n x n, spectral density of the noise; B: n x l, or None; dt: of a row
    jitter: share of dt by which a step may be off from a multiple of it, and is taken for that; unit: of all its times"""

    F: np.ndarray
    Qc: np.ndarray
    B: Optional[np.ndarray]
    dt: float
    jitter: float = 0.0
    unit: str = "s"

    @property
    def seconds(self) -> float:
        """Of its unit of time"""
        return UNITS[self.unit]

    def between(self, times: np.ndarray) -> np.ndarray:
        """From each time to the next one.  What is a multiple of dt but for jitter and the rounding of times is just that;
        others are as good as times are, so that what is one step has one number"""
        made, rounding = np.diff(times), 4 * np.spacing(np.maximum.accumulate(np.abs(times))[1:])
        whole = np.maximum(np.round(made / self.dt), 1) * self.dt
        known = np.round(made / rounding) * rounding
        return np.where(np.abs(made - whole) <= self.jitter * self.dt + rounding, whole, np.where(known > 0, known, made))

    def step(self, dt: float) -> tuple[np.ndarray, np.ndarray, Optional[np.ndarray]]:
        """A, Q and B over dt"""
        A, Q, B = self.steps(np.array([dt]))
        return A[0], Q[0], None if B is None else B[0]

    def steps(self, dt: np.ndarray) -> tuple[np.ndarray, np.ndarray, Optional[np.ndarray]]:
        """Over each dt: k x n x n, k x n x n and k x n x l"""
        A, Q, S = (np.empty((len(dt), *self.F.shape)) for _ in range(3))
        self._through(lib.kq_steps, dt, A, Q, S)
        return A, Q, None if self.B is None else S @ self.B

    def slopes(self, dt: np.ndarray, by_A: np.ndarray, by_Q: np.ndarray, by_B: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """To F and Qc, of what has such slopes to the steps over each dt; by_Q is symmetric"""
        by_S = np.zeros_like(by_A) if self.B is None else by_B @ self.B.T
        made = np.zeros_like(self.F), np.zeros_like(self.F)
        self._through(lib.kq_steps_back, dt, by_A, by_Q, by_S, *made)
        return made

    def _through(self, call: Any, dt: np.ndarray, *arrays: np.ndarray) -> None:
        """C over dt / 2^k and k doublings"""
        doublings = np.maximum(0, np.ceil(np.log2(np.maximum(self.norm * dt / SHORT, 1)))).astype(np.int64)
        n, terms = len(self.F), TERMS + len(self.F) - 1
        work = np.empty(lib.kq_steps_work(n, terms, int(doublings.max(initial=0))))
        given = [np.ascontiguousarray(one, float) for one in (self.F, self.Qc, np.ldexp(dt, -doublings))]
        call(len(dt), n, terms, *map(pointer_of, given), pointer_of(doublings), *map(pointer_of, arrays), pointer_of(work))

    @property
    def norm(self) -> float:
        """Of F; 0: a power of F is 0, and the series ends"""
        return 0.0 if self.ends else float(np.abs(self.F).sum(axis=1).max())

    @property
    def ends(self) -> bool:
        """Is a power of F 0?  By its entries that are not 0, not by their values"""
        pattern = (self.F != 0).astype(int)
        return not np.any(np.linalg.matrix_power(pattern, len(pattern)))
