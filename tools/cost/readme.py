"""The README's section of costs, made from the table and never typed."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping

import card
from cases import FIXED, GCC, RUNTIME, SIZES
from cores import BY_NAME
from errors import CostError
from row import Row

BEGIN, END = "<!-- costs: written by tools/cost.py --readme -->", "<!-- end of costs -->"
PROFILE = GCC
MODULE_SIZES = ((2, 1), (4, 2), (9, 3))
MODULE_CORES = (("m4f", "f32"), ("m3", "q31"))
# what the README calls them; the filter's step first, to compare with
MODULE_ROWS = (
    ("step", RUNTIME, "`kq_step`"),
    ("steady", RUNTIME, "`kq_steady_step`"),
    ("steady", FIXED, "`kq_fixed_steady_step`"),
    ("switch", RUNTIME, "`kq_switch_step`, settled"),
    ("update", RUNTIME, "`kq_update`"),
    ("gated", RUNTIME, "`kq_update_gated`, accepted"),
    ("huber", RUNTIME, "`kq_update_huber`"),
    ("student", RUNTIME, "`kq_update_student`"),
    ("jump", RUNTIME, "`kq_update_jump`, none"),
    ("lag", RUNTIME, "a sample with `kq_lag_smooth`, L = 10"),
    ("lag_states", RUNTIME, "a sample with `kq_lag_smooth_states`, L = 10"),
    ("point", RUNTIME, "a sample with `kq_point_smooth`"),
    ("adapted", RUNTIME, "a sample of `kq_adaptation`"),
    ("em", RUNTIME, "`kq_em_iterate`, 100 steps; Q and R free"),
    ("em_state", RUNTIME, "... A, Q and R free"),
)

STEPS_TITLE = "Instructions of one settled predict and one full update (`kq_step`) at n, m:"
MODULES_TITLE = "Instructions of the other functions at n, m, and of the plain ones beside them:"
Rows = Mapping[tuple[object, ...], Row]

# what one would choose on each core
FITTING = (
    ("m0", "q31"), ("m3", "q31"), ("m4f", "f32"), ("m7", "f32"), ("m7", "f64"), ("m33", "f32"),
    ("rv32", "q31"), ("avr", "f32"), ("avr", "q31"),
)  # fmt: skip


def section(rows: tuple[Row, ...]) -> str:
    by_key = {row.key: row for row in rows}
    tables = (card.markdown(rows), STEPS_TITLE, steps(by_key), MODULES_TITLE, modules(by_key))
    return "\n\n".join(tables)


def modules(by_key: Rows) -> str:
    """Markdown: instructions, a line for each function."""
    columns = [(where, size) for where in MODULE_CORES for size in MODULE_SIZES]
    titles = [f"{core.upper()} {arithmetic}: {n}, {m}" for (core, arithmetic), (n, m) in columns]
    lines = ["| | " + " | ".join(titles) + " |", "|---|" + "---:|" * len(columns)]
    for what, kind, name in MODULE_ROWS:
        cells = [cells_of(by_key, where, kind, what) for where in MODULE_CORES]
        if any(cells) and None not in cells:
            cells = [name, *(cell for core in cells for cell in core or [""] * len(MODULE_SIZES))]
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def cells_of(by_key: Rows, where: tuple[str, str], kind: str, what: str) -> list[str] | None:
    """Of one core, instructions at each size; none where it has no such function, or None where some
    figures are missing."""
    keys = [(*where, *size, kind, PROFILE, what) for size in MODULE_SIZES]
    found = [str(by_key[key].instructions) for key in keys if key in by_key]
    return found if len(found) in (0, len(keys)) else None


def steps(by_key: Rows) -> str:
    """Markdown: a line for each core and arithmetic."""
    sizes = " | ".join(f"{n}, {m}" for n, m in SIZES)
    lines = [
        f"| core | | sizes | {sizes} |",
        "|---|---|---|" + "---:|" * len(SIZES),
    ]
    for core, arithmetic in FITTING:
        for kind in (RUNTIME, FIXED):
            keys = {size: (core, arithmetic, *size, kind, PROFILE, "step") for size in SIZES}
            if all(key in by_key for key in keys.values()):
                by_size = {size: by_key[key] for size, key in keys.items()}
                lines.append(line(core, arithmetic, kind, by_size))
    return "\n".join(lines)


def line(core: str, arithmetic: str, kind: str, by_size: dict[tuple[int, int], Row]) -> str:
    cells = [BY_NAME[core].description, arithmetic, {RUNTIME: "run-time"}.get(kind, kind)]
    return "| " + " | ".join([*cells, *(str(row.instructions) for row in by_size.values())]) + " |"


def rewritten(path: Path, rows: tuple[Row, ...]) -> str:
    """The README with the section as the table has it."""
    text = path.read_text(encoding="utf-8")
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(BEGIN) > text.index(END):
        raise CostError(f"{path.name}: needs the lines '{BEGIN}' and '{END}', once each")
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n{section(rows)}\n{END}{rest.split(END)[1]}"


def matches(path: Path, rows: tuple[Row, ...]) -> bool:
    return rewritten(path, rows) == path.read_text(encoding="utf-8")
