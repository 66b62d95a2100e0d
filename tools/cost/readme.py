"""The README's section of costs, made from the table and never typed."""

from __future__ import annotations

from pathlib import Path

from cases import FIXED, RUNTIME, SIZES
from cores import BY_NAME
from errors import CostError
from row import Row

BEGIN, END = "<!-- costs: written by tools/cost.py --readme -->", "<!-- end of costs -->"
LEVEL = "O2"
SMALL, LARGE = (4, 2), (9, 3)

# what one would choose on each core
FITTING = (
    ("m0", "q31"), ("m3", "q31"), ("m4f", "f32"), ("m7", "f32"), ("m7", "f64"), ("m33", "f32"),
    ("rv32", "q31"), ("avr", "f32"), ("avr", "q31"),
)  # fmt: skip


def section(rows: tuple[Row, ...]) -> str:
    """Markdown: a line for each core and arithmetic."""
    by_key = {row.key: row for row in rows}
    sizes = " | ".join(f"{n}, {m}" for n, m in SIZES)
    lines = [
        f"| core | | sizes | {sizes} | flash | stack | RAM |",
        "|---|---|---|" + "---:|" * (len(SIZES) + 3),
    ]
    for core, arithmetic in FITTING:
        for kind in (RUNTIME, FIXED):
            keys = {size: (core, arithmetic, *size, kind, LEVEL, "step") for size in SIZES}
            if all(key in by_key for key in keys.values()):
                by_size = {size: by_key[key] for size, key in keys.items()}
                lines.append(line(core, arithmetic, kind, by_size))
    return "\n".join(lines)


def line(core: str, arithmetic: str, kind: str, by_size: dict[tuple[int, int], Row]) -> str:
    small, large = by_size[SMALL], by_size[LARGE]
    cells = [BY_NAME[core].description, arithmetic, {RUNTIME: "run-time"}.get(kind, kind)]
    cells += [str(row.instructions) for row in by_size.values()]
    flash = {small.flash_bytes: str(small.flash_bytes)}
    flash[large.flash_bytes] = str(large.flash_bytes)  # one number where both are the same
    cells += [
        ", ".join(flash.values()),
        f"{small.stack_bytes}, {large.stack_bytes}",
        f"{small.ram_bytes}, {large.ram_bytes}",
    ]
    return "| " + " | ".join(cells) + " |"


def rewritten(path: Path, rows: tuple[Row, ...]) -> str:
    """The README with the section as the table has it."""
    text = path.read_text(encoding="utf-8")
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(BEGIN) > text.index(END):
        raise CostError(f"{path.name}: needs the lines '{BEGIN}' and '{END}', once each")
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n{section(rows)}\n{END}{rest.split(END)[1]}"


def matches(path: Path, rows: tuple[Row, ...]) -> bool:
    return rewritten(path, rows) == path.read_text(encoding="utf-8")
