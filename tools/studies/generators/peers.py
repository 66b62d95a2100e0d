"""peers.py SYMFORCE_PYTHON: filters of `kalmanq compile MODEL.py` beside an EKF of SymForce's code, as in PX4's ekf2.

    python3 -m venv /tmp/sym && /tmp/sym/bin/pip install symforce==0.12.0
    PYTHONPATH=tools /usr/bin/python3 -B tools/studies/generators/peers.py /tmp/sym/bin/python

Run by a Python that can count (kq_setup cost).  Prints a table.  On a Cortex-M4F: instructions of a predict and a full
update, the most of 40 rows, with PX4's -funsafe-math-optimizations, too; bytes of flash with libm's; whether there is a heap.
On this machine, of 5 x 400 rows: how far f32 comes from the same code in double, mean (sigma) and covariance (sigma_i
sigma_j), and rows whose covariance is not positive definite; all of it again with R * 1e-6 and P0 * 100.
"""

from __future__ import annotations

import ctypes
import json
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tools" / "cost"))

from build import MARKS, TARGET, linked
from cores import BY_NAME, run, toolchain
from errors import UserError, told_in_one_line

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.firmware.elf import flash_and_ram
from kalmanq.firmware.emulated import Emulator
from kalmanq.nonlinear import NonlinearModel, read
from kalmanq.nonlinear.simulation import simulate

HERE = Path(__file__).resolve().parent
EXAMPLES, FILTER = ROOT / "tools" / "kalmanq" / "examples", HERE / "filter.cpp"
FILES = [*(EXAMPLES / f"{name}.py" for name in ("battery", "range_bearing", "gps_imu")), ROOT / "tools" / "tests" / "equations" / "coordinated_turn.py"]
FORMS = ("P - K H P", "as PX4", "all by SymForce")  # of filter.cpp
CORE, FLAGS = BY_NAME["m4f"], ("-O2", "-ffunction-sections", "-ffp-contract=fast", "-fno-math-errno")
COUNTED, ROWS, SEEDS, LOW = 40, 400, (1, 2, 3, 4, 5), "_low"  # the battery is empty after 480 rows
SAME = 1e-3  # sigma, of the two in double, a component after the other: SymForce's turn has an epsilon of 1e-6 rad/s
THEIRS = """\
void peer_start(void), peer_predict(const float *u), peer_update(const float *z, const float *u);
#define START peer_start()
#define PREDICT(u) peer_predict(u)
#define UPDATE(z, u) peer_update(z, u)
"""
OURS = """\
#include "ours.h"
static ours_filter f;
#define START ours_start(&f)
#define PREDICT(u) ours_predict(&f{predict})
#define UPDATE(z, u) ours_update(&f, z{update})
"""
NOTHING = "#define START\n#define PREDICT(u) (void)(u)\n#define UPDATE(z, u) (void)(z), (void)(u)\n"
MAIN = """\
#include "calls.h"
void cost_region(unsigned region);
void cost_end(void);
int main(void)
{
    START;
    for (unsigned k = 0; k < sizeof z / sizeof z[0]; k++) {
        if (k) { cost_region(0); PREDICT(u[k - 1]); }
        cost_region(1);
        UPDATE(z[k], u[k]);
        cost_region(2);
    }
    cost_end();
    return 0;
}
"""


@dataclass(frozen=True)
class Case:
    model: NonlinearModel
    records: list  # z, u: what floats can hold


def cases(folder: Path) -> dict[str, Case]:
    """Of each file two: with low noise the filter begins less certain, the state no farther off"""
    made = {}
    for path in FILES:
        for suffix, R, P0 in (("", 1, 1), (LOW, 1e-6, 100)):
            drawn, used = (changed(path, folder / f"{path.stem}.py", R, factor) for factor in (1, P0))
            records = [tuple(one.astype(np.float32).astype(float) for one in simulate(drawn, ROWS, seed)[1:]) for seed in SEEDS]
            made[path.stem + suffix] = Case(used, records)
    return made


