"""Measures many programs, two at a time."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from multiprocessing.pool import Pool
from pathlib import Path
from typing import Callable, Sequence, TypeVar

from rich.console import Console
from rich.progress import track

import avr
import build
from build import Place
from cases import Program
from cores import BY_NAME
from measure import Measured, measure

WORKERS = 2
Item = TypeVar("Item")
Result = TypeVar("Result")


def run_all(source: Path, wanted: list[Program]) -> list[Measured]:
    """In the order of the programs; those that this library cannot make are left out."""
    with tempfile.TemporaryDirectory(prefix="kalmanq-cost-") as folder:
        place = Place(source, Path(folder))
        wanted = [
            replace(program, lacks=place.lacks) for program in wanted if place.has(program)
        ]
        make_tools(place, wanted)
        keys = sorted({build.library_key(program) for program in wanted})
        with get_context("fork").Pool(WORKERS) as pool:  # an error ends both
            finish(pool, partial(build.library, place), keys, "compiling")
            return finish(pool, partial(measure, place), wanted, "measuring")


def make_tools(place: Place, wanted: list[Program]) -> None:
    """The host's programs."""
    build.model_printer(place)
    if any(BY_NAME[program.core].family == "avr" for program in wanted):
        avr.build(build.TARGET / "avr_count.c", place.avr_counter)


def finish(
    pool: Pool, task: Callable[[Item], Result], items: Sequence[Item], doing: str
) -> list[Result]:
    """The results, in the order of the items."""
    screen = Console(stderr=True)
    results = pool.imap(task, items)
    return list(
        track(
            results,
            doing,
            len(items),
            console=screen,
            transient=True,
            disable=not screen.is_terminal,
        )
    )
