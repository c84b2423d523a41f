"""From which cut on can an event of a day be decided? An ideal judge, given noise and all forms.

At cut k the judge sees the first k cuts. It is given the true shape of the event and of all others
that began by then, not their sizes; so the others, in each component, are free as the
simulation's own terms are. The event's rivals are nothing at all, and every other effect that a
table of cuts may have, at every shape of `concealed.cut_families`, each component with a size of
its own; so is the warm-up, by the machine's true cold. The event is decidable from the first cut
on at which twice the log-likelihood of the truth is more than SURE above that of the best rival.
"""

from collections.abc import Callable, Iterator

import numpy as np

from autodb.proofs.cases.base.case import Case, Hidden, Rival, Yardstick
from autodb.proofs.cases.cuts.cut_effects import components_apart
from autodb.proofs.cases.cuts.cut_families import CUT_FAMILIES
from autodb.proofs.cases.cuts.cuts import CaseCuts, CutWorld
from autodb.proofs.machines.lathe.day import Day, Event
from autodb.proofs.runs.explain.explain_oracle import SURE, Array, oracle_verdict

FEWEST = 8
"""Cuts of the shortest table that is explained at all."""
STRIDE = 8


def decidable_from(day: Day, event: Event) -> int | None:
    """Return the number of the first cut at which an event is decidable, None where never."""
    return first_sure(lambda count: case_of(day, event, count), event.first, day.bar.size)


def first_sure(case_at: Callable[[int], Case], begin: int, end: int) -> int | None:
    """Return the first count of cuts, from ``begin`` to ``end``, whose case is decided.

    Margins grow with the cuts but for scatter: of every STRIDE counts the last is examined, and
    each of those before it only where that one is sure.
    """
    at = max(begin, FEWEST)
    while at <= end:
        last = min(at + STRIDE - 1, end)
        if sure(case_at(last)):
            return next(count for count in range(at, last + 1) if sure(case_at(count)))
        at = last + 1
    return None


def sure(case: Case) -> bool:
    """Say whether a case is decided; its margin is at most what the truth itself explains."""
    if oracle_explained(case) <= SURE:
        return False
    margin = oracle_verdict(case).margin
    return margin is not None and margin > SURE


def oracle_explained(case: Case) -> float:
    """Return what the true effect explains beside own columns: the fall of the sum of squares."""
    yardstick = Yardstick.beside(case.own, case.whitened)
    part, target = yardstick.left(np.array([case.hidden[0].part, case.measured - case.simulated]))
    return float((part @ target) ** 2 / max(float(part @ part), 1e-300))


def case_of(day: Day, event: Event, count: int) -> Case:
    """Return an event alone in the first cuts of a day, as a case of one concealed effect."""
    rows = slice(0, count)
    others = [components_apart(other.part[:, rows]) for other in day.events if other is not event]
    scatter, expected = day.scatter[:, rows], day.expected[:, rows]
    world = CutWorld(_first(day.cuts, count), day.world.law)

    def whitened(values: Array) -> Array:
        return np.asarray(values / scatter, dtype=np.float64)

    part = event.part[:, rows]
    return Case(
        seed=day.seed, kind=event.name, wanted=0.0, reached=True, tuning="true",
        channels={}, simulation={}, includes=tuple(world.parts), explained=(),
        hidden=(Hidden(event.term, 1.0, 0.0, part),), interval=None,
        measured=day.measured[:, rows], simulated=expected, truth=expected + part,
        own=np.concatenate([*map(components_apart, world.parts.values()), *others]),
        whitened=whitened, rivals=lambda: rivals(world, day.cold[rows]),
    )  # fmt: skip


def rivals(world: CutWorld, cold: Array) -> Iterator[Rival]:
    """Every effect at every shape of its grid on these cuts, and the warm-up by its cold (n,)."""
    for family in CUT_FAMILIES:
        for effect in family.grid(world.cuts):
            yield Rival(effect.term, effect.columns(world, world.base))
    yield Rival("warmup", components_apart(cold * world.base))
    yield Rival("warmup", components_apart(np.tile(cold, (3, 1))))


def _first(cuts: CaseCuts, count: int) -> CaseCuts:
    """Return the first cuts of a day."""
    return CaseCuts(
        t_s=cuts.t_s[:count],
        duration_s=cuts.duration_s[:count],
        speed_m_min=cuts.speed_m_min[:count],
        feed_mm=cuts.feed_mm[:count],
        depth_mm=cuts.depth_mm[:count],
        diameter_mm=cuts.diameter_mm[:count],
        z_mm=cuts.z_mm[:count],
        edge=cuts.edge[:count],
        used_s=cuts.used_s[:count],
        labelled=cuts.labelled,
    )
