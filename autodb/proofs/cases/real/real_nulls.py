"""Recordings against their own full models: nothing is missing, and little or nothing mistuned."""

import numpy as np

from autodb.proofs.cases.real.full_models import FULL_MODELS
from autodb.proofs.cases.real.injected import INJECTED_INTO, fitted_axis, tuned_simulation
from autodb.proofs.cases.real.real_axis import Array
from autodb.proofs.cases.real.real_case import MISTUNED_BY, RealCase, RealSpec

PARTS = {
    "first half": (0.0, 0.5), "second half": (0.5, 1.0), "first third": (0.0, 1 / 3),
    "second third": (1 / 3, 2 / 3), "last third": (2 / 3, 1.0),
}  # fmt: skip
"""Contiguous rows, as shares of all."""
WHOLE_ONLY = frozenset({"laas-roll", "odrive-pull-fast", "odrive-pull-fast-fed"})
"""Recordings whose parts are too short for anybody to be asked about: under SHORTEST_S."""
SHORTEST_S = 2.0
HALF_RATE = "half the rate"
FITTED = ", refitted"
"""The model is fitted to these rows alone."""


def null_specs() -> list[RealSpec]:
    """Return the nulls of all recordings, those of one variant after another."""
    both = (f"{sign}" for sign in ("more", "less"))
    named = [
        [RealSpec("null", name, term, "", sign) for name in INJECTED_INTO for term in _terms(name)]
        for sign in both
    ]
    exact, half_rate = (
        [RealSpec("null", name, variant=one) for name in INJECTED_INTO]
        for one in ("exact", HALF_RATE)
    )
    parts, fitted = (
        [
            RealSpec("null", name, variant=f"{part}{also}")
            for part in PARTS
            for name in INJECTED_INTO
            if name not in WHOLE_ONLY
        ]
        for also in ("", FITTED)
    )
    return [*exact, *(spec for group in named for spec in group), *parts, *half_rate, *fitted]


def _terms(recording: str) -> tuple[str, ...]:
    return FULL_MODELS[recording].terms


def null_case(spec: RealSpec) -> RealCase:
    """Make a null."""
    axis, model, _ = fitted_axis(spec.recording)
    kept = rows_of(spec.variant.removesuffix(FITTED), len(axis))
    axis, model = axis.rows(kept), model.rows(kept)
    retuned: tuple[str, ...] = ()
    if spec.variant.endswith(FITTED):
        model = model.refitted(axis.effort)
    simulated = model.whole
    if spec.term:
        share = MISTUNED_BY if spec.variant == "more" else -MISTUNED_BY
        simulated, retuned = model.mistuned(spec.term, share).whole, (spec.term,)
    return RealCase(
        spec, axis, simulated, model, model.held_out(axis.effort).rms, includes=model.terms,
        own_peaks={term: float(np.max(np.abs(model.part(term)))) for term in model.terms},
        retuned=retuned,
    )  # fmt: skip


def rows_of(variant: str, rows: int) -> slice:
    """Return which rows a variant has: a contiguous part, every second, or all."""
    if variant == HALF_RATE:
        return slice(None, None, 2)
    first, last = PARTS.get(variant, (0.0, 1.0))
    return slice(round(first * rows), round(last * rows))


def twin_of(case: RealCase) -> RealCase:
    """Return the same recording without what was injected or left out, under the same tuning."""
    if case.kind == "shown":
        raise ValueError("what is shown has a null of its own")
    axis, model, rms_full = fitted_axis(case.spec.recording)
    tuning = "mistuned" if case.spec.variant == "mistuned" else "exact"
    simulated: Array
    simulated, retuned = tuned_simulation(model, case.spec.recording, tuning, axis.effort)
    return RealCase(
        RealSpec("null", case.spec.recording, variant=tuning), axis, simulated, model, rms_full,
        includes=model.terms, retuned=retuned,
        own_peaks={term: float(np.max(np.abs(model.part(term)))) for term in model.terms},
    )  # fmt: skip
