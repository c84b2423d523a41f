"""All cases of the proof on published tables, in an order whose every beginning is mixed."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from autodb.proofs.cases.real.injected import LEAST_GAINED, LEAST_SEEN, TUNINGS, Beside
from autodb.proofs.cases.real.left_out_terms import VARIANTS, WORSE
from autodb.proofs.cases.real.real_case import MISTUNED_BY, RealSpec
from autodb.proofs.cases.tables.published_tables import Array
from autodb.proofs.cases.tables.rival_laws import rival_laws
from autodb.proofs.cases.tables.table_case import TableCase, TabledCase
from autodb.proofs.cases.tables.table_effects import MAKERS, TableEffect, effect_in, effects_into
from autodb.proofs.cases.tables.table_models import (
    TABLE_TERMS,
    PublishedModel,
    mixed_held_out,
    table_model,
)

SEED = 37
STRENGTHS = {"weak": 1.0, "strong": 3.0}
"""Rms of what the own laws cannot follow, in errors of cuts left out: cuts are few."""
TABLES = tuple(TABLE_TERMS)
DRAWS = ("1", "2", "3", "4")
"""Effects that are drawn of each kind for each table."""
PARTS = 3
"""Nulls of two thirds of the cuts."""


def table_specs() -> list[RealSpec]:
    """Return all cases before they are made; a beginning of it has each kind by its share."""
    groups = (_left_out_specs(), _injected_specs(), _null_specs())
    placed = [
        ((place + 0.5) / len(group), kind, spec)
        for kind, group in enumerate(groups)
        for place, spec in enumerate(group)
    ]
    return [spec for *_, spec in sorted(placed, key=lambda one: one[:2])]


def _left_out_specs() -> list[RealSpec]:
    return [
        RealSpec("left out", name, term, "", variant)
        for variant in VARIANTS
        for name in TABLES
        for term in TABLE_TERMS[name]
        if term != "shear"
    ]


def _injected_specs() -> list[RealSpec]:
    """Return every effect in every table, at both strengths, under each tuning in turn."""
    found = []
    for draw in range(len(DRAWS)):
        for shift in range(len(MAKERS)):
            for row, name in enumerate(TABLES):
                terms = effects_into(name)
                term = terms[(row + shift) % len(terms)]
                for place, strength in enumerate(reversed(STRENGTHS)):
                    tuning = TUNINGS[(row + shift + draw + 2 * place) % len(TUNINGS)]
                    variant = f"{tuning} {DRAWS[draw]}"
                    found.append(RealSpec("injected", name, term, strength, variant))
    return list(dict.fromkeys(found))


def _null_specs() -> list[RealSpec]:
    signs = [
        RealSpec("null", name, term, "", sign)
        for sign in ("more", "less")
        for name in TABLES
        for term in TABLE_TERMS[name]
    ]
    parts = [
        RealSpec("null", name, variant=f"part {part}") for part in range(PARTS) for name in TABLES
    ]
    return [*(RealSpec("null", name, variant="exact") for name in TABLES), *signs, *parts]


def tabled_case(spec: RealSpec) -> TabledCase:
    """Make a case."""
    return {"left out": _left_out, "injected": _injected, "null": _null}[spec.kind](spec)


@cache
def _fitted(name: str) -> tuple[PublishedModel, Array]:
    """Return a table's full model, and its error (C,) on cuts left out of the fit."""
    model = table_model(name)
    return model, model.errors(model.table.components)


@dataclass(frozen=True)
class _Components:
    """A table whose components become cases: its forces (C, n), the simulation, its own laws fitted
    to the forces, and the laws that were made wrong."""

    spec: RealSpec
    forces: Array
    own: PublishedModel
    refitted: PublishedModel
    retuned: tuple[str, ...]

    def changed(self, place: int, change: Array, rms_full: float, *, seen: bool) -> TableCase:
        """Return the case of a component of which something (n,) is concealed."""
        channel, force = list(self.own.channels)[place], self.forces[place]
        term = self.spec.term
        rivals = rival_laws(term, self.refitted, channel, force, rms_full) if seen else {}
        sizes = {term: float(np.max(np.abs(change)))} | rivals
        return replace(self.alone(place, rms_full), concealed=term, sizes=sizes, seen=seen)

    def alone(self, place: int, rms_full: float) -> TableCase:
        """Return the case of a component of which nothing is concealed."""
        own = {term: float(np.max(np.abs(self.own.part(term)[place]))) for term in self.own.terms}
        channel = list(self.own.channels)[place]
        return TableCase(self.spec, channel, rms_full, own_peaks=own, retuned=self.retuned)


