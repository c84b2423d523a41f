"""Learning what machines know together, and naming the machine that disagrees.

A pass adds the newest versions of pairs to their material's sums, and takes out those they replace.
A machine that disagrees with the others is named, and its pairs that do so stay out of the sums
until they agree.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np
from sqlalchemy import insert
from sqlalchemy.orm import Session

from autodb.agent.fleet.known_together import DisagreeingMachine, named_of
from autodb.agent.learn.shared_priors import (
    OwnCuts,
    PairVersion,
    as_kept,
    known_from,
    known_materials,
    machine_names,
    machines_of,
    newest_prior,
    own_cuts,
    pairs_in,
    sharing,
)
from autodb.agent.learn.starting import of_material
from autodb.agent.rows.posteriors import LAW, pair_name
from autodb.agent.sense.gain_check import standard_cut
from autodb.pairs.disagreeing import ComparedPair, DisagreementCause, compared, disagrees
from autodb.pairs.hierarchy import MANY, KnownMaterial, whole_law
from autodb.standard.protocol import CutProtocol
from autodb.store import Store, models, retried
from autodb.store.models.learning import EVERY, fleet_prior_parameters
from autodb.wording import phrase, phrase_many

Progress = Callable[[str], None]

FLEET = "fleet "
"""Whose rows a pass writes: no machine's name ends with a blank."""
MOST_EXCLUDED = 3
"""One in so many machines may be excluded from a material: most must agree. Chosen."""


@dataclass(frozen=True)
class SharedVersion:
    """What a pass left of a material: its version, how many machines and tools it is from."""

    material: str
    version: int
    machines: int
    tools: int


