"""Compiled filters in q31: beside long double, with no undefined behaviour, whatever words they are given."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import products
import pytest
from library import cc, written

from kalmanq import Model, Quantity
from kalmanq.compiler.algorithm.fixed.rescaled import RescaledWords
from kalmanq.compiler.algorithm.fixed.routines import routines
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run import record
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.compiler.text.product import Product, compiled

TRAPS = ("-fsanitize=undefined", "-fsanitize-undefined-trap-on-error")
STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
MEAN, COVARIANCE = 2e-4, 1e-4  # sigma, sigma_i sigma_j: of these products at most 1.6e-4 and 5.3e-5


def compared(given, drawn, ran) -> record.Accuracy:
    """With long double"""
    return record.apart(given, drawn, ran, *record.exact_of(given, drawn, ran.taken))


def companion() -> Model:
    """A row of A with sum |A_ik| of 8.6"""
    A = np.zeros((4, 4))
    A[0], A[1:, :3] = -np.poly([0.95, 0.9, 0.8, 0.5])[1:], np.eye(3)
    return Model(A, H=[1, 0, 0, 0], R=0.5, Q=[1, 0, 0, 0], P0=[10] * 4, name="companion",
                 states=[Quantity(f"x{i}", "", 1000) for i in range(4)], measurements=[Quantity("z", "", 1000)])


def fixed_bias() -> Model:
    """A bias that nothing moves: never settled"""
    return Model([[1, 0.1], [0, 1]], H=[1, 0], R=0.04, Q=[1e-4, 0], P0=[1, 0.25], name="fixed_bias",
                 states=[Quantity("place", "", 100), Quantity("bias", "", 5)], measurements=[Quantity("z", "", 100)])


def compiled_words(model: Model, **options: object) -> Product:
    return compiled(model, model.name, Options(arithmetic="q31", **options))  # type: ignore[arg-type]


@pytest.mark.parametrize("make", [products.fridge, products.battery, products.gps, products.motor, products.heart,
                                  companion, fixed_bias], ids=lambda one: one.__name__)
def test_is_near_long_double(make):
    """Gaps, samples in part, second updates"""
    product = compiled_words(make())
    with Host(product, TRAPS) as host:
        for seed in (1, 2, 3):
            drawn = record.as_taken(product, record.drawn(product.given, 1000, seed))
            made = compared(product.given, drawn, host.run_record(drawn))
            assert made.mean < (MEAN if make is not companion else 4e-4) and made.covariance < COVARIANCE
            assert made.events == 0


@pytest.mark.parametrize("make, loops", [(products.ultrasound, False), (products.ultrasound, True), (products.pll, False)])
def test_a_long_gap_holds_sigma_and_says_so(make, loops):
    product = compiled_words(make(), loops=loops)
    rows = 3000 if make is products.ultrasound else 100_000
    what = np.ones(rows, np.uint8)
    with Host(product, TRAPS) as host:
        ran = host.run(np.zeros((rows, 1)), None, np.zeros(rows), what)
    bit = 1 << list(product.events).index("SIGMA_SATURATED")
    assert not ran.events[10] and ran.events[-1] == bit and np.array_equal(ran.covariance[-1], ran.covariance[-2])
    assert np.all(np.diff(ran.covariance[:, 0, 0]) >= -1e-6 * ran.covariance[:-1, 0, 0])
    assert np.all(np.isfinite(ran.covariance))


@pytest.mark.parametrize("make, gap", [(products.pll, 6000), (products.bldc, 12_000), (products.well, 4000)])
def test_words_that_have_become_finer_become_coarse_again(make, gap):
    """Samples, a gap in which sigmas grow a thousandfold, samples: beside long double, in all of it"""
    product = compiled_words(make())
    assert isinstance(product.arithmetic, RescaledWords)
    given, rows, within = product.given, gap + 1000, slice(500, 500 + gap)
    drawn = record.as_taken(product, record.drawn(given, rows, 1, 1))
    what, present = np.full(rows, PREDICTS | UPDATES, np.uint8), np.full(rows, given.all, np.uint32)
    what[0], what[within], present[within] = UPDATES, PREDICTS, 0
    with Host(product, TRAPS) as host:
        ran = host.run_record(replace(drawn, what=what, present=present))
    _, covariances = record.exact_of(given, replace(drawn, what=what, present=present), ran.taken)
    sigma = np.sqrt(np.einsum("tii->ti", covariances)).astype(float)
    spread = np.abs(ran.covariance - covariances) / (sigma[:, :, None] * sigma[:, None, :])
    assert (sigma[499 + gap] / sigma[499]).max() > 1000
    assert not np.any(ran.events & np.uint32(1 << list(product.events).index("SIGMA_SATURATED"))) and spread.max() < 2 * COVARIANCE


ANY_WORDS = """\
#include "{name}.h"

