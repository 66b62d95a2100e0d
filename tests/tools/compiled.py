"""Filters that kalmanq compile has written, compiled for this machine and run over arrays."""

from __future__ import annotations

import ctypes
import pickle
import subprocess
from pathlib import Path
from typing import Optional

import numpy as np

from kalmanq import Model
from kalmanq.compiler.proven.files import texts_of
from kalmanq.compiler.proven import product as proven
from kalmanq.compiler.proven.product import Product, Wanted
from kalmanq.compiler.host import compiler

STRICT = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow",
          "-Werror")


_MADE: dict[tuple[bytes, Wanted], Product] = {}


def compiled(model: Model, wanted: Wanted) -> Product:
    """The compiler's own, searched once for each model and what is wanted of it"""
    key = pickle.dumps(model), wanted
    if key not in _MADE:
        _MADE[key] = proven.compiled(model, wanted)
    return _MADE[key]


class Compiled:
    """run(z, u): means T x n, variances T x n (0 where none are carried), NIS, and what was refused"""

    def __init__(self, model: Model, folder: Path, arithmetic: str, **wanted: object):
        self.model, self.folder = model, folder
        self.product: Product = compiled(model, Wanted(arithmetic, "filter_x", **wanted))  # type: ignore[arg-type]
        for name, text in texts_of(self.product, "0").items():
            (folder / name).write_text(text, encoding="utf-8")
        (folder / "driver.c").write_text(driver(self.product), encoding="utf-8")
        self._library: Optional[ctypes.CDLL] = None

    def program(self) -> subprocess.CompletedProcess:
        """NAME_test"""
        make(self.folder, ["filter_x.c", "filter_x_test.c"], "trial", "-lm")
        return subprocess.run([str(self.folder / "trial")], capture_output=True, text=True)

    def run(self, z: np.ndarray, u: Optional[np.ndarray] = None,
            missed_by_predict: bool = True) -> dict[str, np.ndarray]:
        if self._library is None:
            make(self.folder, ["filter_x.c", "driver.c"], "driver.so", "-shared", "-fPIC", "-lm")
            self._library = ctypes.CDLL(str(self.folder / "driver.so"))
        m = self.model
        z = np.asarray(z, float).reshape(-1, m.m)
        moved = np.zeros((len(z), max(m.l, 1)))
        if u is not None and m.l:
            moved[1:] = np.asarray(u, float).reshape(len(z), -1)[:-1]
        out = {"mean": np.zeros((len(z), m.n)), "variance": np.zeros((len(z), m.n)), "nis": np.zeros(len(z)),
               "likelihood": np.zeros(len(z)), "refused": np.zeros((len(z), 2)),
               "lagged": np.full((len(z), m.n), np.nan)}
        given = np.ascontiguousarray(np.nan_to_num(z, nan=0.0 if missed_by_predict else np.nan))
        present = np.ascontiguousarray(~np.isnan(z) if missed_by_predict else np.ones_like(z), np.uint8)
        arrays = [given, present, moved, *out.values()]
        self._library.run(len(z), *(ctypes.c_void_p(one.ctypes.data) for one in arrays))
        return out


def make(folder: Path, sources: list[str], target: str, *flags: str) -> None:
    done = subprocess.run([compiler(), *STRICT, "-ffp-contract=off", *(str(folder / one) for one in sources), *flags,
                           "-o",
                           str(folder / target)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def driver(product: Product) -> str:
    """All rows in C; words are rounded from doubles and read as doubles."""
    plan, name = product.plan, product.plan.name
    m, fixed = plan.model, plan.subject.words.is_fixed
    scale = {which: [2.0 ** plan.fraction(which, k) if fixed else 1.0 for k in range(size)]
             for which, size in (("states", m.n), ("measurements", m.m), ("controls", m.l))}
    word = plan.subject.words.type
    u = ", w" if m.l else ""
    lines = ["#include <math.h>", f'#include "{name}.h"',
             "void run(int rows, const double *z, const unsigned char *present, const double *u, double *mean,",
             "         double *variance, double *nis, double *likelihood, double *refused, double *lagged);",
             "void run(int rows, const double *z, const unsigned char *present, const double *u, double *mean,",
             "         double *variance, double *nis, double *likelihood, double *refused, double *lagged)", "{",
             f"    {name}_filter f;", f"    {name}_start(&f);",
             "    (void)u, (void)variance, (void)nis, (void)likelihood, (void)lagged;",
             *([f"    {name}_lag l;", f"    {name}_lag_start(&l);"] if plan.lag else []),
             "    for (int t = 0; t < rows; t++) {", f"        {word} v[{m.m}], w[{max(m.l, 1)}];",
             "        unsigned bits = 0;"]
    convert = "({})lrint({} * {})" if fixed else "({})({} * {})"
    lines += [f"        v[{j}] = {convert.format(word, f'z[t * {m.m} + {j}]', repr(scale['measurements'][j]))};"
              f" bits |= (unsigned)present[t * {m.m} + {j}] << {j};" for j in range(m.m)]
    lines += [f"        w[{k}] = {convert.format(word, f'u[t * {m.l} + {k}]', repr(scale['controls'][k]))};"
              for k in range(m.l)] or ["        (void)w;"]
    some = plan.partial
    first = f"{name}_update_some(&f, v, bits)" if some else f"{name}_update(&f, v)"
    other = f"{name}_step_some(&f{u}, v, bits)" if some else f"{name}_step(&f{u}, v)"
    lines += ["        if (t == 0) {", f"            if (bits) {first};",
              f"        }} else if (bits == 0) {name}_predict(&f{u});", f"        else {other};"]
    for i, state in enumerate(plan.subject.states):
        lines.append(f"        mean[t * {m.n} + {i}] = (double){name}_mean_{state}(&f) / {scale['states'][i]!r};")
        if plan.carries_covariance:
            point = 2.0 ** plan.subject.words.covariance(i, i) if fixed else 1.0
            lines.append(f"        variance[t * {m.n} + {i}] = (double){name}_variance_{state}(&f) / {point!r};")
    if plan.nis:
        lines.append(f"        nis[t] = (double)f.nis / {2.0 ** plan.subject.words.formats.nis if fixed else 1.0!r};")
        lines += [] if fixed else [f"        likelihood[t] = (double){name}_log_likelihood(&f);"]
    if plan.lag:
        lines += [f"        if ({name}_lag_step(&l, &f)) {{"]
        lines += [f"            lagged[t * {m.n} + {i}] = (double){name}_lagged_{state}(&l) / {scale['states'][i]!r};"
                  for i, state in enumerate(plan.subject.states)] + ["        }"]
    return "\n".join([*lines, "        refused[2 * t] = !!(f.events & FILTER_X_SIGMA_SATURATED);",
                      "        refused[2 * t + 1] = f.events & FILTER_X_REFUSED;",
                      "    }", "}", ""])
