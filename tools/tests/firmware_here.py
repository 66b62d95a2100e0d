"""The C over the library that design writes, on this machine."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import numpy as np
from library import ROOT, objects, written

from kalmanq.core import arithmetic_of, ffi
from kalmanq.compiler.text.over_library import source
from kalmanq.model import model_file
from kalmanq.run.parts import Parts



FLAGS = ("-std=c11", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror", "-ffp-contract=off", "-fPIC",
         f"-I{ROOT / 'include'}", f"-I{ROOT / 'src' / 'fixed_size'}")


class Firmware:
    """What design or compile --library has written, with the library, on this machine"""

    def __init__(self, folder: Path, name: str, T: str):
        self.folder, self.a, self.name = folder, arithmetic_of(T), name
        subprocess.run(["cc", *FLAGS, "-shared", str(folder / f"{self.name}.c"), *objects(f"filter_{T}", f"steady_{T}", f"lengths_{T}"), "-lm", "-o",
                        str(folder / "firmware.so")], check=True)
        self.library = ctypes.CDLL(str(folder / "firmware.so"))
        self.filter = getattr(self.library, f"{self.name}_filter")
        self.filter.restype = ctypes.c_void_p
        assert self.call("init") == 0

    @classmethod
    def designed(cls, folder: Path, path: Path, T: str, *, way: str = "init", any_dt: bool = False, steps: int = 1) -> Firmware:
        text = source(Parts(model_file.read(path), T), way, any_dt=any_dt, steps=steps)
        written(folder, {f"{text.name}.h": text.header, f"{text.name}.c": text.text})
        return cls(folder, text.name, T)

    def call(self, function, *given):
        made = []
        for one in given:
            word = {"f32": ctypes.c_float, "f64": ctypes.c_double, "q31": ctypes.c_int32}[self.a.name]
            made.append((word * len(one))(*one.tolist()) if isinstance(one, np.ndarray) else
                        ctypes.c_float(one) if isinstance(one, float) else ctypes.c_size_t(one))
        return getattr(self.library, f"{self.name}_{function}")(*made)

    def reading(self, n: int) -> np.ndarray:
        f = ffi.cast(f"kq_filter_{self.a.name} *", self.filter())
        return np.array([[self.a.function(one)(f, i) for i in range(n)] for one in ("mean", "sigma")], float)

    def memory(self, length: int) -> np.ndarray:
        """Words of the filter: its mean and root"""
        f = ffi.cast(f"kq_filter_{self.a.name} *", self.filter())
        return np.array([f.memory[k] for k in range(length)], self.a.number)

    @property
    def late_ram(self) -> int:
        """Bytes of its objects for what comes late"""
        sizes = subprocess.run(["nm", "-S", str(self.folder / "firmware.so")], capture_output=True, text=True, check=True).stdout
        names = ("model_before", "model_before_memory", "model_steps", "model_count", "model_newest")
        return sum(int(line.split()[1], 16) for line in sizes.splitlines() if line.split()[-1] in names)
