"""Extended and sigma-point filters and smoothers of the library beside nonlinear_models.py.

    test_nonlinear.py LIBRARY [RUNS]

LIBRARY: kalmanq as a shared library.  RUNS: Monte-Carlo runs of each model (5).  Answers 0 where all is within its
limits; prints what it has measured.
"""
from __future__ import annotations

import ctypes
import sys

import numpy as np

from nonlinear_models import (Battery, CoordinatedTurn, FallingBody, GpsImu, RangeBearing, chance_band, jacobian,
                              linearise_cubature, linearise_extended, run, unwrapped, wrapped)
from shared_library import Library


class Run:
    """The library's run of a model; Words (test_nonlinear_q31.py) has its numbers in fixed point"""

    def __init__(self, library, model):
        self.k, self.model, self.n, self.m = library, model, len(model.x0), len(model.R)
        k, n = library, self.n
        k.kept = []
        self.filter, self.view = k.made("filter", n), np.zeros(512, dtype=np.uint8)
        self.make_model()
        self.tape = k.made("history", n, words=600 * model.steps + 9000)
        self.jacobians, processes = np.zeros(256, dtype=np.uint8), np.zeros(200 * model.steps, dtype=np.uint8)
        words = np.zeros(n * n * 2 * model.steps + 1000, dtype=k.type)
        k.kept += [processes, words]
        k.call("jacobians_assign", self.jacobians, self.tape, n, processes, model.steps, words, len(words))
        k.call("attach", self.filter, self.jacobians)  # `attached` comes first
        self.work = np.zeros(4096, dtype=k.type)

    def make_model(self):
        """Process, sensor and the start of the filter"""
        k, n, model = self.k, self.n, self.model
        self.process, self.sensor = k.made("process", n, 0), k.made("sensor", n, self.m)
        k.call("process_init", self.process, k.numbers(np.eye(n)), None, k.numbers(model.Q))
        k.call("sensor_init_extended", self.sensor, k.numbers(np.zeros((self.m, n))), k.numbers(model.R))
        k.call("filter_init", self.filter, k.numbers(model.x0), k.numbers(model.P0))

    def change_process(self, A):
        self.k.call("process_change_transition", self.process, self.k.numbers(A))

    def change_sensor(self, H):
        self.k.call("sensor_change_measurement", self.sensor, self.k.numbers(H))

    def increment(self, d):
        return self.k.numbers(d)

    def innovation(self, e):
        return self.k.numbers(e)

    def mean(self, of=None):
        of = self.filter if of is None else of
        return np.array([self.k.read("mean", of, i) + self.k.read("mean_low", of, i) for i in range(self.n)])

    def covariance(self, name, *at):
        P = np.zeros((self.n, self.n), dtype=self.k.type)
        self.k.call(name, *at, P)
        return P.astype(np.float64)

    def step_extended(self, z, t):
        k, model = self.k, self.model
        if t:
            x = self.mean()
            self.change_process(jacobian(lambda y: model.increment(y, t - 1), x) + np.eye(self.n))
            k.call("predict_extended", self.filter, self.process, self.increment(model.increment(x, t - 1)))
        if model.measures(t):
            x = self.mean()
            self.change_sensor(jacobian(lambda y: model.h(y, t), x))
            k.call("update", self.filter, self.sensor, self.innovation(wrapped(model, z - np.real(model.h(x, t)))))

    def step_points(self, z, t):
        k, model, n = self.k, self.model, self.n
        if t:
            g = k.callback(lambda x: model.increment(x, t - 1), n, n)
            k.call("predict_sigma_points", self.filter, self.process, g, None, ctypes.c_int(0), self.work)
        if model.measures(t):
            centre = self.mean()
            at = wrapped(model, z - np.real(model.h(centre, t))) + np.real(model.h(centre, t))
            g = k.callback(lambda x: at - np.real(unwrapped(model, x, centre, t)), self.m, n)
            k.call("update_sigma_points", self.filter, self.sensor, g, None, ctypes.c_int(0), self.work)

    def run(self, z, step):
        filtered = []
        for t in range(self.model.steps):
            getattr(self, step)(z[t], t)
            filtered.append((self.mean(), self.covariance("covariance", self.filter)))
        self.k.call("smooth", self.tape)
        return filtered, [self.smoothed(t) for t in range(self.model.steps)]

    def smoothed(self, t):
        self.k.call("smoothed", self.tape, t, self.view)
        return self.mean(self.view), self.covariance("covariance", self.view)


