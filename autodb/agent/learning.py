"""What the newest forces of one pair change: its belief, its process states, what stands aside."""

from dataclasses import dataclass, field

from sqlalchemy.orm import Session

from autodb.agent.beliefs import (
    Start,
    as_belief,
    chain,
    columns_of,
    latest,
    newest_version,
    pair_name,
    start_of,
)
from autodb.agent.felt import Felt, as_observed
from autodb.agent.states import Forces, looked_at, named_states, sorted_out, states_of
from autodb.errors import UnusableInput
from autodb.pairs.learning import learn, learn_choosing
from autodb.pairs.prior import of_state
from autodb.store import models

AT_ONCE = 200
"""Cuts of a pair up to which all of them are learnt at once when there are new ones; beyond, the
new ones change the belief. Chosen: a second's work."""


@dataclass
class Outcome:
    """``versions``: pair and state, version, cuts behind it; ``odd``: cuts that stand aside, by id;
    ``set_aside``: what to say of what was not learnt from.
    """

    versions: list[tuple[str, int, int]] = field(default_factory=list)
    odd: list[int] = field(default_factory=list)
    set_aside: list[str] = field(default_factory=list)


def learn_pair(session: Session, machine_id: int, found: Felt) -> Outcome:
    """Add versions where a pair has forces that its last ones have not seen.

    A version builds on the last one where that one's forces all count still.
    """
    return _Pair(session, machine_id, found).learnt()


class _Pair:
    """One pair on one machine, and the forces that count of it."""

    def __init__(self, session: Session, machine_id: int, found: Felt) -> None:
        self._session, self._machine_id, self._found = session, machine_id, found
        self._name = pair_name(found.pair)
        self._done = Outcome()

    def learnt(self) -> Outcome:
        """Learn the usual state and those confirmed; say what was left out or stands aside."""
        said = self._done.set_aside
        for reason, cuts in self._found.left_out.items():
            said.append(f"{self._name}: {cuts} cuts not learnt from: {reason}")
        try:
            self._other_states(self._usual_state())
        except UnusableInput as error:
            said.append(f"{self._name}: {error}")
        if self._done.odd:
            said.append(
                f"{self._name}: {len(self._done.odd)} cuts are not of its usual state (less "
                "probable than 1 in 1000) and do not change it"
            )
        return self._done

    def _latest(self, state: str | None = None) -> models.CuttingParameters | None:
        return latest(self._session, self._machine_id, self._found.pair.id, state)

    def _usual_state(self) -> Forces:
        """Learn what is of the usual state; return the forces of no state yet."""
        states = states_of(self._session, self._machine_id, self._found.pair.id)
        elsewhere = {force_id for state in states for force_id in seen_by(state)}
        forces = [force for force in self._found.forces if force.id not in elsewhere]
        base = self._still_counting(self._latest(), forces)
        seen = seen_by(base)
        fresh = [force for force in forces if force.id not in seen]
        if not fresh:
            return []
        pair = self._found.pair
        start = start_of(self._session, self._machine_id, pair.material.name, pair.tool.name)
        looked = looked_at(self._session, [force for force in forces if force.id in seen])
        belief = start.belief if base is None else as_belief(base)
        parted = sorted_out(belief, fresh, looked=looked)
        self._add(start, base, parted.usual)
        return parted.odd

    def _other_states(self, odd: Forces) -> None:
        """Learn states from cuts whose cause was confirmed; note the cuts that stand aside."""
        usual = self._latest()
        states = named_states(self._session, odd) if usual is not None else {}
        for name, fresh in states.items():
            assert usual is not None  # without one there is no other state
            start = Start(of_state(as_belief(usual)), f"the usual state, version {usual.version}")
            base = self._still_counting(self._latest(name), self._found.forces)
            self._add(start, base, fresh, name)
        named = {force.cut_id for forces in states.values() for force in forces}
        self._done.odd += sorted({force.cut_id for force in odd} - named)

    def _still_counting(
        self, last: models.CuttingParameters | None, forces: Forces
    ) -> models.CuttingParameters | None:
        """Return a version whose forces all count still, else None."""
        return last if seen_by(last) <= {force.id for force in forces} else None

    def _add(
        self,
        start: Start,
        base: models.CuttingParameters | None,
        fresh: Forces,
        state: str | None = None,
    ) -> None:
        """Add a version that has learnt ``fresh`` beside what ``base`` has."""
        if not fresh:
            return
        seen = seen_by(base)
        before = [force for force in self._found.forces if force.id in seen]
        known = {force.cut_id for force in before}
        if base is not None and len(known) >= AT_ONCE:
            start = Start(as_belief(base), base.started_from, base.relative)
            learnt = learn(start.belief, as_observed(fresh, known=known)).past()
        else:
            learnt = learn_choosing(start.belief, as_observed([*before, *fresh])).past()
        version = newest_version(self._session, self._machine_id, self._found.pair.id) + 1
        self._session.add(
            models.CuttingParameters(
                machine_id=self._machine_id,
                pair_id=self._found.pair.id,
                version=version,
                state=state,
                started_from=start.said,
                relative=start.row,
                previous=base,
                forces=fresh,
                **columns_of(learnt),
            )
        )
        self._session.flush()
        name = self._name if state is None else f"{self._name}, {state}"
        self._done.versions.append((name, version, learnt.cuts))


def seen_by(parameters: models.CuttingParameters | None) -> set[int]:
    """Return the sensed forces that a version and those before it learnt from."""
    versions = [] if parameters is None else chain(parameters)
    return {force.id for version in versions for force in version.forces}
