"""Identify a feed axis from its moves: inertia, viscous, Coulomb, constant load (P0 section 2.2).

Air moves give the drive's own unit: amperes stay amperes. Kilograms and newtons need an effort in
newtons (a torque constant from the data sheet, a known mass, a push against a load cell).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb import fitting, signals
from autodb.channels import axis_of, effort_channels
from autodb.errors import UnusableInput
from autodb.records import Recording
from autodb.terms import TERMS, Term
from autodb.terms.drive import gravity, inertia
from autodb.terms.friction import STANDSTILL_MM_S, coulomb, direction, viscous

Array = NDArray[np.float64]

IDENTIFIED = ("inertia", "viscous", "coulomb", "gravity")
SHORTEST_ROWS = 100
SPREAD_CUTOFFS_HZ = (50.0, 75.0, 100.0, 150.0, 200.0)


@dataclass(frozen=True)
class Protocol:
    """How a recording is filtered before the fit; results are comparable only at one protocol."""

    cutoff_hz: float
    decimate: int
    crop_s: float = 0.5
    anti_alias: bool = True

    def __str__(self) -> str:
        how = "after an anti-alias filter" if self.anti_alias else "without anti-alias filter"
        return (
            f"Butterworth 4th order, {self.cutoff_hz:g} Hz, forwards and backwards; one row in "
            f"{self.decimate} {how}; {self.crop_s:g} s cropped at each end"
        )


@dataclass(frozen=True)
class IdentifiedTerm:
    """One coefficient with its standard deviation, in ``unit``."""

    term: str
    parameter: str
    value: float
    sd: float
    unit: str


@dataclass(frozen=True)
class Identified:
    """A drive model in the effort channel's unit, at one protocol."""

    axis: str
    channel: str
    unit: str
    terms: tuple[IdentifiedTerm, ...]
    covariance: Array
    relative_error: float
    residual_rms: float
    protocol: Protocol
    not_excited: tuple[str, ...]

    def value(self, term: str) -> float:
        """Return the coefficient of ``term``, 0 where the moves did not excite it."""
        return next((t.value for t in self.terms if t.term == term), 0.0)


def default_protocol(rate_hz: float) -> Protocol:
    """Return 100 Hz and 100 samples per second, or less where the recording is slower."""
    return Protocol(cutoff_hz=min(100.0, 0.4 * rate_hz), decimate=max(1, int(rate_hz / 100.0)))


def effort_channel(recording: Recording, axis: str | None) -> str:
    """Return the effort channel of ``axis``, or the only one there is.

    Raises UnusableInput where there is none or the choice is open.
    """
    found = effort_channels(list(recording.channels))
    if axis is not None:
        found = [name for name in found if axis_of(name) == axis]
    if not found:
        gaps = effort_channels(list(recording.unusable))
        if gaps:
            raise UnusableInput(recording.unusable[gaps[0]])
        wanted = f"{axis or 'x'}.current"
        raise UnusableInput(
            f"{recording.path}: no drive effort; a channel '{wanted}' or "
            f"'{axis or 'x'}.drive_force' would work{recording.near(wanted)}"
        )
    if len({axis_of(name) for name in found}) > 1:
        raise UnusableInput(f"{recording.path}: several axes ({', '.join(found)}); give --axis")
    return found[0]


def effort_axis(recording: Recording, axis: str | None) -> str:
    """Return the axis that is identified: ``axis``, or the only one with an effort."""
    return axis_of(effort_channel(recording, axis))


@dataclass(frozen=True)
class Motion:
    """An axis' motion (n,): mm, mm/s, mm/s²; ``quick`` is the velocity that the direction is read
    from, with as little filter as the position's noise allows, so that reversals stay sharp.
    """

    position: Array
    velocity: Array
    acceleration: Array
    quick: Array


def motion(recording: Recording, axis: str, *, cutoff_hz: float) -> Motion:
    """Return the motion of an axis; what is not recorded is derived from position at the cutoff.

    Raises UnusableInput when there is not even a position.
    """
    position = recording[f"{axis}.position"]
    smooth, v, a = signals.derivatives(recording.t_s, position, cutoff_hz=cutoff_hz)
    velocity, acceleration = (
        recording.get(f"{axis}.velocity"),
        recording.get(f"{axis}.acceleration"),
    )
    return Motion(
        position=smooth if velocity is None else position,
        velocity=v if velocity is None else velocity,
        acceleration=a if acceleration is None else acceleration,
        quick=_quick(recording.t_s, position, v) if velocity is None else velocity,
    )


def _quick(t_s: Array, position: Array, filtered: Array) -> Array:
    """Return plain differences of position where their noise stays below standstill, else filtered.

    Third differences hold hardly any motion; white noise σ of the position gives them √20 σ and the
    central difference σ·rate/√2.
    """
    sigma = fitting.spread(np.diff(position, 3)) / np.sqrt(20.0)
    noise = sigma / float(np.median(np.diff(t_s))) / np.sqrt(2.0)
    return np.gradient(position, t_s) if 4.0 * noise < STANDSTILL_MM_S else filtered


