"""The load on an axis from its drive: effort less what moving the axis takes (P0 section 2.2).

load = effort − Σ terms, positive where the motor pushes against it in the positive direction. Two
ways: without delay from the whole recording, or as the disturbance observer that a control can run,
whose filter Q makes the inverse of the inertia proper (P2 figure 1).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.files.channels import place_channel
from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_model import (
    Identified,
    IdentifiedTerm,
    predicted_effort,
)
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.fit.drive_errors import STANDING, TURNED, DriveErrors, states
from autodb.sensing.drives.moves.motion import protocol_of, term_inputs
from autodb.terms.friction import direction
from autodb.terms.term import Contribution, Factor
from autodb.terms.vocabulary import friction_terms, term_called

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

DAMPING = 1.0 / np.sqrt(2.0)
"""Damping of the observer's second-order filter: the flattest (Butterworth)."""
FASTER = 5.0
"""How much faster the observer's velocity is than its load. Chosen."""
AT_LIMIT = 0.98
"""Share of its limit at which an effort is at it."""
FLAT = 1e-6
"""Share by which three rows in a row may differ that a limiter cut off: noise differs by more."""
FRICTION_SHARE = 0.10
"""Relative standard deviation of friction from one run to another: P2's three runs of the same
passes differ by ± 10 %. What one recording of moves cannot show.
"""
BEYOND = 0.05
"""Parts of its range by which an axis must be outside of it to be marked."""


@dataclass(frozen=True)
class DriveModel:
    """What was identified of an axis: terms, covariance (k, k) of the first k, and its errors; of a
    sweep also what friction is off the terms' laws.
    """

    axis: str
    channel: str
    unit: str
    terms: Sequence[IdentifiedTerm]
    covariance: Array
    errors: DriveErrors
    off_law: FrictionDiscrepancy | None = None

    @classmethod
    def of(cls, found: Identified) -> "DriveModel":
        """Return what was identified of an axis; raises ValueError of a spindle, which is none."""
        if found.errors is None:
            raise ValueError(f"{found.axis} has no load")
        return cls(
            axis=found.axis,
            channel=found.channel,
            unit=found.unit,
            terms=found.terms,
            covariance=found.covariance,
            errors=found.errors,
            off_law=found.off_law,
        )


@dataclass(frozen=True)
class DriveLoad:
    """Load and its standard deviation (n,), in ``unit``, up to ``bandwidth_hz``; rows marked.

    ``direction``: of the motion, −1 to 1.
    ``standing``: friction may hold it; ``turned``: shortly after a reversal; ``outside``: where the
    axis was never moved; ``braking``: the drive takes power back; ``at_limit``: the effort is at
    its limit, so that the load may be larger.
    """

    axis: str
    unit: str
    bandwidth_hz: float
    value: Array
    sd: Array
    direction: Array
    standing: Flags
    turned: Flags
    outside: Flags
    braking: Flags
    at_limit: Flags

    def scaled(self, factor: float, unit: str) -> "DriveLoad":
        """Return it in another unit."""
        return replace(self, unit=unit, value=factor * self.value, sd=abs(factor) * self.sd)


def reconstruct(recording: Recording, model: DriveModel, *, bandwidth_hz: float) -> DriveLoad:
    """Return the load of a recording, without delay: filters run forwards and backwards.

    Raises UnusableInput without the model's effort or a position.
    """
    timing = recording.timing
    cutoff_hz = protocol_of(recording, model.axis).cutoff_hz
    inputs = term_inputs(recording, model.axis, cutoff_hz=cutoff_hz)
    effort = recording[model.channel]
    whole = effort - predicted_effort(model.terms, inputs, model.off_law)
    value = signals.lowpass_pieces(whole, timing, cutoff_hz=bandwidth_hz)
    return _load(model, inputs, effort, value, rate_hz=timing.rate_hz, bandwidth_hz=bandwidth_hz)


