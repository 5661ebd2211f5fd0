"""Foxglove's WebSocket as a transport: the same messages, live, for Foxglove and any client of its protocol.

Commands are taken only where that was asked for: the server does not tell one page from another, and any page
in a browser on this machine can reach the loopback.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Iterable
from typing import Any, Final

from rollgait.errors import InputError, MissingExtraError
from rollgait.hardware.topics import OUTPUTS, encoded, types
from rollgait.hardware.transports.transport import Receive
from rollgait.ros.topics import Topic

EXTRA: Final = "foxglove"
"""The optional extra that brings foxglove-sdk."""
PORT: Final = 8765
"""That Foxglove looks at first."""
HOST: Final = "127.0.0.1"
WAITING_MAX: Final = 1000
"""Messages of clients that wait to be looked at; older ones go."""


def need_foxglove() -> None:
    """Raises `MissingExtraError` if foxglove-sdk or the message types are not installed."""
    types()
    try:
        import foxglove  # noqa: F401
    except ImportError:
        raise MissingExtraError("Foxglove's WebSocket", EXTRA) from None


class FoxgloveTransport:
    """A server for Foxglove.

    Args:
        port: to listen on; 0 takes a free one.
        host: address to listen on; beyond the loopback anybody on the network can read along.
        commands: whether clients may publish to who subscribes here.
        topics: that will be published. The server tells its clients of a channel a moment before it takes
            subscriptions to it, and refuses those that come in between for good: so the channels are there
            before it listens. That of another topic is made with its first message.

    Attributes:
        port: that it listens on.

    Raises:
        MissingExtraError: foxglove-sdk or the message types are not installed.
        InputError: the port is in use.
    """

    def __init__(
        self,
        port: int = PORT,
        host: str = HOST,
        *,
        commands: bool = False,
        topics: Iterable[Topic] = OUTPUTS,
    ) -> None:
        need_foxglove()
        import foxglove
        from foxglove.websocket import Capability

        self._context = foxglove.Context()
        self._channels: dict[Topic, Any] = {topic: self._channel(topic) for topic in topics}
        self._inbox = _Inbox()
        try:
            self._server = foxglove.start_server(
                name="rollgait",
                host=host,
                port=port,
                capabilities=[Capability.ClientPublish] if commands else None,
                supported_encodings=["cdr", "json"] if commands else None,
                server_listener=self._inbox,  # type: ignore[arg-type]
                context=self._context,
            )
        except RuntimeError as error:
            raise InputError("foxglove-port", port, f"cannot be listened on: {error}") from None
        self.port = int(self._server.port)

    def publish(self, topic: Topic, data: bytes) -> None:
        """Sends a message, as CDR, to all who have subscribed."""
        if topic not in self._channels:
            self._channels[topic] = self._channel(topic)
        self._channels[topic].log(data)

    def _channel(self, topic: Topic) -> Any:
        import foxglove

        from rollgait.ros.cdr import definition

        schema = foxglove.Schema(
            name=topic.type, encoding="ros2msg", data=definition(topic.type).encode("utf-8")
        )
        return foxglove.Channel(topic.name, schema=schema, message_encoding="cdr", context=self._context)

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """From now on hands what clients publish on a topic to `receive`."""
        self._inbox.readers.setdefault(topic.name, []).append((topic, receive))

    def receive(self, seconds: float) -> None:
        """Hands on what clients have published; waits for the first, so long at most."""
        for receive, data in self._inbox.take(seconds):
            receive(data)

    def close(self) -> None:
        """Ends the server."""
        for channel in self._channels.values():
            channel.close()
        self._channels.clear()
        self._server.stop()


class _Inbox:
    """What clients publish, from the server's threads to the one that asks."""

    def __init__(self) -> None:
        self.readers: dict[str, list[tuple[Topic, Receive]]] = {}
        self._channels: dict[tuple[int, int], tuple[str, str]] = {}
        self._waiting: deque[tuple[str, str, bytes]] = deque(maxlen=WAITING_MAX)
        self._came = threading.Event()

    def take(self, seconds: float) -> list[tuple[Receive, bytes]]:
        """What has come, with who reads it."""
        if not self._waiting and seconds > 0.0:
            self._came.wait(seconds)
        self._came.clear()
        found = []
        while self._waiting:
            name, encoding, data = self._waiting.popleft()
            for topic, receive in self.readers.get(name, ()):
                if (message := _as_cdr(topic, encoding, data)) is not None:
                    found.append((receive, message))
        return found

    # -- what foxglove-sdk calls --

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        """A client says what it will publish."""
        self._channels[client.id, channel.id] = channel.topic, channel.encoding

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        """It will no longer."""
        self._channels.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        """It does."""
        known = self._channels.get((client.id, client_channel_id))
        if known is not None:
            self._waiting.append((*known, bytes(data)))
            self._came.set()

    def on_subscribe(self, client: Any, channel: Any) -> None:
        """Somebody reads along."""

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        """Or no longer."""


def _as_cdr(topic: Topic, encoding: str, data: bytes) -> bytes | None:
    """A message of a client as CDR; None if it is none."""
    if encoding == "cdr":
        return data
    try:
        fields = json.loads(data)
        return encoded(topic, fields) if isinstance(fields, dict) else None
    except Exception:  # of bytes from anywhere
        return None