def off(ours, reference):
    """The largest distance of a mean over a run, in sigmas of the reference"""
    return max(np.max(np.abs(a - b) / np.sqrt(np.diag(P))) for (a, _), (b, P) in zip(ours, reference))


def nees(states, truth):
    return np.mean([(x - s) @ np.linalg.pinv(P, hermitian=True) @ (x - s) / len(s) for (x, P), s in zip(states, truth)])


def squares(states, truth, position):
    """The mean square of a run's errors of position"""
    at = list(position)
    return np.mean([np.sum((x[at] - s[at]) ** 2) for (x, _), s in zip(states, truth)])


def rms(runs, position):
    return np.sqrt(np.mean([squares(states, truth, position) for states, truth in runs]))


# ------------------------------------------------------------------ iteration, by the loops of sigma_points.h


class Iterated(Run):
    """Updates that are linearised where they come out, and passes that are linearised at the last one's results"""

    def __init__(self, library, model):
        super().__init__(library, model)
        k, n, m = library, self.n, self.m
        self.trial, self.at, self.moved = k.made("filter", n), k.made("sensor", n, m), k.made("process", n, 0)
        self.y, self.J, self.E = (np.zeros(256, dtype=k.type) for _ in range(3))
        self.R = np.zeros((m, m), dtype=k.type)
        self.densities = [k.made("filter", n) for _ in range(model.steps)]

    def linearise(self, at, function, rows):
        """The mean at `at`, y and J (rows x n)"""
        g = self.k.callback(function, rows, self.n)
        self.k.call("linearise", at, g, None, ctypes.c_int(rows), ctypes.c_int(0), self.y, self.J, self.E)
        J = self.J[:rows * self.n].reshape(rows, self.n).astype(np.float64)
        return self.mean(at), self.y[:rows].astype(np.float64), J

    def update_at(self, at, to, z, t):
        """`to`, at the predicted state, is updated by h linearised at `at`."""
        model = self.model
        c = self.mean(at)
        near = wrapped(model, z - np.real(model.h(c, t))) + np.real(model.h(c, t))
        c, e, J = self.linearise(at, lambda x: near - np.real(unwrapped(model, x, c, t)), self.m)
        e = e + J @ (self.mean(self.filter) - c)
        H = self.k.numbers(-J)
        self.k.call("sensor_linearise", self.at, self.sensor, H, self.E, self.R)
        self.k.call("update", to, self.at, self.k.numbers(e))

    def step_iterated(self, z, t):
        if t:
            g = self.k.callback(lambda x: self.model.increment(x, t - 1), self.n, self.n)
            self.k.call("predict_sigma_points", self.filter, self.process, g, None, ctypes.c_int(0), self.work)
        if not self.model.measures(t):
            return
        self.k.call("filter_copy", self.trial, self.filter)
        for _ in range(3):
            at = self.k.made("filter", self.n)
            self.k.call("filter_copy", at, self.trial)
            self.k.call("filter_copy", self.trial, self.filter)
            self.update_at(at, self.trial, z, t)
        self.update_at(self.trial, self.filter, z, t)

    def step_pass(self, z, t):
        """Linearised at the densities of the last pass"""
        if t:
            c, y, J = self.linearise(self.densities[t - 1], lambda x: self.model.increment(x, t - 1), self.n)
            A = self.k.numbers(J + np.eye(self.n))
            self.k.call("process_linearise", self.moved, self.process, A, self.E)
            self.k.call("predict_extended", self.filter, self.moved, self.k.numbers(y + J @ (self.mean() - c)))
        if self.model.measures(t):
            self.update_at(self.densities[t], self.filter, z, t)

    def passes(self, z, count):
        """The smoothed states of the last of `count` passes, the first one by sigma points as they come"""
        k = self.k
        for number in range(count):
            k.call("filter_init", self.filter, k.numbers(self.model.x0), k.numbers(self.model.P0))
            k.call("detach", self.tape)
            k.call("attach", self.filter, self.jacobians)  # `attached` comes first
            smoothed = self.run(z, "step_pass" if number else "step_points")[1]
            for t, density in enumerate(self.densities):
                k.call("smoothed", self.tape, t, self.view)
                k.call("filter_copy", density, self.view)
        return smoothed


