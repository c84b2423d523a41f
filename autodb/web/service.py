"""What the routes of one service share."""

import threading
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Any

from anyio import CapacityLimiter, to_thread
from fastapi import Depends, HTTPException, Request

from autodb.agent.operate.access import Access, Role, access_of, is_token
from autodb.agent.rows.machines import owner_named
from autodb.store import Store
from autodb.store.watched import Watched
from autodb.web.http.guard import Rate
from autodb.web.http.logs import Metrics
from autodb.web.http.sessions import HEADER, SAFE, Sessions
from autodb.web.http.settings import ReaderBounds, Settings
from autodb.web.lookup_cache import LookupCache
from autodb.web.receive.apart import Task
from autodb.web.receive.children import Children, Unable
from autodb.web.receive.imports import Imports
from autodb.web.receive.learning import Learnings
from autodb.wording import Worded, language_of, phrase

BEARER = "bearer "
HELD_S = 5.0
"""How long a token that was valid is taken to be so without asking again. Chosen."""
GUESSES, GUESSES_S = 20, 60.0
"""Tokens that are not valid, of one address, within so long: then it has to wait. Chosen."""
PASSED_ON = (
    "forwarded",
    "via",
    "x-forwarded-for",
    "x-forwarded-host",
    "x-forwarded-proto",
    "x-real-ip",
)
"""Headers of which a proxy adds one (RFC 7239, RFC 9110 section 7.6.3, and usage)."""
WAIT_S = 10
"""When to try again where too many wait. Chosen."""
SENDS_S = 60.0
"""Within which an address may send so many files."""


@dataclass
class Service:
    """A store that is served: its settings, what is kept of it, its counts, and who is at work.

    ``sends``: how often files are sent; ``reading``: what is read while who sent it waits.
    """

    settings: Settings
    store: Store
    watched: Watched
    lookup_cache: LookupCache
    metrics: Metrics
    children: Children
    imports: Imports
    learnings: Learnings
    sends: Rate
    reading: CapacityLimiter
    sessions: Sessions = field(default_factory=Sessions)
    _held: dict[str, tuple[float, Access]] = field(default_factory=dict)
    _guesses: Rate = field(default_factory=lambda: Rate(GUESSES, GUESSES_S))
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
        if self.settings.anonymous and not _was_passed_on(request):
            return ANYONE_HERE
        raise HTTPException(
            401, phrase("a token is needed; make one with 'autodb token add'"), CHALLENGE
        )

    def by_token(self, request: Request, secret: str) -> Access:
        """Return whose token it is; raises HTTPException where it is not valid.

        One that is valid is taken however often its address guessed: others may share that.
        """
        found = self._of(secret) if is_token(secret) else None
        if found is not None:
            return found
        self.metrics.refused_tokens.inc()
        client = client_of(request)
        wait_s = self._guesses.wait_s(client)
        self._guesses.note(client)
        if wait_s:
            raise _too_often(phrase("{count} tokens that are not valid", count=GUESSES), wait_s)
        raise HTTPException(401, phrase("the token is not valid"), CHALLENGE)

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
            raise HTTPException(403, phrase("not sent by a page of this service; send it from one"))
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

    def refuse_sending(self, request: Request) -> None:
        """Count a file that an address sends; raises HTTPException where it sends too many."""
        client = client_of(request)
        wait_s = self.sends.wait_s(client)
        if wait_s:
            most = self.settings.limits.a_minute
            raise _too_often(phrase("{count} files within a minute", count=most), wait_s)
        self.sends.note(client)

    def needs_machine(self, machine: str) -> None:
        """Raise NotThere where there is no machine of that name."""
        with self.store.reading() as session:
            owner_named(session, machine)

    def close(self) -> None:
        """End what is at work, and give back the database."""
        self.children.close()
        self.imports.close()
        self.learnings.close()
        self.watched.close()
        self.store.close()


ANYONE_HERE = Access("anyone on this computer", Role.READ, None)
CHALLENGE = {"WWW-Authenticate": "Bearer"}


def client_of(request: Request) -> str:
    """Return the address that a request came from."""
    return request.client.host if request.client else ""


def _was_passed_on(request: Request) -> bool:
    """Return whether a request says that it came through a proxy: then anybody may have asked."""
    return any(name in request.headers for name in PASSED_ON)


def _too_often(what: str, wait_s: int) -> HTTPException:
    said = phrase("{what}; try again in {wait} s", what=what, wait=wait_s)
    return HTTPException(429, said, {"Retry-After": str(wait_s)})


def service_of(request: Request) -> Service:
    """Return the service that a request came to."""
    found = request.app.state.service
    assert isinstance(found, Service)
    return found


async def made_apart(service: Service, task: Task, kind: Any, bounds: ReaderBounds) -> Any:
    """Return what comes of a task, of a type, that a process of its own does while who asks waits.

    Raises HTTPException where too many are done or it could not be tried, UnusableInput where it
    is refused.
    """
    if service.reading.statistics().tasks_waiting >= service.settings.limits.at_once:
        said = phrase("too many files are read; try again in {wait} s", wait=WAIT_S)
        raise HTTPException(503, said, {"Retry-After": str(WAIT_S)})
    work = partial(service.children.do, task, kind, bounds)
    try:
        return await to_thread.run_sync(work, limiter=service.reading)
    except Unable as error:
        raise HTTPException(503, Worded(str(error), language_of(error))) from None


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
        raise HTTPException(403, phrase("served read-only; run 'autodb serve --write'"))
    if access.role < role:
        if access.token_id is None:
            said = phrase(
                "a token is needed of role {role}; make one with 'autodb token add'",
                role=role.word,
            )
            raise HTTPException(401, said, CHALLENGE)
        raise HTTPException(
            403,
            phrase(
                "'{who}' may {role}, not {other}",
                who=access.who, role=access.role.word, other=role.word,
            ),
        )  # fmt: skip
    return access


Reads = Annotated[Access, Depends(may(Role.READ))]
Operates = Annotated[Access, Depends(may(Role.OPERATE, changes=True))]
Administers = Annotated[Access, Depends(may(Role.ADMIN))]
