"""The site's first page: its commands as they stand there, but for the installation; and the pages that are made."""

from __future__ import annotations

import os
import re
import runpy
import shutil
import subprocess
import sys

import pytest
from library import ROOT

import kalmanq

BLOCKS = re.findall(r"^```sh\n(.*?)^```", (ROOT / "tools/docs/start.md").read_text(encoding="utf-8"), re.S | re.M)


@pytest.mark.skipif(not all(map(shutil.which, ("arm-none-eabi-gcc", "qemu-system-arm"))), reason="no emulator of Arm")
def test_five_minutes(tmp_path):
    for name in ("tools", "port", "include", "src"):
        (tmp_path / name).symlink_to(ROOT / name)
    kalmanq = tmp_path / "bin" / "kalmanq"
    kalmanq.parent.mkdir()
    kalmanq.write_text(f'#!/bin/sh\nexec "{sys.executable}" -B -m kalmanq.command_line "$@"\n')
    kalmanq.chmod(0o755)
    program = re.search(r"^```c\n(.*?)^```\n+```text\n(.*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S | re.M)
    (tmp_path / "cart.c").write_text(program.group(1))
    has_riscv = all(map(shutil.which, ("riscv64-unknown-elf-gcc", "qemu-system-riscv32")))
    blocks = [one for one in BLOCKS if has_riscv or "riscv" not in one]
    lines = "".join(blocks).replace("pip install -v './tools[all]'\n", "")
    done = subprocess.run(["bash", "-euc", lines], cwd=tmp_path, capture_output=True, text=True, timeout=300,
                          env={**os.environ, "PATH": f"{kalmanq.parent}:{os.environ['PATH']}"})
    assert done.returncode == 0, done.stderr
    assert (done.stdout + done.stderr).count("walk: 0 wrong") == 2 + has_riscv and done.stdout.endswith(program.group(2)) and (tmp_path / "my.png").read_bytes()[1:4] == b"PNG"
    sizes = subprocess.run(["arm-none-eabi-size", tmp_path / "cart.elf"], check=True, capture_output=True, text=True).stdout
    assert int(sizes.splitlines()[1].split()[0]) < 55000  # with printf, 77000 where what is not called is linked


@pytest.mark.parametrize("word, page", [("EKF", "guides/nonlinear"), ("UKF", "guides/nonlinear"), ("unscented", "guides/nonlinear"),
                                        ("Mahalanobis", "guides/outliers"), ("duplicate time", "reference/data_files")])
def test_a_search_for_the_field_s_word_finds_the_page(word, page):
    assert word in (ROOT / f"tools/docs/{page}.md").read_text(encoding="utf-8")


def test_made_pages_have_every_header_name_and_command():
    made = runpy.run_path(str(ROOT / "tools/docs/make_pages.py"))
    pages = made["python"]()
    assert set(pages) == {"python", *(f"python/{name}" for name in kalmanq.__all__)} and ".. autofunction:: kalmanq.fit\n" in pages["python/fit"]
    headers = made["headers"]()
    names = [path.stem for path in (ROOT / "include/kalmanq").glob("*.h")]
    assert all(f"doxygenfile}} {name}.h" in headers[f"headers/{name}"] and f"\nheaders/{name}\n" in headers["headers"] for name in names)
    assert "--smooth" in made["helped"]("run")


def test_a_function_of_the_reference_has_its_parameters_its_errors_and_links():
    made = runpy.run_path(str(ROOT / "tools/docs/for_doxygen.py"))
    folder = ROOT / "include/kalmanq"
    made["FUNCTIONS"].update(made["functions"](folder))
    before = re.split(r"(?=kq_status (kq_\w+)\()", made["made"]((folder / "filter.h").read_text(encoding="utf-8")))
    said = dict(zip(before[1::2], before[0::2], strict=False))
    assert all(f"\n@param {name} " in said["kq_update_f32"].rpartition("/**")[2] for name in "fsz")
    assert "<b>Errors:</b> KQ_ERR_NULL" in said["kq_update_f32"] and said["kq_update_f64"].endswith("/** As kq_update_f32(). */\nKQ_NODISCARD ")
    assert "@param f with sizes and memory; written" in said["kq_filter_init_q31"].rpartition("/**")[2]  # its twin's
    assert '@ref kq_process_init_root_f32 "kq_process_init_root"' in said["kq_filter_init_root_f32"]
    assert "@cond */\ntypedef struct {\n    uint8_t states;" in made["made"]((folder / "filter.h").read_text(encoding="utf-8"))
