"""Newtons an ampere from a known mass: the same moves with it clamped on, and without.

Air moves give ratios only; what a known mass adds to the inertia is the mass over the motor's
constant (physics reference, section 3).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autodb.agent.identifying import names_of, newest_model, refuse_faults, stored_terms
from autodb.agent.machines import find_machine, signed
from autodb.errors import UnusableInput
from autodb.fitting import NORMAL_95
from autodb.records import Recording
from autodb.sensing.axis_model import IdentifiedTerm
from autodb.sensing.drives import identify
from autodb.sensing.prepared import effort_axis, effort_channel
from autodb.store import Store

TONNE_KG = 1000.0
"""1 N s²/mm is a tonne."""
UNSURE = 0.25
"""Half width of the 95 % interval, as a share, above which a mass tells nothing of use. Chosen."""


@dataclass(frozen=True)
class Weighed:
    """Newtons an ampere, its relative sd, and the inertia that the mass added, A s²/mm."""

    axis: str
    newtons_per_ampere: float
    share: float
    added_A_s2_mm: float


def weigh(
    store: Store,
    machine: str,
    moves: Recording,
    *,
    mass_kg: float,
    axis: str | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Weighed:
    """Return newtons an ampere from moves with ``mass_kg`` clamped on the axis; nothing is stored.

    Without it the axis is as its newest version has it. Raises UnusableInput where there is none,
    where the effort is not in amperes, or where the mass does not show beyond its uncertainty.
    """
    with store.reading() as session:
        owner = find_machine(session, machine)
        name, channel = effort_axis(moves, axis), effort_channel(moves, axis)
        row = newest_model(session, owner.id, channel)
        if row is None or moves.unit(channel) != "A":
            what = "no version" if row is None else "nothing to weigh: its effort is not in amperes"
            raise UnusableInput(
                f"{moves.path}: {channel} has {what}; moves in amperes without the mass, "
                f"identified with --machine {machine} before, would work"
            )
        own = signed(moves, owner)
        light, terms = _inertia(stored_terms(row)), names_of(row)
    refuse_faults(own, axis)
    progress("fitting")
    heavy = _inertia(identify(own, axis=axis, terms=terms).fitted)
    if light is None or heavy is None:
        raise UnusableInput(
            f"{moves.path}: the inertia of {name} is not known; quicker moves, with rapids, "
            "would work"
        )
    added = heavy.value - light.value
    sd = float(np.hypot(heavy.sd or 0.0, light.sd or 0.0))
    if added <= 0 or NORMAL_95 * sd > UNSURE * added:
        raise UnusableInput(
            f"{moves.path}: {mass_kg:g} kg add {added:.2g} ± {NORMAL_95 * sd:.1g} A·s²/mm to "
            f"{name}'s inertia: too little to weigh by; a larger mass, or quicker moves, would work"
        )
    return Weighed(name, mass_kg / TONNE_KG / added, sd / added, added)


def _inertia(terms: "list[IdentifiedTerm] | tuple[IdentifiedTerm, ...]") -> IdentifiedTerm | None:
    return next((t for t in terms if t.term == "inertia" and t.sd is not None), None)
