"""What an arithmetic gives to the text of a filter (the folder beside)."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence

import numpy as np

from kalmanq.compiler.given.enclosure import Settled
from kalmanq.compiler.given.request import Request
from kalmanq.model import Model


class Arithmetic:
    """What the text of a filter is made of: lines and expressions of C (FloatFilter, WordFilter).

    type, zero       of a measurement, and 0 of it
    mean_type        of a mean that is kept (--lag)
    covariance_type  of an entry of the covariance
    model            with all ranges that the C uses
    live             entries of the factor that are carried, as P[0], P[1], ...
    steady           None: the gain is never a constant
    unresolved       states whose sigma cannot follow from so many rows on
    events           bits of f->events after those of all filters: name, and what it means
    includes         what the header needs
    operations       of the factor in a predict and an update, in straight lines; most_operations: beyond, it takes loops
    code_includes    what the code needs beside it
    predicts_at_once, updates_at_once  are entries of the factor read and written where they are needed?
    """

    given: Request
    type: str
    zero: str
    mean_type: str = ""
    covariance_type: str
    model: Model
    live: Sequence[tuple[int, int]]
    steady: Optional[Settled]
    operations: int
    most_operations: int
    unresolved: Mapping[int, int] = {}
    events: Sequence[tuple[str, str]] = ()
    includes: Sequence[str] = ()
    code_includes: Sequence[str] = ()
    predicts_at_once = updates_at_once = False

    @property
    def slots(self) -> int:
        """Components of the largest sample"""
        return len(self.model.measurements)

    def factor_literals(self, P: np.ndarray) -> list[str]:
        """Of a covariance: the entries of its factor that are carried"""
        raise NotImplementedError

    def finer(self, times: float) -> str:
        """A sentence of a report: what makes errors so many times smaller"""
        raise NotImplementedError

    def first_low(self) -> Sequence[str]:
        """Lines: nothing is known below the factor's last bits"""
        return ()

    def finer_lines(self) -> Sequence[str]:
        """Lines after the updates of a sample"""
        return ()

    def accepts(self, j: int) -> str:
        """C: is z[j] a number within its range?"""
        raise NotImplementedError

    def accepts_all(self) -> str:
        """C: is each?  It may say no of numbers near the largest"""
        return " && ".join(self.accepts(j) for j in range(len(self.model.measurements)))

    # ---- a start that is given

    refused_start: str = ""  # what answers 0, and what it does then

    def started_at(self) -> list[str]:
        """The last lines: what is returned"""
        return ["return 1;"]

    # ---- what grows without end

    def within_numbers(self) -> list[str]:
        """Lines after a predict"""
        return []

    def hold(self) -> Optional[dict[str, Any]]:
        """Of a function that they call, if there is one"""
        return None

    # ---- constant gains in a table (--every, --lag)

    def gain_literals(self, gains: Sequence[np.ndarray]) -> list[list[str]]:
        """Of tables n x m of gains, which gained() reads"""
        raise NotImplementedError

    def gained(self, i: int, gains: Sequence[np.ndarray], at: str, y: str) -> str:
        """What the innovations add to the mean i; at, y: of a gain and an innovation, with {} for its place.  "": 0"""
        raise NotImplementedError

    def innovation_text(self, j: int) -> tuple[Sequence[str], str]:
        """z<j> less what the mean says, and lines before it"""
        raise NotImplementedError

    def moved(self, added: Mapping[int, str]) -> list[str]:
        """The means in the places, with what is added to them"""
        raise NotImplementedError

    def kept(self, i: int, text: str) -> str:
        """A mean of mean_type, once it is corrected"""
        return text

    def whole_mean(self, i: int) -> str:
        """f's mean in mean_type"""
        raise NotImplementedError

    def lagged(self, i: int, at: str) -> str:
        """The reading of a mean of mean_type"""
        return at

    def enumerators(self) -> list[str]:
        """Of the header: fractions of raw values, or places of coefficients"""
        return []

    def likelihood(self) -> Optional[dict[str, str]]:
        """Of the header: numbers of what reads it"""
        return None

    def tunable(self) -> dict[str, Any]:
        """What the functions that set coefficients are given"""
        return {"tunable": None, "step": None}

    def format_of(self, which: str, k: int) -> str:
        """Of a raw value, as in Q16.15"""
        return ""

    def routines(self, text: str) -> str:
        """What the functions of `text` call"""
        return ""