static uint32_t random(void)
{{
    static uint64_t s = 88172645463325252u;
    s ^= s << 13;
    s ^= s >> 7;
    s ^= s << 17;
    return (uint32_t)(s >> 16);
}}

int main(void)
{{
    static {name}_filter f;
    {name}_start(&f);
    {first}
    for (long k = 0; k < 40000; k++) {{
        int32_t z[{m}], u[{l} + 1];
        for (int j = 0; j < {m}; j++) z[j] = (int32_t)random() / (1 << random() % 31);
        for (int j = 0; j <= {l}; j++) u[j] = (int32_t)random() / (1 << random() % 31);
        (void)u;
        const unsigned kind = random() % 100;
        if (kind < 60) {name}_step(&f{u}, z);
        else if (kind < 80) {name}_predict(&f{u});
        else {name}_update(&f, z);
        {more}
        volatile int64_t read = {name}_covariance(&f, 0, {n} - 1) + {name}_mean_{state}(&f);
        (void)read;
    }}
    return 0;
}}
"""


@pytest.mark.parametrize("make, options", [
    (products.motor, {}), (products.press, {"nis": True}), (products.oven, {"gate": 3.0, "nis": True}),
    (fixed_bias, {}), (products.motor, {"student": 4.0, "nis": True}), (products.press, {"every": (1, 3)}),
    (products.heart, {"lag": 4, "gate": 3.0}), (products.motor, {"loops": True}),
    (companion, {"loops": True, "student": 2.0, "nis": True}), (products.pll, {}), (products.well, {"gate": 3.0}),
    (products.thermistors, {}), (products.bldc, {})], ids=lambda one: getattr(one, "__name__", ""))
def test_no_words_are_undefined_behaviour(make, options, tmp_path: Path):
    product = compiled_words(make(), **options)
    given = product.given
    text = ANY_WORDS.format(name=given.name, n=given.of.n, m=given.of.m, l=given.of.l, state=given.states[0],
                            first=f"static {given.name}_lag l; {given.name}_lag_start(&l);" if given.options.lag else "",
                            more=f"{given.name}_lag_step(&l, &f);" if given.options.lag else "",
                            u=", u" if given.of.l else "")
    written(tmp_path, {**product.sources(), "main.c": text})
    cc("cc", *STRICT, "-O1", *TRAPS, f"{given.name}.c", "main.c", "-o", "any", folder=tmp_path)
    subprocess.run([str(tmp_path / "any")], check=True)


ROOTS = """\
#include <math.h>
#include <stdint.h>
{routines}
int main(void)
{{
    uint64_t s = 88172645463325252u;
    for (long k = 0; k < 300000; k++) {{
        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        const uint64_t t = k < 100000 ? (uint64_t)k + 1 : (s >> 2 >> k % 62) + 1;
        if (t >> 62) continue;
        const reciprocal r = inverse_root(t);
        const long double over = ldexpl(r.over, r.half - 62) * sqrtl((long double)t);
        const long double root = ldexpl(r.root, 1 - r.half) / sqrtl((long double)t);
        const int32_t u = (int32_t)(s % (UINT64_C(1) << 31)) - (1 << 30);
        const long double one = ldexpl(inverse(u), -30) * (1 + fabsl(ldexpl(u, -30)));
        if (r.half < 1 || fabsl(over - 1) > 0x1p-29 || fabsl(root - 1) > 0x1p-28 || fabsl(one - 1) > 0x1p-28) return 1;
    }}
    return inverse_root(0).half != 31;
}}
"""


def test_roots_and_inverses(tmp_path: Path):
    (tmp_path / "roots.c").write_text(ROOTS.format(routines=routines("inverse_root( inverse(")))
    cc("cc", "-std=c11", "-O1", *TRAPS, "roots.c", "-lm", "-o", "roots", folder=tmp_path)
    subprocess.run([str(tmp_path / "roots")], check=True)


def test_the_quotient_without_a_division_is_the_quotient(tmp_path: Path):
    """For each number that it can be asked for; both round down, so that all cores have the same words."""
    (tmp_path / "q.c").write_text("#include <stdint.h>\n" + routines("inverse(") + """
