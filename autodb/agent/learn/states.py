"""Process states: cuts that are not of a pair's usual state are kept out of it, and named.

The same inputs can cut in another state: a built-up edge, a worn edge, an inclusion. A cut whose
forces are less probable than 1 in 1000 (``autodb.pairs.outlying``) does not bend the pair. Its
recording is explained against what was expected; where a person confirms the cause, and enough of
its cuts are excluded, they become a state of the pair with a posterior of its own.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from autodb.agent.rows.mismatches import is_cause, recordings_of
from autodb.agent.rows.recorded_edges import cut_before_s
from autodb.agent.sense.sensed import as_observed
from autodb.explain.engine.candidates import UNKNOWN
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.changes.harder_work import HarderWork, harder_work
from autodb.pairs.outlying import outlier_test
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.updating import posterior_of_readings
from autodb.store import models

ENOUGH = 8
"""Cuts that a posterior rests on before it takes others for outliers. Chosen."""
PERSISTS = 5
"""Cuts that make a state. Chosen."""
Forces = list[models.SensedForce]


@dataclass(frozen=True)
class HarderCuts:
    """Cuts of one recording, in their order, all of whose forces are larger by a share."""

    cuts: list[models.Cut]
    work: HarderWork


@dataclass(frozen=True)
class SortedForces:
    """Forces of a pair's usual state, those of cuts that are not of it, and which are harder."""

    usual: Forces
    outliers: Forces
    harder: list[HarderCuts]


@dataclass(frozen=True)
class LearntBefore:
    """Recordings, by id, of which cuts were learnt before: their other cuts were excluded,
    and still are, but where they are ``cleared`` by a person who rejected every cause.

    ``learnt``: those cuts, by id; another of their forces may be new. Cuts behind ``old``, by id,
    came to a recording since then; None: no cut did.
    """

    begun: Collection[int] = ()
    learnt: Collection[int] = ()
    cleared: Collection[int] = ()
    old: int | None = None

    def decides(self, force: models.SensedForce) -> bool:
        """Say whether it is decided already if a force's cut is of the usual state."""
        recording = force.cut.recording_id
        before = self.old is None or force.cut_id <= self.old
        return recording in self.cleared or (recording in self.begun and before)

    def still_excluded(self, force: models.SensedForce) -> bool:
        """Say whether a force's cut was excluded, and still is."""
        cleared = force.cut.recording_id in self.cleared
        return self.decides(force) and not cleared and force.cut_id not in self.learnt


def learnt_before(
    session: Session,
    seen: Sequence[models.SensedForce],
    *,
    among: Sequence[models.SensedForce],
    held: Collection[str] = (),
    old: int | None = None,
) -> LearntBefore:
    """Return what became of the recordings of forces that were learnt (``seen``), ``among`` all.

    Those that a term was confirmed for which the posterior has (``held``) are examined anew.
    ``old``: the last cut, by id, that was examined; None: all were.
    """
    recordings = {force.cut.recording_id for force in seen}
    causes = [(row, one.id) for row in _found_in_forces(session, among) for one in row.recordings]
    holds = {recording for row, recording in causes if row.status != "rejected"}
    cleared = {recording for _, recording in causes} - holds
    anew = {recording for row, recording in causes if row.confirmed_term in held}
    return LearntBefore(recordings - anew, {force.cut_id for force in seen}, cleared, old)


def _found_in_forces(
    session: Session, forces: Sequence[models.SensedForce], *conditions: ColumnElement[bool]
) -> Sequence[models.Mismatch]:
    """Return the mismatches of a pair that were found in recordings of its forces, oldest first."""
    pair = next((force.cut.pair for force in forces if force.cut.pair is not None), None)
    if pair is None:
        return []
    recordings = {force.cut.recording_id: force.cut.recording for force in forces}
    machine_id = next(iter(recordings.values())).machine_id
    query = (
        select(models.Mismatch)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == machine_id,
            models.Mismatch.of_pair(pair.id),
            models.Mismatch.channel.startswith("force."),
            *conditions,
        )
    )
    rows = session.scalars(query.order_by(models.Mismatch.id))
    return [row for row in rows if is_cause(row) and recordings.keys() & recordings_of([row])]