def compare_sharp(path, runs, near=0.2):
    """A range of 0.1 mm and a bearing of 1e-6 rad: what is linearised where it begins believes what is wrong."""
    model = RangeBearing(r=(1e-4, 1e-6), steps=30)
    given = [model.simulate(np.random.default_rng(seed)) for seed in range(runs)]
    scores = {}
    for step in ("step_extended", "step_points", "step_iterated"):
        library = Library(path, "f64")
        scores[step[5:]] = np.mean([nees(Iterated(library, model).run(z, step)[1], states) for states, z in given])
    good = scores["extended"] > 100 and abs(scores["iterated"] - 1) < near
    told = ", ".join(f"{name} {value:.3g}" for name, value in scores.items())
    print("sharp RangeBearing f64  smoothed NEES/n: " + told + ("" if good else "  BEYOND ITS LIMIT"))
    return not good


def compare_passes(path, runs):
    """Six passes of the posterior linearisation smoother on the falling body.  Nothing moves it, so the errors of a run
    are those of its start: NEES is a chi-square of n for each run, not for each step."""
    model = FallingBody()
    given = [model.simulate(np.random.default_rng(seed)) for seed in range(runs)]
    library, told = Library(path, "f64"), {}
    for count in (1, 6):
        results = [Iterated(library, model).passes(z, count) for _, z in given]
        truth = [states for states, _ in given]
        told[count] = (rms(zip(results, truth), model.position), np.mean([nees(r, s) for r, s in zip(results, truth)]))
    low, high = chance_band(len(model.x0) * runs)
    good = told[6][0] < 0.9 * told[1][0] and low < told[6][1] < high
    print("passes FallingBody f64  smoothed RMS and NEES/n: " + ", ".join(
        f"{count}: {a:.4g}, {b:.3g}" for count, (a, b) in told.items()) + ("" if good else "  BEYOND ITS LIMIT"))
    return not good


# ------------------------------------------------------------------ an attitude: a quaternion outside, its error inside


def turned(q, v):
    """q turned by the small rotation vector v of the body"""
    length = np.linalg.norm(v)
    r = np.concatenate([[np.cos(length / 2)], np.sinc(length / 2 / np.pi) / 2 * v])
    a, b = q[0], q[1:]
    p = np.concatenate([[a * r[0] - b @ r[1:]], a * r[1:] + r[0] * b + np.cross(b, r[1:])])
    return p / np.linalg.norm(p)


def to_body(q, v):
    return v + 2 * np.cross(-q[1:], np.cross(-q[1:], v) + q[0] * v)


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