int main(void)
{
    for (uint32_t d = UINT32_C(1) << 15; d < UINT32_C(1) << 16; d++) {
        if (quotient(d) != UINT32_C(0xffffffff) / d) return 1;
    }
    return 0;
}
""")
    cc("cc", *STRICT, "-O2", *TRAPS, "-D__AVR__", "q.c", "-o", "q", folder=tmp_path)
    assert subprocess.run([str(tmp_path / "q")]).returncode == 0


WEIGHTS = """\
#include <math.h>
#include <stdint.h>
{routines}
int main(void)
{{
    static const double freedom[] = {{0.2, 1, 4, 30, 1000}};
    uint64_t s = 88172645463325252u;
    for (long k = 0; k < 200000; k++) {{
        double part[3];
        for (int i = 0; i < 3; i++) {{
            s ^= s << 13;
            s ^= s >> 7;
            s ^= s << 17;
            part[i] = ldexp((double)(s >> 11), -53);
        }}
        const double nu = freedom[k % 5], sigma = exp2(16 + 13.9 * part[0]), y = exp2(1 + 29 * part[1]);
        const double root = exp2(29.9 * part[2]), r = sigma * sigma, spread = root * root;
        const uint64_t least = (uint64_t)(r * nu / (nu + 1));
        int half = 0;
        for (uint64_t one = least; one < UINT64_C(1) << 62; one <<= 2) half++;
        const int32_t mantissa = (int32_t)sqrt(ldexp((double)least, 2 * half - 2));
        long double made = r;
        for (int i = 0; i < 3; i++) {{
            const long double share = made / (spread + made), rest = y * share;
            made = r * nu / (nu + 1) + (rest * rest + spread * share) / (nu + 1);
        }}
        const int32_t weight = student((int32_t)floor(y), (uint64_t)spread, (uint64_t)r, least,
                                       (int32_t)(0x80000000u / (nu + 1)), mantissa, half);
        const long double expected = sqrtl(r * nu / (nu + 1) / made), error = ldexpl(weight, -30) - expected;
        if (fabsl(error) > 1e-4L * expected + 0x1p-28L) return 1;
    }}
    return 0;
}}
"""


def test_weights_of_student(tmp_path: Path):
    """Where sigma of the noise has 16 bits or more of an innovation's word, as it has up to 16000 of them"""
    (tmp_path / "weights.c").write_text(WEIGHTS.format(routines=routines("student(")))
    cc("cc", "-std=c11", "-O1", *TRAPS, "weights.c", "-lm", "-o", "weights", folder=tmp_path)
    subprocess.run([str(tmp_path / "weights")], check=True)