def changed(path: Path, copy: Path, R: float, P0: float) -> NonlinearModel:
    copy.write_text(f"{path.read_text()}\nR, P0 = {R} * np.array(R), {P0} * np.array(P0)\n")
    return read(copy)


def described(name: str, model: NonlinearModel) -> dict:
    """As symforce_code.py reads it"""
    arrays = {"Q": model.Q, "R": np.diag(model.R), "x0": model.x0, "P0": model.P0.ravel()}
    return {"model": name.removesuffix(LOW), "n": model.n, "l": model.l, "angles": list(model.angles),
            **{key: one.tolist() for key, one in arrays.items()}}


def padded(u: np.ndarray) -> np.ndarray:
    return u if u.shape[1] else np.zeros((len(u), 1))


# ---- on the Cortex-M4F -----------------------------------------------------------------------


def program(folder: Path, calls: str, source: Optional[Path] = None, *flags: str) -> Path:
    (folder / "calls.h").write_text((folder / "rows.h").read_text() + calls)
    (folder / "main.c").write_text(MAIN)
    gcc, *core = toolchain(CORE, "gcc").compiler
    objects = []
    for path in (folder / "main.c", MARKS, *([source] if source else [])):
        own = [gcc.replace("gcc", "g++"), "-fno-exceptions", "-fno-rtti"] if path.suffix == ".cpp" else [gcc, "-std=c11"]
        objects.append(folder / f"{path.stem}.o")
        run([*own, *core, *FLAGS, *(flags if path == source else ["-DKQ_COST_f32"]), *(f"-I{one}" for one in (
            folder, folder.parent, TARGET, ROOT / "include")), "-c", str(path), "-o", str(objects[-1])])
    return linked(CORE, objects, folder / "program.elf")


def on_core(folder: Path, *given) -> tuple[int, int, bool]:
    """Instructions, bytes, a heap"""
    bare = flash_and_ram(program(folder, NOTHING))[0]
    made = program(folder, *given)
    emulator = Emulator(CORE, made)
    counted, names = emulator.count_regions({}), emulator.elf.symbols
    return counted[0].instructions + counted[1].instructions, flash_and_ram(made)[0] - bare, any("malloc" in one for one in names)


def costs(folder: Path, case: Case) -> list[str]:
    """kalmanq's, and of each form"""
    z, u = (one[:COUNTED] for one in case.records[0])
    (folder / "rows.h").write_text(array("z", z) + array("u", padded(u)))
    product = compiled_equations(case.model, "ours", Options("f32"))
    for name, text in product.sources().items():
        (folder / name).write_text(text)
    predict, update = (", u" * (" u[" in re.search(rf"^\w+ ours_{call}\((.*)\);", product.header, re.M)[1])
                       for call in ("predict", "update"))
    rows = [[on_core(folder, OURS.format(predict=predict, update=update), folder / "ours.c")]]
    for form in range(len(FORMS)):
        own = (THEIRS, FILTER, "-DT=float", f"-DFORM={form}")
        rows.append([on_core(folder, *own), on_core(folder, *own, "-funsafe-math-optimizations")])
    return [f"{' / '.join(str(one[0]) for one in row)} | {row[0][1]} | {'yes' if row[0][2] else 'none'}" for row in rows]


def array(name: str, rows: np.ndarray) -> str:
    inner = ", ".join("{" + ", ".join(f"{one!r}f" for one in row) + "}" for row in rows.tolist())
    return f"static const float {name}[{len(rows)}][{rows.shape[1]}] = {{{inner}}};\n"


# ---- on this machine -------------------------------------------------------------------------