def regressors(moved: Motion) -> dict[str, Array]:
    """Return the column (n,) of every identified term."""
    return {
        "inertia": inertia(moved.acceleration),
        "viscous": viscous(moved.velocity),
        "coulomb": coulomb(direction(moved.quick)),
        "gravity": gravity(moved.position),
    }


def identify(
    recording: Recording, *, axis: str | None = None, protocol: Protocol | None = None
) -> Identified:
    """Fit effort = Σ coefficient · column over the four terms by least squares.

    Effort and columns pass the same filters (parallel filtering), so the linear relation holds
    exactly between them. Standard deviations are Newey and West's over 0.2 s.

    Raises UnusableInput without effort or position, or when no term is excited.
    """
    channel = effort_channel(recording, axis)
    axis = axis_of(channel)
    if len(recording) < SHORTEST_ROWS:
        raise UnusableInput(
            f"{recording.path}: {len(recording)} rows are too few to identify an axis; "
            f"{SHORTEST_ROWS} would work"
        )
    protocol = protocol or default_protocol(recording.rate_hz)
    columns, effort = _filtered(recording, channel, axis, protocol)
    names, not_excited = list(IDENTIFIED), []
    rate = recording.rate_hz / protocol.decimate
    if not np.any(effort):
        raise UnusableInput(f"{recording.path}: {channel} is zero in every row")
    while True:
        design = np.column_stack([columns[name] for name in names])
        try:
            fit = fitting.least_squares(design, effort, lags=round(0.2 * rate))
            break
        except fitting.Undetermined as error:
            not_excited += [names[i] for i in error.columns]
            names = [name for name in names if name not in not_excited]
            if not names:
                raise UnusableInput(f"{recording.path}: {axis} does not move enough") from None
    unit = recording.unit(channel)
    rms = float(np.sqrt(np.mean(fit.residual**2)))
    return Identified(
        axis=axis,
        channel=channel,
        unit=unit,
        terms=tuple(
            _named(name, fit.coefficients[i], fit.sd[i], unit) for i, name in enumerate(names)
        ),
        covariance=fit.covariance,
        relative_error=rms / float(np.sqrt(np.mean(effort**2))),
        residual_rms=rms,
        protocol=protocol,
        not_excited=tuple(f"{name}: {_term(name).excited_by}" for name in not_excited),
    )


def _filtered(
    recording: Recording, channel: str, axis: str, protocol: Protocol
) -> tuple[dict[str, Array], Array]:
    columns = regressors(motion(recording, axis, cutoff_hz=protocol.cutoff_hz))
    effort = signals.lowpass(
        recording[channel], rate_hz=recording.rate_hz, cutoff_hz=protocol.cutoff_hz
    )
    stacked = np.column_stack([*columns.values(), effort])
    if protocol.anti_alias:
        stacked = signals.decimate(stacked, protocol.decimate)
    else:
        stacked = stacked[:: protocol.decimate]
    crop = round(protocol.crop_s * recording.rate_hz / protocol.decimate)
    kept = stacked[crop : len(stacked) - crop]
    if len(kept) < 50:
        raise UnusableInput(f"{recording.path}: too short to identify an axis; 2 s would work")
    return {name: kept[:, i] for i, name in enumerate(columns)}, kept[:, -1]


def _term(name: str) -> Term:
    return next(term for term in TERMS if term.name == name)


def _named(name: str, value: float, sd: float, unit: str) -> IdentifiedTerm:
    parameter = _term(name).parameters[0]
    return IdentifiedTerm(
        term=name,
        parameter=parameter.name,
        value=float(value),
        sd=float(sd),
        unit=parameter.unit.replace("U", unit),
    )


def spread_over_filters(recording: Recording, *, axis: str | None = None) -> list[Identified]:
    """Return the identification at 50 to 200 Hz, with and without the anti-alias filter.

    It shows how much of a result is owed to the filter; a recording too slow for 50 Hz has none.
    """
    base = default_protocol(recording.rate_hz)
    return [
        identify(recording, axis=axis, protocol=replace(base, cutoff_hz=hz, anti_alias=anti_alias))
        for anti_alias in (True, False)
        for hz in SPREAD_CUTOFFS_HZ
        if hz < 0.5 * recording.rate_hz
    ]


def predict_effort(recording: Recording, axis: str, coefficients: dict[str, float]) -> Array:
    """Return the effort (n,) that stored coefficients give for a recording's motion."""
    cutoff_hz = default_protocol(recording.rate_hz).cutoff_hz
    columns = regressors(motion(recording, axis, cutoff_hz=cutoff_hz))
    total = np.zeros(len(recording))
    for name, column in columns.items():
        total += coefficients.get(name, 0.0) * column
    return total
