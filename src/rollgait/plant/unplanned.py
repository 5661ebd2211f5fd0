"""Contacts that nobody planned."""

from __future__ import annotations

from rollgait.config import Config, Line, NonNegative, Number


class UnplannedContact(Config):
    """Something other than a foot has touched the ground."""

    link: Line
    """The link that did."""
    time: Number
    """When it did first, s."""
    force: NonNegative
    """Largest force on it, N."""
