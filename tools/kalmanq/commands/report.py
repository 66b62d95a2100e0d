"""kalmanq report: one page that says whether the data fit the model, and shows why."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import typer
from rich.console import Console

from kalmanq.commands.options import ARITHMETIC, DATA, MODEL, Arithmetic, command_of
from kalmanq.data import tables
from kalmanq.data.files import whole
from kalmanq.errors import KalmanqError
from kalmanq.model import model_file
from kalmanq.pages import report, verdict


@dataclass(frozen=True)
class Asked:
    model: Path = MODEL
    data: Path = DATA
    out: Path = typer.Option(..., "-o", "--out", metavar="REPORT.html", help="One page that stands by itself.")
    arithmetic: Arithmetic = ARITHMETIC


def report_file(asked: Asked, console: Console) -> None:
    _refuse(asked)
    model = model_file.read(asked.model)
    z, u = tables.measurements_and_controls(asked.data, model, has_to_fit=asked.arithmetic == "q31")
    study = report.made_of(model, z, u, asked.arithmetic)
    text = report.page_of(study, asked.model, asked.data.name)
    with whole(asked.out, [asked.model, asked.data]) as path:
        path.write_text(text, encoding="utf-8")
    console.print(verdict.headline(study.found), markup=False)
    console.print(f"wrote {asked.out}", markup=False)


def _refuse(asked: Asked) -> None:
    """What writing would refuse in the end."""
    if not asked.out.parent.is_dir():
        raise KalmanqError(f"{asked.out}: there is no such folder")
    for one in (asked.model, asked.data):
        if asked.out.exists() and one.exists() and asked.out.samefile(one):
            raise KalmanqError(f"{asked.out}: is an input; write to another file")


command = command_of(Asked, report_file)
