"""Functions as users write them, of three states; each of them has a formula."""

import functools
import math
import operator
from dataclasses import dataclass
from functools import partial
from math import atan2, sin as sine

import helper
import numpy as np
import numpy.linalg as la
from helper import turned
from numpy import arctan2 as angle_of, zeros
from numpy.linalg import norm

TABLE_X, TABLE_Y = [-1.0, 0.1, 0.5, 0.9, 1.4], np.array([2.8, 3.2, 3.6, 3.9, 4.2])
M = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.25], [0.1, 0.0, 1.0]])
G = 2.0
GAINS = {"fast": 2.0, "slow": 0.5}
ORDER = np.array([2, 0])


def roots(x): return [np.sqrt(x[0] ** 2 + 1), math.sqrt(1 + x[1] ** 2), (x[2] ** 2) ** 0.5, np.cbrt(x[0]), math.hypot(*x)]
def angles(x): return [np.sin(x[0]), np.cos(x[1]), np.tan(x[2] / 4), np.arctan(x[0]), atan2(x[0], x[1]), angle_of(x[1], x[2])]
def inverse_angles(x): return [np.arcsin(x[0] / 9), np.arccos(x[1] / 9), math.asin(x[2] / 9), math.acos(x[0] / 9)]
def exponentials(x): return [np.exp(-x[0]), np.log(2 + x[1] ** 2), math.log(x[0] ** 2 + 1, 3), np.log2(4 + x[0] ** 2), np.log10(3 + x[1] ** 2)]
def exact_near_zero(x): return [np.expm1(x[0] * 1e-9) * 1e9, np.log1p(x[1] * 1e-9) * 1e9, math.expm1(x[2] * 1e-7) * 1e7]
def hyperbolic(x): return [np.sinh(x[0]), np.cosh(x[1]), np.tanh(x[2]), np.arcsinh(x[0]), np.arccosh(2 + x[1] ** 2), np.arctanh(x[2] / 9)]
def whole_arrays(x): return np.sin(x) * 2 + np.exp(-x) / (1 + x * x)
def powers(x): return [x[0] ** 2, x[1] ** 3, x[2] ** -1, abs(x[0]) ** 0.5, 2 ** x[1], np.power(x[2], 4), (1 + x[0] ** 2) ** 1.5, pow(x[1], 17)]
def power_of_two_states(x): return [(1.5 + x[0] ** 2) ** x[1], np.float_power(2 + x[1] ** 2, 1.25), math.pow(2 + x[2] ** 2, 0.3)]
def whole_power_of_a_negative(x, t): return [(-1) ** t * x[0], (-2.0) ** t, x[1]]
def absolutes(x): return [abs(x[0]), np.abs(x[1]), np.fabs(x[2]), np.absolute(x[0] - 1), math.fabs(x[1])]
def signs(x): return [np.sign(x[0]) * x[1], np.copysign(x[0], x[1]), math.copysign(2.0, x[2]) * x[0], np.heaviside(x[1], 0.5) * x[2]]
def wrapped(x): return [(x[0] * 9 + np.pi) % (2 * np.pi) - np.pi, np.mod(x[1] * 5, 1.0), np.remainder(x[2] * 5, -2.0), math.remainder(x[0] * 9, 2 * math.pi)]
def truncated(x): return [np.fmod(x[0] * 7, 2.0), math.fmod(x[1] * 7, -3.0), np.trunc(x[2] * 4), math.trunc(x[0] * 3), np.fix(x[1] * 4), int(x[2] * 3) * x[0]]
def whole_numbers(x): return [np.floor(x[0] * 3), math.ceil(x[1] * 3), x[2] * 5 // 2, 7 // (x[0] + 9), np.floor_divide(x[1] * 9, 2), round(x[2] * 3)]
def counted(x, t): return [t % 49 * x[0], t // 49 + x[1], divmod(t, 7)[1] * x[2], round(t / 2), np.round(t / 2), (t * 0.1) // 0.3]
def to_digits(x): return [round(x[0], 2), np.round(x[1], 3), np.around(x[2] * 1000, -1)]
def degrees(x): return [np.degrees(x[0]), np.deg2rad(x[1]), math.radians(x[2]), np.rad2deg(x[0]), np.radians(x[1])]
def sinc(x): return [np.sinc(x[0]), np.sinc(x[1] - x[1]) * x[2], *np.sinc(x)]
def chosen(x): return [np.where(x[0] > 0, x[1], x[2]), *np.where(x > 0, x, 2 * x), np.where(x[0] > x[1], [x[0], 1.0], x[2])[1]]
def limited(x): return [np.clip(x[0], -0.5, 0.5), *np.clip(x, -1, 1), x.clip(0, None)[1], np.clip(x[2], -np.inf, 0.25), max(min(x[1], 0.5), -0.5)]
def extremes(x): return [max(x[0], x[1]), min(x), np.maximum(x[0], 0.25), *np.minimum(x, x[::-1]), np.max(x), x.min(), np.amax(np.outer(x, x)), max(x[0], 0)]
def one_of_many(x): return [np.select([x[0] > 1, x[0] > 0, x[0] < -1], [x[1], x[2], 3.0], 0.5)]
def in_pieces(x): return np.piecewise(x, [x < -0.5, x > 0.5], [lambda y: -y * y, lambda y: y * y, 0.25])
def table(x): return [np.interp(x[0], TABLE_X, TABLE_Y), *np.interp(x, TABLE_X, TABLE_Y, left=0.0, right=9.0), np.interp(x[1], [0, 1], [2, x.size])]


def branches(x):
    if x[0] > 1 and x[1] > 0:
        return [x[0] * 2, x[1], 0.0]
    elif x[0] < -1 or not x[2] > 0:
        return [x[0] ** 2, x[1] * x[2], 1.0]
    else:
        return [x[0], x[1] if x[2] > 0.5 else x[2], 2.0]


def every_case_is_there(x):
    if x[0] > 0.5:
        y = x[1]
    elif x[0] == 0.5:
        y = 9.0
    elif x[0] < 0.5:
        y = x[2]
    if x[1] < 0:
        z = 1.0
    elif 0 <= x[1] < 1:
        z = x[1]
    elif x[1] >= 1:
        z = x[0]
    return [y, z]


def chained(x): return [x[0] if -1 < x[0] < 1 else 0.0, x[1] if 0 <= x[2] <= 1 else x[0]]
def comparison_as_number(x): return [(x[0] > 0) * x[1], (x[1] > 0) * 1.0, 1 - (x[2] <= 0.5), (x[0] > 0) == (x[1] > 0), x[2] != 1]
def counts(x): return [np.sum(x > 0), (x > 0.5).sum() * x[0], sum([x[0] > 0, x[1] > 0]), np.mean(x < 0), np.count_nonzero(x > 0)]
def bits_of_comparisons(x): return [np.where((x[0] > 0) & (x[1] > 0) | ~(x[2] > 0), x[0], x[1]), np.where(np.logical_xor(x[0] > 0, x[1] > 0), 1, x[2])]
def all_and_any(x): return [x[0] if np.any(x > 1) else x[1], x[1] if np.all(x > -1) else x[2], 1.0 if (x > 0).any() else 0.0, x[2] if any(a > 1 for a in x) else 3.0]
def nearly(x): return [1.0 if np.isclose(x[0], 0.0, atol=0.5) else x[1], x[2] if np.allclose(x, 0, atol=1.0) else 0.0, math.isclose(x[1], 1, rel_tol=0.5)]
def finite(x): return [x[0] if np.isfinite(x[0]) and not math.isnan(x[1]) else 0.0, *np.where(np.isnan(x), 0.0, x)]
def truthy(x): return [x[1] if x[0] else 3.0, x[0] or x[1], x[0] and x[2], bool(x[1]) * x[2]]
def masked(x): y = x.copy(); y[y < 0] = 0.0; y[x > 1] = 1; return y
def sorted_values(x): return [*sorted(x), *np.sort(x), x[np.argmax(x)], x[int(np.argmin(x))], x[np.argsort(x)[1]]]
def in_a_list(x): return [1.0 if x[0] in [1.0, 2.0] else x[1], 0.0 if x[2] is None else x[2], 1.0 if x[1] == None else x[0]]  # noqa: E711


def fixed_rounds(x):
    y = x
    for k in range(5):
        y = y + 0.1 * np.sin(y) / (k + 1)
    while k < 8:
        y, k = y * 0.9, k + 1
    return y


def lists_and_tuples(x):
    made, pair = [], (x[0], x[1] * 2)
    for one in x:
        made.append(one ** 2)
    made.extend([*pair, len(x), sum(x)])
    named = {"a": x[0] * GAINS["fast"], **{f"b{k}": one for k, one in enumerate(x)}}
    return made + [named["a"], named["b2"]] + [a * b for a, b in zip(x, x[1:])] + list(map(lambda one: -one, x))


def unpacked(x): a, b, c = x; (d, *rest), e = [x, a]; return [a * b, b + c, d, *rest, e]
def filled(x): d = np.zeros(3); d[0] = x[1] * 0.1; d[1:] = x[:2]; d[-1] += 1; return d
def filled_matrix(x): F = np.eye(3); F[0, 1] = x[0]; F[1:, 2] = [x[1], 0.5]; F[:, 0] *= 2; return F @ x
def filled_otherwise(x): d, e = zeros(3), np.empty(2); e[:] = x[1:]; d[[0, 2]] = e; d[ORDER] += 1.0; return [*d, *np.full(2, x[0]), *np.full(2, 0.5) * e]
def numbers_in_arrays(x): d = np.zeros(3); d[0], d[1] = -8.0, x[0]; return [d[0] * d[1], 1 / (d[0] + 1), np.cbrt(d)[0] + x[1], d[2] + 1, *np.exp([x[0], 0.5])]
def like_others(x): y = np.zeros_like(x); y[1] = x[0]; return y + np.ones_like(x) + np.full_like(x, 0.5) * x
def in_place(x): y = x.copy(); y[0] += x[1]; y *= 2; y -= 1; y /= 3; y **= 2; return y
def aliased(x): y = np.asarray(x); y[0] = 5.0; z = x[1:]; z[0] *= 2; x.T[2] = y[0]; return x
def argument_changed(x): x[0] += 1; x[1:] = x[:2] * x[0]; return x
def constants_made(x): return np.linspace(0, 1, 3) * x + np.arange(3) - np.array([1, 2, 3]) / 2 + np.ones(3, dtype=int)
def typed(x): return np.array([x[0], 1], dtype=float) + np.asarray(x, float)[:2] + x.astype(float)[1:] + np.zeros(2, dtype=np.float64)
def matrices(x): return M @ x + x @ M.T + np.dot(M, x) + M.dot(x) + np.matmul(M, x) + (M @ np.diag(x)).T[0]
def vectors(x): return [np.dot(x, x), x.dot(M[0]), np.inner(x, x), np.vdot(x, M[1]), *np.cross(x, [1.0, 2.0, 3.0]), *np.outer(x, x).ravel()]
def sums(x): return [np.sum(x), x.sum(), np.mean(x), x.mean(), np.prod(x), x.prod(), *np.cumsum(x), math.fsum(x), math.prod(x), np.add.reduce(x), *np.outer(x, x).sum(axis=0), x.std(), np.var(x), np.trace(np.outer(x, x))]
def norms(x): return [norm(x), la.norm(x[:2]), np.linalg.norm(x - 1), np.linalg.norm(x, 1), np.linalg.norm(x, np.inf), *np.linalg.norm(np.outer(x, x), axis=1), np.linalg.norm(np.outer(x, x)), math.dist(x, [1, 2, 3])]
def joined(x): return np.concatenate([x[:2], [x[2] * x[0]], np.hstack([x[::-1], 1.0]), np.stack([x, x]).ravel(), np.vstack([x, M])[:, 1], np.append(x, 2.0), np.r_[x[0], 1.0, x]])
def blocks(x): F = np.block([[np.eye(2), x[:2].reshape(2, 1)], [np.zeros((1, 2)), 1.0]]); return F @ x
def reshaped(x): A = np.outer(x, [1.0, 2.0]); return [*A.reshape(2, 3)[1], *A.T[0], *A.flatten(), *np.tile(x, 2), *np.roll(x, 1), *np.diff(x), *x[::-1], *x[None, :].squeeze(), *np.flip(x)]
def spread(x): return (x[:, None] * x[None, :] + x).ravel() * np.ones((3, 3)).ravel()
def einstein(x): return [*np.einsum("ij,j->i", M, x), *np.kron([1.0, 2.0], x), *np.tensordot(M, x, 1), np.trapezoid(x) if hasattr(np, "trapezoid") else np.trapz(x)]
def small_systems(x): A = np.eye(3) * (2 + x[0] ** 2) + np.outer(x, x); return [*np.linalg.solve(A, x), *(np.linalg.inv(A) @ x), np.linalg.det(A), *la.solve(M, x), *np.linalg.inv(M)[0] * x]
def system_of_four(x): A = np.diag([3 + x[0] ** 2, 2.0, 4.0, 5.0]); A[0, 3], A[2, 1] = x[1], x[2]; return np.linalg.solve(A, [x[0], 1.0, x[1], x[2]])
def large_constant_system(x): return np.linalg.solve(np.eye(6) * 2 + 1, np.append(x, x)) + np.linalg.eigvalsh(np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
def polynomials(x): return [np.polyval([1.0, 2.0, 3.0], x[0]), np.polynomial.polynomial.polyval(x[1], [1.0, 2.0]), functools.reduce(lambda a, c: a * x[2] + c, [1.0, 2.0, 3.0])]
def by_operators(x): return [operator.mul(x[0], x[1]), operator.neg(x[2]), *np.multiply.outer(x, x)[0], np.maximum.reduce([x[0], x[1], 0.0]), *np.add(x, [1, 2, 3])]
def scalars_of_numpy(x): return [x[0].item() * 2, x[1].copy(), np.float64(2) * x[2], x.item(1), x.tolist()[2], float(x[0]), np.array(2.0) * x[0]]
def kinds(x): return [x[0] if isinstance(x[0], float) else 9.0, x[1] if isinstance(x[1], (int, np.floating)) and np.isscalar(x[1]) else 9.0, np.ndim(x[2]) + x[2]]
def row_kinds(x, t): return [x[0] if isinstance(t, int) and not isinstance(t, float) else x[1], x[2] * (x[0] > 0) * (x[1] > 0)]
def said(x): print("at", x[0], x, f"{len(x):.2f}"); return [x[0] * 2, x[1] if f"{G:.1f}" == "2.0" else 0.0]
def beside(x): return [*helper.multiplied(np.concatenate([[1.0], x]), [0.5, *x]), *(turned(x[0]) @ x[1:]), helper.EARTH * x[0]]
def with_default(x, t=0.0, scale=2.0): return [scale * x[0] + t, sine(x[1])]
def vectorised(x): return np.vectorize(lambda one: one * one if one > 0 else one)(x)
def generated(x): return np.array([*(one * 2 for one in x)]) + np.array(list(range(3)))


def runge_kutta(x):
    def rate(y):
        return np.array([y[1], -np.sin(y[0]) - 0.1 * y[1], y[0] * y[2]])

    h = 0.1
    k1 = rate(x)
    k2 = rate(x + h / 2 * k1)
    k3 = rate(x + h / 2 * k2)
    k4 = rate(x + h * k3)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def rotation(x):
    c, s = np.cos(x), np.sin(x)
    Rx = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    Rz = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    return (Rz @ Rx @ np.array([1.0, 2.0, 3.0])).tolist()


@dataclass
class Pendulum:
    length: float = 2.0
    mass: float = 0.5

    @property
    def inertia(self):
        return self.mass * self.length ** 2

    def torque(self, angle):
        return -self.mass * helper.EARTH * self.length * np.sin(angle) / self.inertia


@dataclass
class State:
    angle: float
    rate: float


pendulum = Pendulum(1.5)


def of_a_class(x): state = State(x[0], x[1]); return [state.rate, pendulum.torque(state.angle), Pendulum(2.0).inertia * x[2]]


def decorated_with(scale):
    def decorate(function):
        @functools.wraps(function)
        def inner(x):
            return scale * np.asarray(function(x))
        return inner
    return decorate


@decorated_with(2.0)
def decorated(x): return [x[0], math.sin(x[1])]


@functools.lru_cache(maxsize=None)
def cached(angle): return math.sin(angle) if angle > 0 else angle


def of_a_cache(x): return [cached(x[0]), cached(x[1]) + cached(x[0])]
def closure(gain): return lambda x: [gain * math.sin(x[0]), gain * x[1]]
def scaled(gain, x): return [gain * math.sin(x[0]), x[1]]


class Model:
    def __init__(self, gain): self.gain = gain
    def f(self, x): return [self.gain * math.sin(x[0])]
    def __call__(self, x): return [self.gain * math.cos(x[0])]


closed, partly, method, instance = closure(3.0), partial(scaled, 2.0), Model(2.0).f, Model(3.0)


def tried(x):
    try:
        return [x[0] / (2 + x[1] ** 2)]
    except ZeroDivisionError:
        return [0.0]


def infinite_start(x):
    best = np.inf
    for one in x:
        best = min(best, one)
    low = -float("inf")
    for one in x:
        if one > low:
            low = one
    return [best, low]


def eight_limits(x):
    return [max(-1.0, min(1.0, (k + 1) * one)) for k in range(3) for one in x]
