"""An identified axis: its terms with values, how sure they are, and what they predict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autodb.files.channels import ROTARY_AXES
from autodb.sensing.drives.fit.cogging import TriedCogging
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.fit.drive_errors import DriveErrors
from autodb.sensing.drives.fit.steady import SteadyMotion
from autodb.sensing.drives.moves.motion import SPINDLE
from autodb.sensing.drives.moves.protocol import FilterProtocol
from autodb.terms.channel import ChannelPart, predicted_channel
from autodb.terms.ripple import NODES
from autodb.terms.term import Contribution, TermParameter
from autodb.terms.vocabulary import term_called

Array = NDArray[np.float64]

FIRST = {
    "cosine": (1.0, 0.0),
    "sine": (0.0, 1.0),
    "cosine_1": (1.0, 0.0),
    "sine_1": (0.0, 1.0),
}
"""What parameters add to cosine and sine of a ripple's first harmonic."""
SPINDLE_UNITS = {"U·s/mm": "U/rpm", "U·s²/mm": "U·s/rpm"}


@dataclass(frozen=True)
class IdentifiedTerm:
    """One parameter of one term with its standard deviation, in ``unit``.

    ``form`` and ``of`` tell instances of a term apart, as in ``terms.channel.ChannelPart``. ``sd``
    is 0 for a parameter that was given, and None for one that the moves cannot tell from others:
    its value then only means something in the sum of the terms.
    """

    term: str
    parameter: str
    value: float
    sd: float | None
    unit: str
    form: str = ""
    of: str = ""

    @property
    def key(self) -> str:
        """Name of the term's instance."""
        return " ".join(word for word in (self.term, self.form, self.of) if word)


@dataclass(frozen=True)
class PlainFit:
    """Ordinary least squares of the same columns, as published methods do it.

    The sd are Newey and West's over 0.2 s.
    """

    protocol: FilterProtocol
    terms: tuple[IdentifiedTerm, ...]
    given: tuple[IdentifiedTerm, ...]
    relative_error: float
    residual_rms: float

    def value(self, term: str) -> float:
        """Return the first parameter of ``term``, 0 where it has none."""
        return next((t.value for t in self.terms if t.term == term), 0.0)


@dataclass(frozen=True)
class Identified:
    """A drive model in the effort channel's unit, at one protocol.

    ``terms``: every parameter; ``covariance`` (k, k) is of the first k, which got a number.
    ``relative_error``: rms of effort − terms over rms of effort, at the protocol;
    ``held_out_error``: the same on blocks of motion that the terms were not fitted to (ordinary
    least squares around the shape). ``not_excited``:
    what got no number, with the move that would give it one; ``doubts``: values beyond what physics
    allows; ``errors``: how far off it is by what the axis does (none of a spindle); ``off_law``:
    what friction is off its laws, of a sweep on whose blocks left out it is nearer with that (then
    it is in all errors); ``moved``: what is no longer as an earlier version believed it;
    ``cogging``: the forms tried of it, none where it was not asked for.
    """

    axis: str
    channel: str
    unit: str
    terms: tuple[IdentifiedTerm, ...]
    covariance: Array
    relative_error: float
    held_out_error: float
    residual_rms: float
    protocol: FilterProtocol
    not_excited: tuple[str, ...]
    doubts: tuple[str, ...]
    plain: PlainFit
    steady: SteadyMotion | None
    errors: DriveErrors | None
    off_law: FrictionDiscrepancy | None = None
    moved: tuple["ChangedParameter", ...] = ()
    cogging: tuple[TriedCogging, ...] = ()

    @property
    def fitted(self) -> tuple[IdentifiedTerm, ...]:
        """The parameters that got a number, in the order of ``covariance``."""
        return self.terms[: len(self.covariance)]

    def value(self, term: str) -> float:
        """Return the first number of ``term``, 0 where the moves did not excite it."""
        return next((t.value for t in self.fitted if t.term == term), 0.0)


@dataclass(frozen=True)
class ChangedParameter:
    """A parameter that changed by more than the uncertainty of both versions (95 %)."""

    key: str
    parameter: str
    unit: str
    before: float
    before_sd: float
    now: float
    now_sd: float


@dataclass(frozen=True)
class Posteriors:
    """What an earlier version knows: (key, parameter) of each, mean (k,), covariance (k, k).

    ``others``: values of its parameters that have no covariance: given, or known in the sum only.
    """

    names: tuple[tuple[str, str], ...]
    mean: Array
    covariance: Array
    others: Mapping[tuple[str, str], float] = field(default_factory=dict)

    @property
    def keys(self) -> frozenset[str]:
        """The terms that the version has."""
        return frozenset(key for key, _ in (*self.names, *self.others))

    def of(self, names: Sequence[tuple[str, str]]) -> "Posteriors":
        """Return the posteriors about these parameters, in this order."""
        at = [self.names.index(name) for name in names]
        return Posteriors(tuple(names), self.mean[at], self.covariance[np.ix_(at, at)], self.others)


