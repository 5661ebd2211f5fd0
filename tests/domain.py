"""A domain of DDS for each process that tests, and for those that it starts: no other is heard there."""

from __future__ import annotations

import os
import zlib

USUAL = 100
"""Domains that every machine has ports for."""

_RUN = os.environ.setdefault("PYTEST_XDIST_TESTRUNUID", str(os.getpid()))  # a child has that of its parent
_WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))

DOMAIN = 1 + (zlib.crc32(_RUN.encode()) + _WORKER) % USUAL
