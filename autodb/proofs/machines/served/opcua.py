"""A virtual machine behind an OPC UA server: a variable each channel and state."""

import asyncio
import time
from datetime import UTC, datetime, timedelta
from typing import Any

from asyncua import ua
from asyncua.server.server import Server

from autodb.proofs.machines.served.shift import STATE, ServedShift

NAMESPACE = "urn:autodb:virtual"
PIECE_S = 0.05
"""How much of a shift is said at a time."""


class OpcUaServer:
    """A server on loopback; ``history``: it remembers what it said while it runs."""

    def __init__(self, shift: ServedShift, *, port: int, history: bool = False) -> None:
        self._shift, self._port, self._history = shift, port, history
        self._nodes: dict[str, ua.NodeId] = {}
        self._latest: dict[str, ua.DataValue] = {}
        self._changed: dict[str, Any] = {}
        self._server: Server | None = None
        self._row = 0

    @property
    def url(self) -> str:
        """Where it is read."""
        return f"opc.tcp://127.0.0.1:{self._port}/"

    def item(self, name: str) -> str:
        """Return the node id of a channel or state."""
        return f"ns=2;s={name}"

    async def start(self) -> None:
        """Listen, with the values that it had."""
        server = self._server = Server()
        self._changed = {}
        await server.init()
        server.set_endpoint(self.url)
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        space = await server.register_namespace(NAMESPACE)  # 2: the first behind the server's own
        machine = await server.nodes.objects.add_object(space, "Machine")
        for name in [*self._shift.columns, *self._shift.states]:
            number = name in self._shift.columns or isinstance(
                self._shift.states[name][0][1], float
            )
            initial: STATE = 0.0 if number else ""
            node = await machine.add_variable(ua.NodeId.from_string(self.item(name)), name, initial)
            self._nodes[name] = node.nodeid
            said = self._latest.get(name, self._value(initial, self._shift.start_s))
            await server.write_attribute_value(node.nodeid, said)
            if self._history:
                await server.historize_node_data_change(node, timedelta(days=3650))
        await server.start()

    async def stop(self) -> None:
        """Listen no more."""
        if self._server is not None:
            await self._server.stop()
            self._server = None

    @property
    def done(self) -> bool:
        """Whether the shift is over."""
        return self._row >= self._shift.rows

    async def play(self, *, speed: float, upto: int | None = None) -> None:
        """Say the shift, from where it was on, ``speed`` times as fast as it was.

        With a history it has all of that once this ends.
        """
        rows = max(1, round(PIECE_S * self._shift.rate_hz))
        end = self._shift.rows if upto is None else upto
        began, first = time.monotonic(), self._row
        while self._row < end:
            for row in range(self._row, min(self._row + rows, end)):
                await self._say(row)
            self._row = min(self._row + rows, end)
            due = began + (self._row - first) / self._shift.rate_hz / speed
            await asyncio.sleep(max(0.0, due - time.monotonic()))
        while not await self._remembered():
            await asyncio.sleep(PIECE_S)

    async def _remembered(self) -> bool:
        """Say whether the history, which is filled a while behind, has every node's last change."""
        if self._server is None or not self._history:
            return True
        kept = self._server.iserver.history_manager.storage
        for name, last in self._changed.items():
            said, _ = await kept.read_node_history(self._nodes[name], last, None, nb_values=1)
            if not said:
                return False
        return True

    async def _say(self, row: int) -> None:
        shift, instant_s = self._shift, self._shift.instant_s(row)
        said: dict[str, STATE] = {
            name: float(shift.values(name, row, row + 1)[0]) for name in shift.columns
        }
        for name, value in (said | shift.at(row)).items():
            now, before = self._value(value, instant_s), self._latest.get(name)
            if before is not None and now.Value != before.Value:
                self._changed[name] = now.SourceTimestamp
            self._latest[name] = now
            if self._server is not None:
                await self._server.write_attribute_value(self._nodes[name], self._latest[name])

    def _value(self, value: STATE, instant_s: float) -> ua.DataValue:
        stamp: Any = datetime.fromtimestamp(instant_s, UTC)
        return ua.DataValue(ua.Variant(value), SourceTimestamp=stamp, ServerTimestamp=stamp)
