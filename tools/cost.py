#!/usr/bin/env python3
"""tools/cost.py: what the library costs on seven cores (--help says more).

Installs what is missing, as tools/setup.sh knows how; the rest is in tools/cost.
"""

import os
import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parent
SETUP = '. "$0/setup.sh" && kq_setup cost && KQ_COST_READY=1 exec "$KQ_PYTHON" "$0/cost.py" "$@"'


def main() -> None:
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(TOOLS / "cost"))
    try:
        import command_line
    except ModuleNotFoundError as problem:
        if os.environ.get("KQ_COST_READY"):
            sys.exit(f"cost: {problem}, for {sys.executable}")
        os.execvp("bash", ["bash", "-c", SETUP, str(TOOLS), *sys.argv[1:]])
    command_line.app(prog_name="tools/cost.py")


if __name__ == "__main__":
    main()
