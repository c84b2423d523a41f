"""A machine to try an agent on: `python -m autodb.proofs.machines.served PROTOCOL [MACHINE]`.

PROTOCOL: mtconnect, a lathe that turns bars, or opcua, a mill. It writes agent.toml into the
working folder, for the machine of that name [lathe-1], and cuts until Ctrl-C.
"""

import asyncio
import contextlib
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from autodb.proofs.machines.served.example import agent_text
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from autodb.proofs.machines.served.opcua import OpcUaServer
from autodb.proofs.machines.served.shift import lathe_shift, mill_shift

AGENT_FILE = Path("agent.toml")
PORTS = {"mtconnect": 5000, "opcua": 4840}
TIMES = 10_000


async def _served(protocol: str, machine: str) -> None:
    server: MtConnectServer | OpcUaServer
    item: Callable[[str], str] = str
    if protocol == "mtconnect":
        shift = replace(lathe_shift(4, 1), times=TIMES)
        server = MtConnectServer(shift, port=PORTS[protocol])
    else:
        shift = replace(mill_shift(3, 1), times=TIMES)
        server = OpcUaServer(shift, port=PORTS[protocol])
        item = server.item
    try:
        await server.start()
    except OSError as error:
        sys.exit(f"port {PORTS[protocol]}: {error.strerror}")
    text = agent_text(shift, machine=machine, protocol=protocol, url=server.url, item=item)
    AGENT_FILE.write_text(text, encoding="utf-8")
    print(f"{server.url}: {machine} cuts until Ctrl-C; {AGENT_FILE} reads it", flush=True)
    await server.play(speed=1.0)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1] not in PORTS:
        sys.exit("usage: python -m autodb.proofs.machines.served mtconnect|opcua [MACHINE]")
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_served(sys.argv[1], (sys.argv[2:] or ["lathe-1"])[0]))
