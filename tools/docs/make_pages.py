#!/usr/bin/env python3
"""Pages of the site that are made: a page a header, each command's help, and every message with what to do.  make_pages.py OUT"""

import os
import subprocess
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
            parts.append(f"## kalmanq {name}\n\n```text\n{helped(name)}\n```\n")
    return "# The command line\n\n" + "\n".join(parts)


def helped(name: str) -> str:
    environment = {**os.environ, "COLUMNS": "100", "NO_COLOR": "1", "TERM": "dumb"}
    done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", name, "--help"], capture_output=True, text=True, env=environment,
                          check=True)
    return "\n".join(line.rstrip() for line in done.stdout.splitlines()).strip()


def main() -> None:
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    for name, made in (("headers", headers), ("commands", commands), ("messages", messages.page)):
        (out / f"{name}.md").write_text(made(), encoding="utf-8")
        print(f"made {name}.md")


if __name__ == "__main__":
    main()
