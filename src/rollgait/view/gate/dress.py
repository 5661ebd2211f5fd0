"""What viser's page gets of ours before it is sent: its title, dark if preferred, room on phones."""

from __future__ import annotations

import gzip
from html import escape
from typing import Final

from websockets.http11 import Response

VISERS_TITLE: Final = b"<title>Viser</title>"
PREFERENCE: Final = (
    "<script>window.__VISER_EMBED_CONFIG__ = "
    '{darkMode: matchMedia("(prefers-color-scheme: dark)").matches};</script>'
)
"""Viser's page reads this when it begins."""
LOOK: Final = """<style>
:root { color-scheme: light dark }
@media (prefers-color-scheme: dark) {
  canvas[data-engine] { background: #c3cad3 }
  [role="tab"][aria-selected="true"], [role="tab"][aria-selected="true"] * { color: #74c0fc !important }
}
@media (max-width: 36em) {
  div[style*="width: 20em"] { width: 100% !important }
  div[style*="width: 20em"][style*="max-height"] { max-height: 50% !important }
}
</style>"""
"""Paths are black, so the sky is never dark; on a phone the controls take the lower half."""


class Dress:
    """Of the pages of one server.

    Args:
        title: of the page.
    """

    def __init__(self, title: str) -> None:
        head = f"<title>{escape(title)}</title>{PREFERENCE}{LOOK}"
        self._head = head.encode()
        self._made: dict[tuple[bool, int], bytes] = {}

    def put_on(self, response: Response) -> None:
        """Changes a response that is the page; others stay as they are."""
        headers = response.headers
        if response.body is None or not headers.get("Content-Type", "").startswith("text/html"):
            return
        packed = headers.get("Content-Encoding") == "gzip"
        key = (packed, len(response.body))
        if key not in self._made:  # the page has megabytes, and is always the same
            body = gzip.decompress(response.body) if packed else bytes(response.body)
            body = body.replace(VISERS_TITLE, self._head, 1)
            self._made[key] = gzip.compress(body, 6) if packed else body
        response.body = self._made[key]
        del headers["Content-Length"]
        headers["Content-Length"] = str(len(response.body))
