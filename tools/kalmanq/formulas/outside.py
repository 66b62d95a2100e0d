"""What a function reaches beside its arguments: its module, the modules beside that, what it has closed over, and all that is
in them.  While it is traced stand-ins are there; afterwards everything is as it was."""

from __future__ import annotations

import site
import sys
import sysconfig
import types
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Optional

import numpy as np

from kalmanq.formulas.graph import Node
from kalmanq.formulas.stand_ins import BUILTINS, stand_in_of

INSTALLED = [Path(path).resolve() for path in {*sysconfig.get_paths().values(), *site.getsitepackages(), site.getusersitepackages(),
                                               *(path for path in sys.path if path.endswith("-packages")),
                                               Path(__file__).parents[1]}]  # this package, too: it may be anywhere
_EMPTY = object()  # of a cell


class Outside:
    """files: the user's own, by the names that tracebacks have"""

    def __init__(self, function: Callable[..., Any]):
        self.folder: Optional[Path] = None
        self.files: set[str] = set()
        self.spaces: list[dict[str, Any]] = []  # names of modules
        self.before: dict[int, tuple[Any, Any]] = {}  # what can change, and what is in it
        first = _code_of(function)
        if first is not None:
            self.folder = _folder(first.__globals__)
            self.files.add(first.__code__.co_filename)
            self._space(first.__globals__)
        self._walk(function)

    def _walk(self, first: Any) -> None:
        waiting, seen = [first, *self.spaces], set()
        while waiting:
            one = waiting.pop()
            if id(one) in seen or isinstance(one, (Node, str, bytes, int, float, complex)):
                continue
            seen.add(id(one))
            parts = [*self._parts(one)]
            contents = _contents(one)
            if contents is not None and (not isinstance(one, type) or self._is_own(one)):
                self.before[id(one)] = one, contents
            waiting += parts

    def _parts(self, one: Any) -> Iterable[Any]:
        """What may lead further"""
        if isinstance(one, types.ModuleType):
            return [vars(one)] if self._space(vars(one)) else []
        if isinstance(one, types.FunctionType):
            own = [one.__globals__, one.__defaults__, one.__kwdefaults__, vars(one)] if self._space(one.__globals__) else []
            return [*own, *(one.__closure__ or ())]  # a decorator may be of another's
        if isinstance(one, types.MethodType):
            return [one.__func__, one.__self__]
        if isinstance(one, partial):
            return [one.func, one.args, one.keywords]
        if isinstance(one, types.CellType):
            return [_cell(one)]
        if isinstance(one, (staticmethod, classmethod)):
            return [one.__func__]
        if isinstance(one, property):
            return [one.fget]
        if isinstance(one, dict):
            is_space = any(one is space for space in self.spaces)
            return [found for name, found in one.items() if not (is_space and name.startswith("__"))]
        if isinstance(one, (list, tuple, set)):
            return one
        inside = vars(one) if hasattr(one, "__dict__") else {}
        wrapped = [one.__wrapped__] if "__wrapped__" in inside else []
        return [*inside.values(), type(one)] if self._is_own(one) else wrapped

    def _is_own(self, one: Any) -> bool:
        """A class of the user's modules, or an object of one"""
        modules = {getattr(of, "__module__", None) for of in (one, type(one))}
        return any(space.get("__name__") in modules for space in self.spaces)

    def _space(self, names: dict[str, Any]) -> bool:
        """Of the user: the first module, and those in its folder and below"""
        if any(names is one for one in self.spaces):
            return True
        file = names.get("__file__")
        path = Path(file).resolve() if isinstance(file, str) else None
        is_own = path is not None and self.folder is not None and self.folder in path.parents and not any(
            one in path.parents for one in INSTALLED)
        if not is_own and self.spaces:
            return False
        self.spaces.append(names)
        self.files |= {file} if isinstance(file, str) else set()
        return True

    @contextmanager
    def standing_in(self) -> Iterator[None]:
        for space in self.spaces:
            for name, one in list(space.items()):
                other = one if name.startswith("__") else stand_in_of(one)
                if other is not one:
                    space[name] = other
            for name, other in BUILTINS.items():
                space.setdefault(name, other)
        try:
            yield
        finally:
            for one, contents in self.before.values():
                _restore(one, contents)

    def kept(self) -> str:
        """The name or kind of what has kept a formula; "": nothing"""
        for one, was in self.before.values():
            for key, found in _entries(_contents(one)):
                if found is not dict(_entries(was)).get(key) and _has_formula(found):
                    what = getattr(one, "__name__", type(one).__name__)
                    return key if isinstance(one, dict) else f"{what}.{key}" if isinstance(key, str) else f"something in a {what}"
        return ""


def _entries(contents: Any) -> Iterable[tuple[Any, Any]]:
    if isinstance(contents, np.ndarray):
        contents = contents.ravel() if contents.dtype == object else []
    return contents.items() if isinstance(contents, dict) else enumerate(contents)


def _code_of(function: Any) -> Optional[types.FunctionType]:
    """The function of Python's that is run"""
    for _ in range(16):
        if isinstance(function, types.FunctionType) and not hasattr(function, "__wrapped__"):
            return function
        inner = getattr(function, "__wrapped__", getattr(function, "__func__", getattr(function, "func", None)))
        function = inner if inner is not None else getattr(type(function), "__call__", None)
    return None


def _folder(space: dict[str, Any]) -> Optional[Path]:
    file = space.get("__file__")
    return Path(file).resolve().parent if isinstance(file, str) else None


def _cell(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        return _EMPTY


def _contents(one: Any) -> Any:
    """A copy; None: it cannot change, or is not the user's"""
    if isinstance(one, (dict, list, set)):
        return one.copy()
    if isinstance(one, types.CellType):
        return [_cell(one)]
    if isinstance(one, np.ndarray):
        return one.copy()
    return dict(vars(one)) if hasattr(one, "__dict__") and not isinstance(one, (types.ModuleType, types.FunctionType)) else None


def _restore(one: Any, contents: Any) -> None:
    if isinstance(one, (dict, set)):
        one.clear()
        one.update(contents)
    elif isinstance(one, list):
        one[:] = contents
    elif isinstance(one, types.CellType):
        if contents[0] is not _EMPTY:
            one.cell_contents = contents[0]
    elif isinstance(one, np.ndarray):
        if one.flags.writeable:
            one[...] = contents
    else:
        for name in [name for name in vars(one) if name not in contents]:
            delattr(one, name)
        for name, value in contents.items():
            if vars(one).get(name, _EMPTY) is not value:
                setattr(one, name, value)


def _has_formula(one: Any) -> bool:
    if isinstance(one, Node):
        return not one.is_constant
    if isinstance(one, dict):
        return any(map(_has_formula, one.values()))
    if isinstance(one, np.ndarray):
        return one.dtype == object and any(map(_has_formula, one.view(np.ndarray).flat))
    return isinstance(one, (list, tuple, set)) and any(map(_has_formula, one))
