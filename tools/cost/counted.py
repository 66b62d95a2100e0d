"""What an emulator finds out about a call."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace


@dataclass
class Counted:
    instructions: int = 0
    cycles: int = 0
    stack: int = 0
    by_address: Counter[int] = field(default_factory=Counter)


def most(calls: list[Counted]) -> Counted:
    """Of calls of the same region: the one with most instructions, and the deepest stack of all."""
    longest = max(calls, key=lambda call: call.instructions)
    return replace(longest, stack=max(call.stack for call in calls))
