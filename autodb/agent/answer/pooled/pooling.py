"""Cuts of several recordings, explained together: on one clock, with each edge under its name.

A shop's files are small, and wear grows over weeks: what no file shows alone, all show.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from sqlalchemy.orm import Session

from autodb.agent.answer.explaining import Stamps, expected_and_sensed, explain_recording
from autodb.agent.rows.mismatches import is_cause
from autodb.agent.rows.posteriors import pair_name
from autodb.agent.rows.recorded_edges import cut_before_s
from autodb.agent.rows.recordings import counted_cuts, stated_start
from autodb.agent.rows.sensed_forces import operation_of, usable
from autodb.errors import UnusableInput
from autodb.explain import Explained, explain
from autodb.records.tables import CutTable
from autodb.store import models
from autodb.wording import phrase

EXPLAINED = 10
"""Cuts from which on their differences are explained. Chosen."""
DAY_S = 86400.0
"""What is left between recordings of which nobody says when they were made. Chosen: a night."""


@dataclass(frozen=True)
class PooledCuts:
    """Cuts that are explained together. ``pair``: whose they are; None: all of one recording.

    ``excluded``: the cuts, by id, that are not of their pair's normal cutting state. ``about``: the
    term that all cuts together show, and that they are explained for; None: all of them.
    """

    pair: models.Pair | None
    cuts: list[models.Cut]
    excluded: frozenset[int]
    about: str | None = None

    @cached_property
    def recordings(self) -> list[models.StoredRecording]:
        """The recordings of the cuts, in the order in which they came in."""
        found = {cut.recording_id: cut.recording for cut in self.cuts}
        return [found[number] for number in sorted(found)]

    @property
    def called(self) -> str:
        """What is explained, in words."""
        if self.pair is None or len(self.recordings) == 1:
            return self.recordings[0].path
        return f"{pair_name(self.pair)}, {len(self.cuts)} cuts of {len(self.recordings)} recordings"

    def explainable(self, session: Session, owner: models.Machine) -> "ExplainableCuts | None":
        """Return what is explained of the cuts; None: too few of them, or none sensed."""
        cuts = self.cuts if self.pair is None else self._alike()
        if len(cuts) < EXPLAINED:
            return None
        stamps = common_stamps(cuts) if len(self.recordings) > 1 else None
        try:
            return ExplainableCuts(*expected_and_sensed(session, owner, cuts, stamps=stamps))
        except UnusableInput:
            return None

    def _alike(self) -> list[models.Cut]:
        """Return cuts of one operation, of whose edges all say how long they have cut, or none.

        What is not known of every cut, an explanation cannot use of any. Of those with most
        excluded cuts, else of those that say it, else the most.
        """
        kinds: dict[tuple[str, bool], list[models.Cut]] = {}
        for cut in self.cuts:
            says = cut_before_s(cut) is not None
            kinds.setdefault((operation_of(cut), says), []).append(cut)

        def first(kind: tuple[str, bool]) -> tuple[int, bool, int]:
            own = kinds[kind]
            return sum(cut.id in self.excluded for cut in own), kind[1], len(own)

        return kinds[max(kinds, key=first)] if kinds else []


@dataclass(frozen=True)
class ExplainableCuts:
    """What was ``sensed`` in cuts, and ``expected`` of them with the terms that it ``includes``."""

    sensed: CutTable
    expected: CutTable
    includes: list[str]

    def explained(self) -> Explained:
        """Explain what was sensed by what is missing in what was expected."""
        return explain(self.sensed, self.expected, includes=self.includes)


def common_stamps(cuts: Sequence[models.Cut]) -> Stamps:
    """Return number and time of cuts of several recordings, on a clock that they share.

    Numbers that go on from recording to recording stay; else the cuts are counted from 1.
    """
    began_s = _began_s(cuts)
    at = {cut.id: began_s[cut.recording_id] + _time_s(cut) for cut in cuts}
    order = sorted(cuts, key=lambda cut: (at[cut.id], cut.recording_id, cut.number))
    numbers = [cut.number for cut in order]
    if any(later <= earlier for earlier, later in pairwise(numbers)):
        numbers = [float(number) for number in range(1, len(order) + 1)]
    return {cut.id: (number, at[cut.id]) for cut, number in zip(order, numbers, strict=True)}


def _began_s(cuts: Sequence[models.Cut]) -> dict[int, float]:
    """Return what to add to the times of each recording's cuts, s, by its id.

    By the start that all of their side files state; else nothing, where their times follow each
    other as they came in; else they are laid one behind the other, a day apart.
    """
    rows = {cut.recording_id: cut.recording for cut in sorted(cuts, key=lambda c: c.recording_id)}
    started = {number: stated_start(row) for number, row in rows.items()}
    known = {number: start.timestamp() for number, start in started.items() if start is not None}
    if len(known) == len(rows):
        return {number: at - min(known.values()) for number, at in known.items()}
    times = {
        number: [_time_s(cut) for cut in cuts if cut.recording_id == number] for number in rows
    }
    if all(max(times[one]) < min(times[after]) for one, after in pairwise(rows)):
        return dict.fromkeys(rows, 0.0)
    found, end = {}, -DAY_S
    for number, own in times.items():
        found[number] = end + DAY_S - min(own)
        end = found[number] + max(own)
    return found


def _time_s(cut: models.Cut) -> float:
    return float(cut.conditions.get("t", 0.0))


def cuts_of_pair(row: models.StoredRecording, pair: models.Pair) -> list[models.Cut]:
    """Return the usable cuts of a pair in a recording that count."""
    return [cut for cut in counted_cuts(row) if cut.pair_id == pair.id and usable(cut)]


def explain_mismatch(session: Session, row: models.Mismatch) -> Explained:
    """Explain what a mismatch was found in against the machine's models now; nothing is kept.

    Raises UnusableInput as ``explain_recording``, or where too few of its cuts count.
    """
    several = row.found_in is not None and len(row.recordings) > 1 and row.pairs
    if not several or not is_cause(row):
        return explain_recording(session, row.recording)
    owner = session.get_one(models.Machine, row.recording.machine_id)
    cuts = [cut for one in row.recordings for cut in cuts_of_pair(one, row.pairs[0])]
    found = PooledCuts(row.pairs[0], cuts, frozenset()).explainable(session, owner)
    if found is None:
        raise UnusableInput(
            phrase("mismatch {number}: too few of its cuts count and are sensed", number=row.id)
        )
    return found.explained()
