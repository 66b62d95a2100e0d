"""kalmanq compile --library --arith q31: formulas in fixed point come near to double, and to the same bits on every machine."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
from functools import lru_cache
from pathlib import Path

import fixed_functions
import numpy as np
import pytest
from command import kalmanq, succeeds
from equations import path_of
from library import ROOT, STRICT, cc, objects, passes, saved, written
from whole import first

import kalmanq as kalmanq_package
from kalmanq.compiler.algorithm.fixed.device import EVENTS
from kalmanq.compiler.algorithm.fixed.python import Far
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import fixed_report, report
from kalmanq.compiler.run.equation_records import drawn, recorded
from kalmanq.compiler.run.equation_run import FixedEquations, compiled_equations_run
from kalmanq.compiler.run.fixed_records import simulated
from kalmanq.compiler.run.fixed_run import FixedRun
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import Record, in_whole_groups
from kalmanq.compiler.text.emit import Row
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.fixed_device_text import compiled_fixed
from kalmanq.formulas.graph import FUNCTIONS
from kalmanq.model import Quantity
from kalmanq.nonlinear import NonlinearModel, read

SANITIZED = (*STRICT, "-fsanitize=undefined", "-fno-sanitize-recover", f"-I{ROOT / 'include'}")
MOST = {  # sigma: of a mean beside double
    "battery": 1e-5, "range_bearing": 1e-3, "gps_imu": 2e-5, "falling_body": 5e-4, "range_rate": 1e-5, "two_rc": 1e-5,
    "pv_panel": 1e-5, "sir": 1e-4, "house": 1e-5, "orbit": 1e-3, "two_link_arm": 1e-5, "attitude": 5e-5, "drone": 5e-4}
ROWS = {"range_bearing": 200}  # it leaves its declared range of 2 km
ON_CORES = ("battery", "gps_imu", "falling_body", "tyre_slip", "range_bearing", "range_rate", "unicycle", "attitude")
SATURATED = 1 << [name for name, _ in EVENTS].index("SATURATED")
PARTS = ("filter_q31", "range_error_q31", "status")  # of the library
PROGRAM = """\
#include <stdio.h>
#include "{name}.h"
static const struct {{ unsigned char what; unsigned present; int32_t z[{m}], u[{l} + 1], now[{l} + 1]; }} rows[] = {{
{rows}
}};
int main(void)
{{
    static {name}_device f;
    if ({name}_start(&f)) return 1;
    for (int t = 0; t < (int)(sizeof rows / sizeof rows[0]); t++) {{
        unsigned taken = 0;
        {calls}
        printf("%x %lx", taken, (unsigned long)f.events);
        for (unsigned k = 0; k < sizeof f.filter_memory / sizeof f.filter_memory[0]; k++) printf(" %ld", (long)f.filter_memory[k]);
        {nominal}
        printf("\\n");
    }}
    puts("OK");
    return 0;
}}
"""


@lru_cache(None)
def compiled(name: str):
    model = read(path_of(name))
    return model, compiled_fixed(model, "device", simulated(model))


@lru_cache(None)
def exact_of(name: str):
    return compiled_equations(compiled(name)[0], "exact", Options("f64"))


def whole_record(model, product, rows: int, seed: int) -> Record:
    return in_whole_groups(drawn(model, rows, seed), product.given.together)


def both(name: str, seed: int, rows: int):
    """The device, and the filter in double"""
    model, product = compiled(name)
    record = whole_record(model, product, rows, seed)
    with Host(exact_of(name)) as exact:
        return FixedRun(product.arithmetic).run(record), exact.run_record(record)


def sigmas(ran) -> np.ndarray:
    return np.sqrt(np.einsum("tii->ti", ran.covariance))


@pytest.mark.parametrize("name", first(4, MOST))
def test_it_comes_near_to_double(name):
    for seed in (1, 2, 3):
        ran, exact = both(name, seed, ROWS.get(name, 300))
        assert np.array_equal(ran.taken, exact.taken) and not np.any(ran.events), seed
        apart = [compiled(name)[0].minus(*pair) for pair in zip(ran.mean, exact.mean)]
        assert np.max(np.abs(apart) / sigmas(exact)) < MOST[name], seed
        assert np.max(np.abs(sigmas(ran) / sigmas(exact) - 1)) < 1e-4, seed


@pytest.mark.parametrize("name", ["battery", "gps_imu", "attitude"])
def test_a_run_compiled_in_q31_is_the_device(name, tmp_path):
    """run --compiled --arith q31: block after block the words of the device's own run, and near to double"""
    model = read(path_of(name))
    product = compiled_fixed(model, "kf", simulated(model))
    record = whole_record(model, product, 120, 4)
    u = record.now if model.l else None
    z = record.measured
    device = FixedRun(product.arithmetic).run(record)
    with FixedEquations(model) as run:
        parts = [run.run(z[rows], None if u is None else u[rows]) for rows in (slice(0, 50), slice(50, 120))]
        assert np.array_equal(np.vstack([one.mean for one in parts]), device.mean) and run.event_names == []
        assert np.array_equal(np.concatenate([one.taken for one in parts]), (record.present[:, None] >> np.arange(model.m) & 1).sum(axis=1))
    exact = compiled_equations_run(model, "f64", z, u)
    whole = compiled_equations_run(model, "q31", z, u)
    assert np.array_equal(whole.mean, device.mean) and abs(np.nansum(whole.nis) - np.nansum(exact.nis)) < 1e-3 * np.nansum(exact.nis)


