#!/usr/bin/env python3
"""Counts what formulas in fixed point cost on a core without an FPU, beside the same in float.

    fixed.py functions [--core m3] [--csv OUT.csv] [--check OLD.csv]    each function of formulas, with its largest error
    fixed.py devices FOLDER... [--core m3]    predict and updates of devices (kalmanq compile --library -o FOLDER/NAME.c)

Instructions are the most of the arguments, or rows of NAME_test.c, that are tried.
"""

from __future__ import annotations

import re
import sys
import tempfile
import types
from pathlib import Path
from typing import Any

import build
import table
import typer
from build import Place, compiled, linked
from cores import BY_NAME, ROOT, Core, incomparable
from errors import UserError, told_in_one_line
from kalmanq.firmware.elf import flash_and_ram
from kalmanq.firmware.emulated import Emulator
from outputs import csv_text, write

C_NAMES = {"a + b": "x0 + x1", "a b": "x0 * x1", "a / b": "x0 / x1"}  # others are called as they are
MAIN = """\
void cost_region(unsigned region);
void cost_end(void);

int main(void)
{{
{calls}
    cost_end();
    return 0;
}}
"""
app = typer.Typer(add_completion=False)


def fixed_functions() -> Any:
    """The module of the package's tests, without the package's own library in C"""
    for name, folder in (("kalmanq", "."), ("kalmanq.compiler", "compiler"), ("kalmanq.formulas", "formulas")):
        module = types.ModuleType(name)
        module.__path__ = [str(ROOT / "tools" / "kalmanq" / folder)]  # type: ignore[attr-defined]
        sys.modules[name] = module
    sys.path.append(str(ROOT / "tools" / "tests"))
    import fixed_functions as made
    return made


def counted(place: Place, core: Core, text: str, functions: dict[int, str]) -> dict[int, int]:
    source = place.work / "functions.c"
    source.write_text(text, encoding="utf-8")
    objects = [place.work / "functions.o", place.work / "marks.o"]
    for one, target in zip((source, build.MARKS), objects):
        compiled(place, core, build.GCC, one, target)
    found = Emulator(core, linked(core, objects, place.work / "functions.elf")).count_regions(functions)
    return {region: found[region].instructions for region in functions}


def text_of(made: list[Any], routines: str) -> tuple[str, dict[int, str]]:
    """Of each function in q31, float and double, and the regions in which they are called"""
    lines = ["#include <math.h>", "#include <stdint.h>", routines, "int32_t q31; float f32; double f64; uint32_t far_off;"]
    names, calls = {}, []
    for k, one in enumerate(made):
        count = len(one.ranges)
        loads = " ".join(f"const TYPE x{i} = x[{i}];" for i in range(count))
        args = ", ".join(f"x{i}" for i in range(count))
        called = {"abs": "fabs"}.get(one.name, one.name)
        bodies = [("q31", "int32_t", "\n".join(one.lines))]
        bodies += [(T, type_, f"e[0] = {C_NAMES.get(one.name) or f'{called}{end}({args})'};")
                   for T, type_, end in (("f32", "float", "f"), ("f64", "double", ""))]
        values = [[float(word) for word in row] for row in one.rows.tolist()]
        for T, type_, body in bodies:
            cells = one.rows.tolist() if T == "q31" else [[word * 2.0**-n for word, n in zip(row, one.fractions)] for row in values]
            rows = ", ".join(f"{{{', '.join(map(repr, row))}}}" for row in cells)
            name, region = f"{T}_{k}", len(names)
            head = f"void {name}(const {type_} *x, {type_} *e, uint32_t *far)"
            lines += [f"static const {type_} given_{name}[][{count}] = {{{rows}}};", f"{head};",
                      f"__attribute__((noipa)) {head} {{ (void)far;", loads.replace("TYPE", type_), body, "}"]
            calls.append(f"    for (int i = 0; i < {len(cells)}; i++) {{ cost_region({region}); "
                         f"{name}(given_{name}[i], &{T}, &far_off); }}")
            names[region] = name
    return "\n".join([*lines, MAIN.format(calls="\n".join(calls))]), names


