"""Passes of the refresh as the database keeps them: what each did, and the lines that say it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.learn.shifted import ForceShift
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.refresh_cursor import ASKED, Span, last_force
from autodb.errors import UnusableInput
from autodb.store import Store, models
from autodb.wording import msgid, phrase, phrase_many
from autodb.wording.kept import said_again

CONFIRMS = msgid(
    "confirm a cause that holds with 'autodb mismatch confirm NUMBER'; tool_wear then enters "
    "the pair's parameters, and 5 cuts with another cause make a cutting state of their own"
)


@dataclass(frozen=True)
class CameIn:
    """A file of the inbox and what became of it: ``cuts`` new ones, ``again`` there already."""

    file: str
    status: str
    reason: str | None
    recording: int | None
    cuts: int
    again: int = 0


@dataclass
class RefreshReport:
    """What passes did: files that came in; forces; versions as (pair, version, cuts behind it) and
    what they moved; what is excluded (``set_aside``); mismatches opened for it or brought up to
    date; calibrations that are due.

    ``waiting``: how many of the machine's mismatches nobody has decided on; ``retained``: what
    became of old recordings afterwards. ``measured``: forces that a dynamometer measured.
    ``predicted``: new cuts that are linked with a prediction made before; ``asked``: in words, of
    which it is not sure what they are.
    """

    came_in: list[CameIn] = field(default_factory=list)
    sensed: int = 0
    not_sensed: int = 0
    versions: list[tuple[str, int, int]] = field(default_factory=list)
    shifts: list[ForceShift] = field(default_factory=list)
    set_aside: list[str] = field(default_factory=list)
    mismatches: list[str] = field(default_factory=list)
    due: list[str] = field(default_factory=list)
    waiting: int = 0
    retained: list[str] = field(default_factory=list)
    measured: int = 0
    predicted: int = 0
    asked: list[str] = field(default_factory=list)

    @property
    def anything(self) -> bool:
        """Whether anything was new."""
        return bool(
            self.came_in or self.measured or self.sensed or self.not_sensed or self.versions
        )

    @property
    def forces_words(self) -> str:
        """How many forces were measured, sensed and not sensed."""
        sensed, not_sensed = self.sensed, self.not_sensed
        if not self.measured:
            return phrase(
                "{sensed} forces sensed, {other} not sensed", sensed=sensed, other=not_sensed
            )
        return phrase(
            "{measured} forces measured, {sensed} sensed, {other} not sensed",
            measured=self.measured,
            sensed=sensed,
            other=not_sensed,
        )

    def also(self, other: "RefreshReport") -> None:
        """Add what a later pass did."""
        self.came_in += other.came_in
        self.measured += other.measured
        self.sensed += other.sensed
        self.not_sensed += other.not_sensed
        self.versions += other.versions
        self.shifts += other.shifts
        self.set_aside += [one for one in other.set_aside if one not in self.set_aside]
        self.mismatches += other.mismatches
        self.due = other.due
        self.waiting = other.waiting
        self.predicted += other.predicted
        self.asked += other.asked

    def lines(self) -> list[str]:
        """Return it in words, a line each."""
        said = [_of_file(one) for one in self.came_in]
        if self.anything:
            said.append(self.forces_words)
        else:
            said.append(phrase("nothing new: every cut is sensed and every pair is up to date"))
        said += [
            phrase("{pair}: version {version} from {cuts} cuts", pair=pair, version=version, cuts=n)
            for pair, version, n in self.versions
        ]
        said += [one.words for one in self.shifts]
        said += [phrase("excluded: {what}", what=said_again(one)) for one in self.set_aside]
        said += self.mismatches
        if self.mismatches:
            said.append(phrase(CONFIRMS))
        elif self.waiting:
            said.append(
                phrase_many(
                    "{count} mismatch is undecided; see 'autodb mismatch list'",
                    "{count} mismatches are undecided; see 'autodb mismatch list'",
                    self.waiting,
                )
            )
        if self.predicted:
            said.append(
                phrase_many(
                    "{count} cut was predicted before; see 'autodb predictions score'",
                    "{count} cuts were predicted before; see 'autodb predictions score'",
                    self.predicted,
                )
            )
        said += self.asked
        said += [phrase("calibration due: {what}", what=said_again(one)) for one in self.due]
        return said + self.retained


def _of_file(one: CameIn) -> str:
    if one.status == "refused":
        return phrase("{file}: refused: {why}", file=one.file, why=said_again(one.reason or ""))
    said = phrase(
        "{file}: recording {number}, {cuts} new cuts",
        file=one.file,
        number=one.recording,
        cuts=one.cuts,
    )
    return (
        phrase("{said}, {count} there already", said=said, count=one.again) if one.again else said
    )


def files_since(session: Session, machine_id: int) -> Sequence[models.InboxFile]:
    """Return the files of the inbox that no pass has reported."""
    query = select(models.InboxFile).where(
        models.InboxFile.machine_id == machine_id, models.InboxFile.refresh_pass_id.is_(None)
    )
    return session.scalars(query.order_by(models.InboxFile.id)).all()


def files_came_in(session: Session, files: Sequence[models.InboxFile], span: Span) -> list[CameIn]:
    """Return what became of files, with the cuts of a pass that they brought."""
    found = []
    for row in files:
        recording = row.recording_id and session.get_one(models.StoredRecording, row.recording_id)
        cuts = session.scalar(
            select(func.count())
            .select_from(models.Cut)
            .where(models.Cut.recording_id == row.recording_id, models.Cut.id > span.old)
        )
        name, new = Path(row.path).name, cuts or 0
        again = recording.rows - new if recording and recording.kind == "cuts" else 0
        found.append(CameIn(name, row.status, row.reason, row.recording_id, new, max(0, again)))
    return found


@dataclass(frozen=True)
class PassRecord:
    """A pass to be kept: what it did, over which cuts, by what, and the files that it reports.

    ``asked``: what it and those before it explained, and of what evidence.
    """

    done: RefreshReport
    span: Span
    basis: dict[str, Any]
    files: Sequence[models.InboxFile]
    asked: Sequence[Mapping[str, Any]] = ()


def keep_pass(session: Session, machine_id: int, kept: PassRecord) -> None:
    """Keep a pass and its report, with the mark that the next one goes on from."""
    done = kept.done
    row = models.RefreshPass(
        machine_id=machine_id,
        status="done",
        finished_at=models.now(),
        imported=sum(one.status == "imported" for one in done.came_in),
        sensed=done.sensed,
        not_sensed=done.not_sensed,
        versions=len(done.versions),
        report=asdict(done),
        last_cut_id=kept.span.upto,
        last_force_id=last_force(session),
        basis={**kept.basis, ASKED: list(kept.asked)},
    )
    session.add(row)
    session.flush()
    for file in kept.files:
        file.refresh_pass_id = row.id


@dataclass(frozen=True)
class KeptPass:
    """A pass that was kept: its number, when it ended, and what it did."""

    number: int
    finished_at: str
    done: RefreshReport


def last_pass(store: Store, machine: str) -> KeptPass:
    """Return a machine's last pass; raises UnusableInput where there is none."""
    with store.reading() as session:
        found = last_passes_of(session, find_machine(session, machine).id, most=1)
    if not found:
        raise UnusableInput(
            phrase(
                "machine '{machine}': no pass has left a report; run 'autodb refresh --machine "
                "{machine}'",
                machine=machine,
            )
        )
    return found[0]


def last_passes_of(session: Session, machine_id: int, *, most: int) -> list[KeptPass]:
    """Return those of a machine's last passes that left a report, the newest first."""
    rows = session.scalars(
        select(models.RefreshPass)
        .where(models.RefreshPass.machine_id == machine_id, models.RefreshPass.status == "done")
        .order_by(models.RefreshPass.id.desc())
        .limit(most)
    )
    return [
        KeptPass(row.id, str(row.finished_at), _as_refreshed(row.report))
        for row in rows
        if row.report is not None
    ]


def _as_refreshed(kept: dict[str, Any]) -> RefreshReport:
    return RefreshReport(
        **{
            **kept,
            "came_in": [CameIn(**one) for one in kept["came_in"]],
            "versions": [tuple(one) for one in kept["versions"]],
            "shifts": [ForceShift(**one) for one in kept["shifts"]],
        }
    )
