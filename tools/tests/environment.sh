# environment PYTHON FOLDER: a virtual environment with the dependencies of PYTHON; sets `packages` to where its own are
environment() {
    "$1" -m venv --without-pip "$2"
    packages=$("$2/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    "$1" -c 'import sysconfig; print(sysconfig.get_path("purelib"))' >"$packages/dependencies.pth"
}
