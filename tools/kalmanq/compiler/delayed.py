"""NAME_delayed: a filter that takes what was measured some steps ago, as if it had come in time.

The last steps are kept, with what moved the state and what was measured in each, and the filter as it was before them.  What
is late goes into its step, and all steps are worked out again from there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Sequence

from kalmanq.compiler.arithmetic import Arithmetic
from kalmanq.compiler.emit import Text, function, named, passed
from kalmanq.compiler.printing import indented
from kalmanq.compiler.request import Request
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import latest_of, steps_late

EVENT = ("TOO_LATE", "a measurement was of a step that is not kept, or a second one of its step: it was not taken")


@dataclass(frozen=True)
class Late:
    """A sensor's components first, first + 1, ..., and how many steps late they are; 0: in time"""

    name: str
    first: int
    size: int
    steps: int

    @property
    def bits(self) -> int:
        return ((1 << self.size) - 1) << self.first

    @property
    def said(self) -> str:
        return f"{self.steps} steps late" if self.steps else "in time"

    @property
    def ago(self) -> str:
        """Among the arguments of a call"""
        return ", ago" if self.steps else ""


class Delayed:
    """The texts.  arguments: of a predict, after the filter; kept: steps"""

    def __init__(self, given: Request, a: Arithmetic, arguments: str, kept: int, sensors: Sequence[Late]):
        self.given, self.a, self.name, self.type = given, a, given.name, f"{given.name}_delayed"
        self.arguments, self.kept, self.sensors = arguments, kept, sensors

    # ---- what a kind of filter has of its own

    answers = False  # does a predict refuse steps?
    has_clock = False  # of a test: do its rows have times?

    def fields(self) -> str:
        """What a step keeps beside z and present"""
        return _declared(self.arguments)

    def again(self) -> list[str]:
        """Lines: step k on f, and `taken`, the bits of what it took"""
        raise NotImplementedError

    def update_calls(self) -> list[str]:
        """Declarations with what they do"""
        raise NotImplementedError

    def update_functions(self) -> list[str]:
        raise NotImplementedError

    def moved(self) -> list[str]:
        """Lines before a predict of d->now"""
        return []

    def shared(self) -> list[str]:
        """Lines: what a program has set in d->now goes to d->before"""
        return []

    def usage_of_updates(self) -> list[tuple[str, str]]:
        raise NotImplementedError

    def in_time(self) -> list[str]:
        """Lines of a test: row t on in_time"""
        raise NotImplementedError

    def in_time_predict(self) -> list[str]:
        """The same of a predict alone"""
        raise NotImplementedError

    def late_predict(self, row: str) -> str:
        raise NotImplementedError

    def late_row(self, which: Late, row: str, ago: str) -> str:
        """The call of a test that gives a sensor's part of a row to d"""
        raise NotImplementedError

    # ---- NAME.h

    def ram(self, filter_: int, align: int) -> int:
        """Bytes of NAME_delayed, with filters of so many"""
        word = 8 if self.a.type == "double" else 4
        numbers = sum(int(size or 1) for _, size in named(self.fields()))
        step = -(-(word * (numbers + self.given.of.m) + 4) // word) * word
        return -(-(2 * filter_ + self.kept * step + 4) // align) * align

    def usage(self) -> list[tuple[str, str]]:
        """Calls, and what each is for"""
        name = self.name
        return [(f"static {self.type} d;", "in its place, for what comes late"), (f"{name}_start(&d.now);", "once"),
                (f"{name}_delayed_start(&d);", "then"), (f"{name}_delayed_predict(&d{passed(self.arguments)});", "to each step"),
                *self.usage_of_updates(), (f"{name}_mean_{self.given.carried[0]}(&d.now)", "the estimate")]

    def struct(self) -> list[str]:
        cells = ", ".join(filter(None, [self.fields(), f"z[{self.given.of.m}]"]))
        return [f"/* The last {self.kept} steps, and the filter before them */", "typedef struct {", *indented([
            f"{self.given.type} now, before;", "struct {", f"    {self.a.type} {cells};",
            f"    uint32_t present; /* bits of z; {self._bit()}: it began with a predict */", f"}} steps[{self.kept}];",
            "uint16_t count, newest;"]), f"}} {self.type};", ""]

    def calls(self) -> list[str]:
        name = self.name
        refuses = [" *  Returns 0 and changes nothing where dt is refused.  A, B and Q of a step follow from its dt; d->now.r[] is yours, and",
                   " *  holds for all steps that are kept. */"] if self.answers else []
        return [f"/** For measurements that come late: from d->now, which {name}_start or {name}_start_at began. */",
                f"void {name}_delayed_start({self.type} *d);", "",
                "/** To the next step.  It works out the oldest step again, too, which costs one more step." + ("" if refuses else " */"), *refuses,
                f"{self._answer()} {name}_delayed_predict({self.type} *d{self.arguments});", "", *self.update_calls()]

    def _answer(self) -> str:
        return "int" if self.answers else "void"

    def _bit(self) -> str:
        return f"{1 << self.given.of.m}u"

    # ---- NAME.c

    def functions(self) -> list[str]:
        return [*self._start(), *self._replay(), *self._replayed(), *self._place(), *self._predict(), *self.update_functions()]

    def _start(self) -> list[str]:
        return function(f"void {self.name}_delayed_start({self.type} *d)", [
            "d->before = d->now;", "d->steps[0].present = 0;", "d->count = 1;", "d->newest = 0;"])

    def _replay(self) -> list[str]:
        return function(f"static unsigned replay({self.given.type} *f, const {self.type} *d, unsigned k)", [
            f"const unsigned present = (unsigned)d->steps[k].present & {self.given.all}u;", *self.again(), "return taken;"], "Step k again")

    def _replayed(self) -> list[str]:
        return function(f"static unsigned replay_all({self.type} *d, unsigned k)", [
            f"unsigned taken = 0, at = d->newest + 1u >= d->count ? d->newest + 1u - d->count : d->newest + {self.kept + 1}u - d->count;",
            "const uint16_t events = d->now.events;", *self.shared(), "d->now = d->before;", "for (unsigned step = 0; step < d->count; step++) {",
            "    const unsigned made = replay(&d->now, d, at);", "    if (at == k) taken = made;",
            f"    at = at + 1u < {self.kept}u ? at + 1u : 0;", "}", "d->now.events |= events;", "return taken;"],
            "All steps again; what step k took")

    def _place(self) -> list[str]:
        return function(f"static unsigned place({self.type} *d, unsigned present, unsigned ago)", [
            f"const unsigned k = d->newest >= ago ? d->newest - ago : d->newest + {self.kept}u - ago;",
            "if (ago < d->count && !(d->steps[k].present & present)) return k;",
            f"d->now.events |= {self.given.upper}_TOO_LATE;", f"return {self.kept}u;"],
            f"Where the step `ago` steps before now is kept; {self.kept} where no step has room")

    def _predict(self) -> list[str]:
        keep = [line for name, size in named(self.arguments) for line in (
            [f"for (unsigned i = 0; i < {size}u; i++) d->steps[k].{name}[i] = {name}[i];"] if size else [f"d->steps[k].{name} = {name};"])]
        return function(f"{self._answer()} {self.name}_delayed_predict({self.type} *d{self.arguments})", [
            f"const unsigned k = d->newest + 1u < {self.kept}u ? d->newest + 1u : 0;", *self.moved(),
            f"if (d->count == {self.kept}u) {{", *indented(self.shared()), "    (void)replay(&d->before, d, k);", "    d->before.events = 0;", "} else d->count++;",
            "d->newest = (uint16_t)k;", *keep, f"d->steps[k].present = {self._bit()};", *self.predicts(),
            *(["return 1;"] if self.answers else [])])

    def predicts(self) -> list[str]:
        return [f"{self.name}_predict(&d->now{passed(self.arguments)});"]


def _declared(arguments: str) -> str:
    """In a struct"""
    return ", ".join(f"{name}[{size}]" if size else name for name, size in named(arguments))


# ------------------------------------------------------------------------------ constant matrices


def delayed(given: Request, a: Arithmetic, text: Text) -> Optional[Delayed]:
    """Of a model with delays"""
    if not latest_of(given.model):
        return None
    if given.options.lag:
        raise KalmanqError("--lag: and a sensor with a delay: the means that --lag keeps would not know of what comes late")
    if given.options.tunable and given.model.continuous is None:
        raise KalmanqError("--tunable: and a sensor with a delay: fields that a program changes are not kept with the steps; of a model "
                           "with F, Qc and dt the dt of each step is")
    return LinearDelayed(given, a, text)


class LinearDelayed(Delayed):
    def __init__(self, given: Request, a: Arithmetic, text: Text):
        self.answers, self.u = given.options.tunable, text.u
        late = zip(given.sensors, steps_late(given.model, self.answers))
        super().__init__(given, a, text.u + (f", {a.type} dt" if self.answers else ""), latest_of(given.model) + 1,
                         [Late(*sensor, steps) for sensor, steps in late])
        self.z = f"{text.z}, unsigned present, unsigned ago"

    def again(self) -> list[str]:
        move = [f"    (void){self.name}_move(f, d->steps[k].dt);"] if self.answers else []
        return [f"if (d->steps[k].present & {self._bit()}) {{", *move, f"    {self.name}_predict(f{passed(self.u, 'd->steps[k].')});", "}",
                f"const unsigned taken = present ? {self._update('f', 'd->steps[k].z', 'present')} : 0;"]

    def _update(self, f: str, z: str, present: str) -> str:
        return f"{self.name}_update_some({f}, {z}, {present})" if self.given.of.m > 1 else f"{self.name}_update({f}, {z})"

    def moved(self) -> list[str]:
        return [f"if (!{self.name}_move(&d->now, dt)) return 0;"] if self.answers else []

    def shared(self) -> list[str]:
        return [f"for (int j = 0; j < {self.given.of.m}; j++) d->before.r[j] = d->now.r[j];"] if self.answers else []

    def predicts(self) -> list[str]:
        return [f"{self.name}_predict(&d->now{passed(self.u)});"]

    def usage_of_updates(self) -> list[tuple[str, str]]:
        return [(f"{self.name}_delayed_update_{one.name}(&d, {one.name}{one.ago});", one.said) for one in self.sensors] or \
            [(f"{self.name}_delayed_update(&d, z, 1, ago);", "what was measured `ago` steps before")]

    def update_calls(self) -> list[str]:
        name = self.name
        lines = [f"/** Takes what was measured `ago` steps before now, 0 to {self.kept - 1}.  d->now is then what it would be if all had",
                 f" *  come in time.  Costs an update, and {self.kept} steps where `ago` is not 0.  One value of each component in a",
                 " *  step.  Returns the bits of what it took. */", f"unsigned {name}_delayed_update({self.type} *d, {self.z});", ""]
        for one in self.sensors:
            lines += [f"/** What {one.name} has measured{f' {one.steps} steps late, or up to {self.kept - 1}' if one.steps else ', in time'}. */",
                      f"unsigned {self._of_sensor(one)};", ""]
        return lines

    def _of_sensor(self, one: Late) -> str:
        return f"{self.name}_delayed_update_{one.name}({self.type} *d, const {self.a.type} z[{one.size}]{', unsigned ago' if one.steps else ''})"

    def update_functions(self) -> list[str]:
        m, all_ = self.given.of.m, self.given.all
        lines = function(f"unsigned {self.name}_delayed_update({self.type} *d, {self.z})", [
            f"present &= {all_}u;", "const unsigned k = place(d, present, ago);", f"if (k == {self.kept}u || !present) return 0;",
            f"for (unsigned j = 0; j < {m}u; j++)", "    if (present >> j & 1u) d->steps[k].z[j] = z[j];",
            "d->steps[k].present |= present;", f"return ago ? replay_all(d, k) & present : {self._update('&d->now', 'z', 'present')};"])
        for one in self.sensors:
            cells = [f"z[{k - one.first}]" if one.bits >> k & 1 else self.a.zero for k in range(m)]
            down = f" >> {one.first}" if one.first else ""
            lines += function(f"unsigned {self._of_sensor(one)}", [
                f"const {self.a.type} all[{m}] = {{{', '.join(cells)}}};",
                f"return {self.name}_delayed_update(d, all, {one.bits}u, {'ago' if one.steps else '0'}){down};"])
        return lines

    def in_time(self) -> list[str]:
        return [*(f"if (t) {one}" for one in self.in_time_predict()), f"(void){self._update('&in_time', 'rows[t].z', f'{self.given.all}u')};"]

    def in_time_predict(self) -> list[str]:
        move = [f"(void){self.name}_move(&in_time{self._dt()});"] if self.answers else []
        return [*move, f"{self.name}_predict(&in_time{', rows[t].u' if self.given.inputs else ''});"]

    def _dt(self) -> str:
        return f", {self.a.literal(self.given.model.continuous.dt)}" if self.answers else ""

    def late_predict(self, row: str) -> str:
        return f"{'(void)' if self.answers else ''}{self.name}_delayed_predict(&d{f', rows[{row}].u' if self.given.inputs else ''}{self._dt()});"

    def late_row(self, which: Late, row: str, ago: str) -> str:
        return f"(void){self.name}_delayed_update(&d, rows[{row}].z, {which.bits}u, {ago});"
