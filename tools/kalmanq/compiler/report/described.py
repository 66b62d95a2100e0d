"""What there is to call of a compiled filter, for machines: `kalmanq compile --json`, and what measures it."""

from __future__ import annotations

import re
from typing import Any

from kalmanq.compiler.text.equation_text import EquationText
from kalmanq.compiler.text.product import Product


def described(product: Product) -> dict[str, Any]:
    given, text = product.given, product.text
    made = {"name": given.name, "arithmetic": given.options.arithmetic, "form": "factor", "n": given.of.n, "m": given.of.m, "l": given.of.l,
            "ram": product.ram, "ram_delayed": product.ram_delayed, "entries": len(product.arithmetic.live), "predict": _arguments(text.predict_arguments())}
    if not isinstance(text, EquationText):
        return {**made, "calls": product.calls}
    smooths = {"step": text.smoother.record_size, "history": text.smoother.history_size} if text.smoother else None
    sensors = [{"name": one.name, "m": one.m, "arguments": _arguments(text.update_arguments(one))} for one in product.arithmetic.sensors]
    return {**made, "form": "equations", "smooth": smooths, "sensors": sensors}


def _arguments(text: str) -> list[str]:
    """z, u, t and dt, as far as they are there"""
    return re.findall(r"\b(?:[zut]|dt)\b", text)
