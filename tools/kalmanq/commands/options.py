"""What commands share: options, choices out of the library's tables, and how a command is made of its options."""

from __future__ import annotations

import inspect
import math
from dataclasses import fields
from enum import Enum
from pathlib import Path
from typing import Any, Callable, Iterable, List, Optional, Union, get_type_hints

import numpy as np
import typer
from rich.console import Console

from kalmanq.commands.messages import console, told_in_one_line
from kalmanq.core import ARITHMETICS
from kalmanq.data import joining
from kalmanq.data.layouts import Source, layout_of
from kalmanq.data.rows import require_steps as require_even
from kalmanq.errors import KalmanqError
from kalmanq.model import Model, model_file
from kalmanq.model.column_model import row_needs
from kalmanq.nonlinear import NonlinearModel, file as nonlinear_file
from kalmanq.nonlinear.of_columns import equations_of, has_steps
from kalmanq.run.robust import LOSSES, Robust

AnyModel = Union[Model, NonlinearModel]


def choices(name: str, of: Iterable[str]) -> Any:
    """The type of an option that is one of a table's names; a command gets the name."""
    return Enum(name, {one: one for one in of}, type=str)  # type: ignore[misc]


Arithmetic = choices("Arithmetic", ARITHMETICS)
ChipArithmetic = choices("ChipArithmetic", (name for name in ARITHMETICS if name != "f64"))

MODEL = typer.Argument(..., metavar="MODEL", help="A model file (TOML).")
ANY_MODEL = typer.Argument(..., metavar="MODEL", help="A model file (TOML); or a nonlinear one (.py), which is executed.")
DATA = typer.Argument(..., metavar="DATA", help="A CSV file with a header, or a log: measurements and controls by name. Empty cell: missing. -: the standard input.")
DATAS = typer.Argument(..., metavar="DATA", help="A CSV file with a header, a log (GPX, NMEA, UBX, ULog, CAN), Parquet, Feather or Excel; or several, joined by their times. Empty cell: missing. -: the standard input.")
JSON = typer.Option(False, "--json", help="Print the results as JSON.")
ARITHMETIC = typer.Option("f64", "--arith", help="The arithmetic of the chip: float, double or fixed point.")
COMPILED = typer.Option(False, "--compiled", help="Run the C that kalmanq compile writes, built on this machine.")
WORKERS = typer.Option(None, "--workers", min=1, help="Number of processes; all cores by default.")
FRESH = typer.Option(False, "--fresh", help="Start anew: do not go on where a command was interrupted.")

# How a file of data is written; of every command that reads one
LAYOUT_PANEL = "How the data file is written"
LAYOUT = {name: (kind, typer.Option(default, f"--{name.replace('_', '-')}", metavar=metavar, help=said, rich_help_panel=LAYOUT_PANEL, **more))
          for name, kind, default, metavar, said, more in (
    ("separator", Optional[str], None, "LETTER", "What is between fields: a character, or the word tab. Found if left out.", {}),
    ("decimal", Optional[str], None, ". or ,", "The decimal sign. Found if left out.", {}),
    ("missing", List[str], [], "CELL", "A cell that means missing, such as -9999. May be given again.", {}),
    ("rename", List[str], [], "NAME=COLUMN", "COLUMN of the file is NAME of the model. May be given again.", {}),
    ("time", Optional[str], None, "COLUMN", "The column of times, such as 't (ms)'; none: each row is a step. Found by its name if left out.", {}),
    ("time_format", Optional[str], None, "FORMAT", "How times are written, as of strptime: '%d.%m.%y %H:%M'.", {}),
    ("sort", bool, False, None, "Sort the rows by their times.", {}),
    ("skip_untimed", bool, False, None, "Leave rows without a time out.", {}),
    ("pause", Optional[float], None, "SECONDS", "A longer time without a row begins a new record.", {"min": 0}),
    ("database", Optional[str], None, "FILE.dbc", "The signals of a CAN log.", {}),
    ("jitter", Optional[float], None, "SHARE", "A step counts as a multiple of dt if it is off by less than this share of dt.", {"min": 0, "max": 0.49}))}
READ = ("data", "controls", "at")  # fields that are files of data


