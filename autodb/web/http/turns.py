"""What one connection may take of the service's one loop at a time, whatever it sends.

The server parses all that a read gave, up to 256 KiB, before anybody else has a turn, and queues
every request in it. Of chunks of one byte that is 40 000 calls, of the shortest requests 14 000
that wait, and it goes on reading after each answer. Here what came is taken in pieces: while a
request waits for its answer no further piece, and after a turn's time the connection rests.
"""

import asyncio
import time
from typing import Any

from uvicorn.protocols.http.flow_control import FlowControl
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

PIECE_BYTES = 4096
"""Bytes that are parsed at a time. Chosen: the worst of them, short requests, take some 2 ms."""
TURN_S = 0.001
"""Time of the processor after which a connection rests. Chosen: 256 KiB of a body take 0.4 ms."""
REST_S = 0.05
"""How long it rests. Chosen: a connection takes 2 % of the loop to be parsed, sixteen a third."""


class _Flow(FlowControl):
    """Reads on only where neither the server nor the connection's turn keeps it from that."""

    _resting = False

    def rest(self) -> None:
        """Read nothing until ``go_on``."""
        self._set(self.read_paused, resting=True)

    def go_on(self) -> None:
        """Read on, where the server does not mind."""
        self._set(self.read_paused, resting=False)

    def pause_reading(self) -> None:
        """Read nothing until the server says so."""
        self._set(True, resting=self._resting)

    def resume_reading(self) -> None:
        """Read on, where it does not rest."""
        self._set(False, resting=self._resting)

    def _set(self, paused: bool, *, resting: bool) -> None:
        was, now = self.read_paused or self._resting, paused or resting
        self.read_paused, self._resting = paused, resting
        if now and not was:
            self._transport.pause_reading()
        elif was and not now:
            self._transport.resume_reading()


class InTurns(HttpToolsProtocol):
    """An HTTP connection that is parsed in turns."""

    flow: _Flow
    _next: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Begin with nothing to be parsed."""
        super().connection_made(transport)
        self.flow = _Flow(transport)
        self._rest = bytearray()

    def connection_lost(self, exc: Exception | None) -> None:
        """Parse no more."""
        self._rest.clear()
        self._stop_resting()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take what came, or as much of it as this turn allows."""
        self._rest += data
        if self._next is None:
            self._turn()

    def on_response_complete(self) -> None:
        """Answer the next request that waits; without one, take what has come meanwhile."""
        super().on_response_complete()
        if self._rest and self._next is None and not self.pipeline:
            self._next = self.loop.call_later(0.0, self._turn)

    def take(self, piece: bytes) -> None:
        """Parse a piece."""
        super().data_received(piece)

    def _turn(self) -> None:
        self._stop_resting()
        until_s = time.thread_time() + TURN_S
        while self._rest and not self.pipeline and not self.transport.is_closing():
            piece = bytes(self._rest[:PIECE_BYTES])
            del self._rest[:PIECE_BYTES]
            self.take(piece)
            if self._rest and time.thread_time() > until_s:
                self._next = self.loop.call_later(REST_S, self._turn)
                break
        if self.transport.is_closing():
            self._rest.clear()
            self._stop_resting()
        elif self._rest:
            self.flow.rest()
        else:
            self.flow.go_on()

    def _stop_resting(self) -> None:
        if self._next is not None:
            self._next.cancel()
            self._next = None
