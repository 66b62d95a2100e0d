#!/bin/sh
# made.sh COMPILER FLAG... -c SOURCE: what CMake launches the wheel's compiler by.  Of the library an object that the tests' build has made is
# copied: by the same compiler with the same flags, but for warnings, and of nothing newer than it.
# KQ_MADE is that build's folder; the file KQ_COMMANDS has what it compiles by.
for source; do :; done
plain() { sed 's/^[^ ]* *//; s/ -W[^ ]*//g; s/ -MD -MT .* -c / -c /'; }
target() { sed 's/.* -o \([^ ]*\) -c .*/\1/'; }
command=$(grep -F -e " -c $source" "${KQ_COMMANDS:-/dev/null}")
if [ "$(echo "$command" | plain)" = "$(echo "$*" | plain)" ] && [ "$(readlink -f "${command%% *}")" = "$(readlink -f "$1")" ]; then
    made=$KQ_MADE/$(echo "$command" | target) mine=$(echo "$*" | target)
    # shellcheck disable=SC2046
    $(echo "$*" | sed 's/ -MD / -M /; s/ -o [^ ]* -c / /') || exit # it writes what the object depends on
    # shellcheck disable=SC2046
    [ -n "$(find $(sed 's/^[^:]*://; s/\\$//' "$mine.d") -newer "$made")" ] || { cp "$made" "$mine" && exit; }
fi
exec "$@"
