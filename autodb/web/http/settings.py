"""How a service is run."""

import ipaddress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from autodb.files.units import SI
from autodb.store import file_of, on_server

HERE = "127.0.0.1"
PORT = 8321
"""Chosen: free of well-known services (IANA)."""
MIB = 2**20


@dataclass(frozen=True)
class ReaderBounds:
    """What a process may use that reads what was sent, with all that it starts.

    Memory (address space), the time of the clock and of the processor, files open at once, and by
    how much a file may grow, the database's own too. Chosen: a recording of 256 MiB takes a part
    of each.
    """

    memory_MiB: int = 4096
    seconds: int = 600
    files: int = 256
    grows_MiB: int = 2048


@dataclass(frozen=True)
class RequestLimits:
    """How much may be sent to a service, and how often.

    ``recording_MiB``, ``side_MiB``, ``program_MiB``: size of each; ``a_minute``: by one address;
    ``waiting``: recordings that are received, read or wait for it; ``at_once``: what is read while
    who asked waits, and as many more wait for that; ``receive_s``: how long one may take to be
    sent; ``importing``, ``looking``, ``predicting``, ``explaining`` and ``learning``: what a
    process for each may use. All chosen.
    """

    recording_MiB: int = 256
    side_MiB: int = 1
    program_MiB: int = 4
    a_minute: int = 30
    waiting: int = 20
    at_once: int = 2
    receive_s: float = 600.0
    importing: ReaderBounds = ReaderBounds()
    looking: ReaderBounds = ReaderBounds(seconds=300, grows_MiB=64)
    predicting: ReaderBounds = ReaderBounds(memory_MiB=2048, seconds=60, grows_MiB=64)
    explaining: ReaderBounds = ReaderBounds(seconds=300, grows_MiB=64)
    learning: ReaderBounds = ReaderBounds(memory_MiB=8192, seconds=3600)


@dataclass(frozen=True)
class Settings:
    """What a service offers, and to whom.

    ``url``: of the database; ``host`` and ``port``: where it listens; ``writes``: whether anything
    may be changed; ``names``: by which hosts' names it may be asked, none: by any; ``tls``: whether
    it is reached over TLS; ``recordings``: the folder that keeps recordings which were sent, None:
    one beside the database's file; ``proxies``: addresses, or networks, of proxies that are
    believed for whom they ask; ``units``: system of units of its pages, where a browser chose none.
    """

    url: str
    host: str = HERE
    port: int = PORT
    writes: bool = False
    names: tuple[str, ...] = ()
    tls: bool = False
    recordings: Path | None = None
    limits: RequestLimits = RequestLimits()
    proxies: tuple[str, ...] = ()
    units: str = SI

    @property
    def keeps_in(self) -> Path | None:
        """The folder that keeps recordings; None: it was not said, for a database on a server."""
        if self.recordings is not None or on_server(self.url):
            return self.recordings
        return file_of(self.url).absolute().parent / "recordings"

    @cached_property
    def on_loopback(self) -> bool:
        """Whether only programs of this computer reach it."""
        return is_loopback(self.host)

    @property
    def anonymous(self) -> bool:
        """Whether who brings no token may read: only where nobody but this computer's can ask.

        A name or a proxy says that others ask through this computer.
        """
        return self.on_loopback and not self.names and not self.proxies

    @cached_property
    def answers_to(self) -> frozenset[str] | None:
        """Names, in lower case, that a request may call it by; None: any.

        On loopback a page of another site could otherwise ask in the name of its visitor, by a
        name of its own that leads here.
        """
        if self.on_loopback:
            return frozenset({"localhost", "127.0.0.1", "[::1]", *map(str.lower, self.names)})
        return frozenset(map(str.lower, self.names)) if self.names else None


def is_loopback(host: str) -> bool:
    """Return whether an address is reached from this computer only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
