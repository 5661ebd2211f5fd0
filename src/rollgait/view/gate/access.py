"""Who may talk to a page: browsers that show this very page, under an address that is its own.

A page of any other site can send requests to this machine: its `Origin` gives it away. A site whose name was
made to point at this machine (DNS rebinding) is given away by `Host`. Beyond this machine a token decides.
"""

from __future__ import annotations

import ipaddress
import re
import secrets
import socket
from dataclasses import dataclass
from typing import Final
from urllib.parse import parse_qsl, urlsplit

from websockets.http11 import Request

LOOPBACK: Final = "127.0.0.1"
LOOPBACK_NAMES: Final = frozenset({"localhost", LOOPBACK, "::1"})
ANY_ADDRESS: Final = frozenset({"0.0.0.0", "::"})
"""What a server listens on to be reached under all addresses of its machine."""
HTTP_PORT: Final = 80
"""Of an address that names none."""
TOKEN_NAME: Final = "token"
TOKEN_BYTES: Final = 16
"""128 bits: nobody guesses them."""
_AUTHORITY: Final = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9_.-]+)(?::([0-9]{1,5}))?")


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches what listens on this address."""
    number = _number(host)
    return host.lower() in LOOPBACK_NAMES if number is None else number.is_loopback


def authority(host: str, port: int) -> str:
    """Host and port as they stand in an address: IPv6 in brackets."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


@dataclass(frozen=True)
class Site:
    """The addresses of one server.

    Attributes:
        host: that it listens on.
        port: that it listens on.
    """

    host: str
    port: int

    def owns(self, text: str) -> bool:
        """Whether a host with a port, as in the header `Host`, is an address of this server.

        Where the server listens on all addresses, any number is: only names can be made to point elsewhere.
        """
        match = _AUTHORITY.fullmatch(text.lower())
        if match is None or int(match[2] or HTTP_PORT) != self.port:
            return False
        name = match[1].strip("[]")
        number = _number(name)
        if name in LOOPBACK_NAMES or (number or name) == (_number(self.host) or self.host.lower()):
            return True
        return self.host in ANY_ADDRESS and (number is not None or name in _names_of_this_machine())

    def owns_origin(self, origin: str) -> bool:
        """Whether pages of this origin come from this server."""
        scheme, _, rest = origin.partition("://")
        return scheme.lower() == "http" and self.owns(rest)


class Access:
    """Decides about requests.

    Args:
        site: the server that is asked.
        page: the server of the pages that may ask; the same one if not given.

    Attributes:
        token: what a request must know; None where only this machine can ask.
    """

    def __init__(self, site: Site, page: Site | None = None) -> None:
        self.site, self._page = site, page or site
        self.token = None if is_loopback(site.host) else secrets.token_urlsafe(TOKEN_BYTES)

    @property
    def url(self) -> str:
        """The address that lets a browser in."""
        host = socket.gethostname() if self.site.host in ANY_ADDRESS else self.site.host
        query = "" if self.token is None else f"/?{TOKEN_NAME}={self.token}"
        return f"http://{authority(host, self.site.port)}{query}"

    @property
    def cookie(self) -> str | None:
        """What a browser that was let in shows from then on, as the header `Set-Cookie`."""
        if self.token is None:
            return None
        return f"{self._cookie_name}={self.token}; Path=/; HttpOnly; SameSite=Strict"

    def refusal(self, request: Request) -> str | None:
        """Why a request is refused; None if it is not."""
        hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
        if len(hosts) != 1 or not self.site.owns(hosts[0]):
            return f"the host {_shown(hosts)} is not this page's"
        # a browser says where a WebSocket comes from always, where a file is asked for only to other sites
        from_here = all(map(self._page.owns_origin, origins))
        if not from_here or (request.headers.get_all("Upgrade") and len(origins) != 1):
            return f"the origin {_shown(origins)} is not this page's"
        query = _query(request)
        if query is None or any(name != TOKEN_NAME for name, _ in query):
            # viser's page would connect to any server that the query names, and run what that one says
            return f"the query {_shown([request.path])} is none of this page's"
        shown = [value for _, value in query] + self._cookies(request)
        if self.token is not None and not _among(self.token, shown):
            return "it does not show the token of the printed address"
        return None

    @property
    def _cookie_name(self) -> str:
        return f"rollgait-{self.site.port}"  # cookies are shared by all ports of a host

    def _cookies(self, request: Request) -> list[str]:
        parts = ";".join(request.headers.get_all("Cookie")).split(";")
        pairs = (part.strip().partition("=") for part in parts)
        return [value for name, _, value in pairs if name == self._cookie_name]


def _among(token: str, shown: list[str]) -> bool:
    """Whether the token is shown, in a time that says nothing about it."""
    return any(secrets.compare_digest(token.encode(), text.encode("utf-8", "replace")) for text in shown)


def _query(request: Request) -> list[tuple[str, str]] | None:
    try:
        return parse_qsl(urlsplit(request.path).query, keep_blank_values=True)
    except ValueError:
        return None


def _shown(values: list[str]) -> str:
    text = repr(", ".join(values))
    return text if len(text) <= 80 else f"{text[:79]}…"


def _number(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(name)
    except ValueError:
        return None


def _names_of_this_machine() -> set[str]:
    name = socket.gethostname().lower()
    return {name, f"{name}.local"}
