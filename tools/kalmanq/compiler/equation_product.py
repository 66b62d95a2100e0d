"""A nonlinear model compiled: the texts of its C."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Optional

from kalmanq.compiler.emit import passed
from kalmanq.compiler.equation_delayed import delayed_equations
from kalmanq.compiler.equation_text import EquationText
from kalmanq.compiler.equations import EquationFilter, equations
from kalmanq.compiler.head import Header
from kalmanq.compiler.product import Product
from kalmanq.compiler.request import Options
from kalmanq.formulas.graph import using
from kalmanq.nonlinear import NonlinearModel


def compiled_equations(model: NonlinearModel, name: str, options: Options = Options(), source: str = "",
                       looked_at: Optional[dict[int, list[int]]] = None) -> Product:
    """source: a line about the model's file; looked_at: of the model with other noises (Equations).  Untraced says what has no formula."""
    of = replace(equations(model, name, options), looked_at=looked_at)
    with using(model.formulas.graph):
        a = EquationFilter(of)
        text = EquationText(of.given, a)
        remarks = [f"{name}: written by kalmanq compile.", *([source] if source else []), "",
                   "The functions of the model and their derivatives are worked out at the mean in each call."]
        late = delayed_equations(a, text, model)
        return Product(of.given, None, None, a, text, EquationHeader(of.given, a, text, late).text(), text.code(remarks), late)


class EquationHeader(Header):
    def _usage(self) -> list[str]:
        rows = [(f"static {self.given.type} f;", ""), (f"{self.name}_start(&f);", "once"),
                *((f"{self.name}_update{one.suffix}(&f{passed(self.c.update_arguments(one))});", "a sample")
                  for one in self.a.sensors),
                (f"{self.name}_predict(&f{passed(self.c.predict_arguments())});", "to the next instant"),
                (f"{self.name}_mean_{self.given.carried[0]}(&f)", "the estimate"),
                *(self.c.smoother.usage() if self.c.smoother else [])]
        return self._aligned(rows) + self._usage_late()

    def _calls(self) -> list[str]:
        before = self.c.predict_arguments()
        lines = [*self._starts(), f"/** To the next instant.{_said(before, 'controls from here to there', 'of the row that is left')} */",
                 f"void {self.name}_predict({self.filter}{before});", ""]
        for sensor in self.a.sensors:
            arguments = self.c.update_arguments(sensor)
            lines += ["/** Takes a sample.  Returns a bit for each component that it took; it refuses NaN and infinity, with",
                      f" *  {self.given.upper}_REFUSED.{_said(arguments, 'controls of this row', 'of this row')} */",
                      f"unsigned {self.name}_update{sensor.suffix}({self.filter}{arguments});", ""]
            if sensor.m > 1:
                lines += ["/** Takes the components of a sample whose bits are set in `present`. */",
                          f"unsigned {self.name}_update{sensor.suffix}_some({self.filter}{arguments}, unsigned present);", ""]
        return [*lines, *self._covariance(), *(self.c.smoother.calls() if self.c.smoother else [])]

    def _fields(self) -> list[str]:
        return [*super()._fields(), *(self.c.smoother.structs() if self.c.smoother else [])]


def _said(arguments: str, u: str, t: str) -> str:
    """Of the arguments u, t and dt, where there are any"""
    made = f"  u: {u}." if " u[" in arguments else ""
    made += f"  t: time or number {t}." if re.search(r" t\b", arguments) else ""
    return made + ("  dt: time to it." if re.search(r" dt\b", arguments) else "")
