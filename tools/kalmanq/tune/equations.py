"""What a page is of where its model is nonlinear: the emitted C in WebAssembly, the noises that it reads, and what the host found."""

from __future__ import annotations

import base64
import gzip
import json
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.names import WORDS, identifiers
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import equation_report
from kalmanq.compiler.report.costs import costs_of, reasons
from kalmanq.compiler.run.equation_records import drawn
from kalmanq.compiler.run.equation_run import CompiledEquations, EquationRun
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.trial import ROWS, trial
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.errors import KalmanqError
from kalmanq.firmware.costs import CORES
from kalmanq.firmware.steps_kept import MOST_STEPS
from kalmanq.formulas.graph import needed
from kalmanq.formulas.program import Program
from kalmanq.model import Quantity
from kalmanq.nonlinear import NonlinearModel, file as model_file
from kalmanq.run.diagnostics import chi_square_limit
from kalmanq.run.robust import ALONE
from kalmanq.tune import emitted
from kalmanq.tune.emitted import Variant
from kalmanq.tune.equation_noises import noises_of, text_of
from kalmanq.tune.noises import Noise, marker, split
from kalmanq.tune.packing import losses, noise_content, packed, quantities


def content(model: NonlinearModel, z: np.ndarray, u: Optional[np.ndarray], times: Optional[np.ndarray], sources: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    """And the WebAssembly"""
    emitted.tools()
    equation_report.refuse_wrong(model)
    source, noises = model_file.source_of(model.path).decode("utf-8"), noises_of(model)
    begun = [one.value for one in noises]
    name = _name_of(sources["model"])
    # each text of a model that is read again: what a graph has decides which factor stands first
    made = list(emitted.variants(lambda sizes: _with_sizes(model, source, noises, sizes), begun, len(z), name))
    module = emitted.module(model, made)
    run, clock = _on_the_host(model, z, u, times)
    H, d = _plain_rows(model)
    R = model.noises.start.copy()
    for one in noises:
        R = np.where(one.parts["R"] != 0, one.parts["R"], R) if "R" in one.parts and one.key.endswith(" x") and one.value == 1.0 else R
    return {
        "kind": "equations", "name": model.name, "sources": sources, "n": len(model.carried), "states_of_filter": model.n, "m": model.m, "l": model.l,
        "rows": len(z), "states": quantities(model.carried), "measurements": quantities(model.measurements), "controls": quantities(model.controls),
        "H": packed(H), "d": packed(d), "R": packed(R), "rest": {"R": packed(_rest(R, noises))},
        "z": packed(z), "u": packed(np.zeros((len(z), 0)) if u is None else u), "clock": packed(clock), "times": packed(times), "unit": "s" if times is not None else "",
        "step": _step(clock), "flow": None, "noises": [noise_content(one) for one in noises], "template": _template(model, source, noises),
        "smooths": len(z) <= MOST_STEPS, "limits": _limits(model.m), "total": float(np.sum(run.log_likelihood)), "host": _found(run),
        "losses": losses(ALONE, in_sigma=True), "filters": {one.name: _filter(one) for one in made}, "c_name": name, "cores": CORES, **_costs(model, name)}, module


def _name_of(file: str) -> str:
    made = identifiers([Quantity(file.removesuffix(".py"))])[0]
    return f"{made}_filter" if made in WORDS else made


def _filter(one: Variant) -> dict[str, Any]:
    text = {"pieces": one.written.pieces, "literals": [literal.told() for literal in one.written.literals], "header": one.header}
    return {"literals": [literal.told() for literal in one.run.literals], "code": _compressed(text), "events": one.events}


def _compressed(given: Any) -> str:
    return base64.b64encode(gzip.compress(json.dumps(given, ensure_ascii=False).encode(), 9, mtime=0)).decode()


def _with_sizes(model: NonlinearModel, source: str, noises: Sequence[Noise], sizes: Sequence[float]) -> NonlinearModel:
    text = text_of(source, model, noises, lambda k, factor: factor * sizes[k], lambda k, factor: factor * sizes[k] ** 0.5)
    return model_file.read_text(model.path, text)


def _template(model: NonlinearModel, source: str, noises: Sequence[Noise]) -> list[Any]:
    """The file that the page writes, in pieces: between them numbers as of a linear model's"""
    marks, marked = marker()
    return split(text_of(source, model, noises, lambda k, factor: marked([[k, factor]]), lambda k, factor: marked({"root": k, "of": factor})), marks)


def _rest(R: np.ndarray, noises: Sequence[Noise]) -> np.ndarray:
    """Of R what no noise makes"""
    made = R.copy()
    for one in noises:
        if "R" in one.parts:
            made[one.parts["R"] != 0] = 0
    return made


def _on_the_host(model: NonlinearModel, z: np.ndarray, u: Optional[np.ndarray], times: Optional[np.ndarray]) -> tuple[EquationRun, np.ndarray]:
    with CompiledEquations(model, "f64") as host:
        return host.run(z, u if model.l else None, times=times), host.clock


def _found(run: EquationRun) -> dict[str, Any]:
    """By which the page says whether it has the same bits: of all means in f64, and the last one"""
    return {"digest": digest(run.mean), "mean": packed(run.mean[-1])}


def digest(given: np.ndarray) -> int:
    """FNV-1a of the 32-bit halves of doubles"""
    made = 2166136261
    for half in np.ascontiguousarray(given, "<f8").view("<u4").ravel().tolist():
        made = (made ^ half) * 16777619 & 0xFFFFFFFF
    return made


def _step(clock: np.ndarray) -> float:
    return float(clock[-1, 1]) if np.isfinite(clock[-1, 1]) else 1.0


def _limits(m: int) -> list[float]:
    """That a NIS of 0, 1, ... measurements stays below in 95 % of the rows"""
    return [0.0, *(float(chi_square_limit(0.95, np.array(k))) for k in range(1, m + 1))]


def _plain_rows(model: NonlinearModel) -> tuple[np.ndarray, np.ndarray]:
    """Of measurements z = H x + d of one number that is carried; others have rows of 0"""
    H, d = np.zeros((model.m, len(model.carried))), np.zeros(model.m)
    if model.has_errors:
        return H, d
    for c, (e, row) in enumerate(zip(model.formulas.innovation, model.formulas.measurement)):
        some = [i for i, one in enumerate(row) if not one.equals(0)]
        reads = {one.args[0] for one in needed([e])[0] if one.op == "symbol"}
        if len(some) == 1 and row[some[0]].is_constant and reads <= {f"x{some[0]}", f"z{c}"}:
            H[c, some[0]] = row[some[0]].value
            d[c] = -float(Program([e]).values({f"x{some[0]}": 0.0, f"z{c}": 0.0})[0])
    return H, d


def _costs(model: NonlinearModel, name: str) -> dict[str, Any]:
    """By core and call: instructions, as `kalmanq compile` has them; and why there are none"""
    product = compiled_equations(model, name, Options("f32"))
    try:
        record = drawn(model, ROWS, equation_report.SEEDS[0])
        with Host(product) as host:
            found = costs_of(product, test=trial(product, host, record))
    except KalmanqError as problem:  # no rows can be simulated
        return {"costs": {}, "no_costs": str(problem)}
    calls = ["predict", *(f"update{one.suffix}" for one in product.arithmetic.sensors)]
    return {"costs": {core: {"f32": {call: [one.of[call]] for call in calls if one.of[call] is not None}} for core, one in found.items() if one.of},
            "no_costs": " ".join(reasons(found))}
