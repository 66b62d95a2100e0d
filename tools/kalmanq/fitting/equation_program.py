"""The log-likelihood of a nonlinear model in C, with its exact slope along a direction of the parameters.

Every number is a pair: its value and its slope.  The filter is the library's: U D U' (Bierman; Thornton), component by
component, one sensor after the other.
"""

from __future__ import annotations

import ctypes
from typing import Callable, Sequence

import numpy as np

from kalmanq.compiler.run.building import build
from kalmanq.data.files import own_folder, telling_where
from kalmanq.formulas.calculus import derivative
from kalmanq.formulas.functions import value
from kalmanq.formulas.graph import Node, symbol, using
from kalmanq.formulas.printing import Body, Floats, indented
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.constants import Free
from kalmanq.nonlinear.formulas import Formulas

HEAD = """\
#include <math.h>

enum {{ N = {n}, C = {count}, M = {m}, L = {l} }};

typedef struct {{ double v, d; }} pair;

static pair plus(pair a, pair b) {{ return (pair){{a.v + b.v, a.d + b.d}}; }}
static pair minus(pair a, pair b) {{ return (pair){{a.v - b.v, a.d - b.d}}; }}
static pair times(pair a, pair b) {{ return (pair){{a.v * b.v, a.v * b.d + a.d * b.v}}; }}
static pair over(pair a, pair b) {{ double q = a.v / b.v; return (pair){{q, (a.d - q * b.d) / b.v}}; }}
"""
FILTER = """
/* C = U D U' of a C that may be singular: what is left of a variance by rounding is 0 */
static void factor(pair C[N][N], pair U[N][N], pair D[N])
{
    for (int j = N - 1; j >= 0; j--) {
        const double most = C[j][j].v;
        D[j] = C[j][j];
        for (int k = j + 1; k < N; k++) D[j] = minus(D[j], times(D[k], times(U[j][k], U[j][k])));
        const int is_there = D[j].v > 1e-14 * most;
        if (!is_there) D[j] = (pair){0, 0};
        for (int i = 0; i < N; i++) {
            pair c = {i == j, 0};
            if (i < j) {
                c = C[i][j];
                for (int k = j + 1; k < N; k++) c = minus(c, times(D[k], times(U[i][k], U[j][k])));
                c = is_there ? over(c, D[j]) : (pair){0, 0};
            }
            U[i][j] = c;
        }
    }
}

/* U D U' becomes A U D U' A' + V E V' */
static void spread(pair A[N][N], pair V[N][N], pair E[N], pair U[N][N], pair D[N])
{
    pair W[N][2 * N], weights[2 * N];
    for (int k = 0; k < N; k++) weights[k] = D[k], weights[N + k] = E[k];
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            pair sum = {0, 0};
            for (int r = 0; r <= k; r++) sum = plus(sum, times(A[i][r], U[r][k]));
            W[i][k] = sum, W[i][N + k] = V[i][k];
        }
    for (int j = N - 1; j >= 0; j--) {
        pair sum = {0, 0};
        for (int k = 0; k < 2 * N; k++) sum = plus(sum, times(weights[k], times(W[j][k], W[j][k])));
        D[j] = sum;
        for (int i = 0; i < j; i++) {
            pair dot = {0, 0};
            for (int k = 0; k < 2 * N; k++) dot = plus(dot, times(weights[k], times(W[i][k], W[j][k])));
            U[i][j] = sum.v > 0 ? over(dot, sum) : (pair){0, 0};
            for (int k = 0; k < 2 * N; k++) W[i][k] = minus(W[i][k], times(U[i][j], W[j][k]));
        }
    }
}

/* A measurement e of h: U, D and the errors d; adds to the log-likelihood */
static void take(pair e, const pair *h, pair r, pair U[N][N], pair D[N], pair *d, pair *sum)
{
    pair f[N], gain[N], s = r;
    for (int j = 0; j < N; j++) {
        f[j] = h[j], gain[j] = (pair){0, 0}, e = minus(e, times(h[j], d[j]));
        for (int i = 0; i < j; i++) f[j] = plus(f[j], times(h[i], U[i][j]));
    }
    for (int j = 0; j < N; j++) {
        const pair v = times(D[j], f[j]), before = s;
        s = plus(s, times(v, f[j]));
        if (!(s.v > 0)) continue;
        const pair share = before.v > 0 ? over(f[j], before) : (pair){0, 0};
        D[j] = over(times(D[j], before), s);
        for (int i = 0; i < j; i++) {
            const pair had = U[i][j];
            U[i][j] = minus(had, times(gain[i], share));
            gain[i] = plus(gain[i], times(v, had));
        }
        gain[j] = v;
    }
    const pair step = over(e, s), cost = times(e, step);
    for (int i = 0; i < N; i++) d[i] = plus(d[i], times(gain[i], step));
    sum->v -= 0.5 * (log(6.283185307179586477 * s.v) + cost.v);
    sum->d -= 0.5 * (s.d / s.v + cost.d);
}

/* What is there of measurements first ... last - 1: R is made diagonal, row after row */
static void update(int first, int last, const double *z, pair *e, pair H[M][N], pair R[M][M], pair U[N][N], pair D[N], pair *d, pair *sum)
{
    pair W[M][M], E[M];
    int there[M], count = 0;
    for (int j = first; j < last; j++)
        if (!isnan(z[j])) there[count++] = j;
    for (int a = 0; a < count; a++) {
        const int j = there[a];
        E[a] = R[j][j];
        for (int b = 0; b < a; b++) {
            pair w = R[j][there[b]];
            for (int k = 0; k < b; k++) w = minus(w, times(E[k], times(W[a][k], W[b][k])));
            W[a][b] = E[b].v > 0 ? over(w, E[b]) : (pair){0, 0};
            E[a] = minus(E[a], times(E[b], times(W[a][b], W[a][b])));
            e[j] = minus(e[j], times(W[a][b], e[there[b]]));
            for (int i = 0; i < N; i++) H[j][i] = minus(H[j][i], times(W[a][b], H[there[b]][i]));
        }
        take(e[j], H[j], E[a], U, D, d, sum);
    }
}

void likelihood(int rows, const double *at, const double *step, const double *z, const double *u, const double *parameters,
                const double *direction, double *made);

void likelihood(int rows, const double *at, const double *step, const double *z, const double *u, const double *parameters,
                const double *direction, double *made)
{
    pair p[K + 1], x[C], P[N][N], Q[N][N], R[M][M], U[N][N], D[N], V[N][N], E[N], sum = {0, 0};
    for (int k = 0; k < K; k++) p[k] = (pair){parameters[k], direction[k]};
    prior(p, x, *P, *Q, *R);
    factor(P, U, D);
    factor(Q, V, E);
    for (int t = 0; t < rows; t++, z += M, u += L) {
        if (t) {
            pair A[N][N], y[C];
            moved(p, x, u - L, at[t - 1], step[t - 1], y, *A, *Q);
            if (STEP_NOISE) factor(Q, V, E);
            spread(A, V, E, U, D);
            for (int i = 0; i < C; i++) x[i] = y[i];
        }
        for (int k = 0; k < SENSORS; k++) {
            int there = 0;
            for (int j = FIRST[k]; j < FIRST[k + 1]; j++) there |= !isnan(z[j]);
            if (!there) continue;
            pair e[M], H[M][N], d[N] = {{0, 0}}, y[C];
            measured(k, p, x, z, u, at[t], e, *H, R);
            update(FIRST[k], FIRST[k + 1], z, e, H, R, U, D, d, &sum);
            corrected(p, x, d, y);
            for (int i = 0; i < C; i++) x[i] = y[i];
        }
    }
    made[0] = sum.v, made[1] = sum.d;
}
"""