@dataclass
class SharedLearning:
    """What a pass did: the materials that have a new version, and the machines named now."""

    materials: list[SharedVersion] = field(default_factory=list)
    named: list[DisagreeingMachine] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return it in words, a line each."""
        said = [
            phrase(
                "{material}: version {version} from {machines}, {tools}",
                material=one.material, version=one.version,
                machines=phrase_many("{count} machine", "{count} machines", one.machines),
                tools=phrase_many("{count} tool", "{count} tools", one.tools)
            )
            for one in self.materials
        ]  # fmt: skip
        said = said or [phrase("nothing new for all machines together")]
        return [*said, *(one.words for one in self.named)]


def learn_fleet(
    store: Store, *, protocols: Sequence[CutProtocol] = (), progress: Progress = lambda _: None
) -> SharedLearning:
    """Bring what machines know together up to their newest versions.

    ``protocols``: standard cuts whose forces are known, beside those of the kit.
    """

    def one_pass() -> SharedLearning:
        with store.writing(FLEET) as session:
            return _Pass(session, protocols, progress).run()

    return retried(one_pass, progress)


@dataclass
class _Material:
    """One material in a pass: what is known, which pairs are in it, and which are excluded, by
    id; ``own_cuts`` reads the information of a version's own cuts.
    """

    row: models.Material
    prior: models.FleetPrior | None
    known: KnownMaterial
    own_cuts: Callable[[int], OwnCuts]
    inside: dict[int, PairVersion] = field(default_factory=dict)
    excluded: dict[int, PairVersion] = field(default_factory=dict)
    changed: set[int] = field(default_factory=set)

    @property
    def every(self) -> list[PairVersion]:
        """All pairs that are shared of it."""
        return [*self.inside.values(), *self.excluded.values()]

    def put(self, one: PairVersion) -> None:
        """Take a pair into the sums."""
        self.known = self.known.changed(one.tool, more=self.own_cuts(one.id).as_stated)
        self.inside[one.id] = one
        self.changed.add(one.id)

    def take_out(self, one: PairVersion) -> None:
        """Take a pair out of the sums."""
        del self.inside[one.id]
        self.known = self.known.changed(one.tool, less=self.own_cuts(one.id).as_stated)
        self.changed.add(one.id)

    def compared(self, one: PairVersion) -> ComparedPair:
        """Compare a pair with the others."""
        own = self.own_cuts(one.id)
        others = self.known
        if one.id in self.inside:
            others = others.without(one.tool, own.as_stated)
        return compared(
            own.as_sensed,
            as_stated=own.as_stated,
            others=others.pair(one.tool),
            rake_rad=float(np.radians(one.rake_deg or 0.0)),
        )


class _Pass:
    """One pass over all materials."""

    def __init__(
        self, session: Session, protocols: Sequence[CutProtocol], progress: Progress
    ) -> None:
        self._session, self._protocols, self._progress = session, protocols, progress
        self._read: dict[int, OwnCuts] = {}
        self._materials: list[_Material] = []

    def run(self) -> SharedLearning:
        """Bring the sums up to date, name who disagrees, and keep what is new."""
        versions = sharing(self._session)
        numbers = sorted(versions.keys() | known_materials(self._session))
        self._materials = [self._brought_up(one, versions.get(one, [])) for one in numbers]
        named = self._named()
        kept = [self._kept(one, named) for one in self._materials if one.changed and one.every]
        for one in self._materials:
            if one.prior is not None and (one.changed or not one.every):
                one.prior.known = None  # its sums are in the next, or nobody shares any
        return SharedLearning(kept, list(named.values()))

    def _own_cuts(self, version: int) -> OwnCuts:
        if version not in self._read:
            self._read[version] = own_cuts(self._session, version)
        return self._read[version]

    def _brought_up(self, number: int, versions: Sequence[PairVersion]) -> _Material:
        """Take a material's newest versions into its sums, and out what they replace."""
        row = self._session.get_one(models.Material, number)
        self._progress(f"what is known of {row.name}")
        prior, excluded = newest_prior(self._session, number), set()
        found = _Material(
            row, prior, KnownMaterial(of_material(row.name).posterior.law), self._own_cuts
        )
        if prior is not None and prior.known is not None:
            found.known, excluded = known_from(prior.known), set(prior.known["aside"])
            found.inside = {one.id: one for one in pairs_in(self._session, prior)}
        newest = {one.id: one for one in versions}
        for one in [one for one in found.inside.values() if one.id not in newest]:
            found.take_out(one)
        for one in newest.values():
            if one.id in excluded:
                found.excluded[one.id] = one
            elif one.id not in found.inside:
                found.put(one)
        found.changed |= excluded - newest.keys()
        return found

    def _named(self) -> dict[int, DisagreeingMachine]:
        """Name the machines that disagree, the farthest off first, and exclude their pairs."""
        named: dict[int, DisagreeingMachine] = {}
        waiting = self._waiting()
        while waiting:
            found = self._look(waiting)
            self._return(waiting - found.keys())
            new = {key: one for key, one in found.items() if key not in named}
            if not new:
                break
            worst = min(new, key=lambda key: new[key].improbable)
            named[worst] = new[worst].named
            self._exclude(new[worst].outlying)
            if sum(one.known.pairs for one in self._materials) > MANY:
                waiting = set(found)  # one machine more or less moves no other across the line
        return named

    def _waiting(self) -> set[int]:
        """Return the machines, by id, that may agree no more, or again."""
        waiting = set()
        for material in self._materials:
            few = bool(material.changed) and len(material.every) <= MANY
            waiting |= {
                one.machine_id
                for one in material.every
                if few or one.id in material.changed or one.id in material.excluded
            }
        return waiting

    def _look(self, machines: set[int]) -> "dict[int, _Found]":
        """Return which machines disagree."""
        pairs: dict[int, list[tuple[_Material, PairVersion]]] = {}
        for material in self._materials:
            if machines_of(material.inside.values()) > 1:
                for one in material.every:
                    pairs.setdefault(one.machine_id, []).append((material, one))
        count = sum(map(len, pairs.values())) + len(pairs)
        names = machine_names(self._session)
        found = {}
        for machine in sorted(machines & pairs.keys()):
            self._progress(f"comparing {names[machine]}")
            sides = [material.compared(one) for material, one in pairs[machine]]
            verdict = disagrees(sides, compared_in_all=count)
            if verdict is not None:
                standard = standard_cut(self._session, machine, self._protocols)
                verdict = disagrees(sides, compared_in_all=count, standard=standard) or verdict
                versions = [one for _, one in pairs[machine]]
                of = [self._session.get_one(models.Pair, one.pair_id) for one in versions]
                named = named_of(names[machine], [pair_name(one) for one in of], verdict)
                least = min(one.improbable() for one in sides)
                found[machine] = _Found(named, least, verdict.pairs, versions)
        return found

    def _exclude(self, outlying: set[int]) -> None:
        """Exclude pairs of a machine, but where too many machines are already."""
        for material in self._materials:
            some = [one for one in material.inside.values() if one.id in outlying]
            excluded = machines_of(material.excluded.values()) + 1
            if some and excluded * MOST_EXCLUDED <= machines_of(material.every):
                for one in some:
                    material.take_out(one)
                    material.excluded[one.id] = one

    def _return(self, machines: set[int]) -> None:
        """Take pairs of machines that agree again back into the sums."""
        for material in self._materials:
            for one in [one for one in material.excluded.values() if one.machine_id in machines]:
                del material.excluded[one.id]
                material.put(one)

    def _kept(self, material: _Material, named: Mapping[int, DisagreeingMachine]) -> SharedVersion:
        posterior = whole_law(material.known.material())
        version = 1 if material.prior is None else material.prior.version + 1
        machines = {one.machine_id for one in material.every}
        row = models.FleetPrior(
            material_id=material.row.id,
            operation=EVERY,
            component=EVERY,
            law=LAW,
            version=version,
            mean=posterior.mean.tolist(),
            covariance=posterior.covariance.tolist(),
            machines=machines_of(material.inside.values()),
            known={
                **as_kept(material.known),
                "aside": sorted(material.excluded),
                "named": [asdict(one) for key, one in named.items() if key in machines],
            },
        )
        self._session.add(row)
        self._session.flush()
        links = [
            {"fleet_prior_id": row.id, "cutting_parameters_id": one} for one in material.inside
        ]
        if links:
            self._session.execute(insert(fleet_prior_parameters), links)
        tools = len(material.known.tools)
        return SharedVersion(material.row.name, version, row.machines, tools)


@dataclass(frozen=True)
class _Found:
    """A machine that disagrees: how it is named, how improbable its worst pair is, which pairs do,
    of all of its versions.
    """

    named: DisagreeingMachine
    improbable: float
    outlying_pairs: tuple[int, ...]
    versions: Sequence[PairVersion]

    @property
    def outlying(self) -> set[int]:
        """The versions, by id, to exclude: where the calibration may be off, all of them."""
        if self.named.cause == DisagreementCause.CALIBRATION.value:
            return {one.id for one in self.versions}
        return {self.versions[k].id for k in self.outlying_pairs}
