"""How a service is run."""

import ipaddress
from dataclasses import dataclass

HERE = "127.0.0.1"
PORT = 8321
"""Chosen: free of well-known services (IANA)."""
MIB = 2**20


@dataclass(frozen=True)
class Settings:
    """What a service offers, and to whom.

    ``url``: of the database; ``host`` and ``port``: where it listens; ``writes``: whether anything
    may be changed; ``names``: by which hosts' names it may be asked, none: by any; ``tls``: whether
    it is reached over TLS.
    """

    url: str
    host: str = HERE
    port: int = PORT
    writes: bool = False
    names: tuple[str, ...] = ()
    tls: bool = False

    @property
    def on_loopback(self) -> bool:
        """Whether only programs of this computer reach it."""
        return is_loopback(self.host)

    @property
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
