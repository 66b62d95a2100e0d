"""What there is to choose from, where a command has been given no name."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping, Optional

from rich.console import Console

from kalmanq.commands.messages import print_json, table
from kalmanq.errors import KalmanqError


def tell_choices(what: str, choices: Mapping[str, str], heading: str, usage: str, out: Optional[Path], as_json: bool,
                 console: Console) -> None:
    if out:
        raise KalmanqError(f"--out: of which {what}?  {', '.join(choices)}")
    if as_json:
        return print_json(dict(choices))
    made = table(what, heading, title=usage)
    for name, shows in choices.items():
        made.add_row(name, shows)
    console.print(made)
