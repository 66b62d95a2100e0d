"""What other libraries call it: answers to calls that are likely and wrong, in a sentence."""

from __future__ import annotations

import difflib
import inspect
import os
from functools import wraps
from typing import TYPE_CHECKING, Any, Callable, Iterable, TypeVar, cast

Call = TypeVar("Call", bound=Callable[..., Any])

_HERE = {  # what it is called here, and what filterpy, pykalman, statsmodels and textbooks call it
    "A": "F Phi transition transition_matrix transition_matrices",
    "H": "C Z design observation_matrix observation_matrices measurement_matrix",
    "R": "V obs_cov observation_covariance measurement_noise", "Q": "W state_cov transition_covariance process_noise",
    "G": "Gamma selection", "B": "control_matrix", "D": "feedthrough", "c": "transition_offsets state_intercept", "d": "observation_offsets obs_intercept",
    "x0": "x m0 initial_state initial_state_mean", "P0": "P initial_state_cov initial_state_covariance",
    "f": "fx", "h": "hx", "z": "y zs data endog observations", "u": "us exog", "times": "t time timestamps",
    "mean": "x x_post state filtered_state filtered_state_means states means", "covariance": "P P_post filtered_state_cov covariances",
    "smoothed": "smoothed_state smoothed_state_means", "log_likelihood": "llf loglike loglikelihood", "innovation": "y residual",
    "gain()": "K", "measurement()": "S", "run(z)": "filter batch_filter", "forecast(steps)": "get_forecast",
}
_SIZES = dict.fromkeys("dim_x dim_z dim_u k_states k_endog n_dim_state n_dim_obs".split(), "is not given: the matrices have the sizes")
_MODEL = "is of the model: kalmanq.Model(A, H=..., R=..., Q=..., x0=..., P0=...)"
_MATRICES = {"A", "H", "R", "Q", "G", "B", "D", "c", "d", "x0", "P0"}
_IN_VAIN = _MATRICES | {foreign for here in _MATRICES for foreign in _HERE[here].split()} | {*_SIZES}  # of what has a model
_OF_STEPS = {"F": "is A here; of x' = F x take Model.of_continuous(F, H=..., R=..., Qc=..., dt=...)",
             **dict.fromkeys(("Qc", "dt"), "is of continuous time: Model.of_continuous(F, H=..., R=..., Qc=..., dt=...)")}
_OTHERS = {"smooth": "is kalmanq.Smoother(model).run(z)", "rts_smoother": "is kalmanq.Smoother(model).run(z)", "em": "is kalmanq.fit(model, [z])",
           "fit": "is kalmanq.fit(model, [z])"}
_OF_RUN = "mean sigma covariance innovation smoothed smoothed_sigma lagged instant settled scales weights".split()
CLASSES = {"KalmanFilter": "Filter(kalmanq.Model(A, H=..., R=..., Q=...))", "KalmanSmoother": "Smoother(model)",
           **dict.fromkeys(("ExtendedKalmanFilter", "UnscentedKalmanFilter", "EKF", "UKF"), "NonlinearFilter(kalmanq.NonlinearModel(f, h, ...))"),
           "UnobservedComponents": "level(...), kalmanq.trend(...), kalmanq.trend_season(...)"}


def spelled(said: str) -> Callable[[Call], Call]:
    """Of a call, `said` in messages: names that it does not have, and what is missing"""
    def of(call: Call) -> Call:
        every = inspect.signature(call).parameters
        needed = [name for name, one in every.items() if one.default is one.empty and one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]
        takes_any = any(one.kind is one.VAR_KEYWORD for one in every.values())

        @wraps(call)
        def named(*given: Any, **more: Any) -> Any:
            for name in more:
                if name not in every and not takes_any:
                    raise TypeError(f"{said}: {name} {cure(name, [*every][1:])}")
            absent = [name for name in needed[len(given):] if name not in more]
            if absent:
                raise TypeError(f"{said}: {', '.join(absent)} {'is' if len(absent) == 1 else 'are'} missing")
            return call(*given, **more)
        return cast(Call, named)
    return of


