"""What a model costs on a core as C over the library, in each way: its C is written, and measured by firmware/costs.py."""

from __future__ import annotations

import re
import warnings
from typing import Any, Sequence, Union

import numpy as np

from kalmanq.compiler.text.over_library import WORD, Source, source
from kalmanq.data.rows import present_of
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.firmware.cores import BY_NAME
from kalmanq.firmware.costs import Cost, Design, costs
from kalmanq.firmware.reach import Record, draw
from kalmanq.model import Gaps, Model
from kalmanq.run.filters import Filter
from kalmanq.run.parts import Parts

ROWS, LEAST_ROWS, SEEDS = 32, 16, range(12)  # of the record that is run
Measured = tuple[Cost, str]  # and why there is nothing, or not all of it


def costs_of(model: Model, core: str, ways: Sequence[tuple[str, str]], any_dt: bool = False, steps: int = 1) -> list[Measured]:
    """Of each arithmetic and way"""
    record = max(draw(model.changed(gaps=Gaps()), ROWS, SEEDS), key=lambda one: len(one.z))
    if len(record.z) < LEAST_ROWS:
        return [(Cost(), f"each record that is drawn of the model leaves its ranges within {LEAST_ROWS} rows")] * len(ways)
    made = [_design(model, record, *one, any_dt, steps) for one in ways]
    found = iter(costs(BY_NAME[core], [one for one in made if isinstance(one, Design)]))
    return [next(found) if isinstance(one, Design) else (Cost(), one) for one in made]


def _design(model: Model, record: Record, arithmetic: str, way: str, any_dt: bool, steps: int) -> Union[Design, str]:
    """Or why there is none"""
    try:
        parts = Parts(model, arithmetic, way)
        more: dict[str, Any] = {"any_dt": any_dt and (arithmetic, way) == ("f32", "init"), "steps": steps if arithmetic == "q31" and way != "sizes" else 1}
        return design_of(parts, way, source(parts, way, "design", **more), record, **more)
    except KalmanqError as problem:
        return str(problem)


def design_of(parts: Parts, way: str, made: Source, record: Record, any_dt: bool = False, steps: int = 1) -> Design:
    """With cost-calls.h: rows of the record, and the words that come of them"""
    late = re.search(rf"\b{made.name}_(update_\w+)\(.*size_t ago\)", made.header)
    moved = [*(["controls[(t) - 1]"] if parts.model.inputs else []), *(["STEP_DT"] if any_dt else ["1"] if steps > 1 else [])]
    lines = [f'#include "{made.name}.h"', "#include <math.h>", *_names(parts, made.name), *_lengths(parts, record),
             f"#define IS_KNOWN(mean) {'0' if any_dt else '1' if parts.arithmetic.is_fixed else '!isnan(mean)'}",  # any_dt: A and Q are the chip's own
             f"#define STEP_OF(t, z, present) DESIGN(step)({''.join(f'{one}, ' for one in moved)}z, present)",
             *([f"#define STEP_DT {np.float32(parts.model.continuous.dt)!s}f"] if any_dt else []),
             *([f"#define LATE_OF(z) DESIGN({late[1]})(z, 1, 1)"] if late else []), *_rows(parts, record)]
    texts = {f"{made.name}.h": made.header, f"{made.name}.c": made.text, "cost-calls.h": "\n".join(lines) + "\n"}
    return Design(made.name, parts.arithmetic.name, way, texts, late[1] if late else "")


def _names(parts: Parts, name: str) -> list[str]:
    T = parts.arithmetic.name
    ends = f"#define EXPONENTS (DESIGN(filter)()->memory + KQ_FILTER_LEN_Q31(N) - N)" if parts.arithmetic.is_fixed else \
        f"#define MEAN_LEN (KQ_FILTER_LEN_{T.upper()}(N) - KQ_TRIANGLE(N))"
    return [f"typedef {WORD[T]} word;", f"#define DESIGN(name) {name}_##name", f"#define ALL {name.upper()}_ALL", f"#define MEAN kq_mean_{T}",
            f"#define SIGMA kq_sigma_{T}", ends]


def _lengths(parts: Parts, record: Record) -> list[str]:
    return [f"enum {{ N = {parts.model.n}, M = {parts.model.m}, ROWS = {len(record.z)} }};"]


def _rows(parts: Parts, record: Record) -> list[str]:
    model, arithmetic = parts.model, parts.arithmetic
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KalmanqWarning)  # the trials tell of events
        run = Filter(model, arithmetic.name, parts=parts).run(record.z, record.u)
    formats = parts.formats["measurements"] if arithmetic.is_fixed else None
    measured = arithmetic.words(np.nan_to_num(record.z), model.measurements, formats, "measurements")
    made = [_table("rows", "M", measured, arithmetic.is_fixed), _table("expected", "N", run.words["mean"], arithmetic.is_fixed),
            f"static const uint32_t present[ROWS] = {{{', '.join(f'0x{bits:x}' for bits in present_of(record.z))}}};"]
    pushes = len(model.inputs)
    return [*made, _table("controls", str(pushes), parts.words(record.u, "controls")[:, :pushes], arithmetic.is_fixed)] if pushes else made


def _table(name: str, columns: str, values: np.ndarray, is_fixed: bool) -> str:
    def cell(value: Any) -> str:
        return str(int(value)) if is_fixed else "NAN" if np.isnan(value) else f"{np.float32(value)!s}f"

    rows = ", ".join(f"{{{', '.join(map(cell, row))}}}" for row in values)
    return f"static const word {name}[ROWS][{columns}] = {{{rows}}};"
