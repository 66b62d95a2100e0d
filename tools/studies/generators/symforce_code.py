"""symforce_code.py MODELS.json FOLDER: C++ of the models' EKFs by SymForce, with a Python that has it (peers.py)."""

from __future__ import annotations

import json
import sys
from pathlib import Path

try:
    import symforce
except ImportError:
    sys.exit("this Python has no symforce: pip install symforce==0.12.0")

symforce.set_epsilon_to_number(1e-6)
import symforce.symbolic as sf
from symforce.codegen import Codegen, CppConfig
from symforce.values import Values

STAND_IN = """\
#pragma once
#define OF_ONE(name) \\
    inline float name(float a) { return __builtin_##name##f(a); } inline double name(double a) { return __builtin_##name(a); }
#define OF_TWO(name) \\
    inline float name(float a, float b) { return __builtin_##name##f(a, b); } \\
    inline double name(double a, double b) { return __builtin_##name(a, b); }
namespace std { // as <cmath>, which the cross compiler may lack
OF_ONE(exp) OF_ONE(sin) OF_ONE(cos) OF_ONE(sqrt) OF_ONE(floor) OF_TWO(pow) OF_TWO(atan2) OF_TWO(copysign)
}
namespace Eigen { // what SymForce's code needs of it, row by row, as PX4's own matrices
template <typename S, int R, int C> struct Matrix {
    S v[R][C];
    S &operator()(int i, int j) { return v[i][j]; }
    const S &operator()(int i, int j) const { return v[i][j]; }
    void setZero() { for (auto &row : v) for (S &one : row) one = 0; }
};
}
"""


def battery(x, u):
    decay = float(sf.exp(-10.0 / 60))
    s = x[0]
    return ([s - 10 * u[0] / 9000, decay * x[1] + 0.02 * (1 - decay) * u[0]],
            [3.3 + 0.9 * s - 0.15 * sf.exp(-20 * s) + 0.1 * sf.sin(6 * s) - x[1] - 0.03 * u[0]])


def range_bearing(x, u):
    return [x[0] + x[2], x[1] + x[3], x[2], x[3]], seen(x)


def coordinated_turn(x, u):
    w = x[4] + sf.sign_no_zero(x[4]) * sf.epsilon()  # SymForce's way round a division by 0: no branch
    ahead, aside, s, c = sf.sin(w) / w, 2 * sf.sin(w / 2) ** 2 / w, sf.sin(w), sf.cos(w)
    return ([x[0] + ahead * x[2] - aside * x[3], x[1] + aside * x[2] + ahead * x[3],
             c * x[2] - s * x[3], s * x[2] + c * x[3], x[4]], seen(x))


def gps_imu(x, u):
    return ([x[0] + 0.1 * x[2] * sf.cos(x[3]), x[1] + 0.1 * x[2] * sf.sin(x[3]), x[2] + 0.1 * (u[0] - x[4]),
             x[3] + 0.1 * (u[1] - x[5]), x[4], x[5]], [x[0], x[1]])


def seen(x):
    return [sf.sqrt(x[0] ** 2 + x[1] ** 2), sf.atan2(x[1], x[0], epsilon=0)]


def upper(P):
    """As PX4 derives it: the lower triangle is copied"""
    return sf.Matrix([[P[i, j] if i <= j else 0 for j in range(P.shape[1])] for i in range(P.shape[0])])


def written(folder: Path, name: str, inputs: Values, **outputs) -> None:
    generator = Codegen(inputs, Values(**outputs), CppConfig(zero_initialization_sparsity_threshold=1), name=name)
    generator.generate_function(output_dir=folder, skip_directory_nesting=True)


def generated(folder: Path, model, n: int, l: int, angles: list, **constants: list) -> None:
    """model.h: the constants, and EACH: a component's number, functions, state that is H x (or -1), and whether it is an angle"""
    x, u, full = sf.Matrix(n, 1).symbolic("x"), sf.Matrix(max(l, 1), 1).symbolic("u"), sf.Matrix(n, n).symbolic("P")
    P = sf.Matrix([[full[min(i, j), max(i, j)] for j in range(n)] for i in range(n)])
    ahead, expected = map(sf.Matrix, model(x, u))
    A, inputs, Q, each = ahead.jacobian(x), Values(x=x, P=full, u=u), constants.pop("Q"), []
    written(folder, "predict", inputs, x_new=ahead, P_new=upper(A * P * A.T + sf.Matrix(Q)))
    for j, r in enumerate(constants["R"]):
        H = sf.Matrix([expected[j]]).jacobian(x)
        S, direct = (H * P * H.T)[0, 0] + r, [i for i in range(n) if expected[j] == x[i]]
        K = P * H.T / S
        written(folder, f"seen_{j}", inputs, z=expected[j], S=S, H=H.T)
        written(folder, f"whole_{j}", inputs, z=expected[j], K=K, P_new=upper(P - K * (H * P)))
        each.append(f"DO({j}, Seen{j}, Whole{j}, {direct[0] if direct else -1}, {int(j in angles)})")
    arrays = [f"const double {key}_[] = {{{', '.join(map(repr, values))}}};" for key, values in constants.items()]
    names = ["predict", *(f"{kind}_{j}" for kind in ("seen", "whole") for j in range(len(each)))]
    (folder / "model.h").write_text("\n".join([*(f'#include "{name}.h"' for name in names), f"enum {{ N = {n}, L = {max(l, 1)} }};",
                                               *arrays, f"#define EACH {' '.join(each)}", ""]))


def main() -> None:
    (Path(sys.argv[2]) / "Eigen").mkdir()
    (Path(sys.argv[2]) / "Eigen" / "Core").write_text(STAND_IN)
    for name, given in json.loads(Path(sys.argv[1]).read_text()).items():
        generated(Path(sys.argv[2]) / name, globals()[given.pop("model")], **given)


if __name__ == "__main__":
    main()
