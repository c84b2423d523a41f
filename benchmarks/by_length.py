"""Costs of explaining by length, each in a process of its own: peaks of memory are then theirs."""

import math
import resource
import subprocess
import sys
import time
from collections.abc import Sequence

from autodb.explain import explain
from autodb.records.tables import CutTable, Recording


def print_cost(recording: Recording | CutTable, simulation: Recording | CutTable) -> None:
    """Explain; print seconds of the processor, peak GiB, and what is named."""
    begun_s = time.process_time()
    done = explain(recording, simulation)
    took_s = time.process_time() - begun_s
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    named = sorted({c.term for a in done.explanation.channels.values() for c in a.missing})
    print(f"{took_s:.3f} {peak:.2f} {','.join(named)}")


def print_growth(module: str, lengths: Sequence[int], unit: str) -> None:
    """Run a module for every length, which prints its cost, and print how that grows."""
    before: tuple[int, float] | None = None
    for count in lengths:
        command = [sys.executable, "-m", module, str(count)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        took, peak, named = done.stdout.split()
        doubled = ""
        if before is not None:
            power = math.log(float(took) / before[1]) / math.log(count / before[0])
            doubled = f", {2.0**power:.2f} x by doubling"
        print(f"{count} {unit}: {float(took):.1f} s{doubled}, {peak} GiB, named {named}")
        before = count, float(took)
