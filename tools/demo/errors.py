"""What the user did wrong, as one line."""

from __future__ import annotations

from pathlib import Path


class DemoError(Exception):
    """Something the user can put right; its text is the one line to be shown."""


class InputError(DemoError):
    """A file that cannot be used: says which file, which row and why."""

    def __init__(self, path: Path, reason: str, row: int | None = None, column: int | None = None):
        place = [one_line(str(path))]
        if row is not None:
            place.append(f"row {row}" + (f", column {column}" if column is not None else ""))
        super().__init__(": ".join(place + [reason]))


def one_line(text: str, longest: int = 200) -> str:
    """The text without line breaks and other control characters, and not too long."""
    shown = "".join(c if c.isprintable() else "?" for c in text)
    return shown if len(shown) <= longest else shown[: longest - 3] + "..."
