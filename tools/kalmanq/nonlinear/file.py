"""Nonlinear model files: Python programs of functions and arrays, executed as they are.

    x0, P0, Q (or G), R                     arrays; Q, G and R may be functions of x, t, u
    dt                                      seconds of a row, where rows have no times: of functions that take dt, f(x, t, u, dt)
    f(x, t, u) or increment(x, t, u); h(x, t, u)
    sensors = {name: (h, R), ...}           in the place of h and R, where there are several
    delays = {name: how late, ...}          of sensors: in seconds where a function takes t or dt, otherwise in rows
    nominal, plus(x, d), minus(a, b)        where the states are errors of nominal numbers
    A(x, t, u), H(x, t, u), innovation(z, x, t, u), simulated_controls(t)     if there are any
    states, measurements, controls          lists of names, or as in a model file: {"names": [...], "units": [...],
                                            "ranges": [...], "fractions": [...], "columns": [...], ...}
    angles, name, recording                 recording: a dictionary, as the section of a model file
    free                                    names of constants of the file, and of Q, R, x0 and P0, that `kalmanq fit` estimates
"""

from __future__ import annotations

import ast
import copyreg
import difflib
import re
import sys
import types
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional, Sequence, Union

import numpy as np

from kalmanq.errors import ModelError
from kalmanq.formulas.functions import NoFormula
from kalmanq.model import Quantity
from kalmanq.model.model_file import ModelFileError, known
from kalmanq.model.quantities import quantities, recording
from kalmanq.nonlinear.calls import UserError, told
from kalmanq.nonlinear.constants import PUT, Free, Numbers, Symbols, placed, written
from kalmanq.nonlinear.model import NonlinearModel

ARRAYS = ("x0", "P0", "Q", "G", "R")
FUNCTIONS = ("f", "h", "increment", "innovation", "A", "H", "plus", "minus", "simulated_controls")
SECTIONS = ("states", "nominal", "measurements", "controls")
SUFFIX = ".py"


@lru_cache(maxsize=8)
def read_again(path: Path) -> NonlinearModel:
    """Once a process"""
    return read(path)


def _as_its_file(model: NonlinearModel) -> tuple:
    """A model goes to another process as its file: its functions are of no module."""
    if model.path is None:
        raise TypeError("a nonlinear model that is of no file stays in its process")
    return read_again, (model.path,)


copyreg.pickle(NonlinearModel, _as_its_file)


def read(path: Path, constants: Optional[Numbers] = None) -> NonlinearModel:
    """Executes the file.  constants: other numbers of it"""
    model = _model(Path(path), source_of(Path(path)), constants)
    model.path = Path(path) if constants is None else None  # another process would read the file's own
    return model


def read_text(path: Path, text: str) -> NonlinearModel:
    """The model of a text in the place of the file's"""
    return _model(Path(path), text.encode("utf-8"))


def _model(path: Path, source: bytes, constants: Optional[Numbers] = None) -> NonlinearModel:
    key = ""
    try:
        space = executed(path, source, constants)
        _refuse_near(space)
        made = {key: space[key] for key in (*ARRAYS, *FUNCTIONS, "dt") if key in space}
        if isinstance(space.get("sensors"), dict):
            made["sensors"] = space["sensors"]
        if isinstance(space.get("delays"), dict):
            made["delays"] = space["delays"]
        for key in ("x0", "P0", *(() if "sensors" in made else ("R",))):
            if key not in made:
                raise ModelError(key, "is missing")
        for key in SECTIONS:
            if key in space:
                made[key] = _quantities(key, space[key])
        model = NonlinearModel(**made, angles=_list("angles", space.get("angles", ()), "measurements"), name=_name(space, path))
        if isinstance(space.get("recording"), dict):
            key = "recording"
            known(key, space[key])
            model.recording = recording(space[key])
        model.free = tuple(_list("free", space.get("free", ()), "constants of the file, or of Q, R, x0, P0"))
        return model
    except ModelError as problem:
        line = _line(source, problem.key)
        raise ModelFileError(f"{path}: {f'line {line}: ' if line else ''}{problem}") from None
    except UserError as problem:
        raise problem if str(problem).startswith(str(path)) else ModelFileError(f"{path}: {problem}") from None


def free_of(model: NonlinearModel, names: Sequence[str]) -> Free:
    """Its formulas with symbols for constants of its file"""
    if names and model.path is None:
        raise ModelError(names[0], "is free: only a model file has constants; a model of functions has Q, R, x0 and P0")
    path = Path(model.path or "")
    try:
        return Free(model, names, lambda symbols: executed(path, source_of(path), symbols))
    except ModelError as problem:
        line = _line(source_of(path), problem.key) if names else 0
        raise ModelFileError(f"{path}: {f'line {line}: ' if line else ''}{problem}") from None


