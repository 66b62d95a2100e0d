"""kalmanq steady: what a constant model settles to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from kalmanq.commands.messages import print_json, table
from kalmanq.commands.options import JSON, MODEL, command_of
from kalmanq.model import model_file
from kalmanq.run.steady import steady_state


@dataclass(frozen=True)
class Options:
    model: Path = MODEL
    json: bool = JSON


def tell_steady(options: Options, console: Console) -> None:
    model = model_file.read(options.model)
    state = steady_state(model)
    closed = model.A @ (np.eye(model.n) - state.gain @ model.H)
    slowest = float(np.max(np.abs(np.linalg.eigvals(closed))))
    if options.json:
        return print_json({"states": [one.name for one in model.states], "predicted": state.predicted,
                           "filtered": state.filtered, "gain": state.gain, "largest_eigenvalue": slowest})
    made = table("state", "sigma predicted", "sigma filtered", *(f"gain of {one.name}" for one in model.measurements),
                 title=f"{model.name}: steady state")
    for i, one in enumerate(model.states):
        made.add_row(one.label, f"{state.predicted[i, i] ** 0.5:.6g}", f"{state.filtered[i, i] ** 0.5:.6g}",
                     *(f"{k:.6g}" for k in state.gain[i]))
    console.print(made)
    rows = np.log(0.01) / np.log(slowest) if 0 < slowest < 1 else 0
    console.print(f"largest |eigenvalue| of A (I - K H): {slowest:.6g}; an error is down to 1 % in {rows:.0f} rows")


command = command_of(Options, tell_steady)