def _left_out(spec: RealSpec) -> TabledCase:
    model, rms_full = _fitted(spec.recording)
    less, forces = model.without(spec.term), model.table.components
    refitted = less.refitted(forces)
    own, retuned = (refitted, less.terms) if spec.variant == "refit" else (less, ())
    components = _Components(spec, forces, own, refitted, retuned)
    seen = refitted.errors(forces) >= WORSE * rms_full
    part = model.part(spec.term)
    cases = tuple(
        components.changed(place, part[place], float(rms_full[place]), seen=bool(seen[place]))
        for place in range(len(forces))
    )
    return TabledCase(spec, model.table, own.components, less, cases)


def _injected(spec: RealSpec) -> TabledCase:
    """Make a case: what the model's own columns cannot follow is sized over its errors."""
    model, rms = _fitted(spec.recording)
    tuning, draw = spec.variant.split(" ")
    rng = np.random.default_rng(
        [SEED, TABLES.index(spec.recording), list(MAKERS).index(spec.term), int(draw)]
    )
    effect = effect_in(spec.term, model, rng)
    change = _sized(effect, model, rms, STRENGTHS[spec.strength]) * effect.shape
    forces = model.table.components + change
    own, retuned = _tuned(model, tuning, forces, rng)
    components = _Components(spec, forces, own, model.refitted(forces), retuned)
    without, cases = model.errors(forces), []
    for place, (channel, error) in enumerate(zip(model.channels.values(), rms, strict=True)):
        if place not in effect.touched:
            cases.append(components.alone(place, float(error)))
            continue
        full = mixed_held_out(np.vstack([channel.columns, change[place]]), forces[place])
        left = Beside(channel.columns).rms(change[place])
        seen = left >= LEAST_SEEN * error and without[place] >= LEAST_GAINED * full
        cases.append(components.changed(place, change[place], full, seen=bool(seen)))
    return TabledCase(spec, model.table.with_forces(forces), own.components, model, tuple(cases))


def without_effect(spec: RealSpec) -> RealSpec:
    """Return the same table without the effect, under the same tuning as far as that is drawn."""
    return RealSpec("null", spec.recording, variant="exact")


def _tuned(
    model: PublishedModel, tuning: str, forces: Array, rng: np.random.Generator
) -> tuple[PublishedModel, tuple[str, ...]]:
    if tuning == "exact":
        return model, ()
    if tuning == "refitted":
        return model.refitted(forces), model.terms
    term = str(rng.choice(model.terms))
    return model.mistuned(term, float(rng.choice((-MISTUNED_BY, MISTUNED_BY)))), (term,)


def _sized(effect: TableEffect, model: PublishedModel, rms: Array, wanted: float) -> float:
    """Return the factor at which as much is left beside own columns as is ``wanted``, in errors."""
    channels = list(model.channels.values())
    left = [
        Beside(channels[i].columns).rms(effect.shape[i]) / float(rms[i]) for i in effect.touched
    ]
    return min(wanted / float(np.sqrt(np.mean(np.square(left)))), effect.most)


def _null(spec: RealSpec) -> TabledCase:
    """Make a null: the full model as it is, 3 % off in a law, or fitted to two thirds of cuts."""
    model, rms = _fitted(spec.recording)
    if spec.variant.startswith("part"):
        rows = np.arange(len(model.table))
        model = model.rows(np.flatnonzero(rows % PARTS != int(spec.variant.split(" ")[1])))
        model = model.refitted(model.table.components)
        rms = model.errors(model.table.components)
    share = MISTUNED_BY if spec.variant == "more" else -MISTUNED_BY
    own = model.mistuned(spec.term, share) if spec.term else model
    retuned = (spec.term,) if spec.term else ()
    components = _Components(spec, model.table.components, own, model, retuned)
    cases = tuple(components.alone(place, float(error)) for place, error in enumerate(rms))
    return TabledCase(spec, model.table, own.components, model, cases)
