"""Arrays of formulas: what NumPy does with arrays of numbers, it does with these."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable

import numpy as np

from kalmanq.formulas.formula import Formula, as_type
from kalmanq.formulas.functions import CONDITIONAL, NAMED, NoFormula, named, truth, value
from kalmanq.formulas.graph import Node, constant, select

NO_CHOICE = "a selection by a comparison has no fixed length: write np.where(condition, a, b)"


class Array(np.ndarray):
    """Of formulas"""

    def __getitem__(self, key: Any) -> Any:
        if _is_choice(key):
            raise NoFormula(NO_CHOICE)
        return super().__getitem__(key)

    def __setitem__(self, key: Any, given: Any) -> None:
        given = held(given if isinstance(given, Node) else np.array(given, object))
        if not _is_choice(key):
            super().__setitem__(key, given)
        elif np.ndim(given) or np.shape(key) not in ((), self.shape):
            raise NoFormula(NO_CHOICE)
        else:
            self[...] = chosen(key, given, self)

    def astype(self, kind: Any, *rest: Any, **options: Any) -> Any:
        return held(np.frompyfunc(lambda one: as_type(one, kind), 1, 1)(plain(self)))


def _is_choice(key: Any) -> bool:
    return isinstance(key, Node) or isinstance(key, Array) and any(isinstance(one, Node) for one in plain(key).flat)


def plain(one: Any) -> Any:
    """As an array of objects that NumPy takes for nothing else; what is no array and no formula as it is"""
    if isinstance(one, Node):
        box = np.empty((), object)
        box[()] = one
        return box
    if isinstance(one, Array):
        return one.view(np.ndarray)
    return np.array(one, object) if isinstance(one, (list, tuple)) else one


def held(made: Any) -> Any:
    """Floats and formulas as arrays that can hold formulas; an array without dimensions as its number"""
    if type(made) in (list, tuple):
        return type(made)(map(held, made))
    if not isinstance(made, np.ndarray) or made.dtype not in (float, object):
        return made  # what is put into an array of another kind is rounded
    if made.ndim == 0:
        return _entry(made[()])
    if made.dtype.kind == "O" and all(isinstance(one, Node) for one in plain(made).flat):
        return made.view(Array)  # of the same memory
    array = np.empty(made.shape, object)
    array.ravel()[:] = [*map(_entry, plain(made).flat)]
    return array.view(Array)


def _entry(one: Any) -> Any:
    """None: of numpy.empty, nothing was written there"""
    return one if isinstance(one, Node) else constant(np.nan) if one is None else value(one)


def is_constant(given: Any) -> bool:
    """No formula in it but constants?"""
    if isinstance(given, Node):
        return given.is_constant
    if isinstance(given, np.ndarray) and given.dtype == object:
        return all(map(is_constant, plain(given).flat))
    return all(map(is_constant, given)) if isinstance(given, (list, tuple)) else True


def as_numbers(given: Any) -> Any:
    """Of constants"""
    if isinstance(given, np.ndarray) and given.dtype == object:
        return plain(given).astype(float)
    if isinstance(given, (list, tuple)):
        return type(given)(map(as_numbers, given))
    return float(given.value) if isinstance(given, Node) else given


def chosen(condition: Any, yes: Any, no: Any) -> Any:
    """numpy.where"""
    one_by_one = np.frompyfunc(lambda c, a, b: select(truth(c), value(a), value(b)), 3, 1)
    return held(one_by_one(*map(plain, (condition, yes, no))))


def applied(ufunc: Any, method: str, given: Any, options: dict[str, Any]) -> Any:
    """A function of NumPy's, entry by entry"""
    out, name = options.pop("out", None), ufunc.__name__
    options = {key: one for key, one in options.items() if key not in ("dtype", "casting", "order", "subok")}
    whole, first = options.pop("where", True), options.pop("initial", None)
    if method not in ("__call__", "reduce", "accumulate", "outer") or whole is not True or first not in (None, np._NoValue):
        raise NoFormula(f"numpy.{name} of this kind has no formula here")
    given = [plain(one) for one in given]
    if ufunc.signature is not None:  # matmul
        made = held(getattr(ufunc, method)(*given, **options))
    elif ufunc.nout > 1:
        made = _pair(name, *given)
    elif all(set(one) <= set("O->") for one in ufunc.types):  # of numpy.frompyfunc, numpy.vectorize
        made = held(getattr(ufunc, method)(*given, **options))
    else:
        made = _answer(name, _lifted(ufunc, method, options)(*given))
    if out is None:
        return made
    out[0][...] = made
    return out[0]


