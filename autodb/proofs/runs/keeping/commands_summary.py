"""What kills of every command left, and two of it at once: by command, and in all."""

from collections.abc import Sequence
from dataclasses import dataclass

from autodb.proofs.runs.found import Check, CheckedScore, TextTable, percent
from autodb.proofs.runs.keeping.forked import CASES
from autodb.proofs.runs.run_file import Finished, Origin

FINE = (0, 2)
"""Exit statuses: answered, or refused in one line, as what is there already may be."""
AT_WORK, WRITTEN = 0.5, 0.25
"""Least shares of the kills that must hit a process at work, and one that has written."""


@dataclass(frozen=True)
class KilledCommand:
    """One kill of a command: how far it had come, what was not sound then; after it ran again its
    exit status, which files hold something else than undisturbed, and which are too many or few.
    """

    command: str
    case: str
    unsound: tuple[str, ...]
    other: tuple[str, ...]
    stray: tuple[str, ...]
    status: int
    said: str


@dataclass(frozen=True)
class Twice:
    """Two of a command at once: their exit statuses, what was found in the end, and what of its
    files carries a clock or is drawn, so that it was not compared.
    """

    command: str
    statuses: tuple[int, ...]
    unsound: tuple[str, ...]
    other: tuple[str, ...]
    stray: tuple[str, ...]
    said: str
    left_out: tuple[str, ...]

    @property
    def sound(self) -> bool:
        """Say whether one of them was done, the other too or refused, and all is as it must be."""
        fine = set(self.statuses) <= set(FINE) and 0 in self.statuses
        return fine and not (self.unsound or self.other or self.stray)


@dataclass(frozen=True)
class OfCommand:
    """Counts of one command's kills, and of its rounds of two at once."""

    command: str
    kills: int
    at_work: int
    written: int
    unsound: int
    other: int
    stray: int
    failed: int
    rounds: int
    sound: int


@dataclass(frozen=True)
class CommandsSummary(CheckedScore):
    """Counts of all commands, and what was not compared."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[OfCommand, ...]
    left_out: tuple[str, ...]

    def _sum(self, name: str) -> int:
        return sum(getattr(row, name) for row in self.rows)

    def checks(self) -> list[Check]:
        """Return what must be."""
        kills, rounds = self._sum("kills"), self._sum("rounds")
        none = [
            (what, str(count), "0", count == 0)
            for what, count in (
                ("something half-written in sight after a kill", self._sum("unsound")),
                ("run again, ended in other rows or other content", self._sum("other")),
                ("run again, ended with a file too many or too few", self._sum("stray")),
                ("run again, ended neither answered nor refused", self._sum("failed")),
                ("rounds of two at once that did not end sound", rounds - self._sum("sound")),
            )
        ]
        shares = [
            (what, f"{n} ({percent(n / kills)})", f"≥ {percent(least)}", n >= least * kills)
            for what, n, least in (
                ("kills that hit it at work", self._sum("at_work"), AT_WORK),
                ("kills after its first write", self._sum("written"), WRITTEN),
            )
        ]
        return [*none, *shares]

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, each command, and what was not compared."""
        what = f"{self._sum('kills')} kills of {len(self.rows)} commands"
        rows = tuple(
            (f"`{row.command}`", *(str(n) for n in (
                row.kills, row.at_work, row.written, row.unsound, row.other + row.failed, row.stray,
                row.rounds, row.sound,
            ))) for row in self.rows
        )  # fmt: skip
        heads = (
            "command", ">kills", ">at work", ">after its first write", ">half-written",
            ">other rows or content", ">stray files", ">two at once", ">sound",
        )  # fmt: skip
        left = tuple((name,) for name in self.left_out)
        return (
            self.limits(f"{what}, and two of it at once"),
            TextTable("By command", heads, rows),
            TextTable(
                "Clocks and what is drawn at random: not compared", ("column, or file",), left
            ),
        )


def commands_summary_of(
    runs: Sequence[Finished[KilledCommand | Twice]], origin: Origin
) -> CommandsSummary:
    """Count kills and rounds by command, in the order in which they came."""
    judged = [one for run in runs for one in run.judged]
    names = list(dict.fromkeys(one.command for one in judged))
    twice = [one for one in judged if isinstance(one, Twice)]
    return CommandsSummary(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        rows=tuple(_row(name, [one for one in judged if one.command == name]) for name in names),
        left_out=tuple(sorted({name for one in twice for name in one.left_out})),
    )


def _row(name: str, judged: Sequence[KilledCommand | Twice]) -> OfCommand:
    kills = [one for one in judged if isinstance(one, KilledCommand)]
    rounds = [one for one in judged if isinstance(one, Twice)]
    return OfCommand(
        command=name,
        kills=len(kills),
        at_work=sum(one.case != CASES[2] for one in kills),
        written=sum(one.case == CASES[1] for one in kills),
        unsound=sum(bool(one.unsound) for one in kills),
        other=sum(bool(one.other) for one in kills),
        stray=sum(bool(one.stray) for one in kills),
        failed=sum(one.status not in FINE for one in kills),
        rounds=len(rounds),
        sound=sum(one.sound for one in rounds),
    )
