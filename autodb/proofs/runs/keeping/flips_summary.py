"""What bits that flipped changed, and who found it."""

from collections.abc import Sequence
from dataclasses import dataclass

from autodb.proofs.runs.found import Check, CheckedScore, TextTable
from autodb.proofs.runs.keeping.flips import Flip
from autodb.proofs.runs.run_file import Finished, Origin

IN_FILE, IN_LOG = "in the file", "in the log of a killed program"


@dataclass(frozen=True)
class Flipped:
    """A flipped bit, and where: in the file or in its log."""

    where: str
    counts: bool
    by_doctor: bool
    by_backup: bool

    @classmethod
    def of(cls, where: str, flip: Flip) -> "Flipped":
        """Return what was found of a flip."""
        return cls(where, flip.counts, flip.by_doctor, flip.by_backup)


@dataclass(frozen=True)
class Counts:
    """Flips of a place; of those that changed a value, or took rows away, who found them."""

    where: str
    flips: int
    counting: int
    by_doctor: int
    by_backup: int
    by_both: int


@dataclass(frozen=True)
class Flips(CheckedScore):
    """Counts of the file and of the log."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[Counts, ...]

    def checks(self) -> list[Check]:
        """Return what must be."""
        in_file = next(row for row in self.rows if row.where == IN_FILE)
        missed = in_file.counting - in_file.by_both
        return [
            ("flips in the file that changed a value", str(in_file.counting), "> 0",
             in_file.counting > 0),
            ("of them not found by `doctor` and `backup` both", str(missed), "0", missed == 0),
        ]  # fmt: skip

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, and the counts; of a log nothing is promised."""
        rows = tuple(
            (row.where, *(str(n) for n in (
                row.flips, row.counting, row.by_doctor, row.by_backup, row.by_both,
                row.counting - row.by_both,
            ))) for row in self.rows
        )  # fmt: skip
        heads = (
            "one bit", ">flips", ">changed a value or lost a row", ">found by `doctor`",
            ">found by `backup`", ">by both", ">not by both",
        )  # fmt: skip
        return (
            self.limits("Bits that flip in a database's file"),
            TextTable("Where it flipped", heads, rows),
        )


def flips_summary_of(runs: Sequence[Finished[Flipped]], origin: Origin) -> Flips:
    """Count the flips of runs by where they were."""
    every = [one for run in runs for one in run.judged]
    rows = []
    for where in (IN_FILE, IN_LOG):
        counting = [one for one in every if one.where == where and one.counts]
        rows.append(
            Counts(
                where=where,
                flips=sum(one.where == where for one in every),
                counting=len(counting),
                by_doctor=sum(one.by_doctor for one in counting),
                by_backup=sum(one.by_backup for one in counting),
                by_both=sum(one.by_doctor and one.by_backup for one in counting),
            )
        )
    return Flips(origin, (runs[0].seed, runs[-1].seed), tuple(rows))
