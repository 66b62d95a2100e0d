#!/bin/sh
# gallery.sh TOOLS_PYTHON PEERS_PYTHON FITTED.json: the gallery's models, fitted by the package, and their log-likelihoods
# and smoothed states by statsmodels, in an environment that has it.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
"$1" -B "$here/gallery_fitted.py" "$3"
"$2" -B "$here/gallery_peers.py" "$3"
