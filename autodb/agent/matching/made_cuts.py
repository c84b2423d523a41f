"""Stored predictions and the cuts that were then made: linked, or asked about where it is not sure.

A recording's cuts are those of the newest prediction of a job that was made before the recording:
of the job or program that they name, else of the only job of their pair that they fit
(``autodb.forward.matching``). What is not sure is left unlinked, in one line that says how to tell.
"""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.matching.asked_jobs import (
    AskedCuts,
    AskedJob,
    as_made,
    asked_jobs,
    newest_before,
)
from autodb.agent.rows.recordings import made_at
from autodb.errors import near
from autodb.forward.matching import Match, matched
from autodb.store import models
from autodb.store.models.answers import BY_CONDITIONS, BY_NAME

Link = models.PredictedCutMade
NEWEST = 50
"""Jobs of a pair that a cut may be of, the newest ones. Chosen: more than a machine has in work."""
AT_ONCE = 2000
"""Cuts of a recording that are looked at, the newest ones. Chosen: as many as a pass takes."""


@dataclass
class Matched:
    """What was linked, and in words what was not sure."""

    links: list[Link] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)


def match_new(session: Session, owner: models.Machine, *, after: int, upto: int) -> Matched:
    """Link a machine's cuts with ids above ``after`` up to ``upto`` that are not linked yet."""
    found = Matched()
    jobs = asked_jobs(session, owner.id) if upto > after else []
    if not jobs:
        return found
    for number in _recordings(session, owner.id, after, upto, since=jobs[-1].created_at):
        one = _Recording(session, owner, number, jobs)
        for cuts in one.groups():
            one.match(cuts, found)
    session.flush()
    return found


def _recordings(
    session: Session, machine_id: int, after: int, upto: int, *, since: str
) -> Sequence[int]:
    """Return the recordings, by id, with cuts to be linked."""
    row = models.StoredRecording
    query = (
        select(row.id)
        .join(models.Cut, models.Cut.recording_id == row.id)
        .outerjoin(Link, Link.cut_id == models.Cut.id)
        .where(
            row.machine_id == machine_id,
            row.imported_at >= since,
            models.Cut.id > after,
            models.Cut.id <= upto,
            models.counting_cut(models.Cut.superseded_at),
            Link.id.is_(None),
        )
    )
    return session.scalars(query.distinct().order_by(row.id)).all()


