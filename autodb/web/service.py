"""What the routes of one service share."""

import threading
import time
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Annotated

from fastapi import Depends, HTTPException, Request

from autodb.agent.access import Access, Role, access_of
from autodb.agent.shelves import Shelves
from autodb.store import Store
from autodb.store.watched import Watched
from autodb.web.metrics import Metrics
from autodb.web.sessions import HEADER, SAFE, Sessions
from autodb.web.settings import Settings

BEARER = "bearer "
HELD_S = 5.0
"""How long a token that was valid is taken to be so without asking again. Chosen."""
GUESSES, GUESSES_S = 20, 60.0
"""Tokens that are not valid, of one address, within so long: no more are looked at. Chosen."""
CLIENTS = 10_000
"""Addresses whose guesses are remembered. Chosen: some megabytes."""


@dataclass
class Service:
    """A store that is served: its settings, what is kept of it, and its counts."""

    settings: Settings
    store: Store
    watched: Watched
    shelves: Shelves
    metrics: Metrics
    sessions: Sessions = field(default_factory=Sessions)
    _held: dict[str, tuple[float, Access]] = field(default_factory=dict)
    _guessed: dict[str, deque[float]] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def access(self, request: Request, brought: str | None) -> Access:
        """Return who asks; raises HTTPException for a token that is needed, or is not valid.

        ``brought``: the number of a browser's session that came with it.
        """
        header = request.headers.get("authorization")
        if header is not None:
            secret = header[len(BEARER) :].strip()
            return self.by_token(request, secret if header.lower().startswith(BEARER) else "")
        signed_in = self._signed_in(request, brought)
        if signed_in is not None:
            return signed_in
        if self.settings.on_loopback:
            return ANYONE_HERE
        raise HTTPException(401, "a token is needed; 'autodb token add' makes one", CHALLENGE)

    def by_token(self, request: Request, secret: str) -> Access:
        """Return whose token it is; raises HTTPException where it is not valid."""
        client = request.client.host if request.client else ""
        self._refuse_guessing(client)
        found = self._of(secret)
        if found is None:
            self.metrics.refused_tokens.inc()
            self._note_guess(client)
            raise HTTPException(401, "the token is not valid", CHALLENGE)
        return found

    def _signed_in(self, request: Request, brought: str | None) -> Access | None:
        """Return who is signed in with a browser, None: nobody.

        Raises HTTPException where a request that may change something does not bring the
        session's number.
        """
        session = self.sessions.of(request)
        found = None if session is None else self._of(session.token)
        if session is None or found is None:
            return None
        if request.method not in SAFE and not session.brought(brought):
            raise HTTPException(403, "not sent by a page of this service; from one it would work")
        return found

    def _of(self, secret: str) -> Access | None:
        kept = self._held.get(secret)
        if kept is not None and time.monotonic() - kept[0] < HELD_S:
            return kept[1]
        with self.store.reading() as session:
            found = access_of(session, secret)
        with self._lock:
            self._held.pop(secret, None)
            if found is not None:
                self._held[secret] = time.monotonic(), found
        return found

    def _note_guess(self, client: str) -> None:
        with self._lock:
            some = self._guessed.setdefault(client, deque(maxlen=GUESSES))
            some.append(time.monotonic())
            if len(self._guessed) > CLIENTS:
                del self._guessed[next(iter(self._guessed))]

    def _refuse_guessing(self, client: str) -> None:
        """Raise HTTPException where an address had too many tokens that were not valid."""
        with self._lock:
            some = self._guessed.get(client)
            if some is None:
                return
            now = time.monotonic()
            while some and now - some[0] > GUESSES_S:
                some.popleft()
            if not some:
                del self._guessed[client]
            elif len(some) == GUESSES:
                wait_s = int(GUESSES_S - (now - some[0])) + 1
                said = f"{GUESSES} tokens that are not valid; in {wait_s} s it would work"
                raise HTTPException(429, said, {"Retry-After": str(wait_s)})

    def close(self) -> None:
        """Give back the database."""
        self.watched.close()
        self.store.close()


ANYONE_HERE = Access("anyone on this computer", Role.READ, None)
CHALLENGE = {"WWW-Authenticate": "Bearer"}


def service_of(request: Request) -> Service:
    """Return the service that a request came to."""
    found = request.app.state.service
    assert isinstance(found, Service)
    return found


def may(role: Role, *, changes: bool = False) -> Callable[[Request], Awaitable[Access]]:
    """Return what a route depends on that needs a role, and changes something or does not.

    It gives who asks.
    """

    async def asked(request: Request) -> Access:
        return allowed(request, role, request.headers.get(HEADER), changes=changes)

    return asked


def allowed(request: Request, role: Role, brought: str | None, *, changes: bool) -> Access:
    """Return who asks; raises HTTPException where they may not. ``brought`` as of ``access``."""
    service = service_of(request)
    access = service.access(request, brought)
    request.state.who = access.who
    request.state.access = access
    if changes and not service.settings.writes:
        raise HTTPException(403, "served read-only; 'autodb serve --write' would work")
    if access.role < role:
        if access.token_id is None:
            said = f"a token is needed of role {role.word}; 'autodb token add' makes one"
            raise HTTPException(401, said, CHALLENGE)
        raise HTTPException(403, f"'{access.who}' may {access.role.word}, not {role.word}")
    return access


Reads = Annotated[Access, Depends(may(Role.READ))]
Operates = Annotated[Access, Depends(may(Role.OPERATE, changes=True))]
Administers = Annotated[Access, Depends(may(Role.ADMIN))]
