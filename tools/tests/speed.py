"""speed.py PEERS_PYTHON: microseconds of processor time a step, of this package and of others, in one run.

All results of a filter are asked of each: means, variances, innovations and their variances, the likelihood.
    speed.py --step LIBRARY ROWS     one of them, alone
"""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np

ROWS = {"kalmanq": 1_000_000, "statsmodels": 1_000_000, "filterpy": 30_000}
TURNS = 5
AT_LEAST = {"filterpy": 100, "statsmodels": 20}  # what is asked for


def model() -> tuple[np.ndarray, ...]:
    A, H, G = np.eye(4), np.zeros((2, 4)), np.zeros((4, 2))
    A[0, 1] = A[2, 3] = 0.5
    H[0, 0] = H[1, 2] = 1
    G[[0, 2], [0, 1]], G[[1, 3], [0, 1]] = 0.125, 0.5
    return A, H, 0.1 * G @ G.T, 0.25 * np.eye(2), 10 * np.eye(4)


def by_kalmanq(z: np.ndarray) -> float:
    import kalmanq

    A, H, Q, R, P0 = model()
    return float(kalmanq.Filter(kalmanq.Model(A, H=H, R=R, Q=Q, P0=P0), "f64").run(z).mean[-1, 0])


def by_filterpy(z: np.ndarray) -> float:
    from filterpy.kalman import KalmanFilter

    A, H, Q, R, P0 = model()
    f = KalmanFilter(4, 2)
    f.x, f.F, f.H, f.Q, f.R, f.P = np.zeros(4), A, H, Q, R, P0
    f.update(z[0])
    return float(f.batch_filter(z[1:])[0][-1, 0])


def by_statsmodels(z: np.ndarray) -> float:
    from statsmodels.tsa.statespace.kalman_filter import KalmanFilter

    A, H, Q, R, P0 = model()
    f = KalmanFilter(k_endog=2, k_states=4, k_posdef=4)
    f.bind(z)
    f["transition"], f["design"], f["selection"], f["state_cov"], f["obs_cov"] = A, H, np.eye(4), Q, R
    f.initialize_known(np.zeros(4), P0)
    return float(f.filter().filtered_state[0, -1])


LIBRARIES = {"kalmanq": by_kalmanq, "filterpy": by_filterpy, "statsmodels": by_statsmodels}


def step(library: str, rows: int) -> None:
    z = np.random.default_rng(1).standard_normal((rows, 2)).cumsum(axis=0)
    run = LIBRARIES[library]
    run(z[:100])  # imports, and memory that is there
    begun = time.process_time()
    mean = run(z)
    print(1e6 * (time.process_time() - begun) / rows, mean)


def main() -> None:
    pythons = {"kalmanq": sys.executable, "filterpy": sys.argv[1], "statsmodels": sys.argv[1]}
    times: dict[str, list[float]] = {name: [] for name in LIBRARIES}
    for _ in range(TURNS):
        for name in LIBRARIES:
            done = subprocess.run([pythons[name], "-B", __file__, "--step", name, str(ROWS[name])], check=True,
                                  capture_output=True, text=True)
            times[name].append(float(done.stdout.split()[0]))
    least = {name: min(of) for name, of in times.items()}
    print("microseconds a step:", ", ".join(f"{name} {value:.3g}" for name, value in least.items()))
    ratios = {name: least[name] / least["kalmanq"] for name in AT_LEAST}
    for name, factor in AT_LEAST.items():
        print(f"{ratios[name]:.1f} times as fast as {name}; {factor} are asked for")
    sys.exit(any(ratios[name] < factor for name, factor in AT_LEAST.items()))


if __name__ == "__main__":
    if sys.argv[1] == "--step":
        step(sys.argv[2], int(sys.argv[3]))
    else:
        main()
