"""The files of a compiled filter, by name."""

from __future__ import annotations

import decimal
from dataclasses import replace
from typing import Optional

from kalmanq.compiler import exact
from kalmanq.compiler.proven.header import header
from kalmanq.compiler.proven.product import Product
from kalmanq.compiler.proven.proof_file import proof_text, remarks
from kalmanq.compiler.proven.search import Runner
from kalmanq.compiler.proven.text import code
from kalmanq.compiler.proven.trial_file import ROWS, Worst, trial


def texts_of(product: Product, digest: str) -> dict[str, str]:
    """digest: of the model file"""
    name = product.plan.name
    with decimal.localcontext(exact.DIGITS):
        plan = replace(product.plan, remarks=[f"SHA-256 of its model file: {digest}", *remarks(product)])
        with Runner(product.plan) as runner:
            track = runner.record(ROWS, plan.max_gap, prints=True)
        return {f"{name}.c": code(plan), f"{name}.h": header(plan),
                f"{name}_test.c": trial(plan, track, product.proof.track.worst, _worst(product)),
                f"{name}_proof.txt": f"model file {digest} (SHA-256)\n{proof_text(product)}"}


def _worst(product: Product) -> Optional[Worst]:
    if not product.plan.bounds:
        return None
    return Worst(product.plan, product.plan.settled, [one.range or 0 for one in product.model.measurements])