def _lifted(ufunc: Any, method: str, options: dict[str, Any]) -> Callable[..., Any]:
    def of(*given: Any) -> Any:
        if ufunc.__name__ not in NAMED and all(map(is_constant, given)):
            return constant(ufunc(*map(as_numbers, given)))
        return named(ufunc.__name__, *given)

    lifted = np.frompyfunc(of, ufunc.nin, 1)
    if method == "__call__":
        return lifted
    return partial(_reduced, lifted, ufunc, **options) if method == "reduce" else partial(getattr(lifted, method), **options)


def _reduced(lifted: Any, ufunc: Any, array: Any, axis: Any = 0, keepdims: bool = False) -> Any:
    array = np.asarray(array, object)
    if ufunc.__name__ == "add":
        array = np.frompyfunc(value, 1, 1)(array)
    axes = tuple(range(array.ndim)) if axis is None else np.atleast_1d(axis).tolist()
    for k in sorted((k % max(array.ndim, 1) for k in axes), reverse=True) if np.ndim(array) else ():
        empty = not array.shape[k] and ufunc.identity is not None
        array = np.full(np.delete(array.shape, k), ufunc.identity, object) if empty else lifted.reduce(array, axis=k)
        array = np.expand_dims(array, k) if keepdims else array
    return array


def _pair(name: str, *given: Any) -> Any:
    first, second = {"divmod": ("floor_divide", "remainder"), "modf": ("trunc", "fmod")}.get(name, (name, name))
    if name == "modf":
        whole = np.frompyfunc(NAMED["trunc"], 1, 1)(*given)
        return held(given[0] - whole), held(whole)
    return tuple(held(np.frompyfunc(partial(named, one), len(given), 1)(*given)) for one in (first, second))


def _answer(name: str, made: Any) -> Any:
    """Comparisons of constants are True and False."""
    if name in CONDITIONAL and isinstance(made, np.ndarray) and made.ndim and is_constant(made):
        return made.astype(float).astype(bool)
    return held(made)


OWN: dict[Any, Callable[..., Any]] = {}  # functions of NumPy's that look into an array


def dispatched(function: Any, args: Any, options: dict[str, Any]) -> Any:
    """A function of NumPy's with a formula in its arguments"""
    if function in OWN:
        return held(OWN[function](*args, **options))
    try:
        made = np.ndarray.__array_function__(_NOTHING, function, (Array,), boxed(args), boxed(options))
        is_inner = isinstance(made, np.ndarray) and made.ndim == 0 and not any(isinstance(one, Node) for one in args)
        return made if is_inner else held(made)  # NumPy goes on with its array without dimensions
    except NoFormula:
        raise
    except Exception as problem:
        if is_constant(args) and is_constant(list(options.values())):
            return held(function(*as_numbers(args), **{key: as_numbers(one) for key, one in options.items()}))
        raise NoFormula(f"{function.__module__}.{function.__name__} has no formula here ({problem})") from problem


def _of_ufunc(self: Any, ufunc: Any, method: str, *given: Any, **options: Any) -> Any:
    return applied(ufunc, method, given, options)


def _of_function(self: Any, function: Any, types: Any, args: Any, options: Any) -> Any:
    return dispatched(function, args, options)


for _kind in (Formula, Array):
    setattr(_kind, "__array_ufunc__", _of_ufunc)
    setattr(_kind, "__array_function__", _of_function)
_NOTHING = np.empty(0, object).view(Array)


def boxed(given: Any) -> Any:
    """Formulas as arrays without dimensions"""
    if isinstance(given, (list, tuple)):
        return type(given)(map(boxed, given)) if type(given) in (list, tuple) else given
    if isinstance(given, dict):
        return {key: boxed(one) for key, one in given.items()}
    return plain(given).view(Array) if isinstance(given, Node) else given
