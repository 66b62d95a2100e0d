"""What there is to choose from, where a command has been given no name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Mapping, Optional

from rich.console import Console
from rich.table import Table

from kalmanq.errors import KalmanqError


def tell_choices(what: str, choices: Mapping[str, str], heading: str, usage: str, out: Optional[Path], as_json: bool,
                 console: Console) -> None:
    """choices: what each one shows, by name"""
    if out:
        raise KalmanqError(f"--out: of which {what}?  {', '.join(choices)}")
    if as_json:
        print(json.dumps(dict(choices), indent=2))
        return
    table = Table(what, heading, title=usage, title_justify="left")
    for name, shows in choices.items():
        table.add_row(name, shows)
    console.print(table)
