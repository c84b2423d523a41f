"""What an axis' candidates are built from: its motion, its simulated effort, and the other axes."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.included import included_parts, ripples_over_position
from autodb.explain.axis.read_off import READ_OFF, OwnTerms, own_terms, own_terms_of
from autodb.explain.axis.scales import AxisScales, axis_scales
from autodb.explain.axis.tilt import ACROSS, CONSTANT
from autodb.explain.engine.fit import Folds
from autodb.files.channels import LINEAR_AXES, ROTARY_AXES, axis_of, place_channel, way_unit
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import (
    DROWNED,
    axis_kind,
    axis_motion,
    protocol_of,
    term_inputs,
)
from autodb.terms.channel import EVERY
from autodb.terms.friction import since_reversal
from autodb.terms.term import Factor, OutputChange
from autodb.terms.vocabulary import all_terms, friction_terms
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

OWN_PART = 0.005
"""A known part that is less than this share of the simulation is none."""
BRAKING = "braking, with effort against the motion"
"""Key of what is recorded otherwise while power flows back: it acts on all, and has no name."""
READINGS = 3
"""Of a simulation's ripples: beside its terms in the motion that it seems to have without ripples,
then in the one that it has with these."""
PARTS, IN_PARTS, FEWEST_ROWS = 8, 6, 200
"""Contiguous parts of a recording that are left out of a fit in turn, of how many each has to be
predicted better with less of a motion, and rows that show it. Chosen."""
TELLING = 0.05
"""Share by which the error of parts left out falls where a halved cutoff takes off nothing but
noise. Chosen on recordings of real axes."""
WAVES = 4.0
"""Waves of the lowest cutoff tried that a part of the recording has. Chosen."""
AS_SIMULATED = stored_msgid("as in the simulation")
NO_EFFORT_ABOVE = stored_msgid("no effort follows what is faster")
"""Why motion is derived with a lower cutoff than its own noise asks for."""
NO_PARTS: Mapping[str, Array] = MappingProxyType({})


def acting_terms() -> frozenset[str]:
    """Return the names of effects that act on what others add: on some as factors, or on all."""
    return frozenset(
        term.name
        for term in all_terms()
        if isinstance(term, Factor | OutputChange) or EVERY in term.modifies
    )


@dataclass(frozen=True)
class AxisSignals:
    """Signals of one axis at every row, (n,): mm and s, of a rotary axis deg and s.

    ``direction``: ±1 in motion, fading through standstill · ``sense``: the same as the simulation
    turns it ·
    ``effort``: all that is known to act, the simulation at first · ``friction``: the same of
    friction, ``sense`` where there is none ·
    ``last_sense``, ``way``: last direction, and the way run since it turned ·
    ``others``: position or angle, velocity and acceleration of further axes by channel ·
    ``own``: columns of the simulation's terms, ``had`` their coefficients; of a term that is not of
    ``READ_OFF`` its part, and 1 ·
    ``recorded``: the effort as recorded; None: these are of another move ·
    ``pieces``: runs of even rows ·
    ``read_share``: share of the simulation's sum of squares that the terms read off give ·
    ``phase_deg``: the angle at which the weight of a simulated rotary axis is largest ·
    ``like``: signals of the recording, where these are of another move ·
    ``found``: what each effect adds that was found, by term ·
    ``stated``: columns of terms that the simulation is said to have, however little of them it has
    · ``shaped``: terms of the simulation whose shape was read off it, and may be another ·
    ``cutoff_hz``: of the filter that what is not recorded of the motion was derived with, and
    ``lowered`` why it is lower than the recording alone asks for ·
    ``blur_s``: time over which a derived velocity is a mean ·
    ``constant``: the constant load that the simulation of a rotary axis has.
    """

    axis: str
    t_s: Array
    position: Array
    velocity: Array
    acceleration: Array
    direction: Array
    sense: Array
    simulation: Array
    effort: Array
    friction: Array
    last_sense: Array
    way: Array
    others: dict[str, Array]
    own: dict[str, Array]
    had: dict[str, float]
    recorded: Array | None = None
    pieces: tuple[slice, ...] = (slice(None),)
    read_share: float = 1.0
    phase_deg: float = 0.0
    like: "AxisSignals | None" = None
    found: Mapping[str, Array] = field(default_factory=dict)
    stated: Mapping[str, Array] = field(default_factory=dict)
    shaped: frozenset[str] = frozenset()
    cutoff_hz: float = float("inf")
    lowered: str = ""
    blur_s: float = 0.0
    constant: float = 0.0

    def own_size(self, name: str) -> float:
        """Return the coefficient of an own column in the simulation, in the effort's unit: that of
        a weight across its phase is as large as the weight.
        """
        parts = {CONSTANT: self.constant, ACROSS: self.had.get("gravity", 1.0)}
        return parts.get(name, self.had.get(name, 1.0))

    @property
    def rotary(self) -> bool:
        """Whether the axis turns."""
        return self.axis in ROTARY_AXES

    @property
    def unit(self) -> str:
        """The unit of its ways."""
        return way_unit(self.axis)

    @cached_property
    def scales(self) -> AxisScales:
        """What grids are measured in: the recording's scales."""
        if self.like is not None:
            return self.like.scales
        return axis_scales(
            self.t_s, self.position, self.velocity, self.last_sense, self.way, blur_s=self.blur_s
        )

    def part(self, term: str) -> Array | float:
        """Return what a term is known to add, (n,): of the simulation, and found."""
        simulated = self.had[term] * self.own[term] if term in self.own else 0.0
        return simulated + self.found.get(term, 0.0)

    @property
    def joined(self) -> frozenset[str]:
        """The terms of what has been found and the simulation does not have."""
        return frozenset(self.found) - self.had.keys()

    @property
    def frame(self) -> "AxisSignals":
        """The signals that scales, middles and knots of shapes are taken from."""
        return self.like or self

    def beside(self, retuned: Array, parts: Sequence[tuple[str, Array]]) -> "AxisSignals":
        """Return the signals with effort and friction as they are with what has been found.

        ``retuned`` (n,): the change of the simulation's own terms; ``parts``: term, or key where it
        has no name, and (n,) each.
        """
        acting, rubs = acting_terms() | {BRAKING}, friction_terms()
        adding = [(term, part) for term, part in parts if term not in acting]
        others = [part for _, part in adding]
        friction = [part for term, part in parts if term in rubs]
        effort = self.simulation + retuned + sum(others, start=np.zeros_like(retuned))
        known = {"coulomb", "viscous"} & self.had.keys()
        rubbing = self.friction if known else np.zeros_like(retuned)
        rubbing = rubbing + sum(friction, start=np.zeros_like(retuned))
        found = dict(self.found)
        for term, part in adding:
            found[term] = found.get(term, 0.0) + part
        rubbing = rubbing if np.any(rubbing) else self.friction
        return replace(self, effort=effort, friction=rubbing, found=found)

    def completed(self, retuned: Array, parts: Sequence[tuple[str, Array]]) -> "AxisSignals":
        """Return the signals of a simulation that holds what has been found, of size 1 each."""
        now = self.beside(retuned, parts)
        acting = [part for term, part in parts if term in acting_terms()]
        return replace(
            now,
            simulation=sum(acting, start=now.effort),
            had=self.had | dict.fromkeys((term for term, _ in parts), 1.0),
        )

    def channel(self, what: str) -> str:
        """Return the name of a channel of this axis; its `position` is an angle where it turns."""
        return place_channel(self.axis) if what == "position" else f"{self.axis}.{what}"


