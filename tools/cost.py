#!/usr/bin/env python3
"""tools/cost.py: what the library costs on seven cores (tools/cost/cli.py; --help says more).

Sets up what is missing first, as tools/setup.sh knows how.
"""

import os
import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parent
SETUP = '. "$0/setup.sh" && kq_setup cost && KQ_COST_READY=1 exec "$KQ_PYTHON" -B "$0/cost.py" "$@"'


def main() -> None:
    if not os.environ.get("KQ_COST_READY"):
        sys.stdout.flush()
        os.execvp("bash", ["bash", "-c", SETUP, str(TOOLS), *sys.argv[1:]])
    sys.path.insert(0, str(TOOLS / "cost"))
    import cli

    cli.app(prog_name="tools/cost.py")


if __name__ == "__main__":
    main()
