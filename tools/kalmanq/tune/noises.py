"""What of a model can be tuned: sizes of noises, and what of Q, R and P0 each of them makes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Callable, Iterator, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.model import model_file
from kalmanq.model.builders import searched

CLOSE = 1e-9  # of what is a multiple of a size but for rounding
MATRICES = ("Q", "R", "P0", "Qc")


@dataclass
class Noise:
    """key: as `kalmanq fit --free` names it; parts: by matrix what a size of 1 makes of it, of Q for each process;
    power: a size counts so; columns: of G, which go with the root of the size"""

    key: str
    value: float
    parts: dict[str, np.ndarray]
    kind: str = "Q"
    unit: str = ""
    hint: str = ""
    power: int = 1
    columns: list[int] = field(default_factory=list)
    fit: str = ""


@dataclass(frozen=True)
class Shape:
    """A model at the steps of a recording: dt (or None: of steps) of each process"""

    dt: Optional[np.ndarray]

    def arrays(self, model: Model) -> dict[str, Any]:
        A, Q, B = (one[None] if one is not None else None for one in (model.A, model.Q, model.B))
        if self.dt is not None and len(self.dt) > 1:
            A_, Q_, B_ = model.continuous.steps(self.dt[1:])
            A, Q = np.concatenate([A, A_]), np.concatenate([Q, Q_])
            B = None if B is None else np.concatenate([B, B_])
        return {"A": A, "Q": Q, "B": B, "R": model.R, "P0": model.P0, "G": model.G, "H": model.H, "x0": model.x0, "d": model.d,
                "Qc": np.zeros((1, 1)) if model.continuous is None else model.continuous.Qc}


def noises_of(model: Model, shape: Shape) -> tuple[list[Noise], dict[str, np.ndarray], list[Any]]:
    """And by matrix what no noise makes; and the model file, its text in pieces: between them what the page puts in, [[size, factor], ...],
    {"root": ...} or {"dt": ...}"""
    made, rest = _measured(_of_builder(model), model, shape) if model.builder else ([], {})
    if not _are_all(made, rest, model, shape):
        made, rest = _measured(_of_entries(model), model, shape)
        model = _without_builder(model)
    if not made:
        raise KalmanqError("all noises are 0: there is nothing to tune; give a Q, G, Qc or R that is not 0")
    return made, rest, _pieces(model, made, has_dt(model, shape))


def has_dt(model: Model, shape: Shape) -> bool:
    """May the time of a row be another?  Where rows have times they say it."""
    return model.continuous is not None and shape.dt is None


def _are_all(made: Sequence[Noise], rest: dict[str, np.ndarray], model: Model, shape: Shape) -> bool:
    """Is the model the sum of its noises?"""
    given = shape.arrays(model)
    return bool(made) and {one.kind for one in made} >= {name for name in ("Q", "R") if np.any(given[name])} and all(np.allclose(
        sum((one.value**one.power * one.parts[name] for one in made if name in one.parts), rest[name]), given[name], rtol=CLOSE, atol=0) for name in MATRICES)


# ------------------------------------------------------------------------------ what may be one

Sizes = dict[str, float]  # by name
Candidates = tuple[Sizes, Callable[[Sizes], Model]]  # and the model with others


def _of_builder(model: Model) -> Candidates:
    sizes: Sizes = {}
    for name, given in model.builder.items():
        if name in ("builder", "P0", "x0", "c", "d", "dt") or isinstance(given, (str, bool)):
            continue
        if isinstance(given, list):
            if all(isinstance(one, (int, float)) for one in given):
                sizes.update({f"{name}[{k}]": float(value) for k, value in enumerate(given)})
        elif isinstance(given, float) or name in searched(model.builder):
            sizes[name] = float(given)
    return sizes, lambda others: model_file.rebuilt(model, _parameters(model, others))


def _parameters(model: Model, sizes: Sizes) -> dict[str, Any]:
    """Of its builder"""
    made = {name: list(one) if isinstance(one, list) else one for name, one in model.builder.items()}
    for key, value in sizes.items():
        name, _, index = key.rstrip("]").partition("[")
        if index:
            made[name][int(index)] = value
        else:
            made[name] = value
    return made


def _of_entries(model: Model) -> Candidates:
    """Columns of G, blocks of Q or Qc, and of R"""
    of = model.continuous
    matrices = {**({} if model.G is not None else {"Qc": of.Qc} if of else {"Q": model.Q}), "R": model.R}
    found = {key: (name, value, part) for name, given in matrices.items() for key, value, part in blocks(name, given)}
    columns = {} if model.G is None else {f"G[*,{c}] x": c for c in range(model.G.shape[1])}

    def changed(sizes: Sizes) -> Model:
        made = {name: given.copy() for name, given in matrices.items()}
        for key in sizes.keys() & found.keys():
            name, value, part = found[key]
            made[name] = made[name] + (sizes[key] - value) * part
        if columns:
            made["G"] = model.G * np.sqrt([sizes.get(key, 1.0) for key in columns])
        return model.flowing(**made) if of else model.changed(**made)

    return {**dict.fromkeys(columns, 1.0), **{key: value for key, (_, value, _) in found.items()}}, changed


def blocks(name: str, given: np.ndarray) -> Iterator[tuple[str, float, np.ndarray]]:
    """Variances that stand alone, and blocks of correlated ones, whose size is a factor"""
    left = {i for i in range(len(given)) if given[i, i] != 0}
    while left:
        block = {min(left)}
        while True:
            more = {j for i in block for j in left if given[i, j] != 0} | block
            if more == block:
                break
            block = more
        left -= block
        at = sorted(block)
        part = np.zeros_like(given)
        if len(at) == 1:
            part[at[0], at[0]] = 1.0
            yield f"{name}[{at[0]},{at[0]}]", float(given[at[0], at[0]]), part
        else:
            part[np.ix_(at, at)] = given[np.ix_(at, at)]
            yield f"{name} x", 1.0, part


# ------------------------------------------------------------------------------ what is one


def _measured(candidates: Candidates, model: Model, shape: Shape) -> tuple[list[Noise], dict[str, np.ndarray]]:
    """And what no noise makes.  A part is made as the package makes the model with this noise alone: a difference of two models would
    be no covariance where a step is short"""
    sizes, changed = candidates
    found = [_noise(key, value, lambda size, key=key: changed({key: size}), shape) for key, value in sizes.items() if value > 0]
    made = [one for one in found if one]
    none = {one.key: 0.0 for one in made}
    rest = shape.arrays(changed(none))
    for one in made:
        alone = shape.arrays(changed({**none, one.key: one.value}))
        parts = {name: (alone[name] - rest[name]) / one.value**one.power for name in MATRICES}
        one.parts = {name: part for name, part in parts.items() if np.any(part)}
    for one in made:
        _describe(one, model, made)
    return made, {name: rest[name] for name in MATRICES}


def _noise(key: str, value: float, changed: Callable[[float], Model], shape: Shape) -> Optional[Noise]:
    """Without its parts.  None: it is of more than noises, or no power of it makes them"""
    try:
        _, one, two, four = (shape.arrays(changed(factor * value)) for factor in (0, 1, 2, 4))
    except KalmanqError:
        return None
    if any(not _same(one[name], four[name]) for name in ("A", "B", "H", "x0", "d")):
        return None
    for power in (1, 2):
        gains = {name: (four[name] - one[name]) / (4**power - 1) for name in MATRICES}
        if all(np.allclose(two[name], one[name] + (2**power - 1) * gains[name], rtol=CLOSE, atol=0) for name in MATRICES):
            columns = [] if one["G"] is None else _columns(one["G"], four["G"], power)
            if columns is None or not (np.any(gains["Q"]) or np.any(gains["R"])):
                return None
            return Noise(key, value, {}, "R" if np.any(gains["R"]) else "Q", power=power, columns=columns)
    return None


def _same(a: Optional[np.ndarray], b: Optional[np.ndarray]) -> bool:
    return a is b is None or (a is not None and b is not None and np.array_equal(a, b))


def _columns(one: np.ndarray, four: np.ndarray, power: int) -> Optional[list[int]]:
    moved = [c for c in range(one.shape[1]) if not np.array_equal(one[:, c], four[:, c])]
    return moved if all(np.allclose(four[:, c], 2**power * one[:, c], rtol=CLOSE) for c in moved) else None


def _describe(one: Noise, model: Model, noises: Sequence[Noise]) -> None:
    """Its unit, whose noise it is, and how `kalmanq fit` calls it"""
    name = "Qc" if one.key.startswith("Qc") else one.kind
    of, part = model.continuous, one.parts.get(name, np.zeros((1, model.n, model.n)))
    at = np.flatnonzero(np.diag(part if part.ndim == 2 else part[0]))
    whose = [(model.measurements if one.kind == "R" else model.states)[i] for i in at]
    one.hint = ", ".join(quantity.name for quantity in whose)
    entry = one.key.partition("[")[0] in ("Q", "R", "Qc")
    if len(whose) == 1 and whose[0].unit and (entry or one.kind == "R" or (of is None and one.power == 1)) and " x" not in one.key:
        one.unit = squared(whose[0].unit)
        one.unit += f"/{of.unit}" if one.key.startswith("Qc") and of else ""
    if one.key.partition("[")[0] in searched(model.builder):
        one.fit = one.key
    elif " x" in one.key and not one.columns:
        one.fit = one.key[:-2] if sum(other.key.startswith(one.key[:-2]) for other in noises) == 1 else ""
    elif entry:
        one.fit = one.key
    elif of is None and len(at) == 1:
        one.fit = f"{one.kind}[{at[0]},{at[0]}]"


# ------------------------------------------------------------------------------ the model file, in pieces


def _without_builder(model: Model) -> Model:
    if not model.builder:
        return model
    made = model.changed()
    made.builder = None
    return made


def marker() -> tuple[dict[str, Any], Callable[[Any], float]]:
    """What marks stand for, by their text; and a function that makes one: a number that no model has"""
    marks: dict[str, Any] = {}

    def marked(what: Any) -> float:
        value = float(f"7.{len(marks):05d}1e-250")
        marks[repr(value)] = what
        return value

    return marks, marked


def squared(unit: str) -> str:
    return f"({unit})²" if " " in unit or "/" in unit else f"{unit}²"


def _pieces(model: Model, noises: Sequence[Noise], with_dt: bool) -> list[Any]:
    marks, marked = marker()
    made = _with_marks(model, noises, marked)
    if with_dt and made.builder:
        made.builder["dt"] = marked({"dt": 1})
    elif with_dt:
        made.continuous = replace(made.continuous, dt=marked({"dt": 1}))
    return split(model_file.text_of(made), marks)


def split(text: str, marks: dict[str, Any]) -> list[Any]:
    """marks: what stands for which number of the text"""
    pieces: list[Any] = []
    at = 0
    for found in sorted((text.index(mark, begin), mark) for mark in marks for begin in _begins(text, mark)):
        pieces += [text[at : found[0]], marks[found[1]]]
        at = found[0] + len(found[1])
    return [*pieces, text[at:]]


def _begins(text: str, mark: str) -> Iterator[int]:
    at = text.find(mark)
    while at >= 0:
        yield at
        at = text.find(mark, at + 1)


def _with_marks(model: Model, noises: Sequence[Noise], marked: Callable[[Any], float]) -> Model:
    if model.builder and all(one.key.partition("[")[0] in model.builder for one in noises):
        made = model.changed()
        made.builder = _parameters(model, {one.key: marked([[k, 1.0]]) for k, one in enumerate(noises)})
        return made
    R = _marked_sums(model.R, noises, "R", marked)
    if model.G is not None:
        G = model.G.copy()
        for k, one in enumerate(noises):
            for c in one.columns:
                for i in np.flatnonzero(G[:, c]):
                    G[i, c] = marked({"root": k, "of": float(model.G[i, c])})
        return replace_matrices(model, G=G, R=R)
    if model.continuous is None:
        return replace_matrices(model, Q=_marked_sums(model.Q, noises, "Q", marked), R=R)
    of = model.continuous
    Qc = of.Qc.copy()
    named = {key: part for key, _, part in blocks("Qc", of.Qc)}
    for k, one in enumerate(noises):
        for i, j in np.argwhere(np.triu(named.get(one.key, np.zeros_like(Qc)))):
            Qc[i, j] = Qc[j, i] = marked([[k, float(named[one.key][i, j])]])
    return replace_matrices(model, Qc=Qc, R=R)


def replace_matrices(model: Model, R: np.ndarray, Qc: Optional[np.ndarray] = None, **more: np.ndarray) -> Model:
    if Qc is None:
        return model.changed(R=R, **more)
    made = model.changed(R=R)
    made.continuous = replace(model.continuous, Qc=Qc)
    return made


def _marked_sums(given: np.ndarray, noises: Sequence[Noise], name: str, marked: Callable[[Any], float]) -> np.ndarray:
    made = given.copy()
    for i, j in np.argwhere(np.triu(given)):
        terms = [[k, float(_first(one.parts[name])[i, j])] for k, one in enumerate(noises) if name in one.parts and _first(one.parts[name])[i, j]]
        if terms:
            made[i, j] = made[j, i] = marked(terms)
    return made


def _first(part: np.ndarray) -> np.ndarray:
    return part[0] if part.ndim == 3 else part
