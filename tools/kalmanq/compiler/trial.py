"""NAME_test.c: a program that ends with OK where the filter does on your chip what it did on the host."""

from __future__ import annotations

from typing import Optional, Sequence

import numpy as np

from kalmanq.compiler import lag
from kalmanq.compiler.delayed import Late
from kalmanq.compiler.emit import PREDICTS, UPDATES, Row, comment
from kalmanq.compiler.host import Host, Ran
from kalmanq.compiler.printing import indented
from kalmanq.compiler.product import Product
from kalmanq.compiler.record import Record, drawn

ROWS = 24
SEED = 1
NEAR = {"f32": 1e-3, "f64": 1e-9}  # sigma: a core may fuse products where another one rounds them
FAR = 0.5  # sigma: never more
ROUNDINGS = 4  # of what float is off itself: a core's math library rounds in another way
HASH = """\
/* FNV-1a of the bits of a field */
static uint32_t digest(uint32_t h, const void *field, unsigned size)
{
    for (unsigned i = 0; i < size; i++) h = (h ^ ((const unsigned char *)field)[i]) * UINT32_C(16777619);
    return h;
}
"""


def trial(product: Product, host: Host, record: Optional[Record] = None, rounded: float = 0.0) -> str:
    """rounded: how far float is off double, in sigma"""
    record = record or drawn(product.given, ROWS, SEED, 3)
    ran = host.run_record(record)
    back = host.steps_back(record.what) if product.given.options.smooth else None
    return Trial(product, record, ran, back, rounded).text()


