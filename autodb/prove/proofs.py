"""The proofs there are, and running one: seeds 1 to n, each run kept as soon as it is finished."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import autodb
from autodb.errors import UnusableInput, near
from autodb.prove import axis_intervals
from autodb.prove.runs import Finished, Origin, append, digest, resume
from autodb.prove.score import Judged
from autodb.prove.summary import Summary, summary_of
from autodb.virtual import axes, curves, motion, noise, quantities

ROOT = Path(autodb.__file__).parent
APART = ("cli", "virtual")
"""Folders that make no interval; the generator's own modules are looked at by themselves."""


@dataclass(frozen=True)
class Proof:
    """One proof: its name, what it proves, a run of one seed, and the generator's modules."""

    name: str
    what: str
    run: Callable[[int], list[Judged]]
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


PROOFS = (
    Proof(
        name="axis-intervals",
        what="95 % intervals of an identified axis hold the truth of axes drawn at random",
        run=axis_intervals.run,
        generator=(axes, curves, motion, noise, quantities),
    ),
)


def proof(name: str) -> Proof:
    """Return a proof by name; raises UnusableInput naming those there are."""
    found = next((one for one in PROOFS if one.name == name), None)
    if found is None:
        raise UnusableInput(f"no proof '{name}'{near(name, [one.name for one in PROOFS])}")
    return found


@dataclass(frozen=True)
class Begun:
    """A proof in a folder: the file of its runs, those finished, why it began anew or nothing."""

    proof: Proof
    origin: Origin
    path: Path
    finished: dict[int, Finished]
    note: str


def begin(asked: Proof, folder: Path) -> Begun:
    """Open or make the file of a proof's runs in ``folder``.

    Raises UnusableInput when the folder is a file, or the file in it no runs of a proof.
    """
    if folder.exists() and not folder.is_dir():
        raise UnusableInput(f"{folder}: is a file; --out needs a folder")
    folder.mkdir(parents=True, exist_ok=True)
    path, origin = folder / f"{asked.name}.jsonl", asked.origin()
    finished, note = resume(path, origin)
    return Begun(asked, origin, path, finished, note)


def carry_out(begun: Begun, runs: int, *, progress: Callable[[int], None]) -> Summary:
    """Run the seeds of 1 to ``runs`` that are not finished, and sum up all of them.

    The summary is written beside the runs as JSON.
    """
    finished = dict(begun.finished)
    for seed in range(1, runs + 1):
        if seed not in finished:
            run = Finished(seed, tuple(begun.proof.run(seed)))
            finished[seed] = append(begun.path, run)
        progress(seed)
    found = summary_of([finished[seed] for seed in range(1, runs + 1)], begun.origin)
    begun.path.with_suffix(".json").write_text(found.to_json(), encoding="utf-8")
    return found
