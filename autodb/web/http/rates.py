"""How often each address did something lately."""

import threading
import time
from collections import deque

CLIENTS = 10_000
"""Addresses that are remembered; beyond, the oldest is forgotten. Chosen: some megabytes."""


class Rate:
    """Of each address when it did something, so that it may do so ``most`` times in a while."""

    def __init__(self, most: int, within_s: float) -> None:
        self._most, self._within_s = most, within_s
        self._lock = threading.Lock()
        self._when: dict[str, deque[float]] = {}

    def note(self, client: str) -> None:
        """Remember that an address did it now."""
        with self._lock:
            some = self._when.setdefault(client, deque(maxlen=self._most))
            some.append(time.monotonic())
            if len(self._when) > CLIENTS:
                del self._when[next(iter(self._when))]

    def wait_s(self, client: str) -> int:
        """Return how long an address has to wait until it may do it again; 0: it may now."""
        with self._lock:
            some = self._when.get(client)
            if some is None:
                return 0
            now = time.monotonic()
            while some and now - some[0] > self._within_s:
                some.popleft()
            if not some:
                del self._when[client]
            return int(self._within_s - (now - some[0])) + 1 if len(some) == self._most else 0
