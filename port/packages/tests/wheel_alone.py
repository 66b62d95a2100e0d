"""wheel_alone.py FOLDER: what the wheel in FOLDER is where nothing is installed beside what it requires: size, time of its
import, a filter in three arithmetics, every public name, and what the command says of the extra that it lacks."""

import importlib.metadata
import subprocess
import sys
from pathlib import Path

SECONDS = 0.3
FIRST = "import kalmanq; kalmanq.Filter(kalmanq.Model(A=[1], H=[1], Q=1, R=1, P0=1)).run([1.0])"


def seconds(statement: str) -> float:
    """Of a processor, in a new interpreter: the least of five; an interpreter that does nothing is taken off"""
    code = f"import time; begun = time.process_time(); {statement}; print(time.process_time() - begun)"
    return min(float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout) for _ in range(5))


def filtered() -> None:
    import kalmanq

    state = kalmanq.Quantity("level", range=10)
    gauge = kalmanq.Quantity("gauge", range=10)
    model = kalmanq.Model(A=[1], H=[1], Q=1, R=1, P0=1, x0=[5], states=[state], measurements=[gauge])
    for arithmetic in ("f32", "f64", "q31"):
        mean = kalmanq.Filter(model, arithmetic).run([6.0]).mean[0, 0]
        assert abs(mean - 5.5) < 1e-5, (arithmetic, mean)  # P0 = R: the gain is 1 / 2
    for name in kalmanq.__all__:
        getattr(kalmanq, name)


def command() -> str:
    done = subprocess.run([sys.executable, "-m", "kalmanq", "--help"], capture_output=True, text=True)
    assert done.returncode == 1 and not done.stdout and done.stderr.count("\n") == 1, done
    assert "pip install 'kalmanq[cli]'" in done.stderr, done.stderr
    return done.stderr.strip()


folder = Path(sys.argv[1])
[wheel], [source] = folder.glob("*.whl"), folder.glob("*.tar.gz")
print("installed:", *sorted(f"{one.name} {one.version}" for one in importlib.metadata.distributions() if one.name != "pip"))
filtered()
print(command())
alone, numpy, first, backend = (seconds(one) for one in ("import kalmanq", "import numpy", FIRST, "import _cffi_backend"))
print(f"{wheel.name}: {wheel.stat().st_size / 1000:.0f} kB; {source.name}: {source.stat().st_size / 1000:.0f} kB")
print(f"import {alone:.3f} s; import and a filter's first row {first:.3f} s, of which NumPy {numpy:.3f} s, cffi {backend:.4f} s")
sys.exit(f"an import and a first row take more than {SECONDS} s" if first > SECONDS else 0)
