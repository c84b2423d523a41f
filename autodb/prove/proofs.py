"""The proofs there are, and running one: seeds 1 to n, each run kept as soon as it is finished."""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType
from typing import Any, Generic, TypeVar

from pydantic import TypeAdapter

import autodb
from autodb.errors import UnusableInput, near
from autodb.prove import (
    axis_intervals,
    axis_run,
    axis_summary,
    commands_run,
    commands_summary,
    curve_run,
    curve_summary,
    day_run,
    day_summary,
    explain_summary,
    faults_run,
    faults_summary,
    fleet_run,
    fleet_summary,
    flips_run,
    flips_summary,
    lathe_run,
    lathe_summary,
    left_out,
    mill_run,
    mill_summary,
    network_summary,
    outside_run,
    outside_summary,
    pair_run,
    summary,
    table_run,
    table_summary,
)
from autodb.prove.axis_run import Told
from autodb.prove.curve_plans import Planned
from autodb.prove.day_run import DayTold
from autodb.prove.explain_score import Scored
from autodb.prove.found import Found
from autodb.prove.lathe_run import AxisErrors
from autodb.prove.runs import Finished, Origin, append, digest, resume
from autodb.prove.score import Judged
from autodb.sensing.lstm import need_torch
from autodb.virtual import (
    axes,
    curves,
    day,
    drives,
    fleets,
    lathe,
    machine,
    motion,
    noise,
    power_pairs,
    process,
    quantities,
    reference_axis,
    reference_cogging,
    reference_cuts,
    reference_friction,
    reference_lathe,
    reference_mill,
    reference_mill_moves,
    reference_milling,
    reference_moves,
    reference_plan,
    reference_table,
)
from autodb.virtual.concealed import (
    mill_cases,
    mill_effects,
    mill_families,
    mill_plan,
    mill_table_effects,
    milling,
    outside,
)

J = TypeVar("J")
ROOT = Path(autodb.__file__).parent
APART = ("cli", "virtual")
"""Folders that make no interval; the generator's own modules are looked at by themselves."""


CONCEALED = tuple(
    import_module(f"autodb.virtual.concealed{name}")
    for name in (
        "",
        ".added_effects",
        ".axis_cases",
        ".axis_families",
        ".build",
        ".case",
        ".changing_effects",
        ".cut_cases",
        ".cut_effects",
        ".cut_families",
        ".cuts",
        ".disturbance",
        ".effect",
        ".machine",
        ".moves",
        ".plan",
    )
)


CONCEALED_MILLS = (
    *CONCEALED,
    mill_cases,
    mill_effects,
    mill_families,
    mill_plan,
    mill_table_effects,
    milling,
)
DAY = (
    day,
    drives,
    machine,
    *(
        import_module(f"autodb.virtual.concealed{name}")
        for name in ("", ".build", ".case", ".cut_effects", ".cut_families", ".cuts", ".moves")
    ),
)
REFERENCE_AXIS = (curves, motion, noise, reference_axis, reference_friction, reference_moves)
REFERENCE_MILL = (
    curves,
    motion,
    noise,
    reference_cogging,
    reference_cuts,
    reference_friction,
    reference_mill,
    reference_mill_moves,
    reference_milling,
)


@dataclass(frozen=True)
class Proof(Generic[J]):
    """One proof: its name, what it proves, how many runs it takes, and the generator's modules.

    ``run`` judges what one seed draws; ``kept`` is the form of a finished run in a file; ``score``
    sums up runs in the order of their seeds; ``read`` reads what was written of a score.
    """

    name: str
    what: str
    runs: int
    run: Callable[[int], list[J]]
    kept: TypeAdapter[Finished[J]]
    score: Callable[[Sequence[Finished[J]], Origin], Found]
    read: Callable[[str], Found]
    generator: tuple[ModuleType, ...]

    def origin(self) -> Origin:
        """Return what a run of this proof comes from in this program."""
        modules = [Path(str(module.__file__)) for module in self.generator]
        sources = [p for p in ROOT.rglob("*.py") if p.relative_to(ROOT).parts[0] not in APART]
        return Origin(
            proof=self.name,
            version=autodb.__version__,
            generator=digest(modules, root=ROOT),
            product=digest(sources, root=ROOT),
        )


