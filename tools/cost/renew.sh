#!/usr/bin/env bash
# tools/cost/renew.sh [table | designs | boards]: measures committed costs anew, the first two or one of them, and writes them:
#   table    tools/cost.csv, and what README.md and tools/cost/README.md show of it
#   designs  tools/kalmanq/firmware/costs.csv and stacks.csv, which kalmanq design estimates with; after the table, since the
#            stacks need it
#   boards   the tables of tools/examples/boards (5 minutes)
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
# shellcheck source=tools/setup.sh
. "$root/tools/setup.sh"
kq_setup cost

renew_table() {
    "$KQ_PYTHON" -B "$root/tools/cost.py"
    "$KQ_PYTHON" -B "$root/tools/cost.py" --readme
}

# designs are written and fitted where the package is installed, and measured where the emulators are
renew_designs() {
    local work tools_python=$root/build/test/tools/tests/clean/bin/python
    "$root/tools/test.sh" tools.wheel
    work=$(mktemp -d)
    trap "rm -rf '$work'" EXIT
    PYTHONPATH=$root/tools/cost "$tools_python" -B "$root/tools/cost/design_models.py" "$work/designs"
    "$KQ_PYTHON" -B "$root/tools/cost/designs.py" "$work/designs" --csv "$work/measured.csv"
    PYTHONPATH=$root/tools/cost "$tools_python" -B "$root/tools/cost/design_fit.py" "$work/measured.csv" \
        "$(dirname "$(find "$root/tools/kalmanq" -name stacks.csv)")"
}

renew_boards() {
    "$root/tools/test.sh" tools.wheel
    "$KQ_PYTHON" -B "$root/tools/examples/boards/boards.py" costs --write --kalmanq "$root/build/test/tools/tests/clean/bin/python -m kalmanq"
}

case ${1:-all} in
boards) renew_boards ;;
table) renew_table ;;
designs) renew_designs ;;
all) renew_table && renew_designs ;;
*) sed -n '2,6s/^# \{0,1\}//p' "$0" && exit 2 ;;
esac