def fitted_text(path: Path, model: NonlinearModel, free: Sequence[str]) -> str:
    """The file with the constants that `model` was estimated with, and Q, R, x0 and P0 where they were free"""
    numbers, source = Numbers([one for one in free if one not in ARRAYS], model.constants), source_of(path)
    _model(path, source, numbers)
    text = written(source.decode("utf-8"), {**numbers.made, **{one: getattr(model, one) for one in ARRAYS if one in free}})
    again = _model(path, text.encode("utf-8"))
    for key in ("x0", "P0", "Q", "R"):
        if not np.allclose(getattr(again.frame, key), getattr(model.frame, key), 1e-9, 0):  # functions as at the start
            raise ModelFileError(f"{path}: {key} of the fitted file would not be what was estimated: give it, and the constants "
                                 "that are free, in assignments of their own")
    return text


def source_of(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise ModelFileError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise ModelFileError(f"{path}: is a folder: give the model file in it") from None


def executed(path: Path, source: bytes, constants: Union[Numbers, Symbols, None] = None) -> dict[str, Any]:
    """What the file defines.  Its own folder is where it imports from; nothing is written beside it."""
    module = types.ModuleType(f"kalmanq_model_{path.stem}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module  # dataclasses look there
    folder = str(path.resolve().parent)
    sys.path.insert(0, folder)
    writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        tree = compile(source, str(path), "exec", ast.PyCF_ONLY_AST)
        if constants is not None:
            tree = placed(tree, constants.names)
            module.__dict__.update({PUT: constants, **({"__builtins__": constants.builtins} if isinstance(constants, Symbols) else {})})
        exec(compile(tree, str(path), "exec"), module.__dict__)
    except (ModelError, ModelFileError):
        raise
    except (Exception, SystemExit) as problem:
        if isinstance(problem, SyntaxError) and problem.lineno and problem.filename == str(path):
            raise ModelFileError(f"{path}: line {problem.lineno}: {problem.msg}") from None
        cure = f" ({', '.join(constants.names)} free, so what is made of it is a formula: NumPy and math take it; or leave it out of --free)" \
            if isinstance(constants, Symbols) else ""
        raise ModelFileError(_told(problem, path) + cure) from problem
    finally:
        if folder in sys.path:
            sys.path.remove(folder)
        sys.dont_write_bytecode = writes
    return module.__dict__


def _told(problem: BaseException, path: Path) -> str:
    if not isinstance(problem, NoFormula):
        return told("the file", problem, str(path))
    line = next((line for file, line in problem.places if file == str(path)), 0)
    return f"{path}: {f'line {line}: ' if line else ''}{problem}"


def _refuse_near(space: dict[str, Any]) -> None:
    """A misspelt name would be left out without a word: `angle` for `angles`, `inovation` for `innovation`."""
    for wanted, is_function in (*((key, False) for key in (*SECTIONS, "angles")),
                               *((key, True) for key in ("increment", "innovation", "simulated_controls"))):
        if wanted in space:
            continue
        kind = types.FunctionType if is_function else (list, tuple, dict)
        names = [name for name, value in space.items() if isinstance(value, kind) and not name.startswith("_")]
        for near in difflib.get_close_matches(wanted, names, 1, 0.85):
            raise ModelError(near, f"means nothing to kalmanq; {wanted}?  Otherwise begin its name with _")


def _quantities(key: str, given: Any) -> list[Quantity]:
    if isinstance(given, dict):
        known(key, given)
        if not isinstance(given.get("names"), list):
            raise ModelError(key, "names is not a list of texts")
        return quantities(key, given, len(given["names"]), None)
    if not isinstance(given, (list, tuple)) or not all(isinstance(one, (str, Quantity)) for one in given):
        raise ModelError(key, 'is not a list of names, nor {"names": [...], "units": [...], "ranges": [...]}')
    return [one if isinstance(one, Quantity) else Quantity(one) for one in given]


def _list(key: str, given: Any, of: str) -> Any:
    if isinstance(given, (str, int)) or not isinstance(given, (list, tuple)):
        raise ModelError(key, f"is a list of names of {of}")
    return given


def _name(space: dict[str, Any], path: Path) -> str:
    name = space.get("name", Path(path).stem)
    if not isinstance(name, str):
        raise ModelError("name", "is not a text")
    return name


def _line(source: bytes, key: str) -> int:
    """Of KEY = ... or def KEY(...); 0: none."""
    found = 0
    for number, line in enumerate(source.decode("utf-8", "replace").splitlines(), 1):
        if re.match(rf"(def\s+)?{re.escape(key)}\b\s*[=(:,]", line):
            found = number
    return found
