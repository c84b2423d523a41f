"""Connections of the service: one that is silent, or whose request has no end, is ended.

Request lines and headers are bounded in bytes, number and time, before anything is answered: the
server itself reads a header line for as long as it goes on, and keeps all of it.
"""

import asyncio
from http import HTTPStatus
from typing import Any

from autodb.web.http.guard import HEADERS
from autodb.web.http.problems import HttpProblem
from autodb.web.http.turns import InTurns

HEAD_S = 10.0
"""How long a request's head may take, from when the connection opens or it begins. Chosen."""
HEAD_BYTES = 16 * 1024
"""Bytes of a request's line and headers, trailers too. Chosen: twice what most servers take."""
HEADERS_MOST = 100
"""Headers of a request, trailers too. Chosen."""
SAID = {
    HTTPStatus.REQUEST_TIMEOUT: (
        f"the request's head took longer than {HEAD_S:g} s; send it at once"
    ),
    HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: (
        f"more than {HEADERS_MOST} headers, or {HEAD_BYTES} bytes of them; send fewer"
    ),
    HTTPStatus.BAD_REQUEST: "this is not a readable HTTP request; use HTTP/1.1",
}


class _TooLarge(Exception):  # noqa: N818 - raised through the parser, which ends there
    """A head that says more than it may."""


class Connection(InTurns):
    """An HTTP connection whose requests have to begin, and their heads to be whole, in time.

    The server answers so many connections at once; held open in silence they would keep others out.
    """

    _late: asyncio.TimerHandle | None = None
    _began = _within = False
    """Whether a part of a head has come, and whether a request has, but not all of it."""
    _bytes = _headers = _unread = 0
    """Of this head; and bytes since the parser last had a whole head, or a piece of a body."""
    _refused = HTTPStatus.BAD_REQUEST
    """What a request that cannot be parsed gets."""

    def connection_made(self, transport: Any) -> None:
        """Wait for the first request."""
        super().connection_made(transport)
        self._wait()

    def take(self, piece: bytes) -> None:
        """Take a piece of what came, and no more of a head than it may be."""
        self._unread += len(piece)
        super().take(piece)
        if self._unread > HEAD_BYTES:
            self._refuse(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE)
        between = not self._within and (self.cycle is None or self.cycle.response_complete)
        if between and self._late is None and not self.transport.is_closing():
            self._wait()  # blank lines came: the server would keep it for ever

    def on_response_complete(self) -> None:
        """Wait for the end of a body that goes on after its answer: else it could for ever."""
        super().on_response_complete()
        of_newest = self._within and not self._began and self.cycle.response_complete
        if of_newest and not self.transport.is_closing():
            self._wait()

    def on_message_begin(self) -> None:
        """Wait for the head of a request."""
        super().on_message_begin()
        self._began, self._within, self._bytes, self._headers = True, True, 0, 0
        self._wait()

    def on_url(self, url: bytes) -> None:
        """Take a piece of the request's line."""
        self._count(len(url))
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        """Take a header, or a trailer."""
        self._headers += 1
        self._count(len(name) + len(value))
        super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """Wait no more: its body is another's to wait for."""
        self._stop_waiting()
        self._began, self._unread = False, 0
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        """Take a piece of a body, which the routes bound."""
        self._unread = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        """Know that the next head may begin."""
        self._within, self._unread = False, 0
        super().on_message_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        self._stop_waiting()
        super().connection_lost(exc)

    def send_400_response(self, msg: str) -> None:  # noqa: ARG002 - the server's words are not ours
        """Refuse what cannot be parsed, or was said to be too large while it was."""
        self._refuse(self._refused)

    def _count(self, size: int) -> None:
        self._bytes += size
        if self._bytes > HEAD_BYTES or self._headers > HEADERS_MOST:
            self._refused = HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE
            raise _TooLarge

    def _refuse(self, status: HTTPStatus) -> None:
        """Answer with one line, but where another answer is on its way, and end the connection."""
        if self.transport.is_closing():
            return
        if self.cycle is None or self.cycle.response_complete:
            body = HttpProblem(detail=SAID[status]).model_dump_json().encode()
            lines = {"Content-Type": "application/json", "Content-Length": str(len(body))}
            lines |= {"Connection": "close", **HEADERS}
            head = [f"HTTP/1.1 {status.value} {status.phrase}"]
            head += [f"{name}: {value}" for name, value in lines.items()]
            self.transport.write("\r\n".join([*head, "", ""]).encode() + body)
        self._stop_waiting()
        self.transport.close()

    def _give_up(self) -> None:
        """End a connection whose time is over: with a word where it began to ask."""
        if self._began:
            self._refuse(HTTPStatus.REQUEST_TIMEOUT)
        else:
            self.transport.close()

    def _wait(self) -> None:
        self._stop_waiting()
        self._late = self.loop.call_later(HEAD_S, self._give_up)

    def _stop_waiting(self) -> None:
        if self._late is not None:
            self._late.cancel()
            self._late = None
