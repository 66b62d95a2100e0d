"""What can be wrong, and what can happen to numbers."""

from __future__ import annotations

from typing import Optional


class KalmanqError(Exception):
    """What the C core refused, or a tool cannot do; its text is one line.

    text    without the row
    status  the core's kq_status, or None
    row     of a sequence, counted from 0, or None
    """

    def __init__(self, text: str, status: Optional[int] = None, row: Optional[int] = None):
        super().__init__(text if row is None else f"row {row}: {text}")
        self.text = text
        self.status = status
        self.row = row


class ModelError(KalmanqError):
    """A model that is none; `key` is the part of it."""

    def __init__(self, key: str, reason: str):
        super().__init__(f"{key}: {reason}")
        self.key = key
        self.reason = reason


class KalmanqWarning(UserWarning):
    """An event of the C core (status.h): numbers went where they could not all be kept."""


def counted(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"
