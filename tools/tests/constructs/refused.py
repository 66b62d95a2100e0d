"""Functions without a formula.  Under each: what is said of it, after its file, its line and the text of that."""

import cmath
import copy
import datetime
import functools
import json
import math
import random
import statistics

import numpy as np
import scipy.linalg
import scipy.special
from scipy.interpolate import CubicSpline

TABLE, BY_KEY, SEEN = [0.0, 1.0, 4.0, 9.0], {0: 1.0, 1: 2.0}, []
buffer, whole = np.zeros(3), np.zeros(3, int)
state = {"last": 0.0}
spline = CubicSpline([0.0, 1.0, 2.0], [0.0, 1.0, 4.0])
calls, previous = 0, None
generator = np.random.default_rng(1)
NUMBER, KEY, CHOICE = "wants a number where there is a formula.*np.interp", "looked up in a dict.*write comparisons", "np.where"
TWICE, KEEPS = "answers differently when it is called twice.*of x, t and u alone", "keeps {} between calls.*of x, t and u alone"
EXPECTED = {}


def says(reason, line=""):
    """line: what is in the line that is named"""
    def register(function):
        EXPECTED[function.__name__] = function, line, reason
        return function
    return register


def many_paths(x):
    total = 0.0
    for k in range(7):
        if x[k % 3] > k:
            total = total + x[0] * k
    return [total]


def until(x):
    angle = x[0]
    while angle > math.pi:
        angle -= 2 * math.pi
    return [angle]


def halved(value): return halved(value / 2) if value > 1 else value


says("more than 64 paths: write its branches as np.where")(many_paths)
says("more than 64 branches on one path.*fixed number of rounds, or floor", "while angle > math.pi")(until)


@says("more than 64 branches on one path.*fixed number", "halved(")
def recursion(x): return [halved(x[0])]
@says(NUMBER, "TABLE[int(x[0])]")
def looked_up(x): return [TABLE[int(x[0])]]
@says(NUMBER)
def index_of_an_array(x): return [buffer[int(x[0])]]
@says(NUMBER)
def rounds(x): return [sum(x[0] for _ in range(int(x[1])))]
@says(NUMBER)
def repeated(x): return [len([1.0] * x[0])]
@says(KEY)
def key(x): return [BY_KEY[x[0]]]
@says(KEY)
def key_with_default(x): return [BY_KEY.get(x[0], 0.0)]
@says(KEY)
def in_a_set(x): return [1.0 if x[0] in {1.0, 2.0} else x[1]]
TEXT = "text with a number in it has no formula: leave it out"


@says(TEXT, 'f"{x[0]:.2f}"')
def formatted(x): return [float(f"{x[0]:.2f}")]
@says(TEXT)
def text(x): return [float(str(x[0]))]
@says(TEXT)
def sign_by_a_text(x): return [-1.0 if f"{x[0]}".startswith("-") else 1.0]
@says(TEXT)
def text_of_an_array(x): return [len(str(x)) * x[0]]
@says("sum of two comparisons")
def product_of_comparisons(x): return [np.dot(x > 0, x > -1)]
@says("sum of two comparisons")
def comparison_and_true(x): return [True + (x[0] > 0)]
@says(KEY + ".*row t is a control")
def schedule(x, t): return [BY_KEY.get(t, x[0])]
@says(NUMBER + ".*row t is a control")
def row_of_a_list(x, t): return [TABLE[t] * x[0]]
@says(NUMBER)
def array_of_floats_in_single(x): d = np.zeros(3, np.float32); d[0] = x[0]; return d
@says(NUMBER)
def integers_like(x): d = np.zeros_like(x, dtype=int); d[0] = x[0]; return d
@says("%")
def old_format(x): return [float("%.2f" % x[0])]
@says("erf has no formula here")
def error_function(x): return [math.erf(x[0])]
@says("gamma has no formula here")
def gamma(x): return [math.gamma(x[0])]
@says("erf has no formula here")
def of_scipy(x): return scipy.special.erf(x)
@says(NUMBER + "|has no formula here")
def expm(x): return scipy.linalg.expm(np.diag(x)).ravel()
@says(NUMBER + "|has no formula here")
def of_a_spline(x): return [spline(x[0])]
@says("numpy.linalg.eigvalsh has no formula here")
def eigenvalues(x): return np.linalg.eigvalsh(np.outer(x, x))
@says("numpy.linalg.svd has no formula here")
def singular_values(x): return np.linalg.svd(np.outer(x, x))[1]
@says("numpy.linalg.pinv has no formula here")
def pseudo_inverse(x): return np.linalg.pinv(np.outer(x, x))
@says("numpy.linalg.cholesky has no formula here")
def cholesky(x): return np.linalg.cholesky(np.diag(x))
@says("numpy.linalg.lstsq has no formula here")
def least_squares(x): return np.linalg.lstsq(np.outer(x, x), x, rcond=None)[0]
@says("solved up to 4 x 4: give the solution, or the matrix in numbers")
def five_by_five(x): return np.linalg.solve(np.eye(5) * x[0], np.ones(5))
@says("solved up to 4 x 4")
def inverse_of_five(x): return np.linalg.inv(np.eye(5) + x[0])[0]
@says("linalg.norm of this kind.*np.sqrt")
def nuclear(x): return np.linalg.norm(np.outer(x, x), "nuc")
@says(TWICE)
def drawn(x): return x + np.random.normal(size=3)
@says(TWICE)
def drawn_by_a_generator(x): return x + generator.normal()
@says(TWICE)
def drawn_by_python(x): return [x[0] + random.random()]
@says(TWICE)
def of_the_clock(x): return [x[0] + datetime.datetime.now().timestamp()]


@says(TWICE)
def counting(x):
    global calls
    calls += 1
    return [x[0] * calls]


