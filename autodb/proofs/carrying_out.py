"""A proof in a folder: its finished runs in a file, the missing ones carried out, the score."""

import os
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from pathlib import Path
from threading import Thread
from typing import Any

from autodb.errors import UnusableInput
from autodb.proofs.catalogue import Proof, proof
from autodb.proofs.runs.found import ProofResult
from autodb.proofs.runs.run_file import Finished, Origin, append, resume


@dataclass(frozen=True)
class Begun:
    """A proof in a folder: the file of its runs, those finished, why it began anew or nothing."""

    proof: Proof[Any]
    origin: Origin
    path: Path
    finished: dict[int, Finished[Any]]
    note: str


def begin_runs(asked: Proof[Any], folder: Path) -> Begun:
    """Open or make the file of a proof's runs in ``folder``.

    Raises UnusableInput when the folder is a file, or the file in it no runs of a proof.
    """
    if folder.exists() and not folder.is_dir():
        raise UnusableInput(f"{folder}: is a file; --out needs a folder")
    folder.mkdir(parents=True, exist_ok=True)
    path, origin = folder / f"{asked.name}.jsonl", asked.origin()
    finished, note = resume(path, origin, asked.kept)
    return Begun(asked, origin, path, finished, note)


def carry_out(
    begun: Begun, runs: int, *, progress: Callable[[int], None], workers: int = 1
) -> ProofResult:
    """Run the seeds of 1 to ``runs`` that are not finished, and sum up all of them.

    ``progress`` gets how many are finished. Several ``workers`` are processes of their own; a
    run is kept when it is finished, whatever others do. The summary is written beside the runs as
    JSON; it does not depend on how many worked.
    """
    finished = {seed: run for seed, run in begun.finished.items() if seed <= runs}
    progress(len(finished))
    missing = [seed for seed in range(1, runs + 1) if seed not in finished]
    for run in _finished(begun.proof, missing, workers):
        finished[run.seed] = append(begun.path, run, begun.proof.kept)
        progress(len(finished))
    found = begun.proof.score([finished[seed] for seed in range(1, runs + 1)], begun.origin)
    begun.path.with_suffix(".json").write_text(found.to_json(), encoding="utf-8")
    return found


def _finished(asked: Proof[Any], seeds: list[int], workers: int) -> Iterator[Finished[Any]]:
    if workers == 1 or len(seeds) < 2:
        yield from (Finished(seed, tuple(asked.run(seed))) for seed in seeds)
        return
    # Each worker has a core for itself; linear algebra reads this before it starts
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    with get_context("spawn").Pool(workers, begin_worker) as pool:
        yield from pool.imap_unordered(partial(_run, asked.name), seeds)


def _run(name: str, seed: int) -> Finished[Any]:
    return Finished(seed, tuple(proof(name).run(seed)))


def begin_worker() -> None:
    """Leave a keyboard's interrupt to the parent, who ends the workers; end where it was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent.sentinel,), daemon=True).start()


def _end_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