def _networks(seed: int) -> list[network_summary.Judged]:
    """Run what needs PyTorch; raises UnusableInput where it is not installed."""
    need_torch()
    from autodb.prove import network_run

    return network_run.run(seed)


PROOFS: tuple[Proof[Any], ...] = (
    Proof(
        name="axis-intervals",
        what="95 % intervals of an identified axis hold the truth of axes drawn at random",
        runs=2000,
        run=axis_intervals.run,
        kept=TypeAdapter(Finished[Judged]),
        score=summary.summary_of,
        read=summary.Summary.from_json,
        generator=(axes, curves, motion, noise, quantities),
    ),
    Proof(
        name="explain",
        what="explain names what a simulation left out, and nothing where nothing is missing",
        runs=3000,
        run=left_out.run,
        kept=TypeAdapter(Finished[Scored]),
        score=explain_summary.summary_of,
        read=explain_summary.Summary.from_json,
        generator=CONCEALED,
    ),
    Proof(
        name="explain-outside",
        what="what a simulation has right is not called mistuned, whatever else is missing",
        runs=200,
        run=outside_run.run,
        kept=TypeAdapter(Finished[outside_run.Answered]),
        score=outside_summary.summary_of,
        read=outside_summary.Summary.from_json,
        generator=(*CONCEALED, outside),
    ),
    Proof(
        name="explain-milling",
        what="explain names what a milled waveform's simulation left out, and nothing else",
        runs=192,
        run=left_out.run_mill,
        kept=TypeAdapter(Finished[Scored]),
        score=explain_summary.summary_of,
        read=explain_summary.Summary.from_json,
        generator=CONCEALED_MILLS,
    ),
    Proof(
        name="day",
        what="a lathe's day: events named in time, none invented, next cuts predicted with terms",
        runs=20,
        run=day_run.run,
        kept=TypeAdapter(Finished[DayTold]),
        score=day_summary.summary_of,
        read=day_summary.Summary.from_json,
        generator=DAY,
    ),
    Proof(
        name="calibration",
        what="forces of calibrated lathes, on which the published way shows the published errors",
        runs=20,
        run=lathe_run.run,
        kept=TypeAdapter(Finished[AxisErrors]),
        score=lathe_summary.summary_of,
        read=lathe_summary.Summary.from_json,
        generator=(drives, lathe, machine, process, reference_lathe),
    ),
    Proof(
        name="published-axis",
        what="reference axes are as hard as the published ones: the published way shows its errors",
        runs=20,
        run=axis_run.gate,
        kept=TypeAdapter(Finished[Told]),
        score=axis_summary.gate_of,
        read=axis_summary.read_gate,
        generator=REFERENCE_AXIS,
    ),
    Proof(
        name="axis-field",
        what="friction field, contour and weight of reference axes, identified by autodb",
        runs=20,
        run=axis_run.run,
        kept=TypeAdapter(Finished[Told]),
        score=axis_summary.fields_of,
        read=axis_summary.read_fields,
        generator=REFERENCE_AXIS,
    ),
    Proof(
        name="published-mill",
        what="reference mills are as hard as the published one: the published way has its errors",
        runs=20,
        run=mill_run.gate,
        kept=TypeAdapter(Finished[mill_run.Told | mill_run.Kept]),
        score=mill_summary.gate_of,
        read=mill_summary.read_gate,
        generator=REFERENCE_MILL,
    ),
    Proof(
        name="mill-forces",
        what="forces in the cuts of reference mills, from the currents of their linear drives",
        runs=20,
        run=mill_run.run,
        kept=TypeAdapter(Finished[mill_run.Told | mill_run.Kept]),
        score=mill_summary.forces_of,
        read=mill_summary.read_forces,
        generator=REFERENCE_MILL,
    ),
    Proof(
        name="mill-networks",
        what="forces in reference mills' cuts: the published network, and a grey box beside it",
        runs=3,
        run=_networks,
        kept=TypeAdapter(Finished[network_summary.Judged]),
        score=network_summary.summary_of,
        read=network_summary.read,
        generator=(*REFERENCE_MILL, reference_plan),
    ),
    Proof(
        name="table",
        what="forces on tables that tilt, whose sensors chips heat: the published way, and ours",
        runs=20,
        run=table_run.run,
        kept=TypeAdapter(Finished[table_summary.Judged]),
        score=table_summary.summary_of,
        read=table_summary.read,
        generator=(reference_table,),
    ),
    Proof(
        name="faults",
        what="a refresh that is killed loses nothing and counts nothing twice",
        runs=200,
        run=faults_run.run,
        kept=TypeAdapter(Finished[faults_summary.Killed]),
        score=faults_summary.summary_of,
        read=faults_summary.read,
        generator=(),  # what is drawn is when it is killed
    ),
    Proof(
        name="faults-commands",
        what="every command that writes, killed or run twice at once, leaves what it would alone",
        runs=500,
        run=commands_run.run,
        kept=TypeAdapter(Finished[commands_summary.Killed | commands_summary.Twice]),
        score=commands_summary.summary_of,
        read=commands_summary.read,
        generator=(),  # what is drawn is when it is killed
    ),
    Proof(
        name="flips",
        what="a bit that flips in a database's file is found by doctor and backup",
        runs=200,
        run=flips_run.run,
        kept=TypeAdapter(Finished[flips_summary.Flipped]),
        score=flips_summary.summary_of,
        read=flips_summary.read,
        generator=(),  # what is drawn is which bit
    ),
    Proof(
        name="pairs",
        what="95 % intervals of a pair's next forces, in its operation and in those never cut",
        runs=300,
        run=pair_run.run,
        kept=TypeAdapter(Finished[Judged]),
        score=summary.summary_of,
        read=summary.Summary.from_json,
        generator=(power_pairs, process),
    ),
    Proof(
        name="pair-curve",
        what="few turned cuts teach a pair, and fewer where the next one is proposed",
        runs=48,
        run=curve_run.run,
        kept=TypeAdapter(Finished[curve_run.Learnt | Planned]),
        score=curve_summary.summary_of,
        read=curve_summary.Summary.from_json,
        generator=(power_pairs, process),
    ),
    Proof(
        name="fleet",
        what="a new machine predicts sooner from what others know; one that is off is named",
        runs=50,
        run=fleet_run.run,
        kept=TypeAdapter(Finished[fleet_run.Joined | fleet_run.NamedOne]),
        score=fleet_summary.summary_of,
        read=fleet_summary.read,
        generator=(fleets, power_pairs, process),
    ),
)


def proof(name: str) -> Proof[Any]:
    """Return a proof by name; raises UnusableInput naming those there are."""
    found = next((one for one in PROOFS if one.name == name), None)
    if found is None:
        raise UnusableInput(f"no proof '{name}'{near(name, [one.name for one in PROOFS])}")
    return found


@dataclass(frozen=True)
class Begun:
    """A proof in a folder: the file of its runs, those finished, why it began anew or nothing."""

    proof: Proof[Any]
    origin: Origin
    path: Path
    finished: dict[int, Finished[Any]]
    note: str


def begin(asked: Proof[Any], folder: Path) -> Begun:
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
) -> Found:
    """Run the seeds of 1 to ``runs`` that are not finished, and sum up all of them.

    ``progress`` is told how many are finished. Several ``workers`` are processes of their own; a
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
    with get_context("spawn").Pool(workers, _leave_interrupts) as pool:
        yield from pool.imap_unordered(partial(_run, asked.name), seeds)


def _run(name: str, seed: int) -> Finished[Any]:
    return Finished(seed, tuple(proof(name).run(seed)))


def _leave_interrupts() -> None:
    """A keyboard's interrupt is the parent's, who ends the workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
