"""q31: what its calls are given, what is read of it, and both for a program on the host."""

from __future__ import annotations

import math
from typing import Any, Sequence

from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.algorithm.fixed import routines as word_routines
from kalmanq.compiler.algorithm.fixed.factor import Factor, Key, keys
from kalmanq.compiler.algorithm.fixed.formats import BITS, Formats, RawValues
from kalmanq.compiler.algorithm.fixed.mean import Mean
from kalmanq.compiler.templates.engine import rendered
from kalmanq.formulas.printing import indented


class Readings(RawValues, Arithmetic):
    """Of a filter in words, which has these"""

    formats: Formats
    factor: Factor
    mean: Mean
    live: Sequence[Key]
    nis_fraction: int

    def accepts(self, j: int) -> str:
        """C: is z[j] within its range?  INT32_MIN is not."""
        most = self.formats.z_most[j]
        return f"(uint32_t)z[{j}] + {most}u <= {2 * most}u"

    def ends_of_control(self, k: int) -> tuple[str, str]:
        ends, most = self.given.model.controls[k].ends, self.formats.u_most[k]
        least, most = [max(-most, min(most, round(math.ldexp(one, self.formats.u[k])))) for one in ends] if ends else (-most, most)
        return str(least), str(most)

    def mixed(self, j: int) -> str:
        mixing, text = self.given.mixing, f"z[{j}]"
        for k in range(j):
            if self.given.together[j] >> k & 1 and mixing[j, k]:
                more = self.mean.nearest(float(mixing[j, k]), f"z[{k}]", self.formats.z[j] - self.formats.z[k])
                text = f"(int32_t)((uint32_t){text} + (uint32_t){more})"
        d = round(math.ldexp(float(self.given.offsets[j]), self.formats.z[j]))
        return f"(int32_t)((uint32_t){text} - (uint32_t){d if d >= 0 else f'({d})'})" if d else text

    @property
    def one(self) -> str:
        """Of a control that is always 1"""
        return str(1 << self.formats.u[-1])

    def fraction(self, which: str, k: int) -> int:
        return {"states": self.formats.read, "measurements": self.formats.z, "controls": self.formats.u}[which][k]

    def nis_fields(self) -> list[str]:
        return ["int64_t nis;", f"int32_t s[{self.given.of.m}]; /* sigma of each innovation, given the components before it */"]

    def size(self) -> int:
        """Bytes of its fields"""
        n, m, options = self.given.of.n, self.given.of.m, self.given.options
        return 8 * n + 4 * max(len(self.live), 1) + (8 + 4 * m if options.nis else 0) + (4 * m if options.lag else 0)

    def sigma_fraction(self, i: int) -> int:
        return BITS - self.formats.exponent[i]

    def enumerators(self) -> list[str]:
        """The header's fractions"""
        given, upper = self.given, self.given.upper
        rows = [(name, "states", i) for i, name in enumerate(given.states)]
        rows += [(f"z_{name}", "measurements", j) for j, name in enumerate(given.measurements)]
        rows += [(f"u_{name}", "controls", k) for k, name in enumerate(given.controls)]
        lines = [f"{upper}_{name.upper()}_FRACTION = {self.fraction(which, k)}" for name, which, k in rows]
        lines += [f"{upper}_SIGMA_{name.upper()}_FRACTION = {self.sigma_fraction(i)}"
                  for i, name in enumerate(given.states)]
        if given.options.nis:
            lines += [f"{upper}_NIS_FRACTION = {self.nis_fraction}"]
            lines += [f"{upper}_S_{name.upper()}_FRACTION = {BITS - self.formats.row[j]}"
                      for j, name in enumerate(given.measurements)]
        points = [*((name, self.fraction(which, k)) for name, which, k in rows),
                  *((f"sigma_{name}", self.sigma_fraction(i)) for i, name in enumerate(given.states))]
        converted = [one for name, fraction in points for one in self._converted(f"{upper}_{name.upper()}", fraction)]
        to_raw = {"name": given.name, "missing": "INT32_MIN", "control": f"takes 0 for such a control, with {upper}_CONTROL_REFUSED"}
        return ["/* value = raw value 2^-FRACTION; a covariance has the sum of two fractions of sigmas */", "enum {",
                *indented([f"{one}," for one in lines[:-1]] + lines[-1:]), "};", "", *rendered("to_raw.h.j2", to_raw).splitlines(), *converted, ""]

    def _converted(self, name: str, fraction: int) -> list[str]:
        return [f"#define {name}_RAW(value) {self.given.name}_to_raw((double)(value), {2.0**fraction!r})",
                f"#define {name}_VALUE(raw) ((double)(raw) * {2.0**-fraction!r})"]

    def mean_text(self, i: int) -> str:
        return self.lagged(i, self.whole_mean(i))

    def whole_mean(self, i: int) -> str:
        return f"f->x[{i}]"

    def kept(self, i: int, text: str) -> str:
        return f"stopped({text}, INT64_C(1) << {self.formats.end[i]})"

    def lagged(self, i: int, at: str) -> str:
        by = self.formats.x[i] - self.formats.read[i]
        if by <= 0:
            return f"(int32_t)({at} * (INT64_C(1) << {-by}))"
        return f"(int32_t)(({at} + (INT64_C(1) << {by - 1})) >> {by})"

    def covariance(self) -> dict[str, Any]:
        """Its entries; row: of a state, in S"""
        n, slots = self.given.of.n, {key: slot for slot, key in enumerate(self.live)}
        place, row = [slots.get(key, 255) for key in keys(n)], [self.factor.order.index(i) for i in range(n)]
        return {"row": [] if row == list(range(n)) else row, "place": [] if place == list(range(len(place))) else place, "live": len(place)}

    def routines(self, text: str) -> str:
        stop = "\n".join(self.mean.stop(self.given.type)) if "stop(f)" in text else ""
        return word_routines.routines(text + stop) + "\n" + stop + "\n"

    # ---- for a program on the host, and for a test

    def from_double(self, which: str, k: int, text: str) -> str:
        f = self.fraction(which, k)
        beyond = "INT32_MIN" if which == "measurements" else f"({text} < 0 ? INT32_MIN : INT32_MAX)"
        return f"fabs({text}) < ldexp(0x7fffffff, {-f}) ? (int32_t)floor(ldexp({text}, {f}) + 0.5) : {beyond}"

    def mean_double(self, i: int) -> str:
        return f"ldexp((double)f.x[{i}], {-self.formats.x[i]})"

    def covariance_double(self, i: str, j: str) -> str:
        points = ", ".join(str(self.sigma_fraction(k)) for k in range(self.given.of.n))
        sum_ = " - ".join(f"((const int[]){{{points}}})[{one}]" for one in (i, j))
        return f"ldexp((double){self.given.name}_covariance(&f, {i}, {j}), -{sum_})"
