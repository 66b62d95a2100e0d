"""The user's functions: what they answer is checked, and what they raise is told in one line with its place."""

from __future__ import annotations

import inspect
from typing import Any, Callable, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError

OF_ROW = ("x", "t", "u")  # a function may take fewer of the last ones
STEP = "dt"  # one more argument, by its name, of functions of a step
OF_STEP = ("f", "increment", "A", "Q", "G")


class Instant(float):
    """When a row is, in seconds.  dt: of the step that leaves it; None: of none that is known"""

    dt: Optional[float]

    def __new__(cls, time: float, dt: Optional[float] = None) -> Instant:
        made = super().__new__(cls, time)
        made.dt = None if dt is None else float(dt)
        return made


class UserError(KalmanqError):
    """FILE: line N: what a function of the user did."""


class Given:
    """A function of the numbers that `names` says, or of fewer of the last ones; of a step, of dt by its name, too.  After x
    they are by name where all are named so: f(x, u).  dt: of rows without times"""

    def __init__(self, name: str, function: Callable[..., Any], names: Sequence[str] = OF_ROW):
        if not callable(function):
            raise UserError(f"{name}: is {type(function).__name__}, not a function")
        self.name, self.function, self.names = name, function, tuple(names)
        code = getattr(function, "__code__", None)
        self.file: Optional[str] = getattr(code, "co_filename", None)
        self.line: Optional[int] = getattr(code, "co_firstlineno", None)
        self.dt: Optional[float] = None
        self.has_own_step = False  # dt with a default: the file's own
        self.takes = self._arguments()

    def _arguments(self) -> list[str]:
        """Names of what it is given, in its own order"""
        names = list(self.names)
        try:
            parameters = inspect.signature(self.function).parameters.values()
        except (TypeError, ValueError):
            return names
        if any(one.kind == inspect.Parameter.VAR_POSITIONAL for one in parameters):
            return names
        kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        may_step = "t" in names
        given = [one for one in parameters if one.kind in kinds]
        self.has_own_step = any(may_step and one.name == STEP and not is_needed(one) for one in given)
        plain = [one for one in given if one.name != STEP or not may_step]
        takes_step = len(plain) < len(given) and not self.has_own_step
        least = names.index("x") + 1 if "x" in names else 1
        filled, rest = plain[: len(names)], plain[len(names) :]
        if len(filled) < least or any(map(is_needed, rest)):
            step = f", and {STEP} by its name" if self.name in OF_STEP else ""
            raise self.error(f"its arguments are {', '.join(names)}, or fewer of the last ones{step}")
        more = [one.name for one in filled[least:]]
        meant = [*names[:least], *(more if set(more) <= set(names[least:]) else names[least:])]
        for one, name in zip(filled, meant):
            if not is_needed(one) and one.name != name:
                raise self.error(f"{one.name} has a default, but is in the place of {name}: give it another place")
        if takes_step and self.name not in OF_STEP:
            raise self.error(f"takes {STEP}, which is of a step: {', '.join(OF_STEP[:-1])} and {OF_STEP[-1]} may take it")
        by_name = {one.name: name for one, name in zip(filled, meant)}
        by_name.update({STEP: STEP} if takes_step else {})
        if self.has_own_step and STEP in [one.name for one in given[: len(by_name)]]:
            raise self.error(f"{STEP} has a default, but is before others: give it the last place")
        return [by_name[one.name] for one in given if one.name in by_name]

    def arguments(self, *values: Any, dt: Any = None) -> list[Any]:
        """Of values of its `names`, what it takes.  dt: in the place of the step's"""
        by_name = dict(zip(self.names, values))
        if STEP in self.takes:
            by_name[STEP] = self.step(by_name["t"]) if dt is None else dt
        return [by_name[name] for name in self.takes]

    def step(self, t: Any) -> float:
        dt = getattr(t, "dt", None)
        if dt is None and self.dt is None:
            raise self.step_error()
        return self.dt if dt is None else dt

    def step_error(self) -> UserError:
        return self.error(f"takes {STEP}, but the rows have no times, and the model has no {STEP} = ... (seconds from row to row)")

    def error(self, reason: str) -> UserError:
        place = [] if self.file is None else [f"{self.file}: line {self.line}"]
        return UserError(": ".join([*place, self.name, reason]))

    def raw(self, *arguments: Any) -> np.ndarray:
        """What it answers, as an array of real or complex numbers of any shape."""
        given = [one.copy() if isinstance(one, np.ndarray) else float(one) if isinstance(one, Instant) else one
                 for one in self.arguments(*arguments)]
        try:
            answer = self.function(*given)
        except (Exception, SystemExit) as problem:
            raise UserError(told(self.name, problem, self.file) + self.lengths(problem, given)) from problem
        try:
            array = np.asarray(answer if not np.ma.isMaskedArray(answer) else answer.filled(np.nan))
            if answer is None or array.dtype.kind not in "biufcO":
                raise ValueError
            return array if array.dtype.kind == "c" else array.astype(np.float64)
        except Exception:  # of an object's own __array__, too
            raise self.error(f"answers {type(answer).__name__}, no array of numbers") from None

    def lengths(self, problem: Exception, given: Sequence[Any]) -> str:
        """Of an index beyond its arguments: how many numbers each has"""
        if not isinstance(problem, IndexError):
            return ""
        sizes = [f"{name} has {one.size} number{'s' * (one.size != 1)}" if one.size else "no controls are declared"
                 for name, one in zip(self.takes, given) if isinstance(one, np.ndarray)]
        return f" ({', '.join(sizes)})" if sizes else ""

    def numbers(self, shape: tuple[int, ...], *arguments: Any) -> np.ndarray:
        """What it answers: real numbers of this shape; where that is of one row or of one number, it may be flat."""
        made = self.raw(*arguments)
        if made.dtype.kind == "c":
            if np.any(made.imag != 0):
                raise self.error("answers complex numbers")
            made = made.real
        return self.shaped(made, shape)

    def shaped(self, made: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        if made.shape == shape:
            return made
        if made.size == np.prod(shape) and (made.size == 1 or made.ndim < 2 and 1 in shape):
            return made.reshape(shape)
        wanted = " x ".join(map(str, shape))
        found = " x ".join(map(str, made.shape)) if made.ndim else "a number"
        raise self.error(f"answers {found}, not {wanted}")

    def finite(self, made: np.ndarray, names: list[list[str]], x: np.ndarray) -> np.ndarray:
        """Refuses what is not finite, by the names along each axis."""
        wrong = np.argwhere(~np.isfinite(made))
        if len(wrong):
            entry = ", ".join(of[k] for of, k in zip(names, wrong[0]))
            at = ", ".join(f"{value:g}" for value in x)
            raise self.error(f"answers {made[tuple(wrong[0])]:g} for {entry} at x = ({at})")
        return made


class Stacked:
    """h, or H, of several sensors, one after the other.  parts: of each sensor its name, its function and how many numbers, or
    rows, that answers"""

    def __init__(self, parts: Sequence[tuple[str, Given, int]]):
        self.parts = parts
        self.error, self.finite = parts[0][1].error, parts[0][1].finite

    def numbers(self, shape: tuple[int, ...], *arguments: Any) -> np.ndarray:
        return np.concatenate([of.numbers((m, *shape[1:]), *arguments) for _, of, m in self.parts])


def told(name: str, problem: BaseException, file: Optional[str]) -> str:
    """Of an exception in a function of the user: where in his file, and why"""
    line, trace = None, problem.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    place = [] if file is None else [file] if line is None else [f"{file}: line {line}"]
    reason = " ".join(str(problem).split())
    if isinstance(problem, SystemExit):
        return ": ".join([*place, name, f"ends the program ({reason})" if reason else "ends the program"])
    return ": ".join([*place, name, type(problem).__name__ + (f": {reason}" if reason else "")])


def is_needed(one: inspect.Parameter) -> bool:
    """Has it no default?"""
    return one.default is inspect.Parameter.empty
