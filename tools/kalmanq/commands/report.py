"""kalmanq report: one page that says whether the data fit the model, and shows why."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import List

import typer
from rich.console import Console

from kalmanq.commands.messages import tell_written
from kalmanq.commands.options import (
    ANY_MODEL, ARITHMETIC, COMPILED, DATAS, Arithmetic, as_compiled, command_of, read_any, refuse_compiled)
from kalmanq.data import joining
from kalmanq.data.files import refuse_output, whole
from kalmanq.errors import KalmanqError
from kalmanq.nonlinear import NonlinearModel
from kalmanq.pages import report, verdict


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    data: List[Path] = DATAS
    out: Path = typer.Option(..., "-o", "--out", metavar="REPORT.html", help="The report: one HTML file that needs no other.")
    arithmetic: Arithmetic = ARITHMETIC
    compiled: bool = COMPILED


def report_file(options: Options, console: Console) -> None:
    refuse_output(options.out, [options.model, *options.data])
    model = as_compiled(options.compiled, read_any(options.model, options.data), options.data, options.arithmetic)
    if isinstance(model, NonlinearModel) and model.has_errors:
        raise KalmanqError("of error states there is no report; kalmanq simulate --runs judges them")
    refuse_compiled(options.compiled, model, options.arithmetic)
    z, u, times = joining.record(options.data, model, has_to_fit=options.arithmetic == "q31")
    with console.status("filtering, compiling, and counting what the C costs", spinner="line"):
        study = report.made_of(model, z, u, options.arithmetic, options.compiled, times)
        text = report.page_of(study, options.model, " and ".join(one.name for one in options.data))
    with whole(options.out, [options.model, *options.data]) as path:
        path.write_text(text, encoding="utf-8")
    console.print(verdict.headline(study.found))
    if options.compiled:
        console.print(report.LEFT_OUT)
    tell_written([options.out], console)


command = command_of(Options, report_file)
