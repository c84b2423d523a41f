"""All cases of the proof on real axes, in an order whose every beginning is evenly mixed."""

from collections.abc import Iterator
from itertools import islice

from autodb.proofs.cases.real.injected import (
    INJECTED_INTO,
    STRENGTHS,
    TUNINGS,
    injectable,
    injected_case,
)
from autodb.proofs.cases.real.left_out_terms import left_out_case, left_out_specs
from autodb.proofs.cases.real.real_case import RealCase, RealSpec
from autodb.proofs.cases.real.real_effects import EFFECTS
from autodb.proofs.cases.real.real_nulls import null_case, null_specs
from autodb.proofs.cases.real.shown_cases import shown_case, shown_specs

ONE_STRENGTH = ("lost_sign",)
"""All or nothing."""
MAKERS = {
    "shown": shown_case, "left out": left_out_case, "injected": injected_case, "null": null_case,
}  # fmt: skip


def injected_specs() -> list[RealSpec]:
    """Return every term of every recording at both strengths in every tuning.

    Each stretch of as many as there are recordings has all of them, with terms, strengths and
    tunings in turn.
    """
    ways = [(strength, tuning) for tuning in TUNINGS for strength in reversed(STRENGTHS)]
    found = []
    for round_ in range(len(ways)):
        for shift in range(len(EFFECTS)):
            for row, recording in enumerate(INJECTED_INTO):
                term = EFFECTS[(row + shift) % len(EFFECTS)]
                strength, tuning = ways[(round_ + 2 * row + shift) % len(ways)]
                if term in injectable(recording):
                    strength = "strong" if term in ONE_STRENGTH else strength
                    found.append(RealSpec("injected", recording, term, strength, tuning))
    return list(dict.fromkeys(found))


def real_specs() -> list[RealSpec]:
    """Return all cases before they are made; a beginning of it has each kind by its share."""
    groups = (shown_specs(), left_out_specs(), injected_specs(), null_specs())
    placed = [
        ((place + 0.5) / len(group), kind, spec)
        for kind, group in enumerate(groups)
        for place, spec in enumerate(group)
    ]
    return [spec for *_, spec in sorted(placed, key=lambda one: one[:2])]


def made_case(spec: RealSpec) -> RealCase:
    """Make a case; raises NoRecordingsError where the recordings are not here."""
    return MAKERS[spec.kind](spec)


def real_plan(most: int | None = None) -> Iterator[RealCase]:
    """Yield the cases in the order of the plan, the first ``most`` of them."""
    yield from map(made_case, islice(real_specs(), most))
