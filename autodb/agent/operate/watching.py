"""Watch an inbox: a pass whenever something came in, for as long as nobody stops it."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager

from autodb.agent.ingest.entries import inbox_entries
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.learn.passes import RefreshReport
from autodb.agent.operate.refreshing import Progress, refresh
from autodb.store import Store

Opens = Callable[[], AbstractContextManager[Store]]
Excuse = Callable[[Exception], str | None]


def watch(
    opens: Opens,
    machine: str,
    inbox: Inbox,
    *,
    tell: Callable[[RefreshReport], None],
    say: Callable[[str], None],
    excuse: Excuse,
    every_s: float,
    progress: Progress = lambda _: None,
    goes_on: Callable[[], bool] = lambda: True,
) -> None:
    """Refresh a machine whenever files came into its inbox, while ``goes_on``.

    The first pass is made at once, and what is wrong with it is raised. Later, what ``excuse`` has
    a line for (a database that is locked or away, a folder that is not there) is said once and
    tried again: the files wait in the inbox.
    """
    with opens() as store:
        tell(refresh(store, machine, inbox=inbox, progress=progress))
    seen, said = inbox_entries(inbox.folder).files, ""
    while goes_on():
        time.sleep(every_s)
        try:
            there = inbox_entries(inbox.folder).files
            if there == seen and not said:
                continue
            with opens() as store:
                done = refresh(store, machine, inbox=inbox, progress=progress)
            if done.anything:
                tell(done)
            seen, said = there, ""
        except Exception as error:
            line = excuse(error)
            if line is None:
                raise
            if line != said:
                say(f"{line}; trying again every {every_s:g} s")
            said = line