class Attitude:
    """Gyro with a bias at 100 Hz, gravity and the Earth's field at 10 Hz; error state: rotation, bias; rad"""
    steps, dt = 400, 0.01
    Q = np.diag([1e-6] * 3 + [1e-9] * 3)
    R = np.diag([1e-3] * 3 + [4e-3] * 3)
    P0 = np.diag([0.09] * 3 + [1e-3] * 3)
    fields = np.array([[0, 0, 1.0], [0.5, 0, 0.866]])

    def rate(self, t):
        return np.array([0.5 * np.sin(0.03 * t), 0.4 * np.cos(0.02 * t), 0.3])

    def simulate(self, random):
        q, bias = turned(np.array([1.0, 0, 0, 0]), 0.3 * random.standard_normal(3)), 0.03 * random.standard_normal(3)
        gyro, z = [], []
        for t in range(self.steps):
            gyro.append(self.rate(t) + bias + 0.1 * random.standard_normal(3))
            noise = np.sqrt(np.diag(self.R)) * random.standard_normal(6)
            z.append(np.concatenate([to_body(q, b) for b in self.fields]) + noise)
            q = turned(q, self.rate(t) * self.dt)
        return gyro, z

    def drive(self, gyro, z, predict, update):
        """The steps of the filter, that answer the error it has found: the quaternion is here."""
        q, bias = np.array([1.0, 0, 0, 0]), np.zeros(3)
        for t in range(self.steps):
            if t:
                w = gyro[t - 1] - bias
                q = turned(q, w * self.dt)
                A = np.eye(6)
                A[:3, :3] -= cross_matrix(w * self.dt)
                A[:3, 3:] = -self.dt * np.eye(3)
                predict(A)
            if t % 10 == 0:
                seen = [to_body(q, b) for b in self.fields]
                H = np.vstack([np.hstack([cross_matrix(b), np.zeros((3, 3))]) for b in seen])
                error = update(H, z[t] - np.concatenate(seen))
                q, bias = turned(q, error[:3]), bias + error[3:]


def attitude_of_library(path, arithmetic, gyro, z):
    model, k = Attitude(), Library(path, arithmetic)
    model.x0 = np.zeros(6)
    ours = Run(k, model)
    found = []

    def predict(A):
        ours.change_process(A)
        k.call("predict_extended", ours.filter, ours.process, k.numbers(np.zeros(6)))

    def update(H, e):
        ours.change_sensor(H)
        k.call("update", ours.filter, ours.sensor, k.numbers(e))
        error = ours.mean()
        found.append((error, ours.covariance("covariance", ours.filter)))
        k.call("move", ours.filter, k.numbers(-error))
        return error

    model.drive(gyro, z, predict, update)
    k.call("smooth", ours.tape)
    return found, [(ours.smoothed(t)[0], None) for t in range(model.steps)]


def attitude_of_reference(gyro, z):
    """Covariance form; the error of each step smoothed relative to where its quaternion was left"""
    model, found, filtered, A_of = Attitude(), [], [], []
    state = {"P": model.P0.copy()}

    def predict(A):
        filtered.append(state["P"])
        A_of.append(A)
        state["P"] = A @ state["P"] @ A.T + model.Q

    moves = [np.zeros(6)]

    def update(H, e):
        S = H @ state["P"] @ H.T + model.R
        K = np.linalg.solve(S, H @ state["P"]).T
        P = state["P"] - K @ S @ K.T
        state["P"] = (P + P.T) / 2
        found.append((K @ e, state["P"]))
        moves.append(K @ e)
        at.append(len(filtered))
        return K @ e

    at = []
    model.drive(gyro, z, predict, update)
    filtered.append(state["P"])
    correction = {step: error for step, error in zip(at, moves[1:])}
    smoothed = [np.zeros(6)]
    for t in range(model.steps - 2, -1, -1):
        Pp = A_of[t] @ filtered[t] @ A_of[t].T + model.Q
        G = np.linalg.solve(Pp, A_of[t] @ filtered[t]).T
        smoothed.insert(0, G @ (smoothed[0] + correction.get(t + 1, 0)))  # its prediction was 0
    return found, list(zip(smoothed, filtered))


