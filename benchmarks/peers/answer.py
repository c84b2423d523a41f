"""`python -m benchmarks.peers.answer METHOD CASE.npz ANSWER.npz`: one method answers one case.

It runs in a process of its own, which the system ends when its processor time is over.
"""

import resource
import sys
from importlib import import_module
from pathlib import Path

from benchmarks.peers.problem import load

LIMIT_S = 120


def main(method: str, case: Path, out: Path) -> None:
    """Answer a case and write the answer."""
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_S, LIMIT_S + 1))
    module = import_module(f"benchmarks.peers.{method}")
    answer = module.answer(load(case))
    used = resource.getrusage(resource.RUSAGE_SELF)
    answer.save(out, seconds=used.ru_utime + used.ru_stime, version=module.VERSION)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
