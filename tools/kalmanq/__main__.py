"""The command kalmanq, from its first import on: an interrupt is no traceback."""

import sys

INTERRUPTED = 130


def main() -> None:
    try:
        from kalmanq.command_line import main as command
    except KeyboardInterrupt:
        print("kalmanq: interrupted", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None
    command()


if __name__ == "__main__":
    main()
