"""sketches.py WORK: the Arduino package by arduino-lint's rules; its sketches run on the host and are built for an ATmega328P, with
a stand-in of Arduino.h; the sizes are those of the package's README.  PlatformIO's package has the same examples."""

import json
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import packages  # noqa: E402

NAME, CATEGORIES = re.compile(r"[A-Za-z0-9][\w.-]{0,62}"), {"Sensors", "Data Processing", "Signal Input/Output", "Timing", "Other"}
FLASH, RAM = 32256, 2048  # of an Uno, beside its bootloader
WANTED = [  # rows, and of the last line each number: the truth within 4 sigma, the sigma of the textbook's recursion
    ("first", 200, [(511, 0.01)]),
    ("height", 1500, [(120, 0.1), (0, 0.1)]),
    ("speed", 195, [(14, 0.6), (0.148, 0.006)]),
    ("speed", 249, [(14, 86), (21.52, 0.01)]),  # at the end of the tunnel
    ("weight", 102, [(250, 0.24), (0.041, 0.006)]),  # the second row with 250 g: two readings, 0.058 / sqrt(2)
    ("weight", 400, [(250, 0.07), (0.017, 0.006)]),
]
NAMES = sorted({name for name, _, _ in WANTED})



def lint(folder):
    """arduino-lint's rules for a library that is to be in the index"""
    given = dict(line.split("=", 1) for line in (folder / "library.properties").read_text().splitlines())
    assert NAME.fullmatch(given["name"]) and given["name"] == folder.name and not given["name"].lower().startswith("arduino")
    assert re.fullmatch(r"\d+\.\d+\.\d+", given["version"]) and given["version"] == packages.VERSION
    assert all(given[key].strip() == given[key] != "" for key in ("author", "maintainer", "sentence", "paragraph", "architectures"))
    assert not given["paragraph"].startswith(given["sentence"]) and given["category"] in CATEGORIES and given["url"].startswith("https://")
    assert (folder / "src" / given["includes"]).is_file() and not (folder / "utility").exists()
    assert "MIT License" in (folder / "LICENSE").read_text() and (folder / "README.md").is_file()
    for path in folder.rglob("*"):
        assert not path.is_symlink() and path.suffix not in (".exe", ".o", ".a") and path.name not in (".gitmodules", ".development")
    for path in (folder / "examples").iterdir():
        assert NAME.fullmatch(path.name) and [one.name for one in path.iterdir()] == [f"{path.name}.ino"], path
        assert len((path / f"{path.name}.ino").read_text().splitlines()) <= 42 and "kalmanq.h" in (path / f"{path.name}.ino").read_text()
    words = [re.fullmatch(r"(\w+)\t(KEYWORD1|KEYWORD2|LITERAL1)", line) for line in (folder / "keywords.txt").read_text().splitlines()]
    assert all(words) and {"kq_filter_f32", "kq_step_f32", "KQ_FILTER_F32"} <= {one[1] for one in words}


def library(work, folder, cc, flags):
    """Objects of float's arithmetic"""
    names = [path for path in sorted((folder / "src").glob("kq_*.c")) if path.stem in ("kq_filter_f32", "kq_nonlinear_f32", "kq_status")]
    made = [work / f"{cc}_{path.stem}.o" for path in names]
    for path, to in zip(names, made):
        subprocess.run([cc, "-std=c11", "-I", folder / "src", *flags, "-c", path, "-o", to], check=True)
    return made


def program(work, folder, name, cxx, flags, objects):
    to = work / f"{cxx}_{name}"
    subprocess.run([cxx, "-std=c++11", "-fno-threadsafe-statics", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-Werror", "-I", folder / "src", "-I", HERE / "arduino", "-include", "Arduino.h", *flags,
                    "-x", "c++", folder / "examples" / name / f"{name}.ino", "-x", "none", *objects, "-lm", "-o", to], check=True)
    return to


def numbers(work, folder, name, rows, objects):
    """Of the last line"""
    said = subprocess.run([program(work, folder, name, "g++", ["-O1", f"-DKQ_ROWS={rows}"], objects)], check=True, capture_output=True, text=True).stdout
    assert "refused" not in said and said.count("\n") == rows, said[-200:]
    return [float(one) for one in re.findall(r"-?\d+\.\d+", said.splitlines()[-1])]


def sizes(work, folder, objects, flags):
    """Of each sketch without Arduino's core: flash, RAM"""
    for name in NAMES:
        said = subprocess.run(["avr-size", program(work, folder, name, "avr-g++", flags, objects)], check=True, capture_output=True, text=True).stdout
        text, data, bss = map(int, said.splitlines()[1].split()[:3])
        assert text + data < FLASH and data + bss < RAM, said
        yield name, text + data, data + bss


def main(work):
    work.mkdir(parents=True, exist_ok=True)
    for name in ("arduino", "platformio"):
        packages.main(name, work / name / "kalmanq")
    folder = work / "arduino" / "kalmanq"
    lint(folder)
    manifest = json.loads((work / "platformio/kalmanq/library.json").read_text())
    there = {path.parent.name for path in (work / "platformio/kalmanq/examples").glob("*/*.ino")}
    assert {one["name"] for one in manifest["examples"]} == there == set(NAMES) == {path.name for path in (folder / "examples").iterdir()}
    objects = library(work, folder, "gcc", ["-O1"])
    for name, rows, wanted in WANTED:
        found = numbers(work, folder, name, rows, objects)
        assert len(found) == len(wanted) and all(abs(x - y) <= off for x, (y, off) in zip(found, wanted)), (name, found, wanted)
    flags = ["-mmcu=atmega328p", "-Os", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections"]
    made = list(sizes(work, folder, library(work, folder, "avr-gcc", flags), flags))
    print("".join(f"{name}: {flash} bytes of flash, {ram} of RAM\n" for name, flash, ram in made) + f"{len(made)} sketches run and are built")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
