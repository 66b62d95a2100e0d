#!/bin/sh
# The long run of the campaign on both cores: long.sh PROGRAM [models [seed]].  PROGRAM is the
# build's tests/campaign/campaign.  The findings of both halves, then the counts of each.
set -eu
program=$1
models=${2:-2000}
seed=${3:-1}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Two halves: models 0 .. half - 1, and the rest.
half=$((models / 2))
"$program" "$half" "$seed" > "$work/first" &
first=$!
failed=0
"$program" $((models - half)) "$seed" "$half" > "$work/second" || failed=1
wait "$first" || failed=1
cat "$work/first" "$work/second"
exit $failed
