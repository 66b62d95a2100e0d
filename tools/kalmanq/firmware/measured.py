"""What the C that kalmanq compile writes costs on a core: compiled for it, run there emulated, its instructions counted.

Needs the core's cross compiler, and Unicorn and pyelftools (the extra `costs`).
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence, Union

from kalmanq.firmware.cores import BY_NAME, HINT, Core, NotMeasured, run

if TYPE_CHECKING:
    from kalmanq.firmware.emulated import Counted

TARGET = Path(__file__).resolve().parent / "target"
MARKS = TARGET / "marks.c"
CALLS = ("predict", "update", "predict", "update", "step", "step")  # by region of target/compiled.c
MODULES = ("unicorn", "elftools")
NO_EMULATOR = "instructions are counted on Arm and RISC-V"
TYPES = {"f32": "float", "f64": "double", "q31": "int32_t"}


def why_not(core: Core) -> str:
    """What keeps this machine from measuring; empty: nothing"""
    return NO_EMULATOR if core.family == "avr" else missing(core, MODULES)


def missing(core: Core, modules: Sequence[str]) -> str:
    """Of its compiler and of these; empty: nothing"""
    if shutil.which(core.gcc[0]) is None:
        return f"{core.gcc[0]} was not found: {HINT}"
    absent = [one for one in modules if find_spec(one) is None]
    return f"{' and '.join(absent)} cannot be imported: pip install './tools[costs]'" if absent else ""


@lru_cache(maxsize=None)
def compiler(core: Core) -> str:
    """Its name and version"""
    return f"{core.gcc[0]} {run([core.gcc[0], '-dumpfullversion', '-dumpversion']).strip()}"


def flags(core: Core, level: str = "O2") -> tuple[str, ...]:
    """Products are fused where the core can"""
    return "-std=c11", f"-{level}", "-ffunction-sections", f"-ffp-contract={'fast' if core.has_fpu else 'off'}"


def measured(core: Core, what: Mapping[str, Any], texts: Mapping[str, str], level: str = "O2") -> dict[str, Optional[int]]:
    """Of NAME.c and NAME.h in texts, for a nonlinear model of the rows of NAME_test.c, too: instructions of a row in two calls before the
    gain is constant and after (None: it never is) and of a step, or of each predict and update, the most; bytes of the file (flash), of
    all that a program has because of it (program), and of stack.  what: as `kalmanq compile --json` tells it"""
    from kalmanq.firmware.elf import flash_and_ram
    from kalmanq.firmware.emulated import Emulator

    with tempfile.TemporaryDirectory(prefix="kalmanq-costs-") as folder:
        work = Path(folder)
        for name, text in texts.items():
            (work / name).write_text(text, encoding="utf-8")
        written, callers, program = _built(core, what, work, level)
        calls = _calls(what)
        counted = Emulator(core, program).count_regions({region: f"{what['name']}_{call}" for region, call in enumerate(calls)})
        flash, whole, *beside = (flash_and_ram(one)[0] for one in (written, program, *callers))
        return {**_instructions(what, calls, counted), "flash": flash, "program": whole - sum(beside),
                "stack": max((one.stack for region, one in counted.items() if region < len(calls)), default=0)}


def _built(core: Core, what: Mapping[str, Any], work: Path, level: str) -> tuple[Path, list[Path], Path]:
    """The file, what calls it, and both linked"""
    is_nonlinear, name = "sensors" in what, what["name"]
    named = _rows(what, (work / f"{name}_test.c").read_text(encoding="utf-8")) if is_nonlinear else _named(what)
    (work / "cost-calls.h").write_text(named, encoding="utf-8")
    main = TARGET / ("equations.c" if is_nonlinear else "compiled.c")
    written, *callers = (work / f"kq_{one}.o" for one in ("written", "main", "marks"))
    for source, target in ((work / f"{name}.c", written), *zip((main, MARKS), callers)):
        run([*core.gcc, *flags(core, level), "-w", f"-I{work}", "-c", str(source), "-o", str(target)])
    program = work / "kq_program.elf"
    linking = [*core.link_flags, "-nostartfiles", "-Wl,-e,main", "-Wl,--gc-sections", "-Wl,-u,cost_failed"]
    run([*core.gcc, *linking, *map(str, (*callers, written)), "-lm", "-o", str(program)])
    return written, callers, program


def _calls(what: Mapping[str, Any]) -> Sequence[str]:
    return ["predict", *(f"update_{one['name']}" if one["name"] else "update" for one in what["sensors"])] if "sensors" in what else CALLS


def _instructions(what: Mapping[str, Any], calls: Sequence[str], counted: Mapping[int, Counted]) -> dict[str, Optional[int]]:
    of = {region: counted[region].instructions if region in counted else None for region in range(len(calls))}
    if "sensors" in what:
        return {call: of[region] for region, call in enumerate(calls)}
    settles = bool(what["calls"])
    return {"two_calls": of[0] + of[1], "two_calls_settled": of[2] + of[3] if settles else None, "step": of[5],
            "step_settled": of[4] if settles else None}


# ------------------------------------------------------------------------------ cost-calls.h


def _named(what: Mapping[str, Any]) -> str:
    """Of a constant model.  The count of calls is set: the bound on the rows until it settles may be thousands of samples"""
    name, word, calls = what["name"], TYPES[what["arithmetic"]], what["calls"]
    one = {"float": "0x1p-10f", "double": "0x1p-10", "int32_t": "1024"}[word]  # twelve of them are within any range
    u, pushes = (f"static const {word} pushes[{what['l']}];", ", pushes") if "u" in what["predict"] else ("", "")
    return "\n".join([f'#include "{name}.h"', "#define REFUSED (f.events)", f"typedef {word} word;", f"#define FILTER {name}_filter",
                      f"#define DO(call) {name}_##call", f"#define PREDICT_OF(f) {name}_predict(f{pushes})",
                      f"#define STEP_OF(f, z) {name}_step(f{pushes}, z)", f"#define ONE {one}", u,
                      f"enum {{ M = {what['m']}, ROWS = {8 * (not calls)} }};",
                      f"#define SETTLE(f) ({f'(f).calls = {calls}u' if calls else '(void)0'})", ""])


def _rows(what: Mapping[str, Any], test: str) -> str:
    """Of a nonlinear model: the rows of NAME_test.c, and the calls of each"""
    name, word = what["name"], TYPES[what["arithmetic"]]
    rows = re.search(r"static const struct \{.*?\n\};\n", test, re.S)
    if rows is None:
        raise NotMeasured(f"{name}_test.c has no rows")
    has_clock = f"{word} clock[3];" in rows[0]
    left, step, now = (f"rows[k].clock[{k}]" for k in range(3)) if has_clock else (f"({word})(k - 1)", "", f"({word})k")

    def given(arguments: Sequence[str], values: Mapping[str, str]) -> str:
        return "".join(f", {values[one]}" for one in arguments)

    updates, first = [], 0
    for region, (sensor, call) in enumerate(zip(what["sensors"], _calls(what)[1:]), 1):
        z = given(sensor["arguments"], {"z": f"rows[k].z + {first}", "u": "rows[k].now", "t": now})
        whole = f"(rows[k].present >> {first} & {(1 << sensor['m']) - 1}u) == {(1 << sensor['m']) - 1}u"
        updates.append(f"    if ({whole}) {{ cost_region({region}); {name}_{call}(&f{z}); }} \\")
        first += sensor["m"]
    predict = given(what["predict"], {"u": "rows[k].u", "t": left, "dt": step})
    return "\n".join([f'#include "{name}.h"', rows[0],
                      f"enum {{ RECORDED = sizeof rows / sizeof rows[0], ROWS = 20, NO_MORE = {len(what['sensors']) + 1} }};",
                      f"#define FILTER {name}_filter", f"#define DO(call) {name}_##call", f"#define FAILED {name.upper()}_NOT_FINITE",
                      f"#define PREDICT_OF(k) {name}_predict(&f{predict})", "#define UPDATES_OF(k) \\", *updates, ""])


# ------------------------------------------------------------------------------ told


@lru_cache(maxsize=64)
def _kept(core: str, what: str, texts: tuple[tuple[str, str], ...]) -> tuple[Mapping[str, Optional[int]], str]:
    """And why there is nothing.  A product is measured once, however many tell of it"""
    try:
        return measured(BY_NAME[core], json.loads(what), dict(texts)), ""
    except (NotMeasured, OSError) as problem:  # a full disk, too
        return {}, said(problem)


def said(problem: Union[NotMeasured, OSError]) -> str:
    return problem.strerror or str(problem) if isinstance(problem, OSError) else str(problem)


def told(core: str, what: Mapping[str, Any], texts: Mapping[str, str]) -> tuple[Mapping[str, Optional[int]], str]:
    """What was measured at -O2, or why nothing was"""
    reason = why_not(BY_NAME[core])
    return ({}, reason) if reason else _kept(core, json.dumps(what), tuple(texts.items()))