def causes_of(
    session: Session, forces: Sequence[models.SensedForce], terms: Collection[str]
) -> Sequence[models.Mismatch]:
    """Return the mismatches confirmed as one of some terms that were found in a pair's forces."""
    confirmed = models.Mismatch.status == "confirmed"
    return _found_in_forces(session, forces, confirmed, models.Mismatch.confirmed_term.in_(terms))


def sorted_forces(
    start: PairPosterior,
    forces: Sequence[models.SensedForce],
    *,
    before: LearntBefore | None = None,
) -> SortedForces:
    """Return which forces are of the usual state, learnt recording by recording from ``start``.

    The first recordings of a pair, up to ENOUGH cuts, are what its usual state is. Raises
    UnusableInput where the pair's tool cannot make the cuts.
    """
    known = before or LearntBefore()
    posterior, kept, outliers, usual = start, Forces(), Forces(), Forces()
    harder: list[HarderCuts] = []
    for some in _by_recording(forces):
        if usual:  # of the recording before; nobody asks for what the last of them would teach
            taught = posterior_of_readings if posterior.cuts else learn_averaging
            posterior = taught(posterior, as_observed(usual, terms=posterior.terms)).past()
        outlying = {force.cut_id for force in some if known.still_excluded(force)}
        rest = [force for force in some if not known.decides(force)]
        if rest and posterior.cuts >= ENOUGH:
            outlying |= outlying_cuts(posterior, rest)
            work = harder_cuts(posterior, rest)
            harder += [] if work is None else [work]
            outlying |= set() if work is None else {cut.id for cut in work.cuts}
        usual = [force for force in some if force.cut_id not in outlying]
        outliers += [force for force in some if force.cut_id in outlying]
        kept += usual
    return SortedForces(kept, outliers, harder)


def _by_recording(forces: Sequence[models.SensedForce]) -> list[Forces]:
    found: dict[int, Forces] = {}
    for force in forces:
        found.setdefault(force.cut.recording.first_id, []).append(force)
    return list(found.values())


def outlying_cuts(posterior: PairPosterior, forces: Forces) -> set[int]:
    """Return the cuts, by id, that are not of a posterior's state."""
    observed = as_observed(forces, terms=posterior.terms)
    cut_ids = {int(at): force.cut_id for at, force in zip(observed.cut, forces, strict=False)}
    found = outlier_test(posterior, observed)
    return {cut_ids[k] for k, improbable in enumerate(found.outlying) if improbable}


def harder_cuts(posterior: PairPosterior, forces: Forces) -> HarderCuts | None:
    """Return one recording's cuts where they are harder than expected; None: they are not, or not
    all say how long their edges have cut.
    """
    cuts = list({force.cut_id: force.cut for force in forces}.values())
    if any(cut_before_s(cut) is None for cut in cuts):
        return None
    work = harder_work(posterior, as_observed(forces, terms=posterior.terms))
    return None if work is None else HarderCuts(cuts, work)


def named_states(session: Session, outliers: Forces) -> dict[str, Forces]:
    """Return the outlying cuts by the cause that was confirmed for their recording.

    Only where there are PERSISTS of them.
    """
    confirmed = _found_in_forces(
        session,
        outliers,
        models.Mismatch.status == "confirmed",
        models.Mismatch.confirmed_term != UNKNOWN,
    )
    states: dict[str, Forces] = {}
    for row in confirmed:
        name, recordings = str(row.confirmed_term), recordings_of([row])
        own = [force for force in outliers if force.cut.recording_id in recordings]
        states[name] = [*states.get(name, []), *(f for f in own if f not in states.get(name, []))]
    return {
        name: forces
        for name, forces in states.items()
        if len({force.cut_id for force in forces}) >= PERSISTS
    }
