#!/bin/sh
# Makes the virtual environment with rollgait and all its extras: make_venv.sh PYTHON FOLDER
set -eu
python=$1
venv=$2

say() {
  echo "$1" >&2
  exit 1
}

command -v "$python" >/dev/null || say "error: $python is not installed; on Debian: apt-get install python3 python3-venv"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
  say "error: rollgait needs Python 3.11 or newer, $python is $("$python" -V 2>&1 | cut -d' ' -f2); choose another: make PYTHON=python3.12"
"$python" -c 'import venv, ensurepip' 2>/dev/null ||
  say "error: $python cannot make virtual environments; on Debian: apt-get install python3-venv"

echo "setting up $venv (once; a minute or two)"
[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check -e '.[all]'
