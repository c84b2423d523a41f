"""What goes on until Ctrl-C ends in order where a service manager tells it to."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from autodb.cli import main
from tests.conftest import Cli

LONGEST_S = 60.0


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)])
def test_a_refresh_that_watches_says_that_it_stopped(
    cli: Cli, number: signal.Signals, status: int
) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    Path("in").mkdir()
    child = os.fork()
    if child == 0:
        try:
            with Path("log").open("w", buffering=1) as sys.stdout:
                sys.stderr = sys.stdout
                sys.argv = ["autodb", "refresh", "--inbox", "in", "--watch", "--every", "0.1"]
                main()
        except SystemExit as done:
            os._exit(int(str(done.code)))
        finally:
            os._exit(99)
    until = time.monotonic() + LONGEST_S
    while "nothing new" not in _said() and time.monotonic() < until:
        time.sleep(0.05)
    os.kill(child, number)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == status
    assert _said().splitlines()[-1] == "autodb: stopped"


def _said() -> str:
    return Path("log").read_text() if Path("log").exists() else ""
