#!/bin/sh
# callgrind.sh WORK: q31 beside the Q16.16 filter.  Instructions of one predict and of one update
# (all m components; that of q31 with its likelihood) on this machine at -O2, counted by callgrind:
# exact, and the same at every run.  They are those of the second 200 steps, over 200.  Errors are
# the largest of 2000 steps against a textbook filter in long double: of x in sigma, of P_ij in
# sigma_i sigma_j.  Fails if a number is missing or if an error of q31 is not below the other's.
set -eu
work=$1 steps=200
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
mkdir -p "$work"
command -v valgrind >/dev/null || { echo "valgrind is missing"; exit 1; }

# shellcheck disable=SC2086
${CC:-cc} -std=c11 -O2 -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion -Werror \
    -I"$root/include" "$here"/*.c "$root"/src/*.c -lm -o "$work/cost"

# collected FUNCTION FILTER MODEL STEPS: instructions within the function, all calls together
collected() {
    valgrind -q --tool=callgrind --toggle-collect="$1" --callgrind-out-file="$work/callgrind.out" \
        "$work/cost" run "$2" "$3" "$4" >"$work/callgrind.log" 2>&1 ||
        { cat "$work/callgrind.log" >&2; exit 1; }
    awk '$1 == "summary:" || $1 == "totals:" { count = $2 } END { print count + 0 }' \
        "$work/callgrind.out"
}

# cost_of FUNCTION FILTER MODEL: instructions of one call
cost_of() {
    once=$(collected "$1" "$2" "$3" "$steps")
    twice=$(collected "$1" "$2" "$3" $((2 * steps)))
    echo $(((twice - once) / steps))
}

"$work/cost" accuracy >"$work/accuracy.txt"
while read -r model n m filter x P semidefinite of; do
    case $filter in
    q16) predict=q16_predict update=q16_update ;;
    q31) predict=kq_predict_q31 update=kq_update_q31 ;;
    esac
    echo "$n $m $filter $(cost_of "$predict" "$filter" "$model") $(cost_of "$update" "$filter" "$model")" \
        "$x $P $semidefinite $of"
done <"$work/accuracy.txt" >"$work/cost.txt"

echo " n  m  filter  predict  update  error of x  error of P  P semi-definite"
awk '
    { printf "%2d %2d  %-6s %8d %7d  %10s  %10s  %s\n", $1, $2, $3 == "q16" ? "Q16.16" : "q31",
             $4, $5, $6, $7, $8 == $9 ? "always" : sprintf("not at %d of %d steps", $9 - $8, $9)
      if (NF != 9 || $4 <= 0 || $5 <= 0) bad = "a number is missing"
      if ($3 == "q16") { x = $6; P = $7 }
      else if (!($6 + 0 < x + 0 && $7 + 0 < P + 0)) bad = "q31 is not the more accurate one"
      if ($3 == "q31" && $8 != $9) bad = "a covariance of q31 is not semi-definite" }
    END { if (NR != 6) bad = "a line is missing"
          if (bad) print bad
          exit bad != "" }' "$work/cost.txt"
