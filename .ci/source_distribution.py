"""Fails if a source distribution lacks what the repository holds: source_distribution.py ARCHIVE."""

import subprocess
import sys
import tarfile

KEPT = (
    "benchmarks/",
    "docs/",
    "examples/",
    "src/",
    "tests/",
    "tools/",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "LICENSE",
    "Makefile",
    "NOTICE",
    "PACKAGE.md",
    "README.md",
    "SECURITY.md",
    "pyproject.toml",
)

with tarfile.open(sys.argv[1]) as archive:
    held = {name.partition("/")[2] for name in archive.getnames()}
listed = subprocess.run(["git", "ls-files"], capture_output=True, text=True, check=True).stdout.splitlines()
missing = sorted(name for name in listed if name.startswith(KEPT) and name not in held)
absent = sorted(name for name in KEPT if not any(found.startswith(name) for found in held))
if missing or absent:
    sys.exit(f"error: the source distribution lacks {', '.join([*absent, *missing])}")
