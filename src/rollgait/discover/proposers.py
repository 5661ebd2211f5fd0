"""Who proposes gaits: a new way to find them is one file, and one line here."""

from __future__ import annotations

from typing import Final

from rollgait.discover.candidate import Proposer
from rollgait.discover.greedy import stepping
from rollgait.discover.rolling import rolling
from rollgait.discover.skidding import skidding
from rollgait.discover.walking import walking

PROPOSERS: Final[tuple[Proposer, ...]] = (rolling, skidding, stepping, walking)
"""All of them are asked; what they propose is tried in the order of the scores."""
