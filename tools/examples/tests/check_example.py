"""The examples of tools/examples: what they print is right, over many seeds.

    check_example.py run KALMANQ NAME FOLDER LIBRARY RUNS          checks RUNS seeds, draws the first one: FOLDER.png
    check_example.py core KALMANQ NAME FOLDER LIBRARY OBJECT...    a Cortex-M4F, emulated, prints what the host does

KALMANQ: the command that writes the device; LIBRARY: the host's; OBJECT: of the core's.  Prints RMS and NEES/n; answers 0 where all is as it should be.
"""
from __future__ import annotations

import pathlib
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tools/examples"), str(ROOT / "tests/reference")]
from nonlinear_models import chance_band  # noqa: E402
from plot import KINDS, draw, quantities, read_run  # noqa: E402

# The options that each is run with
OPTIONS = {"attitude": [[]], "battery": [[]], "gps_imu": [[], ["points"]],
           "range_bearing": [["sharp"], ["extended"], ["points"], []]}
# Of what a sharp sensor says all the smoother has nothing to add.
AS_GOOD = {("sharp",): ("east_m", "north_m")}
# The RMS of an axis, filter and smoother, of 100 runs of a prototype in NumPy with such an attitude.  Not all of its
# settings are known, hence the tolerance.
ATTITUDE = {("roll_deg", "pitch_deg", "yaw_deg"): (1.376, 0.930),
            ("bias_x_rad_s", "bias_y_rad_s", "bias_z_rad_s"): (0.0197, 0.0121)}
ATTITUDE_TOLERANCE, MANY = 0.10, 100


CORE = "m4f"


def built(kalmanq, name, core, folder, library) -> str:
    """The program of an example on a core"""
    printed(["sh", str(ROOT / "tools/examples/tests/built.sh"), kalmanq, name, core, folder, *library])
    return f"{folder}/{name}"


def printed(command) -> list[str]:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode or done.stderr:
        raise SystemExit(f"{' '.join(command)}: status {done.returncode}, {done.stderr.strip()}")
    return done.stdout.splitlines()


def sound(run, name) -> list[str]:
    """What is wrong with the columns of a run"""
    wanted = ["step", "time"]
    for quantity in quantities(run):
        wanted += [quantity + "_truth"] + [f"{quantity}_{kind}{end}" for kind in KINDS for end in ("", "_sigma")]
    wanted += [f"nees_{kind}" for kind in KINDS]
    faults = [] if list(run) == wanted else [f"{name}: columns {list(run)}"]
    faults += [f"{name}: {column} is not finite" for column in run if not np.isfinite(run[column]).all()]
    faults += [f"{name}: {column} is not positive" for column in run if column.endswith("_sigma") and
               not (run[column] > 0).all()]
    return faults


def rms(runs, quantity, kind) -> float:
    return float(np.sqrt(np.mean([(run[f"{quantity}_{kind}"] - run[f"{quantity}_truth"]) ** 2 for run in runs])))


def check_rms(runs, name, options) -> list[str]:
    """The smoother is better than the filter in each quantity."""
    faults = []
    for quantity in quantities(runs[0]):
        before, after = (rms(runs, quantity, kind) for kind in KINDS)
        print(f"{name:32} {quantity:16} RMS filter {before:.4g}, smoother {after:.4g}")
        limit = 1.001 if quantity in AS_GOOD.get(tuple(options), ()) else 1
        if not after < limit * before:
            faults.append(f"{name}: {quantity}: the smoother is worse than the filter")
    return faults


def check_nees(runs, name, is_right) -> list[str]:
    """NEES/n over K runs of n states is chi-square (n K) / (n K) at one step where all is linear.  The mean over the
    steps varies less, so the band is on the safe side.  is_right: is it to be within the band?"""
    low, high = chance_band(len(quantities(runs[0])) * len(runs))
    faults = []
    for kind in KINDS:
        value = np.mean([run[f"nees_{kind}"] for run in runs])
        print(f"{name:32} NEES/n {kind} {value:.3f} ({low:.2f} .. {high:.2f})")
        if (low < value < high) != is_right:
            faults.append(f"{name}: NEES/n {kind} {value:.3g} is {'not ' if is_right else ''}within {low:.2f} .. {high:.2f}")
    return faults


def check_attitude(runs) -> list[str]:
    """Beside the prototype"""
    faults = []
    for names, wanted in ATTITUDE.items():
        for kind, figure in zip(KINDS, wanted):
            value = np.sqrt(np.mean([rms(runs, name, kind) ** 2 for name in names]))
            print(f"attitude: {kind} {names[0]} and the other axes: {value:.4g}, prototype {figure}")
            if abs(value / figure - 1) > ATTITUDE_TOLERANCE:
                faults.append(f"attitude: {kind} {names[0]}: {value:.4g} is not near {figure}")
    return faults


def check_sharp(program, count) -> list[str]:
    """Without iteration a sharp sensor makes the filter believe what is wrong: the reason for the option, and what the
    band finds."""
    runs = [read_run(printed([program, str(seed), "extended", "sharp"])) for seed in range(1, count + 1)]
    value = np.mean([run["nees_smoothed"] for run in runs])
    print(f"range_bearing extended sharp     NEES/n smoothed {value:.3g}")
    return [] if value > 100 else ["range_bearing extended sharp: NEES/n is not beyond 100"]


def check_refusals(program) -> list[str]:
    faults = []
    for words in (["one"], ["-1"], ["9" * 30], ["1", "nonsense"]):
        done = subprocess.run([program, *words], capture_output=True, text=True)
        if done.returncode != 2 or done.stdout or done.stderr.count("\n") != 1:
            faults.append(f"{program} {' '.join(words)}: status {done.returncode}, {done.stdout}{done.stderr}")
    return faults


def check_run(name, program, count, picture) -> list[str]:
    faults = check_refusals(program)
    for options in OPTIONS[name]:
        title = " ".join([name, *options])
        runs = [read_run(printed([program, str(seed), *options])) for seed in range(1, count + 1)]
        for run in runs:
            faults += sound(run, title)
        faults += check_rms(runs, title, options)
        faults += check_nees(runs, title, count < MANY or "extended" not in options)  # many runs show what it believes too much
    draw(runs[0], picture, f"{title}, seed 1")
    if count >= MANY and name == "attitude":
        faults += check_attitude(runs)
    if count >= MANY and name == "range_bearing":
        faults += check_sharp(program, count)
    return faults


def check_core(program, on_core) -> list[str]:
    """Sines and logarithms of two C libraries differ in their last bits, and so do the runs."""
    host, (*core, last) = read_run(printed([program])), printed(["sh", str(ROOT / "tests/target/run.sh"), CORE, on_core])
    core = read_run(core)
    faults = [] if last == "OK" and list(core) == list(host) else ["the core prints something else"]
    worst = max(np.max(np.abs(core[f"{name}_{kind}"] - host[f"{name}_{kind}"]) / host[f"{name}_{kind}_sigma"])
                for name in quantities(host) for kind in KINDS)
    print(f"{pathlib.Path(program).name}: core and host are apart by {worst:.1e} sigma")
    return faults + ([] if worst < 1e-3 else ["core and host are apart by more than 1e-3 sigma"])


def main():
    what, kalmanq, name, folder, library, *rest = sys.argv[1:]
    program = built(kalmanq, name, "host", folder, [library])
    if what == "core":
        faults = check_core(program, built(kalmanq, name, CORE, f"{folder}/{CORE}", rest))
    else:
        faults = check_run(name, program, int(rest[0]), f"{folder}.png")
    sys.exit("\n".join(faults) or 0)


if __name__ == "__main__":
    main()
