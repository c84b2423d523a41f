"""What the newest forces of a pair change: its posterior, its process states, what is excluded."""

from collections.abc import Callable, Collection, Container, Sequence
from dataclasses import dataclass, field, replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.learn.confirmed_terms import (
    held_causes,
    learn_with,
    opened,
    terms_after,
    to_learn,
)
from autodb.agent.learn.learnt_from import newest_states
from autodb.agent.learn.shifted import ForceShift, shifts
from autodb.agent.learn.starting import start_of
from autodb.agent.learn.states import (
    Forces,
    HarderCuts,
    causes_of,
    learnt_before,
    named_states,
    outlying_cuts,
    sorted_forces,
)
from autodb.agent.rows.mismatches import recordings_of
from autodb.agent.rows.posteriors import (
    Start,
    as_posterior,
    began,
    begins,
    chain_ids,
    latest,
    newest_version,
    pair_name,
    posterior_columns,
)
from autodb.agent.rows.recorded_edges import cut_before_s
from autodb.agent.rows.sensed_forces import PairForces
from autodb.agent.sense.sensed import as_observed
from autodb.errors import UnusableInput
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.engaged import CUTTING_TIME
from autodb.pairs.posterior import PairPosterior, PairTerms
from autodb.pairs.prior import of_state
from autodb.pairs.updating import posterior_of_readings
from autodb.store import models
from autodb.wording import stored_msgid

ROUNDS = 2
"""Rounds in which worn cuts are tested for those that are not of the state with wear either: the
second finds those that only others, which it leaves out, had made so. Chosen."""
AT_ONCE = 200
"""Cuts of a pair up to which all of them are learnt at once when there are new ones; beyond, the
new ones change the posterior. Chosen: some seconds' work."""
IN_TURN = 1000
"""Cuts that are learnt at once where more are new: the equations grow with them. Chosen."""
NOT_USED = stored_msgid("{pair}: {count} cuts are not used: {why}")
OUTLIERS = stored_msgid(
    "{pair}: {count} cuts are outliers from its normal cutting state (probability below 1 in 1000) "
    "and do not change its parameters"
)
OUTLIER = stored_msgid(
    "{pair}: 1 cut is an outlier from its normal cutting state (probability below 1 in 1000) and "
    "does not change its parameters"
)
WITHOUT_TIME = stored_msgid("its edges wear, and the cuts do not state {channel}")
AT_CUT = stored_msgid("{pair}: cut {k} of {n}")
FROM_NORMAL = stored_msgid("the normal cutting state, version {version}")


@dataclass
class LearningOutcome:
    """``versions``: pair and state, version, cuts behind it; ``outliers``: outlying cuts, by id;
    ``harder``: those of harder work, by recording; ``not_used``: what to say of what was not learnt
    from; ``shifts``: what a version moved.
    """

    versions: list[tuple[str, int, int]] = field(default_factory=list)
    outliers: list[int] = field(default_factory=list)
    harder: list[HarderCuts] = field(default_factory=list)
    not_used: list[str] = field(default_factory=list)
    shifts: list[ForceShift] = field(default_factory=list)


