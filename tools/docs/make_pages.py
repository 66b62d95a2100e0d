#!/usr/bin/env python3
"""Pages of the site that are made: a page a header, each command's help, and every message with what to do.  make_pages.py OUT"""

import re
import sys
from pathlib import Path

import messages

ROOT = Path(__file__).resolve().parents[2]


def headers() -> str:
    names = sorted(path.name for path in (ROOT / "include" / "kalmanq").glob("*.h"))
    parts = [f"## {name}\n\n```{{doxygenfile}} {name}\n:sections: func define typedef enum\n```\n" for name in names]
    return "# The C headers\n\nEvery name ends in `_f32`, `_f64` or `_q31`; a comment is for all arithmetics.\n\n" + "\n".join(parts)


def commands() -> str:
    from kalmanq.commands import COMMANDS

    parts = []
    for name, row in COMMANDS.items():
        if row.module.startswith("kalmanq."):
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
    lines = [f"| `` {option} `` | {said} |" for option, said in cells]
    return "\n".join([row.help, "", "```text", row.example, "```", "", "| | |", "|---|---|", *lines])


def main() -> None:
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    for name, made in (("headers", headers), ("commands", commands), ("messages", messages.page)):
        (out / f"{name}.md").write_text(made(), encoding="utf-8")
        print(f"made {name}.md")


if __name__ == "__main__":
    main()