def terms_with(values: Mapping[str, float], effort_unit: str) -> tuple[IdentifiedTerm, ...]:
    """Return terms of one coefficient each with given values: a published model, say."""
    parameters = {name: term_called(name).coefficients[0] for name in values}
    return tuple(
        IdentifiedTerm(name, p.name, values[name], 0.0, unit_in(p, effort_unit))
        for name, p in parameters.items()
    )


def unit_in(parameter: TermParameter, effort_unit: str, axis: str = "x") -> str:
    """Return the parameter's unit for an effort of this unit; a spindle counts rpm, a table deg."""
    unit = SPINDLE_UNITS.get(parameter.unit, parameter.unit) if axis == SPINDLE else parameter.unit
    if axis in ROTARY_AXES:
        unit = unit.replace("mm", "deg")
    return unit.replace("U", effort_unit)


def amplitudes(model: Identified) -> list[IdentifiedTerm]:
    """Return the amplitude of every periodic term's first harmonic, with its sd (delta method).

    √(cosine² + sine²): what shows in the shop, where the terms themselves are cosine and sine, or
    the nodes of a table, of which these two are sums.
    """
    found = []
    for key in dict.fromkeys(t.key for t in model.fitted):
        here = [(i, t) for i, t in enumerate(model.fitted) if t.key == key]
        weights = {t.parameter: first_harmonic(t.parameter) for _, t in here}
        rows = [(i, t, w) for i, t in here if (w := weights[t.parameter]) is not None]
        if not rows:
            continue
        places, first = [i for i, _, _ in rows], rows[0][1]
        both = np.array([w for _, _, w in rows])
        value = np.array([t.value for _, t, _ in rows]) @ both
        size = float(np.hypot(*value))
        gradient = both @ (value / max(size, 1e-300))
        variance = float(gradient @ model.covariance[np.ix_(places, places)] @ gradient)
        found.append(
            IdentifiedTerm(
                first.term, "amplitude", size, variance**0.5, first.unit, first.form, first.of
            )
        )
    return found


def readable(terms: Sequence[IdentifiedTerm]) -> list[IdentifiedTerm]:
    """Return the terms without the nodes of a table, which no one reads."""
    return [t for t in terms if not t.parameter.startswith("node_")]


def first_harmonic(parameter: str) -> tuple[float, float] | None:
    """Return what a parameter adds to cosine and sine of the first harmonic; None: nothing."""
    name, _, number = parameter.partition("_")
    if name == "node":
        # The last node is minus the sum of the others: value · (e^(iφ_j) − e^(iφ_36)) · 2/36
        angle = 2.0 * np.pi * (np.array([int(number), NODES]) - 1.0) / NODES
        cosine, sine = np.cos(angle), np.sin(angle)
        share = 2.0 / NODES
        return share * float(cosine[0] - cosine[1]), share * float(sine[0] - sine[1])
    return FIRST.get(parameter)


def stored_parts(terms: Sequence[IdentifiedTerm]) -> tuple[tuple[ChannelPart, ...], Array]:
    """Return the parts and linear parameters (p,) that stored terms describe.

    A term without all of its shape parameters is left out; a coefficient that is not there is 0.
    """
    parts: list[ChannelPart] = []
    linear: list[float] = []
    for key in dict.fromkeys(t.key for t in terms):
        rows = {t.parameter: t for t in terms if t.key == key}
        first = next(iter(rows.values()))
        term = term_called(first.term, first.form)
        if any(p.name not in rows for p in term.shape):
            continue
        shape: Mapping[str, float] = {p.name: rows[p.name].value for p in term.shape}
        free = tuple(p.name for p in term.shape if rows[p.name].sd)
        parts.append(ChannelPart(term, shape, free, first.of))
        if isinstance(term, Contribution):
            linear += [rows[p.name].value if p.name in rows else 0.0 for p in term.coefficients]
    return tuple(parts), np.array(linear)


def predicted_effort(
    terms: Sequence[IdentifiedTerm],
    inputs: Mapping[str, Array],
    off_law: FrictionDiscrepancy | None = None,
) -> Array:
    """Return the effort (n,) that stored terms give for inputs, and what friction is off them."""
    parts, linear = stored_parts(terms)
    if not len(linear):
        return np.zeros_like(inputs["position"])
    told = predicted_channel(parts, linear, inputs)
    return told if off_law is None else told + off_law.effort(parts, inputs)