def axis_signals(
    recording: Recording,
    simulation: Array,
    channel: str,
    parts: Mapping[str, Array] = NO_PARTS,
    includes: Collection[str] | None = None,
) -> AxisSignals:
    """Return the signals of a channel's axis, with the terms that its simulation has.

    ``parts``: what of it is known to come from which term. The four of ``READ_OFF``, or those of
    them that ``includes`` names, are read off what the others leave; each other part is a column
    of its own, with the coefficient 1.

    Raises UnusableInput when there is not even a position.
    """
    axis = axis_of(channel)
    cutoff_hz = protocol_of(recording, axis, noise_share=DROWNED).cutoff_hz
    inputs = term_inputs(recording, axis, cutoff_hz=cutoff_hz, own_speeds=True)
    further, shaped, read = _read_terms(
        simulation, inputs, recording, channel, parts=parts, includes=includes
    )
    own_hz, lowered = cutoff_hz, ""
    if read.cutoff_hz < own_hz:
        cutoff_hz, lowered = read.cutoff_hz, AS_SIMULATED
        inputs = term_inputs(recording, axis, cutoff_hz=cutoff_hz, own_speeds=True)
    else:
        cutoff_hz, inputs = _telling_motion(simulation, recording, channel, cutoff_hz, inputs)
        lowered = NO_EFFORT_ABOVE if cutoff_hz < own_hz else ""
    sense = read.sense if "coulomb" in read.had else inputs["direction"]
    own, had = read.columns | further, read.had | dict.fromkeys(further, 1.0)
    rotary = axis in ROTARY_AXES
    stated = own_terms(sense, inputs, rotary=rotary, phase_deg=read.phase_deg)
    last, way = since_reversal(inputs["direction"], inputs["position"])
    return AxisSignals(
        axis=axis,
        t_s=recording.t_s,
        position=inputs["position"],
        velocity=inputs["velocity"],
        acceleration=inputs["acceleration"],
        direction=inputs["direction"],
        sense=sense,
        simulation=simulation,
        effort=simulation,
        friction=simulated_friction(sense, own, had),
        last_sense=last,
        way=way,
        others=_others(recording, axis, cutoff_hz=cutoff_hz),
        own=own,
        had=had,
        recorded=recording[channel],
        pieces=recording.pieces,
        read_share=read.share,
        phase_deg=read.phase_deg,
        constant=read.constant,
        stated={name: stated[name] for name in READ_OFF & set(includes or ())},
        shaped=shaped,
        cutoff_hz=cutoff_hz,
        lowered=lowered,
        blur_s=0.0 if f"{axis}.velocity" in recording else 0.5 / cutoff_hz,
    )


