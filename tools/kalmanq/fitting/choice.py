"""What is free, in which form, and what of it is held."""

from __future__ import annotations

import re
from typing import Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.errors import KalmanqError
from kalmanq.fitting.equations import Equations
from kalmanq.fitting.expectation import FORMS, FREE
from kalmanq.fitting.flow import Flow, FlowExpectation
from kalmanq.fitting.noise import Noise
from kalmanq.fitting.of_columns import held_cells
from kalmanq.model import ColumnModel, Model
from kalmanq.model.builders import searched
from kalmanq.nonlinear import NonlinearModel


def require_units(model: Model, free: Sequence[str], held: Mapping[str, np.ndarray]) -> None:
    """H and Q free, and nothing of H held: states in other units would do as well (em.h, KQ_NOT_IDENTIFIED)."""
    if "H" in free and {"Q", "Qc"} & set(free) and not np.any(held.get("H", False) & (model.H != 0)):
        raise KalmanqError("H and Q are not determined by data, but for H^2 Q: leave one of them out of --free, or "
                           "hold an entry of H that is not 0")


def _apart(model: Model, held: Mapping[str, ArrayLike]) -> Mapping[str, ArrayLike]:
    """Noises of one sensor stay those of none other, as its file has them"""
    sizes = model.sensor_sizes
    own = np.repeat(np.arange(len(sizes)), sizes)
    between = (own[:, None] != own) & (model.R == 0) if len(sizes) > 1 else np.zeros(model.R.shape, bool)
    given = np.asarray(held.get("R", np.zeros(model.R.shape, bool)), bool)
    return {**held, "R": between | given} if np.any(between) and given.shape == between.shape else held


class Choice:
    """What is free, in which form, and which entries are held.

    held       of A (n x n), H (m x n), Q (n x n), R (m x m), by name: where true the entry stays as it is
    equations  of a nonlinear model, whose constants may be free, too
    flow       of a model in continuous time, where rows are at irregular times or what is free is of it: Q is of Qc then
    """

    def __init__(self, model: Union[Model, NonlinearModel], free: Sequence[str], Q_form: str, R_form: str,
                 held: Optional[Mapping[str, ArrayLike]], at_times: bool = False):
        self.forms = {"Q": Q_form, "R": R_form, "P0": "full"}
        if not free:
            raise KalmanqError("nothing is free: name what is to be estimated, such as Q and R")
        for form in (Q_form, R_form):
            if form not in FORMS:
                raise KalmanqError(f"{form!r} is no form: {', '.join(FORMS)}")
        held = held_cells(model, free, held)
        self.equations = Equations(model, free) if isinstance(model, NonlinearModel) else None
        of_time = {"F", "Qc", *searched(model.builder)} if getattr(model, "continuous", None) else set()
        is_of_time = at_times or any(name.partition("[")[0] in of_time for name in free)
        self.flow = Flow(model, free) if is_of_time and not self.equations else None
        special = self.equations or self.flow
        self.free = special.free if special else tuple(name for name in FREE if name in free)
        self.constants = self.equations.traced.symbols if self.equations else self.flow.labels if self.flow else ()
        for name in free if not special else ():
            if name not in FREE:
                cure = " (an offset that is not known is a state that stays, without noise and with P0 unknown)" if name in ("c", "d") else ""
                raise KalmanqError(f"{name} is no parameter: {', '.join([*FREE, *sorted(of_time)])}{cure}")
        if self.flow and self.constants and (held or (Q_form, R_form) != ("full", "full")):
            raise KalmanqError("parameters of a builder are free each by itself: leave out --hold, --q-form and --r-form, and name those "
                               "that are free, such as noise[0]")
        held = {"Q" if name == "Qc" else name: mask for name, mask in (held or {}).items()}
        if isinstance(model, Model) and "R" in self.free and R_form == "full" and not self.constants:
            held = _apart(model, held)
        for name in ("Q", "R"):
            self._require_form(model, name)
        if self.equations:
            self.held = {name: self._mask(model, name, mask) for name, mask in (held or {}).items()}
            return
        for name in ("x0", "P0"):
            if name in self.free and np.any(model.unknown):
                raise KalmanqError(f"{name} cannot be free where P0 is unknown: leave it out, or give P0")
        self.held = {name: self._mask(model, name, mask) for name, mask in (held or {}).items()}
        self._require_units(model)
        self._require_units_of_coupled(model)

    def _require_form(self, model: Model, name: str) -> None:
        """A form that is asked for is kept from the beginning: the model has to have it."""
        if name not in self.free or (name == "Q" and not self.flow and self.noise(model).axes is None):  # a form of the Q' of G Q' G'
            return
        value, form, option = self._array(model, name), self.forms[name], f"--{name.lower()}-form"
        off = np.argwhere(np.tril(value, -1) != 0)
        if form == "diagonal" and len(off):
            i, j = map(int, off[0])
            raise KalmanqError(f"{name} of the model is not diagonal, {name}[{i},{j}] is {value[i, j]:g}, and {option} "
                               f"diagonal begins from it: take {option} multiple (one size for all of {name}) or full, or "
                               f"write a diagonal {name} into the model file")

    def named(self, said: str) -> str:
        """With Q called what it is"""
        return re.sub(r"\bQ\b", "Qc", said) if self.flow else said

    def noise(self, model: Model) -> Noise:
        return Noise(self._array(model, "Q"), None if self.flow else model.G)

    def _array(self, model: Model, name: str) -> np.ndarray:
        """As it is called here: of a flow Q is Qc"""
        if self.flow and name in "FQ":
            return getattr(model.continuous, {"Q": "Qc"}.get(name, name))
        made = getattr(model.plain if isinstance(model, ColumnModel) else model, name)
        return getattr(model.frame, name) if made is None else made  # of a function

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
        if name not in ("A", "H", "Q", "R", "F") or name not in self.free:
            raise KalmanqError(f"held: {name} is not one of the free {'F, Qc' if self.flow else 'A, H, Q'}, R")
        mask = np.asarray(given, bool)
        if mask.shape != self._array(model, name).shape:
            raise KalmanqError(f"held: {name} has {self._array(model, name).shape} entries, not {mask.shape}")
        if np.all(mask):
            raise KalmanqError(f"held: all of {name} is fixed; leave it out of the free ones")
        return mask | mask.T if name in ("Q", "R") else mask

    def require_em(self, model: Union[Model, NonlinearModel]) -> None:
        if self.equations or isinstance(model, ColumnModel):
            raise KalmanqError(f"a {'nonlinear model' if self.equations else 'model with numbers from columns'} has no EM: take maximum likelihood (ml)")
        if self.flow and set(self.free) - {"Q", "R"}:
            raise KalmanqError(f"EM of a model in continuous time estimates Qc and R, not {self.free[0]}: take maximum likelihood (ml)")
        if self.flow and not self.held and not self.is_for_em(model):
            raise KalmanqError("EM has no best Qc, given the states, where steps differ and several noises make each: take maximum "
                               "likelihood (ml), or --q-form multiple")
        if not self.is_for_em(model):
            raise KalmanqError("EM holds no entries of Q and R, nor the noises of several sensors apart: take maximum likelihood (ml), or "
                               "--r-form diagonal")

    def is_for_em(self, model: Model) -> bool:
        """The M-step knows no held entries of covariances."""
        if self.flow and (set(self.free) - {"Q", "R"} or "Q" in self.free and not FlowExpectation.has_em(model, self.noise(model), self.forms["Q"])):
            return False
        return self.equations is None and not isinstance(model, ColumnModel) and not {"Q", "R"} & set(self.held)
