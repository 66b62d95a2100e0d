#!/usr/bin/env bash
# tools/cost/renew.sh [table | boards]: measures committed costs anew, the table or those of the boards, and writes them:
#   table    tools/cost.csv, and what README.md and tools/cost/README.md show of it
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

renew_boards() {
    "$root/tools/test.sh" tools.wheel
    "$KQ_PYTHON" -B "$root/tools/examples/boards/boards.py" costs --write --kalmanq "$root/build/test/tools/tests/clean/bin/python -m kalmanq"
}

case ${1:-table} in
boards) renew_boards ;;
table) renew_table ;;
*) sed -n '2,4s/^# \{0,1\}//p' "$0" && exit 2 ;;
esac