@app.command()
def functions(core: str = typer.Option("m3", "--core"), out: Path = typer.Option(None, "--csv"),
              check: Path = typer.Option(None, "--check")) -> None:
    versions = table.read(ROOT / "tools" / "cost.csv").versions
    if check and (reason := incomparable(versions, [BY_NAME[core]], with_clang=False)):
        return print(reason)
    costs = fixed_functions()
    made = costs.functions()
    text, names = text_of(made, costs.routines(made))
    with tempfile.TemporaryDirectory(prefix="kalmanq-fixed-") as work:
        count = counted(Place(ROOT, Path(work)), BY_NAME[core], text, names)
    rows = [("function", "arguments", "error", "last_bits", "q31", "f32", "f64")]
    for k, one in enumerate(made):
        ranges = "; ".join(f"{low:g} to {high:g}" for low, high in one.ranges)
        rows.append((one.name, ranges, f"{one.error:.1e}", f"{one.last_bits:.2f}", *(count[3 * k + i] for i in range(3))))
    text = f"# functions in fixed point: errors, instructions on {core} (tools/cost/fixed.py)\n" + csv_text(rows)
    if check and check.read_text(encoding="utf-8") != text:
        raise UserError(f"{check}: is not what fixed.py functions makes now: renew it by --csv")
    if out:
        write(out, text)
    else:
        print(text, end="")


@app.command()
def devices(folders: list[Path] = typer.Argument(...), core: str = typer.Option("m3", "--core")) -> None:
    for folder in folders:
        with tempfile.TemporaryDirectory(prefix="kalmanq-fixed-") as work:
            print(device(Place(ROOT, Path(work)), BY_NAME[core], folder), flush=True)


def device(place: Place, core: Core, folder: Path) -> str:
    """The rows of NAME_test.c, with a mark before each call"""
    test = next(folder.glob("*_test.c"), None)
    if test is None:
        raise UserError(f"{folder}: no NAME_test.c of a device: kalmanq compile MODEL.py --library -o {folder}/NAME.c writes it")
    name, text = test.name.removesuffix("_test.c"), test.read_text(encoding="utf-8")
    T = "q31" if "int32_t z[" in text else "f64" if "double z[" in text else "f32"
    calls = [one for one in dict.fromkeys(re.findall(rf"\b{name}_(?:predict|update\w*)(?=\()", text))]
    for region, one in enumerate(calls):
        text = re.sub(rf"\b{one}(?=\()", f"(cost_region({region}), {one})", text)
    text = re.sub(r"    if \(!wrong\) puts.*\n", "", re.sub(r"    printf\(.*\n", "    cost_end();\n", text))
    text = "void cost_region(unsigned region);\nvoid cost_end(void);\n" + text
    main = place.work / "main.c"
    main.write_text(text, encoding="utf-8")
    objects = []
    for source in (folder / f"{name}.c", main, build.MARKS, *build.library_sources(place, T, ("filter", "nonlinear"))):
        objects.append(place.work / f"{source.stem}.o")
        compiled(place, core, build.GCC, source, objects[-1], (f"-I{folder}",))
    program = linked(core, objects, place.work / "program.elf")
    found = Emulator(core, program).count_regions(dict(enumerate(calls)))
    counts = [f"{one.removeprefix(name + '_')} {found[region].instructions}" for region, one in enumerate(calls) if region in found]
    flash = flash_and_ram(objects[0])[0], flash_and_ram(program)[0]
    return f"{name} {T} on {core.name}: {', '.join(counts)}; flash {flash[0]}, program {flash[1]}"


if __name__ == "__main__":
    with told_in_one_line("fixed"):
        app()
