"""NAME.h of a filter: what it is of, its calls, its events and its readings."""

from __future__ import annotations

from typing import Mapping, Optional, Sequence

from kalmanq.compiler import delayed, lag
from kalmanq.compiler.arithmetic import Arithmetic
from kalmanq.compiler.emit import Text, comment
from kalmanq.compiler.printing import indented
from kalmanq.compiler.request import Request
from kalmanq.firmware.c_source import plain


def header(given: Request, a: Arithmetic, text: Text, late: Optional[delayed.Delayed] = None) -> str:
    return Header(given, a, text, late).text()


class Header:
    def __init__(self, given: Request, a: Arithmetic, text: Text, late: Optional[delayed.Delayed] = None):
        self.late, self.given, self.a, self.name = late, given, a, given.name
        self.c = text
        self.filter = f"{given.type} *f"

    def text(self) -> str:
        guard = f"{self.given.upper}_H"
        return "\n".join([
            *comment([*self._what(), "", *self._usage(), "", *self._quantities()]), f"#ifndef {guard}",
            f"#define {guard}", "", *self.a.includes, "#include <stdint.h>", "", "#ifdef __cplusplus",
            'extern "C" {', "#endif", "", *self._events(), *self.a.enumerators(), *self._fields(), *self._calls(),
            *self._means(), *self.a.calls(), *lag.calls(self.given, self.a),
            *(self.late.calls() if self.late else []), "#ifdef __cplusplus", "}", "#endif", "", f"#endif /* {guard} */", ""])

    def _what(self) -> list[str]:
        model, options = self.given.model, self.given.options
        return [f"{self.name}: a Kalman filter of {count(model.n, 'state')}, {count(model.m, 'measurement')} and "
                f"{count(self.given.inputs, 'control')} in {options.arithmetic}.", "Written by kalmanq compile."]

    def _usage(self) -> list[str]:
        u = ", u" if self.given.inputs else ""
        rows = [(f"static {self.given.type} f;", ""), (f"{self.name}_start(&f);", "once"),
                (f"{self.name}_update(&f, z);", "the first sample"),
                (f"{self.name}_step(&f{u}, z);", "each next sample"),
                (f"{self.name}_predict(&f{u});", "a sample that is missing"),
                (f"{self.name}_mean_{self.given.carried[0]}(&f)", "the estimate")]
        return self._aligned(rows) + self._usage_late()

    def _usage_late(self) -> list[str]:
        return ["", *self._aligned(self.late.usage())] if self.late else []

    @staticmethod
    def _aligned(rows: Sequence[tuple[str, str]]) -> list[str]:
        width = max(len(call) for call, _ in rows) + 4
        return [f"    {call:<{width}}{what}".rstrip() for call, what in rows]

    def _quantities(self) -> list[str]:
        rows = [("", "name", "unit", "range", "format")]
        for which in ("states", "measurements", "controls"):
            for k, one in enumerate(getattr(self.a.model, "inputs" if which == "controls" else which)):
                rows.append((f"{which[:-1]} {k}", plain(one.name), plain(one.unit), f"{one.range:g}" if one.range else "",
                             self.a.format_of(which, k)))
        rows = rows if rows[1][-1] else [row[:-1] for row in rows]
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        return ["    " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)).rstrip() for row in rows]

    def _events(self) -> list[str]:
        """They stay set until f->events is set to 0."""
        rows = [("REFUSED", "a measurement was NaN, infinite or outside its range: it was not taken")]
        rows += [("CONTROL_REFUSED", "a control was outside its range: the nearer end was taken; NaN: 0")] \
            if self.given.inputs else []
        rows += [("GATED", "a measurement was too far off: it was not taken")] \
            if self.given.options.gate is not None else []
        rows += [*self.a.events, *([delayed.EVENT] if self.late else [])]
        lines = [f"{self.given.upper}_{name} = {1 << bit}{',' if bit < len(rows) - 1 else ''} /* {what} */"
                 for bit, (name, what) in enumerate(rows)]
        return ["/* f->events: bits that stay set until you clear them */", "enum {", *indented(lines), "};", ""]

    def _fields(self) -> list[str]:
        options, m = self.given.options, self.given.of.m
        lines = [*self.a.fields, *self.c.count_fields(), "uint16_t events;"]
        lines += self.a.nis_fields() if options.nis else []
        lines += [f"uint8_t rejected[{m}]; /* in a row, by the gate */"] if options.gate is not None else []
        lines += [f"{self.a.type} y[{m}]; /* innovations of the last sample, once settled */"] if options.lag else []
        return ["typedef struct {", *indented(lines), f"}} {self.given.type};", "", *lag.struct(self.given, self.a),
                *(self.late.struct() if self.late else [])]

    def _calls(self) -> list[str]:
        z, u = self.c.z, self.c.u
        lines = [
            *self._starts(), "/** To the next sample.  A sample that is missing is a predict without an update; any number may be",
            f" *  missing.{'  u: the controls since the last sample.' if self.given.inputs else ''} */", f"void {self.name}_predict({self.filter}{u});", "",
            "/** Takes a sample.  Returns a bit for each component that it took; it refuses NaN, infinity and what is",
            f" *  outside its range, with {self.given.upper}_REFUSED.  A second update is one more measurement. */",
            f"unsigned {self.name}_update({self.filter}, {z});", ""]
        if self.given.of.m > 1:
            lines += ["/** Takes the components of a sample whose bits are set in `present`. */",
                      f"unsigned {self.name}_update_some({self.filter}, {z}, unsigned present);", ""]
        for name, _, size in self.given.sensors:
            lines += [f"/** Takes what {name} has measured. */",
                      f"unsigned {self.name}_update_{name}({self.filter}, const {self.a.type} z[{size}]);", ""]
        lines += ["/** Predict and update: the same result in fewer instructions. */",
                  f"unsigned {self.name}_step({self.filter}{u}, {z});", ""]
        return [*lines, *self._covariance()]

    def _starts(self) -> list[str]:
        return ["/** Before the first sample. */", f"void {self.name}_start({self.filter});", "",
                "/** The same from a mean and a sigma of each state that you give.  Returns 1, or 0 where a number is",
                f" *  {self.a.refused_start}. */", f"{self.c.start_at_head(self.filter)};", ""]

    def _covariance(self) -> list[str]:
        return ["/** Entry i, j of the covariance. */",
                f"{self.a.covariance_type} {self.name}_covariance(const {self.given.type} *f, int i, int j);", ""]

    def _means(self) -> list[str]:
        texts = {f"mean_{state}": self.a.mean_text(i) for i, state in enumerate(self.given.carried)}
        return readings(self.given, self.a.type, texts)


def readings(given: Request, type_: str, texts: Mapping[str, str]) -> list[str]:
    """Functions by name that return a text"""
    head = f"static inline {type_} {given.name}_"
    return [*(f"{head}{name}(const {given.type} *f) {{ return {text}; }}" for name, text in texts.items()), ""]


def count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"
