"""speed.py PEERS_PYTHON: processor time of fixed work, of this package and of others, in one process a task.

    speed.py PEERS_PYTHON [TASK...]
    speed.py --one TASK     one of them: a line a library, microseconds a unit of its work, a number that comes of it, MB of memory

Tasks: step, a step of a long run with means, variances, innovations and their variances, the likelihood; pair, predict and update
of one row; nine, a step of 9 states; series, a row of 1,000 series of 500; file, a row of `kalmanq run`; season and sensors, a
fit of 1,850 rows with a year's waves from an unknown start, and of 7,500 irregular rows of three sensors with five parameters.
OPENBLAS_CORETYPE and OPENBLAS_L2_SIZE are as they come: set both, or none.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import io
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import numpy as np

TURNS = 5
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def moving(axes: int, derivatives: int, dt: float = 0.5) -> tuple[np.ndarray, ...]:
    """A, H, Q, R, P0 of axes of place, speed, ... each"""
    one, noise = np.eye(derivatives), np.array([dt ** (derivatives - i) / math.factorial(derivatives - i) for i in range(derivatives)])[:, None]
    for i in range(derivatives):
        for j in range(i, derivatives):
            one[i, j] = dt ** (j - i) / math.factorial(j - i)
    A, H = np.kron(np.eye(axes), one), np.kron(np.eye(axes), np.eye(1, derivatives))
    return A, H, 0.1 * np.kron(np.eye(axes), noise @ noise.T), 0.25 * np.eye(axes), 10 * np.eye(len(A))


@functools.lru_cache
def data(rows: int, m: int) -> np.ndarray:
    """Made before the time begins"""
    return np.random.default_rng(1).standard_normal((rows, m)).cumsum(axis=0)


def model_of(axes: int, derivatives: int) -> Any:
    import kalmanq

    A, H, Q, R, P0 = moving(axes, derivatives)
    return kalmanq.Model(A, H=H, R=R, Q=Q, P0=P0)


def filterpy_of(axes: int, derivatives: int) -> Any:
    from filterpy.kalman import KalmanFilter

    A, H, Q, R, P0 = moving(axes, derivatives)
    f = KalmanFilter(len(A), axes)
    f.x, f.F, f.H, f.Q, f.R, f.P = np.zeros(len(A)), A, H, Q, R, P0
    return f


def run_kalmanq(axes: int, derivatives: int) -> Callable[[int], float]:
    import kalmanq

    model = model_of(axes, derivatives)
    return lambda rows: float(kalmanq.Filter(model).run(data(rows, axes)).mean[-1, 0])


def run_filterpy(axes: int, derivatives: int) -> Callable[[int], float]:
    return lambda rows: float(filterpy_of(axes, derivatives).batch_filter(data(rows, axes))[0][-1, 0])


def run_statsmodels(axes: int, derivatives: int) -> Callable[[int], float]:
    from statsmodels.tsa.statespace.kalman_filter import KalmanFilter

    A, H, Q, R, P0 = moving(axes, derivatives)

    def run(rows: int) -> float:
        f = KalmanFilter(k_endog=axes, k_states=len(A), k_posdef=len(A))
        f.bind(data(rows, axes))
        f["transition"], f["design"], f["selection"], f["state_cov"], f["obs_cov"] = A, H, np.eye(len(A)), Q, R
        f.initialize_known(np.zeros(len(A)), P0)
        return float(f.filter().filtered_state[0, -1])

    return run


def pairs(f: Any) -> Callable[[int], float]:
    z = data(1000, 2)

    def run(rows: int) -> float:
        for k in range(rows):
            f.predict()
            f.update(z[k % 1000])
        return float(np.ravel(f.x if hasattr(f, "x") else f.mean)[0])

    return run


def pair_kalmanq() -> Callable[[int], float]:
    import kalmanq

    return pairs(kalmanq.Filter(model_of(2, 2)))


def series_kalmanq() -> Callable[[int], float]:
    import kalmanq

    model = model_of(2, 2)
    return lambda rows: float(kalmanq.run_series(model, data(rows, 2).reshape(-1, 500, 2)).mean[-1, -1, 0])


def series_simdkalman() -> Callable[[int], float]:
    import simdkalman

    A, H, Q, R, P0 = moving(2, 2)
    f = simdkalman.KalmanFilter(A, Q, H, R)
    return lambda rows: float(f.compute(data(rows, 2).reshape(-1, 500, 2), 0, initial_value=np.zeros(4), initial_covariance=P0, filtered=True,
                                        smoothed=False, likelihoods=True, gains=False).filtered.states.mean[-1, -1, 0])


def command(*arguments: str) -> None:
    from kalmanq.command_line import main

    sys.argv = ["kalmanq", *arguments]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()), contextlib.suppress(SystemExit):
        main()


FILE = """[model]
A = [[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]]
G = [[0.04, 0], [0.16, 0], [0, 0.04], [0, 0.16]]
H = [[1, 0, 0, 0], [0, 0, 1, 0]]
R = [0.25, 0.25]
P0 = [10, 10, 10, 10]
[measurements]
names = ["x", "y"]
"""


def file_kalmanq() -> Callable[[int], float]:
    folder = tempfile.TemporaryDirectory()
    model, table, out = (Path(folder.name) / name for name in ("m.toml", "z.csv", "out.csv"))
    model.write_text(FILE)
    np.savetxt(table, data(TASKS["file"]["kalmanq"][0], 2), "%.3f", ",", header="x,y", comments="")

    def run(_: int) -> float:
        command("run", str(model), str(table), "-o", str(out))
        return out.stat().st_size * bool(folder)

    return run


def season_kalmanq() -> Callable[[int], float]:
    import kalmanq
    from kalmanq.model.model_file import read

    text = ('[model]\nbuilder = "trend_harmonic"\ntime_unit = "day"\ndt = 1.0\nperiod = 365.25\nharmonics = 3\ndensity = [0.1, 1e-8, 1e-6]\n'
            'noise = 1.0\nP0 = "unknown"\n')
    random, t = np.random.default_rng(2), np.arange(2000)
    z = 20 + 0.002 * t + 8 * np.sin(2 * np.pi * t / 365.25 - 1) + np.cumsum(0.15 * random.normal(size=2000)) + 1.2 * random.normal(size=2000)
    keep = random.random(2000) > 0.075
    return lambda _: _fitted(kalmanq, read, text, z[keep, None], t[keep].astype(float), ("density", "noise"))


def sensors_kalmanq() -> Callable[[int], float]:
    import kalmanq
    from kalmanq.model.model_file import read

    text = "[model]\nF = [[0, 1], [0, -0.05]]\nQc = [0, 0.1]\ndt = 0.15\nH = [[1, 0], [1, 0], [1, 0]]\nR = [0.5, 0.5, 0.5]\nP0 = [100, 10]\n"
    random = np.random.default_rng(3)
    t = np.round(np.cumsum(random.uniform(0.05, 0.25, 7500)), 3)
    speed = np.cumsum(np.sqrt(0.3 * np.diff(t, prepend=t[0])) * random.normal(size=7500))
    z, which = np.full((7500, 3), np.nan), random.integers(0, 3, 7500)
    z[np.arange(7500), which] = np.cumsum(speed * np.diff(t, prepend=t[0])) + np.array([1.0, 0.5, 0.2])[which] * random.normal(size=7500)
    return lambda _: _fitted(kalmanq, read, text, z, t, ("F", "Qc", "R"), R_form="diagonal", held={"F": np.array([[1, 1], [1, 0]], bool)})


def _fitted(kalmanq: Any, read: Any, text: str, z: np.ndarray, times: np.ndarray, free: tuple[str, ...], **more: Any) -> float:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "m.toml"
        path.write_text(text)
        found = kalmanq.fit(read(path), [z], free, times=[times], **more)
    return found.log_likelihood if found.converged else float("nan")


# Of each task: rows of each library, and how to do it
TASKS: dict[str, dict[str, tuple[int, Callable[[], Callable[[int], float]]]]] = {
    "step": {"kalmanq": (1_000_000, lambda: run_kalmanq(2, 2)), "filterpy": (30_000, lambda: run_filterpy(2, 2)), "statsmodels": (1_000_000, lambda: run_statsmodels(2, 2))},
    "pair": {"kalmanq": (100_000, pair_kalmanq), "filterpy": (30_000, lambda: pairs(filterpy_of(2, 2)))},
    "nine": {"kalmanq": (300_000, lambda: run_kalmanq(3, 3)), "statsmodels": (300_000, lambda: run_statsmodels(3, 3))},
    "series": {"kalmanq": (500_000, series_kalmanq), "simdkalman": (500_000, series_simdkalman)},
    "file": {"kalmanq": (1_000_000, file_kalmanq)},
    "season": {"kalmanq": (1, season_kalmanq)}, "sensors": {"kalmanq": (1, sensors_kalmanq)},
}
ALONE = ("file", "season", "sensors")
AT_LEAST = {("step", "filterpy"): 100, ("step", "statsmodels"): 20, ("pair", "filterpy"): 4}  # what is asked for


def one(task: str) -> None:
    """The libraries take turns, and the least of each counts"""
    least: dict[str, tuple[float, float]] = {}
    work = {library: (rows, prepare()) for library, (rows, prepare) in TASKS[task].items() if importlib.util.find_spec(library)}
    for rows, run in work.values():
        if rows > 1 and task != "file":
            run(500)  # imports
            data(rows, 3 if task == "nine" else 2)
    for _ in range(1 if task in ALONE else TURNS):
        for library, (rows, run) in work.items():
            begun = time.process_time()
            made = run(rows)
            least[library] = min((1e6 * (time.process_time() - begun) / rows, made), least.get(library, (math.inf, made)))
    for library, (microseconds, made) in least.items():
        print(library, microseconds, made, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)


def measured(task: str, peers: str) -> dict[str, tuple[float, float]]:
    """Microseconds and MB by library; one that is not installed is not there.  Tasks without others need this package's own environment."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "kalmanq").symlink_to(Path(importlib.util.find_spec("kalmanq").origin).parent)
        done = subprocess.run([sys.executable if task in ALONE else peers, "-B", __file__, "--one", task], capture_output=True, text=True,
                              env={**os.environ, **ONE_THREAD, "PYTHONPATH": folder})
    assert done.returncode == 0, done.stderr
    return {library: (float(value), float(most)) for library, value, _, most in map(str.split, done.stdout.splitlines())}


def main() -> None:
    peers, *chosen = sys.argv[1:]
    failed = False
    for task in chosen or TASKS:
        of = measured(task, peers)
        least = {library: value for library, (value, _) in of.items()}
        print(f"{task}: microseconds", ", ".join(f"{library} {value:.3g}" for library, value in least.items()),
              *[f"{of['kalmanq'][1]:.0f} MB at most"] * (task == "file"), flush=True)
        for library in TASKS[task]:
            ratio, asked = least.get(library, math.nan) / least["kalmanq"], AT_LEAST.get((task, library))
            if library != "kalmanq" and ratio == ratio:
                print(f"  {ratio:.1f} times as fast as {library}" + (f"; {asked} are asked for" if asked else ""))
            failed |= asked is not None and not ratio >= asked
    sys.exit(failed)


if __name__ == "__main__":
    if sys.argv[1] == "--one":
        one(*sys.argv[2:])
    else:
        main()
