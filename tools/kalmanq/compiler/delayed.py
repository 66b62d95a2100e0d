"""NAME_delayed: a filter that takes what was measured some steps ago, as if it had come in time.

The last steps are kept, with what moved the state and what was measured in each, and the filter as it was before them.  What
is late goes into its step, and all steps are worked out again from there.
"""

from __future__ import annotations

from typing import Optional

from kalmanq.compiler.arithmetic import Arithmetic
from kalmanq.compiler.emit import Text, function
from kalmanq.compiler.printing import indented
from kalmanq.compiler.request import Request
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import latest_of, steps_late

EVENT = ("TOO_LATE", "a measurement was of a step that is not kept, or a second one of its step: it was not taken")


def delayed(given: Request, a: Arithmetic, text: Text) -> Optional[Delayed]:
    """Of a model with delays"""
    if not latest_of(given.model):
        return None
    if given.options.lag:
        raise KalmanqError("--lag: and a sensor with a delay: the means that --lag keeps would not know of what comes late")
    if given.options.tunable and given.model.continuous is None:
        raise KalmanqError("--tunable: and a sensor with a delay: fields that a program changes are not kept with the steps; of a model "
                           "with F, Qc and dt the dt of each step is")
    return Delayed(given, a, text)


class Delayed:
    """The texts"""

    def __init__(self, given: Request, a: Arithmetic, text: Text):
        self.given, self.a, self.name, self.type = given, a, given.name, f"{given.name}_delayed"
        self.kept = latest_of(given.model) + 1
        self.varies = given.options.tunable
        self.u = text.u + (f", {a.type} dt" if self.varies else "")
        self.z = f"{text.z}, unsigned present, unsigned ago"
        self.sensors = list(zip(given.sensors, steps_late(given.model, self.varies)))

    @property
    def bits(self) -> int:
        """Of the components that are late, where sensors have names"""
        return sum(((1 << size) - 1) << first for (_, first, size), late in self.sensors if late)

    def ram(self, filter_: int, align: int) -> int:
        """Bytes of NAME_delayed, with filters of so many"""
        word = 8 if self.a.type == "double" else 4
        step = -(-(word * (self.given.inputs + self.given.of.m + self.varies) + 4) // word) * word
        return -(-(2 * filter_ + self.kept * step + 4) // align) * align

    # ---- NAME.h

    def usage(self) -> list[tuple[str, str]]:
        """Calls, and what each is for"""
        name, given = self.name, "".join([", u" if self.given.inputs else "", ", dt" if self.varies else ""])
        takes = [(f"{name}_delayed_update_{sensor}(&d, {sensor}{', ago' if late else ''});", f"{late} steps late" if late else "in time")
                 for (sensor, _, _), late in self.sensors] or [(f"{name}_delayed_update(&d, z, 1, ago);", "what was measured `ago` steps before")]
        return [(f"static {self.type} d;", "in its place, for what comes late"), (f"{name}_start(&d.now);", "once"),
                (f"{name}_delayed_start(&d);", "then"), (f"{name}_delayed_predict(&d{given});", "to each step"), *takes,
                (f"{name}_mean_{self.given.carried[0]}(&d.now)", "the estimate")]

    def struct(self) -> list[str]:
        l, m, type_ = self.given.inputs, self.given.of.m, self.a.type
        cells = [*([f"u[{l}]"] if l else []), *(["dt"] if self.varies else []), f"z[{m}]"]
        return [f"/* The last {self.kept} steps, and the filter before them */", "typedef struct {", *indented([
            f"{self.given.type} now, before;", "struct {", f"    {type_} {', '.join(cells)};",
            f"    uint32_t present; /* bits of z; {self._bit()}: it began with a predict */", f"}} steps[{self.kept}];",
            "uint16_t count, newest;"]), f"}} {self.type};", ""]

    def calls(self) -> list[str]:
        name = self.name
        lines = [f"/** For measurements that come late: from d->now, which {name}_start or {name}_start_at began. */",
                 f"void {name}_delayed_start({self.type} *d);", "",
                 "/** To the next step.  It works out the oldest step again, too, which costs one more step."]
        lines += [" *  Returns 0 and changes nothing where dt is refused. */"] if self.varies else []
        lines[-1] += "" if self.varies else " */"
        lines += [f"{'int' if self.varies else 'void'} {name}_delayed_predict({self.type} *d{self.u});", "",
                  f"/** Takes what was measured `ago` steps before now, 0 to {self.kept - 1}.  d->now is then what it would be if all had",
                  f" *  come in time.  Costs an update, and {self.kept} steps where `ago` is not 0.  One value of each component in a",
                  " *  step.  Returns the bits of what it took. */",
                  f"unsigned {name}_delayed_update({self.type} *d, {self.z});", ""]
        for (sensor, _, size), late in self.sensors:
            said = f" {late:g} steps late, or up to {self.kept - 1}" if late else ", in time"
            lines += [f"/** What {sensor} has measured{said}. */",
                      f"unsigned {self._of_sensor(sensor, size, late)};", ""]
        return lines

    def _of_sensor(self, sensor: str, size: int, late: float) -> str:
        return f"{self.name}_delayed_update_{sensor}({self.type} *d, const {self.a.type} z[{size}]{', unsigned ago' if late else ''})"

    def _bit(self) -> str:
        return f"{1 << self.given.of.m}u"

    # ---- NAME.c

    def functions(self) -> list[str]:
        return [*self._start(), *self._replay(), *self._predict(), *self._update(), *self._updates()]

    def _start(self) -> list[str]:
        return function(f"void {self.name}_delayed_start({self.type} *d)", [
            "d->before = d->now;", "d->steps[0].present = 0;", "d->count = 1;", "d->newest = 0;"])

    def _replay(self) -> list[str]:
        name, all_, u = self.name, self.given.all, ", d->steps[k].u" if self.given.inputs else ""
        move = [f"    (void){name}_move(f, d->steps[k].dt);"] if self.varies else []
        update = f"{name}_update_some(f, d->steps[k].z, present)" if self.given.of.m > 1 else f"{name}_update(f, d->steps[k].z)"
        return function(f"static unsigned replay({self.given.type} *f, const {self.type} *d, unsigned k)", [
            f"const unsigned present = (unsigned)d->steps[k].present & {all_}u;",
            f"if (d->steps[k].present & {self._bit()}) {{", *move, f"    {name}_predict(f{u});", "}",
            f"return present ? {update} : 0;"], "Step k again")

    def _predict(self) -> list[str]:
        name, l = self.name, self.given.inputs
        move = [f"if (!{name}_move(&d->now, dt)) return 0;"] if self.varies else []
        keep = [*(f"d->steps[k].u[{i}] = u[{i}];" for i in range(l)), *(["d->steps[k].dt = dt;"] if self.varies else [])]
        return function(f"{'int' if self.varies else 'void'} {name}_delayed_predict({self.type} *d{self.u})", [
            f"const unsigned k = d->newest + 1u < {self.kept}u ? d->newest + 1u : 0;", *move,
            f"if (d->count == {self.kept}u) {{", "    (void)replay(&d->before, d, k);", "    d->before.events = 0;", "} else d->count++;", "d->newest = (uint16_t)k;", *keep,
            f"d->steps[k].present = {self._bit()};", f"{name}_predict(&d->now{', u' if l else ''});",
            *(["return 1;"] if self.varies else [])])

    def _update(self) -> list[str]:
        name, m, all_ = self.name, self.given.of.m, self.given.all
        now = f"{name}_update_some(&d->now, z, present)" if m > 1 else f"{name}_update(&d->now, z)"
        return function(f"unsigned {name}_delayed_update({self.type} *d, {self.z})", [
            f"const unsigned first = d->newest + 1u >= d->count ? d->newest + 1u - d->count : d->newest + {self.kept + 1}u - d->count;",
            f"const unsigned k = d->newest >= ago ? d->newest - ago : d->newest + {self.kept}u - ago;",
            f"present &= {all_}u;", "if (ago >= d->count || (d->steps[k].present & present)) {",
            f"    d->now.events |= {self.given.upper}_TOO_LATE;", "    return 0;", "}", "if (!present) return 0;",
            f"for (unsigned j = 0; j < {m}u; j++)", "    if (present >> j & 1u) d->steps[k].z[j] = z[j];",
            "d->steps[k].present |= present;", f"if (!ago) return {now};",
            "unsigned taken = 0;", "const uint16_t events = d->now.events;", "d->now = d->before;",
            "for (unsigned step = 0, at = first; step < d->count; step++) {",
            "    const unsigned made = replay(&d->now, d, at);", "    if (at == k) taken = made & present;",
            f"    at = at + 1u < {self.kept}u ? at + 1u : 0;", "}", "d->now.events |= events;", "return taken;"])

    def _updates(self) -> list[str]:
        lines = []
        for (sensor, first, size), late in self.sensors:
            cells = [f"z[{k - first}]" if first <= k < first + size else self.a.zero for k in range(self.given.of.m)]
            lines += function(f"unsigned {self._of_sensor(sensor, size, late)}", [
                f"const {self.a.type} all[{self.given.of.m}] = {{{', '.join(cells)}}};",
                f"return {self.name}_delayed_update(d, all, {((1 << size) - 1) << first}u, {'ago' if late else '0'}){f' >> {first}' if first else ''};"])
        return lines

