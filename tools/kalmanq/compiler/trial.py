"""NAME_test.c: a program that ends with OK where the filter does on your chip what it did on the host."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from kalmanq.compiler import lag
from kalmanq.compiler.emit import comment
from kalmanq.compiler.host import PREDICTS, UPDATES, Host, Ran
from kalmanq.compiler.printing import indented
from kalmanq.compiler.product import Product
from kalmanq.compiler.record import Record, drawn

ROWS = 24
SEED = 1
NEAR = {"f32": 1e-3, "f64": 1e-9}  # sigma: a core may fuse products where another one rounds them
HASH = """\
/* FNV-1a of the bits of a field */
static uint32_t digest(uint32_t h, const void *field, unsigned size)
{
    for (unsigned i = 0; i < size; i++) h = (h ^ ((const unsigned char *)field)[i]) * UINT32_C(16777619);
    return h;
}
"""


def trial(product: Product, host: Host) -> str:
    record = drawn(product.given, ROWS, SEED, 3)
    return Trial(product, record, host.run(record.z, record.u, record.present, record.what)).text()


class Trial:
    def __init__(self, product: Product, record: Record, ran: Ran):
        self.product, self.given, self.a = product, product.given, product.arithmetic
        self.record, self.ran, self.name = record, ran, product.given.name
        self.u = ", rows[t].u" if self.given.of.l else ""

    def text(self) -> str:
        lines = comment([f"{self.name}_test: {ROWS} rows of the model, some of them missing, come to what they came to on the",
                         "host.  Prints OK, and a digest of all bits, which is the same on every core that does not",
                         f"fuse products (-ffp-contract=off): {self.ran.digest:08x}."])
        return "\n".join([*lines, "#include <stdio.h>", "", f'#include "{self.name}.h"', "", *self._rows(), HASH,
                          *self._near(), *self._main()])

    def _rows(self) -> list[str]:
        n, m, l = self.given.of.n, self.given.of.m, self.given.of.l
        controls = [f"{self.a.type} u[{l}];"] if l else []
        lines = []
        for t in range(ROWS):
            cells = [str(self.record.what[t]), str(self.record.present[t]),
                     *([self._list("controls", self.record.u[t])] if l else []),
                     self._list("measurements", self.record.z[t]),
                     f"{{{', '.join(self.a.literal(value) for value in self.ran.reading[t])}}}"]
            lines.append(f"{{{', '.join(cells)}}},")
        return ["static const struct {", *indented([
            f"unsigned char what; /* {PREDICTS}: predict, {UPDATES}: update */", "unsigned present;", *controls,
            f"{self.a.type} z[{m}], mean[{n}];"]), f"}} rows[{ROWS}] = {{", *indented(lines), "};", ""]

    def _list(self, which: str, values: Sequence[float]) -> str:
        return f"{{{', '.join(self.a.literal(self.a.raw(which, k, value)) for k, value in enumerate(values))}}}"

    def _near(self) -> list[str]:
        type_, arithmetic = self.a.type, self.given.options.arithmetic
        if arithmetic == "q31":
            return ["static int is_near(int32_t mean, int32_t expected)", "{", "    return mean == expected;", "}", ""]
        limit = self.a.literal(NEAR[arithmetic])
        return [f"static int is_near({type_} mean, {type_} expected, {type_} variance)", "{",
                f"    const {type_} apart = mean - expected;",
                f"    return apart * apart <= {limit} * {limit} * variance;", "}", ""]

    def _main(self) -> list[str]:
        name, some = self.name, f"{self.name}_update_some(&f, rows[t].z, rows[t].present)"
        update = some if self.given.of.m > 1 else f"{name}_update(&f, rows[t].z)"
        checks = []
        for i, state in enumerate(self.given.states):
            variance = "" if self.a.type == "int32_t" else f", {name}_variance_{state}(&f)"
            checks.append(f"wrong += !is_near({name}_mean_{state}(&f), rows[t].mean[{i}]{variance});")
        digests = [f"h = digest(h, {one}, sizeof {one});"
                   for one in (*(f"f.{field}" for field in self.a.arrays), *lag.kept(self.given))]
        follows = lag.followed(self.given)
        return ["int main(void)", "{", *indented([
            f"static {self.given.type} f;", "int wrong = 0;", "uint32_t h = UINT32_C(2166136261);", f"{name}_start(&f);", *follows[:1],
            f"for (unsigned t = 0; t < {ROWS}; t++) {{", *indented([
                f"if (rows[t].what == {PREDICTS | UPDATES} && rows[t].present == {self.given.all}) "
                f"{name}_step(&f{self.u}, rows[t].z);", "else {",
                f"    if (rows[t].what & {PREDICTS}) {name}_predict(&f{self.u});",
                f"    if (rows[t].what & {UPDATES}) {update};", "}", *checks, *follows[1:], *digests]), "}",
            f'printf("{name}: %d wrong, digest %08lx\\n", wrong, (unsigned long)h);', 'if (!wrong) puts("OK");',
            "return wrong != 0;"]), "}", ""]