def observe(recording: Recording, model: DriveModel, *, bandwidth_hz: float) -> DriveLoad:
    """Return the load as a disturbance observer gives it: nothing of what comes later is used.

    With Q(s) = ω²/(s² + 2 d ω s + ω²) effort and friction are filtered by Q, inertia is s²Q of the
    position: all of one delay, and proper. Friction is that of the velocity through a Q that is
    FASTER, so that it turns when the axis does. Raises UnusableInput as ``reconstruct`` does.
    """
    timing = recording.timing
    rate_hz = timing.rate_hz
    effort, position = recording[model.channel], recording[place_channel(model.axis)]

    def through(values: Array, power: int, hz: float) -> Array:
        def observed(own: Array) -> Array:
            return _observed(own, power=power, bandwidth_hz=hz, rate_hz=rate_hz)

        return signals.by_piece(observed, values, timing.pieces)

    cutoff_hz = protocol_of(recording, model.axis).cutoff_hz
    inputs = term_inputs(recording, model.axis, cutoff_hz=cutoff_hz)
    velocity = through(position, 1, min(FASTER * bandwidth_hz, 0.25 * rate_hz))
    inputs |= {
        "position": position,
        "velocity": velocity,
        "direction": direction(velocity),
        "acceleration": through(position, 2, bandwidth_hz),
    }
    for other in (name.split(".")[0] for name in inputs if name.endswith(".acceleration")):
        place = recording[f"{other}.position"]
        inputs[f"{other}.acceleration"] = through(place, 2, bandwidth_hz)
    heavy = [t for t in model.terms if _accelerates(t) or _modifies(t)]
    others = [t for t in model.terms if not _accelerates(t)]
    value = through(effort - predicted_effort(others, inputs, model.off_law), 0, bandwidth_hz)
    value -= predicted_effort(heavy, inputs)
    return _load(model, inputs, effort, value, rate_hz=rate_hz, bandwidth_hz=bandwidth_hz)


def _modifies(one: IdentifiedTerm) -> bool:
    return not isinstance(term_called(one.term, one.form), Contribution)


def _accelerates(one: IdentifiedTerm) -> bool:
    """Say whether a term adds in proportion to an acceleration, which is filtered already."""
    term = term_called(one.term, one.form)
    return isinstance(term, Contribution) and any("acceleration" in name for name in term.inputs)


def _rubs(one: IdentifiedTerm) -> bool:
    """Say whether a term is friction or a factor on it: these differ from run to run."""
    term = term_called(one.term, one.form)
    acts = isinstance(term, Factor) and not friction_terms().isdisjoint(term.modifies)
    return term.friction or acts


def _observed(values: Array, *, power: int, bandwidth_hz: float, rate_hz: float) -> Array:
    """Return s^power Q of values (n,), Tustin's rule, at rest before the first row."""
    from scipy import signal

    omega = 2.0 * np.pi * bandwidth_hz
    top = np.zeros(3)
    top[2 - power] = omega**2
    b, a = signal.bilinear(top, [1.0, 2.0 * DAMPING * omega, omega**2], fs=rate_hz)
    at_rest = signal.lfilter_zi(b, a) * values[0]
    return np.asarray(signal.lfilter(b, a, values, zi=at_rest)[0], dtype=np.float64)


def _load(
    model: DriveModel,
    inputs: Mapping[str, Array],
    effort: Array,
    value: Array,
    *,
    rate_hz: float,
    bandwidth_hz: float,
) -> DriveLoad:
    labels = states(inputs, highest_mm_s2=model.errors.highest_mm_s2)
    own = model.errors.sd(inputs, rate_hz=rate_hz, bandwidth_hz=bandwidth_hz)
    changed = FRICTION_SHARE * predicted_effort([t for t in model.terms if _rubs(t)], inputs)
    sd = np.sqrt(own**2 + parameter_sd(model, inputs) ** 2 + changed**2)
    beyond = model.errors.beyond(inputs)
    return DriveLoad(
        axis=model.axis,
        unit=model.unit,
        bandwidth_hz=bandwidth_hz,
        value=value,
        sd=sd * (1.0 + beyond),
        direction=inputs["direction"],
        standing=labels == STANDING,
        turned=labels == TURNED,
        outside=beyond > BEYOND,
        braking=effort * inputs["velocity"] < 0.0,
        at_limit=rows_at_limit(effort),
    )


def parameter_sd(model: DriveModel, inputs: Mapping[str, Array]) -> Array:
    """Return what the parameters' covariance leaves open of the terms' sum, (n,)."""
    columns = term_slopes(model.terms, model.covariance, inputs)
    variance = np.einsum("ni,ij,nj->n", columns, model.covariance, columns)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def term_slopes(
    terms: Sequence[IdentifiedTerm], covariance: Array, inputs: Mapping[str, Array]
) -> Array:
    """Return the derivatives (n, k) of the terms' sum by the first k, whose covariance is given."""
    found = []
    for i, term in enumerate(terms[: len(covariance)]):
        step = 1e-4 * float(np.sqrt(covariance[i, i])) or 1e-12
        sides = [
            predicted_effort(
                [*terms[:i], replace(term, value=term.value + h), *terms[i + 1 :]], inputs
            )
            for h in (step, -step)
        ]
        found.append((sides[0] - sides[1]) / (2.0 * step))
    return np.array(found).T


def rows_at_limit(effort: Array) -> Flags:
    """Return the rows (n,) in which an effort sits at its largest magnitude: three at least."""
    size = np.abs(effort)
    top = size >= AT_LIMIT * float(size.max())
    flat = size >= (1.0 - FLAT) * float(size.max())
    held = flat[:-2] & flat[1:-1] & flat[2:]
    return top if held.any() else np.zeros(len(effort), dtype=np.bool_)
