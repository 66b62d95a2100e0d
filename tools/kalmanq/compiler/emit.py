"""NAME.c of a filter: start, predict, update, step, and the readings of its covariance.

`calls` counts predict and full update in turn, so an even number is "updated" and an odd one "predicted".  From SETTLED
on it stays: the covariance is the steady one, and the mean is corrected by the constant gain.  Anything else (a sample
that is missing, or in part, or a second update) leaves the steady state and goes on with the factor from there.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Sequence

from kalmanq.compiler import lag
from kalmanq.compiler.arithmetic import Arithmetic
from kalmanq.compiler.printing import indented
from kalmanq.compiler.request import LONGEST_GAP, Request

NO_FAST_MATH = """\
#if defined __FAST_MATH__ || defined __ASSOCIATIVE_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__)
#error "sums as written, and NaN: no -ffast-math, -funsafe-math-optimizations, -fassociative-math or -ffinite-math-only"
#endif
"""
SHORT_DOUBLE = """\
#if defined __SIZEOF_DOUBLE__ && __SIZEOF_DOUBLE__ < 8
#error "a double is no longer than a float here (AVR): use --arith f32"
#endif
"""


PREDICTS, UPDATES = 1, 2  # of a row


@dataclass(frozen=True)
class Row:
    """What a row of a record is called in C.  what: PREDICTS and UPDATES; present: bits; u: controls of the step to the row;
    now: of the row itself; left: t of the row before, step: the time between them; t: of the row; taken: gets bits"""

    what: str
    present: str
    z: str
    u: str
    now: str
    left: str
    step: str
    t: str
    taken: str


class Text:
    """The functions of a filter, one after the other.  counter: a field of the struct, and what it starts with"""

    counter = ("gap", "0")

    def __init__(self, given: Request, a: Arithmetic):
        self.given, self.a = given, a
        self.filter = f"{given.type} *restrict f"
        self.u = f", const {a.type} u[{given.inputs}]" if given.inputs else ""
        self.z = f"const {a.type} z[{given.of.m}]"
        self.settles = a.steady is not None

    def parts(self) -> list[list[str]]:
        """Its functions"""
        return [self._leave(), self._start(), self._start_at(), self._control(), self.a.hold(), self._predict(), self._taken(),
                self._update(), self._update_some(), self._updates_of_sensors(), self._step(), self._covariance()]

    def code(self, remarks: Sequence[str]) -> str:
        parts = [*self.parts(), self.a.functions(), lag.functions(self.given, self.a, self.a.steady)]
        body = "\n".join(line for part in parts for line in part)
        words = (NO_FAST_MATH if self.a.type != "int32_t" else "") + (SHORT_DOUBLE if self.a.type == "double" else "")
        return "\n".join([*comment(remarks), f'#include "{self.given.name}.h"', "", *self.a.code_includes, words + self.a.routines(body)
                          + self._constants() + body])

    # ---- settled

    def _constants(self) -> str:
        if not self.settles:
            return ""
        updated, predicted = (self.a.factor_literals(P) for P in (self.a.steady.filtered, self.a.steady.predicted))
        rest = ", ".join(str(one) for one in self._rests())
        size = max(len(self.a.live), 1)
        return "\n".join([
            f"#define SETTLED UINT32_C({2 * self.a.steady.samples}) /* calls: {self.a.steady.samples} full samples */",
            f"static const {self.a.type} steady[2][{size}] = {{ /* updated, predicted */",
            f"    {{{', '.join(updated) or '0'}}},", f"    {{{', '.join(predicted) or '0'}}}}};",
            "/* Full samples until the gain is constant again, after 1, 2, ... missing ones */",
            f"static const {self._rest_type()} after_gap[{len(self._rests())}] = {{{rest}}};", "", ""])

    def _rests(self) -> Sequence[int]:
        return self.a.steady.after_gap[:LONGEST_GAP]

    def _rest_type(self) -> str:
        return "uint16_t" if max(self._rests()) < 1 << 16 else "uint32_t"

    def _leave(self) -> list[str]:
        if not self.settles:
            return []
        size = max(len(self.a.live), 1)
        return function(f"static void leave({self.filter}, uint16_t gap)", [
            f"const {self.a.type} *from = steady[f->calls & 1u];",
            f"for (int i = 0; i < {size}; i++) f->P[i] = from[i];", "f->calls &= 1u;", "f->gap = gap;"],
            "From the steady state on, the factor is carried again.")

    # ---- start

    def count_fields(self) -> list[str]:
        return ["uint32_t calls; /* predict and full update in turn */", f"uint16_t {self.counter[0]};"]

    def _reset_counts(self) -> list[str]:
        return ["f->calls = 0;", f"f->{self.counter[0]} = {self.counter[1]};"]

    def _reset(self) -> list[str]:
        options = self.given.options
        lines = [*self._reset_counts(), "f->events = 0;"]
        if options.nis:
            lines += ["f->nis = 0;", *(f"f->s[{j}] = 0;" for j in range(self.a.slots))]
        if options.gate is not None:
            lines += [f"f->rejected[{j}] = 0;" for j in range(self.given.of.m)]
        return lines + ([f"f->y[{j}] = 0;" for j in range(self.given.of.m)] if options.lag else [])

    def _start(self) -> list[str]:
        return function(f"void {self.given.name}_start({self.filter})", [*self.a.start(), *self._reset()])

    def _start_at(self) -> list[str]:
        lines = [*self.a.start_at(), *self._reset(), *self.a.started_at()]
        return function(self.start_at_head(self.filter), lines)

    def start_at_head(self, filter_: str) -> str:
        return f"int {self.given.name}_start_at({filter_}, const {self.a.type} mean[{len(self.given.carried)}], " \
               f"const {self.a.type} sigma[{self.given.of.n}])"

    # ---- predict

    def _control(self) -> list[str]:
        if not self.given.inputs:
            return []
        type_, zero = self.a.type, self.a.zero
        low = f"u > INT32_MIN ? -most : {zero}" if type_ == "int32_t" else f"u < {zero} ? -most : {zero}"
        return function(f"static {type_} control({self.filter}, {type_} u, {type_} most)", [
            "if (u >= -most && u <= most) return u;", f"f->events |= {self.given.upper}_CONTROL_REFUSED;",
            f"return u > {zero} ? most : {low};"], "A control, or the nearer end of its range; 0 for NaN")

    def _controls(self) -> list[str]:
        given = [f"control(f, u[{k}], {self.a.most_control(k)})" for k in range(self.given.inputs)]
        return [f"const {self.a.type} u{k} = {one};" for k, one in enumerate([*given, *(self.a.one for _ in range(self.given.of.l - len(given)))])]

    def _predict(self) -> list[str]:
        a = self.a
        lines = [*self._controls(), *within(a.places(factor=False), block(a.predict_mean()))]
        lines += self._count_predict() if self.settles else []
        lines += [*within(a.places(mean=False), block(a.predict_factor())), *a.within_numbers()]
        return function(f"void {self.given.name}_predict({self.filter}{self.u})", lines)

    def _count_predict(self) -> list[str]:
        return ["if (f->calls == SETTLED) {", "    f->calls++;", "    return;", "}",
                "if (f->calls > SETTLED) leave(f, 1);", "else if (!(f->calls & 1u)) f->calls++;", "else {",
                "    f->calls = 1;", f"    f->gap = f->gap && f->gap < {len(self._rests())} ? "
                "(uint16_t)(f->gap + 1u) : 0;", "}"]

    # ---- update

    def _accepted(self) -> str:
        return " | ".join(f"({self.a.accepts(j)} ? {1 << j}u : 0u)" for j in range(self.given.of.m))

    def _whole_groups(self) -> list[str]:
        """Components with correlated noises are taken together."""
        groups = {group for group in self.given.together if group & (group - 1)}
        return [f"if ((taken & {group}u) != {group}u) taken &= ~{group}u;" for group in sorted(groups)]

    def _refused(self, wanted: str) -> str:
        return f"if (taken != {wanted}) f->events |= {self.given.upper}_REFUSED;"

    def _measured(self) -> list[str]:
        return [f"const {self.a.type} z{j} = {self.a.mixed(j)};" for j in range(self.given.of.m)]

    def _settled_lines(self, predicts: bool) -> list[str]:
        """Of a full sample, once settled; it returns."""
        gates = range(self.given.of.m) if self.given.options.gate is not None else ()
        counted = [] if predicts else ["f->calls = SETTLED;"]
        ends = [*(f"f->rejected[{j}] = 0;" for j in gates), *counted, f"return {self.given.all}u;"]
        mark = "/* store */"
        body = self.a.settled(predicts, [mark, *ends])
        return [*self._measured(), *within(self.a.places(factor=False), body, mark)]

    def _taken(self) -> list[str]:
        """static: the components whose bits are set"""
        given, a = self.given, self.a
        lines = [f"f->nis = {a.zero};"] if given.options.nis else []
        lines += ["if (!taken) return 0;"]
        lines += self._leave_before() if self.settles else []
        body: list[str] = []
        for j in range(given.of.m):
            head = f"if (taken & {1 << j}u) {{" if given.of.m > 1 else "{"
            body += [f"{head} /* {given.measurements[j]} */", *indented(a.update(j)), "}"]
        lines += [*self._measured(), *within(a.places(), body)]
        lines += self._count_update() if self.settles else []
        return function(f"static unsigned take({self.filter}, {self.z}, unsigned taken)", [*lines, "return taken;"])

    def _leave_before(self) -> list[str]:
        return ["if (f->calls >= SETTLED) leave(f, 0);"]

    def _count_update(self) -> list[str]:
        return [f"if (taken != {self.given.all}u || !(f->calls & 1u)) f->calls = 0;",
                "else if (f->gap) f->calls = SETTLED + 2u - UINT32_C(2) * after_gap[f->gap - 1];", "else f->calls++;",
                "f->gap = 0;"]

    def _update(self) -> list[str]:
        given = self.given
        lines = [f"{'unsigned' if self._whole_groups() else 'const unsigned'} taken = {self._accepted()};",
                 *self._whole_groups()]
        if self.settles:
            lines += [f"if (taken == {given.all}u && f->calls == SETTLED + 1u) {{",
                      *indented(self._settled_lines(False)), "}"]
        lines += [self._refused(f"{given.all}u"), "return take(f, z, taken);"]
        return function(f"unsigned {given.name}_update({self.filter}, {self.z})", lines)

    def _update_some(self) -> list[str]:
        given = self.given
        if given.of.m == 1:
            return []
        lines = [f"present &= {given.all}u;", f"unsigned taken = present & ({self._accepted()});",
                 *self._whole_groups(), self._refused("present"),
                 f"return taken == {given.all}u ? {given.name}_update(f, z) : take(f, z, taken);"]
        return function(f"unsigned {given.name}_update_some({self.filter}, {self.z}, unsigned present)", lines)

    def _updates_of_sensors(self) -> list[str]:
        given, lines = self.given, []
        for name, first, size in given.sensors:
            cells = [f"z[{k - first}]" if first <= k < first + size else self.a.zero for k in range(given.of.m)]
            lines += function(f"unsigned {given.name}_update_{name}({self.filter}, const {self.a.type} z[{size}])", [
                f"const {self.a.type} all[{given.of.m}] = {{{', '.join(cells)}}};",
                f"return {given.name}_update_some(f, all, {((1 << size) - 1) << first}u){f' >> {first}' if first else ''};"])
        return lines

    def _step(self) -> list[str]:
        given, u = self.given, ", u" if self.given.inputs else ""
        lines: list[str] = []
        if self.settles:
            all_ = " && ".join(f"{self.a.accepts(j)}" for j in range(given.of.m))
            lines = [f"if (f->calls == SETTLED && {all_}) {{",
                     *indented([*self._controls(), *self._settled_lines(True)]), "}"]
        lines += [f"{given.name}_predict(f{u});", f"return {given.name}_update(f, z);"]
        return function(f"unsigned {given.name}_step({self.filter}{self.u}, {self.z})", lines)

    def row(self, of: Row) -> list[str]:
        """The calls of a row, for programs that run a record"""
        name, m = self.given.name, self.given.of.m
        u = f", {of.u}" if self.given.inputs else ""
        whole = f"{name}_update(&f, {of.z})"
        some = f"{of.present} == {self.given.all} ? {whole} : {name}_update_some(&f, {of.z}, {of.present})" if m > 1 else whole
        return [f"if ({of.what} == {PREDICTS | UPDATES} && {of.present} == {self.given.all}) {of.taken} = {name}_step(&f{u}, {of.z});",
                "else {", f"    if ({of.what} & {PREDICTS}) {name}_predict(&f{u});",
                f"    if ({of.what} & {UPDATES}) {of.taken} = {some};", "}"]

    # ---- readings

    def _factor(self) -> str:
        return "f->calls >= SETTLED ? steady[f->calls & 1u] : f->P"

    def _covariance(self) -> list[str]:
        type_ = self.a.type
        factor = self._factor() if self.settles else "f->P"
        lines = self.a.covariance()
        return function(f"{self.a.covariance_type} {self.given.name}_covariance(const {self.given.type} *f, int i, int j)",
                        [*([f"const {type_} *P = {factor};"] if any("P[" in one for one in lines) else []), *lines])


def function(head: str, body: Sequence[str], remark: str = "") -> list[str]:
    used = _used(body)
    unused = [f"(void){name};" for name in re.findall(r"(\w+)(?:\[\d+\])?[,)]", head) if not _mentions(used, name)]
    return [*([f"/* {remark} */"] if remark else []), head, "{", *indented([*unused, *used]), "}", ""]


def passed(arguments: str, of: str = "") -> str:
    """Arguments of a function as they are passed on; of: where they are"""
    return "".join(f", {of}{name}" for name, _ in named(arguments))


def named(arguments: str) -> list[tuple[str, str]]:
    """Names, and lengths of arrays"""
    return re.findall(r"(\w+)(?:\[(\d+)\])?(?=,|$)", arguments)


def _used(body: Sequence[str]) -> list[str]:
    """Without measurements that a row of zeros does not read; a control is looked at all the same"""
    made = []
    for line in body:
        found = re.fullmatch(r"( *)const \w+ ([zu]\d+) = (.*);", line)
        if found is None or sum(_mentions([other], found[2]) for other in body) > body.count(line):
            made.append(line)
        elif found[2][0] == "u":
            made.append(f"{found[1]}(void){found[3]};")
    return made


def _mentions(lines: Sequence[str], name: str) -> bool:
    return any(re.search(rf"\b{name}\b", line.split("/*")[0]) for line in lines)


def within(places: Sequence[tuple[str, str, str]], body: Sequence[str], mark: str = "") -> list[str]:
    """The body between loads of what it reads and stores of what it writes; mark: the line of the body that becomes the
    stores"""
    text = "\n".join(body)
    loads = [f"{'' if _writes(text, local) else 'const '}{type_} {local} = {field};" for type_, local, field in places
             if re.search(rf"\b{local}\b", text)]
    stores = [f"{field} = {local};" for _, local, field in places if _writes(text, local)]
    if not mark:
        return [*loads, *body, *stores]
    at = next(k for k, line in enumerate(body) if line.strip() == mark)
    room = body[at][:len(body[at]) - len(mark)]
    return [*loads, *body[:at], *(room + one for one in stores), *body[at + 1:]]


def _writes(text: str, local: str) -> bool:
    return re.search(rf"^\s*{local} [-+]?= ", text, re.M) is not None


def block(lines: Sequence[str]) -> list[str]:
    return ["{", *indented(lines), "}"]


def comment(lines: Sequence[str]) -> list[str]:
    return ["/*", *(f" * {line}".rstrip() for line in lines), " */"]
