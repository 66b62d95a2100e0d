"""A nonlinear model compiled: the texts of its C."""

from __future__ import annotations

from dataclasses import replace
from typing import Optional

from kalmanq.compiler.algorithm.equations import EquationFilter, equations
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.text.equation_delayed import delayed_equations
from kalmanq.compiler.text.equation_text import EquationText
from kalmanq.compiler.text.product import Product, written
from kalmanq.formulas.graph import using
from kalmanq.nonlinear import NonlinearModel


def compiled_equations(model: NonlinearModel, name: str, options: Options = Options(), source: str = "",
                       looked_at: Optional[dict[int, list[int]]] = None) -> Product:
    """source: a line about the model's file; looked_at: of the model with other noises (Equations).  Untraced says what has no formula."""
    model = model.traced_anew()
    of = replace(equations(model, name, options), looked_at=looked_at)
    with using(model.formulas.graph):
        text = EquationText(EquationFilter(of))
        remarks = [f"{name}: written by kalmanq compile.", *([source] if source else []), "",
                   "The functions of the model and their derivatives are worked out at the mean in each call."]
        return written(text, remarks, delayed_equations(text, model))
