"""Measures many programs, two at a time."""

from __future__ import annotations

import tempfile
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path
from typing import Callable

import avr
import build
from build import Place
from cases import Program
from cores import BY_NAME
from measure import Measured, measure

WORKERS = 2


def run_all(
    source: Path, wanted: list[Program], progress: Callable[[int, int], None]
) -> list[Measured]:
    """In the order of the programs; those that this library cannot make are left out."""
    with tempfile.TemporaryDirectory(prefix="kalmanq-cost-") as folder:
        place = Place(source, Path(folder))
        wanted = [program for program in wanted if place.has(program)]
        build.model_printer(place)
        if any(BY_NAME[program.core].family == "avr" for program in wanted):
            avr.build(build.TARGET / "avr_count.c", place.avr_counter)
        with ProcessPoolExecutor(WORKERS) as pool:
            keys = sorted({build.library_key(program) for program in wanted})
            finish([pool.submit(build.library, place, *key) for key in keys])
            runs = [pool.submit(measure, place, program) for program in wanted]
            return finish(runs, progress)


def finish(
    tasks: list[Future[Measured]], progress: Callable[[int, int], None] | None = None
) -> list[Measured]:
    """The results; the first error ends everything."""
    results = []
    try:
        for count, task in enumerate(tasks):
            if progress:
                progress(count, len(tasks))
            results.append(task.result())
    except BaseException:
        for task in tasks:
            task.cancel()
        raise
    return results
