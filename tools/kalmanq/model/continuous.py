"""x' = F x + B u + noise, made a step of dt: exactly, with the noise of all the step and controls that stay as they are.

By series over dt / 2^k and doubling: Q of twice the step is Q + A Q A', a sum without a difference (Van Loan 1978 says the
same in one matrix).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np

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
        doublings = np.maximum(0, np.ceil(np.log2(np.maximum(self.norm * dt / SHORT, 1)))).astype(int)
        with np.errstate(over="ignore", invalid="ignore"):
            A, Q, S = self._series(np.ldexp(dt, -doublings)[:, None, None])
            for k in range(doublings.max(initial=0)):
                left = doublings > k
                a, q, s = A[left], Q[left], S[left]
                Q[left], S[left], A[left] = q + a @ q @ a.swapaxes(1, 2), s + a @ s, a @ a
        return A, (Q + Q.swapaxes(1, 2)) / 2, None if self.B is None else S @ self.B

    @property
    def norm(self) -> float:
        """Of F; 0: a power of F is 0, and the series ends"""
        return 0.0 if self.ends else float(np.abs(self.F).sum(axis=1).max())

    @property
    def ends(self) -> bool:
        """Is a power of F 0?  By its entries that are not 0, not by their values"""
        pattern = (self.F != 0).astype(int)
        return not np.any(np.linalg.matrix_power(pattern, len(pattern)))

    def _series(self, h: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """e^(F h), its noise, and the integral of e^(F s)"""
        power, noise = np.eye(len(self.F)) + 0 * h, self.Qc * h
        A, Q, S = power.copy(), noise.copy(), power * h
        for k in range(1, TERMS + len(self.F)):
            power = self.F @ power * (h / k)
            noise = (self.F @ noise + noise @ self.F.T) * (h / (k + 1))
            if not (power.any() or noise.any()):
                break
            A, Q, S = A + power, Q + noise, S + power * (h / (k + 1))
        return A, Q, S
