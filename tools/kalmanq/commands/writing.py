"""The C files that compile and design write: of one model, tried on this machine, or over the library."""

from __future__ import annotations

import textwrap
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Sequence

from kalmanq.compiler.report import report
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.trial import trial
from kalmanq.compiler.text.over_library import source
from kalmanq.compiler.text.product import Product
from kalmanq.data.files import whole
from kalmanq.firmware.ranges import Choice
from kalmanq.model import Model
from kalmanq.run.parts import Parts


@dataclass(frozen=True)
class Made:
    """texts: by file; lines: of what is said, and told: the same for machines"""

    texts: dict[str, str]
    lines: list[str]
    told: dict[str, Any]


def alone(product: Product, said: str) -> tuple[report.Findings, list[str], dict[str, str]]:
    """C of one model: what was found, the report's lines, and texts by file; said: lines about the model's file"""
    with Host(product) as host:
        found = report.findings(product, host)
        told = report.lines(product, found)
        return found, told, report.files(product, trial(product, host), told, said)


def over_library(model: Model, arithmetic: str, way: str, name: str, remarks: Sequence[str], **more: Any) -> dict[str, str]:
    """C that calls the library; more: of c_source.source"""
    made = source(Parts(model, arithmetic), way, name, remarks, **more)
    return {f"{made.name}.h": made.header, f"{made.name}.c": made.text}


def write(folder: Path, texts: dict[str, str], model: Path) -> list[Path]:
    """All of them, or none; never over the model's file"""
    paths = [folder / name for name in texts]
    with ExitStack() as stack:
        for path, text in zip(paths, texts.values()):
            stack.enter_context(whole(path, [model])).write_text(text, encoding="utf-8")
    return paths


def remarks_of(notes: Sequence[Choice]) -> list[str]:
    """Ranges that were chosen, in lines for a comment"""
    return [line for one in notes for line in in_lines(f"{one}.")]


def in_lines(text: str) -> list[str]:
    return textwrap.wrap(text, 100, break_on_hyphens=False, break_long_words=False)
