"""What is free, in which form, and what of it is held."""

from __future__ import annotations

from typing import Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.errors import KalmanqError
from kalmanq.fitting.equations import Equations
from kalmanq.fitting.expectation import FORMS, FREE
from kalmanq.fitting.noise import Noise
from kalmanq.model import Model
from kalmanq.nonlinear import NonlinearModel


def require_units(model: Model, free: Sequence[str], held: Mapping[str, np.ndarray]) -> None:
    """H and Q free, and nothing of H held: states in other units would do as well (em.h, KQ_NOT_IDENTIFIED)."""
    if {"H", "Q"} <= set(free) and not np.any(held.get("H", False) & (model.H != 0)):
        raise KalmanqError("H and Q are not determined by data, but for H^2 Q: leave one of them out of --free, or "
                           "hold an entry of H that is not 0")


class Choice:
    """What is free, in which form, and which entries are held.

    held       of A (n x n), H (m x n), Q (n x n), R (m x m), by name: where true the entry stays as it is
    equations  of a nonlinear model, whose constants may be free, too
    """

    def __init__(self, model: Union[Model, NonlinearModel], free: Sequence[str], Q_form: str, R_form: str,
                 held: Optional[Mapping[str, ArrayLike]]):
        self.forms = {"Q": Q_form, "R": R_form, "P0": "full"}
        if not free:
            raise KalmanqError("nothing is free")
        for form in (Q_form, R_form):
            if form not in FORMS:
                raise KalmanqError(f"{form!r} is no form: {', '.join(FORMS)}")
        self.equations = Equations(model, free) if isinstance(model, NonlinearModel) else None
        self.free = self.equations.free if self.equations else tuple(name for name in FREE if name in free)
        for name in free if not self.equations else ():
            if name not in FREE:
                raise KalmanqError(f"{name} is no parameter: {', '.join(FREE)}")
        for name in ("Q", "R"):
            self._require_form(model, name)
        if self.equations:
            self.held = {name: self._mask(model, name, mask) for name, mask in (held or {}).items()}
            return
        for name in ("x0", "P0"):
            if name in free and np.any(model.unknown):
                raise KalmanqError(f"{name} cannot be free where P0 is unknown")
        self.held = {name: self._mask(model, name, mask) for name, mask in (held or {}).items()}
        self._require_units(model)
        self._require_units_of_coupled(model)

    def _require_form(self, model: Model, name: str) -> None:
        """A form that is asked for is kept from the beginning: the model has to have it."""
        if name not in self.free or (name == "Q" and Noise(model).axes is None):  # a form of the Q' of G Q' G'
            return
        value, form, option = getattr(model, name), self.forms[name], f"--{name.lower()}-form"
        off = np.argwhere(np.tril(value, -1) != 0)
        if form == "diagonal" and len(off):
            i, j = map(int, off[0])
            raise KalmanqError(f"{name} of the model is not diagonal, {name}[{i},{j}] is {value[i, j]:g}, and {option} "
                               f"diagonal begins from it: take {option} multiple (one size for all of {name}) or full, or "
                               f"write a diagonal {name} into the model file")

    def _require_units(self, model: Model) -> None:
        """The density of what determines an unknown state has its unit, so it would rise as H goes to 0."""
        held = self.held.get("H", np.zeros(model.H.shape, bool))
        for i in np.flatnonzero(model.unknown) if "H" in self.free else ():
            if not np.all(held[:, i]) and not np.any(held[:, i] & (model.H[:, i] != 0)):
                raise KalmanqError(f"H cannot be free where P0 of {model.states[i].name} is unknown: hold an entry "
                                   f"of H[*,{i}] that is not 0, or give P0")

    def _require_units_of_coupled(self, model: Model) -> None:
        """The same of a state that is seen through others alone, with all of A that couples it free."""
        held = self.held.get("A", np.zeros(model.A.shape, bool))
        for i in np.flatnonzero(model.unknown) if "A" in self.free else ():
            coupling = np.zeros(model.A.shape, bool)
            coupling[:, i] = coupling[i] = True
            coupling[i, i] = False
            fixed = np.any(model.A[coupling & held] != 0) or np.any(model.H[:, i] != 0)
            if not fixed and np.any(coupling & ~held):
                raise KalmanqError(f"A cannot be free where P0 of {model.states[i].name} is unknown and nothing else "
                                   f"has its unit: hold an entry of A[*,{i}] that is not 0, or give P0")

    def _mask(self, model: Model, name: str, given: ArrayLike) -> np.ndarray:
        if name not in ("A", "H", "Q", "R") or name not in self.free:
            raise KalmanqError(f"held: {name} is not one of the free A, H, Q, R")
        mask = np.asarray(given, bool)
        if mask.shape != getattr(model, name).shape:
            raise KalmanqError(f"held: {name} has {getattr(model, name).shape} entries, not {mask.shape}")
        if np.all(mask):
            raise KalmanqError(f"held: all of {name} is held; leave it out of the free ones")
        return mask | mask.T if name in ("Q", "R") else mask

    def require_em(self) -> None:
        if self.equations:
            raise KalmanqError("a nonlinear model has no EM: take maximum likelihood (ml)")
        if not self.is_for_em:
            raise KalmanqError("EM holds no entries of Q and R: maximum likelihood (ml) does")

    @property
    def is_for_em(self) -> bool:
        """The M-step knows no held entries of covariances."""
        return self.equations is None and not {"Q", "R"} & set(self.held)