class Trial:
    def __init__(self, product: Product, record: Record, ran: Ran, back: Optional[np.ndarray] = None, rounded: float = 0.0):
        """back: smoothed means 1, 2, ... steps ago, of a filter with --smooth"""
        self.product, self.given, self.a = product, product.given, product.arithmetic
        self.record, self.ran, self.back, self.rounded, self.name = record, ran, back, rounded, product.given.name

    def text(self) -> str:
        same = " and has its math library" if self.rounded else ""
        lines = comment([f"{self.name}_test: {ROWS} rows of the model, some of them missing, come to what they came to on the",
                         "host.  Prints OK, and a digest of all bits, which is the same on every core that does not",
                         f"fuse products (-ffp-contract=off){same}: {self.ran.digest:08x}."])
        return "\n".join([*lines, "#include <stdio.h>", "", f'#include "{self.name}.h"', "", *self._rows(), *self._smoothed(), HASH,
                          *self._near(), *self._main()])

    def _rows(self) -> list[str]:
        n, m, l = len(self.given.carried), self.given.of.m, self.given.inputs
        given = [("u", self.record.u), *([] if self.record.now is None else [("now", self.record.now)])] if l else []
        controls = [f"{self.a.type} {', '.join(f'{name}[{l}]' for name, _ in given)};"] if l else []
        clocks = [] if self.record.clock is None else [f"{self.a.type} clock[3];"]
        lines = []
        for t in range(ROWS):
            cells = [*(str(one[t]) for one in (self.record.what, self.record.present, self.ran.taken)),
                     *(self._list("controls", values[t][:l]) for _, values in given),
                     *(f"{{{', '.join(self.a.literal(float(np.nan_to_num(one))) for one in self.record.clock[t])}}}" for _ in clocks),
                     self._list("measurements", self.record.z[t]),
                     f"{{{', '.join(self.a.literal(value) for value in self.ran.reading[t])}}}"]
            lines.append(f"{{{', '.join(cells)}}},")
        return ["static const struct {", *indented([
            f"unsigned char what; /* {PREDICTS}: predict, {UPDATES}: update */", "unsigned present, taken;", *controls, *clocks,
            f"{self.a.type} z[{m}], mean[{n}];"]), f"}} rows[{ROWS}] = {{", *indented(lines), "};", ""]

    def _list(self, which: str, values: Sequence[float]) -> str:
        return f"{{{', '.join(self.a.literal(self.a.raw(which, k, value)) for k, value in enumerate(values))}}}"

    def _smoothed(self) -> list[str]:
        if self.back is None:
            return []
        rows = [f"{{{', '.join(self.a.literal(value) for value in row)}}}," for row in self.back]
        return ["/* Means 1, 2, ... steps ago, given all rows */",
                f"static const {self.a.type} smoothed[{len(rows)}][{len(self.given.carried)}] = {{", *indented(rows), "};", ""]

    def _smooths(self) -> list[str]:
        """Goes back over what is recorded, by both ways"""
        if self.back is None:
            return []
        name, count = self.name, len(self.back)
        near = [f"wrong += !is_near({{}}, smoothed[back - 1][{i}], {self._variance(i, 's')});" for i in range(len(self.given.carried))]
        return [f"static {self.given.type} s;", f"{self.a.type} mean[{len(self.given.carried)}];", "int back = 1;", "s = f;",
                f"for (; back <= {count} && {name}_smooth(&s, &history, back); back++) {{",
                f"    if (!{name}_lagged(&f, &history, back, mean)) wrong++;",
                *(f"    {one.format(f'{name}_mean_{state}(&s)')}" for one, state in zip(near, self.given.carried)),
                *(f"    {one.format(f'mean[{i}]')}" for i, one in enumerate(near)), "}",
                f"wrong += back != {count + 1};"]

    def _late(self) -> list[str]:
        """In time, and late"""
        late, name = self.product.late, self.name
        if late is None:
            return []
        late.has_clock = self.record.clock is not None
        sensors = late.sensors or [Late("", 0, self.given.of.m, late.kept - 1)]
        given, flushed = [], []
        for one in sensors:
            steps = min(one.steps, ROWS // 2)
            call = late.late_row(one, f"t - {steps}" if steps else "t", str(steps))
            given.append(f"    {f'if (t >= {steps}) ' if steps else ''}{call}")
            flushed += [f"for (int t = {ROWS - steps}; t < {ROWS}; t++) {late.late_row(one, 't', f'(unsigned)({ROWS} - t)')}"] if steps else []
        means = (f"{name}_mean_{state}" for state in self.given.carried)
        return ["/* The same rows, whole: in time, and late */", f"static {self.given.type} in_time;", f"static {late.type} d;",
                f"{name}_start(&in_time);", f"{name}_start(&d.now);", f"{name}_delayed_start(&d);", f"for (int t = 0; t < {ROWS}; t++) {{",
                *indented(late.in_time()), f"    if (t) {late.late_predict('t')}", *given, "}", "{", "    const int t = 1;", "    (void)t;",
                *indented(late.in_time_predict()), f"    {late.late_predict('t')}", "}", *flushed,
                *(f"wrong += !is_near({mean}(&d.now), {mean}(&in_time){'' if self.a.type == 'int32_t' else ', ' + self._variance(i, 'in_time')});"
                  for i, mean in enumerate(means))]

    def _near(self) -> list[str]:
        type_, arithmetic = self.a.type, self.given.options.arithmetic
        if arithmetic == "q31":
            return ["static int is_near(int32_t mean, int32_t expected)", "{", "    return mean == expected;", "}", ""]
        limit = self.a.literal(float(np.clip(np.nan_to_num(ROUNDINGS * self.rounded), NEAR[arithmetic], FAR)))
        return [f"static int is_near({type_} mean, {type_} expected, {type_} variance)", "{",
                f"    const {type_} apart = mean - expected;",
                f"    return apart * apart <= {limit} * {limit} * variance;", "}", ""]

    def _variance(self, i: int, of: str = "f") -> str:
        """Of number i of the mean; a nominal number has none of its own: the least of the errors"""
        if not self.given.nominal:
            return f"{self.name}_variance_{self.given.states[i]}(&{of})"
        return self.a.literal(float(np.einsum("tii->ti", self.ran.covariance).min()))

    def _main(self) -> list[str]:
        name = self.name
        clock = ("t - 1", "", "t") if self.record.clock is None else (f"rows[t].clock[{k}]" for k in range(3))
        calls = self.product.text.row(Row(*(f"rows[t].{one}" for one in ("what", "present", "z", "u", "now")), *clock, "taken"))
        checks = []
        for i, state in enumerate(self.given.carried):
            variance = "" if self.a.type == "int32_t" else f", {self._variance(i)}"
            checks.append(f"wrong += !is_near({name}_mean_{state}(&f), rows[t].mean[{i}]{variance});")
        digests = [f"h = digest(h, {one}, sizeof {one});"
                   for one in (*(f"f.{field}" for field in self.a.arrays), *lag.kept(self.given))]
        follows = lag.followed(self.given)
        history = [] if self.back is None else [f"static {name}_history history;", f"{name}_history_start(&history);"]
        return ["int main(void)", "{", *indented([
            f"static {self.given.type} f;", "int wrong = 0;", "uint32_t h = UINT32_C(2166136261);", f"{name}_start(&f);", *follows[:1], *history,
            f"for (int t = 0; t < {ROWS}; t++) {{", "    unsigned taken = 0;",
            *indented([*calls, "wrong += taken != rows[t].taken;", *checks, *follows[1:], *digests]), "}", *self._smooths(), *self._late(),
            f'printf("{name}: %d wrong, digest %08lx\\n", wrong, (unsigned long)h);', 'if (!wrong) puts("OK");',
            "return wrong != 0;"]), "}", ""]
