"""What an emulator finds out about a call."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field


@dataclass
class Counted:
    ram: int
    instructions: int = 0
    cycles: int = 0
    stack: int = 0
    by_address: Counter[int] = field(default_factory=Counter)