def cure(name: str, known: Iterable[str]) -> str:
    """Of a name that a call does not have: which one it has"""
    known = list(known)
    here = [one for one, names in _HERE.items() if name == one or name in names.split()]
    if name in _SIZES:
        return _SIZES[name]
    if "model" in known and _MATRICES & set(here):
        return _MODEL
    if "A" in known and name in _OF_STEPS:
        return _OF_STEPS[name]
    near = [one for one in here if one in known] or difflib.get_close_matches(name, known, 1)
    return f"is {near[0]} here" if here and near else f"is no name here: {near[0]}?" if near else f"is no name here: {', '.join(known)}"


def require_model(given: Any, kind: type, cure: str) -> None:
    """Of what is in a model's place: a `kind`, or a sentence"""
    if isinstance(given, kind):
        return
    if isinstance(given, (str, os.PathLike)):
        cure = "kalmanq.model.model_file.read(path) reads a model file" if kind.__name__ == "Model" else "kalmanq.nonlinear.file.read(path) reads a model file"
    elif not hasattr(given, "states"):
        cure = f"make one first, kalmanq.{kind.__name__}(...), and give the data to run(z)"
    raise TypeError(f"model is {_article(type(given).__name__)}, not a {kind.__name__}: {cure}")


def _article(word: str) -> str:
    return f"{'an' if word[0].lower() in 'aeiou' else 'a'} {word}"


class Spelled:
    """An object that says what names of other libraries are here"""

    if not TYPE_CHECKING:  # which knows what there is
        def __getattr__(self, name: str) -> Any:
            said = _said(type(self), name)
            raise AttributeError(f"{type(self).__name__} has no {name!r}{f': it {said}' if said else ''}")


class _Elsewhere:
    """In a class, in the place of __getattr__, which would cost each reading: a name of other libraries"""

    def __init__(self, name: str):
        self.name = name

    def __get__(self, one: Any, kind: type) -> Any:
        raise AttributeError(f"{kind.__name__} has no {self.name!r}: it {_said(kind, self.name) or 'is no name here'}")


class _InVain(_Elsewhere):
    """A matrix that would be left out of account, and numbers be wrong"""

    def __set__(self, one: Any, value: Any) -> None:
        raise AttributeError(f"{type(one).__name__}: {self.name} {_MODEL}, or model.changed(Q=...)")


def _own(names: Iterable[str], kind: type) -> list[str]:
    """Those that are not of other libraries, or that the class has itself"""
    return [name for name in names if name not in vars(OfModel) or name.startswith("__") or any(name in vars(one) for one in kind.__mro__ if one is not OfModel)]


class _Quiet(type):
    """Of a class whose help and completion leave these names out"""

    def __dir__(cls) -> list[str]:
        return _own(super().__dir__(), cls)


class OfModel(metaclass=_Quiet):
    """A filter or smoother, which says what names of other libraries are here, read or set"""

    def __dir__(self) -> list[str]:
        return _own(super().__dir__(), type(self))


_OF_CALLS = ("f", "h", "z", "u", "times")
for _name in {*(" ".join(names for here, names in _HERE.items() if here not in _OF_CALLS)).split(), *_MATRICES, *_SIZES, *_OTHERS, *_OF_RUN}:
    setattr(OfModel, _name, (_InVain if _name in _IN_VAIN else _Elsewhere)(_name))


def _said(kind: type, name: str) -> str:
    has = {*dir(kind), *getattr(kind, "__dataclass_fields__", ())}
    here = [one for one, names in _HERE.items() if name in names.split() and one.split("(")[0] in has]
    if here:
        return f"is {here[0]} here"
    if name in _OTHERS:
        return _OTHERS[name]
    if name in _OF_RUN:
        return f"is what a run answers: run(z).{name}"
    matrix = [one for one, names in _HERE.items() if one in _MATRICES and name in (one, *names.split())]
    return f"is model.{matrix[0]}" if matrix else ""
