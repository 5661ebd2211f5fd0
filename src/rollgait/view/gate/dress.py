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
NOTHING_LOST: Final = r"""<script>(() => {
const later = window.setTimeout.bind(window), held = new Map();
const holds = /^\(\)=>\{\w+=null,\w+=!0,\w+&&(\w+)&&\w+\(\1\)\}$/;
window.setTimeout = (act, ms, ...more) => {
  if (ms !== 50 || !holds.test(String(act))) return later(act, ms, ...more);
  const id = later(() => { held.delete(id); act(); }, ms);
  held.set(id, act);
  return id;
};
const release = () => {
  while (held.size) for (const [id, act] of [...held]) { held.delete(id); clearTimeout(id); act(); }
};
for (const turn of ["pointerdown", "focusin"]) window.addEventListener(turn, release, true);
})();</script>"""
"""Viser's page holds back what is set within 50 ms of what was set before, so that a slider says not too
much while it is dragged. But it has one place for all controls: what is set in another one takes it. A slow
page, which takes all keys that came while it drew in such a time, shows numbers that it never sends. Here
what is held back goes as soon as a person turns to something else. Where viser's code is another one,
nothing is changed."""
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
        head = f"<title>{escape(title)}</title>{PREFERENCE}{NOTHING_LOST}{LOOK}"
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
