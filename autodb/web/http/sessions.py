"""Who is signed in with a browser: a cookie stands for a token, which is checked each time.

A cookie comes with every request that a browser sends here, also with one that a page of another
site had it send. So whatever changes something has to bring the session's own number besides,
which only our pages know.
"""

import hashlib
import secrets
import threading
import time
from collections import OrderedDict
from dataclasses import dataclass

from fastapi import Request, Response

COOKIE = "autodb_session"
LASTS_S = 12 * 3600
"""How long a session lasts. Chosen: a shift and its handing over."""
MOST = 1000
"""Sessions that are kept; beyond, the oldest ends. Chosen."""
HEADER, FIELD = "x-csrf-token", "csrf"
SAFE = ("GET", "HEAD", "OPTIONS")


@dataclass(frozen=True)
class Session:
    """A browser's session: the token that it stands for, its own number, and when it ends."""

    token: str
    csrf: str
    ends_s: float

    def brought(self, number: str | None) -> bool:
        """Return whether a number that came with a request is the session's own."""
        return number is not None and secrets.compare_digest(self.csrf, number)


class Sessions:
    """Sessions by their cookies, of which only hashes are kept; all end with the service."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: OrderedDict[str, Session] = OrderedDict()

    def begin(self, response: Response, token: str, *, tls: bool) -> None:
        """Sign a browser in: its cookie goes with the response."""
        value = secrets.token_urlsafe(32)
        made = Session(token, secrets.token_urlsafe(32), time.monotonic() + LASTS_S)
        with self._lock:
            self._kept[_hash(value)] = made
            if len(self._kept) > MOST:
                self._kept.popitem(last=False)
        response.set_cookie(
            COOKIE, value, max_age=LASTS_S, httponly=True, samesite="strict", secure=tls
        )

    def of(self, request: Request) -> Session | None:
        """Return the session whose cookie a request brings."""
        value = request.cookies.get(COOKIE)
        if value is None:
            return None
        with self._lock:
            found = self._kept.get(_hash(value))
            if found is not None and found.ends_s < time.monotonic():
                del self._kept[_hash(value)]
                return None
        return found

    def end(self, request: Request, response: Response) -> None:
        """Sign a browser out."""
        value = request.cookies.get(COOKIE)
        if value is not None:
            with self._lock:
                self._kept.pop(_hash(value), None)
        response.delete_cookie(COOKIE, httponly=True, samesite="strict")


def _hash(value: str) -> str:
    return hashlib.sha256(value.encode()).hexdigest()