def compare_attitude(path, runs):
    faults = 0
    for arithmetic, limit in (("f64", 1e-10), ("f32", 1e-3)):
        worst = []
        for seed in range(runs):
            gyro, z = Attitude().simulate(np.random.default_rng(seed))
            ours, reference = attitude_of_library(path, arithmetic, gyro, z), attitude_of_reference(gyro, z)
            worst.append([off(a, b) for a, b in zip(ours, reference)])
        most = np.median(worst, axis=0)
        good = bool(np.all(most <= limit))
        print(f"Attitude        extended {arithmetic}  filter: {most[0]:.1e} sigma, smoother: {most[1]:.1e} sigma"
              + ("" if good else "  BEYOND ITS LIMIT"))
        faults += not good
    return faults


# model, steps, linearisation; limits in sigma (median of the worst step of each run): f64, f32
CASES = [
    (RangeBearing, "step_extended", linearise_extended, 1e-10, 2e-5),
    (RangeBearing, "step_points", linearise_cubature, 1e-10, 2e-4),
    (Battery, "step_extended", linearise_extended, 1e-10, 5e-5),
    (Battery, "step_points", linearise_cubature, 1e-10, 1e-4),
    (GpsImu, "step_extended", linearise_extended, 1e-10, 5e-5),
    (GpsImu, "step_points", linearise_cubature, 1e-10, 3e-4),
    (FallingBody, "step_extended", linearise_extended, 1e-7, 2e-3),
    (FallingBody, "step_points", linearise_cubature, 1e-7, 2e-3),
    (CoordinatedTurn, "step_extended", linearise_extended, 1e-7, 1e-4),
    (CoordinatedTurn, "step_points", linearise_cubature, 1e-7, 1e-3),
]


def compare(path, case, runs):
    """Prints a line for each arithmetic; answers how many limits do not hold."""
    make, step, linearise, limit64, limit32 = case
    model, faults = make(), 0
    given = [model.simulate(np.random.default_rng(seed)) for seed in range(runs)]
    with np.errstate(all="ignore"):
        references = [run(model, z, linearise) for _, z in given]
    kept = [k for k, (_, smoothed) in enumerate(references) if np.isfinite(smoothed[0][0]).all()]
    given, references = [given[k] for k in kept], [references[k] for k in kept]
    if len(kept) < runs:
        print(f"{make.__name__:16}{step[5:]:9}the reference itself is lost in {runs - len(kept)} of {runs} runs")
    for arithmetic, limit in (("f64", limit64), ("f32", limit32)):
        library = Library(path, arithmetic)
        ours = [Run(library, model).run(z, step) for _, z in given]
        line, good = f"{make.__name__:16}{step[5:]:9}{arithmetic}", True
        for which, name in ((0, "filter"), (1, "smoother")):
            worst = [off(a[which], b[which]) for a, b in zip(ours, references)]
            truth = [states for states, _ in given]
            mine, theirs = (rms(zip([r[which] for r in all_runs], truth), model.position)
                            for all_runs in (ours, references))
            scores = [np.mean([nees(r[which], s) for r, s in zip(all_runs, truth)]) for all_runs in (ours, references)]
            good &= bool(np.median(worst) <= limit and abs(mine / theirs - 1) <= 0.005)
            good &= bool(abs(scores[0] / scores[1] - 1) <= 0.05)
            line += (f"  {name}: {np.median(worst):.1e} sigma (worst {max(worst):.1e}), RMS {mine:.4g} ({theirs:.4g}), "
                     f"NEES/n {scores[0]:.3g} ({scores[1]:.3g})")
        print(line + ("" if good else "  BEYOND ITS LIMIT"), flush=True)
        faults += not good
    return faults


def main():
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    faults = sum(compare(sys.argv[1], case, runs) for case in CASES)
    faults += compare_sharp(sys.argv[1], max(3, runs)) + compare_passes(sys.argv[1], 4 * runs)
    faults += compare_attitude(sys.argv[1], max(1, runs // 3))
    print("FAIL" if faults else "OK")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