def learn_pair(
    session: Session,
    machine_id: int,
    found: PairForces,
    *,
    old: int | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> LearningOutcome:
    """Add versions where a pair has forces that its last ones have not seen, or a confirmed cause.

    A version builds on the last one where that one's forces all count still; one with a cause that
    the last had not stands alone. ``old``: the last cut, by id, that was examined before; None:
    all were.
    """
    pair = _Pair(session, machine_id, found, progress)
    return pair.learnt(old)


class _Pair:
    """One pair on one machine, and the forces that count of it."""

    def __init__(
        self,
        session: Session,
        machine_id: int,
        found: PairForces,
        progress: Callable[[str], None],
    ) -> None:
        self._session, self._machine_id, self._found = session, machine_id, found
        self._name, self._progress = pair_name(found.pair), progress
        self._old: int | None = None
        self._done = LearningOutcome()

    def learnt(self, old: int | None) -> LearningOutcome:
        """Learn the usual state and those confirmed; say what is not used or an outlier."""
        self._old = old
        said = self._done.not_used
        for reason, cuts in self._found.left_out.items():
            said.append(NOT_USED.format(pair=self._name, count=cuts, why=reason))
        try:
            if self._found.after:
                self._done.outliers += sorted({force.cut_id for force in self._new_ones()})
            else:
                self._with_terms()
                self._other_states(self._usual_state())
        except UnusableInput as error:
            said.append(f"{self._name}: {error}")
        if self._done.outliers:
            count = len(self._done.outliers)
            said.append((OUTLIER if count == 1 else OUTLIERS).format(pair=self._name, count=count))
        return self._done

    def _latest(self, state: str | None = None) -> models.CuttingParameters | None:
        return latest(self._session, self._machine_id, self._found.pair.id, state)

    def _with_terms(self) -> None:
        """Add a version with the causes in it that were confirmed and that the last one has not.

        It is fitted anew, from the cuts that the last has learnt and those of the recordings that
        the causes were found in; but those of them that are not of the normal cutting state with
        these causes either.
        """
        last = self._latest()
        causes = held_causes(self._session, self._found.forces)
        if last is None or not causes:
            return
        new = [one for one in causes if one not in last.mismatches]
        if not new:
            return
        if all(_is_known(one, last.mismatches) for one in new):
            last.mismatches = causes
            return
        seen, terms = seen_by(self._session, last), as_posterior(last).terms
        usual = self._but_of_states(but={str(one.confirmed_term) for one in causes})
        forces = to_learn(causes, usual, seen, terms)
        start = self._start(causes)
        learnt = learn_with(
            causes, start.posterior, forces, last=as_posterior(last), progress=self._progress
        )
        before = replace(start.posterior, off_law=as_posterior(last).off_law, terms=learnt.terms)
        kept = forces
        for _ in range(ROUNDS):
            outlying = outlying_cuts(learnt.past(), forces)
            now = [force for force in forces if force.id in seen or force.cut_id not in outlying]
            if now == kept:
                break
            kept, near = now, learnt
            observed = as_observed(kept, terms=learnt.terms)
            learnt = posterior_of_readings(before, observed, near=near)
        self._keep(start, None, kept, learnt.past(), causes=causes)

    def _start(self, causes: Sequence[models.Mismatch] = ()) -> Start:
        """Return where the pair starts; with the numbers of the law opened that causes are of."""
        pair = self._found.pair
        start = start_of(self._session, self._machine_id, pair.material.name, pair.tool.name)
        wider = opened(start.posterior, causes)
        if wider is start.posterior or start.said is None:
            return start
        return begins(wider, start.said, start.row, start.prior)

    def _new_ones(self) -> Forces:
        """Learn new cuts that are of the usual state; return the forces of the others.

        Nothing that was learnt or decided before is examined.
        """
        last = self._latest()
        assert last is not None  # without a version no cut of a pair is old
        posterior, forces = as_posterior(last), self._found.forces
        if posterior.wear is not None:
            forces = self._of_known_wear(forces)
        parted = sorted_forces(posterior, forces)
        if parted.usual:
            start = began(last)
            learnt = self._in_turn(posterior, parted.usual)
            self._keep(start, last, parted.usual, learnt, causes=last.mismatches)
        self._done.harder += parted.harder
        return parted.outliers

    def _usual_state(self) -> Forces:
        """Learn what is of the usual state; return the forces of no state yet."""
        last = self._latest()
        causes = [] if last is None else last.mismatches
        held = {str(one.confirmed_term) for one in causes}
        terms = PairTerms() if last is None else as_posterior(last).terms
        forces = self._but_of_states(but=held)
        if terms.wear is not None:
            forces = self._of_known_wear(forces)
        base = self._still_counting(last, forces)
        seen = seen_by(self._session, base)
        fresh = [force for force in forces if force.id not in seen]
        if not fresh:
            return []
        start = self._start(causes)
        start = replace(start, posterior=replace(start.posterior, terms=terms))
        before = learnt_before(
            self._session,
            [force for force in forces if force.id in seen],
            among=forces,
            held=held,
            old=self._old,
        )
        posterior = start.posterior if base is None else as_posterior(base)
        parted = sorted_forces(posterior, fresh, before=before)
        self._add(start, base, parted.usual, causes=causes)
        self._done.harder += parted.harder
        return parted.outliers

    def _but_of_states(self, *, but: Collection[str]) -> Forces:
        """Return the forces that no other state than those of ``but`` has learnt."""
        states = newest_states(self._session, self._machine_id, self._found.pair.id)
        elsewhere = {
            n for state in states if state.state not in but for n in seen_by(self._session, state)
        }
        return [force for force in self._found.forces if force.id not in elsewhere]

    def _of_known_wear(self, forces: Forces) -> Forces:
        """Return the forces of cuts that say how worn their edge was; say how many do not."""
        kept = [force for force in forces if cut_before_s(force.cut) is not None]
        cuts = {force.cut_id for force in forces} - {force.cut_id for force in kept}
        if cuts:
            self._done.not_used.append(
                NOT_USED.format(
                    pair=self._name, count=len(cuts), why=WITHOUT_TIME.format(channel=CUTTING_TIME)
                )
            )
        return kept

    def _other_states(self, outliers: Forces) -> None:
        """Learn states from cuts whose cause was confirmed; note the other outliers."""
        usual = self._latest()
        states = named_states(self._session, outliers) if usual is not None else {}
        for cause in [] if usual is None else usual.mismatches:
            states.pop(str(cause.confirmed_term), None)
        for name, fresh in states.items():
            assert usual is not None  # without one there is no other state
            start = begins(of_state(as_posterior(usual)), FROM_NORMAL.format(version=usual.version))
            base = self._still_counting(self._latest(name), self._found.forces)
            known = seen_by(self._session, base)
            cuts = [*fresh, *(force for force in self._found.forces if force.id in known)]
            self._add(start, base, fresh, name, causes_of(self._session, cuts, [name]))
        named = {force.cut_id for forces in states.values() for force in forces}
        self._done.outliers += sorted({force.cut_id for force in outliers} - named)

    def _still_counting(
        self, last: models.CuttingParameters | None, forces: Forces
    ) -> models.CuttingParameters | None:
        """Return a version whose forces all count still, else None."""
        return last if seen_by(self._session, last) <= {force.id for force in forces} else None

    def _add(
        self,
        start: Start,
        base: models.CuttingParameters | None,
        fresh: Forces,
        state: str | None = None,
        causes: Sequence[models.Mismatch] = (),
    ) -> None:
        """Add a version that has learnt ``fresh`` beside what ``base`` has."""
        if not fresh:
            return
        seen = seen_by(self._session, base)
        before = [force for force in self._found.forces if force.id in seen]
        known = {force.cut_id for force in before}
        if base is not None and len(known) >= AT_ONCE:
            start = began(base)
            learnt = self._in_turn(start.posterior, fresh, known=known)
        elif len({force.cut_id for force in fresh}) > IN_TURN:
            every = sorted([*before, *fresh], key=lambda force: force.cut_id)
            learnt = self._in_turn(start.posterior, every)
        else:
            start = self._as_bent_now(start, [*before, *fresh], state)
            observed = as_observed([*before, *fresh], terms=start.posterior.terms)
            learnt = learn_averaging(start.posterior, observed).past()
        self._keep(start, base, fresh, learnt, state=state, causes=causes)

    def _as_bent_now(self, start: Start, forces: Forces, state: str | None) -> Start:
        """Return a start whose wear and band have the shapes that all forces say.

        About as the last version has them; of versions without either, and of other states, as is.
        """
        last = self._latest(state)
        if last is None or state is not None:
            return start
        terms = terms_after(start.posterior, forces, near=as_posterior(last))
        return replace(start, posterior=replace(start.posterior, terms=terms))

    def _in_turn(
        self, posterior: PairPosterior, forces: Forces, *, known: Container[int] = ()
    ) -> PairPosterior:
        """Return a posterior after forces, IN_TURN cuts at once; ``known``: as in as_observed."""
        cuts = list(dict.fromkeys(force.cut_id for force in forces))
        for begin in range(0, len(cuts), IN_TURN):
            some = set(cuts[begin : begin + IN_TURN])
            observed = as_observed(
                [force for force in forces if force.cut_id in some],
                terms=posterior.terms,
                known=known,
            )
            taught = posterior_of_readings if posterior.cuts else learn_averaging
            posterior = taught(posterior, observed).past()
            self._progress(AT_CUT.format(pair=self._name, k=begin + len(some), n=len(cuts)))
        return posterior

    def _keep(
        self,
        start: Start,
        base: models.CuttingParameters | None,
        fresh: Forces,
        learnt: PairPosterior,
        *,
        state: str | None = None,
        causes: Sequence[models.Mismatch] = (),
    ) -> None:
        name = self._name if state is None else f"{self._name}, {state}"
        before = self._latest(state)
        if before is not None:
            self._done.shifts += shifts(name, as_posterior(before), learnt, fresh)
        version = newest_version(self._session, self._machine_id, self._found.pair.id) + 1
        self._session.add(
            models.CuttingParameters(
                machine_id=self._machine_id,
                pair_id=self._found.pair.id,
                version=version,
                state=state,
                previous=base,
                forces=fresh,
                mismatches=list(causes),
                **start.columns,
                **posterior_columns(learnt),
            )
        )
        self._session.flush()
        self._done.versions.append((name, version, learnt.cuts))


def _is_known(cause: models.Mismatch, known: Sequence[models.Mismatch]) -> bool:
    """Say whether a cause is one that a version holds, found again in another component."""
    alike = [
        one for one in known if (one.confirmed_term, one.lot) == (cause.confirmed_term, cause.lot)
    ]
    return recordings_of([cause]) <= recordings_of(alike)


def seen_by(session: Session, parameters: models.CuttingParameters | None) -> set[int]:
    """Return the sensed forces that a version and those before it learnt from."""
    if parameters is None:
        return set()
    seen = models.cutting_parameters_force.c
    chain = seen.cutting_parameters_id.in_(chain_ids([parameters]))
    return set(session.scalars(select(seen.sensed_force_id).where(chain)))