def test_what_is_not_near_is_told(tmp_path):
    """A target beyond the declared range by an event from there on, a formula whose digits cancel by the report"""
    ran, exact = both("range_bearing", 3, 300)
    far = np.flatnonzero(np.any(np.abs(ran.mean - exact.mean) > 1e-2 * sigmas(exact), axis=1))
    told = np.flatnonzero(ran.events)
    assert len(far) and told[0] <= far[0]
    # with quotients near 0
    turn = saved(tmp_path / "turn.py", path_of("coordinated_turn").read_text(encoding="utf-8").replace("abs(w) > 1e-2", "abs(w) > 1e-4"))
    model = read(turn)
    product = compiled_fixed(model, "device", simulated(model))
    found = fixed_report.tried(model, product)
    said = [one for one in report.lines(product, found) if "In fixed point" in one]
    assert any("df(north)/dturn is off by" in one for one in said) and len(said) < 4
    model, product = compiled("gps_imu")
    assert not report.warned(product, fixed_report.tried(model, product))


FLIGHT = """
import numpy as np

states = ["distance", "speed"]
measurements = ["echo"]
x0 = [1000.0, 0.0]
P0 = [%s, 1e2]
Q = [0, 1e-6]
R = [%s]


def f(x):
    return [x[0] + 0.01 * x[1], x[1]]


def h(x):
    return [np.sqrt(x[0]**2 + 1.0)]
"""


@pytest.mark.parametrize("P0, R", [("1e6", "1e-10"), ("1e9", "1e-6")])
def test_a_wrong_number_that_no_event_tells_is_refused_with_the_cure(P0, R, tmp_path):
    """Its prior is far wider than what follows, so that sigma has few steps of the raw values"""
    (tmp_path / "flight.py").write_text(FLIGHT % (P0, R))
    done = kalmanq("compile", tmp_path / "flight.py", "--library", "--arith", "q31", "-o", tmp_path / "out.c")
    said = " ".join(done.stderr.split())
    assert done.returncode and "no event says so" in said and not list(tmp_path.glob("out*"))
    assert "distance: a range of" in said and "echo: a range of" in said and "or use --arith f32" in said
    assert not kalmanq("compile", tmp_path / "flight.py", "--library", "--arith", "f32", "-o", tmp_path / "out.c").returncode
    (tmp_path / "flight.py").write_text(FLIGHT % ("1e2", "1e-2"))
    done = kalmanq("compile", tmp_path / "flight.py", "--library", "--arith", "q31", "-o", tmp_path / "near.c")
    assert not done.returncode and "coarse" not in done.stdout


