"""kalmanq compile --library: a nonlinear model over the library comes to what the straight-line C in double comes to."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import kalmanq as kalmanq_package
from command import kalmanq
from compiled import STRICT
from kalmanq.compiler import equation_report
from kalmanq.compiler.emit import Row
from kalmanq.compiler.equation_device_text import compiled_device, in_whole_groups
from kalmanq.compiler.equation_product import compiled_equations
from kalmanq.compiler.host import Host
from kalmanq.compiler.request import Options
from kalmanq.nonlinear import read

ROOT, OWN = Path(__file__).resolve().parents[2], Path(__file__).parent / "equations"
EXAMPLES = Path(kalmanq_package.__file__).parent / "examples"
MODELS = [EXAMPLES / "battery.py", EXAMPLES / "range_bearing.py", OWN / "attitude.py", OWN / "drift.py"]
MOST = {"f32": 1e-3, "f64": 1e-9}  # sigma
ROWS, NEAR = 300, 100  # of range_bearing the target is 2 km away in the end, where float rounds h to 3e-3 sigma in any filter
DRIVER = """\
#include "{name}.h"
void run(int rows, const unsigned char *what, const unsigned *present, const double *z, const double *u, const double *now,
         double *mean, double *P, unsigned *taken);
void run(int rows, const unsigned char *what, const unsigned *present, const double *z, const double *u, const double *now,
         double *mean, double *P, unsigned *taken)
{{
    static {name}_device f;
    if ({name}_start(&f)) return;
    for (int t = 0; t < rows; t++, z += {m}, u += {l}, now += {l}) {{
        {type} v[{m}], w[{l} + 1], at[{l} + 1], covariance[{n} * {n}];
        (void)w, (void)at;
        for (int k = 0; k < {m}; k++) v[k] = ({type})z[k];
        for (int k = 0; k < {l}; k++) w[k] = ({type})u[k], at[k] = ({type})now[k];
        taken[t] = 0;
        {calls}
        {means}
        if (kq_covariance_{T}({name}_filter(&f), covariance)) return;
        for (int k = 0; k < {n} * {n}; k++) *P++ = (double)covariance[k];
    }}
}}
"""


def build(folder: Path, arguments: list, compiler: str = "cc") -> None:
    done = subprocess.run([compiler, *map(str, arguments)], capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="session")
def library(tmp_path_factory) -> Path:
    work = tmp_path_factory.mktemp("library")
    for part in ("filter_f32", "nonlinear_f32", "filter_f64", "nonlinear_f64", "status"):
        build(work, ["-std=c11", "-O1", "-ffp-contract=off", "-fPIC", f"-I{ROOT / 'include'}", "-c", ROOT / "src" / f"kq_{part}.c"])
    return work


def parts(library: Path, T: str) -> list[Path]:
    return [library / f"kq_{part}.o" for part in (f"filter_{T}", f"nonlinear_{T}", "status")]


def ran(product, record, library: Path, folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    given, a, name = product.given, product.arithmetic, product.given.name
    calls = product.text.row(Row("what[t]", "present[t]", "v", "w", "at", f"(({a.type})t)", "taken[t]"))
    means = [f"*mean++ = (double){name}_mean_{one}(&f);" for one in given.carried]
    files = {**product.sources(), "driver.c": DRIVER.format(name=name, m=given.of.m, l=given.of.l, n=given.of.n, type=a.type, T=a.T,
                                                            calls="\n        ".join(calls), means="\n        ".join(means))}
    for file, text in files.items():
        (folder / file).write_text(text)
    build(folder, [*STRICT, "-ffp-contract=off", "-fPIC", "-shared", f"-I{ROOT / 'include'}", f"{name}.c", "driver.c",
                   *parts(library, a.T), "-lm", "-o", "run.so"])
    rows, n = len(record.what), given.of.n
    made = np.full((rows, len(given.carried)), np.nan), np.full((rows, n, n), np.nan), np.zeros(rows, np.uint32)
    arrays = [np.ascontiguousarray(one) for one in (record.what, record.present, record.z, record.u, record.now)]
    ctypes.CDLL(str(folder / "run.so")).run(rows, *(ctypes.c_void_p(one.ctypes.data) for one in (*arrays, *made)))
    return made


@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_it_comes_to_what_straight_lines_in_double_come_to(path, arithmetic, library, tmp_path):
    model = read(path)
    product = compiled_device(model, "device", Options(arithmetic))
    with Host(compiled_equations(model, "straight", Options("f64"))) as straight, \
            Host(compiled_equations(model, "same", Options(arithmetic))) as same:
        for seed in (1, 2, 3):
            record = in_whole_groups(equation_report.drawn(model, ROWS, seed)[0], product.given.together)
            assert np.any(record.present != 2**model.m - 1)
            exact = straight.run(record.z, record.u, record.present, record.what, now=record.now)
            folder = tmp_path / str(seed)
            folder.mkdir()
            mean, P, taken = ran(product, record, library, folder)
            sigma = np.sqrt(np.einsum("tii->ti", exact.covariance))
            others = same.run(record.z, record.u, record.present, record.what, now=record.now).mean
            apart, theirs = (np.abs([model.minus(*pair) for pair in zip(one, exact.mean)]) / sigma for one in (mean, others))
            spread = (P - exact.covariance) / (sigma[:, :, None] * sigma[:, None, :])
            assert np.array_equal(taken, exact.taken)
            assert apart[:NEAR].max() < MOST[arithmetic] and np.abs(spread).max() < MOST[arithmetic]
            assert apart.max() < max(MOST[arithmetic], 1.5 * theirs.max())


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_its_files_are_free_of_warnings_and_its_test_says_ok(path, library, tmp_path):
    for T in ("f32", "f64"):
        done = kalmanq("compile", path, "--library", "--arith", T, "-o", tmp_path / f"own_{T}.c")
        assert done.returncode == 0, done.stderr
        sources = [f"own_{T}.c", f"own_{T}_test.c"]
        for compiler in [one for one in ("gcc", "clang") if shutil.which(one)]:
            build(tmp_path, [*STRICT, f"-I{ROOT / 'include'}", "-ffp-contract=off", *sources, *parts(library, T), "-lm", "-o", "trial"],
                  compiler)
            assert subprocess.run([tmp_path / "trial"], capture_output=True, text=True).stdout.endswith("OK\n"), compiler
        build(tmp_path, ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{ROOT / 'include'}", "-fsyntax-only", "-x", "c++",
                         "-include", f"own_{T}.h", os.devnull], "g++")


def test_what_is_linear_is_told_once_and_the_rest_in_each_call(tmp_path):
    texts = {path.stem: compiled_device(read(path), path.stem, Options()).code for path in MODELS}
    for name in ("battery", "range_bearing"):
        assert "kq_predict_f32(" in texts[name] and "kq_predict_extended" not in texts[name]
    assert "f->H[" in texts["range_bearing"] and "f->H[2]" not in texts["range_bearing"]
    assert "device_reset" not in texts["drift"] and "kq_sensor_init_diagonal_f32(&f->sensor_mark, H_mark, R_mark)" in texts["drift"]
    assert "f->A[1] = u[0]" in texts["drift"].replace("u0;", "u[0];") and "f->A[0]" not in texts["drift"]
    assert "kq_move_f32" in texts["attitude"]


@pytest.mark.parametrize("option, call", [(["--gate", 3], "kq_loss_gate"), (["--student", 10], "kq_loss_student"), (["--nis"], "kq_nis"),
                                          (["--iterate", 3], "sigma_points.h"), (["--smooth", 9], "kq_smooth")])
def test_options_of_straight_lines_name_the_library_s_call(option, call, tmp_path):
    done = kalmanq("compile", EXAMPLES / "range_bearing.py", "--library", *option, "-o", tmp_path / "own.c")
    assert done.returncode and option[0] in done.stderr and call in done.stderr and not (tmp_path / "own.c").exists()


def test_a_constant_model_is_sent_to_design(tmp_path):
    done = kalmanq("compile", EXAMPLES / "constant_velocity.toml", "--library", "-o", tmp_path / "own.c")
    assert done.returncode and "kalmanq design" in done.stderr
