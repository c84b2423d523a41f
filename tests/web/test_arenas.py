"""Threads of the service take memory from one arena, which does not grow with their number."""

import platform
import subprocess
import sys

import pytest

COUNTED = """
import threading
from pathlib import Path
from autodb.web.http import arenas
assert {first}
threads = threading.Barrier(9)
def take():
    kept = [bytes(1000 + k) for k in range(1000)]
    threads.wait()
    threads.wait()
for _ in range(8):
    threading.Thread(target=take, daemon=True).start()
threads.wait()
maps = [line.split() for line in Path("/proc/self/maps").read_text().splitlines()]
begins = [int(one[0].partition("-")[0], 16) for one in maps if len(one) == 5 and "w" in one[1]]
print(sum(begin % 2**26 == 0 for begin in begins))
threads.wait()
"""
"""Prints how many arenas there are beside the first: glibc has each begin at 64 MiB (arena.c)."""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="arenas are glibc's")
def test_threads_share_one_arena() -> None:
    def counted(first: str) -> int:
        command = [sys.executable, "-c", COUNTED.format(first=first)]
        return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)

    assert counted("arenas.share_one()") == 0
    assert counted("True") > 0