@says(KEEPS.format("previous"))
def first_call(x):
    global previous
    if previous is None:
        previous = x.copy()
    return x - previous


@says(KEEPS.format("something in a list"))
def appended(x): SEEN.append(x[0]); return [SEEN[0] * 2]
@says(KEEPS.format("last"))
def kept_in_a_dict(x): state["last"] = x[0]; return [x[1]]
@says(KEEPS.format("something in a list"))
def kept_in_a_default(x, t=0, seen=[]): seen.append(x[0]); return [x[1] + 0 * len(seen)]  # noqa: B006


class Kept:
    last = None

    @classmethod
    def of_all(cls, x): cls.last = x[1]; return [cls.last]

    def __init__(self): self.angle = 0.0
    def f(self, x): self.angle = x[0]; return [self.angle]


kept = Kept()
@says(KEEPS.format("Kept.angle"))
def kept_in_an_object(x): return kept.f(x)
@says(KEEPS.format("Kept.last"))
def kept_in_a_class(x): return Kept.of_all(x)
@says(NUMBER, "buffer[0] = x[0]")
def array_from_outside(x): buffer[0] = x[0]; return buffer
@says(NUMBER)
def added_to_an_array_from_outside(x): np.add(buffer, x, out=buffer); return buffer
@says(NUMBER)
def array_of_integers(x): d = np.zeros(3, int); d[0] = x[0]; return d
@says(NUMBER)
def list_of_integers(x): d = np.array([0, 1, 2]); d[1] = x[1]; return d
@says("complex numbers.*real and imaginary parts")
def complex_number(x): return [np.abs(x[0] + 1j * x[1])]
@says("complex numbers")
def complex_answer(x): return [complex(x[0], x[1])]
@says("complex numbers")
def complex_exponential(x): return [cmath.exp(x[0]).real]
@says("complex numbers|has no formula here")
def fourier(x): return np.abs(np.fft.fft(x))
@says("numbers of float32 have no formula here: write float")
def single(x): return x.astype(np.float32) * 2
@says(NUMBER)
def number_of_numpy(x): return [np.float64(x[0]) * 2]
@says("numbers of float32")
def array_of_single(x): return np.array(x, dtype=np.float32)
@says("has no fixed length: write " + CHOICE)
def selected(x): return [np.sum(x[x > 0])]
@says("where without two branches.*" + CHOICE)
def where_alone(x): return np.where(x > 0)[0]
@says("without period")
def periodic_table(x): return [np.interp(x[0], [0, 1], [1, 2], period=2.0)]
@says("table of numbers")
def table_of_formulas(x): return [np.interp(0.5, [0.0, 1.0], [x[0], x[1]])]
@says("whose points increase")
def table_with_a_step(x): return [np.interp(x[0], [0, 1, 1, 2], [0, 0, 1, 1])]
@says("sum of two comparisons.*np.logical_or")
def sum_of_comparisons(x): return [((x[0] > 0) + (x[1] > 0)) * x[2]]
@says("bits of a number.*write % and //")
def bits(x, t): return [x[0] * (t & 1)]
@says("has no formula here|TypeError")
def counts(x): return np.bincount(x)
@says(NUMBER)
def from_an_iterator(x): return np.fromiter((2 * one for one in x), float)
@says("answers 1 numbers on one branch and 2 on another|answers 2 numbers on one branch and 1 on another")
def lengths(x): return [x[0]] if x[0] > 0 else [x[0], x[1]]
@says("answers NoneType, no numbers")
def nothing(x): x * 2
@says("answers str, no numbers")
def a_text(x): return ["fast"]
@says("a number that is not finite \\(nan\\).*np.empty")
def not_filled(x): d = np.empty(3); d[0] = x[0]; return d
@says("a number that is not finite \\(inf\\)", "np.log(d)")
def logarithm_of_zero(x): d = np.zeros(3); return -np.log(d) * 2 + x
@says("a number that is not finite \\(nan\\)")
def missing(x): return [x[0] if x[0] > 0 else np.nan]
@says("AssertionError: out of range", 'assert x[0] > 0')
def checked(x): assert x[0] > 0, "out of range"; return [x[0]]
@says("ValueError: too far")
def guarded(x):
    if x[0] > 100:
        raise ValueError("too far")
    return [x[0]]


@says(NUMBER, "int(np.float64(x[0]))")
def swallowed(x):
    try:
        k = int(np.float64(x[0]))
    except Exception:
        k = 0
    return [x[0] * k]


@says(NUMBER, "math.sin(x[0])")
def imported_inside(x):
    import math
    return [math.sin(x[0])]


@says("a formula has not|has no formula here")
def method_of_numpy(x): return [x[0].tobytes()[0]]
@says("has no attribute 'angle'")
def misspelt(x): return [x[0].angle]
@says("not JSON serializable|can't serialize|wants")
def written(x): return [float(json.loads(json.dumps(x[0])))]
@says("has no formula here|convert|numerator|wants a number")
def mean_of_python(x): return [statistics.mean(x)]
@says("has no formula here")
def of_three_numbers(x): return [np.frexp(x[0])[0]]
@says("IndexError")
def beyond(x): return [x[3]]
@says("solved up to 4 x 4")
def determinant_of_five(x): return [np.linalg.det(np.eye(5) * x[0])]
@says("gcd has no formula here")
def divisor(x): return [math.gcd(x[0], 2)]
@says("max of arrays has no formula here: write np.maximum")
def larger_array(x): return max(x[0], x * 2)
@says("ambiguous|truth value")
def array_as_condition(x): return x if x > 0 else -x
@says("takes more than 20000 operations: give fewer rounds")
def endless(x):
    y = x[0]
    for _ in range(30000):
        y = y * 1.001 + x[1]
    return [y]
