"""NAME.h of a filter: what it is of, its words, its calls and its readings."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from kalmanq.compiler.proven import lag_text
from kalmanq.compiler.printing import indented
from kalmanq.compiler.proven.plan import LARGEST, Plan, bookkeeping, events as events_of
from kalmanq.firmware.c_source import plain


def comment(plan: Plan, remarks: Sequence[str]) -> list[str]:
    m = plan.model
    what = f"{plan.name}: {m.n} states, {m.m} measurements, {m.l} controls, in " \
           f"{'q31' if plan.subject.words.is_fixed else 'f32'}, written by kalmanq compile."
    return ["/*", *(f" * {line}".rstrip() for line in (what, *remarks)), " */"]


def header(plan: Plan) -> str:
    lines = [*comment(plan, ["", *usage(plan), "", *quantities(plan)]), f"#ifndef KALMANQ_COMPILED_{plan.upper}_H",
             f"#define KALMANQ_COMPILED_{plan.upper}_H", "", *includes(plan), "",
             "#ifdef __cplusplus", 'extern "C" {', "#endif", "",
             *(["void probe(int line, long long value);", ""] if plan.probes else []), *events(plan), *points(plan), *fields(plan),
             *calls(plan), *readings(plan), *lag_text.calls(plan), "#ifdef __cplusplus", "}", "#endif", "",
             "#endif", ""]
    return "\n".join(lines).replace("*restrict ", "*")  # a word that C++ lacks, and a declaration does not need


def includes(plan: Plan) -> list[str]:
    has_logarithms = plan.nis and not plan.subject.words.is_fixed
    return [*(["#include <math.h>"] if has_logarithms else []), "#include <stdint.h>"]


def usage(plan: Plan) -> list[str]:
    u = ", u" if plan.model.l else ""
    rows = [(f"static {plan.type} f;", ""), (f"{plan.name}_start(&f);", "once"),
            (f"{plan.name}_update(&f, z);", "the first sample"), (f"{plan.name}_step(&f{u}, z);", "each other one"),
            (f"{plan.name}_predict(&f{u});", "one that is missing"),
            (f"{plan.name}_mean_{plan.subject.states[0]}(&f)", "what it says")]
    width = max(len(call) for call, _ in rows) + 4
    return [f"    {call:<{width}}{what}" for call, what in rows]


def quantities(plan: Plan) -> list[str]:
    """A table of what things are called, their units and, in fixed point, their points and bounds."""
    fixed = plan.subject.words.is_fixed
    rows = [("", "name", "unit", *(("format", "at most") if fixed else ("range",)))]
    for which in ("states", "measurements", "controls"):
        for k, one in enumerate(getattr(plan.model, which)):
            span = f"{one.range:g}" if one.range else ""
            if fixed:
                fraction = plan.fraction(which, k)
                rows.append((f"{which[:-1]} {k}", plain(one.name), plain(one.unit), f"Q{31 - fraction}.{fraction}",
                             f"{plan.bounds[k]:.4g}" if which == "states" and plan.bounds else span))
            else:
                rows.append((f"{which[:-1]} {k}", plain(one.name), plain(one.unit), span))
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["    " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)).rstrip() for row in rows]


def events(plan: Plan) -> list[str]:
    rows = [f"{plan.upper}_{name} = {1 << bit}" for bit, name in enumerate(events_of(plan))]
    said = [f"{row}{',' if row != rows[-1] else ''} /* {what} */" for row, what in zip(rows, events_of(plan).values())]
    return ["/* f->events: bits that stay set until you clear them */", "enum {", *indented(said), "};", ""]


def points(plan: Plan) -> list[str]:
    if not plan.subject.words.is_fixed:
        return []
    s, rows = plan.subject, []
    for letter, which, names in (("", "states", s.states), ("Z_", "measurements", s.measurements),
                                 ("U_", "controls", s.controls)):
        rows += [f"    {plan.upper}_{letter}{name.upper()}_FRACTION = {plan.fraction(which, k)}"
                 for k, name in enumerate(names)]
    rows += [f"    {plan.upper}_VARIANCE_{s.states[i].upper()}_FRACTION = {s.words.covariance(i, i)}"
             for i in range(s.of.n) if plan.carries_covariance]
    if plan.nis:
        rows += [f"    {plan.upper}_NIS_FRACTION = {s.words.formats.nis}"]
        rows += [f"    {plan.upper}_S_{one.upper()}_FRACTION = {s.words.variance(j)}"
                 for j, one in enumerate(s.measurements)]
    return ["/* value = word 2^-FRACTION */", "enum {", *(f"{row}," for row in rows[:-1]), rows[-1], "};", ""]


def fields(plan: Plan) -> list[str]:
    s = plan.subject
    lines = [f"{type_} {name};" for type_, name in bookkeeping(plan)]
    lines += [f"{type_} {name};" for i in range(s.of.n) for name, type_ in s.mean.fields(i)]
    lines += [f"{s.words.type} {plan.field(key)};" for key in plan.structure.carried]
    if plan.nis:
        lines += [f"{'int64_t' if s.words.is_fixed else 'float'} nis;",
                  *(f"{s.words.type} s_{one};" for one in s.measurements)]
    lines += [f"{s.words.type} {name};" for name in lag_text.innovations(plan)]
    return ["typedef struct {", *indented(lines), f"}} {plan.type};", "", *lag_text.struct(plan)]


def calls(plan: Plan) -> list[str]:
    name, type_ = plan.name, f"{plan.type} *restrict f"
    missed = f"At most {plan.max_gap} in a row are to be missing" if plan.max_gap else "None is to be missing"
    between = f", {plan.min_run} between two gaps" if plan.max_gap else ""
    stays = "the covariance stays where it is" if plan.carries_covariance else "the gain is not for it"
    stays += "; too soon after another gap it\n *  becomes what the longest declared one leaves of the start" \
        if plan.max_gap and plan.carries_covariance else ""
    return [
        "/** Before the first sample. */", f"void {name}_start({type_});", "",
        f"/** To the next sample: one that is missing, or that update is to take.  {missed}{between}:",
        f" *  beyond that the mean goes on, {stays}, with {plan.upper}_SIGMA_SATURATED.{steering(plan)} */",
        f"void {name}_predict({type_}{plan.controls});", "",
        *taking(plan), f"unsigned {name}_update({type_}, {plan.sample});", "",
        "/** Predict and update, the same words in fewer instructions. */",
        f"unsigned {name}_step({type_}{plan.controls}, {plan.sample});", "", *in_part(plan)]


def steering(plan: Plan) -> str:
    """What becomes of a control beyond its range"""
    if not plan.stops:
        return ""
    no_number = "" if plan.subject.words.is_fixed else ", NaN as 0"
    told = f"with {plan.upper}_CONTROL_REFUSED"
    said = f"  A control beyond its range is\n *  taken as the nearer end of it{no_number}, {told}."
    if all(one.range for one in plan.model.controls):
        return said
    none = f"  A control beyond {LARGEST:.0e}, or NaN, is\n *  taken as 0, {told}."
    return none.replace("e+", "e") + (said if any(one.range for one in plan.model.controls) else "")


def in_part(plan: Plan) -> list[str]:
    if not plan.partial:
        return []
    name, type_ = plan.name, f"{plan.type} *restrict f"
    told = f"; f->nis{'' if plan.subject.words.is_fixed else ' and the likelihood'} stay as the last whole one left them." \
        if plan.nis else "."
    return ["/** Takes what is present of a sample, a bit for each component.  A sample in part",
            f" *  counts as one of a gap{told} */",
            f"unsigned {name}_update_some({type_}, {plan.sample}, unsigned present);",
            f"unsigned {name}_step_some({type_}{plan.controls}, {plan.sample}, unsigned present);", ""]


def taking(plan: Plan) -> list[str]:
    beyond = "" if all(one.range for one in plan.model.measurements) else f" (1e{int(np.log10(LARGEST))} where it has none)"
    return ["/** Takes a sample, once after start and after each predict.  Returns a bit for each component that it took; it",
            f" *  refuses a second one, what is outside its range{beyond}, and what is NaN or infinite: with",
            f" *  {plan.upper}_REFUSED. */"]


def readings(plan: Plan) -> list[str]:
    s, lines = plan.subject, []
    for i, name in enumerate(s.states):
        type_, text = s.mean.reading(i)
        lines += reading(plan, f"mean_{name}", type_, text)
    for (i, j), text in plan.form.covariance(s.of.n, plan.entry).items():
        if i == j and plan.carries_covariance:
            lines += reading(plan, f"variance_{s.states[i]}", s.words.type, text)
    if plan.nis:
        lines += ["/** Of the last sample that was there as a whole.  f->s_...: the variance of a component's",
                  " *  innovation given the components before it. */"]
        lines += reading(plan, "nis", "int64_t" if s.words.is_fixed else "float", "f->nis")
    if plan.nis and not s.words.is_fixed:
        logarithms = " + ".join(f"(float)logf(f->s_{one})" for one in s.measurements)
        constant = np.float32(s.of.m * np.log(2 * np.pi))
        lines += reading(plan, "log_likelihood", "float", f"-0.5f * (f->nis + {constant}f + {logarithms})")
    return lines


def reading(plan: Plan, name: str, type_: str, text: str) -> list[str]:
    unused = [] if "f->" in text else ["    (void)f;"]
    return [f"static inline {type_} {plan.name}_{name}(const {plan.type} *f)", "{", *unused, f"    return {text};",
            "}", ""]
