#!/usr/bin/env python3
"""Pages of the site that are made: a page a header, a page a name of the package, and each command's help.  make_pages.py OUT"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def headers() -> dict[str, str]:
    """A page a header, and the page that lists them as kalmanq.h does"""
    folder = ROOT / "include" / "kalmanq"
    pages = {f"headers/{path.stem}": f"# {path.name}\n\n```{{doxygenfile}} {path.name}\n:sections: briefdescription detaileddescription func "
             "innerclass typedef enum define\n```\n" for path in sorted(folder.glob("*.h"))}
    said = dict(re.findall(r"^ \*     (\w+)\.h +(\S.*)$", (folder / "kalmanq.h").read_text(encoding="utf-8"), re.M))
    names = [*said, *(name for name in ("kalmanq",) if name not in said)]
    rows = [f"| [{name}.h](headers/{name}.md) | {said.get(name, 'includes all of them but generic.h')} |" for name in names]
    tree = "\n".join(f"headers/{name}" for name in names)
    pages["headers"] = ("# The C headers\n\nEvery name ends in `_f32`, `_f64` or `_q31`; the comment of the first is for all three.\n\n| header | it has |\n|---|---|\n"
                        + "\n".join(rows) + f"\n\n```{{toctree}}\n:hidden:\n\n{tree}\n```\n")
    return pages


def python() -> dict[str, str]:
    """A page a name of the package, and the page that lists them"""
    import kalmanq

    pages = {}
    for name in kalmanq.__all__:
        of = getattr(kalmanq, name)
        kind, options = ("class", "   :undoc-members:\n   :inherited-members: Exception\n") if isinstance(of, type) else ("function", "")
        pages[f"python/{name}"] = f"# {name}\n\n```{{eval-rst}}\n.. auto{kind}:: kalmanq.{name}\n{options}```\n"
    names, tree = "\n".join(f"   {name}" for name in kalmanq.__all__), "\n".join(f"python/{name}" for name in kalmanq.__all__)
    pages["python"] = ("# The names of the Python package\n\n```{eval-rst}\n.. currentmodule:: kalmanq\n\n.. autosummary::\n   :nosignatures:\n\n"
                       f"{names}\n```\n\n```{{toctree}}\n:hidden:\n\n{tree}\n```\n")
    return pages


def commands() -> str:
    from kalmanq.commands import COMMANDS

    parts = []
    for name, row in COMMANDS.items():
        parts.append(f"## kalmanq {name}\n\n{helped(name)}\n")
    return ("# The command line\n\n`kalmanq COMMAND --help` says the same in a terminal. Commands that read data also take the [options for files of "
            "data](../reference/data_files.md).\n\n" + "\n".join(parts))


def helped(name: str) -> str:
    from kalmanq.command_line import loaded
    from kalmanq.commands import COMMANDS
    from kalmanq.commands.options import LAYOUT

    command, row = loaded(name), COMMANDS[name]
    context = command.make_context(f"kalmanq {name}", [], resilient_parsing=True)
    told = [one.get_help_record(context) for one in command.get_params(context) if one.name not in {*LAYOUT, "help"}]
    cells = [[re.sub(r" *\| *", r" \\| ", cell) for cell in one] for one in told if one]  # a narrow screen breaks the lines there
    lines = [f"| `` {re.sub(r' <(path|list.Path.|str|float)>$', '', option)} `` | {said} |" for option, said in cells]
    return "\n".join([row.help, "", "```text", row.example, *row.more, "```", "", "| option | does |", "|---|---|", *lines])


def main() -> None:
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    pages = {**headers(), **python(), "commands": commands()}
    for name, text in pages.items():
        (out / name).parent.mkdir(exist_ok=True)
        (out / f"{name}.md").write_text(text, encoding="utf-8")
    print(f"made {len(pages)} pages")


if __name__ == "__main__":
    main()
