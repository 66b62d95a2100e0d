"""What a firmware engineer finds in the emitted files, whatever the model and the arithmetic."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Callable

import numpy as np
import pytest

import equations as examples
from library import STRICT, cc, written
from products import ALL, gps, rover
from whole import first

from kalmanq import Model
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.fixed_records import simulated
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.trial import trial
from kalmanq.compiler.text.equation_device_text import compiled_device
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.fixed_device_text import compiled_fixed
from kalmanq.compiler.text.product import Product, compiled
from kalmanq.errors import KalmanqError

YOURS = "This file is yours: no licence, no condition."
ARITHMETICS = ("f32", "f64", "q31")
NEEDS_CPP = pytest.mark.skipif(not shutil.which("g++"), reason="no C++ compiler")
CPP = ("g++", "-x", "c++", "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror", "-fsyntax-only")


def files_of(product: Product) -> dict[str, str]:
    """All files of it"""
    with Host(product) as host:
        return {**product.sources(), f"{product.given.name}_test.c": trial(product, host)}


def others() -> list[Product]:
    """Of nonlinear models, and devices over the library"""
    unicycle, glucose = (examples.model_of(name) for name in ("unicycle", "glucose"))
    return [compiled_equations(unicycle, "one"), compiled_equations(unicycle, "two", Options("f64", gate=3.0, nis=True)),
            compiled_equations(glucose, "three", Options(smooth=20)), compiled_device(unicycle, "four"),
            compiled_fixed(glucose, "five", simulated(glucose), Options("q31"))]


# ------------------------------------------------------------------------------ whose it is, what stands where, which bits


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_each_file_says_whose_it_is(arithmetic: str) -> None:
    assert all(YOURS in text for text in files_of(compiled(gps(), "flt", Options(arithmetic))).values())


def test_files_of_nonlinear_models_say_whose_they_are() -> None:
    assert all(YOURS in text for one in others() for text in one.sources().values())


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_quantities_are_named_where_they_come_from(arithmetic: str) -> None:
    product = compiled(rover(), "flt", Options(arithmetic))
    text, given = product.code, product.given
    start = text[text.index("void flt_start("):text.index("int flt_start_at(")]
    assert re.findall(r"f->x\[\d+\] = [^;]*; /\* (\w+) \*/", start) == list(given.carried)
    for letter, names in (("x", given.carried), ("z", given.measurements), ("u", given.controls)):
        for k, name in enumerate(names):
            lines = re.findall(rf"^ *(?:const )?\w+ {letter}{k} = .*;.*$", text, re.M)
            assert any(line.endswith(f"; /* {name} */") for line in lines), (letter, k)


@pytest.mark.parametrize("arithmetic, said", [("f32", "with -ffp-contract=off, which takes up to"), ("f64", "-ffp-contract=off"),
                                              ("q31", "Its results are the same bits on every core.")])
def test_the_header_says_where_its_bits_are_the_same(arithmetic: str, said: str) -> None:
    assert said in compiled(gps(), "flt", Options(arithmetic)).header


# ------------------------------------------------------------------------------ NAME_test says how near


def tried(folder: Path, texts: dict[str, str], *flags: str) -> tuple[int, list[str]]:
    written(folder, texts)
    cc("cc", *STRICT, *flags, "flt.c", "flt_test.c", "-lm", "-o", "trial", folder=folder)
    done = subprocess.run([str(folder / "trial")], capture_output=True, text=True)
    return done.returncode, done.stdout.splitlines()


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_bits_of_the_host_are_told(arithmetic: str, tmp_path: Path) -> None:
    code, said = tried(tmp_path, files_of(compiled(gps(), "flt", Options(arithmetic))), "-O2", "-ffp-contract=off")
    assert code == 0 and said[-2:] == ["bit-identical to the host", "OK"]


def test_other_bits_are_told(tmp_path: Path) -> None:
    """As those of a core that fuses products: another digest is expected"""
    for arithmetic, within in (("f32", "0.001"), ("f64", "1e-09"), ("q31", "")):
        texts = files_of(compiled(gps(), "flt", Options(arithmetic)))
        texts["flt_test.c"], count = re.subn(r"(h [!=]= UINT32_C\(0x)\w+", r"\g<1>1", texts["flt_test.c"])
        assert count == 1
        code, said = tried(tmp_path, texts, "-O1", "-ffp-contract=off")
        if arithmetic == "q31":  # its bits are promised
            assert code == 1 and "OK" not in said
        else:
            assert code == 0 and said[-2].startswith(f"equal to within {within} sigma: ") and said[-1] == "OK"


# ------------------------------------------------------------------------------ sigmas by name

READ = """#include <stdio.h>
#include "flt.h"
int main(void)
{{
    static flt_filter f;
    static const {T} z[{m}];
    flt_start(&f);
    {print}
    for (int t = 0; t < {rows}; t++) {{
        if (t) flt_predict(&f{u});
        flt_update(&f, z);
    }}
    {print}
    return 0;
}}
"""


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("make", (gps, rover))
def test_sigmas_and_variances_have_names(make: Callable[[], Model], arithmetic: str, tmp_path: Path) -> None:
    product = compiled(make(), "flt", Options(arithmetic))
    given, steady, is_fixed = product.given, product.steady, arithmetic == "q31"
    assert steady is not None
    value = "FLT_SIGMA_{upper}_VALUE({call})" if is_fixed else "(double){call}"
    prints = [f'printf("%.9g %.9g\\n", {value.format(upper=one.upper(), call=f"flt_sigma_{one}(&f)")}, (double)flt_variance_{one}(&f));'
              for one in given.states]
    T = {"f32": "float", "f64": "double", "q31": "int32_t"}[arithmetic]
    u = f", (const {T}[{given.inputs}]){{0}}" if given.inputs else ""
    main = READ.format(T=T, m=given.of.m, u=u, rows=steady.samples + 2, print="\n    ".join(prints))
    written(tmp_path, {**product.sources(), "main.c": main})
    cc("cc", *STRICT, "-O1", "flt.c", "main.c", "-lm", "-o", "read", folder=tmp_path)
    made = np.array([line.split() for line in subprocess.run([str(tmp_path / "read")], capture_output=True, text=True).stdout.splitlines()], float)
    first, last = np.sqrt(np.diag(given.of.P0.astype(float))), np.sqrt(np.diag(steady.filtered).astype(float))
    assert np.allclose(made[:, 0], [*first, *last], rtol=1e-4)
    scale = [2.0 ** (2 * product.arithmetic.sigma_fraction(i)) if is_fixed else 1.0 for i in range(given.of.n)]
    assert np.allclose(made[:, 1] / [*scale, *scale], made[:, 0] ** 2, rtol=1e-4)


# ------------------------------------------------------------------------------ MISRA C:2012

OPTIONS = [{}, {"nis": True, "gate": 4.0}, {"lag": 2}, {"loops": True}, {"every": (1, 2)}, {"student": 8.0}, {"tunable": True}]
FUNCTION = re.compile(r"^\w[^\n]*?(\w+)\([^()\n]*\)\n\{\n(.*?)^\}$", re.M | re.S)


def codes(arithmetic: str) -> list[str]:
    made = [] if arithmetic == "q31" else [one.code for one in others()[:3]]
    for options in OPTIONS:
        if not (arithmetic == "q31" and "tunable" in options):
            made.append(compiled(gps(), "flt", Options(arithmetic, **options)).code)
    return made


def calls(text: str) -> dict[str, set[str]]:
    """Of each function, those of the file that it calls"""
    bodies = dict(FUNCTION.findall(text))
    return {name: {other for other in bodies if re.search(rf"\b{other}\(", body)} for name, body in bodies.items()}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_no_function_calls_itself(arithmetic: str) -> None:
    """17.2, in any number of steps; so a linker's bound on the stack is one"""
    for text in codes(arithmetic):
        left = calls(text)
        assert any(other.startswith("take") for called in left.values() for other in called)
        while left:
            ends = [name for name, called in left.items() if not called & set(left)]
            assert ends, left
            left = {name: called for name, called in left.items() if name not in ends}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_conditions_are_comparisons(arithmetic: str) -> None:
    """14.4: of bits it is said what they are compared with"""
    for text in codes(arithmetic):
        assert not re.findall(r"\bif \(!?\(*[\w>.\[\]-]+ (?:&|>>) \d+u?\)+ (?!!=|==|[<>&|+*-])[^\n]*", text)


