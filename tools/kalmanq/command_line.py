"""kalmanq: design, test and run Kalman filters for microcontrollers."""

from __future__ import annotations

import signal
import sys
from importlib import import_module, metadata
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from kalmanq.commands import COMMANDS, GONE, Row, commands
from kalmanq.commands.messages import INTERRUPTED, told_in_one_line
from kalmanq.errors import KalmanqError

TERMINATED = 143
HELP = {"help_option_names": ["-h", "--help"]}


class Later(TyperCommand):
    """A command whose module is imported when it is called: what `kalmanq --help` shows needs none."""

    def make_context(self, info_name: Any, args: Any, parent: Any = None, **extra: Any) -> Any:
        with told_in_one_line():
            refuse_gone(str(self.name), args)
            command = loaded(str(self.name))
        return command.make_context(info_name, args, parent=parent, **extra)


class Commands(TyperGroup):
    def __init__(self, **given: Any):
        super().__init__(**{**given, "commands": {name: Later(name, help=row.help) for name, row in commands().items()}})


app = typer.Typer(cls=Commands, help=__doc__, no_args_is_help=True, pretty_exceptions_enable=False, context_settings=HELP,
                  epilog=f"Example: {COMMANDS['run'].example}")


def _tell_version(is_asked: bool) -> None:
    if is_asked:
        from kalmanq.core import lib  # here, as other options need none of it
        library = f"C library {lib.KQ_VERSION_MAJOR}.{lib.KQ_VERSION_MINOR}.{lib.KQ_VERSION_PATCH}"
        try:
            print(f"kalmanq {metadata.version('kalmanq')}, {library}")
        except metadata.PackageNotFoundError:
            print(f"kalmanq, not installed: from the source in {Path(__file__).resolve().parents[1]}, {library}")
        raise typer.Exit


@app.callback()
def _options(_version: bool = typer.Option(False, "--version", callback=_tell_version, is_eager=True, help="Show the version and exit.")) -> None:
    """typer wants a function where it does not know of the commands"""


def refuse_gone(name: str, words: list[str]) -> None:
    for option in (word.split("=")[0] for word in words):
        if why := GONE.get(name, {}).get(option):
            raise KalmanqError(f"{option} is gone since 2.0: {why}")


def loaded(name: str) -> Any:
    row = commands()[name]
    command = import_module(row.module).command
    alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    alone.command(name, help=row.help, epilog=_examples(row), context_settings=HELP)(command)
    return typer.main.get_command(alone)


def _examples(row: Row) -> str:
    """A line each: what is between two empty lines"""
    return "\n\n".join(["Examples:", row.example, *row.more]) if row.more else f"Example: {row.example}"


_heard: list[int] = []


def _terminate(number: int, _: object) -> None:
    """As an interrupt, which leaves nothing behind"""
    _heard.append(number)
    signal.raise_signal(signal.SIGINT)


def main() -> None:
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # it is ignored in the background of a script
        signal.signal(signal.SIGTERM, _terminate)
    try:
        with told_in_one_line():
            try:
                app(prog_name="kalmanq")
            finally:
                sys.stdout.flush()
    except SystemExit as ended:
        raise SystemExit(TERMINATED if _heard and ended.code == INTERRUPTED else ended.code) from None


if __name__ == "__main__":
    main()
