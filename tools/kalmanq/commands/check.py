"""kalmanq check: is a model fit for a filter?  Of a nonlinear one: are its Jacobians right, do its ranges fit?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import REFUSED, print_json
from kalmanq.commands.options import ANY_MODEL, JSON, Arithmetic, command_of, read_any
from kalmanq.compiler.given.rates import rates_of
from kalmanq.compiler.report import settling
from kalmanq.data import joining
from kalmanq.errors import counted
from kalmanq.model import Model
from kalmanq.model.column_model import row_needs
from kalmanq.nonlinear import checks as nonlinear
from kalmanq.run import checks as linear, checks_of_rows as rows


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    data: Optional[Path] = typer.Argument(None, metavar="DATA.csv", help="Data: rates of sensors are told from them, and a nonlinear model's Jacobians are checked along them.")
    arithmetic: Optional[Arithmetic] = typer.Option(None, "--arith", help="Judge the resolution of this arithmetic alone; by default f32, and q31 "
                                                    "where there are ranges.")
    json: bool = JSON


def check(options: Options, console: Console) -> None:
    model = read_any(options.model, options.data)
    made = _of_linear(options, model) if isinstance(model, Model) else \
        nonlinear.findings(model, _rows(options, model), options.arithmetic)
    if options.json:
        print_json({one.subject: {"good": one.is_good, "note": one.is_note, "said": one.said} for one in made})
    else:
        console.print(f"{model.name}: {counted(model.n, 'state')}, {counted(model.m, 'measurement')}, {counted(len(model.inputs), 'control')}")
        for one in made:
            console.print(f"  {one.mark} {one.subject}: {one.said}")
    if not all(one.is_good for one in made):
        raise SystemExit(REFUSED)


def _of_linear(options: Options, model: Model) -> list[linear.Finding]:
    if row_needs(model):
        return rows.findings(model, None if options.data is None else joining.record(options.data, model), options.arithmetic)
    rates = () if options.data is None else rates_of(joining.record(options.data, model)[0])
    made = [*linear.findings(model, options.arithmetic), settling.finding(model, rates)]
    return [*made, settling.formats(model)] if any(one.subject == "ranges" and one.is_good for one in made) else made


def _rows(options: Options, model: nonlinear.NonlinearModel) -> Optional[nonlinear.Rows]:
    if options.data is None:
        return None
    z, u, times = joining.record(options.data, model)
    return z, np.zeros((len(z), 0)) if u is None else u, times


command = command_of(Options, check)
