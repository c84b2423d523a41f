"""What kills of a refresh left: where they hit, and whether anything was lost or counted twice."""

from collections.abc import Sequence
from dataclasses import dataclass

from autodb.proofs.runs.found import Check, CheckedScore, TextTable
from autodb.proofs.runs.run_file import Finished, Origin

PHASES = (
    "before anything came in",
    "while files came in",
    "all in, nothing learnt yet",
    "after the pass was kept",
)


@dataclass(frozen=True)
class Killed:
    """One kill: at which tenth of an undisturbed run, how far that had come; what was found then
    and after it ran again: a sound database, the same rows, the same files.
    """

    tenth: int
    phase: str
    sound: bool
    rows: bool
    files: bool


@dataclass(frozen=True)
class Kills(CheckedScore):
    """Counts of kills by phase and by tenth, and of those that left something else."""

    origin: Origin
    seeds: tuple[int, int]
    phases: tuple[int, ...]
    tenths: tuple[int, ...]
    unsound: int
    other_rows: int
    other_files: int

    def checks(self) -> list[Check]:
        """Return what must be."""
        total = sum(self.phases)
        hit = sum(self.phases[1:3])
        found = [
            (what, str(count), "0", count == 0)
            for what, count in (
                ("databases that were not sound", self.unsound),
                ("ended in other rows than undisturbed", self.other_rows),
                ("ended in other files than undisturbed", self.other_files),
            )
        ]
        least = total // 4
        return [*found, ("kills while it worked", str(hit), f"≥ {least}", hit >= least)]

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, and where the kills hit."""
        phases = tuple((name, str(count)) for name, count in zip(PHASES, self.phases, strict=True))
        tenths = tuple(
            (f"{10 * k} to {10 * (k + 1)} %", str(count)) for k, count in enumerate(self.tenths)
        )
        return (
            self.limits("SIGKILL in a refresh from an inbox"),
            TextTable("How far it had come", ("", ">kills"), phases),
            TextTable("When, of the time of an undisturbed run", ("", ">kills"), tenths),
        )


def faults_summary_of(runs: Sequence[Finished[Killed]], origin: Origin) -> Kills:
    """Count the kills of runs."""
    kills = [one for run in runs for one in run.judged]
    return Kills(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        phases=tuple(sum(one.phase == name for one in kills) for name in PHASES),
        tenths=tuple(sum(one.tenth == k for one in kills) for k in range(10)),
        unsound=sum(not one.sound for one in kills),
        other_rows=sum(not one.rows for one in kills),
        other_files=sum(not one.files for one in kills),
    )
