"""What an axis' candidates are built from: its motion, its simulated effort, and the other axes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from autodb.files.channels import axis_of
from autodb.records import Recording
from autodb.sensing.drives.moves.motion import DROWNED, axis_motion, protocol_of, term_inputs
from autodb.terms.friction import since_reversal

Array = NDArray[np.float64]

OWN_SHARE = 0.005
"""A term of which the simulation has less than this share is not in it."""
BLURRED_SHARE = 0.02
"""The same where motion is known within a dead band only. Chosen."""
WIDTHS_MM_S = (0.0, 0.1, 0.3, 1.0, 3.0)
"""Speeds over which a simulation's friction may turn; 0 is the recording's own direction."""
WRITTEN = 1e-12
"""Share of a simulation's sum of squares that six written digits leave: no width leaves less."""
READ_OFF = frozenset({"coulomb", "viscous", "inertia", "gravity"})
"""Terms that a simulation is read off with."""
NO_PARTS: Mapping[str, Array] = MappingProxyType({})
FRICTION = frozenset({"coulomb", "viscous", "stribeck", "position_friction", "asymmetry"})
ACTING = frozenset({"warmup", "gain", "lag", "saturation", "lost_sign"})
"""Effects that change others."""


@dataclass(frozen=True)
class AxisSignals:
    """Signals of one axis at every row, (n,).

    ``direction``: ±1 in motion, fading through standstill · ``sense``: the same as the simulation
    turns it ·
    ``effort``: all that is known to act, the simulation at first · ``friction``: the same of
    friction, ``sense`` where there is none ·
    ``last_sense``, ``way``: last direction, and the way run since it turned [mm] ·
    ``others``: position, velocity and acceleration of further axes by channel ·
    ``own``: columns of the simulation's terms, ``had`` their coefficients; of a term that is not of
    ``READ_OFF`` its part, and 1 ·
    ``pieces``: runs of even rows ·
    ``like``: signals of the recording, where these are of another move.
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
    pieces: tuple[slice, ...] = (slice(None),)
    like: "AxisSignals | None" = None

    @property
    def frame(self) -> "AxisSignals":
        """The signals that scales, middles and knots of shapes are taken from."""
        return self.like or self

    def beside(self, retuned: Array, parts: Sequence[tuple[str, Array]]) -> "AxisSignals":
        """Return the signals with effort and friction as they are with what has been found.

        ``retuned`` (n,): the change of the simulation's own terms; ``parts``: term and (n,) each.
        """
        others = [part for term, part in parts if term not in ACTING]
        friction = [part for term, part in parts if term in FRICTION]
        effort = self.simulation + retuned + sum(others, start=np.zeros_like(retuned))
        known = {"coulomb", "viscous"} & self.had.keys()
        rubbing = self.friction if known else np.zeros_like(retuned)
        rubbing = rubbing + sum(friction, start=np.zeros_like(retuned))
        return replace(self, effort=effort, friction=rubbing if np.any(rubbing) else self.friction)

    def completed(self, retuned: Array, parts: Sequence[tuple[str, Array]]) -> "AxisSignals":
        """Return the signals of a simulation that holds what has been found, of size 1 each."""
        now = self.beside(retuned, parts)
        had = self.had | dict.fromkeys((term for term, _ in parts), 1.0)
        return replace(now, simulation=now.effort + sum(
            (part for term, part in parts if term in ACTING), start=np.zeros_like(retuned)
        ), had=had)

    def channel(self, what: str) -> str:
        """Return the name of a channel of this axis."""
        return f"{self.axis}.{what}"


def axis_signals(
    recording: Recording, simulation: Array, channel: str, parts: Mapping[str, Array] = NO_PARTS
) -> AxisSignals:
    """Return the signals of a channel's axis, with the terms that its simulation has.

    ``parts``: what of it is known to come from which term. The four of ``READ_OFF`` are read off
    what the others leave; each other part is a column of its own, with the coefficient 1.

    Raises UnusableInput when there is not even a position.
    """
    axis = axis_of(channel)
    cutoff_hz = protocol_of(recording, axis, noise_share=DROWNED).cutoff_hz
    inputs = term_inputs(recording, axis, cutoff_hz=cutoff_hz)
    level = OWN_SHARE * float(np.sqrt(np.mean(simulation**2)))
    further = {n: p for n, p in parts.items() if n not in READ_OFF and np.std(p) > level}
    rest = simulation - sum(further.values(), start=np.zeros_like(simulation))
    measured = recording.timing.placed
    sense, had = _read_off(rest, inputs, measured)
    own = {name: column for name, column in own_terms(sense, inputs).items() if name in had}
    own, had = own | further, had | dict.fromkeys(further, 1.0)
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
        pieces=recording.pieces,
    )


def simulated_friction(sense: Array, own: Mapping[str, Array], had: Mapping[str, float]) -> Array:
    """Return the friction that a simulation has, (n,), ``sense`` where it has none."""
    terms = [had[name] * own[name] for name in ("coulomb", "viscous") if name in had]
    friction = sum(terms, start=np.zeros_like(sense))
    return friction if np.any(friction) else sense


def own_terms(sense: Array, inputs: dict[str, Array]) -> dict[str, Array]:
    """Return the columns (n,) that a simulation is read off with, by term."""
    return {
        "coulomb": sense,
        "viscous": inputs["velocity"],
        "inertia": inputs["acceleration"],
        "gravity": np.ones_like(sense),
    }


def _read_off(
    simulation: Array, inputs: dict[str, Array], measured: NDArray[np.bool_] | None
) -> tuple[Array, dict[str, float]]:
    """Return the direction as the simulation turns it, and the coefficients of the terms it has.

    A simulation has no noise, so what its output contains can be read by regression; the width over
    which its friction turns is the one that leaves least. Rows that were not ``measured`` say
    nothing.
    """
    v, stride = inputs["velocity"], max(1, len(simulation) // 200_000)
    rows: slice | NDArray[np.intp] = slice(None, None, stride)
    if measured is not None:
        rows = np.flatnonzero(measured)[::stride]
    rounding = WRITTEN * float(np.sum(simulation[rows] ** 2))
    best: tuple[float, Array, Array] = (np.inf, inputs["direction"], np.zeros(4))
    for width in WIDTHS_MM_S:
        sense = np.asarray(np.tanh(v / width)) if width else inputs["direction"]
        matrix = np.column_stack(list(own_terms(sense, inputs).values()))
        coefficients = np.asarray(
            np.linalg.lstsq(matrix[rows], simulation[rows], rcond=None)[0], dtype=np.float64
        )
        left = float(np.sum((simulation[rows] - matrix[rows] @ coefficients) ** 2))
        if left + rounding < 0.98 * best[0]:
            best = (left, sense, coefficients)
    _, sense, coefficients = best
    share = OWN_SHARE if measured is None else BLURRED_SHARE
    level = share * float(np.sqrt(np.mean(simulation**2)))
    had = {
        name: float(c)
        for (name, column), c in zip(own_terms(sense, inputs).items(), coefficients, strict=True)
        if abs(c) * np.sqrt(np.mean(column**2)) > level
    }
    return sense, had


def _others(recording: Recording, axis: str, *, cutoff_hz: float) -> dict[str, Array]:
    """Return position, velocity and acceleration of the other linear axes that move."""
    found: dict[str, Array] = {}
    for name in recording.channels:
        other, _, what = name.partition(".")
        if what != "position" or other == axis or not np.ptp(recording[name]) > 0:
            continue
        moved = axis_motion(recording, other, cutoff_hz=cutoff_hz)
        found |= {
            f"{other}.position": moved.position,
            f"{other}.velocity": moved.velocity,
            f"{other}.acceleration": moved.acceleration,
        }
    return found
