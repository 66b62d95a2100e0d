"""The README's program compiles, clean, and prints what the README says.

usage: check_readme.py README SOURCE WORK
"""
import pathlib
import re
import subprocess
import sys


def block(text: str, language: str) -> str:
    found = re.search(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    if not found:
        sys.exit(f"the README has no ```{language} block")
    return found.group(1)


def main(readme: str, source: str, work: str) -> None:
    text = pathlib.Path(readme).read_text(encoding="utf-8")
    folder = pathlib.Path(work)
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "example.c"
    program.write_text(block(text, "c"), encoding="utf-8")
    sources = sorted(str(p) for p in (pathlib.Path(source) / "src").glob("*.c"))
    subprocess.run(
        ["cc", "-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
         f"-I{source}/include", str(program), *sources, "-lm", "-o", str(folder / "example")],
        check=True)
    printed = subprocess.run([str(folder / "example")], check=True, capture_output=True,
                             text=True).stdout
    if printed != block(text, "text"):
        sys.exit(f"the README's program prints:\n{printed}")
    print(printed, end="")


if __name__ == "__main__":
    main(*sys.argv[1:])