class _Recording:
    """The cuts of one recording that count, and the jobs that were predicted, the newest first."""

    def __init__(
        self, session: Session, owner: models.Machine, number: int, jobs: Sequence[AskedJob]
    ) -> None:
        self._session, self._owner, self._jobs = session, owner, jobs
        self._row = session.get_one(models.StoredRecording, number)
        newest = session.scalars(
            select(models.Cut)
            .where(models.Cut.recording_id == number, models.counting_cut(models.Cut.superseded_at))
            .order_by(models.Cut.id.desc())
            .limit(AT_ONCE)
        )
        self.cuts = sorted(newest, key=lambda cut: cut.number)
        ids = [cut.id for cut in self.cuts]
        self._linked = set(session.scalars(select(Link.cut_id).where(Link.cut_id.in_(ids))))

    def groups(self) -> Iterator[list[models.Cut]]:
        """Yield its cuts by what they say they are of, pair, job, program, and by what was asked
        for when they were made."""
        made = sorted(job.created_at for job in self._jobs)

        def key(cut: models.Cut) -> tuple[int, str, str, int]:
            said, before = cut.named or {}, bisect_right(made, made_at(cut))
            return cut.pair_id or 0, said.get("job", ""), said.get("program", ""), before

        for _, some in groupby(sorted(self.cuts, key=key), key):
            yield list(some)

    def match(self, cuts: list[models.Cut], found: Matched) -> None:
        """Link cuts of one pair and job, or ask."""
        candidates, why = self._candidates(cuts[0], newest_before(self._jobs, made_at(cuts[0])))
        if why is not None:
            found.asked.append(self._said(why))
        several = [_Fitted(self._session, job, cuts) for job in candidates]
        left = _undominated([one for one in several if one.fitting])
        for job in left:
            rivals = set().union(*(one.fitting for one in left if one is not job))
            self._link(job, cuts, job.fitting - rivals, found)
        shared = sorted(
            {k for one in left for k in one.fitting if sum(k in o.fitting for o in left) > 1}
        )
        shared = [k for k in shared if cuts[k].id not in self._linked]
        if shared:
            names = " or of ".join(one.job.words for one in left)
            remedy = f"{self._remedy('NUMBER')}, next time with job in the side file"
            found.asked.append(self._said(f"{_listed(cuts, shared)} may be of {names}: {remedy}"))

    def _candidates(
        self, cut: models.Cut, jobs: Sequence[AskedJob]
    ) -> tuple[list[AskedJob], str | None]:
        """Return the jobs that a cut may be of, and what is wrong with the one that it names."""
        said = cut.named or {}
        job, program = said.get("job"), said.get("program")
        called = [one for one in jobs if one.is_called(job, program)]
        pair = cut.pair and (cut.pair.material.name, cut.pair.tool.name)
        of_pair = [one for one in called if pair in (None, one.pair)]
        if of_pair or (job is None and program is None) or not jobs:
            return (of_pair[:NEWEST] if pair or job or program else []), None
        if called:
            other = " / ".join(called[0].pair)
            return [], f"{called[0].words} is for {other}, not for {' / '.join(pair or ())}"
        what = f"job '{job}'" if job is not None else f"program '{program}'"
        hint = near(job, dict.fromkeys(one.name for one in jobs)) if job is not None else ""
        return [], f"no prediction of {what} was made before it{hint}"

    def _link(self, one: "_Fitted", cuts: list[models.Cut], own: set[int], found: Matched) -> None:
        """Link the cuts that only this job fits, and ask about those that are several of it."""
        free = [k for k in sorted(own) if cuts[k].id not in self._linked]
        knew = one.asked.knew([cuts[k].id for k in free])
        for k in free:
            match = one.matches[k]
            if match.place is not None and cuts[k].id not in knew:
                by = BY_NAME if match.by_name else BY_CONDITIONS
                found.links.append(linked(self._session, one.asked, match.place, cuts[k], by=by))
        for places, some in _by_places(one.matches, free):
            names = " or ".join(f"'{one.asked.called(place)}'" for place in places)
            remedy = self._remedy(f"{one.job.prediction} --cut NUMBER=NAME")
            text = f"{_listed(cuts, some)} may be {names} of {one.job.words}: {remedy}"
            found.asked.append(self._said(f"{text}, next time in a column job.cut"))
        unknown = [k for k, cut in enumerate(cuts) if _names_none(cut, one.matches[k])]
        if unknown and (cuts[0].named or {}).get("job"):
            said = as_made(cuts[unknown[0]])
            what = f"cut '{said.name}'" if said.name is not None else f"line {said.block:g}"
            hint = near(said.name, [c.name for c in one.asked.cuts]) if said.name else ""
            found.asked.append(self._said(f"{one.job.words} has no {what}{hint}"))

    def _said(self, text: str) -> str:
        return f"recording {self._row.id}: {text}"

    def _remedy(self, which: str) -> str:
        return (
            f"say which with 'autodb predictions match --machine {self._owner.name} --recording "
            f"{self._row.id} --prediction {which}'"
        )


class _Fitted:
    """A job beside cuts: which of them may be of it, and what each may be."""

    def __init__(self, session: Session, job: AskedJob, cuts: Sequence[models.Cut]) -> None:
        self.job, self.asked = job, AskedCuts(session, job.prediction)
        self.matches = matched(self.asked.cuts, [as_made(cut) for cut in cuts])
        self.fitting = {k for k, match in enumerate(self.matches) if match.places}


def _undominated(several: Sequence[_Fitted]) -> list[_Fitted]:
    """Return the jobs but those of which another one explains all cuts, and more."""
    return [one for one in several if not any(one.fitting < other.fitting for other in several)]


def _names_none(cut: models.Cut, match: Match) -> bool:
    """Say whether a cut names what its job does not have."""
    return as_made(cut).says and not match.places


def _by_places(
    matches: Sequence[Match], some: Iterable[int]
) -> Iterator[tuple[tuple[int, ...], list[int]]]:
    """Yield cuts that may have the same several places in a job, with these places."""
    open_: dict[tuple[int, ...], list[int]] = {}
    for k in some:
        if len(matches[k].places) > 1:
            open_.setdefault(matches[k].places, []).append(k)
    yield from open_.items()


def _listed(cuts: Sequence[models.Cut], some: Sequence[int]) -> str:
    numbers = ", ".join(f"{cuts[k].number:g}" for k in some)
    return f"cut {numbers}" if len(some) == 1 else f"cuts {numbers}"


def linked(session: Session, asked: AskedCuts, place: int, cut: models.Cut, *, by: str) -> Link:
    """Link a cut with the place that it has in a predicted job; return the new row."""
    row = Link(
        prediction_id=asked.row.id,
        number=place + 1,
        name=asked.called(place),
        cut_id=cut.id,
        matched_by=by,
        expected=asked.expected(place, as_made(cut)),
    )
    session.add(row)
    return row