# ------------------------------------------------------------------------------ C


def core(name: str) -> dict[str, str]:
    asked = ["sh", str(ROOT / "tests/target/cores.sh"), "describe", name, "gcc"]
    said = subprocess.run(asked, check=True, capture_output=True, text=True).stdout
    return dict(line.split("=", 1) for line in said.splitlines())


@pytest.fixture(scope="session")
def on_m3(tmp_path_factory):
    """Its objects on a Cortex-M3"""
    work, of = tmp_path_factory.mktemp("library"), core("m3")
    for part in PARTS:
        source = ROOT / "src" / f"kq_{part}.c"
        cc(*of["compiler"].split(), "-std=c11", "-O0", *of["profile"].split(), *of["include"].split(), "-c", source, folder=work)
    return [work / f"kq_{part}.o" for part in PARTS]


def program(folder: Path, name: str, rows: int, seed: int) -> Record:
    """Written to a folder: the device, and a program that prints all of its words in each row"""
    model, product = compiled(name)
    record, a = whole_record(model, product, rows, seed), product.arithmetic
    calls = product.text.row(Row(*(f"rows[t].{one}" for one in ("what", "present", "z", "u", "now")), "t - 1", "", "t", "taken"))

    def cells(which: str, values) -> str:
        return f"{{{', '.join(a.literal(a.raw(which, k, value)) for k, value in enumerate(values)) or '0'}}}"

    nominal, lines = " ".join(f'printf(" %ld", (long)f.x[{i}]);' for i in range(len(product.given.nominal))), []
    for t in range(rows):
        u, now = (cells("controls", of[t]) if of is not None and model.l else "{0}" for of in (record.u, record.now))
        lines.append(f"{{{record.what[t]}, {record.present[t]}, {cells('measurements', record.z[t])}, {u}, {now}}},")
    files = {**product.sources(), "program.c": PROGRAM.format(name="device", m=model.m, l=model.l, rows="\n".join(lines),
                                                                      calls="\n        ".join(calls), nominal=nominal)}
    written(folder, files)
    return record


def expected(name: str, record: Record) -> list[str]:
    """What the program prints, by Python"""
    run, made, events = FixedRun(compiled(name)[1].arithmetic), [], 0
    for t in range(len(record.what)):
        taken = run.row(record, t)
        events |= run.events
        made.append(" ".join([f"{taken:x} {events:x}", *map(str, run.filter.memory), *map(str, run.x)]))
    return [*made, "OK"]


