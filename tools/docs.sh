#!/usr/bin/env bash
# tools/docs.sh [OUT]: the documentation site, in build/docs/html or OUT.  Installs what is missing; nothing is asked of the network
# when all is there.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=tools/setup.sh
. "$root/tools/setup.sh"
kq_setup_many build tools
command -v doxygen >/dev/null || kq_install doxygen
site=$root/.deps/docs
[ -d "$site/sphinx_design" ] || {
    echo "== installing Sphinx"
    "$KQ_TOOLS_PYTHON" -m pip install -q --disable-pip-version-check --target "$site" sphinx myst-parser breathe furo sphinx-design sphinx-copybutton
}
out=${1:-$root/build/docs/html}
cd "$root"
[ -n "$(find tools/kalmanq -maxdepth 1 -name '_core*.so' -newer src/kq_filter_f32.c)" ] || {
    echo "== building the C core for Python"
    cmake -S tools -B build/core -G Ninja -DCMAKE_BUILD_TYPE=Release -DPython_EXECUTABLE="$KQ_TOOLS_PYTHON" >build/docs.log
    ninja -C build/core _core >>build/docs.log
    find build/core -name '_core*.so' -exec cp {} tools/kalmanq/ \;
}
mkdir -p build/docs
echo "== the headers, by Doxygen"
(
    printf '%s\n' 'PROJECT_NAME = kalmanq' 'INPUT = include/kalmanq' 'OUTPUT_DIRECTORY = build/docs/doxygen' 'GENERATE_HTML = NO' \
        'GENERATE_LATEX = NO' 'GENERATE_XML = YES' 'OPTIMIZE_OUTPUT_FOR_C = YES' 'EXTRACT_ALL = YES' 'MACRO_EXPANSION = YES' \
        'EXPAND_ONLY_PREDEF = YES' 'PREDEFINED = KQ_NODISCARD=' 'EXCLUDE_SYMBOLS = KQ_PRIVATE_*' 'QUIET = YES' 'MARKDOWN_SUPPORT = NO' 'INPUT_FILTER = "python3 tools/docs/for_doxygen.py"' 'WARN_IF_UNDOCUMENTED = NO'
) | doxygen - 2>build/docs/doxygen.log
if [ -s build/docs/doxygen.log ]; then cat build/docs/doxygen.log >&2 && exit 1; fi
PYTHONPATH=$site:tools "$KQ_TOOLS_PYTHON" -B tools/docs/make_pages.py tools/docs/made
trap 'rm -rf "$root/tools/docs/made"' EXIT
echo "== the site, by Sphinx"
PYTHONPATH=$site:tools "$KQ_TOOLS_PYTHON" -B -m sphinx -q -j auto -W --keep-going -c tools/docs -d build/docs/doctrees . "$out"
echo "done: $(find "$out" -name '*.html' | wc -l) pages, $out/index.html"
