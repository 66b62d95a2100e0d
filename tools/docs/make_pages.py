#!/usr/bin/env python3
"""Pages of the site that are made: a page a header, each command's help, and every message with what to do.  make_pages.py OUT"""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "tools" / "kalmanq"
PARTS = {"model": "Models and model files", "data": "Files of data", "run": "Filters and runs", "fitting": "Fitting", "nonlinear": "Nonlinear models",
         "formulas": "Formulas of nonlinear models", "compiler": "compile", "firmware": "design", "commands": "Options of commands",
         "pages": "Pictures and pages", "core": "The C core"}
RAISES = re.compile(r"Error$|^stop$|\.error$")


def headers() -> str:
    names = sorted(path.name for path in (ROOT / "include" / "kalmanq").glob("*.h"))
    parts = [f"## {name}\n\n```{{doxygenfile}} {name}\n:sections: func define typedef enum\n```\n" for name in names]
    return "# The C headers\n\nEvery name ends in `_f32`, `_f64` or `_q31`; a comment is for all arithmetics.\n\n" + "\n".join(parts)


def commands() -> str:
    from kalmanq.commands import COMMANDS

    parts = []
    for name, (place, _) in COMMANDS.items():
        if place.startswith("kalmanq."):
            parts.append(f"## kalmanq {name}\n\n```text\n{helped(name)}\n```\n")
    return "# The command line\n\n" + "\n".join(parts)


def helped(name: str) -> str:
    environment = {**os.environ, "COLUMNS": "100", "NO_COLOR": "1", "TERM": "dumb"}
    done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", name, "--help"], capture_output=True, text=True, env=environment,
                          check=True)
    return "\n".join(line.rstrip() for line in done.stdout.splitlines()).strip()


def messages() -> str:
    by_part: dict[str, set[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        part = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        for one in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(one, ast.Call) and RAISES.search(called(one.func)):
                by_part.setdefault(PARTS.get(part, "Others"), set()).update(filter(None, map(template, one.args)))
    parts = [f"## {title}\n\n" + "\n".join(f"- `` {text} ``" for text in sorted(found)) + "\n" for title, found in by_part.items() if found]
    return ("# Messages\n\nEvery message of the host tools, with names in braces for what it names. A message says what is wrong, where, and "
            "after the colon what to do.\n\n" + "\n".join(parts))


def called(function: ast.expr) -> str:
    return f".{function.attr}" if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def template(given: ast.expr) -> str:
    """A text of several words, with {name} for what is put in"""
    if isinstance(given, ast.Constant) and isinstance(given.value, str):
        text = given.value
    elif isinstance(given, ast.JoinedStr):
        text = "".join(part.value if isinstance(part, ast.Constant) else f"{{{ast.unparse(part.value)[:30]}}}" for part in given.values)  # type: ignore
    else:
        return ""
    return " ".join(text.replace("`", "'").split()) if len(text.split()) > 3 else ""


def main() -> None:
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    for name, made in (("headers", headers), ("commands", commands), ("messages", messages)):
        (out / f"{name}.md").write_text(made(), encoding="utf-8")
        print(f"made {name}.md")


if __name__ == "__main__":
    main()