@pytest.mark.parametrize("arithmetic", ["q31"])
def test_hexadecimal_words_are_unsigned(arithmetic: str) -> None:
    """7.2"""
    text = re.sub(r"/\*.*?\*/", "", "\n".join(codes(arithmetic)), flags=re.S)
    assert "0xfffd7d13u" in text and not re.findall(r"(?<!_C\()\b0x[89a-f][0-9a-f]{7}\b(?!u)", text)


# ------------------------------------------------------------------------------ C++


@NEEDS_CPP
@pytest.mark.parametrize("is_whole", first(1, (False, True)))
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("options", [{}, {"nis": True, "gate": 4.0}, {"lag": 2}, {"loops": True}, {"student": 8.0}, {"tunable": True}], ids=str)
def test_all_products_are_cpp_too(arithmetic: str, options: dict, is_whole: bool, tmp_path: Path) -> None:
    """Every day each in one arithmetic, and the first in each"""
    files = []
    for k, make in enumerate(ALL if not options else ALL[::4]):
        if k and k % 3 != ARITHMETICS.index(arithmetic) and not is_whole:
            continue
        try:
            product = compiled(make(), f"p{k}", Options(arithmetic, **options))
        except KalmanqError:
            continue  # what these options refuse
        written(tmp_path, product.sources() if k else files_of(product))
        files += [f"p{k}.c", *(["p0_test.c"] if not k else [])]
    if files:
        cc(*CPP, *files, folder=tmp_path)
    else:
        assert arithmetic == "q31" and "tunable" in options


@NEEDS_CPP
def test_other_products_are_cpp_too(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[2]
    for one in others():
        written(tmp_path, one.sources())
        cc(*CPP, f"-I{root / 'include'}", f"{one.given.name}.c", folder=tmp_path)