@pytest.mark.parametrize("name", first(2, ON_CORES))
def test_it_is_the_same_bits_in_python_on_the_host_and_on_a_cortex_m3(name, on_m3, tmp_path):
    record = program(tmp_path, name, 60, 2)
    wanted = expected(name, record)
    for compiler in [one for one in ("gcc", "clang") if shutil.which(one)]:
        cc(compiler, *SANITIZED, "device.c", "program.c", *objects(*PARTS), "-o", "program", folder=tmp_path)
        done = subprocess.run([tmp_path / "program"], capture_output=True, text=True)
        assert done.stdout.splitlines() == wanted, compiler
    m3 = core("m3")
    cc(*m3["compiler"].split(), *STRICT, *m3["include"].split(), "-c", "device.c", "program.c", folder=tmp_path)
    cc(*m3["linker"].split(), "device.o", "program.o", *on_m3, "-o", "program.m3", folder=tmp_path)
    emulator = [*m3["emulator"].split(), tmp_path / "program.m3"]
    done = subprocess.run(emulator, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert done.stdout.splitlines() == wanted
    asked = [m3["nm"], "-u", tmp_path / "device.o", *on_m3]
    listed = subprocess.run(asked, check=True, capture_output=True, text=True).stdout
    floats = [line for line in listed.splitlines() if any(one in line for one in ("__aeabi_f", "__aeabi_d", "__aeabi_i2", "sqrt"))]
    assert "device.o" in listed and not floats


def test_an_event_stays(tmp_path):
    """Of a state far beyond the records that the formats are of"""
    program(tmp_path, "battery", 1, 2)
    (tmp_path / "program.c").write_text("""\
#include <stdio.h>
#include "device.h"
int main(void)
{
    static device_device f;
    static const int32_t z[1] = {0}, u[1] = {0}, low[2] = {-0x7fffffff, 0}, back[2] = {0x7fffffff, 0};
    int32_t e[1];
    int answers[4] = {device_start(&f)};
    (void)!device_innovation(&f, z, u, e);
    const uint32_t before = f.events;
    answers[1] = kq_move_q31(&f.filter, low);
    (void)!device_innovation(&f, z, u, e);
    const uint32_t at = f.events;
    answers[2] = kq_move_q31(&f.filter, back);
    (void)!device_innovation(&f, z, u, e);
    printf("%d %d %d ", answers[0], answers[1], answers[2]);
    printf("%lx %lx %lx", (unsigned long)before, (unsigned long)at, (unsigned long)f.events);
    return 0;
}
""")
    cc("cc", *STRICT, f"-I{ROOT / 'include'}", "device.c", "program.c", *objects(*PARTS), "-o", "program", folder=tmp_path)
    said = subprocess.run([tmp_path / "program"], capture_output=True, text=True).stdout
    assert said == f"0 0 0 0 {SATURATED:x} {SATURATED:x}"


def test_it_starts_anywhere(tmp_path):
    program(tmp_path, "battery", 1, 2)
    (tmp_path / "program.c").write_text("""\
#include <stdio.h>
#include "device.h"
int main(void)
{
    static device_device f;
    static const int32_t mean[2] = {123456789, -54321}, sigma[2] = {1000000, 77};
    const int status = device_start_at(&f, mean, sigma);
    printf("%d %ld %ld %ld %ld", status, (long)device_mean_charge(&f), (long)device_mean_polarisation(&f), (long)device_sigma_charge(&f),
        (long)device_sigma_polarisation(&f));
    return 0;
}
""")
    cc("cc", *SANITIZED, "device.c", "program.c", *objects(*PARTS), "-o", "program", folder=tmp_path)
    assert subprocess.run([tmp_path / "program"], capture_output=True, text=True).stdout == "0 123456789 -54321 1000000 77"


@pytest.mark.parametrize("range_, holds", [(1, False), ((0, 1), True)])
def test_formats_hold_what_is_between_the_ends_of_a_range(range_, holds):
    """A charge that stays where it is in simulated rows, and runs empty in a record: exp(-20 s) grows from 1e-7 to 0.4"""
    model = NonlinearModel(lambda x, t, u: [x[0] - 0.001 * u[0]], lambda x: [3.3 + 0.9 * x[0] - 0.15 * np.exp(-20 * x[0])],
                           x0=[0.8], P0=[1e-4], Q=[1e-8], R=[1e-6], states=[Quantity("charge", range=range_)],
                           measurements=[Quantity("voltage", range=4)], controls=[Quantity("current", range=2)])
    charge = 0.8 - 0.001 * np.arange(760.0)[:, None]
    z = 3.3 + 0.9 * charge - 0.15 * np.exp(-20 * charge) + 1e-3 * np.random.default_rng(3).normal(size=charge.shape)
    record = recorded(model, z, np.ones_like(charge))
    product = compiled_fixed(model, "device", simulated(model))
    with Host(compiled_equations(model, "exact", Options("f64"))) as exact:
        ran, right = FixedRun(product.arithmetic).run(record), exact.run_record(record)
    worst = (np.abs(ran.mean - right.mean) / sigmas(right)).max()
    assert (worst < 1e-4) == holds and any(ran.events & SATURATED) == (not holds)
    assert any("They hold charge from 0 to 1" in one for one in report.lines(product, fixed_report.Tried())) == holds


# ------------------------------------------------------------------------------ functions


@lru_cache(None)
def tried_functions():
    return fixed_functions.functions()


def test_the_table_has_the_errors_of_all_functions_and_the_page_says_them():
    with open(ROOT / "tools/cost/fixed.csv", encoding="utf-8") as file:
        rows = {row[0]: row for row in csv.reader(file) if row[0][0] != "#"}
    assert {one.name: [f"{one.error:.1e}", f"{one.last_bits:.2f}"] for one in tried_functions()} == \
        {name: row[2:4] for name, row in rows.items() if name != "function"}
    assert set(FUNCTIONS) <= set(rows) and all(one.last_bits < 4 for one in tried_functions())
    readme = (ROOT / "tools/docs/evidence/compiled.md").read_text(encoding="utf-8")
    lines = readme.split("M3: q31 | f32 | f64 |\n")[1].split("\n\n")[0].splitlines()[1:]
    said = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    assert len(said) > 10
    for name, ranges, bits, *costs in said:
        assert [ranges, *costs] == [rows[name][1], *rows[name][4:]] and bits == f"{float(rows[name][3]):.1f}", name


def told(run, row) -> str:
    far = Far()
    return f"{run(far, *row)[0]} {far.bits}"


def test_functions_are_the_same_bits_in_c(tmp_path):
    """At random raw arguments and at their ends, with the sanitizer"""
    made, lines, calls, wanted = tried_functions(), [], [], []
    ends = [0, 1, -1, 2**30, -2**30, 2**31 - 1, -2**31, 12345]
    draws = np.random.default_rng(5)
    for k, one in enumerate(made):
        count = len(one.ranges)
        rows = [*one.rows.tolist(), *draws.integers(-2**31, 2**31, (200, count)).tolist()]
        rows += draws.choice(ends, (40, count)).tolist()
        cells = ", ".join("{" + ", ".join(map(str, row)) + "}" for row in rows)
        loads = " ".join(f"const int32_t x{i} = x[{i}];" for i in range(count))
        lines += [f"static void f{k}(const int32_t *x, int32_t *e, uint32_t *far) {{ (void)far;", loads, *one.lines, "}",
                  f"static const int32_t given{k}[][{count}] = {{{cells}}};"]
        calls.append(f"for (int i = 0; i < {len(rows)}; i++) {{ int32_t e[1]; uint32_t far = 0; f{k}(given{k}[i], e, &far); "
                     'printf("%ld %lu\\n", (long)e[0], (unsigned long)far); }')
        wanted += [told(one.run, row) for row in rows]
    head = ["#include <stdint.h>", "#include <stdio.h>", fixed_functions.routines(made)]
    text = "\n".join([*head, *lines, "int main(void)", "{", *calls, "return 0;", "}", ""])
    (tmp_path / "functions.c").write_text(text)
    for compiler in [one for one in ("gcc", "clang") if shutil.which(one)]:
        cc(compiler, *SANITIZED, "functions.c", "-o", "functions", folder=tmp_path)
        assert subprocess.run([tmp_path / "functions"], capture_output=True, text=True).stdout.splitlines() == wanted, compiler


# ------------------------------------------------------------------------------ the command


@pytest.mark.parametrize("name", first(1, ["attitude", "battery", "gps_imu"]))
def test_its_files_are_free_of_warnings_and_its_test_says_ok(name, tmp_path):
    texts = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        succeeds("compile", path_of(name), "--library", "--arith", "q31", "-o", tmp_path / folder / "own.c")
        texts.append({path.name: path.read_text() for path in (tmp_path / folder).iterdir()})
    assert texts[0] == texts[1] and sorted(texts[0]) == ["own.c", "own.h", "own_report.txt", "own_test.c"]
    report = " ".join(texts[0]["own_report.txt"].split())
    assert "means within" in report and "2 bits more than they used" in report
    for compiler in filter(shutil.which, ("gcc", "clang")):
        passes(tmp_path / "one", "own", *objects(*PARTS), compiler=compiler, flags=SANITIZED)
    cc("g++", "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{ROOT / 'include'}", "-fsyntax-only", "-x", "c++", "-include",
       "own.h", os.devnull, folder=tmp_path / "one")
