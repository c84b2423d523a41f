"""What is run in children, all begun together."""

import os
import time
from collections.abc import Callable

from autodb.errors import UnusableInput


def begun(work: Callable[[], object]) -> int:
    """Run in a child; it exits 0, or 2 for what is refused."""
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        work()
        code = 0
    except UnusableInput:
        code = 2
    finally:
        os._exit(code)


def at_once(*works: Callable[[], object]) -> list[int]:
    """Run each in a child, all begun together; return their exit codes."""
    start = time.monotonic() + 0.1

    def waiting(work: Callable[[], object]) -> Callable[[], object]:
        def run() -> object:
            time.sleep(max(0.0, start - time.monotonic()))
            return work()

        return run

    children = [begun(waiting(work)) for work in works]
    return [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
