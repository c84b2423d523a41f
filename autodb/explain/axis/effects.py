"""Where each effect of an axis gets its candidates from: written for it, or made from its term."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from autodb.explain.axis import friction, loads, marks
from autodb.explain.axis import sensors_of_axis as sensors
from autodb.explain.axis.from_term import candidates_from_term
from autodb.explain.axis.signals import AxisSignals, acting_terms
from autodb.explain.engine.candidates import UNKNOWN, Candidate
from autodb.sensing.drives.moves.motion import axis_kind
from autodb.terms.vocabulary import terms_on

OTHER_SHAPE = "in another shape"
"""What the key of an effect ends in that the simulation has in the shape that was read off it."""
Made = Callable[[AxisSignals], Candidate | list[Candidate]]


def _after_reversals(make: Made) -> Made:
    """Make candidates where the axis turns back."""
    return lambda s: make(s) if np.any(np.diff(s.last_sense) != 0) else []


def _of_an_effort(make: Made) -> Made:
    """Make candidates where an effort is known: nothing else can be scaled, shifted or clipped."""
    return lambda s: make(s) if np.any(s.effort) else []


WRITTEN: tuple[tuple[str, Made], ...] = (
    ("coulomb", friction.coulomb_candidate),
    ("viscous", friction.viscous_candidate),
    ("stribeck", friction.stribeck_dip),
    ("asymmetry", friction.asymmetry_candidate),
    ("position_friction", friction.position_friction_candidate),
    ("warmup", friction.warmup_candidate),
    ("presliding", _after_reversals(friction.soft_start)),
    ("backlash", _after_reversals(friction.play)),
    ("gravity", loads.weights),
    ("inertia", loads.inertia_candidate),
    ("spring", loads.spring_candidate),
    ("compliance", loads.swings_behind),
    ("cross_coupling", loads.cross_couplings),
    ("gain", _of_an_effort(sensors.gain_candidate)),
    ("sensor_drift", sensors.drift),
    ("lag", _of_an_effort(sensors.shift)),
    ("saturation", _of_an_effort(marks.clipping)),
    ("lost_sign", _of_an_effort(marks.lost_sign_candidate)),
    (UNKNOWN, _of_an_effort(sensors.braking)),
)
"""Effects whose candidates are written for them; what scans find, they propose themselves."""


def candidates_of_axis(s: AxisSignals) -> list[Candidate]:
    """Return the candidates of every effect but those that scans find."""
    return _made(s, lambda _: True)


def candidates_of_effect(s: AxisSignals, term: str) -> list[Candidate]:
    """Return the candidates of one effect."""
    return _made(s, {term}.__contains__)


def acting_candidates(s: AxisSignals) -> list[Candidate]:
    """Return the candidates of effects that act on what others add."""
    return _made(s, (acting_terms() | {UNKNOWN}).__contains__)


def _made(s: AxisSignals, wanted: Callable[[str], bool]) -> list[Candidate]:
    """Return the candidates of the effects whose names are wanted."""
    found: list[Candidate] = []
    for name, make in WRITTEN:
        made = make(s) if wanted(name) else []
        found += made if isinstance(made, list) else [made]
    written = {name for name, _ in WRITTEN}
    for name, term in terms_on(axis_kind(s.axis)).items():
        if wanted(name) and name not in written:
            found += candidates_from_term(term, s)
    named = [replace(c, key=f"{c.key} {OTHER_SHAPE}") if c.term in s.shaped else c for c in found]
    return [candidate for candidate in named if candidate.forms]