def theirs(folder: Path, form: int, word: str, z: np.ndarray, u: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    library = folder / f"{word}{form}.so"
    if not library.exists():
        run(["g++", "-O2", "-ffp-contract=off", "-fPIC", "-shared", f"-DT={word}", f"-DFORM={form}", "-DHOST", f"-I{folder}",
             f"-I{folder.parent}", str(FILTER), "-o", str(library)])
    made = np.zeros((len(z), n)), np.zeros((len(z), n, n))
    arrays = [np.ascontiguousarray(one) for one in (z, padded(u))]
    ctypes.CDLL(str(library)).run(len(z), *(ctypes.c_void_p(one.ctypes.data) for one in (*arrays, *made)))
    return made


def ours(host: Host, z: np.ndarray, u: np.ndarray, times: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """times m: a component after the other, each at the mean that the one before has left, as PX4 takes them"""
    rows, m = z.shape
    carried, now, z = (np.repeat(one, times, axis=0) for one in (np.vstack([np.zeros((1, u.shape[1])), u[:-1]]), u, z))
    part = np.arange(rows * times) % times
    made = host.run(z, carried, now=now, present=np.full(rows, 2**m - 1) if times == 1 else 1 << part,
                    what=UPDATES + PREDICTS * ((part == 0) & (np.arange(rows * times) > 0)))
    return made.reading[times - 1::times], made.covariance[times - 1::times]


def apart(one: tuple, other: tuple) -> list[float]:
    sigma = np.sqrt(np.diagonal(other[1], axis1=1, axis2=2))
    return [float(np.max(np.nan_to_num(np.abs(error), nan=np.inf))) for error in (
        (one[0] - other[0]) / sigma, (one[1] - other[1]) / (sigma[:, :, None] * sigma[:, None, :]))]


def not_definite(P: np.ndarray) -> int:
    """Rows with a variance, or an eigenvalue of the correlations, that is not above 0"""
    variances = np.diagonal(P, axis1=1, axis2=2)
    good = np.isfinite(P).all(axis=(1, 2)) & (variances > 0).all(axis=1)
    sigma = np.sqrt(variances[good])
    return len(P) - int((np.linalg.eigvalsh(P[good] / (sigma[:, :, None] * sigma[:, None, :]))[:, 0] > 0).sum())


def errors(folder: Path, case: Case) -> list[str]:
    """kalmanq's, and of each form"""
    model = case.model
    made = [[] for _ in range(len(FORMS) + 1)]
    single, double = (compiled_equations(model, "ours", Options(arithmetic)) for arithmetic in ("f32", "f64"))
    with Host(single) as f32, Host(double) as f64:
        for z, u in case.records:
            runs = [(ours(f32, z, u), ours(f64, z, u))]
            runs += [[theirs(folder, form, word, z, u, model.n) for word in ("float", "double")] for form in range(len(FORMS))]
            for rows, pair in zip(made, runs):
                rows.append([*apart(*pair), *(not_definite(P) for _, P in pair)])
            off = max(apart(runs[2][1], ours(f64, z, u, model.m)))
            if not off < SAME:
                raise UserError(f"{folder.name}: in double SymForce's is {off:.1e} sigma from kalmanq's: not the same model")
    text = []
    for rows in made:
        mean, P, lost, lost_double = np.array(rows).T
        text.append(f"{mean.max():.1e}, {P.max():.1e} | {lost.sum():.0f}" + f" ({lost_double.sum():.0f})" * bool(lost_double.any()))
    return text


def main() -> None:
    if len(sys.argv) != 2:
        raise UserError("give the Python that has symforce (and first PYTHONPATH=tools)")
    with tempfile.TemporaryDirectory() as place:
        work, known = Path(place), cases(Path(place))
        (work / "models.json").write_text(json.dumps({name: described(name, case.model) for name, case in known.items()}))
        run([sys.argv[1], str(HERE / "symforce_code.py"), str(work / "models.json"), str(work)])
        print("| model | filter | instructions / PX4's flag | flash | heap | error: mean, covariance | not definite | "
              "low noise: error | not definite |\n|---|---|--:|--:|---|--:|--:|--:|--:|")
        for path in FILES:
            name = path.stem
            columns = costs(work / name, known[name]), *(errors(work / one, known[one]) for one in (name, name + LOW))
            for who, *cells in zip(("kalmanq", *FORMS), *columns):
                print(f"| {name} | {who} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    with told_in_one_line("peers"):
        main()
