"""The command kalmanq, from its first import on: an interrupt is no traceback."""

import sys

REFUSED, INTERRUPTED = 1, 130
COMMAND_LINE = ("click", "rich", "typer")  # the extra that it needs


def main() -> None:
    try:
        from kalmanq.command_line import main as command
    except KeyboardInterrupt:
        print("kalmanq: interrupted", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None
    except ModuleNotFoundError as problem:
        missing = str(problem.name).split(".")[0]
        if missing not in COMMAND_LINE:
            raise
        print(f"kalmanq: the command line needs {missing}, which is not installed: pip install 'kalmanq[cli]', or "
              "'./tools[cli]' in the project's folder", file=sys.stderr)
        raise SystemExit(REFUSED) from None
    command()


if __name__ == "__main__":
    main()