def command_of(Options: Any, perform: Callable[[Any, Console], None]) -> Callable[..., None]:
    """A function for typer.  The fields of the dataclass `Options` are the options: `perform` gets one of it, with a Source
    for each file of data."""
    hints, own = get_type_hints(Options), [one.name for one in fields(Options)]
    parameters = {one.name: (hints[one.name], one.default) for one in fields(Options)}
    reads = [name for name in READ if name in parameters]
    if reads:
        last = parameters.popitem()
        parameters.update(LAYOUT)
        parameters.update([last])

    def command(**given: Any) -> None:
        with told_in_one_line():
            layout = layout_of({name: given[name] for name in LAYOUT}) if reads else None
        made = {name: _plain(given[name]) for name in own}
        for name in reads:
            made[name] = _source(made[name], layout)
        paths = [path for name in ("data", "out", "plot", "controls", "at")
                 for path in (made.get(name) if isinstance(made.get(name), list) else [made.get(name)])]
        with told_in_one_line(made.get("model"), *paths):
            perform(Options(**made), console())

    command.__signature__ = inspect.Signature([  # type: ignore[attr-defined]
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
        for name, (kind, default) in parameters.items()])
    command.__annotations__ = {name: kind for name, (kind, _) in parameters.items()}
    return command


def _plain(given: Any) -> Any:
    return given.value if isinstance(given, Enum) else given


def _source(given: Any, layout: Any) -> Any:
    return [Source(one, layout) for one in given] if isinstance(given, (list, tuple)) else \
        None if given is None else Source(given, layout)


def require_steps(model: Model, times: Optional[np.ndarray], what: str) -> None:
    """Of an option whose filter runs steps of dt alone"""
    require_even(model, times, what, f"leave {what} out; --jitter takes steps that are nearly dt for dt; --time none takes each row for one")


def forms_of(losses: Iterable[str]) -> str:
    """As --robust takes them: gate[=K]|..."""
    return "|".join(f"{name}[={LOSSES[name].letter}]" for name in losses)


def robust_of(given: Optional[str], known: Iterable[str] = LOSSES) -> Optional[Robust]:
    """Of --robust LOSS[=PARAMETER]; known: losses that the command has"""
    if given is None:
        return None
    loss, has_value, value = given.partition("=")
    if loss not in known:
        cure = "; over the library `kalmanq run` has it, and firmware kalmanq/robust.h" if loss in LOSSES else ""
        raise KalmanqError(f"--robust {given}: give one of {', '.join(known)}{cure}")
    try:
        parameter = float(value) if has_value else None
    except ValueError:
        raise KalmanqError(f"--robust {given}: {value or 'nothing'} is not a number: give one, such as {loss}={LOSSES[loss].shown:g}") from None
    if parameter is not None and loss == "gate" and not 1 < parameter < math.inf:
        raise KalmanqError(f"--robust {given}: K is in sigma, above 1: give gate={LOSSES['gate'].shown:g}, or gate alone")
    try:
        return Robust(loss, parameter)
    except KalmanqError as problem:
        raise KalmanqError(f"--robust {given}: {problem}") from None


def as_compiled(is_compiled: bool, model: AnyModel, data: Any, arithmetic: str = "f32") -> AnyModel:
    """What the emitted C is of: a linear model with numbers from columns, or D, is compiled as functions"""
    if not (is_compiled and isinstance(model, Model) and row_needs(model)):
        return model
    if model.continuous and not has_steps(model):
        require_steps(model, joining.record(data, model)[2], "--compiled")
    return equations_of(model, arithmetic)


def refuse_compiled(is_compiled: bool, model: AnyModel, arithmetic: str = "f32", more: str = "") -> None:
    """more: options that not all of them have"""
    if is_compiled and isinstance(model, NonlinearModel) and arithmetic == "q31" and more:
        raise KalmanqError(f"--compiled --arith q31: the device over the library is an extended filter: leave {more} out")


def read_any(path: Path, data: Any = None) -> AnyModel:
    """A linear model of a TOML file, a nonlinear one of a Python file; data: a file or several, whose --jitter it takes."""
    is_nonlinear = Path(path).suffix == nonlinear_file.SUFFIX
    if is_nonlinear and data is not None and (data[0] if isinstance(data, list) else data).layout.jitter is not None:
        raise KalmanqError("--jitter: of a linear model with F, Qc and dt")
    return nonlinear_file.read(path) if is_nonlinear else jittered(model_file.read(path), data)


def jittered(model: Model, data: Any) -> Model:
    share = None if data is None else (data[0] if isinstance(data, list) else data).layout.jitter
    return model if share is None or model.continuous is None else model.jittered(share)