class Parameters:
    """Where each free parameter's numbers are: of a constant one, of x0 n, of a covariance those up to its diagonal"""

    def __init__(self, model: NonlinearModel, names: Sequence[str]):
        self.places, at = {}, 0
        for name in names:
            size = {"x0": model.n, "P0": model.n, "Q": model.n, "R": model.m}.get(name, 1)
            count = size * (size + 1) // 2 if name in ("P0", "Q", "R") else size
            self.places[name], at = slice(at, at + count), at + count
        self.count = at

    def put(self, vector: np.ndarray, name: str, array: np.ndarray) -> None:
        vector[self.places[name]] = array[np.tril_indices(len(array))] if array.ndim == 2 else array

    def symbols(self, name: str, size: int) -> list[list[Node]]:
        """A covariance's"""
        first = self.places[name].start
        return [[symbol(f"p{first + max(i, j) * (max(i, j) + 1) // 2 + min(i, j)}") for j in range(size)] for i in range(size)]


class Likelihood:
    """at(instants, z, u, parameters, direction): the log-likelihood of a record and its slope"""

    def __init__(self, model: NonlinearModel, free: Free, parameters: Parameters):
        text = _text(model, free, parameters)
        with own_folder("kalmanq-fit-") as folder, telling_where(folder):
            (folder / "likelihood.c").write_text(text, encoding="utf-8")
            library = ctypes.CDLL(str(build(folder, ["likelihood.c"], "likelihood.so", ("-shared", "-fPIC"))))
        self._function: Callable[..., None] = library.likelihood

    def at(self, instants: Sequence[float], z: np.ndarray, u: np.ndarray, parameters: np.ndarray, direction: np.ndarray) -> np.ndarray:
        made = np.zeros(2)
        steps = [getattr(one, "dt", None) for one in instants]
        given = [np.ascontiguousarray(one, np.float64)
                 for one in (instants, [np.nan if one is None else one for one in steps], z, u, parameters, direction)]
        self._function(len(z), *(ctypes.c_void_p(one.ctypes.data) for one in (*given, made)))
        return made


