"""Learning what machines know together, and naming the machine that disagrees.

A pass adds the newest versions of pairs to their material's sums, and takes out those they replace.
A machine that disagrees with the others is named, and its pairs that do so stay out of the sums
until they agree.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np
from sqlalchemy.orm import Session

from autodb.agent.beliefs import LAW
from autodb.agent.named import Named, named_of
from autodb.agent.standing import standard_cut
from autodb.agent.starting import of_material
from autodb.agent.together import (
    OwnCuts,
    as_kept,
    known_from,
    machines_of,
    names_of,
    newest_prior,
    own_cuts,
    sharing,
)
from autodb.pairs.disagreeing import Cause, Compared, compared, disagrees
from autodb.pairs.hierarchy import MANY, Known, whole
from autodb.standard.protocol import Protocol
from autodb.store import Store, lasting, models
from autodb.store.models.learning import EVERY

Progress = Callable[[str], None]

FLEET = "fleet "
"""Whose rows a pass writes: no machine's name ends with a blank."""
MOST_ASIDE = 3
"""One in so many machines may be set aside of a material: most must agree. Chosen."""


@dataclass(frozen=True)
class Together:
    """What a pass left of a material: its version, how many machines and tools told it."""

    material: str
    version: int
    machines: int
    pairs: int
    tools: int


