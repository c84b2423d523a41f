"""From which cut on can an event of a day be told? An ideal judge, who knows noise and all forms.

At cut k the judge sees the first k cuts. The other events are known to it and taken off; the
event's true shape has a free size, the simulation's own terms are free in each component. Its rivals
are nothing at all, and every other effect that a table of cuts may have, at every shape of
`concealed.cut_families`, each component with a size of its own; so is the warm-up, by the machine's
true cold. The event is decidable from the first cut on at which twice the log-likelihood of the
truth is more than SURE above that of the best rival.
"""

from collections.abc import Callable, Iterator
from dataclasses import fields, replace

import numpy as np

from autodb.prove.explain_oracle import SURE, Array, verdict
from autodb.virtual.concealed.case import Case, Hidden, Rival, Yardstick
from autodb.virtual.concealed.cut_effects import apart
from autodb.virtual.concealed.cut_families import CUT_FAMILIES
from autodb.virtual.concealed.cuts import Cuts, CutWorld
from autodb.virtual.day import Day, Event

FEWEST = 8
"""Cuts of the shortest table that is explained at all."""


def decidable_from(day: Day, event: Event) -> int | None:
    """Return the number of the first cut at which an event is decidable, None where never."""
    return first_sure(lambda count: case_of(day, event, count), event.first, day.bar.size)


def first_sure(case_at: Callable[[int], Case], begin: int, end: int) -> int | None:
    """Return the first count of cuts, from ``begin`` to ``end``, whose case is told for sure.

    A margin is at most what the truth itself explains: rivals are looked at only beyond SURE.
    """
    for count in range(max(begin, FEWEST), end + 1):
        case = case_at(count)
        if explained(case) <= SURE:
            continue
        margin = verdict(case).margin
        if margin is not None and margin > SURE:
            return count
    return None


def explained(case: Case) -> float:
    """Return what the true effect explains beside own columns: the fall of the sum of squares."""
    yardstick = Yardstick.beside(case.own, case.whitened)
    part, target = yardstick.left(
        np.array([case.hidden[0].part, case.measured - case.simulated])
    )
    return float((part @ target) ** 2 / max(float(part @ part), 1e-300))


def case_of(day: Day, event: Event, count: int) -> Case:
    """Return an event alone in the first cuts of a day, as a case of one concealed effect."""
    rows = slice(0, count)
    others = np.sum([other.part for other in day.events if other is not event], axis=0)
    scatter, expected = day.scatter[:, rows], day.expected[:, rows]
    world = CutWorld(_first(day.cuts, count), day.world.law)

    def whitened(values: Array) -> Array:
        return np.asarray(values / scatter, dtype=np.float64)

    part = event.part[:, rows]
    return Case(
        seed=day.seed, kind=event.name, wanted=0.0, reached=True, tuning="true",
        channels={}, simulation={}, includes=tuple(world.parts), explained=(),
        hidden=(Hidden(event.term, 1.0, 0.0, part),), interval=None,
        measured=(day.measured - others)[:, rows], simulated=expected, truth=expected + part,
        own=np.concatenate([apart(column) for column in world.parts.values()]),
        whitened=whitened, rivals=lambda: rivals(world, day.cold[rows]),
    )  # fmt: skip


def rivals(world: CutWorld, cold: Array) -> Iterator[Rival]:
    """Every effect at every shape of its grid on these cuts, and the warm-up by its cold (n,)."""
    for family in CUT_FAMILIES:
        for effect in family.grid(world.cuts):
            yield Rival(effect.term, effect.columns(world, world.base))
    yield Rival("warmup", apart(cold * world.base))
    yield Rival("warmup", apart(np.tile(cold, (3, 1))))


def _first(cuts: Cuts, count: int) -> Cuts:
    """Return the first cuts of a day."""
    arrays = {field.name: getattr(cuts, field.name) for field in fields(cuts)}
    kept = {name: a[:count] for name, a in arrays.items() if isinstance(a, np.ndarray)}
    return replace(cuts, **kept)
