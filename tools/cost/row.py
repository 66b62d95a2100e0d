"""A row of the table."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """The columns, in their order."""

    core: str
    arithmetic: str
    n: int
    m: int
    sizes: str
    profile: str
    what: str
    instructions: int
    cycles_estimate: int
    stack_bytes: int
    instructions_worst: int | None
    stack_worst: int | None
    ram_program: int | None
    flash_program: int | None

    @property
    def key(self) -> tuple[object, ...]:
        """What is measured; the rest is what came out."""
        return (
            self.core,
            self.arithmetic,
            self.n,
            self.m,
            self.sizes,
            self.profile,
            self.what,
        )
