"""Tables of data, what kalmanq has written, and the C that goes with it."""
from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Optional, Sequence

import numpy as np


class BoardError(Exception):
    """Told in one line"""


def run(command: Sequence[str], environment: Optional[dict[str, str]] = None) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
    except FileNotFoundError:
        raise BoardError(f"{command[0]}: is not there; boards.py --kalmanq COMMAND, and `kalmanq doctor` says what is missing") from None
    if done.returncode:
        said = [line for line in (done.stderr.strip() or done.stdout).splitlines() if line.strip()] or ["no message"]
        told = [line for line in said if "error: " in line] or said[-1:]
        raise BoardError(f"{' '.join(map(str, command[:4]))} ...: {told[0].strip()}")
    return done.stdout


def table(path: Path) -> dict[str, np.ndarray]:
    lines = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return {name: np.array([float(line[k]) if line[k] else np.nan for line in lines[1:]]) for k, name in enumerate(lines[0])}


def fraction(header: str, name: str) -> int:
    found = re.search(rf"\b{name.upper()}_FRACTION = (\d+)", header)
    if not found:
        raise BoardError(f"{name.upper()}_FRACTION: is not in the header that kalmanq has written")
    return int(found[1])


def quantities(header: str, kind: str) -> list[str]:
    """Names of measurements or controls, from the header's table"""
    return re.findall(rf"^ \*  +{kind} \d+  +(\S+)", header, re.M)


def as_float(value: float) -> str:
    text = f"{value:.9g}"
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def recording(name: str, fixed: bool, header: str, columns: dict[str, np.ndarray]) -> str:
    """recording.h"""
    z, u = (quantities(header, kind) for kind in ("measurement", "control"))

    def words(names: list[str], letter: str) -> np.ndarray:
        values = np.column_stack([np.nan_to_num(columns[one]) for one in names])
        scales = [2.0 ** fraction(header, f"{name}_{letter}_{one}") for one in names] if fixed else 1.0
        return np.rint(values * scales).astype(np.int64) if fixed else values.astype(np.float32)

    def cells(row: np.ndarray) -> str:
        return f"{{{', '.join(str(int(one)) if fixed else as_float(float(one)) for one in row)}}}"

    present = [sum(1 << j for j, one in enumerate(z) if np.isfinite(columns[one][t])) for t in range(len(columns[z[0]]))]
    parts = [words(z, "Z"), *([words(u, "U")] if u else [])]
    rows = ["    {" + ", ".join([*(cells(one[t]) for one in parts), str(bits)]) + "}," for t, bits in enumerate(present)]
    fields = f"number z[{len(z)}];{f' number u[{len(u)}];' if u else ''} uint8_t present; /* a bit for each of z */"
    return "\n".join([f"/* {name}: written by boards.py of data.csv */", f"typedef {'int32_t' if fixed else 'float'} number;",
                      f"enum {{ ROWS = {len(present)} }};", "static const struct {", f"    {fields}", "} recording[ROWS] = {", *rows, "};", ""])


def as_compiled(header: str, name: str, T: str) -> str:
    """The calls of `kalmanq compile` by those of `kalmanq design`"""
    upper = name.upper()
    states = re.search(rf"enum {{\n((?:    {upper}_\w+,\n)+)    {upper}_STATES\n", header)
    if not states:
        raise BoardError(f"{name}.h: has no states")
    moved = "" if f"{name}_predict(void)" in header else ", u"
    lines = [f"static inline kq_filter_{T} *{name}_object(void) {{ return {name}_filter(); }}",
             f"typedef struct {{ int events; kq_filter_{T} object; }} {name}_shown;",
             f"#define {name}_filter {name}_shown",
             f"enum {{ {upper}_GATED = 0 }};", f"#define {name}_start(f) ((f)->events = {name}_init() != KQ_OK)",
             f"#define {name}_predict(f{moved}) ((f)->events |= ({name}_predict)({moved[2:]}) != KQ_OK)",
             *(f"#define {name}_{call}(f, z) ((f)->events |= ({name}_{call})(z, {upper}_ALL) != KQ_OK)" for call in ("update", "step"))]
    lines += [f"#define {name}_mean_{one[len(name) + 1:].lower()}(f) ((void)(f), kq_mean_{T}({name}_object(), {one}))"
              for one in re.findall(r"\w+", states[1])]
    return "\n".join([*lines, *late(header, name, T), ""])


def late(header: str, name: str, T: str) -> list[str]:
    """The calls of NAME_delayed, where a sensor is late"""
    sensors = re.findall(rf"^kq_status {name}_update_(\w+)\(const \w+ z\[\d+\], uint32_t present(, size_t ago)?\);", header, re.M)
    if not any(ago for _, ago in sensors):
        return []
    calls = [f"#define {name}_delayed_update_{one}(d, z{ago and ', ago'}) ((d)->now.events |= ({name}_update_{one})(z, 1{ago and ', ago'}) != KQ_OK)"
             for one, ago in sensors]
    states = re.findall(rf"^    {name.upper()}_(\w+),$", header.split("_STATES")[0], re.M)
    return [f"typedef struct {{ {name}_shown now; }} {name}_delayed;", f"#define {name}_delayed_start(d) ((void)(d))",
            f"#define {name}_delayed_predict(d) {name}_predict(&(d)->now)", *calls,
            f"static inline float squared(float sigma) {{ return sigma * sigma; }}",
            *(f"#define {name}_variance_{one.lower()}(f) ((void)(f), squared(kq_sigma_{T}({name}_object(), {name.upper()}_{one})))" for one in states)]


def as_first(header: str, is_compiled: bool, first_is_compiled: bool) -> str:
    """The calls of a nonlinear way by those of the first one: a filter's answer components, a device's statuses"""
    found = re.search(r"^\} (\w+)_(filter|device);", header, re.M)
    if not found:
        raise BoardError("the header that kalmanq has written has no filter")
    name, have = found.groups()
    lines = ["#ifndef KALMANQ_STATUS_H", "typedef int kq_status;", "#endif"] if is_compiled else []
    lines += [f"typedef struct {{ {name}_{have} own; int events; }} {name}_wrapped;",
              f"#define {name}_{'filter' if first_is_compiled else 'device'} {name}_wrapped"]
    for answer, call, given in re.findall(rf"^(\w+) {name}_((?:start|predict|update)\w*)\((.*)\);", header, re.M):
        if call in ("start_at", "update_some"):
            continue
        args = [re.sub(r"\[.*\]", "", one).split()[-1].lstrip("*") for one in given.split(",")]
        made = f"({name}_{call})({', '.join(['&(f)->own', *args[1:]])})"
        failed = f"({made}, 0)" if answer == "void" else f"!{made}" if is_compiled else f"({made} != 0)"
        lines.append(f"#define {name}_{call}({', '.join(args)}) " + (f"((f)->events |= {failed})" if first_is_compiled else failed))
    lines += [f"#define {one}(f) ({one})(&(f)->own)" for one in re.findall(rf"static inline \w+ ({name}_mean_\w+)\(", header)]
    return "\n".join([*lines, ""])
