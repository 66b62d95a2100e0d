"""One file: page.html with its style, its scripts, the library in WebAssembly and what it is of."""

from __future__ import annotations

import base64
import gzip
import json
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report.costs import costs_of, reasons
from kalmanq.compiler.text.product import compiled
from kalmanq.errors import KalmanqError
from kalmanq.firmware.costs import CORES
from kalmanq.model import Model
from kalmanq.nonlinear import NonlinearModel
from kalmanq.run.filters import Filter
from kalmanq.run.robust import LOSSES, bits_of
from kalmanq.tune import emitted, equations
from kalmanq.tune.noises import Shape, has_dt, noises_of
from kalmanq.tune.packing import losses, noise_content, packed, quantities

HERE = Path(__file__).resolve().parent
CORE = HERE / "core.wasm"
STEPS_MOST = 1000  # steps of other lengths than dt, which have a process each
NUMBERS_MOST = 40_000_000  # that the page's memory has to hold


def core() -> bytes:
    if not CORE.exists():
        raise KalmanqError("tune: this installation is without WebAssembly: install clang and lld (apt install clang lld), and "
                           "then kalmanq again")
    return CORE.read_bytes()


def require(model: Union[Model, NonlinearModel]) -> None:
    """What a page of the model is made by"""
    if isinstance(model, NonlinearModel):
        emitted.tools()
    else:
        core()


def page(model: Union[Model, NonlinearModel], z: np.ndarray, u: Optional[np.ndarray], times: Optional[np.ndarray], sources: dict[str, Any]) -> str:
    """sources: names of the files that it is of"""
    refuse(model, z, u)
    given, module = equations.content(model, z, u, times, sources) if isinstance(model, NonlinearModel) else \
        ({**content(model, z, u, times, sources), **costs(model)}, core())
    wasm = base64.b64encode(gzip.compress(module, 9, mtime=0)).decode()
    pieces = {"STYLE": _file("page.css"), "ENGINE": _file("engine.js"), "EM": _file("em.js"), "EQUATIONS": _file("equations.js"), "WORKER": _file("worker.js"),
              "CHARTS": _file("charts.js"), "PAGE": _file("page.js"), "CORE": wasm, "CONTENT": for_script(given), "SETTINGS": "null"}
    made = _file("page.html")
    for name, text in pieces.items():
        before, mark, after = made.partition(f"/*{name}*/")
        if not mark:
            raise KalmanqError(f"page.html has no place for {name}")
        made = before + text + after
    return made


def _file(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def for_script(given: Any) -> str:
    """JSON that ends no <script>, whatever names are in it"""
    made = json.dumps(given, ensure_ascii=False, allow_nan=False)
    return made.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


# ------------------------------------------------------------------------------ what it is of


def content(model: Model, z: np.ndarray, u: Optional[np.ndarray], times: Optional[np.ndarray], sources: dict[str, Any]) -> dict[str, Any]:
    dt, which = steps_of(model, times)
    shape = Shape(dt)
    noises, rest, template = noises_of(model, shape)
    arrays = shape.arrays(model)
    filter_ = Filter(model)
    filter_.run(z, u, times=times)
    return {
        "name": model.name, "sources": sources, "n": model.n, "m": model.m, "l": model.l, "rows": len(z),
        "states": quantities(model.states), "measurements": quantities(model.measurements), "controls": quantities(model.controls),
        "processes": len(arrays["A"]), "factor": 0 if model.G is None else model.G.shape[1],
        "unknown": sum(1 << int(i) for i in np.flatnonzero(model.unknown)), "sensors": bits_of(model.sensor_sizes),
        **{name: packed(arrays[name]) for name in ("A", "B", "Q", "G", "H", "R", "x0", "P0", "d")},
        "rest": {name: packed(rest[name]) for name in ("Q", "R", "P0")},
        "z": packed(z), "u": packed(_with_ones(model, u, len(z))), "which": packed(which), "times": packed(times),
        "unit": model.continuous.unit if model.continuous and times is not None else "",
        "flow": flow(model, rest["Qc"]) if has_dt(model, shape) else None,
        "noises": [noise_content(one) for one in noises], "template": template, "total": filter_.log_likelihood,
        "losses": losses(LOSSES, in_sigma=False), "cores": CORES}


def refuse(model: Union[Model, NonlinearModel], z: np.ndarray, u: Optional[np.ndarray]) -> None:
    if model.inputs and (u is None or np.any(np.isnan(u))):
        row = 0 if u is None else int(np.argmax(np.any(np.isnan(u), axis=1)))
        raise KalmanqError(f"row {row}: a control is missing: give all controls, or leave B out of the model")
    need = len(z) * (10 * model.n + (model.n + 5) * model.n + 8 * model.m)
    if need > NUMBERS_MOST:
        most = NUMBERS_MOST * len(z) // need
        raise KalmanqError(f"{len(z)} rows of {model.n} states: a page holds {most}: give fewer rows")


def steps_of(model: Model, times: Optional[np.ndarray]) -> tuple[Optional[np.ndarray], Optional[np.ndarray]]:
    """dt of each process, the model's own first, and which one is before each row"""
    if times is None or model.continuous is None:
        return None, None
    own, between = model.continuous.dt, model.continuous.between(times)
    others = np.setdiff1d(between, [own])
    if len(others) > STEPS_MOST:
        raise KalmanqError(f"{len(others)} steps of other lengths than dt = {own:g}; a page has at most {STEPS_MOST}: give --jitter, or "
                           "--time none, which takes each row for a step of dt")
    dt = np.concatenate([[own], others])
    order = np.argsort(dt)
    return dt, np.concatenate([[0], order[np.searchsorted(dt[order], between)]]).astype(float)


def flow(model: Model, rest: np.ndarray) -> dict[str, Any]:
    """By which the page makes a step of another dt"""
    of = model.continuous
    return {"F": packed(of.F), "B": packed(of.B), "dt": of.dt, "unit": of.unit, "rest": packed(rest)}


def _with_ones(model: Model, u: Optional[np.ndarray], rows: int) -> Optional[np.ndarray]:
    """Rows x l: the control of an offset is 1"""
    if not model.l:
        return None
    given = np.zeros((rows, 0)) if u is None else np.reshape(u, (rows, -1))
    return np.hstack([given, np.ones((rows, model.l - given.shape[1]))])


def costs(model: Model) -> dict[str, Any]:
    """Of the C that `kalmanq compile` writes, by core and arithmetic: instructions of a row in two calls, bytes of flash, RAM and stack,
    and instructions once it has settled; and why there are none"""
    made: dict[str, dict[str, dict[str, list[Optional[int]]]]] = {}
    why_not: list[str] = []
    for arithmetic in ("f32", "q31"):
        try:
            product = compiled(model, "filter", Options(arithmetic))
        except KalmanqError as problem:
            why_not.append(f"{arithmetic}: {problem}.")
            continue
        found = costs_of(product)
        why_not += reasons(found)
        for core_, of in ((core_, one.of) for core_, one in found.items() if one.of):
            rows = {"compiled": [of["two_calls"], of["program"], product.ram_delayed or product.ram, of["stack"]], "settled": [of["two_calls_settled"]]}
            made.setdefault(core_, {})[arithmetic] = {name: row for name, row in rows.items() if row[0] is not None}
    return {"costs": made, "no_costs": " ".join(dict.fromkeys(why_not))}