def _text(model: NonlinearModel, free: Free, parameters: Parameters) -> str:
    f = free.formulas
    with using(f.graph):
        named = {label: f"p{parameters.places[label].start}" for label in free.symbols}
        start = [symbol(f"p{k}") for k in range(parameters.count)[parameters.places["x0"]]] if "x0" in parameters.places else free.start
        P0, Q, R = (parameters.symbols(name, len(rows)) if name in parameters.places else rows
                    for name, rows in (("P0", free.P0), ("Q", free.Q), ("R", free.R)))
        write = _Functions([one.args[0] for one in free.symbols.values()], list(named.values()), parameters.count)
        moved = f.moved if "f" in f.given else [x + one for x, one in zip(f.x, f.change)]
        functions = [
            write.function("prior(const pair *p, pair *x, pair *P, pair *Q, pair *R)", {}, [("x", start), ("P", _flat(P0)), ("Q", _flat(Q)), ("R", _flat(R))]),
            write.function("moved(const pair *p, const pair *x, const double *u, double t, double dt, pair *y, pair *A, pair *Q)", {"x": f.x},
                           [("y", moved), ("A", _flat(f.transition)), ("Q", _flat(_noise_of_step(f)))], f.u),
            write.measured(model, f),
            write.function("corrected(const pair *p, const pair *x, const pair *d, pair *y)", {"x": f.x, "d": f.d}, [("y", f.corrected)])]
    first = ", ".join(str(one.first) for one in model.sensors)
    sizes = HEAD.format(n=model.n, count=len(model.carried), m=model.m, l=model.l)
    tables = f"enum {{ K = {parameters.count}, SENSORS = {len(model.sensors)}, STEP_NOISE = {int(f.noise_of_step is not None)} }};\nstatic const int FIRST[] = {{{first}, {model.m}}};\n"
    return "\n".join([sizes, tables, *("\n".join(one) + "\n" for one in functions)]) + FILTER


def _noise_of_step(f: Formulas) -> Sequence[Sequence[Node]]:
    """Q where it, or G, is a function"""
    rows = f.noise_of_step or []
    if "G" not in f.given:
        return rows
    G = np.array(rows, object)
    return [[value(one) for one in row] for row in G @ G.T]


def _flat(rows: Sequence[Sequence[Node]]) -> list[Node]:
    return [one for row in rows for one in row]


class _Functions:
    """C functions of formulas over pairs"""

    def __init__(self, constants: Sequence[str], named: Sequence[str], count: int):
        self.constants, self.count = dict(zip(constants, named)), count

    def function(self, signature: str, pairs: dict, targets: Sequence[tuple[str, Sequence[Node]]], u: Sequence[Node] = (),
                 z: Sequence[Node] = ()) -> list[str]:
        return [f"static void {signature}", "{", *indented(self.lines(pairs, targets, u, z)), "}"]

    def lines(self, pairs: dict, targets: Sequence[tuple[str, Sequence[Node]]], u: Sequence[Node] = (), z: Sequence[Node] = ()) -> list[str]:
        slopes, lines = {}, []
        for stem, nodes in pairs.items():
            for k, one in enumerate(nodes):
                lines.append(f"const double {stem}{k} = {stem}[{k}].v, slope_{stem}{k} = {stem}[{k}].d;")
                slopes[id(one)] = symbol(f"slope_{stem}{k}")
        for k in range(self.count):
            lines.append(f"const double p{k} = p[{k}].v, slope_p{k} = p[{k}].d;")
            slopes[id(symbol(f"p{k}"))] = symbol(f"slope_p{k}")
        for name, other in self.constants.items():
            lines.append(f"const double {name} = {other};")
            slopes[id(symbol(name))] = symbol(f"slope_{other}")
        lines += [f"const double {stem}{k} = {stem}[{k}];" for stem, some in (("u", u), ("z", z)) for k in range(len(some))]
        body = Body(Floats("double"), lines=lines)
        written = [(f"{name}[{k}]", one) for name, rows in targets for k, one in enumerate(rows)]
        body.assign([(f"{name}.v", one) for name, one in written] +
                    [(f"{name}.d", derivative(one, None, slopes)) for name, one in written])  # type: ignore[arg-type]
        return body.lines

    def measured(self, model: NonlinearModel, f) -> list[str]:  # type: ignore[no-untyped-def]
        """e and H of a sensor"""
        lines = ["static void measured(int sensor, const pair *p, const pair *x, const double *z, const double *u, double t, pair *all, pair *rows,",
                 "                     pair R[M][M])",
                 "{"]
        for k, one in enumerate(model.sensors):
            noise = [(f"R[{i}]", row) for i, row in list(enumerate(f.noise_of_sensors or []))[one.rows]]
            body = self.lines({"x": f.x}, [("e", f.innovation[one.rows]), ("H", _flat(f.measurement[one.rows])), *noise], f.u, f.z)
            lines += indented([f"if (sensor == {k}) {{", f"    pair *e = all + {one.first}, *H = rows + {one.first * model.n};",
                               *indented(body), "}"])
        return [*lines, "}"]
