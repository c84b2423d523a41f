"""Time networks on a reference mill: blocks of 50 ms as they come, and training on P0's recordings.

    python -m benchmarks.networks              # the stream alone, of a network trained for a minute
    python -m benchmarks.networks --train      # also P0's 160 recordings, ours and P0's own network

Streams run on one core, beside a bare run of the same networks, their lower limit; training takes
what PyTorch takes.
"""

import sys
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import torch

from autodb.proofs.machines.mill.reference_mill_moves import RATE_HZ
from autodb.proofs.machines.mill.reference_plan import TESTS, TRAINING
from autodb.proofs.runs.mill.mill_run import SCORED
from autodb.proofs.runs.mill.network_run import SweptMill, recorded_of
from autodb.proofs.runs.mill.published_lstm import published_network
from autodb.sensing.network import learning
from autodb.sensing.network.beside import networks_beside
from autodb.sensing.network.fused import FusedStream
from autodb.sensing.network.greybox import GreyBox
from autodb.sensing.network.network import ran, side_by_side
from autodb.sensing.network.stream import Stream

SEED, FEW, BLOCK_S, RUNS = 101, 16, 0.05, 5


def blocks(rows: int) -> list[slice]:
    """Return the rows of blocks of BLOCK_S: twelve and thirteen in turn at 250 Hz."""
    ends = np.arange(0.0, rows / RATE_HZ, BLOCK_S) * RATE_HZ
    edges = [*(int(one) for one in ends), rows]
    return [slice(begin, end) for begin, end in pairwise(edges) if end > begin]


def times_real(once: Callable[[], object], rows: int) -> float:
    """Return how many times faster than real time a run is, the median of RUNS."""
    took = []
    for _ in range(RUNS):
        began = time.perf_counter()
        once()
        took.append(time.perf_counter() - began)
    return rows / RATE_HZ / float(np.median(took))


def streams(machine: SweptMill, box: GreyBox) -> None:
    """Print how fast blocks go through, with drive models and network put together, and bare."""
    torch.set_num_threads(1)
    tables = box.tables(machine.drives)
    cuts = [recorded_of(one) for one in machine.cuts(TRAINING[:FEW])]
    fusions = {c: one.fusion for c, one in networks_beside(box, machine.drives, cuts).items()}
    channels = machine.cuts(TESTS[1:2])[0].channels
    rows = len(channels["x.position"])
    cut = [{name: one[part] for name, one in channels.items()} for part in blocks(rows)]
    network = side_by_side(box.members)
    shown = [np.zeros((part.stop - part.start, len(box.scaled.middle))) for part in blocks(rows)]

    def through(stream: Stream | FusedStream) -> None:
        for block in cut:
            stream.step(block)
        stream.finish()

    def bare() -> None:
        state = None
        for block in shown:
            _, state = ran(network, block, state)

    print("| blocks of 50 ms at 250 Hz, one core | times real time |\n|---|---:|")
    for name, once in (
        (
            "drive models, network, both together",
            lambda: through(FusedStream(box, tables, fusions)),
        ),
        ("drive models and network", lambda: through(Stream(box, tables))),
        ("the bare networks", bare),
    ):
        print(f"| {name} | {times_real(once, rows):.1f} |", flush=True)


def training(machine: SweptMill) -> None:
    """Print how long training on all of P0's recordings takes, ours and P0's network."""
    cuts = machine.cuts(TRAINING)
    seen = [recorded_of(one) for one in cuts]
    print("\n| training on 160 recordings | minutes |\n|---|---:|")
    began = time.perf_counter()
    learning.train_grey_box(seen, machine.drives, rate_hz=RATE_HZ)
    print(f"| grey box, three networks | {(time.perf_counter() - began) / 60.0:.1f} |", flush=True)
    began = time.perf_counter()
    for k in range(len(SCORED)):
        published_network(cuts, k)
    print(f"| P0's networks of x and y | {(time.perf_counter() - began) / 60.0:.1f} |")


if __name__ == "__main__":
    mill = SweptMill.swept(SEED)
    if "--train" in sys.argv:
        training(mill)
    few = [recorded_of(one) for one in mill.cuts(TRAINING[:FEW])]
    streams(mill, learning.train_grey_box(few, mill.drives, rate_hz=RATE_HZ))
