"""`python -m benchmarks.cold`: how long commands take from the start of their process.

A look-up of one turned cut and the list of pairs in a small database, whose one pair has a
posterior with all digits and no open mismatch, `autodb --help`, and `import autodb`. Beside each
the time on the processor: other programs on the computer disturb it less. Medians of RUNS, after
one that fills the cache of files; the modules are compiled.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from autodb.agent.rows.machines import add_machine
from autodb.agent.rows.posteriors import posterior_columns
from autodb.files.machine import LATHE
from autodb.store import create_store, models, open_store
from benchmarks.fleet_lookups import GEOMETRY, drawn

RUNS = 15
CUT = ("--diameter", "50", "--depth", "2", "--feed", "0.25", "--speed", "220")
PAIR = ("--material", "steel", "--tool", "insert")
LIMITS_S = {"lookup, one cut": 0.7, "lookup, the pairs": 0.7, "--help": 0.2, "import autodb": 0.15}


def fill(url: str) -> None:
    """Make a database of one machine that has learnt one pair."""
    create_store(url)
    store = open_store(url)
    add_machine(store, "lathe", LATHE)
    with store.writing() as session:
        insert = models.Tool(name="insert", kind="turning_insert", **GEOMETRY)
        pair = models.Pair(material=models.Material(name="steel"), tool=insert)
        session.add(pair)
        session.flush()
        columns = posterior_columns(drawn(np.random.default_rng(1)))
        session.add(models.CuttingParameters(machine_id=1, pair_id=pair.id, version=1, **columns))
    store.close()


def took_s(command: tuple[str, ...], folder: Path) -> tuple[float, float]:
    """Return the wall time and the processor's time of a process."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    subprocess.run(
        (sys.executable, *command), cwd=folder, check=True, stdout=subprocess.DEVNULL,
        env=environment,
    )  # fmt: skip
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the times."""
    with tempfile.TemporaryDirectory(prefix="autodb-cold-") as name:
        folder = Path(name)
        fill(f"sqlite:///{folder / 'autodb.sqlite3'}")
        program = ("-m", "autodb")
        asked = {
            "lookup, one cut": (*program, "lookup", *PAIR, *CUT),
            "lookup, the pairs": (*program, "lookup"),
            "--help": (*program, "--help"),
            "import autodb": ("-c", "import autodb"),
        }
        for what, command in asked.items():
            took_s(command, folder)
            wall, busy = np.median([took_s(command, folder) for _ in range(RUNS)], axis=0)
            met = "passed" if wall <= LIMITS_S[what] else "missed"
            print(
                f"{what}: {wall:.2f} s ({busy:.2f} on the processor; limit {LIMITS_S[what]:g}: "
                f"{met})",
                flush=True,
            )


if __name__ == "__main__":
    main()
