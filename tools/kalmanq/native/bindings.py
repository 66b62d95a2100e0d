"""Writes the C source of the Python module that binds the whole C core, from its own headers.

    bindings.py COMPILER INCLUDE OUTPUT

The headers, preprocessed, are what cffi reads: no declaration is written twice.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import cffi

HERE = Path(__file__).resolve().parent

# A kq_function of Python: `context` is a handle of what answers it (kalmanq.nonlinear.callbacks).
CALLED_BACK = "".join(f"""extern "Python" void kalmanq_answer_{name}(void *context, const {number} *x, {number} *y);
""" for name, number in (("f32", "float"), ("f64", "double")))

# numbers that macros stand for
CONSTANTS = re.compile(r"^#define (KQ_[A-Z0-9_]+) +\(?-?\d+\)?\s*(?:/\*.*)?$", re.M)
def preprocessed(compiler: str, include: Path) -> str:
    command = [compiler, "-E", "-P", "-nostdinc", f"-I{HERE / 'freestanding'}", f"-I{include}",
               str(HERE / "sequences.h")]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    text = re.sub(r"__attribute__\(\(warn_unused_result\)\)|\[\[nodiscard\]\]", "", text)
    return re.sub(r"extern const struct[^;]*;", "", text)


# kinds of losses, which are objects: their addresses
LOSSES = re.compile(r"^extern const struct (kq_loss_kind_\w+) ([^;]*);", re.M)


def main() -> None:
    compiler, include, output = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    headers = "".join(path.read_text(encoding="utf-8") for path in sorted((include / "kalmanq").glob("*.h")))
    constants = sorted(set(CONSTANTS.findall(headers)))
    builder = cffi.FFI()
    builder.cdef(preprocessed(compiler, include))
    builder.cdef("".join(f"#define {name} ...\n" for name in constants))
    builder.cdef(CALLED_BACK)
    losses = [(kind, name.strip()) for kind, names in LOSSES.findall(headers) for name in names.split(",")]
    builder.cdef("".join(f"const struct {kind} *{name}_address(void);\n" for kind, name in losses))
    addresses = "".join(f"static const struct {kind} *{name}_address(void) {{ return &{name}; }}\n"
                        for kind, name in losses)
    builder.set_source("kalmanq._core", '#include "sequences.h"\n' + addresses)
    builder.emit_c_code(str(output))


if __name__ == "__main__":
    main()
