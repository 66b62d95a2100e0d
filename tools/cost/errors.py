"""What the user can put right, as one line."""

from __future__ import annotations


class CostError(Exception):
    """Its text is the one line to be shown."""


def one_line(text: str, longest: int = 300) -> str:
    """The text without line breaks and other control characters, and not too long."""
    shown = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return shown if len(shown) <= longest else shown[: longest - 3] + "..."
