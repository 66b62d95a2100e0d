"""What kalmanq compile will make of a model, for kalmanq check: does its gain settle, when, and why not."""

from __future__ import annotations

import math
from typing import Sequence

from kalmanq.compiler.given import enclosure
from kalmanq.compiler.given.request import GAP, LONGEST_GAP, Options, request
from kalmanq.compiler.text.product import TOO_SLOW, compiled
from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.run.checks import Finding, lasting, note


def finding(model: Model, rates: Sequence[int] = ()) -> Finding:
    """rates: that data show, where full samples are rare"""
    try:
        given = request(model, "filter", Options())
    except KalmanqError as problem:
        return note("compiled", f"refused: {problem}")
    if rates:
        return Finding(True, "compiled", of_rates(model, rates))
    steady = enclosure.settled(given.of, min(max(model.gaps.max_gap, GAP), LONGEST_GAP), Options().settle)
    if steady is None:
        return Finding(True, "compiled", f"the gain is worked out in each row: {lasting(model) or TOO_SLOW}")
    return Finding(True, "compiled", f"the gain is constant after {steady.samples} full samples, and again "
                   f"{steady.after_gap[0]} after one that is missing")


def of_rates(model: Model, rates: Sequence[int]) -> str:
    """With --every, beside what a filter without it makes of them"""
    rows, option = math.lcm(*rates), f"--every {','.join(map(str, rates))}"
    slow = ", ".join(f"{one.name} every {k} rows" for one, k in zip(model.measurements, rates) if k > 1)
    try:
        turn = compiled(model, "filter", Options(every=rates)).cycle
    except KalmanqError as problem:
        return f"the data have {slow}: the gain is worked out in each row ({option}: {problem})"
    then = f"each row has a constant gain after {turn.cycles} cycles of {rows} rows, {turn.cycles * rows} rows" if turn else \
        "the gain is worked out in each row as well: no cycle of rows has a steady state"
    return f"the data have {slow}, so most rows are no full sample and the gain is worked out in each row; with kalmanq compile {option} {then}"


def formats(model: Model) -> Finding:
    """Of the C in q31, by which its header is written: where a word needs room for more than the range, not the library's"""
    try:
        arithmetic = compiled(model, "filter", Options("q31")).arithmetic
    except KalmanqError as problem:
        return note("compiled in q31", f"refused: {problem}")
    made = (f"{one.name} {arithmetic.format_of(which, k)}" for which in ("states", "measurements") for k, one in enumerate(getattr(model, which)))
    return Finding(True, "compiled in q31", f"the header's formats: {', '.join(made)}")