@dataclass
class Learnt:
    """What a pass did: the materials that have a new version, and the machines named now."""

    materials: list[Together] = field(default_factory=list)
    named: list[Named] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return it in words, a line each."""
        said = [
            f"{one.material}: version {one.version} from {_counted(one.machines, 'machine')}, "
            f"{_counted(one.tools, 'tool')}"
            for one in self.materials
        ]
        return (said or ["nothing new to know together"]) + [one.words for one in self.named]


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def learn_fleet(
    store: Store, *, protocols: Sequence[Protocol] = (), progress: Progress = lambda _: None
) -> Learnt:
    """Bring what machines know together up to their newest versions.

    ``protocols``: standard cuts whose forces are known, beside those of the kit.
    """

    def one_pass() -> Learnt:
        with store.writing(FLEET) as session:
            return _Pass(session, protocols, progress).run()

    return lasting(one_pass, progress)


@dataclass
class _Material:
    """One material in a pass: what is known, which pairs are in it, and which stand aside."""

    row: models.Material
    prior: models.FleetPrior | None
    known: Known
    inside: dict[int, OwnCuts] = field(default_factory=dict)
    aside: dict[int, OwnCuts] = field(default_factory=dict)
    changed: set[int] = field(default_factory=set)

    def put(self, one: OwnCuts) -> None:
        """Take a pair into the sums."""
        self.known = self.known.changed(one.row.pair.tool.name, more=one.as_stated)
        self.inside[one.row.id] = one

    def take_out(self, number: int) -> OwnCuts:
        """Take a pair out of the sums."""
        one = self.inside.pop(number)
        self.known = self.known.changed(one.row.pair.tool.name, less=one.as_stated)
        return one

    def others(self, one: OwnCuts) -> Known:
        """Return what all but one pair tell."""
        if one.row.id in self.aside:
            return self.known
        return self.known.without(one.row.pair.tool.name, one.as_stated)

    def compared(self, one: OwnCuts) -> Compared:
        """Compare a pair with the others."""
        tool = one.row.pair.tool
        expected = self.others(one).pair(tool.name)
        rake_rad = np.radians(tool.rake_deg or 0.0)
        return compared(
            one.as_felt, as_stated=one.as_stated, others=expected, rake_rad=float(rake_rad)
        )


class _Pass:
    """One pass over all materials."""

    def __init__(self, session: Session, protocols: Sequence[Protocol], progress: Progress) -> None:
        self._session, self._protocols, self._progress = session, protocols, progress
        self._materials = {
            number: self._brought_up(number, rows) for number, rows in sharing(session).items()
        }

    def run(self) -> Learnt:
        """Bring the sums up to date, name who disagrees, and keep what is new."""
        named = self._named()
        done = Learnt(named=list(named.values()))
        for material in self._materials.values():
            if material.changed:
                done.materials.append(self._kept(material, named))
        return done

    def _brought_up(self, number: int, rows: Sequence[models.CuttingParameters]) -> _Material:
        """Take a material's newest versions into its sums, and out what they replace."""
        row, prior = self._session.get_one(models.Material, number), None
        self._progress(f"what is known of {row.name}")
        before: dict[int, models.CuttingParameters] = {}
        known, aside = Known(of_material(row.name).belief.law), set()
        prior = newest_prior(self._session, number)
        if prior is not None and prior.known is not None:
            known, aside = known_from(prior.known), set(prior.known["aside"])
            before = {one.id: one for one in prior.parameters}
        found = _Material(row, prior, known)
        newest = {one.id: one for one in rows}
        for key, one in before.items():
            found.inside[key] = own_cuts(one)
        for key in before.keys() - newest.keys():
            found.take_out(key)
            found.changed.add(key)
        for key, one in newest.items():
            if key in aside:
                found.aside[key] = own_cuts(one)
            elif key not in before:
                found.put(own_cuts(one))
                found.changed.add(key)
        if aside - newest.keys():
            found.changed |= aside - newest.keys()
        return found

    def _named(self) -> dict[int, Named]:
        """Name the machines that disagree, the farthest off first, and set their pairs aside."""
        named: dict[int, Named] = {}
        waiting = self._waiting()
        while waiting:
            found = self._look(waiting)
            self._return(waiting - found.keys())
            new = {key: one for key, one in found.items() if key not in named}
            if not new:
                break
            worst = min(new, key=lambda key: new[key].improbable)
            named[worst] = new[worst].named
            self._set_aside(new[worst].odd)
            if sum(one.known.pairs for one in self._materials.values()) > MANY:
                waiting = set(found)  # one machine more or less moves no other across the line
        return named

    def _waiting(self) -> set[int]:
        """Return the machines, by id, that may agree no more, or again."""
        waiting = set()
        for material in self._materials.values():
            every = {**material.inside, **material.aside}
            some = every if material.changed and len(every) <= MANY else material.aside
            waiting |= {one.row.machine_id for one in some.values()}
            waiting |= {every[key].row.machine_id for key in material.changed & every.keys()}
        return waiting

    def _look(self, machines: Iterable[int]) -> dict[int, "_Found"]:
        """Return which machines disagree."""
        pairs: dict[int, list[tuple[_Material, OwnCuts]]] = {}
        for material in self._materials.values():
            if machines_of(one.row for one in material.inside.values()) < 2:
                continue
            for one in (*material.inside.values(), *material.aside.values()):
                pairs.setdefault(one.row.machine_id, []).append((material, one))
        count = sum(map(len, pairs.values())) + len(pairs)
        names = names_of(self._session, list(pairs))
        found = {}
        for machine in sorted(set(machines) & pairs.keys()):
            self._progress(f"comparing {names[machine]}")
            sides = [material.compared(one) for material, one in pairs[machine]]
            told = disagrees(sides, compared_in_all=count)
            if told is not None:
                standard = standard_cut(self._session, machine, self._protocols)
                told = disagrees(sides, compared_in_all=count, standard=standard) or told
                rows = [one.row for _, one in pairs[machine]]
                least = min(one.improbable() for one in sides)
                found[machine] = _Found(
                    named_of(names[machine], rows, told), least, told.pairs, rows
                )
        return found

    def _set_aside(self, odd: Iterable[int]) -> None:
        """Set pairs of a machine aside, but where too many machines are already."""
        for material in self._materials.values():
            keys = [key for key in material.inside if key in set(odd)]
            aside = machines_of(one.row for one in material.aside.values()) + 1
            of_all = machines_of(
                one.row for one in (*material.inside.values(), *material.aside.values())
            )
            if keys and aside * MOST_ASIDE <= of_all:
                material.aside |= {key: material.take_out(key) for key in keys}
                material.changed |= set(keys)

    def _return(self, machines: Iterable[int]) -> None:
        """Take pairs that agree again back into the sums."""
        agree = set(machines)
        for material in self._materials.values():
            back = [k for k, one in material.aside.items() if one.row.machine_id in agree]
            for key in back:
                material.put(material.aside.pop(key))
                material.changed.add(key)

    def _kept(self, material: _Material, named: Mapping[int, Named]) -> Together:
        belief = whole(material.known.material())
        rows = [one.row for one in material.inside.values()]
        prior, version = material.prior, 1
        if prior is not None:
            version = prior.version + 1
            prior.known = None  # its sums are in the next; its numbers and what told them stay
        every = {
            one.row.machine_id for one in (*material.inside.values(), *material.aside.values())
        }
        known = {
            **as_kept(material.known),
            "aside": sorted(material.aside),
            "named": [asdict(one) for key, one in named.items() if key in every],
        }
        self._session.add(
            models.FleetPrior(
                material_id=material.row.id,
                operation=EVERY,
                component=EVERY,
                law=LAW,
                version=version,
                mean=belief.mean.tolist(),
                covariance=belief.covariance.tolist(),
                machines=machines_of(rows),
                known=known,
                parameters=rows,
            )
        )
        self._session.flush()
        tools = len(material.known.tools)
        return Together(material.row.name, version, machines_of(rows), len(rows), tools)


@dataclass(frozen=True)
class _Found:
    """A machine that disagrees: how it is named, how improbable its worst pair is, its odd rows."""

    named: Named
    improbable: float
    odd_pairs: tuple[int, ...]
    rows: Sequence[models.CuttingParameters]

    @property
    def odd(self) -> list[int]:
        """The versions, by id, that stand aside: where the calibration may be off, all of them."""
        if self.named.cause == Cause.CALIBRATION.value:
            return [row.id for row in self.rows]
        return [self.rows[k].id for k in self.odd_pairs]