def _telling_motion(
    simulation: Array,
    recording: Recording,
    channel: str,
    cutoff_hz: float,
    inputs: dict[str, Array],
) -> tuple[float, dict[str, Array]]:
    """Return the cutoff to derive motion with, and what the terms take, (n,) each.

    What a filter lets through above the machine's own motion is noise of its encoder, and no force
    follows it: of cutoffs each half the one before, that one is taken with which friction, mass and
    load of the motion below predict the difference clearly better in blocks left out of their fit
    than with each that is higher; an acceleration that drowns in noise gains nothing from the first
    of them. A simulation that was computed with a filtered motion has its cutoff from that.
    """
    difference, axis = recording[channel] - simulation, axis_of(channel)
    given = all(f"{axis}.{name}" in recording for name in ("velocity", "acceleration"))

    def squares(motion: Mapping[str, Array]) -> Array:
        laws = own_terms(motion["direction"], motion, rotary=axis in ROTARY_AXES) | {
            "position": motion["position"] - motion["position"].mean()
        }
        columns = np.column_stack([difference, simulation, *laws.values()])
        every = np.arange(1, columns.shape[1])
        return Folds(columns, 0, blocks=PARTS, folds=PARTS).by_fold(every, np.zeros(len(every)))

    told, lower_hz = squares(inputs), cutoff_hz / 2.0
    least_hz = WAVES * PARTS / float(np.ptp(recording.t_s))
    while len(difference) >= FEWEST_ROWS and lower_hz > least_hz and not given:
        lower = term_inputs(recording, axis, cutoff_hz=lower_hz, own_speeds=True)
        then = squares(lower)
        in_parts = int(np.sum(then < told))
        if then.sum() <= (1.0 - TELLING) ** 2 * told.sum() and in_parts >= IN_PARTS:
            cutoff_hz, inputs, told = lower_hz, lower, then
        lower_hz /= 2.0
    return cutoff_hz, inputs


def _read_terms(
    simulation: Array,
    inputs: Mapping[str, Array],
    recording: Recording,
    channel: str,
    *,
    parts: Mapping[str, Array],
    includes: Collection[str] | None,
) -> tuple[dict[str, Array], frozenset[str], OwnTerms]:
    """Return what further terms add to a simulation (n,), by name, which of them have a shape that
    was read off it, and the terms of ``READ_OFF`` beside them.
    """
    axis = axis_of(channel)
    lacking = frozenset(includes or ()).difference(parts)
    level = OWN_PART * float(np.sqrt(np.mean(simulation**2)))
    further = _beyond_read_off(parts, level)
    known = sum(further.values(), start=np.zeros_like(simulation))
    reading = partial(own_terms_of, simulation, inputs, recording, axis, includes=includes)
    read = reading(known)
    moved = {**inputs, **read.motion}
    included: dict[str, Array] = {}
    for motion in (inputs, moved) if lacking else ():
        included = included or included_parts(simulation, motion, axis_kind(axis), lacking)
    if included:
        further |= _beyond_read_off(included, level)
        known = sum(further.values(), start=np.zeros_like(simulation))
        read = reading(known)
    rippled = READINGS if "cogging" in lacking.difference(included) else 0
    others = own_terms(moved["direction"], moved, rotary=axis in ROTARY_AXES)
    for _ in range(rippled):
        ripples = ripples_over_position(simulation - known, recording[place_channel(axis)], others)
        if ripples is None:
            break
        further["cogging"], read = ripples, reading(known + ripples)
        others = read.columns
    return further, frozenset(included), read


def _beyond_read_off(parts: Mapping[str, Array], level: float) -> dict[str, Array]:
    """Return the parts (n,) of terms that a simulation is not always read off with, by name."""
    return {n: part for n, part in parts.items() if n not in READ_OFF and np.std(part) > level}


def simulated_friction(sense: Array, own: Mapping[str, Array], had: Mapping[str, float]) -> Array:
    """Return the friction that a simulation has, (n,), ``sense`` where it has none."""
    terms = [had[name] * own[name] for name in ("coulomb", "viscous") if name in had]
    friction = sum(terms, start=np.zeros_like(sense))
    return friction if np.any(friction) else sense


def _others(recording: Recording, axis: str, *, cutoff_hz: float) -> dict[str, Array]:
    """Return position or angle, velocity and acceleration of the other axes that move."""
    found: dict[str, Array] = {}
    for other in (*LINEAR_AXES, *ROTARY_AXES):
        place = place_channel(other)
        if other == axis or place not in recording or not np.ptp(recording[place]) > 0:
            continue
        moved = axis_motion(recording, other, cutoff_hz=cutoff_hz, own_speeds=True)
        found |= {
            place: moved.position,
            f"{other}.velocity": moved.velocity,
            f"{other}.acceleration": moved.acceleration,
        }
    return found
