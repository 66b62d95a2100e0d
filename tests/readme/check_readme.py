"""The README's programs compile, clean, and print what the README says.

usage: check_readme.py README SOURCE LIBRARY WORK
"""
import pathlib
import re
import subprocess
import sys


def programs(text: str) -> list[tuple[str, str]]:
    """Each C program with the text block behind it."""
    found = re.findall(r"^```c\n(.*?)^```\n+```text\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    if len(found) < 2:
        sys.exit("the README should have a program in float and one in q31, with what they print")
    return found


def run(program: str, source: str, library: str, folder: pathlib.Path) -> str:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "example.c").write_text(program, encoding="utf-8")
    subprocess.run(
        ["cc", "-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
         f"-I{source}/include", str(folder / "example.c"), library, "-lm", "-o",
         str(folder / "example")],
        check=True)
    return subprocess.run([str(folder / "example")], check=True, capture_output=True,
                          text=True).stdout


def main(readme: str, source: str, library: str, work: str) -> None:
    text = pathlib.Path(readme).read_text(encoding="utf-8")
    for number, (program, expected) in enumerate(programs(text)):
        printed = run(program, source, library, pathlib.Path(work) / str(number))
        if printed != expected:
            sys.exit(f"the README's program {number} prints:\n{printed}")
        print(printed, end="")


if __name__ == "__main__":
    main(*sys.argv[1:])
