"""Killed at any moment, import, calibrate, refresh and confirm leave nothing half-written.

Forked children are killed with SIGKILL; each time the database is sound and holds the state before
the command or the one after it, and the command run again ends in the latter.
"""

import pytest

from tests.helpers.kills import PHASES, STEPS, report, run


@pytest.mark.parametrize("kills", [2, pytest.param(20, marks=pytest.mark.campaign)])
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_what_kills_leave(kills: int) -> None:
    found = run(kills)
    assert [hits.damaged for hits in found] == [[]] * len(STEPS), report(found)
    assert [sum(hits.tenths) for hits in found] == [kills] * len(STEPS)
    assert sum(hits.phases[PHASES[1]] for hits in found) >= kills // 2
