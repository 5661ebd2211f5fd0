#!/bin/sh
# Makes the virtual environment with rollgait, all its extras and the developers' tools: make_venv.sh PYTHON FOLDER
set -eu
python=$1
venv=$2

stop() {
  echo "error: $1" >&2
  exit 1
}

version=$("$python" -c 'import platform; print(platform.python_version())' 2>/dev/null) ||
  stop "$python is not installed; on Debian: apt-get install python3 python3-venv"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
  stop "rollgait needs Python 3.11 or newer, $python is $version; choose another: make PYTHON=python3.12"
"$python" -c 'import venv, ensurepip' 2>/dev/null ||
  stop "$python cannot make virtual environments; on Debian: apt-get install python3-venv"

echo "setting up $venv (once; a minute or two)"
# An interrupted attempt may have left a folder without pip.
"$venv/bin/python" -m pip --version >/dev/null 2>&1 || "$python" -m venv --clear "$venv"
"$venv/bin/python" -m pip install -qq --disable-pip-version-check -e '.[all,dev,docs]'
